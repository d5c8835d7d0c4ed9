//! Light subpaths: every vertex is aimed at the lens and kept, to be joined to camera subpaths.
//!
//! `LightEnd::start` and `LightEnd::step` are what is done; `abreast` takes sixteen subpaths through them side by side, which
//! changes no bit of what each adds.

mod abreast;

use super::connect::{hit_lens, splat};
use super::{Partial, Vertex, Walk, Weighing};
use crate::accel::Hit;
use crate::endpoint::Camera;
use crate::integrator::light_tracing::lens_sample;
use crate::photons::Photon;
use crate::render::Sink;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::bodies::Media;
use crate::transport::Tracer;
use crate::transport::reflection::start_sample;

/// How light subpaths walk.
pub(in crate::integrator) struct LightEnd<'a> {
    pub(in crate::integrator) scene: &'a Scene,
    pub(in crate::integrator) camera: &'a Camera,
    /// Subpaths of the iteration.
    pub(in crate::integrator) n_paths: usize,
    pub(in crate::integrator) max_bounces: u32,
    pub(in crate::integrator) has_roulette: bool,
    /// Whether the lens is aimed at, and may be run into.
    pub(in crate::integrator) has_connections: bool,
    pub(in crate::integrator) weighing: Weighing,
}

/// A vertex of a light subpath as it is kept: also what makes the surface there again.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct LightVertex {
    pub(in crate::integrator) photon: Photon,
    pub(in crate::integrator) partial: Partial,
    barycentrics: [f32; 2],
}

impl LightEnd<'_> {
    /// A light starts a subpath; `None` if it goes nowhere.
    pub(super) fn start(&self, tracer: &mut Tracer<'_>, sampler: &mut Sampler<'_>) -> Option<Walk> {
        let start = self.scene.lights().start(&start_sample(sampler))?;
        Some(Walk::from_light(&start, tracer, &self.weighing))
    }

    /// One step of a subpath, from what it meets on to the next ray; false where it ends. Vertices that can be joined are
    /// handed to `keep`.
    pub(super) fn step(
        &self,
        walk: &mut Walk,
        found: Option<&Hit>,
        tracer: &mut Tracer<'_>,
        sampler: &mut Sampler<'_>,
        sink: &mut Sink<'_>,
        keep: impl FnOnce(LightVertex),
    ) -> bool {
        // t = 0: the lens, where the subpath runs into it.
        self.meet_lens(walk, found, tracer, sink);
        let Some(vertex) = walk.arrive(found, tracer, &self.weighing) else {
            return false;
        };
        if walk.bounce() == self.max_bounces {
            return false;
        }
        sampler.start_bounce(walk.bounce());
        if vertex.surface.bsdf.has_density() {
            keep(LightVertex::of(&vertex));
            // t = 1: the lens aimed at.
            let u = lens_sample(sampler);
            if self.has_connections
                && let Some((raster, seen)) = splat(
                    tracer,
                    self.camera,
                    &vertex,
                    u,
                    self.n_paths,
                    &self.weighing,
                )
            {
                sink.splat(raster, seen);
            }
        }
        walk.scatter(&vertex, sampler, self.has_roulette, &self.weighing)
    }

    /// t = 0: adds what a subpath brings that runs into a lens of finite size before it meets anything else.
    #[inline]
    fn meet_lens(
        &self,
        walk: &Walk,
        found: Option<&Hit>,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
    ) {
        if self.has_connections && self.camera.has_lens() {
            let (camera, weighing) = (self.camera, &self.weighing);
            let found = hit_lens(tracer, camera, walk, found, self.n_paths, weighing);
            if let Some((raster, seen)) = found {
                sink.splat(raster, seen);
            }
        }
    }
}

impl LightVertex {
    #[inline(always)]
    fn of(vertex: &Vertex<'_>) -> Self {
        Self {
            photon: vertex.photon(),
            partial: vertex.partial,
            barycentrics: vertex.surface.barycentrics,
        }
    }

    /// The vertex as its walk had it.
    #[inline]
    pub(super) fn restored<'a>(&self, tracer: &Tracer<'a>) -> Vertex<'a> {
        let photon = &self.photon;
        Vertex {
            surface: tracer.surface_at_point(
                &photon.point(),
                self.barycentrics,
                photon.wo,
                photon.indices,
            ),
            throughput: photon.power,
            partial: self.partial,
            // A segment's absorption is that on the camera vertex's side of it.
            media: Media::VACUUM,
            n_vertices: photon.n_vertices,
        }
    }
}
