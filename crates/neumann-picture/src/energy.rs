//! The series as a quantity: how much of the light each bounce is worth, how fast that decays, and
//! what lies beyond the last bounce.
//!
//! `L_e, T L_e, T²L_e, …` decay like a geometric series of which the ratio tends to the spectral
//! radius of T, as far as this picture sees it. The ratio is fitted to the logarithms of the later
//! terms by weighted least squares.

mod chart;

use std::fmt::Write;

use neumann_core::film::View;

use crate::figures::significant;

pub use chart::{Chart, DEVIATIONS, Ink, Line};

/// The energy of the terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Energy {
    /// The terms, those that no light has come to among them.
    pub terms: Vec<TermEnergy>,
    /// How they decay, if enough of them are known.
    pub decay: Option<Decay>,
}

/// What a term is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TermEnergy {
    /// Which one, the tail last.
    pub part: View,
    /// Its share of the mean luminance of L.
    pub share: f64,
    /// The standard error of the share, if pixels are independent of each other; those that share
    /// photons are not, and have a larger one. `None` where it is not known.
    pub error: Option<f64>,
}

/// A geometric series that was fitted to the later terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// What is left from one bounce to the next, with its standard error.
    pub ratio: [f64; 2],
    /// The share of term number 0, if the series went on downwards like this.
    pub at_zero: f64,
    /// The first term that it was fitted to,
    pub first: usize,
    /// and the last one.
    pub last: usize,
    /// The share of all bounces beyond those that were computed, with its standard error; `None` if
    /// the ratio may be 1 or more.
    pub beyond: Option<[f64; 2]>,
}

/// Terms of a fit, at least.
const FEWEST: usize = 3;
/// A term is no part of a fit if its relative error is larger than this.
const WORST: f64 = 0.25;
/// No term is better known than this: the decay is not quite geometric.
const BEST: f64 = 1e-3;

impl Energy {
    /// From the shares of the layers in L and their relative errors of a pixel, tail last, as a
    /// film has them.
    #[must_use]
    pub fn of(shares: &[f64], errors: &[Option<f64>], n_pixels: usize, max_bounces: u32) -> Self {
        let n = shares.len().saturating_sub(1);
        let root = (n_pixels.max(1) as f64).sqrt();
        let has_tail = max_bounces as usize >= n;
        let n_terms = n.min(max_bounces as usize + 1);
        let parts = (0..n_terms)
            .map(View::Term)
            .chain(has_tail.then_some(View::Tail));
        let terms: Vec<_> = parts
            .map(|part| {
                let layer = if let View::Term(k) = part { k } else { n };
                let share = shares[layer];
                let error = errors.get(layer).copied().flatten();
                TermEnergy {
                    part,
                    share,
                    error: error.map(|relative| share * relative / root),
                }
            })
            .collect();
        Self {
            decay: Decay::fit(&terms[..n_terms.min(terms.len())], max_bounces),
            terms,
        }
    }

    /// What a person should know of the decay, in a sentence or two.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Some(decay) = self.decay else {
            return "Too few terms are known well enough to say how they decay.".to_owned();
        };
        let percent = |[value, error]: [f64; 2]| {
            let (value, error) = (100.0 * value, 100.0 * error);
            format!("{} % ± {} %", significant(value, 3), significant(error, 1))
        };
        let kept = percent(decay.ratio);
        let beyond = decay.beyond.map_or_else(
            || "What lies beyond the last bounce cannot be said.".to_owned(),
            |beyond| format!("Beyond the last bounce lies {} of L.", percent(beyond)),
        );
        format!("Each bounce keeps {kept} of the light of the one before. {beyond}")
    }

    /// A line for each term: its name, its share, the standard error of that.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut csv = "term,share,standard error\n".to_owned();
        for TermEnergy { part, share, error } in &self.terms {
            let error = error.map(|error| error.to_string()).unwrap_or_default();
            // Writing to a string cannot fail.
            let _ = writeln!(csv, "{part},{share},{error}");
        }
        csv
    }
}

impl Decay {
    /// The share of a bounce by the fit.
    #[must_use]
    pub fn share(&self, bounce: f64) -> f64 {
        self.at_zero * self.ratio[0].powf(bounce)
    }

    /// Fits the later half of the terms that are known well, since the first ones still depend on
    /// where the lights are.
    fn fit(terms: &[TermEnergy], max_bounces: u32) -> Option<Self> {
        let known = |term: &TermEnergy| {
            let error = term.error.filter(|_| term.share > 0.0)? / term.share;
            (error <= WORST).then_some(error.max(BEST))
        };
        let known: Vec<(usize, f64, f64)> = terms
            .iter()
            .enumerate()
            .skip(1)
            .filter_map(|(k, term)| Some((k, term.share.ln(), known(term)?)))
            .collect();
        if known.len() < FEWEST {
            return None;
        }
        let n = known.len().div_ceil(2).max(FEWEST);
        let fitted = &known[known.len() - n..];
        // Least squares about the weighted middle, where slope and height are independent.
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            fitted
                .iter()
                .map(|(k, y, e)| of(*k as f64, *y) / (e * e))
                .sum()
        };
        let weight = sum(&|_, _| 1.0);
        let [middle, height] = [sum(&|x, _| x), sum(&|_, y| y)].map(|s| s / weight);
        let spread = sum(&|x, _| (x - middle).powi(2));
        let slope = sum(&|x, y| (x - middle) * (y - height)) / spread;
        let misfit = sum(&|x, y| (y - height - slope * (x - middle)).powi(2));
        // Where the terms scatter more than their errors say, the errors are too small.
        let inflation = (misfit / (n as f64 - 2.0)).max(1.0);
        let [of_slope, of_height] = [spread, weight].map(|w| (inflation / w).sqrt());
        let ratio = slope.exp();
        let at_zero = (height - slope * middle).exp();
        let next = f64::from(max_bounces) + 1.0;
        let beyond = (slope + 2.0 * of_slope < 0.0).then(|| {
            let sum = (height + slope * (next - middle)).exp() / (1.0 - ratio);
            let by_slope = of_slope * (next - middle + ratio / (1.0 - ratio));
            [sum, sum * by_slope.hypot(of_height)]
        });
        Some(Self {
            ratio: [ratio, ratio * of_slope],
            at_zero,
            first: fitted[0].0,
            last: fitted[n - 1].0,
            beyond,
        })
    }
}

#[cfg(test)]
mod tests {
    use neumann_core::film::View;

    use super::{Decay, Energy};

    /// Shares of a series of which the ratio is known, with its tail up to bounce 16.
    fn geometric(ratio: f64, n: usize, error: f64) -> Energy {
        let mut shares: Vec<f64> = (0..n as i32)
            .map(|k| (1.0 - ratio) * ratio.powi(k))
            .collect();
        shares.push(ratio.powi(n as i32) - ratio.powi(17));
        // A hundred pixels.
        let errors = vec![Some(10.0 * error); n + 1];
        Energy::of(&shares, &errors, 100, 16)
    }

    #[test]
    fn a_geometric_series_is_found() {
        for ratio in [0.3, 0.5, 0.9] {
            let energy = geometric(ratio, 8, 0.01);
            assert_eq!(energy.terms.len(), 9);
            assert_eq!(energy.terms[8].part, View::Tail);
            let decay = energy.decay.unwrap();
            assert!((decay.ratio[0] - ratio).abs() < 1e-9, "{decay:?}");
            assert_eq!([decay.first, decay.last], [4, 7]);
            assert!((decay.share(5.0) / energy.terms[5].share - 1.0).abs() < 1e-9);
            let [beyond, error] = decay.beyond.unwrap();
            assert!((beyond / ratio.powi(17) - 1.0).abs() < 1e-9, "{decay:?}");
            assert!(error > 0.0 && energy.sentence().starts_with("Each bounce keeps"));
        }
    }

    /// The interval holds the ratio about as often as it should.
    #[test]
    fn errors_of_the_ratio_are_right() {
        let (ratio, error) = (0.6f64, 0.05);
        let mut state = 7u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as f64 / f64::from(1u32 << 31)
        };
        let mut n_within = 0;
        for _ in 0..400 {
            let mut energy = geometric(ratio, 8, error);
            for term in &mut energy.terms[..8] {
                let normal = (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
                term.share *= 1.0 + error * normal;
            }
            let decay = Decay::fit(&energy.terms[..8], 16).unwrap();
            n_within += u32::from((decay.ratio[0] - ratio).abs() < 1.96 * decay.ratio[1]);
        }
        // The errors are those that were stated or larger.
        assert!((370..400).contains(&n_within), "{n_within}");
    }

    #[test]
    fn what_is_not_known_is_not_said() {
        let unknown = Energy::of(&[0.5, 0.25, 0.2, 0.05], &[None; 4], 100, 16);
        assert_eq!(unknown.decay, None);
        assert!(unknown.sentence().starts_with("Too few"));
        let short = Energy::of(&[0.5, 0.3, 0.2, 0.0], &[Some(0.1); 4], 100, 1);
        assert_eq!(short.terms.len(), 2, "no more than were computed");
        assert_eq!(short.csv().lines().count(), 3);
        // A ratio that may be 1 has no sum.
        let level = Energy::of(&[0.2; 6], &[Some(1.0); 6], 100, 16);
        assert_eq!(level.decay.unwrap().beyond, None);
    }
}
