//! Camera subpaths: every vertex is joined with the lights and with the vertices of light subpaths.
//!
//! Sixteen walk side by side ([`crate::integrator::lanes`]); [`CameraEnd::trace`] has the order of
//! their steps.

use super::connect::{
    contribution, hit_emitter, hit_environment, next_event, next_event_unshadowed,
};
use super::lanes::{Directions, Met, VertexLanes, WalkLanes, knowing_heuristic};
use super::light::LightVertex;
use super::merging::Merging;
use super::subpath::{LightSubpath, Waiting};
use super::{Heuristic, MisWeights, Vertex, Walk};
use crate::accel::Hit;
use crate::bsdf::TransportMode;
use crate::endpoint::light::PanelLanes;
use crate::endpoint::{Aim, Camera, LightChoice, SurfacePoint};
use crate::film::Strategy;
use crate::integrator::lanes::Unseen;
use crate::integrator::path_tracing::{add_unlit, hit};
use crate::math::lanes::{LANES, Lanes, lanes_of, vectorized};
use crate::pass::{PixelPath, PixelPlace, PixelSample, Pixels, Sink};
use crate::photons::{Near, Search};
use crate::radiometry::Rgb;
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
    pub(in crate::integrator) weighing: MisWeights,
}

/// Scratch memory of the subpaths of some pixels, which those of others may use again.
pub(in crate::integrator) struct CameraScratch<'s> {
    /// What each lane's subpath is connected to.
    lights: Vec<LightSubpath<'s>>,
    waiting: Waiting,
    met: Met<'s>,
    events: AimLanes,
    directions: Directions,
    merges: Vec<Merge>,
    near: Vec<Near>,
}

/// A vertex that is to be merged, with its search. What it looks for is far away in memory: so all
/// lanes search together, and between one step of their searches and the next, other things are
/// done.
struct Merge {
    lane: usize,
    search: Search,
    /// Where what was found for it ends among all that was.
    end: usize,
}

/// What comes of lights that are aimed at.
#[derive(Default)]
struct AimLanes {
    panels: PanelLanes,
    start_over_aim: Lanes<f32>,
    /// The lanes that aim by themselves, one bit for each.
    by_themselves: u32,
    light: Unseen,
}

impl<'s> CameraScratch<'s> {
    /// Room for subpaths in a scene.
    pub(in crate::integrator) fn new(scene: &'s Scene) -> Self {
        Self {
            lights: (0..LANES).map(|_| LightSubpath::new(scene)).collect(),
            waiting: Waiting::default(),
            met: Met::new(scene),
            events: AimLanes::default(),
            directions: Directions::default(),
            merges: Vec::new(),
            near: Vec::new(),
        }
    }
}

impl CameraScratch<'_> {
    /// Goes on with the searches.
    fn approach(&self, end: &CameraEnd<'_>) {
        if let Some(merging) = &end.merging {
            for merge in &self.merges {
                merging.grid().approach(&merge.search);
            }
        }
    }

    /// Ends the searches.
    fn finish(&mut self, end: &CameraEnd<'_>) {
        let Some(merging) = &end.merging else { return };
        self.near.clear();
        for merge in &mut self.merges {
            merging.grid().finish(&merge.search, &mut self.near);
            merge.end = self.near.len();
        }
    }
}

impl CameraEnd<'_> {
    /// The camera starts a subpath.
    fn start(&self, sample: PixelSample, tracer: &mut Tracer<'_>, sampler: &Sampler<'_>) -> Walk {
        let u = sampler.start().lens;
        Walk::from_camera(self.camera, sample.raster, u, tracer, &self.weighing)
    }

    /// s = 0: `L_e`, where a subpath runs into it; the vertex that it goes on from, if it does.
    fn meet<'s>(
        &self,
        walk: &mut Walk,
        found: Option<&Hit>,
        tracer: &mut Tracer<'s>,
        sink: &mut Sink<'_>,
    ) -> Option<Vertex<'s>> {
        let weighing = &self.weighing;
        let Some(vertex) = walk.arrive(found, tracer, weighing) else {
            if self.has_connections {
                if let Some(found) = hit_environment(tracer, walk, weighing) {
                    sink.add(found);
                }
            } else if walk.is_specular {
                let lights = self.scene.lights();
                let radiance = lights.environment_radiance(walk.ray.direction());
                let bounce = u32::from(walk.n_vertices) - 1;
                sink.add(hit(bounce, walk.carried.throughput * radiance, 1.0));
            }
            return None;
        };
        let bounce = walk.bounce();
        if bounce == 0 {
            add_unlit(tracer, &vertex.surface, &mut **sink);
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
        if bounce >= self.max_bounces {
            return None;
        }
        Some(vertex)
    }
}

impl<'s> CameraEnd<'s> {
    /// Traces the subpaths of all pixels, each joined with the light subpath that `light_path`
    /// names.
    pub(in crate::integrator) fn trace<'p>(
        &self,
        mut pixels: Pixels<'_>,
        light_path: impl Fn(&PixelPath<'_>) -> (u32, &'p [LightVertex]),
        scratch: &mut CameraScratch<'s>,
        tracer: &mut Tracer<'s>,
        sink: &mut Sink<'_>,
    ) {
        let mut walks = WalkLanes::new(TransportMode::Radiance, sink);
        let mut places = [PixelPlace::default(); LANES];
        loop {
            // A lane without a subpath takes the next one.
            for lane in lanes_of(walks.common.free()) {
                let Some(pixel) = pixels.next() else {
                    break;
                };
                places[lane] = pixel.place;
                let lights = &mut scratch.lights[lane];
                lights.clear();
                if self.has_connections {
                    let (path, vertices) = light_path(&pixel);
                    sink.joins(path);
                    for vertex in vertices {
                        lights.push(&vertex.restored(tracer));
                    }
                }
                let walk = self.start(pixel.sample, tracer, &pixel.sampler);
                walks.set(lane, &walk);
                walks.common.samplers[lane] = pixel.sampler;
            }
            if walks.common.taken() == 0 {
                break;
            }
            let hits = tracer.hits(&walks.common.rays);
            let (max_bounces, weighing) = (self.max_bounces, &self.weighing);
            let met = &mut scratch.met;
            walks.meet(
                tracer,
                max_bounces,
                weighing,
                &hits,
                met,
                |lane, walk, found, tracer| {
                    sink.start_pixel(places[lane]);
                    self.meet(walk, found, tracer, sink)
                },
            );
            self.begin_merges(&walks, scratch);
            self.draw(&walks, scratch);
            self.aim(&walks, &places, scratch, tracer, sink);
            scratch.approach(self);
            self.connect(&walks, &places, scratch, tracer, sink);
            // None waits for another step, so that what is added to a pixel's layer is in the order
            // of its path.
            scratch
                .waiting
                .see(tracer, |place, found| sink.add_at(place, found));
            scratch.finish(self);
            self.merge(&walks, &places, scratch, sink);
            let (met, directions) = (&mut scratch.met, &mut scratch.directions);
            walks.scatter(met, directions, tracer, self.has_roulette, weighing);
        }
    }

    /// Draws what plain vertices need, and chooses lights to aim at.
    fn draw(&self, walks: &WalkLanes<'_>, scratch: &mut CameraScratch<'s>) {
        let CameraScratch {
            met,
            events,
            directions,
            ..
        } = scratch;
        let lights = self.scene.lights();
        events.by_themselves = walks.common.taken() & !met.plain;
        for lane in lanes_of(met.plain) {
            let u = walks.common.samplers[lane].bounce(walks.common.bounces.get(lane));
            directions.numbers.set(lane, &u);
            if !self.has_connections {
                continue;
            }
            events.panels.clear(lane);
            let receiver = met.vertices.surfaces.receiver(lane);
            let Some(chosen) = lights.choose(&receiver, LightChoice::Tree, u.light) else {
                continue;
            };
            match lights.as_uniform(chosen.light) {
                Some(panel) => {
                    events
                        .panels
                        .set(lane, &panel, chosen.pmf, u.point_on_light);
                    let start_over_aim = lights.pmf_start(chosen.light) / chosen.pmf;
                    events.start_over_aim.set(lane, start_over_aim);
                }
                None => events.by_themselves |= 1 << lane,
            }
        }
    }

    /// s = 1: lights aimed at.
    fn aim(
        &self,
        walks: &WalkLanes<'_>,
        places: &[PixelPlace; LANES],
        scratch: &mut CameraScratch<'s>,
        tracer: &mut Tracer<'s>,
        sink: &mut Sink<'_>,
    ) {
        if !self.has_connections {
            return;
        }
        let CameraScratch { met, events, .. } = scratch;
        for lane in lanes_of(events.by_themselves) {
            let u = light_sample(&met.numbers(lane, walks));
            met.with_vertex(lane, walks, |vertex| {
                if let Some(found) = next_event(tracer, vertex, &u, &self.weighing) {
                    sink.add_at(places[lane], found);
                }
            });
        }
        if met.plain == 0 {
            return;
        }
        aim(&met.vertices, events, &self.weighing);
        for seen in events.light.see(met.plain, tracer) {
            let strategy = Strategy::connect(1, walks.n_vertices(seen.lane));
            let found = contribution(seen.value, seen.mis_weight, strategy);
            sink.add_at(places[seen.lane], found);
        }
    }

    /// s ≥ 2: every vertex of the light subpath that leaves the path short enough.
    fn connect(
        &self,
        walks: &WalkLanes<'_>,
        places: &[PixelPlace; LANES],
        scratch: &mut CameraScratch<'s>,
        tracer: &mut Tracer<'s>,
        sink: &mut Sink<'_>,
    ) {
        if !self.has_connections {
            return;
        }
        let CameraScratch {
            met,
            lights,
            waiting,
            ..
        } = scratch;
        let (weighing, max_bounces) = (&self.weighing, self.max_bounces);
        for lane in lanes_of(walks.common.taken()) {
            let (lights, place) = (&mut lights[lane], places[lane]);
            met.with_vertex(lane, walks, |vertex| {
                let add = |place, found| sink.add_at(place, found);
                lights.connect(tracer, vertex, max_bounces, weighing, waiting, place, add);
            });
        }
    }

    /// Begins to look for what the vertices are to be merged with.
    fn begin_merges(&self, walks: &WalkLanes<'_>, scratch: &mut CameraScratch<'s>) {
        let Some(merging) = &self.merging else { return };
        let CameraScratch { met, merges, .. } = scratch;
        for lane in lanes_of(walks.common.taken()) {
            if let Some(position) = met.position(lane) {
                merges.push(Merge {
                    search: merging.grid().begin(position),
                    lane,
                    end: 0,
                });
            }
        }
    }

    /// Merges all vertices of a step with what was found.
    fn merge(
        &self,
        walks: &WalkLanes<'_>,
        places: &[PixelPlace; LANES],
        scratch: &mut CameraScratch<'s>,
        sink: &mut Sink<'_>,
    ) {
        let Some(merging) = &self.merging else { return };
        let CameraScratch {
            met, merges, near, ..
        } = scratch;
        let mut start = 0;
        for Merge { lane, end, .. } in merges.drain(..) {
            let near = &near[start..end];
            start = end;
            sink.start_pixel(places[lane]);
            met.with_vertex(lane, walks, |vertex| {
                merging.merge(vertex, near, self.max_bounces, &self.weighing, sink);
            });
        }
    }
}

vectorized! {
    /// Aims at the lights.
    fn aim(vertices: &VertexLanes<'_>, events: &mut AimLanes, weighing: &MisWeights) {
        knowing_heuristic!(weighing => aim_lanes(vertices, events, weighing));
    }
}

#[inline(always)]
fn aim_lanes(vertices: &VertexLanes<'_>, events: &mut AimLanes, weighing: &MisWeights) {
    for lane in 0..LANES {
        let vertex = vertices.get(lane, 0);
        let point = &vertex.surface.point;
        let start_over_aim = events.start_over_aim.get(lane);
        let aim = events.panels.aim(lane, point.position).map(|aim| Aim {
            start_over_aim,
            ..aim
        });
        let light = aim.as_ref().and_then(|aim| aim.surface);
        let aimed = aim
            .as_ref()
            .and_then(|aim| next_event_unshadowed(&vertex, aim, weighing));
        let ray = point.segment_to(&light.unwrap_or(SurfacePoint::NOWHERE));
        let (value, mis_weight) = aimed.unwrap_or((Rgb::BLACK, 0.0));
        events
            .light
            .set(lane, aimed.is_some(), value, mis_weight, &ray);
    }
}
