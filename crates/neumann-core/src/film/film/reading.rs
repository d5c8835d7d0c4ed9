//! What is read from a film.

use rayon::prelude::*;

use super::{Film, Means, Spread, TILES_PER_TASK};
use crate::film::tile::watched_pixels;
use crate::film::{TILE, TILE_PIXELS, View};
use crate::radiometry::Rgb;

impl Film {
    /// Copies of the means of all layers: `layers()[k][y * width + x]`, row 0 on top; the last one
    /// is the tail.
    #[must_use]
    pub fn layers(&self) -> Vec<Vec<Rgb>> {
        (0..=self.n_layers).map(|k| self.layer(k)).collect()
    }

    /// A copy of the mean of one layer, `layer(k)[y * width + x]`; the tail is layer
    /// [`Self::n_layers`].
    ///
    /// # Panics
    /// If there is no such layer.
    #[must_use]
    pub fn layer(&self, k: usize) -> Vec<Rgb> {
        assert!(k <= self.n_layers, "layer {k} of {}", self.n_layers);
        self.plane(k)
    }

    /// The mean of one layer at a pixel, `y * width + x`; the tail is layer [`Self::n_layers`].
    #[must_use]
    pub fn layer_at(&self, layer: usize, pixel: usize) -> Rgb {
        self.mean_at(self.index(layer, pixel))
    }

    /// A copy of the mean of L, `total()[y * width + x]`.
    #[must_use]
    pub fn total(&self) -> Vec<Rgb> {
        self.plane(self.n_layers + 1)
    }

    /// Estimated variance of [`Self::total`] at a pixel; zero before the second iteration.
    ///
    /// It is the sample variance over the number of iterations, unbiased were they independent,
    /// times what batch means say that it is less, for they are not: their points fill each
    /// other's gaps.
    #[must_use]
    pub fn variance_of_mean(&self, pixel: usize) -> Rgb {
        let total = self.index(self.n_layers + 1, pixel);
        self.deviations_at(total) * self.variance_of_deviations() as f32
    }

    /// Estimated standard error of the luminance of [`Self::total`] at a pixel, as if its channels
    /// moved together, which is the safe side; zero before the second iteration.
    #[must_use]
    pub fn luminance_error(&self, pixel: usize) -> f32 {
        self.variance_of_mean(pixel).map(f32::sqrt).luminance()
    }

    /// The variance of the mean, over the sum of squared deviations.
    fn variance_of_deviations(&self) -> f64 {
        let n = f64::from(self.n_iterations());
        if n < 2.0 {
            return 0.0;
        }
        self.variance_ratio().unwrap_or(1.0) / (n * (n - 1.0))
    }

    /// Of the mean, to that of as many independent iterations. `None` while it cannot be known.
    fn variance_ratio(&self) -> Option<f64> {
        if self.batch_means.n_iterations() == u64::from(self.n_iterations()) {
            self.batch_means.variance_ratio()
        } else {
            // Of a film whose history is not known, the larger estimate is the safe one.
            Some(1.0)
        }
    }

    /// What a file needs to go on with the same bits.
    #[must_use]
    pub fn spread(&self) -> Spread {
        let totals = (0..self.n_pixels()).map(|pixel| self.index(self.n_layers + 1, pixel));
        Spread {
            deviations: totals.map(|total| self.deviations_at(total)).collect(),
            batch_means: self.batch_means.to_bytes(),
        }
    }

    /// The recent and the older iterations, and their shares in all.
    fn parts(&self) -> impl Iterator<Item = (&Means, f32)> {
        let n = self.n_iterations().max(1) as f32;
        let older = self.older.as_deref();
        let share = older.map_or(1.0, |_| self.recent.n as f32 / n);
        let older = older.map(|older| (older, older.n as f32 / n));
        std::iter::once((&self.recent, share)).chain(older)
    }

    /// The mean of the values at an index.
    fn mean_at(&self, index: usize) -> Rgb {
        let values = self
            .parts()
            .map(|(means, share)| means.values[index] * share);
        values.fold(Rgb::BLACK, |sum, value| sum + value)
    }

    /// The squared deviations of L, whose mean is at `total`.
    fn deviations_at(&self, total: usize) -> Rgb {
        let of = |means: &Means| means.values[total + TILE_PIXELS];
        match &self.older {
            None => of(&self.recent),
            Some(older) => {
                let [a, b] = [f64::from(older.n), f64::from(self.recent.n)];
                let apart = self.recent.values[total] - older.values[total];
                of(older) + of(&self.recent) + apart * apart * (a * b / (a + b)) as f32
            }
        }
    }

    /// The mean radiance of a view at one pixel; black if the film does not keep it apart.
    #[must_use]
    pub fn radiance(&self, view: View, pixel: usize) -> Rgb {
        match view {
            View::Total => self.mean_at(self.index(self.n_layers + 1, pixel)),
            _ => view
                .layers(self.n_layers)
                .into_iter()
                .flatten()
                .map(|k| self.layer_at(k, pixel))
                .fold(Rgb::BLACK, |sum, value| sum + value),
        }
    }

    /// Writes a whole view into `out[y * width + x]`.
    ///
    /// # Panics
    /// If `out` has another size than the film.
    pub fn compose(&self, view: View, out: &mut [Rgb]) {
        assert_eq!(out.len(), self.n_pixels(), "as many pixels as the film");
        let planes = match view {
            View::Total => self.n_layers + 1..self.n_layers + 2,
            _ => view.layers(self.n_layers).unwrap_or(0..0),
        };
        for (y, out) in out.chunks_exact_mut(self.width.max(1)).enumerate() {
            out.fill(Rgb::BLACK);
            for plane in planes.clone() {
                self.add_row(plane, y, out);
            }
        }
    }

    /// Adds a row of a layer to `out[x]`; the tail is layer [`Self::n_layers`].
    pub(crate) fn add_row(&self, layer: usize, y: usize, out: &mut [Rgb]) {
        for (means, share) in self.parts() {
            for (out, values) in out.chunks_mut(TILE).zip(self.row(means, layer, y)) {
                for (sum, value) in out.iter_mut().zip(values) {
                    *sum += *value * share;
                }
            }
        }
    }

    /// Mean over all pixels of each layer, tail last.
    #[must_use]
    pub fn layer_means(&self) -> Vec<[f64; 3]> {
        (0..=self.n_layers)
            .into_par_iter()
            .map(|layer| {
                let mut sum = [0f64; 3];
                for (means, share) in self.parts() {
                    let rows = (0..self.height).flat_map(|y| self.row(means, layer, y));
                    for value in rows.flatten() {
                        for (sum, channel) in sum.iter_mut().zip(value.to_array()) {
                            *sum += f64::from(channel * share);
                        }
                    }
                }
                sum.map(|s| s / self.n_pixels().max(1) as f64)
            })
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

    /// Whether there is any light that was scattered.
    #[must_use]
    pub fn has_bounces(&self) -> bool {
        let per_tile = self.values_per_tile();
        let bounces = TILE_PIXELS..per_tile - 2 * TILE_PIXELS;
        self.parts().any(|(means, _)| {
            let mut tiles = means.values.chunks_exact(per_tile).zip(&means.lit);
            tiles.any(|(tile, lit)| {
                !lit.is_black() && tile[bounces.clone()].iter().any(|value| !value.is_black())
            })
        })
    }

    /// Estimated relative error of the image: the root of the mean variance over pixels and
    /// channels, over the mean radiance. `None` while nothing is known of it: before the fourth
    /// iteration, and while no light has been found.
    #[must_use]
    pub fn estimated_error(&self) -> Option<f64> {
        if self.n_iterations() < 2 {
            return None;
        }
        self.variance_ratio()?;
        let per_tile = self.values_per_tile();
        // What of a tile is beyond the image is black.
        let (deviations, sum) = (0..self.grid().n_tiles())
            .into_par_iter()
            .with_min_len(TILES_PER_TASK)
            .map(|tile| {
                let total = (tile + 1) * per_tile - 2 * TILE_PIXELS;
                let pixels = total..total + TILE_PIXELS;
                let deviations = |i: usize| f64::from(self.deviations_at(i).mean());
                let mean = |i: usize| f64::from(self.mean_at(i).mean());
                (
                    pixels.clone().map(deviations).sum::<f64>(),
                    pixels.map(mean).sum::<f64>(),
                )
            })
            .reduce(|| (0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        let n_pixels = self.n_pixels().max(1) as f64;
        let variance = deviations / n_pixels * self.variance_of_deviations();
        (sum > 0.0).then(|| variance.sqrt() / (sum / n_pixels))
    }

    /// [`Self::estimated_error`] of each layer by itself, tail last, from the pixels of which
    /// batches are kept. `None` where nothing is known: of a layer that no light has come to, and
    /// of a film whose history is not known.
    #[must_use]
    pub fn layer_errors(&self) -> Vec<Option<f64>> {
        let n_inside = self.n_watched_inside();
        let error = |(layer, mean): (usize, &[f64; 3])| {
            let mean = mean.iter().sum::<f64>() / 3.0;
            let n = self.n_iterations();
            let variance = self.layer_spread.variance(layer, n, n_inside)?;
            (mean > 0.0).then_some(variance.sqrt() / mean)
        };
        self.layer_means().iter().enumerate().map(error).collect()
    }

    /// How many of the pixels that are watched are in the image.
    fn n_watched_inside(&self) -> usize {
        let grid = self.grid();
        let per_tile = self.batch_means.per_tile();
        let of_tile = |tile: usize| {
            let bounds = grid.bounds(tile);
            let [width, height] = [0, 1].map(|i| bounds.end[i] - bounds.start[i]);
            let watched = watched_pixels(per_tile);
            let inside = watched.filter(|p| p % TILE < width && p / TILE < height);
            inside.count()
        };
        (0..grid.n_tiles()).map(of_tile).sum()
    }

    /// A row of a layer, the total or the deviations, tile by tile.
    fn row<'m>(&self, means: &'m Means, plane: usize, y: usize) -> impl Iterator<Item = &'m [Rgb]> {
        (0..self.width).step_by(TILE).map(move |x| {
            let start = self.index(plane, y * self.width + x);
            &means.values[start..start + TILE.min(self.width - x)]
        })
    }

    fn plane(&self, plane: usize) -> Vec<Rgb> {
        let mut values = vec![Rgb::BLACK; self.n_pixels()];
        for (y, row) in values.chunks_exact_mut(self.width.max(1)).enumerate() {
            self.add_row(plane, y, row);
        }
        values
    }
}
