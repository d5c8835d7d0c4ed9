//! How uncertain each layer is, from the spread of its iterations at the pixels that are watched.
//!
//! Means and sums of squared deviations by Welford's recurrence, as the film has them for L alone
//! (Knuth, TAOCP 2, 4.2.2); and batch means of each layer, since layers do not converge alike.

use super::batch_means::BatchMeans;
use crate::radiometry::Rgb;

/// The spread of the layers of a film, tail last.
#[derive(Clone, Debug)]
pub(super) struct LayerSpread {
    layers: Vec<OneLayer>,
}

/// Of one layer at the watched pixels, tiles row by row.
#[derive(Clone, Debug)]
struct OneLayer {
    n_iterations: u32,
    means: Vec<Rgb>,
    deviations: Vec<Rgb>,
    batch_means: BatchMeans,
}

impl LayerSpread {
    /// That of no iteration, for a film of so many tiles and layers, with the tail.
    pub(super) fn new(n_tiles: usize, n_layers: usize) -> Self {
        let batch_means = BatchMeans::new(n_tiles);
        let black = vec![Rgb::BLACK; n_tiles * batch_means.per_tile()];
        let layer = OneLayer {
            n_iterations: 0,
            means: black.clone(),
            deviations: black,
            batch_means,
        };
        Self {
            layers: vec![layer; n_layers],
        }
    }

    /// Takes in an iteration; `values(layer)` are those of the watched pixels.
    pub(super) fn push(&mut self, iteration: u32, values: impl Fn(usize) -> Vec<Rgb>) {
        for (number, layer) in self.layers.iter_mut().enumerate() {
            layer.push(iteration, values(number));
        }
    }

    /// Takes in the iterations of another one of the same shape.
    pub(super) fn absorb(&mut self, other: &Self) {
        for (layer, other) in self.layers.iter_mut().zip(&other.layers) {
            layer.absorb(other);
        }
    }

    /// Variance of the mean of `n_iterations`, which must be all that it knows of: over channels
    /// and over the watched pixels, of which `n_inside` are in the image. `None` while it cannot be
    /// known, and while no light has come to any of them.
    pub(super) fn variance(&self, layer: usize, n_iterations: u32, n_inside: usize) -> Option<f64> {
        let layer = self.layers.get(layer)?;
        let is_lit = layer.means.iter().any(|mean| !mean.is_black());
        let n_known = layer.batch_means.n_iterations();
        if !is_lit || n_iterations < 2 || n_known != u64::from(n_iterations) {
            return None;
        }
        // What is beyond the image is black.
        let deviations = layer.deviations.iter().map(|d| f64::from(d.mean()));
        let n = f64::from(n_iterations);
        let independent = deviations.sum::<f64>() / n_inside.max(1) as f64 / (n * (n - 1.0));
        Some(independent * layer.batch_means.variance_ratio()?)
    }
}

impl OneLayer {
    fn push(&mut self, iteration: u32, values: Vec<Rgb>) {
        self.n_iterations += 1;
        let step = 1.0 / self.n_iterations as f32;
        let spread = self.means.iter_mut().zip(&mut self.deviations);
        for ((mean, deviations), value) in spread.zip(&values) {
            let apart = *value - *mean;
            *mean += apart * step;
            *deviations += apart * (*value - *mean);
        }
        self.batch_means.push(iteration, values);
    }

    /// By Chan, Golub and `LeVeque` (1979).
    fn absorb(&mut self, other: &Self) {
        self.batch_means.absorb(&other.batch_means);
        if other.n_iterations == 0 {
            return;
        }
        let [a, b] = [self.n_iterations, other.n_iterations].map(|n| n as f32);
        self.n_iterations += other.n_iterations;
        for (i, mean) in self.means.iter_mut().enumerate() {
            let apart = other.means[i] - *mean;
            *mean += apart * (b / (a + b));
            self.deviations[i] += other.deviations[i] + apart * apart * (a * b / (a + b));
        }
    }
}
