//! Sixteen camera subpaths abreast ([`crate::integrator::abreast`]).

use super::CameraEnd;
use crate::accel::RayLanes;
use crate::bsdf::TransportMode;
use crate::endpoint::light::PanelLanes;
use crate::endpoint::{Aim, LightChoice, SurfacePoint};
use crate::film::Strategy;
use crate::integrator::bidirectional::connect::{contribution, next_event_unshadowed};
use crate::integrator::bidirectional::lanes::{
    Directions, VertexLanes, WalkLanes, knowing_heuristic,
};
use crate::integrator::bidirectional::light::LightVertex;
use crate::integrator::bidirectional::subpath::{LightSubpath, Unseen};
use crate::integrator::bidirectional::{Heuristic, Vertex, Weighing};
use crate::math::lanes::{LANES, Lanes, lanes_of, vectorized};
use crate::photons::{Near, Search};
use crate::radiometry::{Rgb, RgbLanes};
use crate::render::{PixelPath, PixelPlace, Pixels, Sink};
use crate::scene::Scene;
use crate::transport::{Tracer, is_segment};

/// Memory for the subpaths of a tile, which the next one may use again.
pub(in crate::integrator) struct CameraRoom<'s> {
    /// What each lane's subpath is connected to.
    lights: Vec<LightSubpath<'s>>,
    unseen: Unseen,
    vertices: VertexLanes<'s>,
    events: Events,
    directions: Directions,
    merges: Vec<Merge<'s>>,
    near: Vec<Near>,
}

/// A vertex that is to be merged, with its search. What it looks for is far away in memory: so all lanes search together, and
/// between one step of their searches and the next, other things are done.
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
struct Events {
    panels: PanelLanes,
    start_over_aim: Lanes<f32>,
    value: RgbLanes,
    mis_weight: Lanes<f32>,
    shadows: RayLanes,
    is_aimed: Lanes<u32>,
    is_apart: Lanes<u32>,
}

impl<'s> CameraRoom<'s> {
    /// Room for subpaths in a scene.
    pub(in crate::integrator) fn new(scene: &'s Scene) -> Self {
        Self {
            lights: (0..LANES).map(|_| LightSubpath::new(scene)).collect(),
            unseen: Unseen::default(),
            vertices: VertexLanes::new(scene),
            events: Events::default(),
            directions: Directions::default(),
            merges: Vec::new(),
            near: Vec::new(),
        }
    }
}

impl CameraRoom<'_> {
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

impl<'s> CameraEnd<'s> {
    /// Traces the subpaths of all pixels, each joined with the light subpath that `light_path` names.
    pub(in crate::integrator) fn trace<'p>(
        &self,
        mut pixels: Pixels<'_>,
        light_path: impl Fn(&PixelPath<'_>) -> &'p [LightVertex],
        room: &mut CameraRoom<'s>,
        tracer: &mut Tracer<'s>,
        sink: &mut Sink<'_>,
    ) {
        let mut walks = WalkLanes::new(TransportMode::Radiance);
        let mut places = [PixelPlace::default(); LANES];
        loop {
            // A lane without a subpath takes the next one.
            for lane in lanes_of(!walks.common.rays.mask()) {
                let Some(mut pixel) = pixels.next() else {
                    break;
                };
                places[lane] = pixel.place;
                let lights = &mut room.lights[lane];
                lights.clear();
                if self.has_connections {
                    for vertex in light_path(&pixel) {
                        lights.push(&vertex.restored(tracer));
                    }
                }
                let walk = self.start(pixel.sample, tracer, &mut pixel.sampler);
                walks.set(lane, &walk);
                walks.common.samplers[lane] = pixel.sampler;
            }
            if walks.common.rays.mask() == 0 {
                break;
            }
            // What do they meet? Some go on from there together, the others each by itself.
            let hits = tracer.hits(&walks.common.rays);
            let mut abreast = 0;
            for lane in lanes_of(walks.common.rays.mask()) {
                let vertices = &mut room.vertices;
                if walks.join(self.scene, self.max_bounces, lane, &hits, vertices) {
                    abreast |= 1 << lane;
                }
            }
            if abreast != 0 {
                walks.arrive(abreast, self.scene, &mut room.vertices, &self.weighing);
                abreast = self.draw(abreast, &walks, room);
            }
            for lane in lanes_of(walks.common.rays.mask() & !abreast) {
                sink.start_pixel(places[lane]);
                let mut walk = walks.get(lane);
                let goes_on = self.step(
                    &mut walk,
                    hits[lane].as_ref(),
                    &mut room.lights[lane],
                    &mut room.unseen,
                    tracer,
                    &mut walks.common.samplers[lane],
                    sink,
                    |vertex| self.begin_merge(lane, &vertex, Some(vertex), &mut room.merges),
                );
                if goes_on {
                    walks.set(lane, &walk);
                } else {
                    walks.common.end(lane);
                }
            }
            if abreast != 0 {
                self.begin_merges(abreast, &walks, room);
                self.aim(abreast, &walks, &places, room, tracer, sink);
                room.approach(self);
                self.connect(abreast, &walks, &places, room, tracer, sink);
            }
            // None waits for another step, so that what is added to a pixel's layer is in the order of its path.
            room.unseen
                .see(tracer, |place, found| sink.add_at(place, found));
            room.finish(self);
            if abreast != 0 {
                let (vertices, directions) = (&room.vertices, &mut room.directions);
                walks.scatter(
                    abreast,
                    vertices,
                    directions,
                    self.has_roulette,
                    &self.weighing,
                );
            }
            self.merge(&places, room, sink);
        }
    }

    /// Draws what the lanes need, and chooses lights to aim at; returns those lanes whose lights are plain triangles.
    fn draw(&self, mut abreast: u32, walks: &WalkLanes<'_>, room: &mut CameraRoom<'s>) -> u32 {
        let lights = self.scene.lights();
        let events = &mut room.events;
        for lane in lanes_of(abreast) {
            let bounce = walks.common.bounce(lane);
            // In the order in which a step by itself draws them.
            let [light, point, direction, lobe] = walks.common.samplers[lane].bounce_pairs(bounce);
            room.directions.set(lane, [direction, lobe]);
            if !self.has_connections {
                continue;
            }
            let receiver = room.vertices.surfaces.receiver(lane);
            let Some(chosen) = lights.choose(&receiver, LightChoice::Tree, light) else {
                events.panels.clear(lane);
                continue;
            };
            match lights.as_uniform(chosen.light) {
                Some(panel) => {
                    events.panels.set(lane, &panel, chosen.pmf, point);
                    let start_over_aim = lights.pmf_start(chosen.light) / chosen.pmf;
                    events.start_over_aim.set(lane, start_over_aim);
                }
                None => abreast &= !(1 << lane),
            }
        }
        abreast
    }

    /// s = 1: lights aimed at.
    fn aim(
        &self,
        abreast: u32,
        walks: &WalkLanes<'_>,
        places: &[PixelPlace; LANES],
        room: &mut CameraRoom<'s>,
        tracer: &mut Tracer<'s>,
        sink: &mut Sink<'_>,
    ) {
        if !self.has_connections {
            return;
        }
        let events = &mut room.events;
        aim(&room.vertices, events, &self.weighing);
        let Events {
            shadows,
            is_aimed,
            is_apart,
            ..
        } = &mut *events;
        shadows.set_mask_where(abreast, is_aimed, is_apart);
        let shares = tracer.transmittances(shadows);
        for lane in lanes_of(abreast) {
            if events.is_aimed.get(lane) != 0 && shares[lane] > 0.0 {
                let value = events.value.get(lane) * shares[lane];
                let strategy = Strategy::connect(1, walks.n_vertices(lane));
                let found = contribution(value, events.mis_weight.get(lane), strategy);
                sink.add_at(places[lane], found);
            }
        }
    }

    /// s ≥ 2: every vertex of the light subpaths that leaves the path short enough.
    fn connect(
        &self,
        abreast: u32,
        walks: &WalkLanes<'_>,
        places: &[PixelPlace; LANES],
        room: &mut CameraRoom<'s>,
        tracer: &mut Tracer<'s>,
        sink: &mut Sink<'_>,
    ) {
        if !self.has_connections {
            return;
        }
        let (weighing, unseen) = (&self.weighing, &mut room.unseen);
        for lane in lanes_of(abreast) {
            let vertex = room.vertices.get(lane, walks.n_vertices(lane));
            room.lights[lane].connect(
                tracer,
                &vertex,
                self.max_bounces,
                weighing,
                unseen,
                places[lane],
                |place, found| sink.add_at(place, found),
            );
        }
    }

    /// Begins to look for what the vertices of the lanes are to be merged with.
    fn begin_merges(&self, abreast: u32, walks: &WalkLanes<'_>, room: &mut CameraRoom<'s>) {
        if self.merging.is_none() {
            return;
        }
        for lane in lanes_of(abreast) {
            let vertex = room.vertices.get(lane, walks.n_vertices(lane));
            self.begin_merge(lane, &vertex, None, &mut room.merges);
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
    fn merge(&self, places: &[PixelPlace; LANES], room: &mut CameraRoom<'s>, sink: &mut Sink<'_>) {
        let Some(merging) = &self.merging else { return };
        let mut start = 0;
        for merge in room.merges.drain(..) {
            let near = &room.near[start..merge.end];
            start = merge.end;
            let in_lane;
            let vertex = match &merge.alone {
                Some(vertex) => vertex,
                None => {
                    in_lane = room.vertices.get(merge.lane, merge.n_vertices);
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
    fn aim(vertices: &VertexLanes<'_>, events: &mut Events, weighing: &Weighing) {
        knowing_heuristic!(weighing => aim_lanes(vertices, events, weighing));
    }
}

#[inline(always)]
fn aim_lanes(vertices: &VertexLanes<'_>, events: &mut Events, weighing: &Weighing) {
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
        let is_aimed = aimed.is_some();
        let (value, mis_weight) = aimed.unwrap_or((Rgb::BLACK, 0.0));
        let light = light.unwrap_or(SurfacePoint::NOWHERE);
        events.value.set(lane, value);
        events.mis_weight.set(lane, mis_weight);
        let segment = point.segment_to(&light);
        events.shadows.set_segment(lane, &segment);
        events.is_aimed.set(lane, u32::from(is_aimed));
        events.is_apart.set(lane, u32::from(is_segment(&segment)));
    }
}
