//! What is read from a film.

use rayon::prelude::*;

use super::{Film, TILES_PER_TASK};
use crate::film::{TILE, TILE_PIXELS, View};
use crate::radiometry::Rgb;

impl Film {
    /// Copies of the means of all layers: `layers()[k][y * width + x]`, row 0 on top; the last one is the tail.
    #[must_use]
    pub fn layers(&self) -> Vec<Vec<Rgb>> {
        (0..=self.n_layers).map(|k| self.layer(k)).collect()
    }

    /// A copy of the mean of one layer, `layer(k)[y * width + x]`; the tail is layer [`Self::n_layers`].
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
        self.values[self.index(layer, pixel)]
    }

    /// A copy of the mean of L, `total()[y * width + x]`.
    #[must_use]
    pub fn total(&self) -> Vec<Rgb> {
        self.plane(self.n_layers + 1)
    }

    /// Unbiased estimate of the variance of [`Self::total`] at a pixel; zero before the second iteration.
    #[must_use]
    pub fn variance_of_mean(&self, pixel: usize) -> Rgb {
        self.variance_from(self.values[self.index(self.n_layers + 2, pixel)])
    }

    fn variance_from(&self, deviations: Rgb) -> Rgb {
        if self.n_iterations < 2 {
            return Rgb::BLACK;
        }
        let n = self.n_iterations as f32;
        deviations / (n * (n - 1.0))
    }

    /// The mean radiance of a view at one pixel; black if the film does not keep it apart.
    #[must_use]
    pub fn radiance(&self, view: View, pixel: usize) -> Rgb {
        match view {
            View::Total => self.values[self.index(self.n_layers + 1, pixel)],
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
        for (out, values) in out.chunks_mut(TILE).zip(self.row(layer, y)) {
            for (sum, value) in out.iter_mut().zip(values) {
                *sum += *value;
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
                for part in (0..self.height).flat_map(|y| self.row(layer, y)) {
                    for value in part {
                        for (sum, channel) in sum.iter_mut().zip(value.to_array()) {
                            *sum += f64::from(channel);
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

    /// Estimated relative error of the image: the root of the mean variance over pixels and
    /// channels, over the mean radiance. `None` while nothing is known of it: before the second
    /// iteration, and while no light has been found.
    #[must_use]
    pub fn estimated_error(&self) -> Option<f64> {
        if self.n_iterations < 2 {
            return None;
        }
        let n = self.n_pixels().max(1) as f64;
        let per_tile = self.values_per_tile();
        // What of a tile is beyond the image is black.
        let (variance, mean) = self
            .values
            .par_chunks_exact(per_tile)
            .with_min_len(TILES_PER_TASK)
            .map(|tile| {
                let (means, deviations) = tile.split_at(per_tile - TILE_PIXELS);
                let total = &means[means.len() - TILE_PIXELS..];
                let variance = |d: &Rgb| f64::from(self.variance_from(*d).mean());
                (
                    deviations.iter().map(variance).sum::<f64>(),
                    total.iter().map(|m| f64::from(m.mean())).sum::<f64>(),
                )
            })
            .reduce(|| (0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        (mean > 0.0).then(|| (variance / n).sqrt() / (mean / n))
    }

    /// A row of a layer, the total or the deviations, tile by tile.
    fn row(&self, plane: usize, y: usize) -> impl Iterator<Item = &[Rgb]> {
        (0..self.width).step_by(TILE).map(move |x| {
            let start = self.index(plane, y * self.width + x);
            &self.values[start..start + TILE.min(self.width - x)]
        })
    }

    fn plane(&self, plane: usize) -> Vec<Rgb> {
        let mut values = Vec::with_capacity(self.n_pixels());
        for y in 0..self.height {
            for part in self.row(plane, y) {
                values.extend_from_slice(part);
            }
        }
        values
    }
}
