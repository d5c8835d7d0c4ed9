//! Is a difference chance? The chi-square test, and the correction for asking many questions at
//! once. Student's and Welch's tests are those of [`Estimate`].
//!
//! A p-value is the probability of a deviation at least as large if the program is right.
//! A [`Family`] of tests fails if any p-value is below [`SIGNIFICANCE`] after Holm's
//! correction, so the chance of a false alarm is that for the whole family, not per test.

pub use neumann_picture::agreement::Estimate;
use statrs::distribution::{ChiSquared, ContinuousCDF};

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
    use neumann_picture::agreement::{deviations, two_sided};
    use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

    use super::{Family, chi_square};

    #[test]
    fn tails_agree_with_tables() {
        // The quantile of chi-square is 18.307 with 10 degrees of freedom.
        let observed: Vec<f64> = (0..11)
            .map(|i| if i == 0 { 140.79 } else { 95.921 })
            .collect();
        let result = chi_square(&observed, &[100.0; 11]);
        assert!((result.statistic - 18.3).abs() < 0.1 && (result.p_value - 0.05).abs() < 0.002);
    }

    /// Those of the program are of its own making.
    #[test]
    fn tails_are_those_of_others() {
        for freedom in [1.0, 2.5, 7.0, 30.0, 61.3, 500.0, 1e6] {
            let others = StudentsT::new(0.0, 1.0, freedom).unwrap();
            for t in [1e-6, 0.1, 0.9, 2.0, 5.0, 9.0, 40.0] {
                let (ours, theirs) = (two_sided(t, freedom), 2.0 * others.sf(t));
                let apart = (ours - theirs).abs();
                assert!(
                    apart < 1e-6 * theirs + 1e-300,
                    "{t}, {freedom}: {ours} {theirs}"
                );
            }
        }
        let normal = Normal::new(0.0, 1.0).unwrap();
        for z in [0.01, 1.0, 1.9, 2.1, 6.0, 30.0] {
            let found = deviations(2.0 * normal.sf(z));
            assert!((found - z).abs() < 1e-6 * z, "{z}: {found}");
        }
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
