//! Path tracing with multiple importance sampling.
//!
//! The last one plus one idea: light is both aimed at and run into, and each way is weighed by how
//! well it samples the direction, `w_i = p_i² / (p_1² + p_2²)` ([Veach 1997] 9.2.3.2). A sky of
//! one radiance is not aimed at: the BSDF samples it as it counts. Where there are mirrors or
//! glass, a diffuse surface sends them some of its paths ([`crate::transport::specular_casters`]).
//! Where such a sky is the only light, a path splits in two at its first surface: nearly all of the
//! error is in what of the sky is seen from there. Long paths end by Russian roulette on their
//! throughput.
//!
//! `lanes` has the order of a step, for sixteen paths side by side; `alone` the same for a path by
//! itself.

mod alone;
mod lanes;
pub(crate) mod onward;
mod walk;

use crate::endpoint::LightChoice;
use crate::integrator::{
    Integrator, Method, Parameter, ParameterKind, ParameterValues, PixelIntegrator, Shot, Sight,
};
use crate::pass::{PixelSink, Pixels};
use crate::scene::Scene;
use crate::transport::Tracer;

use super::nee::{LIGHTS, light_choice};
use walk::{N_SPLITS, PathTracer};

/// The row of the registry.
pub static METHOD: Method = Method {
    id: "pt-mis",
    title: "PT mis",
    name: "Path tracing, multiple importance sampling",
    about: "Lights are aimed at and run into, each way weighed by how well it samples the \
            direction: \
            small lights and sharp reflections both come out clean.",
    blind_spots: "Lights without extent by way of a mirror or smooth glass: neither can be aimed \
                  at the other.",
    formula: "T L_e ≈ Σ w_i f cos θ L_e / p_i,  w_i = p_i² / Σ p_j²",
    pseudo_code: include_str!("../../pseudo_code/pt-mis.txt"),
    sight: Sight::FULL,
    bias: None,
    has_techniques: true,
    has_photons: false,
    parameters: &[
        Parameter {
            name: "roulette",
            title: "Russian roulette",
            unit: "",
            about: "End long paths by chance, in proportion to what they could still carry.",
            kind: ParameterKind::Switch { default: true },
        },
        LIGHTS,
        SPECULAR_CASTERS,
        ADAPTIVE,
    ],
    build: |values: &ParameterValues| {
        Integrator::Pixels(Box::new(Mis {
            choice: match light_choice(values) {
                LightChoice::Tree => LightChoice::TreeBesideBsdf,
                choice => choice,
            },
            has_roulette: values.switch("roulette"),
            aims_at_specular_casters: values.switch(SPECULAR_CASTERS.name),
            is_adaptive: values.switch(ADAPTIVE.name),
        }))
    },
};

/// Whether paths are sent to mirrors and glass.
const SPECULAR_CASTERS: Parameter = Parameter {
    name: "casters",
    title: "Aim at mirrors",
    unit: "",
    about: "Diffuse surfaces send up to a quarter of their paths to mirrors and smooth glass, \
            where caustics come from.",
    kind: ParameterKind::Switch { default: true },
};

struct Mis {
    choice: LightChoice,
    has_roulette: bool,
    aims_at_specular_casters: bool,
    is_adaptive: bool,
}

/// Whether more paths go where the picture is noisy.
const ADAPTIVE: Parameter = Parameter {
    name: "adaptive",
    title: "Adaptive sampling",
    unit: "",
    about: "Four paths a pixel and iteration, from the fifth iteration on more of them where the \
            first four were noisy. \
            Unbiased: what was measured and what is sampled by it have random numbers of their \
            own.",
    kind: ParameterKind::Switch { default: false },
};

impl PixelIntegrator for Mis {
    fn trace(
        &self,
        shot: &Shot<'_>,
        pixels: Pixels<'_>,
        tracer: &mut Tracer<'_>,
        sink: &mut PixelSink<'_>,
    ) {
        let scene = tracer.scene;
        let walk = PathTracer {
            scene,
            max_bounces: shot.max_bounces,
            splits: PathTracer::splits_in(scene),
            choice: self.choice,
            has_roulette: self.has_roulette,
            specular_casters: if self.aims_at_specular_casters {
                scene.specular_casters()
            } else {
                &[]
            },
        };
        lanes::trace(&walk, shot.camera, pixels, tracer, sink);
    }

    fn n_splits(&self, scene: &Scene) -> u8 {
        if PathTracer::splits_in(scene) {
            N_SPLITS
        } else {
            1
        }
    }

    fn is_adaptive(&self) -> bool {
        self.is_adaptive
    }
}
