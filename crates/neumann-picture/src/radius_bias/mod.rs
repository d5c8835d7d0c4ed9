//! Noise against the bias of a radius, for methods that count photons within one.
//!
//! Two errors are in a picture by photons. Chance makes each render another one, by the variance
//! `Var A`. And photons are counted up to `r` away, which smooths the light: the mean of all
//! renders is `E A = L + b`. With a symmetric kernel, linear changes of the light cancel, and what
//! is left goes with the square of the radius (Silverman 1986, 3.3; Knaus and Zwicker 2011,
//! sec. 4): `b = c r²`, or `c Σ r_i² / n` where the radius shrinks from iteration to iteration.
//!
//! So a second render at the radius `ρ r` has the bias `q b`, with
//! `q = Σ (ρ r_i)² / Σ r_i² = ρ²`, and from renders A and B at both radii
//!
//! ```text
//! b ≈ (A - B) / (1 - q)        b² ≈ mean(b)² - Var(mean b)        error² = Var A + b²
//! ```
//!
//! `Var(mean b)` is subtracted since the square of noise is no bias: what is left is zero in the
//! mean where there is none. A and B have the same random numbers, thus the same photons, so that
//! most of their noise is not in the difference. Renders that differ in their seed alone say how
//! both spread; two halves are enough, more are surer.
//!
//! What it is not: within a radius of an edge of the light, or of a surface, the bias goes with `r`
//! rather than with `r²`, and is up to [`EDGES`] times what is said; on the edge itself both radii
//! see the same, and nothing is said. By `vcm` it may fall faster than with `r²`, for smaller
//! radii have smaller MIS weights; it is no less than `1 - q` times what is said.

mod map;
mod radii;
mod report;
#[cfg(test)]
mod tests;

use neumann_core::film::{Film, View};
use neumann_core::radiometry::Rgb;

use crate::agreement::{Batches, Cells, Estimate};

pub use map::{Half, common_look, planes};
pub use radii::{Radii, has_radius, pair};
pub use report::{Report, Row};

/// The smaller radius over the larger one.
pub const RATIO: f64 = 0.5;
/// How many times the bias may be what is said, where the light has edges. Along a straight edge
/// of a shadow the root of `∫ b(u)² du` is 1.56 times that of
/// `∫ (b(u) - b(2 u))² du / (1 - q)²`. There `b(u) = (acos u - u √(1 - u²)) / π` is the
/// share of a disk beyond a line `u` radii from its middle.
pub const EDGES: f64 = 1.6;
/// Standard deviations of what is said of a bias.
const DEVIATIONS: f64 = 2.0;

/// Renders at two radii that differ in their seed alone.
#[derive(Clone, Debug)]
pub struct RadiusBias {
    /// Mean square of the smaller radius over that of the larger one.
    q: f64,
    /// At the radius, at the smaller one, and the first less the second.
    wide: Batches,
    narrow: Batches,
    difference: Batches,
}

/// The errors of a part of the series, relative to its mean.
#[derive(Clone, Debug, PartialEq)]
pub struct PartError {
    /// Which.
    pub view: View,
    /// Its mean luminance.
    pub mean: f64,
    /// Of one render at the radius.
    pub here: Split,
    /// Of one at half of it.
    pub at_half: Split,
    /// The least and the most that the bias at the radius may be, for all that noise lets us know.
    pub bias_range: [f64; 2],
}

/// An error in its two parts: root mean squares over the pixels, as shares of the mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// What chance makes.
    pub noise: f64,
    /// What the radius makes.
    pub bias: f64,
}

impl Split {
    /// Both together.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.noise.hypot(self.bias)
    }
}

impl PartError {
    /// True if chance does not explain the bias.
    #[must_use]
    pub fn has_bias(&self) -> bool {
        self.bias_range[0] > 0.0
    }
}

impl RadiusBias {
    /// No renders yet, of films of this shape; `q` is the mean square of the smaller radius over
    /// that of the larger one.
    #[must_use]
    pub fn new(width: usize, height: usize, n_layers: usize, q: f64) -> Self {
        let batches = Batches::new(width, height, n_layers);
        Self {
            q,
            wide: batches.clone(),
            narrow: batches.clone(),
            difference: batches,
        }
    }

    /// Takes in a render at the radius, and one at the smaller radius with the same seed.
    ///
    /// # Panics
    /// If the films have another shape.
    pub fn take(&mut self, wide: &Film, narrow: &Film) {
        self.wide.take(wide);
        self.narrow.take(narrow);
        let shape = (wide.width(), wide.height(), wide.n_layers());
        assert_eq!(shape, (narrow.width(), narrow.height(), narrow.n_layers()));
        let mut others = vec![Rgb::BLACK; narrow.n_pixels()];
        self.difference.take_values(|view, values| {
            wide.compose(view, values);
            narrow.compose(view, &mut others);
            for (value, other) in values.iter_mut().zip(&others) {
                *value += *other * -1.0;
            }
        });
    }

    /// Renders at each radius.
    #[must_use]
    pub fn n(&self) -> usize {
        self.wide.n()
    }

    /// The cells of the picture.
    #[must_use]
    pub fn cells(&self) -> Cells {
        self.wide.cells()
    }

    /// The parts of the series, by their number.
    #[must_use]
    pub fn views(&self) -> Vec<View> {
        self.wide.views()
    }

    /// The picture at the radius in a cell and channel.
    #[must_use]
    pub fn wide(&self, view: usize, cell: usize, channel: usize) -> Estimate {
        self.wide.estimate(view, cell, channel)
    }

    /// The bias in a cell and channel, with its standard error.
    #[must_use]
    pub fn bias(&self, view: usize, cell: usize, channel: usize) -> Estimate {
        self.extrapolated(self.difference.estimate(view, cell, channel))
    }

    /// The luminance of a pixel at the radius, and its bias.
    #[must_use]
    pub fn pixel(&self, view: usize, pixel: usize) -> [Estimate; 2] {
        let difference = self.difference.pixel(view, pixel);
        [self.wide.pixel(view, pixel), self.extrapolated(difference)]
    }

    /// The bias that makes such a difference of the radii.
    fn extrapolated(&self, difference: Estimate) -> Estimate {
        let scale = 1.0 / (1.0 - self.q);
        Estimate {
            mean: difference.mean * scale,
            standard_error: difference.standard_error * scale,
            ..difference
        }
    }

    /// Variance of one render at the radius, at a pixel.
    fn variance(&self, view: usize, pixel: usize) -> f64 {
        variance(self.wide.pixel(view, pixel))
    }

    /// The square of the bias at a pixel, less what noise makes of it, and that.
    fn square(&self, view: usize, pixel: usize) -> [f64; 2] {
        let [_, bias] = self.pixel(view, pixel);
        let of_noise = bias.standard_error * bias.standard_error;
        [bias.mean * bias.mean - of_noise, of_noise]
    }

    /// The errors of all parts that have light; at least two renders are wanted.
    #[must_use]
    pub fn parts(&self) -> Vec<PartError> {
        let views = self.views().into_iter().enumerate();
        views.filter_map(|(i, view)| self.part(i, view)).collect()
    }

    fn part(&self, number: usize, view: View) -> Option<PartError> {
        let (width, height) = self.cells().size();
        let n = width * height;
        let per_pixel = |f: &dyn Fn(usize) -> f64| (0..n).map(f).sum::<f64>() / n as f64;
        let mean = per_pixel(&|pixel| self.wide.pixel(number, pixel).mean);
        if mean <= 0.0 {
            return None;
        }
        let relative = |square: f64| square.max(0.0).sqrt() / mean;
        let noise = per_pixel(&|pixel| self.variance(number, pixel));
        let at_half = per_pixel(&|pixel| variance(self.narrow.pixel(number, pixel)));
        let (square, spread) = self.mean_square(number);
        let bias = relative(square);
        let range = [-1.0, 1.0].map(|sign| relative(square.max(0.0) + sign * DEVIATIONS * spread));
        Some(PartError {
            view,
            mean,
            here: Split {
                noise: relative(noise),
                bias,
            },
            at_half: Split {
                noise: relative(at_half),
                bias: self.q * bias,
            },
            bias_range: range,
        })
    }

    /// The mean square of the bias over the pixels, and how far noise may put it off.
    ///
    /// Noise is alike in neighbours that look at the same photons. Where it has the covariance
    /// `v ρ(d)`, `v` that of a pixel, the sum of squares has the variance
    /// `2 Σ v² Σ ρ² + 4 Σ b² v Σ ρ`, and `Σ ρ² <= Σ ρ`.
    ///
    /// `Σ ρ` is the number of pixels that move as one. It is read off the finest cells: their
    /// noise is less than that of their pixels by so much.
    fn mean_square(&self, view: usize) -> (f64, f64) {
        let cells = self.cells();
        let (width, height) = cells.size();
        let mut of_cells = vec![0.0; cells.len()];
        let (mut sum, mut variance) = (0.0, 0.0);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let [square, of_noise] = self.square(view, y * width + x);
            sum += square;
            variance += of_noise * (2.0 * of_noise + 4.0 * square.max(0.0));
            if let Some(cell) = cells.around(x, y).next() {
                of_cells[cell] += of_noise;
            }
        }
        let finest = (0..cells.len()).filter(|cell| of_cells[*cell] > 0.0);
        let (mut together, mut apart) = (0.0, 0.0);
        for cell in finest {
            let mean = self.extrapolated(self.difference.luminance(view, cell));
            together += (mean.standard_error * cells.cell(cell).n_pixels() as f64).powi(2);
            apart += of_cells[cell];
        }
        let as_one = if apart > 0.0 { together / apart } else { 1.0 };
        let n = (width * height) as f64;
        (sum / n, (variance * as_one.max(1.0)).sqrt() / n)
    }
}

/// Of the values whose mean is so certain.
fn variance(estimate: Estimate) -> f64 {
    estimate.n as f64 * estimate.standard_error * estimate.standard_error
}
