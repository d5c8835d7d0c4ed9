//! The reflection equation at a surface point, as it is looked at: pictures over the hemisphere,
//! figures, and means on their way. What the command and the window have in common.

mod convergence;
mod panel;

pub use convergence::{Convergence, Line};
pub use panel::{Panel, PanelScale, about, formula, outline, ring, shows};

use neumann_core::render::hemisphere::{Estimator, Integrand};
use neumann_core::render::{Hemisphere, Measured};

use crate::figures::{Figure, significant};
use crate::race::colours;

/// The equation.
pub const EQUATION: &str = "L_{o} = L_{e} + ∫ L_{i} f cos θ dω";

/// What stands below the integral, in the order of the equation, and the product.
pub const INTEGRANDS: [Integrand; 4] = [
    Integrand::Incident,
    Integrand::Bsdf,
    Integrand::Cosine,
    Integrand::Product,
];

/// The densities of directions, in the order of the estimators.
pub const DENSITIES: [Integrand; 3] = [
    Integrand::Density(Estimator::Bsdf),
    Integrand::Density(Estimator::Light),
    Integrand::Density(Estimator::Mis),
];

/// The colour of an estimator, for a dark or a light ground.
#[must_use]
pub fn colour(estimator: Estimator, is_dark: bool) -> [u8; 3] {
    let [bsdf, light, mis, _] = colours(is_dark);
    match estimator {
        Estimator::Bsdf => bsdf,
        Estimator::Light => light,
        Estimator::Mis => mis,
    }
}

/// A mean with its interval, luminance.
#[must_use]
pub fn with_interval(measured: &Measured) -> String {
    let mean = significant(f64::from(measured.mean.luminance()), 4);
    match measured.interval {
        Some(interval) => format!("{mean} ± {}", significant(interval, 2)),
        None => mean,
    }
}

/// The integral by each estimator, in their order, and by the pictures.
#[must_use]
pub fn figures(hemisphere: &Hemisphere) -> Vec<Figure> {
    let of = |estimator: Estimator| Figure {
        name: estimator.name(),
        text: with_interval(&hemisphere.estimate_by(estimator).measured()),
        about: match estimator {
            Estimator::Bsdf => {
                "Directions are drawn from the BSDF; light counts where they run into it."
            }
            Estimator::Light => {
                "A light is aimed at; light that arrives scattered is found by the BSDF."
            }
            Estimator::Mis => "Both ways, each weighed by how densely it draws the direction.",
        },
    };
    let mut figures: Vec<Figure> = Estimator::ALL.into_iter().map(of).collect();
    figures.push(Figure {
        name: "pictures",
        text: with_interval(&hemisphere.integral()),
        about: "The product picture summed up over all directions, and what comes from points. \
                Directions are drawn anew within each of its pixels, so that its only error is \
                noise.",
    });
    figures
}

/// What is to be said of the directions that no picture has; `None` if there are none.
#[must_use]
pub fn points(hemisphere: &Hemisphere) -> Option<String> {
    let n_lights = hemisphere.points().iter().filter(|p| p.is_light).count();
    let n_lobes = hemisphere.points().len() - n_lights;
    let count = |n: usize, one: &str, many: &str| match n {
        0 => None,
        1 => Some(format!("one {one}")),
        n => Some(format!("{n} {many}")),
    };
    let lobes = count(n_lobes, "mirror-like direction", "mirror-like directions");
    let lights = count(n_lights, "light without extent", "lights without extent");
    let what: Vec<String> = [lobes, lights].into_iter().flatten().collect();
    if what.is_empty() {
        return None;
    }
    let value = with_interval(&hemisphere.sum_of_points());
    let what = what.join(" and ");
    Some(format!(
        "rings: {what}, points that no picture has; they bring {value}"
    ))
}
