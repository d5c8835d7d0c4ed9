//! Light tracing: path tracing read backwards.
//!
//! Particles start at the lights and carry their share of the power; what scatters where they land is
//! sent to the lens, if it is seen from there. The walk is that of the path tracer, with
//! importance for radiance, and pixels are found instead of chosen.
//!
//! `Walk::start` and `Walk::step` are the method. `abreast` takes sixteen particles through them side by side, which changes no
//! bit of what each adds.

mod abreast;

use glam::Vec2;

use crate::accel::Hit;
use crate::bsdf::TransportMode;
use crate::endpoint::{Aim, Camera};
use crate::film::{Contribution, Strategy};
use crate::integrator::bidirectional::connect::see_light;
use crate::integrator::{Integrator, Method, Parameter, ParameterKind, ParameterValues, Sight};
use crate::math::Ray;
use crate::radiometry::Rgb;
use crate::render::{Cancelled, Pass, Sink};
use crate::sampling::{Sampler, roulette};
use crate::scene::Scene;
use crate::scene::bodies::Media;
use crate::transport::reflection::start_sample;
use crate::transport::{SurfaceVertex, Tracer};

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
        // As many paths as pixels, so that an iteration is as much work as that of a path tracer.
        let n_paths = pass.n_pixels();
        let walk = Walk {
            scene,
            camera: pass.camera(),
            n_paths,
            max_bounces: pass.max_bounces(),
            has_roulette: self.has_roulette,
        };
        let numbers = pass.light_numbers(n_paths);
        pass.trace_light_paths_together(scene, n_paths, numbers, |paths, tracer, sink| {
            abreast::trace(&walk, paths, tracer, sink);
        })
    }
}

/// How particles walk.
struct Walk<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    n_paths: usize,
    max_bounces: u32,
    has_roulette: bool,
}

/// A particle on its way.
#[derive(Clone, Copy, Debug)]
struct Path {
    ray: Ray,
    throughput: Rgb,
    media: Media,
    /// Scattering events so far.
    bounce: u32,
    /// The largest channel of the power that it started with.
    power: f32,
}

impl Walk<'_> {
    /// A light sends out a particle; the lens may see where it starts. `None` if it goes nowhere.
    fn start(
        &self,
        tracer: &mut Tracer<'_>,
        sampler: &mut Sampler<'_>,
        sink: &mut Sink<'_>,
    ) -> Option<Path> {
        let start = self.scene.lights().start(&start_sample(sampler))?;
        let u = lens_sample(sampler);
        let media = tracer.media_at_light(&start);
        let seen = see_light(tracer, self.camera, &start, media, u, self.n_paths);
        if let Some((raster, seen)) = seen {
            sink.splat(raster, seen);
        }
        let power = start.throughput();
        (self.max_bounces > 0).then(|| Path {
            ray: start.ray(),
            throughput: power,
            media,
            bounce: 0,
            power: power.max_channel(),
        })
    }

    /// One step of a particle, from where its ray lands on to the next ray; `None` where it ends.
    fn step(
        &self,
        mut path: Path,
        found: Option<&Hit>,
        tracer: &mut Tracer<'_>,
        sampler: &mut Sampler<'_>,
        sink: &mut Sink<'_>,
    ) -> Option<Path> {
        let bounce = path.bounce;
        let ray = path.ray;
        let vertex = tracer.arrive(&ray, found, &mut path.media, &mut path.throughput)?;
        let media = path.media;

        // What scatters there, seen by the lens.
        sampler.start_bounce(bounce);
        if vertex.bsdf.has_density() {
            let u = lens_sample(sampler);
            if let Some(seen) = see_vertex(tracer, self.camera, &vertex, media, u) {
                let value = path.throughput * seen.share / self.n_paths as f32;
                sink.splat(seen.raster, splat(bounce + 1, value));
            }
        }

        // Draw a direction from the BSDF, and on to the next vertex.
        let [a, b] = sampler.next_2d();
        let sample = vertex.sample([sampler.next_1d(), a, b], MODE)?;
        path.throughput *= sample.throughput();

        // Particles that carry little end by chance.
        if self.has_roulette && !sample.is_delta {
            let relative = path.throughput / path.power;
            path.throughput *= roulette::play(bounce, relative, sampler)?;
        }
        path.media = vertex.media_towards(sample.wi, media);
        path.ray = vertex.ray(sample.wi);
        path.bounce += 1;
        (path.bounce < self.max_bounces).then_some(path)
    }
}

const MODE: TransportMode = TransportMode::Importance;

/// What the lens sees of a vertex.
struct Seen {
    raster: Vec2,
    /// Of the power that arrives at the vertex, what is added to the pixel.
    share: Rgb,
}

/// Aims at the lens from a vertex that was reached through `media`; `None` if nothing gets there.
#[inline]
fn see_vertex(
    tracer: &mut Tracer<'_>,
    camera: &Camera,
    vertex: &SurfaceVertex<'_>,
    media: Media,
    u: [f32; 2],
) -> Option<Seen> {
    let (seen, aim) = see_unshadowed(camera, vertex, u)?;
    let media = vertex.media_towards(aim.wi, media);
    let light = tracer.light_to_lens(&vertex.point, &aim, media);
    (!light.is_black()).then(|| Seen {
        share: seen.share * light,
        ..seen
    })
}

/// The same as if nothing were in the way.
#[inline(always)]
fn see_unshadowed(camera: &Camera, vertex: &SurfaceVertex<'_>, u: [f32; 2]) -> Option<(Seen, Aim)> {
    let (aim, raster) = camera.aim(vertex.point.position, u)?;
    let f_cos = vertex.f_cos(aim.wi, MODE);
    let seen = Seen {
        raster,
        share: f_cos * aim.value * (1.0 / aim.pdf_w),
    };
    (!f_cos.is_black()).then_some((seen, aim))
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
