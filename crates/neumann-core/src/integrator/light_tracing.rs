//! Light tracing: path tracing read backwards.
//!
//! Particles start at the lights and carry their share of the power; what scatters where they land
//! is sent to the lens, if it is seen from there. The walk is that of the path tracer, with
//! importance for radiance, and pixels are found instead of chosen. It is the light end of
//! bidirectional path tracing by itself: one technique, of weight 1.

use super::bidirectional::{LightEnd, MisWeights, ToLens, numbered};
use super::{Integrator, Method, Parameter, ParameterKind, ParameterValues, PassIntegrator, Sight};
use crate::pass::{Cancelled, Pass};
use crate::scene::Scene;

/// The row of the registry.
pub static METHOD: Method = Method {
    id: "lt",
    title: "light",
    name: "Light tracing",
    about: "Particles walk from the lights, and every surface they land on is aimed at the lens: \
            caustics come out clean.",
    blind_spots: "Mirrors and smooth glass seen directly or by way of each other: the lens \
                  cannot be aimed at through them. \
                  Unlit surfaces, and for an orthographic camera the sky.",
    formula: "I ≈ Σ W_e G V f Φ / N,  Φ ≈ the light that arrives",
    pseudo_code: include_str!("pseudo_code/lt.txt"),
    sight: Sight {
        delta_to_camera: false,
        ..Sight::FULL
    },
    bias: None,
    has_techniques: false,
    has_photons: false,
    parameters: &[ROULETTE],
    build: |values: &ParameterValues| {
        Integrator::Passes(Box::new(LightTracing {
            has_roulette: values.switch(ROULETTE.name),
        }))
    },
};

/// Whether long paths end by chance.
pub(super) const ROULETTE: Parameter = Parameter {
    name: "roulette",
    title: "Russian roulette",
    unit: "",
    about: "End long paths by chance, in proportion to what they could still carry.",
    kind: ParameterKind::Switch { default: true },
};

struct LightTracing {
    has_roulette: bool,
}

impl PassIntegrator for LightTracing {
    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled> {
        // As many paths as pixels, so that an iteration is as much work as that of a path tracer.
        let n_paths = pass.n_pixels();
        let light = LightEnd {
            scene,
            camera: pass.camera(),
            n_paths,
            max_bounces: pass.max_bounces(),
            has_roulette: self.has_roulette,
            to_lens: ToLens::Aimed,
            weighing: MisWeights::one_technique(),
        };
        let numbers = pass.light_numbers(n_paths);
        pass.trace_light_paths_together(scene, n_paths, numbers, |paths, tracer, sink| {
            light.trace(numbered(paths), tracer, sink, |_, _| ());
        })
    }
}
