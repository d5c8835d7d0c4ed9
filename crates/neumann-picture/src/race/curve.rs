//! Errors over time.

use crate::compare::Comparison;
use crate::figures::significant;

/// How far a method had come.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Processor time that it had had.
    pub seconds: f64,
    /// Iterations that it had rendered.
    pub n_iterations: u32,
    /// How far its picture was from the reference.
    pub comparison: Comparison,
}

impl Point {
    /// What is said of it, in two lines.
    #[must_use]
    pub fn facts(&self) -> [String; 2] {
        let n = self.n_iterations;
        let iterations = if n == 1 { "iteration" } else { "iterations" };
        [
            format!("{n} {iterations}, {:.1} s", self.seconds),
            format!(
                "relMSE {}, FLIP {}",
                significant(self.comparison.rel_mse, 3),
                significant(self.comparison.flip, 3)
            ),
        ]
    }
}

/// Which error is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Measure {
    /// Mean relative square error.
    #[default]
    RelMse,
    /// FLIP.
    Flip,
}

impl Measure {
    /// All, in the order of menus.
    pub const ALL: [Self; 2] = [Self::RelMse, Self::Flip];

    /// What it is called.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RelMse => "relMSE",
            Self::Flip => "FLIP",
        }
    }

    /// The error.
    #[must_use]
    pub fn of(self, comparison: &Comparison) -> f64 {
        match self {
            Self::RelMse => comparison.rel_mse,
            Self::Flip => comparison.flip,
        }
    }

    /// Slope of the curve of an unbiased method. The deviation of a mean of `n` samples falls as
    /// `n^(−1/2)`, and relMSE is a mean of squares.
    #[must_use]
    pub fn slope(self) -> f64 {
        match self {
            Self::RelMse => -1.0,
            Self::Flip => -0.5,
        }
    }

    /// [`Self::slope`] as it is written.
    #[must_use]
    pub fn slope_text(self) -> &'static str {
        match self {
            Self::RelMse => "slope −1 (root: −1/2)",
            Self::Flip => "slope −1/2",
        }
    }
}

/// Processor time after which an error was as low as `quality` and stayed so; between two points
/// by a straight line of the logarithms. `None` if it is not that low yet.
#[must_use]
pub fn seconds_to(curve: &[Point], measure: Measure, quality: f64) -> Option<f64> {
    let error = |point: &Point| measure.of(&point.comparison);
    let is_good = |point: &Point| error(point) <= quality;
    let n_good = curve.iter().rev().take_while(|p| is_good(p)).count();
    let after = curve.get(curve.len() - n_good)?;
    let Some(before) = (curve.len() - n_good).checked_sub(1).map(|i| &curve[i]) else {
        return Some(after.seconds);
    };
    let [a, b, q] = [error(before), error(after), quality].map(|e| e.max(f64::MIN_POSITIVE).ln());
    let [from, to] = [before.seconds, after.seconds].map(|s| s.max(f64::MIN_POSITIVE).ln());
    let share = if a > b { (a - q) / (a - b) } else { 1.0 };
    Some((from + share * (to - from)).exp())
}

#[cfg(test)]
pub(super) mod tests {
    use super::{Measure, Point, seconds_to};
    use crate::compare::Comparison;

    /// A point of given time and relMSE; its FLIP is the root.
    pub(in crate::race) fn point(seconds: f64, rel_mse: f64) -> Point {
        Point {
            seconds,
            n_iterations: 1,
            comparison: Comparison {
                rmse: 0.0,
                rel_mse,
                flip: rel_mse.sqrt(),
                mean_ratio: [1.0; 3],
                mean: [1.0; 3],
                mean_reference: [1.0; 3],
                largest_difference: 0.0,
                n_skipped: 0,
            },
        }
    }

    #[test]
    fn time_to_a_quality_is_where_the_curve_crosses_it() {
        let curve = [point(1.0, 0.1), point(2.0, 0.05), point(4.0, 0.025)];
        let to = |quality| seconds_to(&curve, Measure::RelMse, quality);
        assert_eq!(to(0.2), Some(1.0), "it was as good at once");
        let between = to(0.05 / 2f64.sqrt()).unwrap();
        assert!((between - 2.0 * 2f64.sqrt()).abs() < 1e-9, "{between}");
        assert!((to(0.025).unwrap() - 4.0).abs() < 1e-9);
        assert_eq!(to(0.02), None);
        assert_eq!(seconds_to(&[], Measure::RelMse, 1.0), None);
        let flip = seconds_to(&curve, Measure::Flip, 0.05f64.sqrt()).unwrap();
        assert!((flip - 2.0).abs() < 1e-9, "{flip}");
        // A firefly takes back what had been reached.
        let back = [point(1.0, 0.1), point(2.0, 0.01), point(4.0, 0.1)];
        assert_eq!(seconds_to(&back, Measure::RelMse, 0.05), None);
    }
}
