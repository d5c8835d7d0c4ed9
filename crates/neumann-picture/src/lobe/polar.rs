//! A polar plot in the unit circle: x to the right, where light is mirrored to, and y along the
//! normal. Whoever draws puts the circle where it likes.

use neumann_core::render::lobe::{PolarPoint, Viewed};

use super::{DECADES, Plot, Plotted, Radius, largest};
use crate::figures::significant;

/// A ring with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// Its radius, at most 1.
    pub radius: f32,
    /// Its value.
    pub label: String,
}

/// A mirror-like lobe.
#[derive(Clone, Copy, Debug)]
pub struct Arrow {
    /// Its tip.
    pub tip: [f32; 2],
    /// The share of the light that it scatters, luminance.
    pub share: f32,
}

/// A polar plot.
#[derive(Clone, Debug)]
pub struct PolarChart {
    /// Values, a line on either side of the surface: first the viewer's.
    pub curves: [Vec<[f32; 2]>; 2],
    /// The density of directions, scaled to the integral of the values; empty where values stand
    /// without their cosine, which no density has.
    pub densities: [Vec<[f32; 2]>; 2],
    /// Rings, innermost first.
    pub rings: Vec<Ring>,
    /// Mirror-like lobes.
    pub arrows: Vec<Arrow>,
    /// The direction to the viewer.
    pub viewer: [f32; 2],
    /// True if there is something on the other side of the surface.
    pub is_whole: bool,
}

/// Values below this share of the largest are drawn as none, where they end a curve.
const NONE: f32 = 1e-9;

impl PolarChart {
    /// Plots a view.
    #[must_use]
    pub fn new(view: &Viewed, plot: Plot) -> Self {
        let most = largest(view, plot.plotted);
        let side = 1f32.copysign(view.wo.z);
        let line = |is_behind: bool, value: &dyn Fn(&PolarPoint) -> f32| -> Vec<[f32; 2]> {
            let mut here: Vec<&PolarPoint> = view.polar.iter().collect();
            here.retain(|p| (p.wi.z * side < 0.0) == is_behind);
            // The side of negative z begins and ends in the middle of the list.
            let turned = |p: &PolarPoint| {
                let angle = p.angle.to_radians();
                if p.wi.z < 0.0 {
                    angle.rem_euclid(std::f32::consts::TAU)
                } else {
                    angle
                }
            };
            here.sort_by(|a, b| turned(a).total_cmp(&turned(b)));
            here.dedup_by(|a, b| turned(a) == turned(b));
            let place = |p: &&PolarPoint| {
                let radius = plot.radius.of(value(p) / most.max(f32::MIN_POSITIVE));
                [p.wi.x * radius, p.wi.z * radius]
            };
            let is_seen = here.iter().any(|p| value(p) > NONE * most);
            if is_seen {
                here.iter().map(place).collect()
            } else {
                Vec::new()
            }
        };
        let value = |p: &PolarPoint| plot.plotted.of(p.f, p.wi.z).max_channel();
        let sides = [false, true];
        let curves = sides.map(|is_behind| line(is_behind, &value));
        let integrals = &view.integrals;
        let scale = integrals.f_cos / integrals.pdf_w.max(1e-9);
        let density = |p: &PolarPoint| p.pdf_w * scale as f32;
        let densities = sides.map(|is_behind| match plot.plotted {
            Plotted::Product => line(is_behind, &density),
            Plotted::Value => Vec::new(),
        });
        let arrow = |lobe: &neumann_core::render::lobe::DeltaLobe| {
            let share = lobe.share.luminance();
            let radius = plot.radius.of(share);
            Arrow {
                tip: [lobe.wi.x * radius, lobe.wi.z * radius],
                share,
            }
        };
        Self {
            curves,
            densities,
            rings: rings(most, plot.radius),
            arrows: view.drawn.deltas.iter().map(arrow).collect(),
            viewer: [view.wo.x, view.wo.z],
            is_whole: view.drawn.is_transmissive,
        }
    }
}

/// Rings with their values; the outermost is the largest value, or all of the light where there are
/// mirror-like lobes alone.
fn rings(most: f32, radius: Radius) -> Vec<Ring> {
    if most <= 0.0 {
        return vec![Ring {
            radius: 1.0,
            label: "100 %".to_owned(),
        }];
    }
    let label = |value: f32, figures| significant(f64::from(value), figures);
    match radius {
        Radius::Linear => vec![
            Ring {
                radius: 0.5,
                label: label(0.5 * most, 2),
            },
            Ring {
                radius: 1.0,
                label: label(most, 2),
            },
        ],
        Radius::Logarithmic => {
            let n = DECADES as i32;
            let ring = |i: i32| {
                let share = 10f32.powi(-i);
                Ring {
                    radius: radius.of(share),
                    label: label(most * share, 2),
                }
            };
            (0..n).rev().map(ring).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::PolarChart;
    use crate::lobe::tests::grey;
    use crate::lobe::{Plot, Plotted, Radius};

    #[test]
    fn a_grey_surface_is_a_half_circle_and_with_its_cosine_a_circle() {
        let lobes = grey();
        let view = &lobes.views[1];
        let plot = |plotted| Plot {
            plotted,
            radius: Radius::Linear,
        };
        let chart = PolarChart::new(view, plot(Plotted::Value));
        let [curve, behind] = &chart.curves;
        assert!(behind.is_empty() && chart.densities[0].is_empty() && !chart.is_whole);
        for [x, y] in curve {
            assert!((x.hypot(*y) - 1.0).abs() < 1e-4 && *y > 0.0);
        }
        let (first, last) = (curve[0], curve[curve.len() - 1]);
        assert!(
            first[0] < -0.99 && last[0] > 0.99,
            "from the viewer's side on"
        );
        let chart = PolarChart::new(view, plot(Plotted::Product));
        for line in [&chart.curves[0], &chart.densities[0]] {
            for [x, y] in line {
                assert!((x.hypot(y - 0.5) - 0.5).abs() < 1e-3, "{x} {y}");
            }
        }
        assert!((chart.viewer[0] + 0.5).abs() < 1e-6);
        let labels: Vec<&str> = chart.rings.iter().map(|r| r.label.as_str()).collect();
        assert_eq!(labels, ["0.08", "0.16"]);
    }
}
