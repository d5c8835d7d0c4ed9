//! The mean of the frames, with the variance of L.

use bytemuck::{cast_slice, cast_slice_mut, zeroed_vec};
use rayon::prelude::*;

use super::frame::{LitLayers, TILE, TILE_PIXELS, TileBounds, TileGrid};
use super::{Frame, View};
use crate::math::prefetch;
use crate::radiometry::Rgb;

/// The mean of all iterations so far, layer by layer.
///
/// Means are kept as running means, `m += (x - m) / n`, whose rounding error
/// stays near `sqrt(n / 3)` half-units in the last place: 1e-5 relative after
/// 100 000 iterations. The sum of squared deviations of L is kept by Welford's
/// recurrence (Knuth, TAOCP 2, 4.2.2).
#[derive(Clone, Debug)]
pub struct Film {
    width: usize,
    height: usize,
    n_layers: usize,
    n_iterations: u32,
    layers: Vec<Vec<Rgb>>,
    total: Vec<Rgb>,
    deviations: Vec<Rgb>,
    /// What of each tile is not all black.
    lit: Vec<LitLayers>,
    n_refused: u64,
}

/// Two films, or a film and its parts, do not fit each other.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FilmError {
    /// Sizes or numbers of layers differ.
    #[error("films of different shape: {0} and {1}; render both with the same --size and --layers")]
    Shape(String, String),
}

impl Film {
    /// An empty film with `n_layers` bounce layers and a tail.
    #[must_use]
    pub fn new(width: usize, height: usize, n_layers: usize) -> Self {
        // Memory that is never written where a layer is black.
        let plane = || zeroed_vec(width * height);
        Self {
            width,
            height,
            n_layers,
            n_iterations: 0,
            layers: (0..=n_layers).map(|_| plane()).collect(),
            total: vec![Rgb::BLACK; width * height],
            deviations: vec![Rgb::BLACK; width * height],
            lit: vec![LitLayers::default(); TileGrid::new(width, height).n_tiles()],
            n_refused: 0,
        }
    }

    /// A film put together again from what [`Self::layers`], [`Self::total`] and
    /// [`Self::variance_of_mean`] gave, for instance from a file.
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
        Ok(Self {
            width,
            height,
            n_layers: layers.len() - 1,
            n_iterations,
            layers,
            total,
            deviations: variance_of_mean.iter().map(|v| *v * scale).collect(),
            lit: vec![LitLayers::ALL; TileGrid::new(width, height).n_tiles()],
            n_refused,
        })
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
        self.n_iterations
    }

    /// Contributions refused because they were not finite or negative, over all iterations.
    #[must_use]
    pub fn n_refused(&self) -> u64 {
        self.n_refused
    }

    /// Means: `layers()[k][y * width + x]`, row 0 on top; the last one is the tail.
    #[must_use]
    pub fn layers(&self) -> &[Vec<Rgb>] {
        &self.layers
    }

    /// Mean of L, `total()[y * width + x]`.
    #[must_use]
    pub fn total(&self) -> &[Rgb] {
        &self.total
    }

    /// Unbiased estimate of the variance of [`Self::total`] at a pixel; zero before the second iteration.
    #[must_use]
    pub fn variance_of_mean(&self, pixel: usize) -> Rgb {
        if self.n_iterations < 2 {
            return Rgb::BLACK;
        }
        let n = self.n_iterations as f32;
        self.deviations[pixel] / (n * (n - 1.0))
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
        self.n_iterations += 1;
        self.n_refused += frame.n_refused();
        let step = 1.0 / self.n_iterations as f32;
        // By rows of tiles.
        let n = self.width * TILE;
        let mut bands: Vec<Band<'_>> = self
            .total
            .chunks_mut(n)
            .zip(self.deviations.chunks_mut(n))
            .zip(self.lit.chunks_mut(frame.grid().n_columns()))
            .map(|((total, deviations), lit)| Band {
                total,
                deviations,
                lit,
                layers: Vec::with_capacity(self.n_layers + 1),
            })
            .collect();
        for layer in &mut self.layers {
            for (chunk, band) in layer.chunks_mut(n).zip(&mut bands) {
                band.layers.push(chunk);
            }
        }
        let width = self.width;
        bands
            .par_iter_mut()
            .enumerate()
            .for_each(|(row, band)| band.add(frame, row, width, step));
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
        let n = self.n_iterations + other.n_iterations;
        if other.n_iterations == 0 {
            return Ok(());
        }
        let share = f64::from(other.n_iterations) / f64::from(n);
        let mix = |a: f32, b: f32| (f64::from(a) + (f64::from(b) - f64::from(a)) * share) as f32;
        let mix_rgb = |a: Rgb, b: Rgb| Rgb::new(mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b));
        for i in 0..self.total.len() {
            let apart = other.total[i] - self.total[i];
            self.deviations[i] = self.deviations[i]
                + other.deviations[i]
                + apart * apart * (self.n_iterations as f32 * share as f32);
            self.total[i] = mix_rgb(self.total[i], other.total[i]);
        }
        for (mine, theirs) in self.layers.iter_mut().zip(&other.layers) {
            for (a, b) in mine.iter_mut().zip(theirs) {
                *a = mix_rgb(*a, *b);
            }
        }
        for (mine, theirs) in self.lit.iter_mut().zip(&other.lit) {
            *mine = mine.union(*theirs);
        }
        self.n_iterations = n;
        self.n_refused += other.n_refused;
        Ok(())
    }

    /// The mean radiance of a view at one pixel; black if the film does not keep it apart.
    #[must_use]
    pub fn radiance(&self, view: View, pixel: usize) -> Rgb {
        match view {
            View::Total => self.total[pixel],
            _ => view
                .layers(self.n_layers)
                .into_iter()
                .flatten()
                .map(|k| self.layers[k][pixel])
                .fold(Rgb::BLACK, |sum, value| sum + value),
        }
    }

    /// Writes a whole view into `out[y * width + x]`, reading as few planes as it needs.
    ///
    /// # Panics
    /// If `out` has another size than the film.
    pub fn compose(&self, view: View, out: &mut [Rgb]) {
        assert_eq!(out.len(), self.total.len(), "as many pixels as the film");
        let Some(range) = view.layers(self.n_layers) else {
            out.fill(Rgb::BLACK);
            return;
        };
        if view == View::Total {
            out.copy_from_slice(&self.total);
            return;
        }
        out.copy_from_slice(&self.layers[range.start]);
        for layer in &self.layers[range.start + 1..range.end] {
            for (sum, value) in out.iter_mut().zip(layer) {
                *sum += *value;
            }
        }
    }

    /// Mean over all pixels of each layer, tail last.
    #[must_use]
    pub fn layer_means(&self) -> Vec<[f64; 3]> {
        self.layers
            .par_iter()
            .map(|layer| mean_of(layer.iter().copied()))
            .collect()
    }

    /// Share of each layer in the energy (mean luminance) of L, tail last; zeros for a black film.
    #[must_use]
    pub fn energy_shares(&self) -> Vec<f64> {
        let luminance: Vec<f64> = self
            .layer_means()
            .iter()
            .map(|m| 0.2126 * m[0] + 0.7152 * m[1] + 0.0722 * m[2])
            .collect();
        let sum: f64 = luminance.iter().sum();
        luminance
            .iter()
            .map(|l| if sum > 0.0 { l / sum } else { 0.0 })
            .collect()
    }

    /// Estimated relative error of the image: the root mean square over pixels
    /// of the standard error of luminance, over the mean luminance. Infinite before
    /// the second iteration, zero for a black image.
    #[must_use]
    pub fn estimated_error(&self) -> f64 {
        if self.n_iterations < 2 {
            return f64::INFINITY;
        }
        let n = self.total.len().max(1) as f64;
        let (variance, mean) = (0..self.total.len())
            .into_par_iter()
            .with_min_len(BAND)
            .fold(
                || (0f64, 0f64),
                |(variance, mean), i| {
                    let v = self.variance_of_mean(i);
                    (
                        variance + f64::from(v.mean()),
                        mean + f64::from(self.total[i].mean()),
                    )
                },
            )
            .reduce(|| (0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        if mean <= 0.0 {
            return 0.0;
        }
        (variance / n).sqrt() / (mean / n)
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

/// Pixels that one task looks at, at least.
const BAND: usize = 4096;

/// The pixels of a row of tiles.
struct Band<'a> {
    total: &'a mut [Rgb],
    deviations: &'a mut [Rgb],
    lit: &'a mut [LitLayers],
    layers: Vec<&'a mut [Rgb]>,
}

impl Band<'_> {
    fn add(&mut self, frame: &Frame, row: usize, width: usize, step: f32) {
        let grid = frame.grid();
        for column in 0..grid.n_columns() {
            let tile = row * grid.n_columns() + column;
            let TileBounds { start, end } = grid.bounds(tile);
            // A row of the tile, in the film's planes and in the tile's, channel by channel.
            let rows = (0..end[1] - start[1]).map(|y| {
                let from = y * width;
                let in_film = N_CHANNELS * (from + start[0])..N_CHANNELS * (from + end[0]);
                let in_tile = N_CHANNELS * y * TILE;
                (in_film.clone(), in_tile..in_tile + in_film.len())
            });
            let mut sum = [0f32; N_CHANNELS * TILE_PIXELS];
            let layers = frame.layers_of_tile(tile);
            let was_lit = self.lit[column];
            let lit = was_lit.union(frame.lit(tile));
            self.lit[column] = lit;
            for (layer, (mean, values)) in self.layers.iter_mut().zip(layers).enumerate() {
                if !lit.contains(layer) {
                    continue;
                }
                let (mean, values) = (cast_slice_mut(mean), cast_slice(values));
                for (in_film, in_tile) in rows.clone() {
                    let values: &[f32] = &values[in_tile.clone()];
                    // What the next tile will want of this row: too short a stretch for the processor to see it coming.
                    for line in (in_film.end..in_film.end + in_film.len()).step_by(FLOATS_PER_LINE)
                    {
                        if let Some(value) = mean.get(line) {
                            prefetch(value);
                        }
                    }
                    let mean: &mut [f32] = &mut mean[in_film];
                    if !was_lit.contains(layer) {
                        // Written before it is read, or the system would hand out the page twice.
                        mean.fill(0.0);
                    }
                    for ((m, x), s) in mean.iter_mut().zip(values).zip(&mut sum[in_tile]) {
                        *s += *x;
                        *m += (*x - *m) * step;
                    }
                }
            }
            let (total, deviations) = (cast_slice_mut(self.total), cast_slice_mut(self.deviations));
            for (in_film, in_tile) in rows {
                let total: &mut [f32] = &mut total[in_film.clone()];
                let deviations: &mut [f32] = &mut deviations[in_film];
                let pairs = total.iter_mut().zip(deviations);
                for ((m, d), x) in pairs.zip(&sum[in_tile]) {
                    let before = *x - *m;
                    *m += before * step;
                    *d += before * (*x - *m);
                }
            }
        }
    }
}

/// Channels of a colour.
const N_CHANNELS: usize = 3;
/// In a line of cache.
const FLOATS_PER_LINE: usize = 16;

fn mean_of(values: impl ExactSizeIterator<Item = Rgb>) -> [f64; 3] {
    let n = values.len().max(1) as f64;
    let sum = values.fold([0f64; 3], |s, c| {
        [
            s[0] + f64::from(c.r),
            s[1] + f64::from(c.g),
            s[2] + f64::from(c.b),
        ]
    });
    sum.map(|s| s / n)
}

#[cfg(test)]
mod tests {
    use super::{Film, Frame, TILE_PIXELS, View};
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

    #[test]
    fn the_mean_stays_exact_over_many_iterations() {
        let mut film = Film::new(1, 1, 1);
        let mut frame = Frame::new(1, 1, 1);
        let mut exact = 0f64;
        let n = 100_000u32;
        for i in 0..n {
            let x = 0.1 + (i.wrapping_mul(2_654_435_761) >> 8) as f32 * 1e-7;
            frame.values()[0] = Rgb::splat(x);
            exact += f64::from(x);
            film.add(&frame);
        }
        let relative = f64::from(film.total()[0].r) / (exact / f64::from(n)) - 1.0;
        assert!(relative.abs() < 1e-4, "{relative}");
    }
}
