//! Curves of errors over time as they are drawn: logarithmic axes, their ticks, and the slope that
//! an unbiased method has. Whoever draws puts the unit square where it likes.

use super::{Measure, Point};
use crate::axis::Axis;

/// Axes that hold all curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Processor time.
    pub seconds: Axis,
    /// The error.
    pub error: Axis,
    /// A straight line of the slope of an unbiased method, in the unit square.
    pub guide: [[f64; 2]; 2],
    measure: Measure,
}

impl Chart {
    /// Axes for these curves; `None` while there is nothing to draw.
    #[must_use]
    pub fn new(curves: &[&[Point]], measure: Measure) -> Option<Self> {
        let points = || curves.iter().copied().flatten();
        let seconds = Axis::around(points().map(|point| point.seconds))?;
        let error = Axis::around(points().map(|point| measure.of(&point.comparison)))?;
        let guide = guide(&seconds, &error, measure.slope());
        Some(Self {
            seconds,
            error,
            guide,
            measure,
        })
    }

    /// Where a point is in the unit square, from the lower left; `None` if it has no logarithm.
    #[must_use]
    pub fn place(&self, point: &Point) -> Option<[f64; 2]> {
        let error = self.measure.of(&point.comparison);
        Some([self.seconds.place(point.seconds)?, self.error.place(error)?])
    }
}

/// A line of a slope beside curves that fall from the upper left corner of the unit square.
fn guide(seconds: &Axis, error: &Axis, slope: f64) -> [[f64; 2]; 2] {
    let steepness = slope * seconds.decades() / error.decades();
    let from = [0.42, 0.84];
    let across = (0.5f64).min(-0.6 / steepness);
    [from, [from[0] + across, from[1] + steepness * across]]
}

/// Colours that colour-blind people tell apart (Okabe and Ito, 2008), for a dark or a light ground.
#[must_use]
pub fn colours(is_dark: bool) -> [[u8; 3]; super::MOST] {
    const SKY_BLUE: [u8; 3] = [86, 180, 233];
    const ORANGE: [u8; 3] = [230, 159, 0];
    const GREEN: [u8; 3] = [0, 158, 115];
    const PURPLE: [u8; 3] = [204, 121, 167];
    const BLUE: [u8; 3] = [0, 114, 178];
    const VERMILION: [u8; 3] = [213, 94, 0];
    if is_dark {
        [SKY_BLUE, ORANGE, GREEN, PURPLE]
    } else {
        [BLUE, VERMILION, GREEN, PURPLE]
    }
}

#[cfg(test)]
mod tests {
    use super::super::curve::tests::point;
    use super::{Chart, Measure, Point};

    fn chart(points: &[Point], measure: Measure) -> Chart {
        Chart::new(&[points], measure).expect("there is something to draw")
    }

    #[test]
    fn curves_lie_in_the_square_and_fall_by_the_slope_of_the_guide() {
        let points: Vec<Point> = (0..8)
            .map(|i| 0.1 * 2f64.powi(i))
            .map(|seconds| point(seconds, 0.03 / seconds))
            .collect();
        for measure in Measure::ALL {
            let chart = chart(&points, measure);
            let places: Vec<_> = points.iter().filter_map(|p| chart.place(p)).collect();
            assert_eq!(places.len(), 8);
            for [x, y] in places.iter().chain(&chart.guide) {
                assert!(
                    (0.0..=1.0).contains(x) && (0.0..=1.0).contains(y),
                    "{x} {y}"
                );
            }
            let steepness = |[a, b]: [[f64; 2]; 2]| (b[1] - a[1]) / (b[0] - a[0]);
            let curve = steepness([places[0], places[7]]);
            let guide = steepness(chart.guide);
            assert!((curve - guide).abs() < 1e-9, "{curve} {guide}");
        }
    }

    #[test]
    fn axes_have_ticks_whatever_their_length() {
        for n_decades in [0.0, 0.1, 1.0, 3.0, 9.0, 40.0] {
            let points = [point(1.0, 1.0), point(2.0, 10f64.powf(-n_decades))];
            let axis = chart(&points, Measure::RelMse).error;
            let labels = axis.ticks.iter().filter(|tick| !tick.label.is_empty());
            let n = labels.count();
            assert!((1..=8).contains(&n), "{n_decades}: {n}");
            let mut at = axis.ticks.iter().map(|tick| tick.at);
            assert!(at.all(|at| (0.0..=1.0).contains(&at)));
        }
        let axis = chart(&[point(0.07, 1.0), point(3.0, 1.0)], Measure::RelMse).seconds;
        let labels: Vec<_> = axis.ticks.iter().map(|tick| tick.label.as_str()).collect();
        assert_eq!(labels, ["0.1", "0.2", "0.5", "1", "2"]);
        assert!((axis.value(axis.ticks[3].at) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_has_no_logarithm_is_left_out() {
        assert_eq!(Chart::new(&[], Measure::RelMse), None);
        assert_eq!(Chart::new(&[&[point(1.0, 0.0)]], Measure::RelMse), None);
        let points = [point(1.0, 0.5), point(2.0, 0.0), point(3.0, f64::NAN)];
        let chart = chart(&points, Measure::RelMse);
        assert!(chart.place(&points[0]).is_some());
        assert_eq!(chart.place(&points[1]), None);
        assert_eq!(chart.place(&points[2]), None);
    }
}
