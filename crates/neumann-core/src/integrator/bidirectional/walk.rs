//! A subpath, vertex by vertex, from either end.
//!
//! One step is one application of T, whichever way it is walked: importance goes from the lights
//! as radiance comes from the camera ([Veach 1997] 4.5), so there is one walk for both.

use glam::Vec2;

use super::{MisWeights, Partial};
use crate::accel::Hit;
use crate::bsdf::TransportMode;
use crate::endpoint::{Camera, LightChoice, Lights, Receiver, Spread, Start};
use crate::math::Ray;
use crate::math::lanes::side_by_side;
use crate::photons::Photon;
use crate::radiometry::Rgb;
use crate::sampling::{BounceNumbers, roulette};
use crate::scene::bodies::Media;
use crate::transport::{SurfaceVertex, Tracer, VertexSample};

/// A vertex of a subpath, on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Vertex<'a> {
    /// The surface there.
    pub surface: SurfaceVertex<'a>,
    /// Throughput of the subpath up to here, scattering not included; with the light's power, for
    /// one from a light.
    pub throughput: Rgb,
    /// What the weights need to know of the subpath.
    pub partial: Partial,
    /// What the subpath came through.
    pub media: Media,
    /// Vertices of the subpath, this one and the endpoint included.
    pub n_vertices: u16,
}

impl Vertex<'_> {
    /// The vertex of a light's walk as a photon.
    #[must_use]
    pub fn photon(&self) -> Photon {
        Photon {
            position: self.surface.point.position,
            triangle: self.surface.point.triangle,
            ng: self.surface.point.ng,
            wo: self.surface.wo,
            power: self.throughput,
            n_vertices: self.n_vertices,
            indices: self.surface.indices,
        }
    }
}

/// What a subpath carries from vertex to vertex.
#[derive(Clone, Copy, Debug)]
pub struct Carried {
    /// Throughput along the next segment, or up to the vertex that it has met.
    pub throughput: Rgb,
    /// Throughput at the start, for the roulette.
    pub(super) initial: f32,
    /// The running quantities; along a segment, without its geometry.
    pub partial: Partial,
}

side_by_side! {
    /// What the subpaths of all lanes carry.
    pub(crate) struct CarriedLanes of Carried {
        throughput: Rgb,
        initial: f32,
        partial: Partial,
    }
}

impl Carried {
    /// What a subpath from a light starts with.
    #[inline(always)]
    pub(super) fn of_light(start: &Start, weighing: &MisWeights) -> Self {
        let throughput = start.throughput();
        Self {
            throughput,
            initial: throughput.max_channel(),
            partial: weighing.of_light(start),
        }
    }

    /// Takes the segment that has met a surface into account.
    #[inline(always)]
    pub(super) fn arrive(
        &mut self,
        surface: &SurfaceVertex<'_>,
        comes_from_infinity: bool,
        weighing: &MisWeights,
    ) {
        if weighing.has_others() {
            let d2 = surface.distance * surface.distance;
            let d2 = if comes_from_infinity { 1.0 } else { d2 };
            let cos = surface.cos_g(surface.wo);
            self.partial = weighing.arrive(self.partial, d2, cos);
        }
    }

    /// Takes the scattering event after `bounce` others into account, with the direction that was
    /// drawn: the probability with which the subpath goes on.
    #[inline(always)]
    pub(super) fn leave(
        &mut self,
        surface: &SurfaceVertex<'_>,
        bounce: u32,
        sample: &VertexSample,
        mode: TransportMode,
        has_roulette: bool,
        weighing: &MisWeights,
    ) -> f32 {
        self.throughput *= sample.throughput();
        let survival = if has_roulette && !sample.is_delta {
            roulette::survival_after(bounce, self.throughput / self.initial)
        } else {
            1.0
        };
        self.throughput *= 1.0 / survival;
        if weighing.has_others() {
            self.partial = weighing.scatter(
                self.partial,
                surface.cos_g(sample.wi),
                sample.pdf_w,
                surface.pdf_w_reverse(sample, mode),
                sample.is_delta,
            );
        }
        survival
    }
}

/// The running quantities at the first vertex that a light subpath meets, from which its light may
/// have been aimed at.
#[inline(always)]
pub(super) fn of_first(
    partial: Partial,
    lights: &Lights,
    light: usize,
    receiver: &Receiver,
    weighing: &MisWeights,
) -> Partial {
    let aim = lights.pmf_aim(receiver, LightChoice::Tree, light);
    weighing.choose(partial, aim / lights.pmf_start(light))
}

/// A subpath on its way.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    pub(super) mode: TransportMode,
    /// The segment that comes next.
    pub ray: Ray,
    /// What it carries along.
    pub carried: Carried,
    /// What the next segment runs through.
    pub media: Media,
    /// Vertices so far.
    pub n_vertices: u16,
    /// The latest vertex, as lights see it; nothing at the start.
    pub receiver: Option<Receiver>,
    /// The light that it starts at.
    pub(super) light: Option<usize>,
    pub(super) comes_from_infinity: bool,
    /// True while every direction was drawn from a delta lobe.
    pub is_specular: bool,
}

impl Walk {
    /// A subpath that starts at a point of the raster, and of the lens.
    #[inline]
    #[must_use]
    pub fn from_camera(
        camera: &Camera,
        raster: Vec2,
        u: [f32; 2],
        tracer: &mut Tracer<'_>,
        weighing: &MisWeights,
    ) -> Self {
        let start = camera.ray(raster, u);
        Self {
            mode: TransportMode::Radiance,
            ray: start.ray,
            carried: Carried {
                throughput: Rgb::WHITE,
                initial: 1.0,
                partial: weighing.of_camera(&start),
            },
            media: tracer.begin_at_camera(&start.ray),
            n_vertices: 1,
            receiver: None,
            light: None,
            comes_from_infinity: matches!(start.spread, Spread::Parallel { .. }),
            is_specular: true,
        }
    }

    /// A subpath that starts at a light.
    #[must_use]
    pub fn from_light(start: &Start, tracer: &mut Tracer<'_>, weighing: &MisWeights) -> Self {
        Self {
            media: tracer.begin_at_light(start),
            comes_from_infinity: start.is_at_infinity(),
            ..Self::leaving_light(start.ray(), Carried::of_light(start, weighing), start.light)
        }
    }

    /// The same from a light that has a place, in vacuum.
    #[inline(always)]
    pub(super) fn leaving_light(ray: Ray, carried: Carried, light: usize) -> Self {
        Self {
            mode: TransportMode::Importance,
            ray,
            carried,
            media: Media::VACUUM,
            n_vertices: 1,
            receiver: None,
            light: Some(light),
            comes_from_infinity: false,
            is_specular: true,
        }
    }

    /// Goes along the segment to the next vertex; `None` where it leaves the scene.
    #[inline(always)]
    pub fn meet<'a>(
        &mut self,
        tracer: &mut Tracer<'a>,
        weighing: &MisWeights,
    ) -> Option<Vertex<'a>> {
        let found = tracer.hit(&self.ray);
        self.arrive(found.as_ref(), tracer, weighing)
    }

    /// The same where it is known already what the segment meets if media are not asked.
    #[inline(always)]
    pub(super) fn arrive<'a>(
        &mut self,
        found: Option<&Hit>,
        tracer: &mut Tracer<'a>,
        weighing: &MisWeights,
    ) -> Option<Vertex<'a>> {
        let ray = self.ray;
        let carried = &mut self.carried;
        let surface = tracer.arrive(&ray, found, &mut self.media, &mut carried.throughput)?;
        carried.arrive(&surface, self.comes_from_infinity, weighing);
        if weighing.has_others()
            && let Some(light) = self.light.take()
        {
            let (lights, receiver) = (tracer.scene.lights(), surface.receiver());
            carried.partial = of_first(carried.partial, lights, light, &receiver, weighing);
        }
        self.comes_from_infinity = false;
        self.n_vertices += 1;
        Some(Vertex {
            surface,
            throughput: carried.throughput,
            partial: carried.partial,
            media: self.media,
            n_vertices: self.n_vertices,
        })
    }

    /// Scattering events that lead to the latest vertex.
    #[inline]
    #[must_use]
    pub fn bounce(&self) -> u32 {
        u32::from(self.n_vertices) - 2
    }

    /// Draws a direction and leaves the vertex; false where the subpath ends.
    #[inline]
    pub fn scatter(
        &mut self,
        vertex: &Vertex<'_>,
        tracer: &mut Tracer<'_>,
        u: &BounceNumbers,
        has_roulette: bool,
        weighing: &MisWeights,
    ) -> bool {
        let surface = &vertex.surface;
        let Some(sample) = surface.sample(u.bsdf(), self.mode) else {
            return false;
        };
        let (bounce, mode) = (self.bounce(), self.mode);
        let carried = &mut self.carried;
        let survival = carried.leave(surface, bounce, &sample, mode, has_roulette, weighing);
        tracer.leaves(surface, &sample, mode, survival);
        if u.roulette >= survival {
            return false;
        }
        self.is_specular &= sample.is_delta;
        self.receiver = Some(surface.receiver());
        self.media = surface.media_towards(sample.wi, self.media);
        self.ray = surface.ray(sample.wi);
        true
    }
}
