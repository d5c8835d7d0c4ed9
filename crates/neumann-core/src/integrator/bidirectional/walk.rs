//! A subpath, vertex by vertex, from either end.
//!
//! One step is one application of T, whichever way it is walked: importance goes from the lights
//! as radiance comes from the camera ([Veach 1997] 4.5), so there is one walk for both.

use glam::Vec2;

use super::{Partial, Weighing};
use crate::accel::Hit;
use crate::bsdf::TransportMode;
use crate::endpoint::{Camera, LightChoice, Lights, Receiver, Spread, Start};
use crate::math::Ray;
use crate::photons::Photon;
use crate::radiometry::Rgb;
use crate::sampling::{Sampler, roulette};
use crate::scene::bodies::Media;
use crate::transport::{SurfaceVertex, Tracer};

/// A vertex of a subpath, on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Vertex<'a> {
    /// The surface there.
    pub surface: SurfaceVertex<'a>,
    /// Throughput of the subpath up to here, scattering not included; with the light's power, for one from a light.
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

/// The running quantities at the first vertex that a light subpath meets, from which its light may have been aimed at.
#[inline(always)]
pub(super) fn of_first(
    partial: Partial,
    lights: &Lights,
    light: usize,
    receiver: &Receiver,
    weighing: &Weighing,
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
    /// Throughput along it.
    pub throughput: Rgb,
    /// Throughput at the start, for the roulette.
    pub(super) initial: f32,
    /// The running quantities, without the geometry of the next segment.
    pub partial: Partial,
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
        weighing: &Weighing,
    ) -> Self {
        let start = camera.ray(raster, u);
        Self {
            mode: TransportMode::Radiance,
            ray: start.ray,
            throughput: Rgb::WHITE,
            initial: 1.0,
            partial: weighing.of_camera(&start),
            media: tracer.media_at_camera(&start.ray),
            n_vertices: 1,
            receiver: None,
            light: None,
            comes_from_infinity: matches!(start.spread, Spread::Parallel { .. }),
            is_specular: true,
        }
    }

    /// A subpath that starts at a light.
    #[must_use]
    pub fn from_light(start: &Start, tracer: &mut Tracer<'_>, weighing: &Weighing) -> Self {
        let throughput = start.throughput();
        Self {
            mode: TransportMode::Importance,
            ray: start.ray(),
            throughput,
            initial: throughput.max_channel(),
            partial: weighing.of_light(start),
            media: tracer.media_at_light(start),
            n_vertices: 1,
            receiver: None,
            light: Some(start.light),
            comes_from_infinity: start.is_at_infinity(),
            is_specular: true,
        }
    }

    /// Goes along the segment to the next vertex; `None` where it leaves the scene.
    #[inline(always)]
    pub fn meet<'a>(&mut self, tracer: &mut Tracer<'a>, weighing: &Weighing) -> Option<Vertex<'a>> {
        let found = tracer.hit(&self.ray);
        self.arrive(found.as_ref(), tracer, weighing)
    }

    /// The same where it is known already what the segment meets if media are not asked.
    #[inline(always)]
    pub(super) fn arrive<'a>(
        &mut self,
        found: Option<&Hit>,
        tracer: &mut Tracer<'a>,
        weighing: &Weighing,
    ) -> Option<Vertex<'a>> {
        let ray = self.ray;
        let surface = tracer.arrive(&ray, found, &mut self.media, &mut self.throughput)?;
        if weighing.has_others() {
            let d2 = if self.comes_from_infinity {
                1.0
            } else {
                surface.distance * surface.distance
            };
            self.partial = weighing.arrive(self.partial, d2, surface.cos_g(surface.wo));
            if let Some(light) = self.light.take() {
                let lights = tracer.scene.lights();
                self.partial = of_first(self.partial, lights, light, &surface.receiver(), weighing);
            }
        }
        self.comes_from_infinity = false;
        self.n_vertices += 1;
        Some(Vertex {
            surface,
            throughput: self.throughput,
            partial: self.partial,
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
        sampler: &mut Sampler<'_>,
        has_roulette: bool,
        weighing: &Weighing,
    ) -> bool {
        let bounce = self.bounce();
        let [a, b] = sampler.next_2d();
        let u = [sampler.next_1d(), a, b];
        let Some(sample) = vertex.surface.sample(u, self.mode) else {
            return false;
        };
        self.throughput *= sample.throughput();
        if has_roulette && !sample.is_delta {
            let relative = self.throughput / self.initial;
            let Some(factor) = roulette::play(bounce, relative, sampler) else {
                return false;
            };
            self.throughput *= factor;
        }
        if weighing.has_others() {
            self.partial = weighing.scatter(
                self.partial,
                vertex.surface.cos_g(sample.wi),
                sample.pdf_w,
                vertex.surface.pdf_w_reverse(&sample, self.mode),
                sample.is_delta,
            );
        }
        self.is_specular &= sample.is_delta;
        self.receiver = Some(vertex.surface.receiver());
        self.media = vertex.surface.media_towards(sample.wi, self.media);
        self.ray = vertex.surface.ray(sample.wi);
        true
    }
}
