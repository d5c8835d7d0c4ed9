//! A BSDF as it is looked at: polar plots, lobes in space, disks, figures and a table. What the
//! command and the window have in common.

mod albedo;
mod disk;
mod polar;
mod solid;
mod table;

pub use albedo::AlbedoChart;
pub use disk::Disk;
pub use polar::{Arrow, PolarChart, Ring};
pub use solid::{SolidStyle, Turn, draw};
pub use table::csv;

use neumann_core::radiometry::Rgb;
use neumann_core::render::lobe::{Lobes, Viewed};

use crate::figures::{Figure, significant};

/// What is plotted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plotted {
    /// `f`, 1/sr.
    #[default]
    Value,
    /// `f cos θ`, 1/sr.
    Product,
}

impl Plotted {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Value, Self::Product];

    /// Its formula.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Value => "f",
            Self::Product => "f cos θ",
        }
    }

    /// What it is, in a sentence.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::Value => "The BSDF itself, as it is defined.",
            Self::Product => {
                "The BSDF with the cosine of the found direction, as it stands in the reflection \
                 equation; dashes are the density of BSDF sampling, scaled to the same integral."
            }
        }
    }

    /// The value of a direction whose cosine with the normal is `z`.
    #[must_use]
    pub fn of(self, f: Rgb, z: f32) -> Rgb {
        match self {
            Self::Value => f,
            Self::Product => f * z.abs(),
        }
    }
}

/// How far from the middle a value is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Radius {
    /// By its size.
    #[default]
    Linear,
    /// By its logarithm, over [`DECADES`].
    Logarithmic,
}

/// Powers of ten from the middle to the outer ring of a logarithmic plot.
pub const DECADES: f32 = 4.0;

impl Radius {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Linear, Self::Logarithmic];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Logarithmic => "log",
        }
    }

    /// What it is, in a sentence.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::Linear => "Twice the value is drawn twice as far from the middle.",
            Self::Logarithmic => {
                "Ten times the value is one ring further out; the middle is a ten thousandth of \
                 the largest."
            }
        }
    }

    /// The distance of a share of the largest value, in [0, 1].
    #[must_use]
    pub fn of(self, share: f32) -> f32 {
        match self {
            Self::Linear => share.clamp(0.0, 1.0),
            Self::Logarithmic if share > 0.0 => (1.0 + share.log10() / DECADES).clamp(0.0, 1.0),
            Self::Logarithmic => 0.0,
        }
    }
}

/// How lobes are plotted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plot {
    /// What.
    pub plotted: Plotted,
    /// How far out.
    pub radius: Radius,
}

/// The largest value of a view, as it is plotted, in its brightest channel.
#[must_use]
pub fn largest(view: &Viewed, plotted: Plotted) -> f32 {
    let plane = view.polar.iter().map(|p| (p.f, p.wi.z));
    let solid = &view.solid;
    let sphere = solid.f.iter().copied();
    let all = plane.chain(sphere.zip(solid.directions.iter().map(|wi| wi.z)));
    all.map(|(f, z)| plotted.of(f, z).max_channel())
        .fold(0.0, f32::max)
}

/// A share in hundreds.
#[must_use]
pub fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 3))
}

/// What there is to say of a view.
#[must_use]
pub fn figures(view: &Viewed) -> Vec<Figure> {
    let at = view.albedo();
    let most = largest(view, Plotted::Product);
    let mut figures = vec![
        Figure {
            name: "albedo",
            text: percent(f64::from(at.albedo.luminance())),
            about: "Share of the light arriving from there that is scattered, luminance.",
        },
        Figure {
            name: "Σ p",
            text: significant(view.total_probability(), 4),
            about: "The density summed up over all directions, with the probabilities of \
                    mirror-like lobes and of no direction at all. It is 1 if directions are drawn \
                    with the density that is stated.",
        },
    ];
    if most > 0.0 {
        figures.push(Figure {
            name: "max f cos θ",
            text: format!("{} sr⁻¹", significant(f64::from(most), 3)),
            about: "The largest value with its cosine, mirror-like lobes not counted.",
        });
    }
    if view.drawn.refused > 0.0 {
        figures.push(Figure {
            name: "refused",
            text: percent(view.drawn.refused),
            about: "Share of draws that yield no direction: the facet that was drawn sends light \
                    below the surface.",
        });
    }
    if !view.drawn.deltas.is_empty() {
        figures.push(Figure {
            name: "specular",
            text: percent(at.specular_share()),
            about: "Share of the scattered light that leaves in mirror-like directions.",
        });
    }
    figures
}

/// What there is to say of both ways between two directions.
#[must_use]
pub fn reciprocity(lobes: &Lobes) -> String {
    let Some(found) = lobes.reciprocity else {
        return "reciprocity: mirror-like lobes alone, nothing to compare".to_owned();
    };
    let verdict = if found.holds() { "holds" } else { "fails" };
    let largest = significant(f64::from(found.largest), 2);
    format!(
        "reciprocity {verdict}: both ways between two directions, f differs by {largest} of itself \
         at most ({} pairs)",
        found.n_pairs
    )
}

#[cfg(test)]
pub(crate) mod tests {
    use neumann_core::bsdf::{Bsdf, Lambert};
    use neumann_core::radiometry::Rgb;
    use neumann_core::render::CancelToken;
    use neumann_core::render::lobe::{ANGLES, Lobes};

    use super::{Plotted, Radius, figures, largest, reciprocity};

    pub(crate) fn grey() -> Lobes {
        let albedo = Rgb::splat(0.5);
        let bsdf = Bsdf::Lambert(Lambert { albedo });
        Lobes::new(&bsdf, &ANGLES, false, &CancelToken::default()).expect("nobody cancels it")
    }

    #[test]
    fn ten_times_the_value_is_one_ring_further_out() {
        let radii = [1.0, 0.1, 0.01, 1e-4, 1e-9, 0.0].map(|s| Radius::Logarithmic.of(s));
        let expected = [1.0, 0.75, 0.5, 0.0, 0.0, 0.0];
        for (found, expected) in radii.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        assert_eq!(Radius::Linear.of(0.25), 0.25);
    }

    #[test]
    fn figures_of_a_grey_surface() {
        let lobes = grey();
        let view = &lobes.views[2];
        let f = 0.5 * std::f32::consts::FRAC_1_PI;
        for plotted in Plotted::ALL {
            assert!((largest(view, plotted) - f).abs() < 1e-6);
        }
        let texts: Vec<String> = figures(view).into_iter().map(|f| f.text).collect();
        assert_eq!(texts, ["50 %", "1", "0.159 sr⁻¹"]);
        assert!(reciprocity(&lobes).starts_with("reciprocity holds"));
    }
}
