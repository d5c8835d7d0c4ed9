//! The albedo over the angle of the viewer, in the unit square: 0 below and on the left. Whoever
//! draws puts it where it likes.

use neumann_core::render::lobe::Lobes;

/// Degrees at the right end.
const RIGHT: f32 = 90.0;

/// Curves over the angle.
#[derive(Clone, Debug)]
pub struct AlbedoChart {
    /// The albedo: red, green, blue.
    pub channels: [Vec<[f32; 2]>; 3],
    /// Its luminance.
    pub all: Vec<[f32; 2]>,
    /// What mirror-like lobes scatter; empty if there are none.
    pub specular: Vec<[f32; 2]>,
    /// The mean over drawn directions with its interval: place, lower and upper end.
    pub sampled: Vec<[f32; 3]>,
    /// Angles with their places.
    pub ticks: Vec<(f32, String)>,
    /// True if the channels are apart.
    pub is_coloured: bool,
}

impl AlbedoChart {
    /// Of the whole curve.
    #[must_use]
    pub fn new(lobes: &Lobes) -> Self {
        let across = |angle: f32| angle / RIGHT;
        let all = || lobes.albedo.iter();
        let of = |value: &dyn Fn(&neumann_core::render::lobe::AlbedoAt) -> f32| {
            all().map(|at| [across(at.angle), value(at)]).collect()
        };
        let channels = [0, 1, 2].map(|i| of(&|at| at.albedo.to_array()[i]));
        let is_apart = |at: &neumann_core::render::lobe::AlbedoAt| {
            let grey = at.albedo.mean();
            (at.albedo.max_channel() - grey).abs() > 5e-3
        };
        let has_specular = all().any(|at| !at.specular.is_black());
        let luminance = |at: &neumann_core::render::lobe::AlbedoAt| at.specular.luminance();
        let sampled = all().map(|at| {
            let half = 1.96 * at.standard_error;
            let ends = [at.sampled - half, at.sampled + half].map(|v| v as f32);
            [across(at.angle), ends[0], ends[1]]
        });
        let ticks = (0..=3).map(|i| 30.0 * i as f32);
        Self {
            channels,
            all: of(&|at| at.albedo.luminance()),
            specular: if has_specular {
                of(&luminance)
            } else {
                Vec::new()
            },
            sampled: sampled.collect(),
            ticks: ticks.map(|a| (across(a), format!("{a}°"))).collect(),
            is_coloured: all().any(is_apart),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::AlbedoChart;
    use crate::lobe::tests::grey;

    #[test]
    fn a_grey_surface_scatters_half_of_it_everywhere() {
        let chart = AlbedoChart::new(&grey());
        assert!(!chart.is_coloured && chart.specular.is_empty());
        assert_eq!(chart.all[0][0], 0.0);
        assert!(chart.all.last().is_some_and(|at| at[0] > 0.98));
        for ([_, value], [_, low, high]) in chart.all.iter().zip(&chart.sampled) {
            assert!((value - 0.5).abs() < 1e-5);
            assert!(*low < value + 1e-5 && *high > value - 1e-5, "{low} {high}");
        }
        let labels: Vec<&str> = chart.ticks.iter().map(|(_, l)| l.as_str()).collect();
        assert_eq!(labels, ["0°", "30°", "60°", "90°"]);
    }
}
