//! The pixels of a tile, from which the paths of an iteration start.

use std::collections::HashSet;

use glam::Vec2;

use super::CancelToken;
use super::sink::{PixelPlace, PixelSink};
use crate::film::{TILE_PIXELS, TileBounds};
use crate::sampling::{Sampler, TileNumbers};

/// One path's place on the film.
#[derive(Clone, Copy, Debug)]
pub struct PixelSample {
    /// Its position on the raster, drawn uniformly from the pixel.
    pub raster: Vec2,
    /// `y * width + x` of the pixel.
    pub index: usize,
}

/// A path that starts from a pixel.
#[derive(Clone, Debug)]
pub struct PixelPath<'t> {
    /// Its place on the film.
    pub sample: PixelSample,
    /// Its random numbers, the first two of which said where in the pixel it starts.
    pub sampler: Sampler<'t>,
    /// Where its contributions go.
    pub place: PixelPlace,
    /// What it may split into.
    pub splits: Splits<'t>,
}

impl PixelPath<'_> {
    /// The number of its pixel among those that are handed over at once.
    #[inline]
    #[must_use]
    pub fn number(&self) -> usize {
        self.place.in_tile()
    }
}

/// The random numbers of the paths that a path may split into: they have its numbers up to its
/// first scattering event, and from there on are spread as evenly, all together, as the numbers of
/// paths of their own.
#[derive(Clone, Copy, Debug)]
pub struct Splits<'t> {
    numbers: &'t [TileNumbers],
    place: PixelPlace,
    index: usize,
}

impl<'t> Splits<'t> {
    /// Those of one of the paths that it splits into, below the `n_splits` of the integrator.
    #[inline]
    #[must_use]
    pub fn sampler(&self, split: usize) -> Sampler<'t> {
        self.numbers[split].of_pixel(self.place.x(), self.place.y(), self.index)
    }
}

/// The paths of the pixels of a tile, row by row; all over again where each pixel has several.
#[derive(Debug)]
pub struct Pixels<'t> {
    /// `numbers[sample * n_splits + split]`
    numbers: &'t [TileNumbers],
    n_splits: usize,
    bounds: TileBounds,
    width: usize,
    cancel: &'t CancelToken,
    /// Columns and rows of those that count, if not all do.
    only: Option<&'t HashSet<[u32; 2]>>,
    /// The next one.
    sample: usize,
    x: usize,
    y: usize,
}

impl<'t> Pixels<'t> {
    /// All of a tile of an image of `width` pixels, with the numbers of all samples of each, and of
    /// as many paths as each may split into.
    pub(super) fn new(
        (numbers, n_splits): (&'t [TileNumbers], usize),
        bounds: TileBounds,
        width: usize,
        cancel: &'t CancelToken,
    ) -> Self {
        let [x, y] = bounds.start;
        Self {
            numbers,
            n_splits,
            bounds,
            width,
            cancel,
            only: None,
            sample: 0,
            x,
            y,
        }
    }

    /// Passes by all pixels but some (columns and rows).
    pub(super) fn only(self, only: Option<&'t HashSet<[u32; 2]>>) -> Self {
        Self { only, ..self }
    }

    /// The most pixels that are handed over at once.
    pub const MOST: usize = TILE_PIXELS;

    /// Number among those that are handed over, and `y * width + x` in the image, of every pixel,
    /// once.
    pub fn indices(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (TileBounds { start, end }, width) = (self.bounds, self.width);
        (start[1]..end[1]).flat_map(move |y| {
            let number = move |x| (PixelPlace::new(x, y).in_tile(), y * width + x);
            (start[0]..end[0]).map(number)
        })
    }

    /// Runs `path` for each, one after the other.
    #[inline]
    pub fn one_by_one(
        self,
        sink: &mut PixelSink<'_>,
        mut path: impl FnMut(PixelSample, &Sampler<'_>, &mut PixelSink<'_>),
    ) {
        for next in self {
            sink.start_pixel(next.place);
            path(next.sample, &next.sampler, sink);
        }
    }
}

/// Ends after the last path, or when the iteration is cancelled.
impl<'t> Iterator for Pixels<'t> {
    type Item = PixelPath<'t>;

    #[inline(always)]
    fn next(&mut self) -> Option<PixelPath<'t>> {
        loop {
            let path = self.next_of_all()?;
            let place = [path.place.x() as u32, path.place.y() as u32];
            if self.only.is_none_or(|only| only.contains(&place)) {
                return Some(path);
            }
        }
    }
}

impl<'t> Pixels<'t> {
    #[inline(always)]
    fn next_of_all(&mut self) -> Option<PixelPath<'t>> {
        let first = self.sample * self.n_splits;
        let numbers = self.numbers.get(first..first + self.n_splits)?;
        let (x, y) = (self.x, self.y);
        if x == self.bounds.start[0] && self.cancel.is_cancelled() {
            return None;
        }
        self.x += 1;
        if self.x == self.bounds.end[0] {
            self.x = self.bounds.start[0];
            self.y += 1;
            if self.y == self.bounds.end[1] {
                self.y = self.bounds.start[1];
                self.sample += 1;
            }
        }
        let index = y * self.width + x;
        let sampler = numbers[0].of_pixel(x, y, index);
        let u = sampler.start().film;
        let raster = Vec2::new(x as f32 + u[0], y as f32 + u[1]);
        let place = PixelPlace::new(x, y);
        Some(PixelPath {
            sample: PixelSample { raster, index },
            sampler,
            place,
            splits: Splits {
                numbers,
                place,
                index,
            },
        })
    }
}
