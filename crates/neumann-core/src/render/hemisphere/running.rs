//! A mean on its way: what it was after how many paths, and how sure.

use crate::radiometry::Rgb;
use crate::render::inspection::{Measured, Sum};

/// What a running mean was after some paths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Paths so far.
    pub n: u32,
    /// Their mean luminance, W m⁻² sr⁻¹.
    pub mean: f64,
    /// Half the width of the interval that holds the truth 95 times of 100.
    pub interval: f64,
}

/// A running mean of independent paths.
#[derive(Clone, Debug, Default)]
pub struct Running {
    sum: Sum,
    n: u32,
    moments: Vec<Moment>,
}

/// The first moment that is kept; before that there is hardly an interval.
const FIRST: u32 = 16;
/// So many moments are kept while the number of paths doubles.
const PER_DOUBLING: f64 = 8.0;

impl Running {
    pub(super) fn add(&mut self, value: Rgb) {
        self.sum.add(value);
        self.sum.end_iteration();
        self.n += 1;
        let next = self.moments.last().map_or(FIRST, |last| {
            let n = f64::from(last.n) * (1.0 / PER_DOUBLING).exp2();
            (n.ceil() as u32).max(last.n + 1)
        });
        if self.n >= next {
            let measured = self.measured();
            self.moments.push(Moment {
                n: self.n,
                mean: f64::from(measured.mean.luminance()),
                interval: measured.interval.unwrap_or(f64::INFINITY),
            });
        }
    }

    /// The mean so far.
    #[must_use]
    pub fn measured(&self) -> Measured {
        self.sum.measured(self.n)
    }

    /// Paths so far.
    #[must_use]
    pub fn n(&self) -> u32 {
        self.n
    }

    /// What it was, a few times for each doubling of the paths, and what it is.
    #[must_use]
    pub fn moments(&self) -> Vec<Moment> {
        let mut moments = self.moments.clone();
        if moments.last().is_some_and(|last| last.n < self.n) {
            let measured = self.measured();
            moments.push(Moment {
                n: self.n,
                mean: f64::from(measured.mean.luminance()),
                interval: measured.interval.unwrap_or(f64::INFINITY),
            });
        }
        moments
    }
}
