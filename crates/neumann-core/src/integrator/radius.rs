//! Within which distance photons count, and how it shrinks.

use super::{Parameter, ParameterKind, ParameterValues};
use crate::scene::Scene;

/// A radius that shrinks from iteration to iteration.
#[derive(Clone, Copy, Debug)]
pub struct Radius {
    initial: f32,
    is_relative: bool,
    alpha: f32,
}

impl Radius {
    /// The initial radius.
    pub const INITIAL: Parameter = Parameter {
        name: "radius",
        title: "Radius",
        unit: "",
        about: "Photons within this distance count: a share of the scene's radius, or metres.",
        kind: ParameterKind::Real {
            default: 0.003,
            min: 1e-6,
            max: 10.0,
            is_logarithmic: true,
        },
    };
    /// What it is measured in.
    pub const UNIT: Parameter = Parameter {
        name: "radius-unit",
        title: "Radius in",
        unit: "",
        about: "Whether the radius is a share of the scene's radius or metres.",
        kind: ParameterKind::Choice {
            default: 0,
            options: &["scene", "metres"],
        },
    };
    /// How fast it shrinks.
    pub const ALPHA: Parameter = Parameter {
        name: "alpha",
        title: "Alpha",
        unit: "",
        about: "How slowly the radius shrinks: its square goes down with the iterations i like i^(alpha - 1); 1 keeps it.",
        kind: ParameterKind::Real {
            default: 0.75,
            min: 0.1,
            max: 1.0,
            is_logarithmic: false,
        },
    };

    /// Reads the parameters; without alpha among them, it stays as it is.
    #[must_use]
    pub fn of(values: &ParameterValues) -> Self {
        Self {
            initial: values.real(Self::INITIAL.name) as f32,
            is_relative: values.choice(Self::UNIT.name) == 0,
            alpha: values
                .value(Self::ALPHA.name)
                .map_or(1.0, |_| values.real(Self::ALPHA.name) as f32),
        }
    }

    /// The radius of iteration number `iteration`, metres: `r = r_1 (i + 1)^((α - 1) / 2)`, which is how that of Knaus and
    /// Zwicker 2011 shrinks in the end, and depends on the number of the iteration alone.
    #[must_use]
    pub fn at(&self, scene: &Scene, iteration: u32) -> f32 {
        let unit = if self.is_relative {
            scene.lights().bounds().radius
        } else {
            1.0
        };
        let shrunk = (f64::from(iteration) + 1.0).powf(0.5 * (f64::from(self.alpha) - 1.0));
        // What is smaller than rounding merges nothing and divides by zero.
        (self.initial * unit * shrunk as f32).max(1e-6 * unit)
    }
}
