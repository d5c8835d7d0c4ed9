//! Path tracing with multiple importance sampling.
//!
//! The last one plus one idea: light is both aimed at and run into, and each way
//! is weighed by how well it samples the direction, `w_i = p_i² / (p_1² + p_2²)`
//! ([Veach 1997] 9.2.3.2). A sky of one radiance is not aimed at: the BSDF samples it
//! as it counts. Where there are mirrors or glass, a diffuse surface sends them some of its paths
//! ([`crate::transport::casters`]). Where such a sky is the only light, a path splits in two at its first surface: nearly all of the
//! error is in what of the sky is seen from there. Long paths end by Russian roulette on their throughput.
//!
//! `Walk::step` is the method. `abreast` takes sixteen paths through it side by side, which changes no bit.

use crate::accel::Hit;
use crate::endpoint::LightChoice;
use crate::integrator::{Integrator, Method, Parameter, ParameterKind, ParameterValues, Sight};
use crate::math::Ray;
use crate::radiometry::Rgb;
use crate::render::{Cancelled, Pass, Sink};
use crate::sampling::{Sampler, roulette};
use crate::scene::bodies::Media;
use crate::scene::{Caster, Scene};
use crate::transport::casters::Cones;
use crate::transport::reflection::{Drawn, aim_at_light, light_sample};
use crate::transport::{SurfaceVertex, Tracer};

use super::abreast;
use super::adaptive::{ADAPTIVE, Adaptive};
use super::bsdf::{MODE, bsdf_numbers};
use super::nee::{LIGHTS, light_choice};
use super::{add_unlit, connect, hit};

/// The row of the registry.
pub static METHOD: Method = Method {
    id: "pt-mis",
    title: "PT mis",
    name: "Path tracing, multiple importance sampling",
    about: "Lights are aimed at and run into, each way weighed by how well it samples the direction: \
            small lights and sharp reflections both come out clean.",
    blind_spots: "Lights without extent by way of a mirror or smooth glass: neither can be aimed at the other.",
    sight: Sight::FULL,
    bias: None,
    has_techniques: false,
    parameters: &[
        Parameter {
            name: "roulette",
            title: "Russian roulette",
            unit: "",
            about: "End long paths by chance, in proportion to what they could still carry.",
            kind: ParameterKind::Switch { default: true },
        },
        LIGHTS,
        CASTERS,
        ADAPTIVE,
    ],
    build: |values: &ParameterValues| {
        let mis = Mis {
            choice: match light_choice(values) {
                LightChoice::Tree => LightChoice::TreeBesideBsdf,
                choice => choice,
            },
            has_roulette: values.switch("roulette"),
            has_casters: values.switch(CASTERS.name),
        };
        if values.switch(ADAPTIVE.name) {
            Box::new(Adaptive::new(mis))
        } else {
            Box::new(mis)
        }
    },
};

/// Whether paths are sent to mirrors and glass.
const CASTERS: Parameter = Parameter {
    name: "casters",
    title: "Aim at mirrors and glass",
    unit: "",
    about: "Diffuse surfaces send up to a quarter of their paths to mirrors and smooth glass, where caustics come from.",
    kind: ParameterKind::Switch { default: true },
};

struct Mis {
    choice: LightChoice,
    has_roulette: bool,
    has_casters: bool,
}

impl Integrator for Mis {
    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled> {
        let camera = pass.camera();
        let splits = Walk::splits_in(scene);
        pass.split(if splits { N_SPLITS } else { 1 });
        let walk = Walk {
            scene,
            max_bounces: pass.max_bounces(),
            splits,
            choice: self.choice,
            has_roulette: self.has_roulette,
            casters: if self.has_casters {
                scene.casters()
            } else {
                &[]
            },
        };
        pass.trace_pixels_together(scene, |pixels, tracer, sink| {
            abreast::trace(&walk, camera, pixels, tracer, sink);
        })
    }

    fn traces_only_pixels(&self) -> bool {
        true
    }
}

/// How paths walk.
pub(super) struct Walk<'a> {
    pub(super) scene: &'a Scene,
    pub(super) max_bounces: u32,
    pub(super) choice: LightChoice,
    pub(super) has_roulette: bool,
    /// What diffuse surfaces send some of their paths to.
    pub(super) casters: &'a [Caster],
    /// Whether paths split at their first surface.
    pub(super) splits: bool,
}

/// Paths that one splits into.
pub(super) const N_SPLITS: u8 = 2;

/// A path on its way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    pub(super) ray: Ray,
    pub(super) throughput: Rgb,
    pub(super) media: Media,
    /// Scattering events so far,
    pub(super) bounce: u32,
    /// and those of them that were not at delta lobes.
    pub(super) n_events: u32,
    /// Where the ray's direction was drawn; nothing where it could not have been aimed.
    pub(super) drawn: Option<Drawn>,
}

impl Path {
    /// A path that leaves the camera.
    pub(super) fn new(ray: Ray, tracer: &mut Tracer<'_>) -> Self {
        Self {
            ray,
            throughput: Rgb::WHITE,
            media: tracer.media_at_camera(&ray),
            bounce: 0,
            n_events: 0,
            drawn: None,
        }
    }
}

impl Walk<'_> {
    /// True in a scene where paths split: one lit by nothing but a sky of one radiance.
    pub(super) fn splits_in(scene: &Scene) -> bool {
        let lights = scene.lights();
        let sky = lights.uniform_environment();
        lights.as_slice().len() == 1 && sky.is_some_and(|radiance| !radiance.is_black())
    }

    /// One step of a path, from what its ray has met on to the next ray; `None` where it ends. Others that it splits into, with
    /// their random numbers, are handed to `split_off`.
    #[allow(clippy::too_many_arguments, reason = "a path with all its ends")]
    #[inline(always)]
    pub(super) fn step<'t>(
        &self,
        path: Path,
        found: Option<&Hit>,
        tracer: &mut Tracer<'_>,
        sampler: &mut Sampler<'_>,
        others: impl Iterator<Item = Sampler<'t>>,
        sink: &mut Sink<'_>,
        mut split_off: impl FnMut(Path, Sampler<'t>),
    ) -> Option<Path> {
        let (mut path, vertex) = self.meet(path, found, tracer, sink)?;
        if self.splits && path.bounce == 0 && vertex.bsdf.has_density() {
            path.throughput *= 1.0 / f32::from(N_SPLITS);
            for mut sampler in others {
                if let Some(next) = self.scatter(path, &vertex, tracer, &mut sampler, sink) {
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
        sink: &mut Sink<'_>,
    ) -> Option<(Path, SurfaceVertex<'s>)> {
        let bounce = path.bounce;
        // What does the ray meet? Nothing: the environment emits.
        let ray = path.ray;
        let Some(vertex) = tracer.arrive(&ray, found, &mut path.media, &mut path.throughput) else {
            let direction = path.ray.direction();
            let radiance = self.scene.lights().environment_radiance(direction);
            if !radiance.is_black() {
                let weight = path
                    .drawn
                    .map_or(1.0, |d| d.mis_weight_of_environment(tracer, direction));
                sink.add(hit(bounce, path.throughput * radiance, weight));
            }
            return None;
        };
        if bounce == 0 {
            add_unlit(tracer, &vertex, sink);
        }

        // L_e that was run into, against having been aimed at.
        let emitted = tracer.emitted(&vertex);
        if !emitted.is_black() {
            let weight = path.drawn.map_or(1.0, |d| d.mis_weight(tracer, &vertex));
            sink.add(hit(bounce, path.throughput * emitted, weight));
        }
        (bounce < self.max_bounces).then_some((path, vertex))
    }

    /// Aims at a light from a vertex, and goes on to the next ray; `None` where the path ends.
    fn scatter(
        &self,
        mut path: Path,
        vertex: &SurfaceVertex<'_>,
        tracer: &mut Tracer<'_>,
        sampler: &mut Sampler<'_>,
        sink: &mut Sink<'_>,
    ) -> Option<Path> {
        let (bounce, media) = (path.bounce, path.media);

        // Draw a direction from the BSDF, or towards a mirror or glass.
        let cones = Cones::seen_from(vertex, self.casters);
        let u = bsdf_numbers(sampler, bounce);
        let sample = match &cones {
            Some(cones) => cones.sample(vertex, u, MODE),
            None => vertex.sample(u, MODE),
        };

        // The next event, aimed at, against running into it.
        if vertex.bsdf.has_density() {
            let u = light_sample(sampler);
            if let Some(aimed) = aim_at_light(tracer, vertex, media, self.choice, &u) {
                let value = path.throughput * aimed.value;
                let aimed = cones.map_or(aimed, |cones| cones.beside(aimed));
                sink.add(connect(bounce + 1, value, aimed.mis_weight()));
            }
        }

        // On to the next vertex.
        let sample = sample?;
        path.throughput *= sample.throughput();
        path.drawn = Drawn::at(vertex, self.choice, &sample);

        // Paths that carry little end by chance.
        if !sample.is_delta {
            if self.has_roulette {
                path.throughput *= roulette::play(path.n_events, path.throughput, sampler)?;
            }
            path.n_events += 1;
        }
        path.media = vertex.media_towards(sample.wi, media);
        path.ray = vertex.ray(sample.wi);
        path.bounce += 1;
        Some(path)
    }
}
