//! Is a difference chance? Chi-square, Student's and Welch's tests, and the
//! correction for asking many questions at once.
//!
//! A p-value is the probability of a deviation at least as large if the program is right.
//! A [`Family`] of tests fails if any p-value is below [`SIGNIFICANCE`] after Holm's
//! correction, so the chance of a false alarm is that for the whole family, not per test.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

/// Probability of a false alarm in a whole family of tests.
pub const SIGNIFICANCE: f64 = 1e-4;

/// Cells that expect fewer samples are pooled, so that counts are nearly normal.
const SMALLEST_EXPECTATION: f64 = 10.0;

/// Result of a chi-square test.
#[derive(Clone, Copy, Debug)]
pub struct ChiSquare {
    /// Sum of squared deviations over expectations.
    pub statistic: f64,
    /// Cells after pooling, less one.
    pub degrees_of_freedom: f64,
    /// Probability of such a statistic by chance.
    pub p_value: f64,
}

/// Share of samples that may fall where none can be: rounding moves a few over an edge.
const STRAY_SHARE: f64 = 1e-4;

/// Pearson's test of counts against expectations that add up to the same number. Cells of
/// small expectation are pooled; samples where none can be are beyond chance.
#[must_use]
pub fn chi_square(observed: &[f64], expected: &[f64]) -> ChiSquare {
    let total: f64 = expected.iter().sum();
    let n_stray: f64 = observed
        .iter()
        .zip(expected)
        .filter(|(_, e)| **e <= 1e-9 * total)
        .map(|(o, _)| o)
        .sum();
    if n_stray > STRAY_SHARE * total {
        return ChiSquare {
            statistic: f64::INFINITY,
            degrees_of_freedom: 0.0,
            p_value: 0.0,
        };
    }
    let (mut statistic, mut n_cells) = (0.0, 0usize);
    let mut pool = (0.0, 0.0);
    let mut count = |(o, e): (f64, f64)| {
        statistic += (o - e) * (o - e) / e;
        n_cells += 1;
    };
    for (o, e) in observed.iter().zip(expected) {
        if *e >= SMALLEST_EXPECTATION {
            count((*o, *e));
            continue;
        }
        pool = (pool.0 + o, pool.1 + e);
        if pool.1 >= SMALLEST_EXPECTATION {
            count(std::mem::take(&mut pool));
        }
    }
    if pool.1 > 1.0 {
        count(pool);
    }
    let degrees_of_freedom = n_cells.saturating_sub(1) as f64;
    let p_value = match ChiSquared::new(degrees_of_freedom) {
        Ok(distribution) => distribution.sf(statistic),
        // A single cell holds everything: there is nothing to differ.
        Err(_) => 1.0,
    };
    ChiSquare {
        statistic,
        degrees_of_freedom,
        p_value,
    }
}

/// A mean with its standard error, from independent values.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Number of values.
    pub n: usize,
}

impl Estimate {
    /// From independent values, at least two.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        Self {
            mean,
            standard_error: (squares / (n - 1.0) / n).sqrt(),
            n: values.len(),
        }
    }

    /// Student's test of the mean against a known value. `rounding`, relative, is what
    /// single precision may add to the standard error.
    #[must_use]
    pub fn p_value(&self, expected: f64, rounding: f64) -> f64 {
        let error = self.standard_error.hypot(rounding * expected.abs());
        student(self.mean - expected, error, self.n as f64 - 1.0)
    }

    /// Welch's test: do two means differ though their variances may?
    #[must_use]
    pub fn p_value_against(&self, other: &Self, rounding: f64) -> f64 {
        let (a, b) = (self.standard_error.powi(2), other.standard_error.powi(2));
        let spread = a + b;
        let freedom = if spread > 0.0 {
            spread * spread / (a * a / (self.n as f64 - 1.0) + b * b / (other.n as f64 - 1.0))
        } else {
            1e6
        };
        let error = spread.sqrt().hypot(rounding * self.mean.abs());
        student(self.mean - other.mean, error, freedom)
    }
}

/// Two-sided p-value of a difference with the given standard error.
fn student(difference: f64, error: f64, freedom: f64) -> f64 {
    if difference == 0.0 {
        return 1.0;
    }
    if error == 0.0 || !difference.is_finite() {
        return 0.0;
    }
    let t = (difference / error).abs();
    match StudentsT::new(0.0, 1.0, freedom) {
        Ok(distribution) => 2.0 * distribution.sf(t),
        Err(_) => 0.0,
    }
}

/// Many tests judged together.
#[derive(Clone, Debug, Default)]
pub struct Family {
    tests: Vec<(f64, String)>,
}

impl Family {
    /// Adds a test; `what` says what was compared, with the numbers.
    pub fn add(&mut self, p_value: f64, what: String) {
        self.tests.push((p_value, what));
    }

    /// Number of tests.
    #[must_use]
    pub fn len(&self) -> usize {
        self.tests.len()
    }

    /// True before the first test.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.tests.is_empty()
    }

    /// Those that chance does not explain, by Holm's step-down correction.
    #[must_use]
    pub fn rejected(&self) -> Vec<&(f64, String)> {
        let mut sorted: Vec<&(f64, String)> = self.tests.iter().collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let n = sorted.len();
        let n_rejected = sorted
            .iter()
            .enumerate()
            .take_while(|(i, (p, _))| p.is_nan() || p * ((n - i) as f64) < SIGNIFICANCE)
            .count();
        sorted.truncate(n_rejected);
        sorted
    }

    /// Fails with everything that chance does not explain.
    ///
    /// # Panics
    /// If there was nothing to test, or chance does not explain something.
    pub fn judge(&self) {
        assert!(!self.tests.is_empty(), "nothing was tested");
        let rejected = self.rejected();
        let n_rejected = rejected.len();
        let lines: Vec<String> = rejected
            .iter()
            .take(40)
            .map(|(p, what)| format!("  p = {p:.1e}  {what}"))
            .collect();
        assert!(
            rejected.is_empty(),
            "{n_rejected} of {} tests deviate beyond chance (significance {SIGNIFICANCE:.0e} for \
             all together):\n{}",
            self.tests.len(),
            lines.join("\n")
        );
    }
}

#[cfg(test)]
mod tests {
    use super::{Estimate, Family, chi_square};

    #[test]
    fn tails_agree_with_tables() {
        // Quantiles: chi-square 18.307 with 10 degrees of freedom, Student 2.228 with 10.
        let observed: Vec<f64> = (0..11)
            .map(|i| if i == 0 { 140.79 } else { 95.921 })
            .collect();
        let result = chi_square(&observed, &[100.0; 11]);
        assert!((result.statistic - 18.3).abs() < 0.1 && (result.p_value - 0.05).abs() < 0.002);
        let values: Vec<f64> = (0..11).map(|i| f64::from(i) - 5.0).collect();
        let estimate = Estimate::of(&values);
        let p = estimate.p_value(2.228 * estimate.standard_error, 0.0);
        assert!((p - 0.05).abs() < 1e-3, "{p}");
    }

    #[test]
    fn impossible_samples_are_rejected_and_small_cells_pooled() {
        assert!(chi_square(&[50.0, 1.0], &[51.0, 0.0]).p_value == 0.0);
        let result = chi_square(&[40.0, 6.0, 5.0, 49.0], &[40.0, 5.0, 5.0, 50.0]);
        assert!((result.degrees_of_freedom - 2.0).abs() < 1e-9);
    }

    #[test]
    fn many_questions_ask_for_stronger_answers() {
        let mut family = Family::default();
        family.add(2e-5, "alone".to_owned());
        assert_eq!(family.rejected().len(), 1);
        for _ in 0..9 {
            family.add(0.5, "more".to_owned());
        }
        assert_eq!(family.rejected().len(), 0);
    }
}
