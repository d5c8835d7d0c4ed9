//! How the estimates of one number come together, as it is drawn: the mean of each over the number
//! of its paths, on a logarithmic axis, with the interval about it. Whoever draws puts the unit
//! square where it likes.

use neumann_core::render::Hemisphere;
use neumann_core::render::hemisphere::{Estimator, Moment};

/// Intervals from this place on are shown whole.
const SHOWN_WHOLE: f64 = 0.5;

/// The course of all estimators.
#[derive(Clone, Debug)]
pub struct Convergence {
    /// One for each, in their order.
    pub lines: Vec<Line>,
    /// Numbers of paths with their places, from 0 to 1.
    pub ticks: Vec<(f64, String)>,
    /// The least and the largest luminance.
    pub values: [f64; 2],
}

/// The course of one estimator, from the left to the right; 0 is below, and what lies beyond 0 or 1
/// is outside of the chart.
#[derive(Clone, Debug)]
pub struct Line {
    /// Whose it is.
    pub estimator: Estimator,
    /// Its means,
    pub mean: Vec<[f64; 2]>,
    /// and the ends of their intervals: place, lower and upper end.
    pub band: Vec<[f64; 3]>,
}

impl Convergence {
    /// `None` before there are means to be drawn.
    #[must_use]
    pub fn new(hemisphere: &Hemisphere) -> Option<Self> {
        let moments = Estimator::ALL.map(|e| hemisphere.estimate_by(e).moments());
        Self::of(&moments)
    }

    fn of(moments: &[Vec<Moment>; 3]) -> Option<Self> {
        let logarithm = |n: u32| f64::from(n).log2();
        let all = || moments.iter().flatten();
        let first = all().map(|m| m.n).min()?;
        let last = all().map(|m| m.n).max()?;
        let length = (logarithm(last) - logarithm(first)).max(1.0);
        let across = |n: u32| (logarithm(n) - logarithm(first)) / length;
        let shown = all().filter(|m| across(m.n) >= SHOWN_WHOLE || m.n == last);
        let ends = shown.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], m| {
            [
                least.min(m.mean - m.interval),
                most.max(m.mean + m.interval),
            ]
        });
        let least_width = 1e-3 * ends[1].abs().max(1e-6);
        let margin = (0.05 * (ends[1] - ends[0])).max(least_width);
        let values = [ends[0] - margin, ends[1] + margin];
        let up = |value: f64| (value - values[0]) / (values[1] - values[0]);
        let line = |(estimator, moments): (Estimator, &Vec<Moment>)| Line {
            estimator,
            mean: moments.iter().map(|m| [across(m.n), up(m.mean)]).collect(),
            band: moments
                .iter()
                .map(|m| {
                    [
                        across(m.n),
                        up(m.mean - m.interval),
                        up(m.mean + m.interval),
                    ]
                })
                .collect(),
        };
        let lines = Estimator::ALL.into_iter().zip(moments).map(line).collect();
        // Powers of four are enough.
        let powers = (2..16).map(|power| 1u32 << (2 * power));
        let ticks = powers.filter(|n| (first..=last).contains(n));
        let ticks = ticks.map(|n| (across(n), n.to_string())).collect();
        Some(Self {
            lines,
            ticks,
            values,
        })
    }

    /// Where a luminance is.
    #[must_use]
    pub fn up(&self, value: f64) -> f64 {
        (value - self.values[0]) / (self.values[1] - self.values[0])
    }
}

#[cfg(test)]
mod tests {
    use neumann_core::render::hemisphere::Moment;

    use super::Convergence;

    fn moments(scale: f64) -> Vec<Moment> {
        let moment = |n: u32| Moment {
            n,
            mean: 2.0 + scale / f64::from(n),
            interval: 4.0 / f64::from(n).sqrt(),
        };
        (4..12).map(|power| moment(1 << power)).collect()
    }

    #[test]
    fn means_come_together_within_their_bands() {
        let all = [1.0, -1.0, 0.0].map(moments);
        let chart = Convergence::of(&all).expect("moments");
        assert_eq!(chart.lines.len(), 3);
        for line in &chart.lines {
            assert_eq!(line.mean.len(), 8);
            let ([x0, _], [x1, y1]) = (line.mean[0], line.mean[7]);
            assert_eq!((x0, x1), (0.0, 1.0));
            assert!((y1 - chart.up(2.0)).abs() < 0.05, "{y1}");
            for ([x, mean], [place, low, high]) in line.mean.iter().zip(&line.band) {
                assert!(x == place && low < mean && mean < high);
                // The first, wide ones may reach out of the chart.
                assert!(*x < 0.5 || (*low >= 0.0 && *high <= 1.0), "{low} {high}");
            }
        }
        let labels: Vec<_> = chart
            .ticks
            .iter()
            .map(|(_, label)| label.as_str())
            .collect();
        assert_eq!(labels, ["16", "64", "256", "1024"]);
    }

    #[test]
    fn nothing_is_drawn_of_nothing_and_what_never_changes_has_a_height() {
        assert!(Convergence::of(&[Vec::new(), Vec::new(), Vec::new()]).is_none());
        let moment = |n| Moment {
            n,
            mean: 0.0,
            interval: 0.0,
        };
        let same = vec![moment(16), moment(32)];
        let chart = Convergence::of(&[same.clone(), same.clone(), same]).expect("moments");
        assert!(chart.values[1] > chart.values[0]);
    }
}
