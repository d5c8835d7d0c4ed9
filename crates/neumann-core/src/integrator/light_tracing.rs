//! Light tracing: path tracing read backwards.
//!
//! Particles start at the lights and carry their share of the power; what scatters where they land is
//! sent to the lens, if it is seen from there. The walk is that of the path tracer, with
//! importance for radiance, and pixels are found instead of chosen.

use glam::Vec2;

use crate::bsdf::TransportMode;
use crate::endpoint::Camera;
use crate::film::{Contribution, Strategy};
use crate::integrator::bidirectional::connect::see_light;
use crate::integrator::{Integrator, Method, Parameter, ParameterKind, ParameterValues, Sight};
use crate::radiometry::Rgb;
use crate::render::{Cancelled, Pass};
use crate::sampling::{Sampler, roulette};
use crate::scene::Scene;
use crate::transport::reflection::start_sample;
use crate::transport::{Medium, SurfaceVertex, Tracer};

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
                let power = start.throughput();
                let mut throughput = power;
                let mut medium = Medium::VACUUM;
                let mut ray = start.ray();
                for bounce in 0..max_bounces {
                    // Where does it land?
                    let Some(found) = tracer.hit(&ray) else {
                        return;
                    };
                    let vertex = tracer.surface_vertex(-ray.direction(), &found);
                    throughput *= medium.transmittance(vertex.distance);

                    // What scatters there, seen by the lens.
                    sampler.start_bounce(bounce);
                    if vertex.bsdf.has_density() {
                        let u = lens_sample(sampler);
                        if let Some(seen) = see_vertex(tracer, camera, &vertex, medium, u) {
                            let value = throughput * seen.share / n_paths as f32;
                            sink.splat(seen.raster, splat(bounce + 1, value));
                        }
                    }

                    // Draw a direction from the BSDF, and on to the next vertex.
                    let [a, b] = sampler.next_2d();
                    let Some(sample) = vertex.sample([sampler.next_1d(), a, b], MODE) else {
                        return;
                    };
                    throughput *= sample.throughput();

                    // Paths that carry little end by chance.
                    if has_roulette && !sample.is_delta {
                        let relative = throughput / power.max_channel();
                        let Some(factor) = roulette::play(bounce, relative, sampler) else {
                            return;
                        };
                        throughput *= factor;
                    }
                    medium = medium.beyond(&vertex, sample.wi);
                    ray = vertex.ray(sample.wi);
                }
            },
        )?;
        Ok(())
    }
}

const MODE: TransportMode = TransportMode::Importance;

/// What the lens sees of a vertex.
struct Seen {
    raster: Vec2,
    /// Of the power that arrives at the vertex, what is added to the pixel.
    share: Rgb,
}

/// Aims at the lens from a vertex that was reached through a medium; `None` if nothing gets there.
#[inline]
fn see_vertex(
    tracer: &mut Tracer<'_>,
    camera: &Camera,
    vertex: &SurfaceVertex<'_>,
    medium: Medium,
    u: [f32; 2],
) -> Option<Seen> {
    let (aim, raster) = camera.aim(vertex.point.position, u)?;
    let f_cos = vertex.f_cos(aim.wi, MODE);
    if f_cos.is_black() {
        return None;
    }
    let visibility = tracer.visibility(&vertex.point, &aim);
    if visibility <= 0.0 {
        return None;
    }
    let through = medium.beyond(vertex, aim.wi).transmittance(aim.distance);
    Some(Seen {
        raster,
        share: f_cos * aim.value * through * (visibility / aim.pdf_w),
    })
}

/// Light that arrives on the lens after `bounce` scattering events.
#[inline]
fn splat(bounce: u32, value: Rgb) -> Contribution {
    Contribution {
        value,
        mis_weight: 1.0,
        bounce,
        strategy: Strategy::connect(bounce as u16 + 1, 1),
    }
}

/// Random numbers for a point of the lens.
#[inline]
pub(super) fn lens_sample(sampler: &mut Sampler<'_>) -> [f32; 2] {
    sampler.next_2d()
}
