//! Light subpaths: every vertex is aimed at the lens and kept, to be joined to camera subpaths.
//!
//! Sixteen walk side by side ([`crate::integrator::lanes`]). A step is made alone
//! ([`LightEnd::step`]) or with those of other lanes ([`LightEnd::step_together`]).

use glam::{Vec2, Vec3};

use super::connect::{
    contribution, hit_lens, see_light, see_panel_unshadowed, splat, splat_unshadowed,
};
use super::lanes::{Directions, VertexLanes, WalkLanes, knowing_heuristic};
use super::walk::{Carried, CarriedLanes};
use super::{Heuristic, MisWeights, Partial, Vertex, Walk};
use crate::accel::{Hit, HitLanes};
use crate::bsdf::TransportMode;
use crate::endpoint::light::PanelLanes;
use crate::endpoint::{Camera, Spread, Start, StartDensities};
use crate::film::Strategy;
use crate::integrator::lanes::Unseen;
use crate::math::Ray;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, lanes_of, vectorized};
use crate::math::ray::NO_TRIANGLE;
use crate::pass::{LightPaths, Sink};
use crate::photons::Photon;
use crate::radiometry::Rgb;
use crate::sampling::{Sampler, StartNumbers};
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
    /// How they bring light to the lens.
    pub(in crate::integrator) to_lens: ToLens,
    pub(in crate::integrator) weighing: MisWeights,
}

/// A light subpath that is to be walked.
pub(in crate::integrator) struct LightPath {
    /// Its number in the iteration, which is its name.
    pub(in crate::integrator) path: u32,
    /// The number by which its vertices are kept.
    pub(in crate::integrator) number: u32,
    /// Its random numbers.
    pub(in crate::integrator) sampler: Sampler<'static>,
}

/// How light subpaths bring light to the lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::integrator) enum ToLens {
    /// Not at all: their vertices are kept, and that is all.
    Never,
    /// By aiming at it from where lights start them and from all vertices (t = 1).
    Aimed,
    /// By aiming at it from all vertices, and by running into it (t = 1, t = 0).
    AimedOrMet,
}

/// A vertex of a light subpath as it is kept: also what makes the surface there again.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct LightVertex {
    pub(in crate::integrator) photon: Photon,
    pub(in crate::integrator) partial: Partial,
    barycentrics: [f32; 2],
}

/// The subpaths of all lanes, and what they need to make steps together.
struct Lights<'s> {
    walks: WalkLanes<'static>,
    /// The number that each subpath has.
    numbers: [u32; LANES],
    starts: Starts,
    vertices: VertexLanes<'s>,
    directions: Directions,
    u_lens: [Lanes<f32>; 2],
    /// What the lens sees of the vertices.
    seen: Unseen,
}

impl LightEnd<'_> {
    /// Traces subpaths, and hands their vertices to `keep`.
    pub(in crate::integrator) fn trace(
        &self,
        mut paths: impl Iterator<Item = LightPath>,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
        mut keep: impl FnMut(u32, LightVertex),
    ) {
        let mut lights = Lights {
            walks: WalkLanes::new(TransportMode::Importance, sink),
            numbers: [0; LANES],
            starts: Starts::default(),
            vertices: VertexLanes::new(self.scene),
            directions: Directions::default(),
            u_lens: Default::default(),
            seen: Unseen::default(),
        };
        loop {
            let is_last = self.start_all(&mut paths, &mut lights, tracer, sink);
            let taken = lights.walks.common.taken();
            if taken == 0 {
                if is_last {
                    return;
                }
                continue;
            }
            // What do they meet? Some go on from there together, the others each by itself.
            let hits = tracer.hits(&lights.walks.common.rays);
            let mut together = 0;
            for lane in lanes_of(taken) {
                let vertices = &mut lights.vertices;
                let walks = &mut lights.walks;
                if walks.join(self.scene, self.max_bounces, lane, &hits, vertices) {
                    together |= 1 << lane;
                    continue;
                }
                let (number, mut walk) = (lights.numbers[lane], walks.get(lane));
                let sampler = &walks.common.samplers[lane];
                let found = hits[lane].as_ref();
                let goes_on = self.step(&mut walk, found, tracer, sampler, sink, |vertex| {
                    keep(number, vertex);
                });
                if goes_on {
                    walks.set(lane, &walk);
                } else {
                    walks.common.end(lane);
                }
            }
            if together != 0 {
                self.step_together(&mut lights, together, &hits, tracer, sink, &mut keep);
            }
            // Those that could be joined to nothing any more end before they meet it.
            for lane in lanes_of(lights.walks.common.taken()) {
                if lights.walks.common.bounces.get(lane) >= self.most_bounces() {
                    lights.walks.common.end(lane);
                }
            }
        }
    }

    /// Scattering events after which a subpath is of no use.
    fn most_bounces(&self) -> u32 {
        self.max_bounces + u32::from(self.meets_lens())
    }

    fn aims_at_lens(&self) -> bool {
        self.to_lens != ToLens::Never
    }

    fn meets_lens(&self) -> bool {
        self.to_lens == ToLens::AimedOrMet && self.camera.has_lens()
    }

    /// A light starts a subpath; `None` if it goes nowhere. The lens may see where it starts.
    fn start(
        &self,
        tracer: &mut Tracer<'_>,
        u: &StartNumbers,
        sink: &mut Sink<'_>,
    ) -> Option<Walk> {
        let start = self.scene.lights().start(&start_sample(u))?;
        let walk = Walk::from_light(&start, tracer, &self.weighing);
        if self.to_lens == ToLens::Aimed {
            let (camera, n) = (self.camera, self.n_paths);
            let seen = see_light(tracer, camera, &start, walk.media, u.lens, n);
            if let Some((raster, seen)) = seen {
                sink.splat(raster, seen);
            }
        }
        (self.most_bounces() > 0).then_some(walk)
    }

    /// One step of a subpath, from what it meets on to the next ray; false where it ends. Vertices
    /// that can be joined are handed to `keep`.
    fn step(
        &self,
        walk: &mut Walk,
        found: Option<&Hit>,
        tracer: &mut Tracer<'_>,
        sampler: &Sampler<'_>,
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
        let u = sampler.bounce(walk.bounce());
        if vertex.surface.bsdf.has_density() {
            keep(LightVertex::of(&vertex));
            // t = 1: the lens aimed at.
            if self.aims_at_lens() {
                let (camera, n, weighing) = (self.camera, self.n_paths, &self.weighing);
                if let Some((raster, seen)) = splat(tracer, camera, &vertex, u.lens, n, weighing) {
                    sink.splat(raster, seen);
                }
            }
        }
        walk.scatter(&vertex, tracer, &u, self.has_roulette, &self.weighing)
    }

    /// The same step of the subpaths in all lanes that have met plain surfaces.
    fn step_together(
        &self,
        lights: &mut Lights<'_>,
        together: u32,
        hits: &HitLanes,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
        keep: &mut impl FnMut(u32, LightVertex),
    ) {
        let Lights {
            walks,
            numbers,
            vertices,
            directions,
            u_lens,
            seen,
            ..
        } = lights;
        if self.meets_lens() {
            for lane in lanes_of(together) {
                self.meet_lens(&walks.get(lane), hits[lane].as_ref(), tracer, sink);
            }
        }
        walks.arrive(together, self.scene, vertices, &self.weighing);
        for lane in lanes_of(together) {
            let vertex = vertices.get(lane, walks.n_vertices(lane));
            keep(numbers[lane], LightVertex::of(&vertex));
            let common = &walks.common;
            let u = common.samplers[lane].bounce(common.bounces.get(lane));
            directions.numbers.set(lane, &u);
            for (lanes, u) in u_lens.iter_mut().zip(u.lens) {
                lanes.set(lane, u);
            }
        }
        if self.aims_at_lens() {
            see(vertices, u_lens, seen, self.camera, &self.weighing);
            for seen in seen.see(together, tracer) {
                let strategy = Strategy::connect(walks.n_vertices(seen.lane), 1);
                let value = seen.value / self.n_paths as f32;
                sink.splat(seen.raster, contribution(value, seen.mis_weight, strategy));
            }
        }
        let has_roulette = self.has_roulette;
        walks.scatter(together, vertices, directions, has_roulette, &self.weighing);
    }

    /// t = 0: adds what a subpath brings that runs into a lens of finite size before it meets
    /// anything else.
    #[inline]
    fn meet_lens(
        &self,
        walk: &Walk,
        found: Option<&Hit>,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
    ) {
        if self.meets_lens() {
            let (camera, weighing) = (self.camera, &self.weighing);
            let found = hit_lens(tracer, camera, walk, found, self.n_paths, weighing);
            if let Some((raster, seen)) = found {
                sink.splat(raster, seen);
            }
        }
    }

    /// Puts the next subpath into each lane that has none; true if there are no more. Those of
    /// plain triangles start together.
    fn start_all(
        &self,
        paths: &mut impl Iterator<Item = LightPath>,
        lights: &mut Lights<'_>,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
    ) -> bool {
        let Lights {
            walks,
            numbers,
            starts,
            ..
        } = lights;
        let (mut together, mut is_last) = (0, false);
        for lane in lanes_of(walks.common.free()) {
            let Some(LightPath {
                path,
                number,
                sampler,
            }) = paths.next()
            else {
                is_last = true;
                break;
            };
            numbers[lane] = number;
            tracer.next_light_path(path);
            let u = sampler.start();
            if walks.common.may_join() && starts.choose(self.scene, lane, &u) {
                together |= 1 << lane;
            } else if let Some(walk) = self.start(tracer, &u, sink) {
                walks.set(lane, &walk);
            }
            walks.common.samplers[lane] = sampler;
        }
        if together != 0 {
            self.start_together(walks, starts, together, tracer, sink);
        }
        is_last
    }

    /// Starts the subpaths of the lanes that have been chosen for: [`Self::start`].
    fn start_together(
        &self,
        walks: &mut WalkLanes<'_>,
        starts: &mut Starts,
        together: u32,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
    ) {
        start(starts, self.camera, &self.weighing);
        let mut started = 0;
        for lane in lanes_of(together) {
            started |= starts.is_started.get(lane) << lane;
        }
        if self.to_lens == ToLens::Aimed {
            for seen in starts.seen.see(started, tracer) {
                let value = seen.value / self.n_paths as f32;
                let strategy = Strategy::connect(1, 1);
                sink.splat(seen.raster, contribution(value, 1.0, strategy));
            }
        }
        if self.most_bounces() == 0 {
            return;
        }
        for lane in lanes_of(started) {
            let ray = Ray::new(starts.origin.get(lane), starts.direction.get(lane))
                .leaving(starts.leaves.get(lane));
            let carried = starts.carried.get(lane);
            walks.set(
                lane,
                &Walk::leaving_light(ray, carried, starts.lights[lane]),
            );
        }
    }
}

/// Light paths, each kept by its place among those that are handed over.
pub(in crate::integrator) fn numbered(paths: LightPaths) -> impl Iterator<Item = LightPath> {
    let first = paths.next_number();
    paths.enumerate().map(move |(number, sampler)| LightPath {
        path: (first + number) as u32,
        number: number as u32,
        sampler,
    })
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

vectorized! {
    /// Aims at the lens.
    fn see(
        vertices: &VertexLanes<'_>,
        u: &[Lanes<f32>; 2],
        seen: &mut Unseen,
        camera: &Camera,
        weighing: &MisWeights,
    ) {
        knowing_heuristic!(weighing => see_lanes(vertices, u, seen, camera, weighing));
    }
}

#[inline(always)]
fn see_lanes(
    vertices: &VertexLanes<'_>,
    u: &[Lanes<f32>; 2],
    seen: &mut Unseen,
    camera: &Camera,
    weighing: &MisWeights,
) {
    for lane in 0..LANES {
        let vertex = vertices.get(lane, 0);
        let u = [u[0].get(lane), u[1].get(lane)];
        let splat = splat_unshadowed(camera, &vertex, u, weighing);
        let raster = splat.as_ref().map_or(Vec2::ZERO, |splat| splat.raster);
        let wi = splat.as_ref().map_or(Vec3::ZERO, |splat| splat.aim.wi);
        let distance = splat.as_ref().map_or(0.0, |splat| splat.aim.distance);
        let value = splat.as_ref().map_or(Rgb::BLACK, |splat| splat.value);
        let mis_weight = splat.as_ref().map_or(0.0, |splat| splat.mis_weight);
        let point = &vertex.surface.point;
        let ray = point.segment_to_lens(point.position + wi * distance);
        seen.set(lane, splat.is_some(), value, mis_weight, &ray);
        seen.set_raster(lane, raster);
    }
}

/// Subpaths that start together from plain triangles.
#[derive(Default)]
struct Starts {
    panels: PanelLanes,
    u_direction: [Lanes<f32>; 2],
    u_lens: [Lanes<f32>; 2],
    lights: [usize; LANES],
    origin: Vec3Lanes,
    leaves: Lanes<u32>,
    direction: Vec3Lanes,
    carried: CarriedLanes,
    is_started: Lanes<u32>,
    /// What the lens sees of where they start.
    seen: Unseen,
}

impl Starts {
    /// Chooses the light of a lane's subpath; false if it is no plain triangle, or may be within a
    /// body.
    fn choose(&mut self, scene: &Scene, lane: usize, u: &StartNumbers) -> bool {
        let lights = scene.lights();
        if scene.bodies().hold_lights() {
            return false;
        }
        let Some(chosen) = lights.choose_start(u.light) else {
            return false;
        };
        let Some(panel) = lights.as_uniform(chosen.light) else {
            return false;
        };
        self.panels.set(lane, &panel, chosen.pmf, u.position);
        self.lights[lane] = chosen.light;
        for i in 0..2 {
            self.u_direction[i].set(lane, u.direction[i]);
            self.u_lens[i].set(lane, u.lens[i]);
        }
        true
    }
}

vectorized! {
    /// Starts subpaths, and aims at the lens from there.
    fn start(starts: &mut Starts, camera: &Camera, weighing: &MisWeights) {
        knowing_heuristic!(weighing => start_lanes(starts, camera, weighing));
    }
}

#[inline(always)]
fn start_lanes(starts: &mut Starts, camera: &Camera, weighing: &MisWeights) {
    for lane in 0..LANES {
        let u = [
            starts.u_direction[0].get(lane),
            starts.u_direction[1].get(lane),
        ];
        let started = starts.panels.start(lane, u);
        starts.is_started.set(lane, u32::from(started.is_some()));
        let start = started.unwrap_or(NOWHERE);
        let ray = start.ray();
        starts.origin.set(lane, ray.origin());
        starts.leaves.set(lane, ray.leaves());
        starts.direction.set(lane, ray.direction());
        starts
            .carried
            .set(lane, Carried::of_light(&start, weighing));
        let u = [starts.u_lens[0].get(lane), starts.u_lens[1].get(lane)];
        let panels = &starts.panels;
        let seen = see_panel_unshadowed(camera, &start, u, |wo| panels.radiance(lane, wo));
        let raster = seen.as_ref().map_or(Vec2::ZERO, |(raster, ..)| *raster);
        let wi = seen.as_ref().map_or(Vec3::ZERO, |(.., aim)| aim.wi);
        let distance = seen.as_ref().map_or(0.0, |(.., aim)| aim.distance);
        let value = seen.as_ref().map_or(Rgb::BLACK, |(_, value, _)| *value);
        let point = start.point();
        let ray = point.segment_to_lens(point.position + wi * distance);
        starts.seen.set(lane, seen.is_some(), value, 1.0, &ray);
        starts.seen.set_raster(lane, raster);
    }
}

/// In the place of a start that does not take place.
const NOWHERE: Start = Start {
    position: Vec3::ZERO,
    triangle: NO_TRIANGLE,
    ng: Vec3::Z,
    direction: Vec3::Z,
    value: Rgb::BLACK,
    cos: 1.0,
    densities: StartDensities {
        pdf_a: 1.0,
        pdf_w: 1.0,
    },
    spread: Spread::Point { pdf_w: 1.0 },
    light: 0,
    on_triangle: None,
    opacity: 1.0,
    is_delta_position: false,
    is_delta_direction: false,
};
