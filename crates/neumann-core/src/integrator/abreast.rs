//! What paths abreast have in common, whichever end they start from.
//!
//! Sixteen paths walk side by side, for speed alone. Each lane has a path, and takes the next one when it ends. Where a path
//! meets a plain diffuse surface, as most do in most scenes, it makes its step in vectors, together with the other
//! lanes ([`crate::transport::diffuse`]); from anywhere else, by itself. Either way the step is the same to the last bit: both
//! are made of the same functions.

use crate::accel::{HitLanes, RayLanes};
use crate::math::Ray;
use crate::math::lanes::{LANES, Lanes};
use crate::radiometry::{Rgb, RgbLanes};
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::bodies::Media;
use crate::transport::diffuse::{DiffuseHit, DiffuseSamples, DiffuseVertices};

/// The paths of all lanes that have one.
pub(super) struct PathLanes<'t> {
    /// Their rays; a lane without one has no path.
    pub(super) rays: RayLanes,
    throughput: RgbLanes,
    bounce: Lanes<u32>,
    pub(super) media: [Media; LANES],
    pub(super) samplers: [Sampler<'t>; LANES],
}

impl Default for PathLanes<'_> {
    fn default() -> Self {
        Self {
            rays: RayLanes::default(),
            throughput: RgbLanes::default(),
            bounce: Lanes::default(),
            media: [Media::VACUUM; LANES],
            samplers: std::array::from_fn(|_| Sampler::new(0, 0, 0)),
        }
    }
}

impl PathLanes<'_> {
    /// What the step before has left of a path's throughput.
    #[inline(always)]
    pub(super) fn throughput(&self, lane: usize) -> Rgb {
        self.throughput.get(lane)
    }

    /// Scattering events so far.
    #[inline(always)]
    pub(super) fn bounce(&self, lane: usize) -> u32 {
        self.bounce.get(lane)
    }

    /// Puts a path into a lane, beside its random numbers.
    #[inline(always)]
    pub(super) fn set(
        &mut self,
        lane: usize,
        ray: &Ray,
        throughput: Rgb,
        media: Media,
        bounce: u32,
    ) {
        self.rays.set(lane, ray);
        self.throughput.set(lane, throughput);
        self.media[lane] = media;
        self.bounce.set(lane, bounce);
    }

    /// Takes a path out of its lane.
    #[inline(always)]
    pub(super) fn end(&mut self, lane: usize) {
        self.rays.set_mask(self.rays.mask() & !(1 << lane));
    }

    /// Lets the path of a lane join those that make their next step together, if what it has met is plain enough.
    #[inline(always)]
    pub(super) fn join<'s>(
        &self,
        scene: &'s Scene,
        max_bounces: u32,
        lane: usize,
        hits: &HitLanes,
        vertices: &mut DiffuseVertices<'s>,
    ) -> bool {
        if self.bounce.get(lane) >= max_bounces || !self.media[lane].is_vacuum() {
            return false;
        }
        let found = hits[lane].as_ref();
        match found.and_then(|hit| DiffuseHit::of(scene, hit)) {
            Some(found) => {
                vertices.set(lane, &found);
                true
            }
            None => false,
        }
    }

    /// Takes the path of a lane on along the direction that was drawn, if it is among those that make the step together.
    #[inline(always)]
    pub(super) fn go_on(
        &mut self,
        lane: usize,
        is_abreast: bool,
        samples: &DiffuseSamples,
        throughput: Rgb,
    ) {
        self.throughput.set_if(is_abreast, lane, throughput);
        let (origin, direction) = (samples.origin(lane), samples.direction(lane));
        self.rays.replace(lane, is_abreast, origin, direction);
        let bounce = self.bounce.get(lane) + u32::from(is_abreast);
        self.bounce.set(lane, bounce);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::sync::Arc;

    use crate::integrator::{Method, ParameterValues};
    use crate::radiometry::Rgb;
    use crate::render::{CancelToken, RenderSettings, Renderer, WorkerPool};
    use crate::scene::Scene;
    use crate::scene::builtin::builtin;
    use crate::scene::description::{EnvironmentDescription, Lens, SceneDescription};

    /// Scenes that have, between them, all that paths may join for or have to do by themselves: smooth normals, mirrors and glass,
    /// coats, a tree of lights, a sky, volumes.
    pub(in crate::integrator) const SCENES: [&str; 6] =
        ["cornell", "cornell-glass", "plates", "many", "sky", "pool"];

    /// Two iterations of a scene, seen through a lens, layer by layer.
    pub(in crate::integrator) fn layers(scene: &str, method: &'static Method) -> Vec<Rgb> {
        layers_of(&builtin(scene).unwrap().load().unwrap(), method)
    }

    /// The same under a sky of one radiance instead of its lights.
    pub(in crate::integrator) fn layers_under_even_sky(
        scene: &str,
        method: &'static Method,
    ) -> Vec<Rgb> {
        let mut description = builtin(scene).unwrap().load().unwrap();
        for material in &mut description.materials {
            material.emission = Rgb::BLACK;
        }
        description.environment = Some(EnvironmentDescription::uniform(Rgb::WHITE));
        layers_of(&description, method)
    }

    fn layers_of(description: &SceneDescription, method: &'static Method) -> Vec<Rgb> {
        let scene = Arc::new(Scene::build(description));
        let mut settings = RenderSettings::new(scene.cameras()[0].clone(), 40, 30);
        settings.camera.lens = Some(Lens {
            // Wide enough for particles to run into it.
            aperture: 0.5,
            focus_distance: 2.0,
        });
        settings.method = method;
        settings.values = ParameterValues::defaults(method.parameters);
        settings.max_bounces = 20;
        let pool = WorkerPool::new(Some(2), || ()).unwrap();
        let mut renderer = Renderer::new(scene, settings, pool, 0);
        let mut all: Vec<Rgb> = Vec::new();
        for _ in 0..2 {
            let frame = renderer.iterate(&CancelToken::default()).unwrap();
            for tile in 0..frame.grid().n_tiles() {
                all.extend(frame.layers_of_tile(tile).flatten());
            }
        }
        assert!(all.iter().any(|value| !value.is_black()), "a black picture");
        all
    }
}
