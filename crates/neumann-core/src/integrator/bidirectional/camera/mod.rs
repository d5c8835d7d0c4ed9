//! Camera subpaths: every vertex is joined with the lights and with the vertices of light subpaths.
//!
//! `CameraEnd::start` and `CameraEnd::step` are what is done; `abreast` takes sixteen subpaths through them side by side, which
//! changes nothing but the order in which contributions to a pixel are added.

mod abreast;

pub(in crate::integrator) use abreast::CameraRoom;

use super::connect::{hit_emitter, hit_environment, next_event};
use super::merging::Merging;
use super::subpath::{LightSubpath, Unseen};
use super::{Vertex, Walk, Weighing};
use crate::accel::Hit;
use crate::endpoint::Camera;
use crate::integrator::light_tracing::lens_sample;
use crate::integrator::path_tracing::{add_unlit, hit};
use crate::render::{PixelSample, Sink};
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::transport::Tracer;
use crate::transport::reflection::light_sample;

/// How camera subpaths walk, and what they are joined with.
pub(in crate::integrator) struct CameraEnd<'a> {
    pub(in crate::integrator) scene: &'a Scene,
    pub(in crate::integrator) camera: &'a Camera,
    pub(in crate::integrator) max_bounces: u32,
    pub(in crate::integrator) has_roulette: bool,
    /// Whether subpaths are joined by segments.
    pub(in crate::integrator) has_connections: bool,
    /// What vertices are merged with, if they are.
    pub(in crate::integrator) merging: Option<Merging<'a>>,
    pub(in crate::integrator) weighing: Weighing,
}

impl CameraEnd<'_> {
    /// The camera starts a subpath.
    pub(super) fn start(
        &self,
        sample: PixelSample,
        tracer: &mut Tracer<'_>,
        sampler: &mut Sampler<'_>,
    ) -> Walk {
        let u = lens_sample(sampler);
        Walk::from_camera(self.camera, sample.raster, u, tracer, &self.weighing)
    }

    /// One step of a subpath, from what it meets on to the next ray; false where it ends. A vertex that is to be merged is
    /// handed to `merge`.
    #[allow(clippy::too_many_arguments, reason = "a path with all its ends")]
    pub(super) fn step<'s>(
        &self,
        walk: &mut Walk,
        found: Option<&Hit>,
        lights: &mut LightSubpath<'s>,
        unseen: &mut Unseen,
        tracer: &mut Tracer<'s>,
        sampler: &mut Sampler<'_>,
        sink: &mut Sink<'_>,
        merge: impl FnOnce(Vertex<'s>),
    ) -> bool {
        let weighing = &self.weighing;
        // s = 0: L_e, where the subpath runs into it.
        let Some(vertex) = walk.arrive(found, tracer, weighing) else {
            if self.has_connections {
                if let Some(found) = hit_environment(tracer, walk, weighing) {
                    sink.add(found);
                }
            } else if walk.is_specular {
                let lights = self.scene.lights();
                let radiance = lights.environment_radiance(walk.ray.direction());
                let bounce = u32::from(walk.n_vertices) - 1;
                sink.add(hit(bounce, walk.throughput * radiance, 1.0));
            }
            return false;
        };
        let bounce = walk.bounce();
        if bounce == 0 {
            add_unlit(tracer, &vertex.surface, sink);
        }
        if self.has_connections {
            if let Some(found) = hit_emitter(tracer, walk, &vertex, weighing) {
                sink.add(found);
            }
        } else if walk.is_specular {
            // Merging alone cannot find light by way of mirrors only.
            let emitted = tracer.emitted(&vertex.surface);
            sink.add(hit(bounce, vertex.throughput * emitted, 1.0));
        }
        if bounce == self.max_bounces {
            return false;
        }
        sampler.start_bounce(bounce);
        if vertex.surface.bsdf.has_density() {
            let u = light_sample(sampler);
            if self.has_connections {
                // s = 1: a light aimed at.
                if let Some(found) = next_event(tracer, &vertex, &u, weighing) {
                    sink.add(found);
                }
                // s ≥ 2: every vertex of the light subpath that leaves the path short enough.
                lights.connect(
                    tracer,
                    &vertex,
                    self.max_bounces,
                    weighing,
                    unseen,
                    sink.pixel(),
                    |place, found| sink.add_at(place, found),
                );
            }
            if self.merging.is_some() {
                merge(vertex);
            }
        }
        walk.scatter(&vertex, sampler, self.has_roulette, weighing)
    }
}
