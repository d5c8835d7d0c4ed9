//! The mean of the frames, with the variance of L.

mod reading;

use std::sync::Arc;

use rayon::prelude::*;

use super::Frame;
use super::batch_means::BatchMeans;
use super::frame::{LitLayers, TILE_PIXELS, TileGrid};
use super::layer_spread::LayerSpread;
use super::means::Means;
use super::tile::{FilmTile, NextFilm};
use crate::radiometry::Rgb;

/// The mean of all iterations so far, layer by layer.
///
/// Means are kept as running means, `m += (x - m) / n`, and the sum of squared deviations of L by
/// Welford's recurrence (Knuth, TAOCP 2, 4.2.2). In single precision a step is lost in rounding
/// where `n` is large, so every 8192 iterations the running mean begins anew, and what
/// it was goes into the mean of the older iterations: the error stays at a few millionths.
#[derive(Clone, Debug)]
pub struct Film {
    width: usize,
    height: usize,
    n_layers: usize,
    /// The last iterations.
    recent: Means,
    /// Those before them.
    older: Option<Arc<Means>>,
    /// How the spread of the iterations becomes the variance of their mean.
    batch_means: BatchMeans,
    /// How each layer spreads.
    layer_spread: LayerSpread,
    n_refused: u64,
}

/// Iterations of a running mean.
const MOST_RECENT: u32 = 8192;

/// What a film knows beside the means, which a file needs to go on with the same bits.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Sums of squared deviations of L from its mean, `[y * width + x]`.
    pub deviations: Vec<Rgb>,
    /// The means of batches of iterations, encoded.
    pub batch_means: Vec<u8>,
}

/// Two films, or a film and its parts, do not fit each other.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FilmError {
    /// Sizes or numbers of layers differ.
    #[error("films of different shape: {0} and {1}; render both with the same --size and --layers")]
    Shape(String, String),
    /// The sums of squares or the means of batches cannot be those of the film.
    #[error("the spread of its iterations cannot be that of the film")]
    Spread,
}

impl Film {
    /// An empty film with `n_layers` bounce layers and a tail.
    #[must_use]
    pub fn new(width: usize, height: usize, n_layers: usize) -> Self {
        let n_tiles = TileGrid::new(width, height).n_tiles();
        Self {
            width,
            height,
            n_layers,
            recent: Means::new(n_tiles, (n_layers + 3) * TILE_PIXELS),
            older: None,
            batch_means: BatchMeans::new(n_tiles),
            layer_spread: LayerSpread::new(n_tiles, n_layers + 1),
            n_refused: 0,
        }
    }

    /// A film put together again from what [`Self::layers`], [`Self::total`] and
    /// [`Self::variance_of_mean`] gave, for instance from a file; [`Self::set_spread`] gives it
    /// the rest.
    ///
    /// # Errors
    /// If a plane has another size than `width × height`.
    pub fn from_parts(
        (width, height): (usize, usize),
        n_iterations: u32,
        layers: Vec<Vec<Rgb>>,
        total: Vec<Rgb>,
        variance_of_mean: &[Rgb],
        n_refused: u64,
    ) -> Result<Self, FilmError> {
        let n = width * height;
        let fits = !layers.is_empty()
            && layers.iter().all(|layer| layer.len() == n)
            && total.len() == n
            && variance_of_mean.len() == n;
        if !fits {
            return Err(FilmError::Shape(
                format!("{width}x{height}"),
                "its planes".to_owned(),
            ));
        }
        let scale = n_iterations as f32 * (n_iterations as f32 - 1.0).max(0.0);
        let deviations: Vec<Rgb> = variance_of_mean.iter().map(|v| *v * scale).collect();
        let mut film = Self::new(width, height, layers.len() - 1);
        film.n_refused = n_refused;
        let planes = layers.iter().chain([&total, &deviations]);
        for (number, plane) in planes.enumerate() {
            film.set_plane(number, plane);
        }
        film.recent.lit.fill(LitLayers::ALL);
        film.recent.n = n_iterations;
        Ok(film)
    }

    /// Gives a film of [`Self::from_parts`] what [`Self::spread`] was.
    ///
    /// # Errors
    /// If it cannot be that of this film.
    pub fn set_spread(&mut self, spread: &Spread) -> Result<(), FilmError> {
        let batch_means = BatchMeans::from_bytes(self.grid().n_tiles(), &spread.batch_means)
            .filter(|means| means.n_iterations() <= self.n_iterations().into())
            .ok_or(FilmError::Spread)?;
        let is_possible = spread.deviations.iter().all(|d| d.is_radiance());
        if spread.deviations.len() != self.n_pixels() || !is_possible {
            return Err(FilmError::Spread);
        }
        self.batch_means = batch_means;
        self.set_plane(self.n_layers + 2, &spread.deviations);
        Ok(())
    }

    fn set_plane(&mut self, number: usize, plane: &[Rgb]) {
        for (pixel, value) in plane.iter().enumerate() {
            let index = self.index(number, pixel);
            self.recent.values[index] = *value;
        }
    }

    /// Pixels per row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Number of bounce layers, the tail not counted.
    #[must_use]
    pub fn n_layers(&self) -> usize {
        self.n_layers
    }

    /// Number of iterations that it is the mean of.
    #[must_use]
    pub fn n_iterations(&self) -> u32 {
        self.recent.n + self.older.as_ref().map_or(0, |older| older.n)
    }

    /// Contributions refused because they were not finite or negative, over all iterations.
    #[must_use]
    pub fn n_refused(&self) -> u64 {
        self.n_refused
    }

    /// Number of pixels.
    #[must_use]
    pub fn n_pixels(&self) -> usize {
        self.width * self.height
    }

    /// Takes in one more iteration.
    ///
    /// # Panics
    /// If the frame has another shape.
    pub fn add(&mut self, frame: &Frame) {
        assert_eq!(
            (frame.width(), frame.height(), frame.n_layers()),
            (self.width, self.height, self.n_layers),
            "frame and film differ in shape"
        );
        self.n_refused += frame.n_refused();
        let begins_anew = self.begins_anew();
        if begins_anew {
            self.older = Some(Arc::new(self.whole()));
            self.recent.n = 0;
        }
        self.recent.n += 1;
        let step = 1.0 / self.recent.n as f32;
        let mut watched = self.room();
        let (per_tile, n_watched) = (self.values_per_tile(), self.n_watched());
        self.recent
            .values
            .par_chunks_exact_mut(per_tile)
            .zip(&mut self.recent.lit)
            .zip(watched.par_chunks_exact_mut(n_watched))
            .enumerate()
            .with_min_len(TILES_PER_TASK)
            .for_each(|(number, ((after, lit), watched))| {
                let tile = FilmTile {
                    before: None,
                    lit_before: if begins_anew {
                        LitLayers::default()
                    } else {
                        *lit
                    },
                    after,
                    lit,
                    watched,
                    step,
                };
                tile.take(frame.tile(number), frame.lit(number));
            });
        self.take_watched(frame.iteration, &watched);
    }

    /// Room for what is watched of an iteration, black.
    fn room(&self) -> Vec<Rgb> {
        vec![Rgb::BLACK; self.grid().n_tiles() * self.n_watched()]
    }

    /// Takes in what was watched of an iteration.
    fn take_watched(&mut self, iteration: u32, watched: &[Rgb]) {
        let per_tile = self.batch_means.per_tile();
        let n_watched = self.n_watched();
        // L comes first, then each layer.
        let values = |plane: usize| {
            let tiles = watched.chunks_exact(n_watched);
            let of_plane = tiles.flat_map(|tile| &tile[plane * per_tile..][..per_tile]);
            of_plane.copied().collect::<Vec<Rgb>>()
        };
        self.layer_spread.push(iteration, |layer| values(layer + 1));
        self.batch_means.push(iteration, values(0));
    }

    /// True if the running mean starts again with the next iteration.
    fn begins_anew(&self) -> bool {
        self.recent.n >= MOST_RECENT
    }

    /// The means of all iterations.
    fn whole(&self) -> Means {
        match &self.older {
            Some(older) => older.join(&self.recent),
            None => self.recent.clone(),
        }
    }

    /// A film of the same shape without an iteration.
    pub(crate) fn black(&self) -> Self {
        Self::new(self.width, self.height, self.n_layers)
    }

    /// Becomes `before` with the iteration of this number, which `run` hands over, each tile once,
    /// and then says how much it refused; of what the film was itself nothing stays.
    ///
    /// # Errors
    /// Those of `run`; the film is worth nothing then but to be written again.
    ///
    /// # Panics
    /// If the shapes differ.
    pub(crate) fn follow<E>(
        &mut self,
        before: &Self,
        iteration: u32,
        run: impl FnOnce(NextFilm<'_>) -> Result<u64, E>,
    ) -> Result<(), E> {
        assert_eq!(self.shape(), before.shape(), "films differ in shape");
        let begins_anew = before.begins_anew();
        (self.older, self.recent.n) = if begins_anew {
            (Some(Arc::new(before.whole())), 1)
        } else {
            (before.older.clone(), before.recent.n + 1)
        };
        let mut watched = before.room();
        let next = NextFilm {
            before,
            begins_anew,
            values: &mut self.recent.values,
            lit: &mut self.recent.lit,
            watched: &mut watched,
            next: 0,
            step: 1.0 / self.recent.n as f32,
        };
        self.n_refused = before.n_refused + run(next)?;
        self.batch_means = before.batch_means.clone();
        self.layer_spread = before.layer_spread.clone();
        self.take_watched(iteration, &watched);
        Ok(())
    }

    /// Takes in the iterations of another film of the same shape.
    ///
    /// # Errors
    /// If the shapes differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        if self.shape() != other.shape() {
            return Err(FilmError::Shape(
                self.shape_in_words(),
                other.shape_in_words(),
            ));
        }
        self.recent = self.whole().join(&other.whole());
        self.older = None;
        self.batch_means.absorb(&other.batch_means);
        self.layer_spread.absorb(&other.layer_spread);
        self.n_refused += other.n_refused;
        Ok(())
    }

    /// Values of a tile, all layers together with the total and the deviations.
    pub(super) fn values_per_tile(&self) -> usize {
        (self.n_layers + 3) * TILE_PIXELS
    }

    /// A tile of the recent iterations: its layers, tail last, its total and its deviations.
    pub(super) fn tile(&self, tile: usize) -> &[Rgb] {
        let n = self.values_per_tile();
        &self.recent.values[tile * n..(tile + 1) * n]
    }

    /// What of a tile of the recent iterations is not black.
    pub(super) fn lit(&self, tile: usize) -> LitLayers {
        self.recent.lit[tile]
    }

    /// Values of a tile that are watched: L and each layer, at some of its pixels.
    pub(super) fn n_watched(&self) -> usize {
        self.batch_means.per_tile() * (self.n_layers + 2)
    }

    /// Where the value of a layer, the total or the deviations is at a pixel.
    fn index(&self, plane: usize, pixel: usize) -> usize {
        assert!(pixel < self.n_pixels(), "a pixel of the film");
        let slot = self
            .grid()
            .slot(plane, pixel % self.width, pixel / self.width);
        slot.tile as usize * self.values_per_tile() + slot.in_tile as usize
    }

    fn grid(&self) -> TileGrid {
        TileGrid::new(self.width, self.height)
    }

    fn shape(&self) -> (usize, usize, usize) {
        (self.width, self.height, self.n_layers)
    }

    fn shape_in_words(&self) -> String {
        format!(
            "{}x{} with {} layers",
            self.width, self.height, self.n_layers
        )
    }
}

/// Tiles that one task takes in, at least.
const TILES_PER_TASK: usize = 16;

#[cfg(test)]
mod tests {
    use super::{Film, Frame, NextFilm, TILE_PIXELS};
    use crate::film::{TILE, View, add_to_tile};
    use crate::radiometry::Rgb;

    fn frame_of(value: f32) -> Frame {
        let mut frame = Frame::new(3, 2, 2);
        let layers = frame.values().chunks_exact_mut(TILE_PIXELS);
        for (layer, factor) in layers.zip([1.0, 0.0, 2.0]) {
            layer.fill(Rgb::splat(factor * value));
        }
        frame
    }

    #[test]
    fn layers_add_up_and_variance_is_that_of_the_mean() {
        let mut film = Film::new(3, 2, 2);
        for value in [1.0, 2.0, 3.0, 6.0] {
            film.add(&frame_of(value));
        }
        assert!((film.radiance(View::Total, 0).r - 9.0).abs() < 1e-6);
        assert!((film.radiance(View::Tail, 5).r - 6.0).abs() < 1e-6);
        // L was 3, 6, 9, 18: sample variance 42, over n = 4.
        assert!((film.variance_of_mean(3).g - 10.5).abs() < 1e-5);
    }

    #[test]
    fn an_error_is_unknown_until_there_is_evidence() {
        let film = |n_iterations, mean, variance| {
            let mean = vec![Rgb::splat(mean); 6];
            let layers = vec![mean.clone(), vec![Rgb::BLACK; 6]];
            let variance = [Rgb::splat(variance); 6];
            Film::from_parts((3, 2), n_iterations, layers, mean, &variance, 0).unwrap()
        };
        let known = film(3, 2.0, 4.0).estimated_error().unwrap();
        assert!((known - 1.0).abs() < 1e-6, "{known}");
        let (black, single) = (film(3, 0.0, 0.0), film(1, 2.0, 0.0));
        assert_eq!(black.estimated_error(), None, "no light yet");
        assert_eq!(single.estimated_error(), None, "one has no spread");
        assert_eq!(Film::new(3, 2, 2).estimated_error(), None);
    }

    /// Sets the pixels of a layer of 3×2.
    fn fill_inside(layer: &mut [Rgb], value: f32) {
        for row in layer.chunks_exact_mut(TILE).take(2) {
            row[..3].fill(Rgb::splat(value));
        }
    }

    #[test]
    fn a_layer_by_itself_has_its_own_error() {
        let (mut film, mut other) = (Film::new(3, 2, 2), Film::new(3, 2, 2));
        for (i, value) in [1.0, 2.5, 0.25, 6.0, 3.0, 1.5].into_iter().enumerate() {
            let mut frame = Frame::new(3, 2, 2);
            frame.iteration = i as u32;
            let layers = frame.values().chunks_exact_mut(TILE_PIXELS);
            // All light in the tail.
            for (layer, factor) in layers.zip([0.0, 0.0, 1.0]) {
                fill_inside(layer, factor * value);
            }
            film.add(&frame);
            if i >= 4 {
                other.add(&frame);
            }
        }
        let [of_first, of_second, of_tail] = film.layer_errors()[..] else {
            panic!("three layers");
        };
        assert_eq!([of_first, of_second], [None; 2], "no light came there");
        let (tail, whole) = (of_tail.unwrap(), film.estimated_error().unwrap());
        assert!((tail / whole - 1.0).abs() < 1e-5, "{tail} {whole}");
        // What is merged knows as much.
        let mut first = Film::new(3, 2, 2);
        for (i, value) in [1.0, 2.5, 0.25, 6.0].into_iter().enumerate() {
            let mut frame = frame_of(0.0);
            frame.iteration = i as u32;
            let layers = frame.values().chunks_exact_mut(TILE_PIXELS);
            fill_inside(layers.last().unwrap(), value);
            first.add(&frame);
        }
        first.merge(&other).unwrap();
        let merged = first.layer_errors()[2].unwrap();
        assert!((merged / tail - 1.0).abs() < 1e-5, "{merged} {tail}");
        // A film from a file does not know.
        let layers = film.layers();
        let variance = [Rgb::WHITE; 6];
        let read = Film::from_parts((3, 2), 6, layers, film.total(), &variance, 0).unwrap();
        assert_eq!(read.layer_errors(), [None; 3]);
    }

    #[test]
    fn merging_equals_adding() {
        let (mut whole, mut first, mut second) =
            (Film::new(3, 2, 2), Film::new(3, 2, 2), Film::new(3, 2, 2));
        for (i, value) in [1.0, 2.5, 0.25, 6.0, 3.0].into_iter().enumerate() {
            whole.add(&frame_of(value));
            if i < 2 { &mut first } else { &mut second }.add(&frame_of(value));
        }
        first.merge(&second).unwrap();
        assert_eq!(first.n_iterations(), 5);
        assert!((first.total()[0].r - whole.total()[0].r).abs() < 1e-6);
        let (a, b) = (first.variance_of_mean(0).r, whole.variance_of_mean(0).r);
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }

    /// A frame with something in some layers of some tiles.
    fn sparse_frame(seed: usize) -> Frame {
        let mut frame = Frame::new(40, 20, 3);
        let per_tile = frame.values_per_tile();
        let (values, lit) = frame.tiles();
        for (tile, (values, lit)) in values.chunks_exact_mut(per_tile).zip(lit).enumerate() {
            // What is not lit means nothing.
            values.fill(Rgb::splat(7.0));
            for layer in (0..4).filter(|layer| (tile + layer * seed).is_multiple_of(3)) {
                // The first pixel of each tile is in the image.
                let value = Rgb::splat(1.0 + (seed * tile + layer) as f32 * 0.3);
                add_to_tile(values, lit, layer * TILE_PIXELS, value);
            }
        }
        frame
    }

    fn hand_over(mut next: NextFilm<'_>, frame: &Frame, n_tiles: usize) {
        for (number, tile) in next.tiles(0..n_tiles).enumerate() {
            tile.take(frame.tile(number), frame.lit(number));
        }
    }

    #[test]
    fn a_film_that_follows_another_is_that_with_one_more_frame() {
        let n_tiles = 6;
        let mut added = Film::new(40, 20, 3);
        let (mut film, mut spare) = (added.black(), added.black());
        for seed in [1, 2, 0, 5, 4, 1] {
            // First it is cut short, and leaves something where there should be nothing.
            let outcome = spare.follow(&film, added.n_iterations(), |next| {
                hand_over(next, &sparse_frame(0), n_tiles / 2);
                Err("cut short")
            });
            assert_eq!(outcome, Err("cut short"));
            let mut frame = sparse_frame(seed);
            frame.iteration = added.n_iterations();
            let outcome = spare.follow(&film, added.n_iterations(), |next| {
                hand_over(next, &frame, n_tiles);
                Ok::<_, ()>(0)
            });
            assert_eq!(outcome, Ok(()));
            std::mem::swap(&mut film, &mut spare);
            added.add(&frame);
            assert_eq!(film.n_iterations(), added.n_iterations());
            assert_eq!(film.layers(), added.layers(), "{seed}");
            assert_eq!(film.total(), added.total(), "{seed}");
            for pixel in 0..film.n_pixels() {
                assert_eq!(film.variance_of_mean(pixel), added.variance_of_mean(pixel));
            }
        }
        assert!(film.total()[0].g > 0.0 && film.total()[1].g == 0.0);
    }

    #[test]
    #[should_panic(expected = "each tile once")]
    fn no_tile_is_handed_out_twice() {
        let (film, mut spare) = (Film::new(40, 20, 3), Film::new(40, 20, 3));
        let _ = spare.follow(&film, 0, |mut next| {
            drop(next.tiles(0..3));
            drop(next.tiles(0..3));
            Ok::<_, ()>(0)
        });
    }

    /// Light that comes seldom: almost every step of the mean is a small one downwards.
    #[test]
    fn means_stay_exact_over_many_iterations() {
        const LAYERS: usize = 3;
        let mut film = Film::new(1, 1, LAYERS);
        let mut frame = Frame::new(1, 1, LAYERS);
        let mut exact = [0f64; LAYERS];
        let mut state = 1u32;
        let n = 1_000_000;
        for i in 0..n {
            frame.iteration = i;
            let values = frame.values().chunks_exact_mut(TILE_PIXELS);
            for (k, (value, exact)) in values.zip(&mut exact).enumerate() {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                // In one of 1, 100 and 10 000 iterations.
                let is_there = (state >> 8).is_multiple_of(100u32.pow(k as u32));
                let x = f32::from(u8::from(is_there)) * (0.1 + (state >> 8) as f32 * 1e-7);
                value[0] = Rgb::splat(x);
                *exact += f64::from(x);
            }
            film.add(&frame);
        }
        for (k, exact) in exact.into_iter().enumerate() {
            let relative = f64::from(film.layer_at(k, 0).r) / (exact / f64::from(n)) - 1.0;
            assert!(
                relative.abs() < 5e-6,
                "1 in {}: {relative}",
                100u32.pow(k as u32)
            );
        }
    }
}
