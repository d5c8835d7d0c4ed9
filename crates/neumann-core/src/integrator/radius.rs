//! Within which distance photons count, and how it shrinks.

use glam::{Vec2, Vec3};

use super::{Parameter, ParameterKind, ParameterValues};
use crate::endpoint::Camera;
use crate::scene::Scene;
use crate::transport::Tracer;

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
        about: "Photons within this distance count: a share of the scene's radius, less where \
                the camera sees \
                a small part, or metres.",
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
        title: "Radius unit",
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
        about: "How slowly the radius shrinks: its square goes down with the iterations i like \
                i^(alpha - 1); 1 keeps it.",
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

    /// The radius of iteration number `iteration`, metres: `r = r_1 (i + 1)^((α - 1) / 2)`, which
    /// is how that of Knaus and Zwicker 2011 shrinks in the end, and depends on the number of the
    /// iteration alone. A relative radius is a share of the scene's radius, or of 48 times what
    /// `camera` sees, which is less where a small thing stands on a wide floor; but no less than a
    /// pixel is wide there, or photons would be too few.
    #[must_use]
    pub fn at(&self, scene: &Scene, camera: &Camera, iteration: u32) -> f32 {
        let initial = if self.is_relative {
            let whole = self.initial * scene.lights().bounds().radius;
            radius_seen(scene, camera).map_or(whole, |seen| {
                let (width, height) = camera.raster_size();
                let pixel = WIDTH_SEEN * seen / width.min(height);
                (self.initial * SEEN * seen).max(pixel).min(whole)
            })
        } else {
            self.initial
        };
        let shrunk = (f64::from(iteration) + 1.0).powf(0.5 * (f64::from(self.alpha) - 1.0));
        // What is smaller than rounding merges nothing and divides by zero.
        initial * (shrunk as f32).max(1e-4)
    }
}

/// What the camera sees counts as so many times wider, so that a view of a whole scene leaves the
/// scene's radius as it is.
const SEEN: f32 = 48.0;
/// Width of a disk over the median distance of its points from the middle: `2 √2`.
const WIDTH_SEEN: f32 = 2.828;

/// Rays that ask what the camera sees, along each side of the film.
const N_RAYS: usize = 16;

/// Median distance of what a camera sees from the middle of it, metres; `None` where it sees
/// nothing or a single point.
fn radius_seen(scene: &Scene, camera: &Camera) -> Option<f32> {
    let mut tracer = Tracer::new(scene);
    let (width, height) = camera.raster_size();
    let cell = Vec2::new(width, height) / N_RAYS as f32;
    let mut seen = Vec::with_capacity(N_RAYS * N_RAYS);
    for i in 0..N_RAYS * N_RAYS {
        let raster = Vec2::new((i % N_RAYS) as f32 + 0.5, (i / N_RAYS) as f32 + 0.5) * cell;
        let ray = camera.ray(raster, [0.5; 2]).ray;
        if let Some(hit) = tracer.hit(&ray) {
            seen.push(tracer.surface_vertex(&ray, &hit).point.position);
        }
    }
    let middle = Vec3::from_array([0, 1, 2].map(|axis| median(seen.iter().map(|p| p[axis]))));
    let radius = median(seen.iter().map(|p| p.distance(middle)));
    (radius > 0.0).then_some(radius)
}

/// The upper median; 0 of nothing.
fn median(values: impl Iterator<Item = f32>) -> f32 {
    let mut values: Vec<f32> = values.collect();
    let half = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(half, f32::total_cmp).1
}
