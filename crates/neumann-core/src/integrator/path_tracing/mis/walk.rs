//! A path, step by step.

use crate::accel::Hit;
use crate::endpoint::LightChoice;
use crate::integrator::path_tracing::bsdf::MODE;
use crate::integrator::path_tracing::{add_unlit, connect, hit};
use crate::math::Ray;
use crate::math::lanes::side_by_side;
use crate::pass::PixelSink;
use crate::radiometry::Rgb;
use crate::sampling::{Sampler, roulette};
use crate::scene::bodies::Media;
use crate::scene::{Scene, SpecularCaster};
use crate::transport::reflection::{Drawn, aim_at_light, light_sample};
use crate::transport::specular_casters::Cones;
use crate::transport::{SurfaceVertex, Tracer, VertexSample};

/// How paths walk.
pub(super) struct PathTracer<'a> {
    pub(super) scene: &'a Scene,
    pub(super) max_bounces: u32,
    pub(super) choice: LightChoice,
    pub(super) has_roulette: bool,
    /// What diffuse surfaces send some of their paths to.
    pub(super) specular_casters: &'a [SpecularCaster],
    /// Whether paths split at their first surface.
    pub(super) splits: bool,
}

/// Paths that one splits into.
pub(super) const N_SPLITS: u8 = 2;

/// What a path carries from vertex to vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    pub(super) throughput: Rgb,
    /// Scattering events so far that were not at delta lobes.
    n_events: u32,
    /// Where the ray's direction was drawn.
    drawn: Drawn,
}

side_by_side! {
    /// What the paths of all lanes carry.
    pub(crate) struct CarriedLanes of Carried { throughput: Rgb, n_events: u32, drawn: Drawn }
}

/// A path on its way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    pub(super) ray: Ray,
    pub(super) carried: Carried,
    pub(super) media: Media,
    /// Scattering events so far.
    pub(super) bounce: u32,
}

impl Path {
    /// A path that leaves the camera.
    pub(super) fn new(ray: Ray, tracer: &mut Tracer<'_>) -> Self {
        Self {
            ray,
            carried: Carried {
                throughput: Rgb::WHITE,
                n_events: 0,
                drawn: Drawn::NOWHERE,
            },
            media: tracer.begin_at_camera(&ray),
            bounce: 0,
        }
    }
}

impl PathTracer<'_> {
    /// True in a scene where paths split: one lit by nothing but a sky of one radiance.
    pub(super) fn splits_in(scene: &Scene) -> bool {
        let lights = scene.lights();
        let sky = lights.uniform_environment();
        lights.as_slice().len() == 1 && sky.is_some_and(|radiance| !radiance.is_black())
    }

    /// One step of a path, from what its ray has met on to the next ray; `None` where it ends.
    /// Others that it splits into, with their random numbers, are handed to `split_off`.
    #[allow(clippy::too_many_arguments, reason = "a path with all its ends")]
    #[inline(always)]
    pub(super) fn step<'t>(
        &self,
        path: Path,
        found: Option<&Hit>,
        tracer: &mut Tracer<'_>,
        sampler: &Sampler<'_>,
        others: impl Iterator<Item = Sampler<'t>>,
        sink: &mut PixelSink<'_>,
        mut split_off: impl FnMut(Path, Sampler<'t>),
    ) -> Option<Path> {
        let (mut path, vertex) = self.meet(path, found, tracer, sink)?;
        if self.splits && path.bounce == 0 && vertex.bsdf.has_density() {
            path.carried.throughput *= 1.0 / f32::from(N_SPLITS);
            tracer.splits(u32::from(N_SPLITS));
            for sampler in others {
                if let Some(next) = self.scatter(path, &vertex, tracer, &sampler, sink) {
                    split_off(next, sampler);
                }
            }
        }
        self.scatter(path, &vertex, tracer, sampler, sink)
    }

    /// Light that a path runs into, and the vertex that it goes on from, if it does.
    #[inline(always)]
    fn meet<'s>(
        &self,
        mut path: Path,
        found: Option<&Hit>,
        tracer: &mut Tracer<'s>,
        sink: &mut PixelSink<'_>,
    ) -> Option<(Path, SurfaceVertex<'s>)> {
        let bounce = path.bounce;
        // What does the ray meet? Nothing: the environment emits.
        let ray = path.ray;
        let (media, carried) = (&mut path.media, &mut path.carried);
        let Some(vertex) = tracer.arrive(&ray, found, media, &mut carried.throughput) else {
            let direction = ray.direction();
            let radiance = self.scene.lights().environment_radiance(direction);
            if !radiance.is_black() {
                let drawn = &carried.drawn;
                let weight = drawn.mis_weight_of_environment(tracer, self.choice, direction);
                sink.add(hit(bounce, carried.throughput * radiance, weight));
            }
            return None;
        };
        if bounce == 0 {
            add_unlit(tracer, &vertex, sink);
        }

        // L_e that was run into, against having been aimed at.
        let emitted = tracer.emitted(&vertex);
        if !emitted.is_black() {
            let weight = carried.drawn.mis_weight(tracer, self.choice, &vertex);
            sink.add(hit(bounce, carried.throughput * emitted, weight));
        }
        (bounce < self.max_bounces).then_some((path, vertex))
    }

    /// Aims at a light from a vertex, and goes on to the next ray; `None` where the path ends.
    fn scatter(
        &self,
        mut path: Path,
        vertex: &SurfaceVertex<'_>,
        tracer: &mut Tracer<'_>,
        sampler: &Sampler<'_>,
        sink: &mut PixelSink<'_>,
    ) -> Option<Path> {
        let (bounce, media) = (path.bounce, path.media);
        let u = sampler.bounce(bounce);

        // Draw a direction from the BSDF, or towards a mirror or glass.
        let cones = Cones::seen_from(vertex, self.specular_casters);
        let sample = match &cones {
            Some(cones) => cones.sample(vertex, u.bsdf(), MODE),
            None => vertex.sample(u.bsdf(), MODE),
        };

        // The next event, aimed at, against running into it.
        if vertex.bsdf.has_density() {
            let light = light_sample(&u);
            if let Some(aimed) = aim_at_light(tracer, vertex, media, self.choice, &light) {
                let value = path.carried.throughput * aimed.value;
                let aimed = cones.map_or(aimed, |cones| cones.beside(aimed));
                sink.add(connect(bounce + 1, value, aimed.mis_weight()));
            }
        }

        // On to the next vertex.
        let sample = sample?;
        let survival = self.leave(&mut path.carried, vertex, &sample);
        tracer.leaves(vertex, &sample, MODE, survival);
        if u.roulette >= survival {
            return None;
        }
        path.media = vertex.media_towards(sample.wi, media);
        path.ray = vertex.ray(sample.wi);
        path.bounce += 1;
        Some(path)
    }

    /// Takes a direction that was drawn into account: the probability with which the path goes on.
    /// Those that carry little end by chance.
    #[inline(always)]
    pub(super) fn leave(
        &self,
        carried: &mut Carried,
        vertex: &SurfaceVertex<'_>,
        sample: &VertexSample,
    ) -> f32 {
        carried.throughput *= sample.throughput();
        carried.drawn = Drawn::at(vertex, sample);
        if sample.is_delta {
            return 1.0;
        }
        let survival = if self.has_roulette {
            roulette::survival_after(carried.n_events, carried.throughput)
        } else {
            1.0
        };
        carried.throughput *= 1.0 / survival;
        carried.n_events += 1;
        survival
    }
}
