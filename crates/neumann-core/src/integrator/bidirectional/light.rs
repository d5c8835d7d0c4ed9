//! Light subpaths: every vertex is aimed at the lens and kept, to be joined to camera subpaths.
//!
//! Sixteen walk side by side ([`crate::integrator::lanes`]); [`LightEnd::trace`] has the order of
//! their steps.

use glam::{Vec2, Vec3};

use super::connect::{
    contribution, hit_lens, see_light, see_panel_unshadowed, splat, splat_unshadowed,
};
use super::lanes::{Directions, Met, VertexLanes, WalkLanes, knowing_heuristic};
use super::walk::{Carried, CarriedLanes};
use super::{Heuristic, MisWeights, Partial, Vertex, Walk};
use crate::accel::HitLanes;
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
    met: Met<'s>,
    directions: Directions,
    u_lens: [Lanes<f32>; 2],
    /// What the lens sees of the vertices.
    seen: Unseen,
}

impl LightEnd<'_> {
    /// Traces subpaths, and hands their vertices to `keep`.
    pub(in crate::integrator) fn trace<'s>(
        &self,
        mut paths: impl Iterator<Item = LightPath>,
        tracer: &mut Tracer<'s>,
        sink: &mut Sink<'_>,
        mut keep: impl FnMut(u32, LightVertex),
    ) {
        let mut lights = Lights {
            walks: WalkLanes::new(TransportMode::Importance, sink),
            numbers: [0; LANES],
            starts: Starts::default(),
            met: Met::new(tracer.scene),
            directions: Directions::default(),
            u_lens: Default::default(),
            seen: Unseen::default(),
        };
        loop {
            let is_last = self.start(&mut paths, &mut lights, tracer, sink);
            let taken = lights.walks.common.taken();
            if taken == 0 {
                if is_last {
                    return;
                }
                continue;
            }
            let hits = tracer.hits(&lights.walks.common.rays);
            self.meet_lens(&lights.walks, &hits, tracer, sink);
            self.meet(&mut lights, &hits, tracer);
            self.keep(&mut lights, &mut keep);
            self.aim(&mut lights, tracer, sink);
            let Lights {
                walks,
                met,
                directions,
                ..
            } = &mut lights;
            walks.scatter(met, directions, tracer, self.has_roulette, &self.weighing);
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

    /// t = 0: adds what subpaths bring that run into a lens of finite size before they meet
    /// anything else.
    fn meet_lens(
        &self,
        walks: &WalkLanes<'_>,
        hits: &HitLanes,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
    ) {
        if !self.meets_lens() {
            return;
        }
        let (camera, n, weighing) = (self.camera, self.n_paths, &self.weighing);
        for lane in lanes_of(walks.common.taken()) {
            let (walk, found) = (walks.get(lane), hits[lane].as_ref());
            if let Some((raster, seen)) = hit_lens(tracer, camera, &walk, found, n, weighing) {
                sink.splat(raster, seen);
            }
        }
    }

    /// Takes all subpaths to what they have met.
    fn meet<'s>(&self, lights: &mut Lights<'s>, hits: &HitLanes, tracer: &mut Tracer<'s>) {
        let (max_bounces, weighing) = (self.max_bounces, &self.weighing);
        let Lights { walks, met, .. } = lights;
        walks.meet(
            tracer,
            max_bounces,
            weighing,
            hits,
            met,
            |_, walk, found, tracer| {
                let vertex = walk.arrive(found, tracer, weighing)?;
                if walk.bounce() >= max_bounces {
                    return None;
                }
                Some(vertex)
            },
        );
    }

    /// Hands the vertices that can be joined to `keep`.
    fn keep(&self, lights: &mut Lights<'_>, keep: &mut impl FnMut(u32, LightVertex)) {
        let Lights {
            walks,
            numbers,
            met,
            directions,
            u_lens,
            ..
        } = lights;
        for lane in lanes_of(walks.common.taken()) {
            if met.plain >> lane & 1 == 0 {
                if let Some(other) = met.other(lane) {
                    keep(numbers[lane], LightVertex::of(other));
                }
                continue;
            }
            let vertex = met.vertices.get(lane, walks.n_vertices(lane));
            keep(numbers[lane], LightVertex::of(&vertex));
            let common = &walks.common;
            let u = common.samplers[lane].bounce(common.bounces.get(lane));
            directions.numbers.set(lane, &u);
            for (lanes, u) in u_lens.iter_mut().zip(u.lens) {
                lanes.set(lane, u);
            }
        }
    }

    /// t = 1: aims at the lens.
    fn aim(&self, lights: &mut Lights<'_>, tracer: &mut Tracer<'_>, sink: &mut Sink<'_>) {
        if !self.aims_at_lens() {
            return;
        }
        let Lights {
            walks,
            met,
            u_lens,
            seen,
            ..
        } = lights;
        let (camera, n, weighing) = (self.camera, self.n_paths, &self.weighing);
        for lane in lanes_of(walks.common.taken() & !met.plain) {
            let Some(vertex) = met.other(lane) else {
                continue;
            };
            let u = met.numbers(lane, walks);
            if let Some((raster, seen)) = splat(tracer, camera, vertex, u.lens, n, weighing) {
                sink.splat(raster, seen);
            }
        }
        if met.plain == 0 {
            return;
        }
        see(&met.vertices, u_lens, seen, camera, weighing);
        for seen in seen.see(met.plain, tracer) {
            let strategy = Strategy::connect(walks.n_vertices(seen.lane), 1);
            let value = seen.value / n as f32;
            sink.splat(seen.raster, contribution(value, seen.mis_weight, strategy));
        }
    }

    /// Puts the next subpath into each lane that has none; true if there are no more. The lens may
    /// see where they start.
    fn start(
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
        let (camera, n, weighing) = (self.camera, self.n_paths, &self.weighing);
        let (mut plain, mut is_last) = (0, false);
        starts.others.clear();
        for lane in lanes_of(walks.common.free()) {
            let Some(next) = paths.next() else {
                is_last = true;
                break;
            };
            numbers[lane] = next.number;
            tracer.next_light_path(next.path);
            let u = next.sampler.start();
            walks.common.samplers[lane] = next.sampler;
            if walks.common.may_join() && starts.choose(self.scene, lane, &u) {
                plain |= 1 << lane;
            } else if let Some(start) = self.scene.lights().start(&start_sample(&u)) {
                let walk = Walk::from_light(&start, tracer, weighing);
                let u_lens = u.lens;
                starts.others.push(OtherStart {
                    lane,
                    start,
                    walk,
                    u_lens,
                });
            }
        }
        let plain = starts.complete(plain, camera, weighing);
        // t = 1 at the light itself.
        if self.to_lens == ToLens::Aimed {
            for other in &starts.others {
                let (media, u) = (other.walk.media, other.u_lens);
                let seen = see_light(tracer, camera, &other.start, media, u, n);
                if let Some((raster, seen)) = seen {
                    sink.splat(raster, seen);
                }
            }
            for seen in starts.seen.see(plain, tracer) {
                let value = seen.value / n as f32;
                let strategy = Strategy::connect(1, 1);
                sink.splat(seen.raster, contribution(value, 1.0, strategy));
            }
        }
        // On their way.
        if self.most_bounces() > 0 {
            for OtherStart { lane, walk, .. } in &starts.others {
                walks.set(*lane, walk);
            }
            for lane in lanes_of(plain) {
                walks.set(lane, &starts.walk(lane));
            }
        }
        is_last
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

/// Subpaths that start: side by side from plain triangles, each other one by itself.
#[derive(Default)]
struct Starts {
    others: Vec<OtherStart>,
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

/// The start of a lane's subpath by itself.
struct OtherStart {
    lane: usize,
    start: Start,
    walk: Walk,
    u_lens: [f32; 2],
}

impl Starts {
    /// Starts those that were chosen for (one bit for each lane), and returns those that go
    /// anywhere.
    fn complete(&mut self, chosen: u32, camera: &Camera, weighing: &MisWeights) -> u32 {
        if chosen == 0 {
            return 0;
        }
        start(self, camera, weighing);
        lanes_of(chosen).fold(0, |all, lane| all | self.is_started.get(lane) << lane)
    }

    /// The subpath of a lane, on its way from a plain triangle.
    #[inline(always)]
    fn walk(&self, lane: usize) -> Walk {
        let ray = Ray::new(self.origin.get(lane), self.direction.get(lane))
            .leaving(self.leaves.get(lane));
        Walk::leaving_light(ray, self.carried.get(lane), self.lights[lane])
    }

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
