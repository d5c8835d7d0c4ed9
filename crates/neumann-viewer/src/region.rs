//! A region: the part of the picture that is rendered alone, and the whole picture around it.
//!
//! The film of a region has its pixels only. The film of the whole picture is kept as it was when
//! the region began, and stands around it.

use std::borrow::Cow;

use egui::{Rect, lerp, pos2};
use neumann_core::film::{Film, View as Part};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{Job, Stats, Thumbnail};
use neumann_core::scene::description::{CameraDescription, Crop};

use crate::display::image_area::Placement;
use crate::display::mean_of;

/// Fewest columns and rows of a region, pixels.
const SMALLEST: usize = 4;

/// A rectangle that is being drawn on the picture: two opposite corners, shares of width and
/// height; none before the pointer is pressed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drawing {
    /// Where the pointer was pressed, and where it is.
    pub corners: Option<[[f32; 2]; 2]>,
}

impl Drawing {
    /// The pixels that it covers of a picture of `size` pixels; `None` where it has hardly any.
    #[must_use]
    pub fn region(&self, size: (usize, usize)) -> Option<Crop> {
        let [a, b] = self.corners?;
        let of = [size.0, size.1];
        let ends = [0, 1].map(|i| {
            let edge = |share: f32| (share.clamp(0.0, 1.0) * of[i] as f32).round() as usize;
            [edge(a[i].min(b[i])), edge(a[i].max(b[i]))]
        });
        let size = ends.map(|[first, end]| end - first);
        let is_large = size.iter().all(|side| *side >= SMALLEST);
        is_large.then_some(Crop {
            of,
            at: ends.map(|[first, _]| first),
            size,
        })
    }
}

/// The share of a region's width and height at a share of those of the whole picture; `None`
/// outside it.
#[must_use]
pub fn within(region: &Crop, fraction: [f32; 2]) -> Option<[f32; 2]> {
    let share = [0, 1].map(|i| {
        let at = fraction[i] * region.of[i] as f32 - region.at[i] as f32;
        at / region.size[i] as f32
    });
    let is_inside = share.iter().all(|s| (0.0..1.0).contains(s));
    is_inside.then_some(share)
}

/// The same, where there may be no region: the whole picture then.
#[must_use]
pub fn share(region: Option<&Crop>, fraction: [f32; 2]) -> Option<[f32; 2]> {
    region.map_or(Some(fraction), |region| within(region, fraction))
}

/// Where a region is on the screen; the whole picture, if there is none.
#[must_use]
pub fn rect(placement: &Placement, region: Option<&Crop>) -> Rect {
    let film = placement.film;
    let Some(Crop { of, at, size }) = region else {
        return film;
    };
    let corner = |pixel: [usize; 2]| {
        let share = [0, 1].map(|i| pixel[i] as f32 / of[i] as f32);
        pos2(
            lerp(film.x_range(), share[0]),
            lerp(film.y_range(), share[1]),
        )
    };
    Rect::from_min_max(corner(*at), corner([0, 1].map(|i| at[i] + size[i])))
}

/// Columns and rows in words.
#[must_use]
pub fn words(region: &Crop) -> String {
    format!("{} × {}", region.size[0], region.size[1])
}

/// The whole picture as it was when a region began.
pub struct Around {
    /// What it was rendered by.
    pub job: Job,
    pub(crate) film: Film,
    /// [`Published::generation`](neumann_core::render::Published::generation) of the film.
    pub(crate) generation: u64,
    /// That of the ladder.
    pub(crate) divisor: usize,
    pub(crate) stats: Stats,
    pub(crate) shares: Vec<f64>,
    pub(crate) layer_errors: Vec<Option<f64>>,
    pub(crate) thumbnails: Vec<Thumbnail>,
    /// The part that was composed last, with its pixels.
    pub(crate) composed: Option<(Part, Vec<Rgb>)>,
}

impl Around {
    /// True if the camera stood where that of a region's film does: only then does it continue
    /// the region.
    fn is_seen_by(&self, camera: &CameraDescription) -> bool {
        let whole = CameraDescription {
            crop: None,
            ..camera.clone()
        };
        whole == self.job.settings.camera
    }

    /// Composes a part, unless that is there already.
    pub fn compose(&mut self, part: Part) {
        if self.composed.as_ref().is_none_or(|(of, _)| *of != part) {
            self.composed = Some((part, self.pixels(part).into_owned()));
        }
    }

    fn pixels(&self, part: Part) -> Cow<'_, [Rgb]> {
        if let Some((of, pixels)) = &self.composed
            && *of == part
        {
            return Cow::Borrowed(pixels);
        }
        let mut pixels = vec![Rgb::BLACK; self.film.n_pixels()];
        self.film.compose(part, &mut pixels);
        Cow::Owned(pixels)
    }
}

/// A whole picture with the film of a region in its place, and about its mean radiance, if that is
/// known.
#[derive(Clone, Debug, Default)]
pub struct Pieced {
    /// Pixels per row, and rows.
    pub size: (usize, usize),
    /// Row 0 on top.
    pub pixels: Vec<Rgb>,
    /// Mean radiance around the region.
    pub mean: Option<f32>,
}

/// Puts a part of a region's film into its place in the whole picture. What is around it is as it
/// was, or black where there is nothing, or only what another camera saw.
pub fn piece(
    around: Option<&Around>,
    film: &Film,
    camera: &CameraDescription,
    region: &Crop,
    part: Part,
) -> Pieced {
    let [width, height] = region.of;
    let around = around.filter(|around| around.is_seen_by(camera));
    let mean = around.map(|around| mean_of(&crate::picture::sum_of(&around.thumbnails, part)));
    let mut pixels = match around {
        None => vec![Rgb::BLACK; width * height],
        Some(around) => {
            let size = (around.film.width(), around.film.height());
            let from = around.pixels(part);
            if size == (width, height) {
                from.into_owned()
            } else {
                scaled(&from, size, (width, height))
            }
        }
    };
    let mut of_film = vec![Rgb::BLACK; film.n_pixels()];
    film.compose(part, &mut of_film);
    let [columns, rows] = region.size;
    let of_film = scaled(&of_film, (film.width(), film.height()), (columns, rows));
    for (y, row) in of_film.chunks(columns.max(1)).enumerate() {
        let start = (region.at[1] + y) * width + region.at[0];
        if let Some(place) = pixels.get_mut(start..start + columns) {
            place.copy_from_slice(row);
        }
    }
    Pieced {
        size: (width, height),
        pixels,
        mean,
    }
}

/// Pixels of a coarse picture, each as often as it takes.
fn scaled(pixels: &[Rgb], from: (usize, usize), to: (usize, usize)) -> Vec<Rgb> {
    let index = |i: usize, n: usize, of: usize| (i * of / n.max(1)).min(of.saturating_sub(1));
    let mut scaled = Vec::with_capacity(to.0 * to.1);
    for y in 0..to.1 {
        let row = index(y, to.1, from.1) * from.0;
        let columns = (0..to.0).map(|x| row + index(x, to.0, from.0));
        scaled.extend(columns.map(|i| pixels.get(i).copied().unwrap_or(Rgb::BLACK)));
    }
    scaled
}

#[cfg(test)]
mod tests {
    use neumann_core::scene::description::Crop;

    use super::{Drawing, within};

    #[test]
    fn a_rectangle_covers_pixels_from_whichever_corner_it_is_drawn() {
        let drawn = |a, b| Drawing {
            corners: Some([a, b]),
        };
        let region = Crop {
            of: [200, 100],
            at: [20, 30],
            size: [100, 40],
        };
        for (a, b) in [([0.1, 0.3], [0.6, 0.7]), ([0.6, 0.3], [0.1, 0.7])] {
            assert_eq!(drawn(a, b).region((200, 100)), Some(region));
        }
        assert_eq!(drawn([0.1, 0.3], [0.11, 0.9]).region((200, 100)), None);
        let beyond = drawn([0.9, 0.9], [1.4, 1.7]).region((200, 100)).unwrap();
        assert_eq!((beyond.at, beyond.size), ([180, 90], [20, 10]));

        assert_eq!(within(&region, [0.35, 0.5]), Some([0.5, 0.5]));
        assert_eq!(within(&region, [0.05, 0.5]), None);
        assert_eq!(within(&region, [0.35, 0.75]), None);
    }
}
