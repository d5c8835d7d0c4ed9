//! What paths side by side have in common, whichever end they start from.
//!
//! Sixteen paths walk side by side, for speed alone. Each lane has a path, and takes the next one
//! when it ends. Where a path meets a plain diffuse surface, as most do in most scenes, it makes
//! its step in vectors, together with the other lanes ([`crate::transport::diffuse`]); from
//! anywhere else, by itself. Either way the step is made of the same functions and has the same
//! bits. A sink may ask for paths one by one ([`PixelSink::is_alone`]): the same with one lane,
//! which makes every step by itself.

use glam::Vec2;

use crate::accel::{HitLanes, RayLanes};
use crate::math::Ray;
use crate::math::lanes::{LANES, Lanes, lanes_of};
use crate::pass::PixelSink;
use crate::radiometry::{Rgb, RgbLanes};
use crate::sampling::{BounceNumbers, Sampler};
use crate::scene::Scene;
use crate::scene::bodies::Media;
use crate::transport::diffuse::{DiffuseHit, DiffuseSamples, DiffuseVertices};
use crate::transport::{Tracer, is_segment};

/// The paths of all lanes that have one.
#[derive(Clone)]
pub(super) struct PathLanes<'t> {
    /// Their rays; a lane without one has no path.
    pub(super) rays: RayLanes,
    /// Scattering events so far.
    pub(super) bounces: Lanes<u32>,
    pub(super) media: [Media; LANES],
    pub(super) samplers: [Sampler<'t>; LANES],
    /// One bit for each lane that may have a path.
    usable: u32,
    may_join: bool,
}

impl PathLanes<'_> {
    /// No path yet.
    pub(super) fn new(sink: &PixelSink<'_>) -> Self {
        Self {
            rays: RayLanes::default(),
            bounces: Lanes::default(),
            media: [Media::VACUUM; LANES],
            samplers: std::array::from_fn(|_| Sampler::new(0, 0, 0)),
            usable: if sink.is_alone() { 1 } else { !(!0 << LANES) },
            may_join: !sink.is_alone(),
        }
    }

    /// The lanes that have a path.
    #[inline(always)]
    pub(super) fn taken(&self) -> u32 {
        self.rays.mask()
    }

    /// The lanes that a path may be put into.
    #[inline(always)]
    pub(super) fn free(&self) -> u32 {
        self.usable & !self.rays.mask()
    }

    /// True if paths may make steps together.
    #[inline(always)]
    pub(super) fn may_join(&self) -> bool {
        self.may_join
    }

    /// Puts a path into a lane, beside its random numbers.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, ray: &Ray, media: Media, bounce: u32) {
        self.rays.set(lane, ray);
        self.media[lane] = media;
        self.bounces.set(lane, bounce);
    }

    /// Takes a path out of its lane.
    #[inline(always)]
    pub(super) fn end(&mut self, lane: usize) {
        self.rays.set_mask(self.rays.mask() & !(1 << lane));
    }

    /// Lets the path of a lane join those that make their next step together, if what it has met
    /// is plain enough.
    #[inline(always)]
    pub(super) fn join<'s>(
        &self,
        scene: &'s Scene,
        max_bounces: u32,
        lane: usize,
        hits: &HitLanes,
        vertices: &mut DiffuseVertices<'s>,
    ) -> bool {
        if !self.may_join || self.bounces.get(lane) >= max_bounces || !self.media[lane].is_vacuum()
        {
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

    /// Takes the path of a lane on along the direction that was drawn, if it is among those that
    /// make the step together.
    #[inline(always)]
    pub(super) fn go_on(&mut self, lane: usize, is_together: bool, samples: &DiffuseSamples) {
        let (origin, direction) = (samples.origin(lane), samples.direction(lane));
        self.rays.replace(lane, is_together, origin, direction);
        let bounce = self.bounces.get(lane) + u32::from(is_together);
        self.bounces.set(lane, bounce);
    }
}

/// The numbers with which paths leave their vertices.
#[derive(Default)]
pub(super) struct DirectionNumbers {
    /// As a BSDF takes them.
    pub(super) bsdf: [Lanes<f32>; 3],
    pub(super) roulette: Lanes<f32>,
}

impl DirectionNumbers {
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, u: &BounceNumbers) {
        for (lanes, u) in self.bsdf.iter_mut().zip(u.bsdf()) {
            lanes.set(lane, u);
        }
        self.roulette.set(lane, u.roulette);
    }
}

/// Light that gets to its end if nothing is in the way, and the rays that tell.
#[derive(Default)]
pub(super) struct Unseen {
    value: RgbLanes,
    mis_weight: Lanes<f32>,
    /// Where on the raster the end is, for light that gets to the lens.
    raster: [Lanes<f32>; 2],
    rays: RayLanes,
    is_there: Lanes<u32>,
    /// 1 where anything may be in between.
    is_apart: Lanes<u32>,
}

/// Light that has got to its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) lane: usize,
    pub(super) value: Rgb,
    pub(super) mis_weight: f32,
    pub(super) raster: Vec2,
}

impl Unseen {
    /// Sets a lane: whether there is light, its value and weight, and its ray. The values are not
    /// an `Option`, or no vectors are made of the loop that sets them.
    #[inline(always)]
    pub(super) fn set(
        &mut self,
        lane: usize,
        is_there: bool,
        value: Rgb,
        mis_weight: f32,
        ray: &Ray,
    ) {
        self.is_there.set(lane, u32::from(is_there));
        self.value.set(lane, value);
        self.mis_weight.set(lane, mis_weight);
        self.rays.set_segment(lane, ray);
        self.is_apart.set(lane, u32::from(is_segment(ray)));
    }

    /// True if there is light in a lane.
    #[inline(always)]
    pub(super) fn is_there(&self, lane: usize) -> bool {
        self.is_there.get(lane) != 0
    }

    /// Puts the light of a lane of others into a lane, its place on the raster left out.
    #[inline(always)]
    pub(super) fn copy(&mut self, lane: usize, others: &Self, of: usize) {
        self.value.set(lane, others.value.get(of));
        self.mis_weight.set(lane, others.mis_weight.get(of));
        self.rays.copy(lane, &others.rays, of);
        self.is_there.set(lane, others.is_there.get(of));
        self.is_apart.set(lane, others.is_apart.get(of));
    }

    /// Sets the place of a lane's end on the raster.
    #[inline(always)]
    pub(super) fn set_raster(&mut self, lane: usize, raster: Vec2) {
        self.raster[0].set(lane, raster.x);
        self.raster[1].set(lane, raster.y);
    }

    /// Weights, to be changed.
    #[inline(always)]
    pub(super) fn mis_weights(&mut self) -> &mut Lanes<f32> {
        &mut self.mis_weight
    }

    /// What is seen of the light of some lanes (one bit for each).
    #[inline(always)]
    pub(super) fn see(
        &mut self,
        lanes: u32,
        tracer: &mut Tracer<'_>,
    ) -> impl Iterator<Item = Seen> + use<'_> {
        self.rays
            .set_mask_where(lanes, &self.is_there, &self.is_apart);
        let shares = tracer.transmittances(&self.rays);
        let this = &*self;
        lanes_of(lanes)
            .filter(move |&lane| this.is_there(lane) && shares[lane] > 0.0)
            .map(move |lane| Seen {
                lane,
                value: this.value.get(lane) * shares[lane],
                mis_weight: this.mis_weight.get(lane),
                raster: Vec2::new(this.raster[0].get(lane), this.raster[1].get(lane)),
            })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use crate::integrator::{METHODS, Method, ParameterValues};
    use crate::radiometry::Rgb;
    use crate::render::{CancelToken, RenderSettings, Renderer, WorkerPool};
    use crate::scene::Scene;
    use crate::scene::builtin::builtin;
    use crate::scene::description::{EnvironmentDescription, Lens, SceneDescription};

    /// Scenes that have, between them, all that paths may join for or have to do by themselves:
    /// smooth normals, mirrors and glass, coats, a tree of lights, a sky, volumes.
    const SCENES: [&str; 6] = ["cornell", "cornell-glass", "plates", "many", "sky", "pool"];

    /// A scene under a sky of one radiance instead of its lights, where paths split.
    fn under_even_sky(scene: &str) -> SceneDescription {
        let mut description = builtin(scene).unwrap().load().unwrap();
        for material in &mut description.materials {
            material.emission = Rgb::BLACK;
        }
        description.environment = Some(EnvironmentDescription::uniform(Rgb::WHITE));
        description
    }

    /// Two iterations of a scene, seen through a lens, layer by layer.
    fn layers(description: &SceneDescription, method: &'static Method, is_alone: bool) -> Vec<Rgb> {
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
        renderer.trace_alone(is_alone);
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

    /// Paths of pixels have the same bits; what falls on one pixel from elsewhere may be added in
    /// another order.
    #[test]
    fn paths_side_by_side_are_those_that_walk_alone() {
        let plain = SCENES.map(|name| (name, builtin(name).unwrap().load().unwrap()));
        let skies = ["cornell", "cornell-glass"].map(|name| (name, under_even_sky(name)));
        for (name, scene) in plain.iter().chain(&skies) {
            for method in ["pt-mis", "lt", "bdpt", "vcm"] {
                let method = METHODS.iter().find(|m| m.id == method).unwrap();
                let (together, alone) = (layers(scene, method, false), layers(scene, method, true));
                let bound = if method.id == "pt-mis" { 0.0 } else { 1e-5 };
                for (a, b) in together.iter().zip(&alone) {
                    let apart = (*a - *b).map(f32::abs).max_channel();
                    let id = method.id;
                    assert!(
                        apart <= bound * b.max_channel(),
                        "{id}, {name}: {a:?}, {b:?}"
                    );
                }
            }
        }
    }
}
