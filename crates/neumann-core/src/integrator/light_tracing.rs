//! Light tracing: path tracing read backwards.
//!
//! Particles start at the lights and carry their share of the power; what scatters where they land is
//! sent to the lens, if it is seen from there. The walk is that of the path tracer, with
//! importance for radiance, and pixels are found instead of chosen.

use crate::integrator::bidirectional::connect::{see_light, splat};
use crate::integrator::bidirectional::{Walk, Weighing};
use crate::integrator::{Integrator, Method, Parameter, ParameterKind, ParameterValues, Sight};
use crate::render::{Cancelled, Pass};
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::transport::reflection::start_sample;

/// The row of the registry.
pub static METHOD: Method = Method {
    id: "lt",
    title: "light",
    name: "Light tracing",
    about: "Particles walk from the lights, and every surface they land on is aimed at the lens: caustics come out clean.",
    blind_spots: "Mirrors and smooth glass seen directly or by way of each other: the lens cannot be aimed at through them. \
                  Unlit surfaces, and for an orthographic camera the sky.",
    sight: Sight {
        delta_to_camera: false,
        ..Sight::FULL
    },
    bias: None,
    has_techniques: false,
    parameters: &[ROULETTE],
    build: |values: &ParameterValues| {
        Box::new(LightTracing {
            has_roulette: values.switch(ROULETTE.name),
        })
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

impl Integrator for LightTracing {
    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled> {
        let max_bounces = pass.max_bounces();
        let camera = pass.camera();
        let has_roulette = self.has_roulette;
        // As many paths as pixels, so that an iteration is as much work as that of a path tracer.
        let n_paths = pass.n_pixels();
        let numbers = pass.light_numbers(n_paths);
        // The only technique: all weights are 1.
        let weighing = Weighing::one_technique();
        pass.trace_light_paths(
            scene,
            n_paths,
            numbers,
            |_, tracer, sampler, sink, _: &mut Vec<()>| {
                // A light sends out a particle; the lens may see where it starts.
                let Some(start) = scene.lights().start(&start_sample(sampler)) else {
                    return;
                };
                let u = lens_sample(sampler);
                if let Some((raster, seen)) = see_light(tracer, camera, &start, u, n_paths) {
                    sink.splat(raster, seen);
                }
                let mut walk = Walk::from_light(&start, &weighing);
                while let Some(vertex) = walk.meet(tracer, &weighing) {
                    sampler.start_bounce(walk.bounce());

                    if walk.bounce() == max_bounces {
                        return;
                    }

                    // What scatters here, seen by the lens.
                    if vertex.surface.bsdf.has_density() {
                        let u = lens_sample(sampler);
                        if let Some((raster, seen)) =
                            splat(tracer, camera, &vertex, u, n_paths, &weighing)
                        {
                            sink.splat(raster, seen);
                        }
                    }

                    // Draw a direction from the BSDF, and on to the next vertex.
                    if !walk.scatter(&vertex, sampler, has_roulette, &weighing) {
                        return;
                    }
                }
            },
        )?;
        Ok(())
    }
}

/// Random numbers for a point of the lens.
#[inline]
pub(super) fn lens_sample(sampler: &mut Sampler) -> [f32; 2] {
    sampler.next_2d()
}
