//! Do two means differ beyond chance? Student's and Welch's tests.
//!
//! A p-value is the probability of a difference at least as large if there is none in truth. With
//! ν degrees of freedom that of `|t|` is `I_x(ν/2, 1/2)`, `x = ν / (ν + t²)`, with I the
//! regularized incomplete beta function (Abramowitz and Stegun, 26.7.1), here by its continued
//! fraction (DLMF 8.17.22).

use std::f64::consts::PI;

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
        Self::of_spread(mean, squares, values.len())
    }

    /// From the mean of `n` independent values and their squared deviations from it.
    #[must_use]
    pub fn of_spread(mean: f64, squares: f64, n: usize) -> Self {
        Self {
            mean,
            standard_error: (squares / (n as f64 - 1.0) / n as f64).sqrt(),
            n,
        }
    }

    /// The same with the relative error that it has, but of another mean.
    #[must_use]
    pub fn error_at(self, mean: f64) -> Self {
        let scale = if self.mean > 0.0 {
            mean / self.mean
        } else {
            1.0
        };
        Self {
            standard_error: self.standard_error * scale,
            ..self
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
    two_sided((difference / error).abs(), freedom)
}

/// Probability that Student's t with so many degrees of freedom is beyond `±t`.
#[must_use]
pub fn two_sided(t: f64, freedom: f64) -> f64 {
    if freedom.is_nan() || freedom <= 0.0 {
        return 0.0;
    }
    let x = freedom / (freedom + t * t);
    incomplete_beta(x, 1.0 - x, 0.5 * freedom, 0.5)
}

/// `I_x(a, b)`; `y = 1 - x`.
fn incomplete_beta(x: f64, y: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || y <= 0.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    // The fraction converges fast on this side only.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(y, x, b, a);
    }
    let ln_beta = ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b);
    (a * x.ln() + b * y.ln() - ln_beta).exp() * fraction(x, a, b) / a
}

/// The continued fraction of `I_x(a, b)`, by Lentz's method.
fn fraction(x: f64, a: f64, b: f64) -> f64 {
    const SMALL: f64 = 1e-300;
    const MOST: u32 = 10_000;
    let nonzero = |v: f64| if v.abs() < SMALL { SMALL } else { v };
    let (mut c, mut d) = (1.0, 1.0 / nonzero(1.0 - (a + b) * x / (a + 1.0)));
    let mut value = d;
    for m in (1..MOST).map(f64::from) {
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut step = 1.0;
        for term in [even, odd] {
            d = 1.0 / nonzero(1.0 + term * d);
            c = nonzero(1.0 + term / c);
            step = c * d;
            value *= step;
        }
        if (step - 1.0).abs() < 1e-14 {
            break;
        }
    }
    value
}

/// `ln Γ(x)` for positive x: Lanczos (1964), with the coefficients of Godfrey for g = 7.
fn ln_gamma(x: f64) -> f64 {
    const G: f64 = 7.0;
    const COEFFICIENTS: [f64; 8] = [
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let terms = COEFFICIENTS.iter().zip(1..);
    let sum: f64 = terms.map(|(c, i)| c / (x + f64::from(i))).sum();
    let t = x + G + 0.5;
    0.5 * (2.0 * PI).ln() + (x + 0.5) * t.ln() - t + (0.999_999_999_999_809_9 + sum).ln()
}

/// No score is larger: p-values beyond are below what a number can hold.
pub const MOST_DEVIATIONS: f64 = 37.0;

/// How many standard deviations a normal variable is beyond, on either side, with probability `p`.
///
/// Acklam's rational approximation of the quantiles (2003), good to nine figures.
#[must_use]
pub fn deviations(p: f64) -> f64 {
    const A: [f64; 6] = [
        -39.696_830_286_653_76,
        220.946_098_424_520_5,
        -275.928_510_446_968_7,
        138.357_751_867_269,
        -30.664_798_066_147_16,
        2.506_628_277_459_239,
    ];
    const B: [f64; 6] = [
        -54.476_098_798_224_06,
        161.585_836_858_040_9,
        -155.698_979_859_886_6,
        66.801_311_887_719_72,
        -13.280_681_552_885_72,
        1.0,
    ];
    const C: [f64; 6] = [
        -0.007_784_894_002_430_293,
        -0.322_396_458_041_136_5,
        -2.400_758_277_161_838,
        -2.549_732_539_343_734,
        4.374_664_141_464_968,
        2.938_163_982_698_783,
    ];
    const D: [f64; 5] = [
        0.007_784_695_709_041_462,
        0.322_467_129_070_039_8,
        2.445_134_137_142_996,
        3.754_408_661_415_868,
        1.0,
    ];
    let horner = |coefficients: &[f64], x: f64| coefficients.iter().fold(0.0, |sum, c| sum * x + c);
    let q = 0.5 * p;
    if q.is_nan() || q <= 0.0 {
        return MOST_DEVIATIONS;
    }
    let z = if q < 0.024_25 {
        let r = (-2.0 * q.ln()).sqrt();
        -horner(&C, r) / horner(&D, r)
    } else {
        let from_middle = 0.5 - q;
        let r = from_middle * from_middle;
        horner(&A, r) * from_middle / horner(&B, r)
    };
    z.clamp(0.0, MOST_DEVIATIONS)
}

#[cfg(test)]
mod tests {
    use super::{Estimate, MOST_DEVIATIONS, deviations, two_sided};

    #[test]
    fn tails_agree_with_tables() {
        // Abramowitz and Stegun, table 26.10; and the tails of one and two degrees in closed form.
        for (t, freedom, p) in [
            (2.228, 10.0, 0.05),
            (4.587, 10.0, 0.001),
            (3.460, 60.0, 0.001),
            (1.960, 1e6, 0.05),
        ] {
            let found: f64 = two_sided(t, freedom);
            assert!((found / p - 1.0).abs() < 2e-3, "{t}, {freedom}: {found}");
        }
        for t in [1e-3, 0.3, 1.0, 7.0, 1e3, 1e9] {
            let one = 1.0 - 2.0 * f64::atan(t) / std::f64::consts::PI;
            let two = 1.0 - t / (2.0 + t * t).sqrt();
            for (freedom, p) in [(1.0, one), (2.0, two)] {
                let found = two_sided(t, freedom);
                assert!(
                    (found - p).abs() < 1e-12 + 1e-6 * p,
                    "{t}, {freedom}: {found}"
                );
            }
        }
    }

    #[test]
    fn deviations_are_those_of_the_normal_distribution() {
        for (p, z) in [(1.0, 0.0), (0.317_310_5, 1.0), (0.05, 1.959_964)] {
            assert!((deviations(p) - z).abs() < 1e-5, "{p}");
        }
        assert!((deviations(1.973_175e-9) - 6.0).abs() < 1e-5);
        assert!((deviations(0.0) - MOST_DEVIATIONS).abs() < 1e-9);
        for z in [0.5, 2.0, 2.4, 5.0, 20.0] {
            let p = two_sided(z, 1e6);
            assert!((deviations(p) / z - 1.0).abs() < 1e-3, "{z}: {p}");
        }
    }

    #[test]
    fn a_mean_is_as_certain_as_its_values_spread() {
        let values: Vec<f64> = (0..11).map(|i| f64::from(i) - 5.0).collect();
        let estimate = Estimate::of(&values);
        // The variance of 0 … 10 is 11.
        assert!((estimate.standard_error - 1.0).abs() < 1e-12);
        assert!((estimate.p_value(2.228, 0.0) - 0.05).abs() < 1e-4);
        let higher = Estimate {
            mean: 2.0,
            ..estimate
        };
        // 20 degrees of freedom, t = √2.
        assert!((estimate.p_value_against(&higher, 0.0) - 0.1727).abs() < 1e-3);
        let exact = |mean| Estimate {
            mean,
            standard_error: 0.0,
            n: 11,
        };
        assert!(
            exact(1.0).p_value_against(&exact(1.000_002), 1e-5) > 0.5,
            "rounding"
        );
        assert!(exact(1.0).p_value_against(&exact(1.001), 1e-5) < 1e-9);
        assert!(exact(0.0).p_value_against(&exact(1e-30), 1e-5) < 1e-9);
    }
}
