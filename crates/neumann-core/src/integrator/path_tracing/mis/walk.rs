//! A path by itself: what it carries, and what it runs into.

use crate::accel::Hit;
use crate::endpoint::LightChoice;
use crate::integrator::path_tracing::{add_unlit, hit};
use crate::math::Ray;
use crate::math::lanes::side_by_side;
use crate::pass::Gather;
use crate::radiometry::Rgb;
use crate::sampling::roulette;
use crate::scene::bodies::Media;
use crate::scene::{Scene, SpecularCaster};
use crate::transport::reflection::Drawn;
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

impl Carried {
    /// What a path carries whose direction was drawn there, or nowhere.
    pub(super) fn new(throughput: Rgb, drawn: Drawn) -> Self {
        Self {
            throughput,
            n_events: 0,
            drawn,
        }
    }
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
            carried: Carried::new(Rgb::WHITE, Drawn::NOWHERE),
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

    /// Light that a path runs into, and the vertex that it goes on from, if it does.
    #[inline(always)]
    pub(super) fn meet<'s>(
        &self,
        path: &mut Path,
        found: Option<&Hit>,
        tracer: &mut Tracer<'s>,
        sink: &mut impl Gather,
    ) -> Option<SurfaceVertex<'s>> {
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
                sink.gather(hit(bounce, carried.throughput * radiance, weight));
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
            sink.gather(hit(bounce, carried.throughput * emitted, weight));
        }
        (bounce < self.max_bounces).then_some(vertex)
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
