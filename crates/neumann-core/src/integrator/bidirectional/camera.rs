//! Camera subpaths: every vertex is joined with the lights and with the vertices of light subpaths.
//!
//! Sixteen walk side by side ([`crate::integrator::lanes`]). A step is made alone
//! ([`CameraEnd::step`]) or with those of other lanes; the order in which contributions to a pixel
//! are added is all that this changes.

use super::connect::{
    contribution, hit_emitter, hit_environment, next_event, next_event_unshadowed,
};
use super::lanes::{Directions, VertexLanes, WalkLanes, knowing_heuristic};
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
    vertices: VertexLanes<'s>,
    events: AimLanes,
    directions: Directions,
    merges: Vec<Merge<'s>>,
    near: Vec<Near>,
}

/// A vertex that is to be merged, with its search. What it looks for is far away in memory: so all
/// lanes search together, and between one step of their searches and the next, other things are
/// done.
struct Merge<'s> {
    /// The vertex, if it is not that of the lane.
    alone: Option<Vertex<'s>>,
    lane: usize,
    n_vertices: u16,
    search: Search,
    /// Where what was found for it ends among all that was.
    end: usize,
}

/// What comes of lights that are aimed at.
#[derive(Default)]
struct AimLanes {
    panels: PanelLanes,
    start_over_aim: Lanes<f32>,
    light: Unseen,
}

impl<'s> CameraScratch<'s> {
    /// Room for subpaths in a scene.
    pub(in crate::integrator) fn new(scene: &'s Scene) -> Self {
        Self {
            lights: (0..LANES).map(|_| LightSubpath::new(scene)).collect(),
            waiting: Waiting::default(),
            vertices: VertexLanes::new(scene),
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

    /// One step of a subpath, from what it meets on to the next ray; false where it ends. A vertex
    /// that is to be merged is handed to `merge`.
    #[allow(clippy::too_many_arguments, reason = "a path with all its ends")]
    fn step<'s>(
        &self,
        walk: &mut Walk,
        found: Option<&Hit>,
        lights: &mut LightSubpath<'s>,
        waiting: &mut Waiting,
        tracer: &mut Tracer<'s>,
        sampler: &Sampler<'_>,
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
                sink.add(hit(bounce, walk.carried.throughput * radiance, 1.0));
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
        let u = sampler.bounce(bounce);
        if vertex.surface.bsdf.has_density() {
            if self.has_connections {
                // s = 1: a light aimed at.
                if let Some(found) = next_event(tracer, &vertex, &light_sample(&u), weighing) {
                    sink.add(found);
                }
                // s ≥ 2: every vertex of the light subpath that leaves the path short enough.
                lights.connect(
                    tracer,
                    &vertex,
                    self.max_bounces,
                    weighing,
                    waiting,
                    sink.pixel(),
                    |place, found| sink.add_at(place, found),
                );
            }
            if self.merging.is_some() {
                merge(vertex);
            }
        }
        walk.scatter(&vertex, tracer, &u, self.has_roulette, weighing)
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
            // What do they meet? Some go on from there together, the others each by itself.
            let hits = tracer.hits(&walks.common.rays);
            let mut together = 0;
            for lane in lanes_of(walks.common.taken()) {
                let vertices = &mut scratch.vertices;
                if walks.join(self.scene, self.max_bounces, lane, &hits, vertices) {
                    together |= 1 << lane;
                }
            }
            if together != 0 {
                walks.arrive(together, self.scene, &mut scratch.vertices, &self.weighing);
                together = self.draw(together, &walks, scratch);
            }
            for lane in lanes_of(walks.common.taken() & !together) {
                sink.start_pixel(places[lane]);
                let mut walk = walks.get(lane);
                let goes_on = self.step(
                    &mut walk,
                    hits[lane].as_ref(),
                    &mut scratch.lights[lane],
                    &mut scratch.waiting,
                    tracer,
                    &walks.common.samplers[lane],
                    sink,
                    |vertex| self.begin_merge(lane, &vertex, Some(vertex), &mut scratch.merges),
                );
                if goes_on {
                    walks.set(lane, &walk);
                } else {
                    walks.common.end(lane);
                }
            }
            if together != 0 {
                self.begin_merges(together, &walks, scratch);
                self.aim(together, &walks, &places, scratch, tracer, sink);
                scratch.approach(self);
                self.connect(together, &walks, &places, scratch, tracer, sink);
            }
            // None waits for another step, so that what is added to a pixel's layer is in the order
            // of its path.
            scratch
                .waiting
                .see(tracer, |place, found| sink.add_at(place, found));
            scratch.finish(self);
            if together != 0 {
                let (vertices, directions) = (&scratch.vertices, &mut scratch.directions);
                walks.scatter(
                    together,
                    vertices,
                    directions,
                    self.has_roulette,
                    &self.weighing,
                );
            }
            self.merge(&places, scratch, sink);
        }
    }

    /// Draws what the lanes need, and chooses lights to aim at; returns those lanes whose lights
    /// are plain triangles.
    fn draw(
        &self,
        mut together: u32,
        walks: &WalkLanes<'_>,
        scratch: &mut CameraScratch<'s>,
    ) -> u32 {
        let lights = self.scene.lights();
        let events = &mut scratch.events;
        for lane in lanes_of(together) {
            let u = walks.common.samplers[lane].bounce(walks.common.bounces.get(lane));
            scratch.directions.numbers.set(lane, &u);
            if !self.has_connections {
                continue;
            }
            let receiver = scratch.vertices.surfaces.receiver(lane);
            let Some(chosen) = lights.choose(&receiver, LightChoice::Tree, u.light) else {
                events.panels.clear(lane);
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
                None => together &= !(1 << lane),
            }
        }
        together
    }

    /// s = 1: lights aimed at.
    fn aim(
        &self,
        together: u32,
        walks: &WalkLanes<'_>,
        places: &[PixelPlace; LANES],
        scratch: &mut CameraScratch<'s>,
        tracer: &mut Tracer<'s>,
        sink: &mut Sink<'_>,
    ) {
        if !self.has_connections {
            return;
        }
        let events = &mut scratch.events;
        aim(&scratch.vertices, events, &self.weighing);
        for seen in events.light.see(together, tracer) {
            let strategy = Strategy::connect(1, walks.n_vertices(seen.lane));
            let found = contribution(seen.value, seen.mis_weight, strategy);
            sink.add_at(places[seen.lane], found);
        }
    }

    /// s ≥ 2: every vertex of the light subpaths that leaves the path short enough.
    fn connect(
        &self,
        together: u32,
        walks: &WalkLanes<'_>,
        places: &[PixelPlace; LANES],
        scratch: &mut CameraScratch<'s>,
        tracer: &mut Tracer<'s>,
        sink: &mut Sink<'_>,
    ) {
        if !self.has_connections {
            return;
        }
        let (weighing, waiting) = (&self.weighing, &mut scratch.waiting);
        for lane in lanes_of(together) {
            let vertex = scratch.vertices.get(lane, walks.n_vertices(lane));
            scratch.lights[lane].connect(
                tracer,
                &vertex,
                self.max_bounces,
                weighing,
                waiting,
                places[lane],
                |place, found| sink.add_at(place, found),
            );
        }
    }

    /// Begins to look for what the vertices of the lanes are to be merged with.
    fn begin_merges(&self, together: u32, walks: &WalkLanes<'_>, scratch: &mut CameraScratch<'s>) {
        if self.merging.is_none() {
            return;
        }
        for lane in lanes_of(together) {
            let vertex = scratch.vertices.get(lane, walks.n_vertices(lane));
            self.begin_merge(lane, &vertex, None, &mut scratch.merges);
        }
    }

    /// Begins to look for what a vertex is to be merged with.
    #[inline(always)]
    fn begin_merge(
        &self,
        lane: usize,
        vertex: &Vertex<'s>,
        alone: Option<Vertex<'s>>,
        merges: &mut Vec<Merge<'s>>,
    ) {
        if let Some(merging) = &self.merging {
            merges.push(Merge {
                search: merging.grid().begin(vertex.surface.point.position),
                alone,
                lane,
                n_vertices: vertex.n_vertices,
                end: 0,
            });
        }
    }

    /// Merges all vertices of a step with what was found.
    fn merge(
        &self,
        places: &[PixelPlace; LANES],
        scratch: &mut CameraScratch<'s>,
        sink: &mut Sink<'_>,
    ) {
        let Some(merging) = &self.merging else { return };
        let mut start = 0;
        for merge in scratch.merges.drain(..) {
            let near = &scratch.near[start..merge.end];
            start = merge.end;
            let in_lane;
            let vertex = match &merge.alone {
                Some(vertex) => vertex,
                None => {
                    in_lane = scratch.vertices.get(merge.lane, merge.n_vertices);
                    &in_lane
                }
            };
            sink.start_pixel(places[merge.lane]);
            merging.merge(vertex, near, self.max_bounces, &self.weighing, sink);
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
