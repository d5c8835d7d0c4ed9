//! Subpaths side by side, from either end ([`crate::integrator::lanes`]).

use glam::Vec3;

use super::walk::{Carried, CarriedLanes, of_first};
use super::{Heuristic, MisWeights, Vertex, Walk};
use crate::accel::{Hit, HitLanes};
use crate::bsdf::TransportMode;
use crate::endpoint::ReceiverLanes;
use crate::integrator::lanes::{DirectionNumbers, PathLanes};
use crate::math::lanes::{LANES, Lanes, lanes_of, vectorized};
use crate::pass::Sink;
use crate::radiometry::RgbLanes;
use crate::sampling::BounceNumbers;
use crate::scene::Scene;
use crate::scene::bodies::Media;
use crate::transport::Tracer;
use crate::transport::diffuse::{DiffuseSamples, DiffuseVertices};

use super::weights::PartialLanes;

/// The subpaths of all lanes that have one: [`Walk`] lane by lane.
pub(super) struct WalkLanes<'t> {
    mode: TransportMode,
    pub(super) common: PathLanes<'t>,
    carried: CarriedLanes,
    /// The latest vertices.
    receivers: ReceiverLanes,
    /// The light that each starts at.
    lights: [Option<u32>; LANES],
    // One bit for each lane.
    has_receiver: u32,
    comes_from_infinity: u32,
    is_specular: u32,
}

/// What the subpaths of all lanes have met: plain vertices side by side, others each by itself.
pub(super) struct Met<'a> {
    pub(super) vertices: VertexLanes<'a>,
    /// The lanes with plain vertices, one bit for each.
    pub(super) plain: u32,
    others: Vec<Option<Vertex<'a>>>,
    /// The random numbers of others.
    numbers: [BounceNumbers; LANES],
}

/// Vertices of subpaths, on diffuse surfaces.
pub(super) struct VertexLanes<'a> {
    pub(super) surfaces: DiffuseVertices<'a>,
    throughput: RgbLanes,
    partial: PartialLanes,
}

/// Directions drawn there.
#[derive(Default)]
pub(super) struct Directions {
    pub(super) numbers: DirectionNumbers,
    samples: DiffuseSamples,
    /// 1 where the subpath goes on.
    goes_on: Lanes<u32>,
}

/// Evaluates an expression with a [`MisWeights`] of which the compiler knows the heuristic, or no
/// vectors are made of what it does.
macro_rules! knowing_heuristic {
    ($weighing:ident => $value:expr) => {{
        let heuristic = $weighing.heuristic();
        macro_rules! known {
            ($known:expr) => {{
                let $weighing = &$weighing.with($known);
                $value
            }};
        }
        match heuristic {
            Heuristic::Balance => known!(Heuristic::Balance),
            Heuristic::Power => known!(Heuristic::Power),
            Heuristic::Average => known!(Heuristic::Average),
            Heuristic::Never => known!(Heuristic::Never),
        }
    }};
}
pub(super) use knowing_heuristic;

impl WalkLanes<'_> {
    /// No subpath yet.
    pub(super) fn new(mode: TransportMode, sink: &Sink<'_>) -> Self {
        Self {
            mode,
            common: PathLanes::new(sink),
            carried: CarriedLanes::default(),
            receivers: ReceiverLanes::default(),
            lights: [None; LANES],
            has_receiver: 0,
            comes_from_infinity: 0,
            is_specular: 0,
        }
    }

    /// Vertices of the subpath of a lane, the one that it has just met included.
    #[inline(always)]
    pub(super) fn n_vertices(&self, lane: usize) -> u16 {
        self.common.bounces.get(lane) as u16 + 2
    }

    /// The subpath of a lane.
    pub(super) fn get(&self, lane: usize) -> Walk {
        let is = |bits: u32| bits >> lane & 1 != 0;
        Walk {
            mode: self.mode,
            ray: self.common.rays.get(lane),
            carried: self.carried.get(lane),
            media: self.common.media[lane],
            n_vertices: self.common.bounces.get(lane) as u16 + 1,
            receiver: is(self.has_receiver).then(|| self.receivers.get(lane)),
            light: self.lights[lane].map(|light| light as usize),
            comes_from_infinity: is(self.comes_from_infinity),
            is_specular: is(self.is_specular),
        }
    }

    /// The subpath of a lane, at the vertex that it has met.
    #[inline(always)]
    fn at(&self, lane: usize, vertex: &Vertex<'_>) -> Walk {
        Walk {
            carried: Carried {
                throughput: vertex.throughput,
                partial: vertex.partial,
                ..self.carried.get(lane)
            },
            media: vertex.media,
            n_vertices: vertex.n_vertices,
            light: None,
            comes_from_infinity: false,
            ..self.get(lane)
        }
    }

    /// Puts a subpath into a lane, beside its random numbers.
    pub(super) fn set(&mut self, lane: usize, walk: &Walk) {
        let bounce = u32::from(walk.n_vertices) - 1;
        self.common.set(lane, &walk.ray, walk.media, bounce);
        self.carried.set(lane, walk.carried);
        self.lights[lane] = walk.light.map(|light| light as u32);
        if let Some(receiver) = walk.receiver {
            self.receivers.set(lane, receiver);
        }
        let set = |bits: &mut u32, is: bool| *bits = *bits & !(1 << lane) | u32::from(is) << lane;
        set(&mut self.has_receiver, walk.receiver.is_some());
        set(&mut self.comes_from_infinity, walk.comes_from_infinity);
        set(&mut self.is_specular, walk.is_specular);
    }

    /// Takes subpaths to the vertices that their rays have met. Those on plain surfaces get there
    /// together; each other one by `meet`, which returns `None` where the subpath ends.
    #[inline(always)]
    pub(super) fn meet<'s>(
        &mut self,
        tracer: &mut Tracer<'s>,
        max_bounces: u32,
        weighing: &MisWeights,
        hits: &HitLanes,
        met: &mut Met<'s>,
        mut meet: impl FnMut(usize, &mut Walk, Option<&Hit>, &mut Tracer<'s>) -> Option<Vertex<'s>>,
    ) {
        met.plain = 0;
        for lane in lanes_of(self.common.taken()) {
            let surfaces = &mut met.vertices.surfaces;
            if self
                .common
                .join(tracer.scene, max_bounces, lane, hits, surfaces)
            {
                met.plain |= 1 << lane;
                continue;
            }
            let mut walk = self.get(lane);
            met.others[lane] = meet(lane, &mut walk, hits[lane].as_ref(), tracer);
            if met.others[lane].is_some() {
                met.numbers[lane] = self.common.samplers[lane].bounce(walk.bounce());
            } else {
                self.common.end(lane);
            }
        }
        if met.plain != 0 {
            self.arrive(met.plain, tracer.scene, &mut met.vertices, weighing);
        }
    }

    /// [`Walk::arrive`] at plain surfaces.
    fn arrive(
        &mut self,
        plain: u32,
        scene: &Scene,
        vertices: &mut VertexLanes<'_>,
        weighing: &MisWeights,
    ) {
        vertices.surfaces.complete(&self.common.rays);
        arrive(self, vertices, weighing);
        if weighing.has_others() {
            for lane in lanes_of(plain) {
                if let Some(light) = self.lights[lane].take() {
                    let receiver = vertices.surfaces.receiver(lane);
                    let partial = vertices.partial.get(lane);
                    let lights = scene.lights();
                    let partial = of_first(partial, lights, light as usize, &receiver, weighing);
                    vertices.partial.set(lane, partial);
                }
            }
        }
    }

    /// Draws directions and leaves the vertices; ends the subpaths that go nowhere.
    pub(super) fn scatter(
        &mut self,
        met: &mut Met<'_>,
        directions: &mut Directions,
        tracer: &mut Tracer<'_>,
        has_roulette: bool,
        weighing: &MisWeights,
    ) {
        for lane in lanes_of(self.common.taken() & !met.plain) {
            let Some(vertex) = &met.others[lane] else {
                continue;
            };
            let mut walk = self.at(lane, vertex);
            if walk.scatter(vertex, tracer, &met.numbers[lane], has_roulette, weighing) {
                self.set(lane, &walk);
            } else {
                self.common.end(lane);
            }
        }
        if met.plain != 0 {
            self.scatter_plain(met.plain, &met.vertices, directions, has_roulette, weighing);
        }
    }

    /// [`Walk::scatter`] at plain surfaces.
    fn scatter_plain(
        &mut self,
        plain: u32,
        vertices: &VertexLanes<'_>,
        directions: &mut Directions,
        has_roulette: bool,
        weighing: &MisWeights,
    ) {
        let Directions {
            numbers, samples, ..
        } = directions;
        vertices.surfaces.sample(&numbers.bsdf, self.mode, samples);
        leave(self, plain, vertices, directions, has_roulette, weighing);
        self.has_receiver |= plain;
        self.comes_from_infinity &= !plain;
        self.is_specular &= !plain;
        for lane in lanes_of(plain) {
            if directions.goes_on.get(lane) == 0 {
                self.common.end(lane);
            }
        }
    }
}

impl<'a> Met<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        Self {
            vertices: VertexLanes::new(scene),
            plain: 0,
            others: vec![None; LANES],
            numbers: [BounceNumbers::default(); LANES],
        }
    }

    /// Calls a function with the vertex in a lane, if subpaths can be joined to it.
    #[inline(always)]
    pub(super) fn with_vertex(
        &self,
        lane: usize,
        walks: &WalkLanes<'_>,
        mut call: impl FnMut(&Vertex<'a>),
    ) {
        if self.plain >> lane & 1 != 0 {
            call(&self.vertices.get(lane, walks.n_vertices(lane)));
        } else if let Some(other) = self.other(lane) {
            call(other);
        }
    }

    /// Where it is.
    #[inline(always)]
    pub(super) fn position(&self, lane: usize) -> Option<Vec3> {
        if self.plain >> lane & 1 != 0 {
            return Some(self.vertices.surfaces.vertex(lane).point.position);
        }
        self.other(lane).map(|other| other.surface.point.position)
    }

    /// The random numbers of the event in a lane.
    #[inline(always)]
    pub(super) fn numbers(&self, lane: usize, walks: &WalkLanes<'_>) -> BounceNumbers {
        if self.plain >> lane & 1 == 0 {
            return self.numbers[lane];
        }
        let bounce = walks.common.bounces.get(lane);
        walks.common.samplers[lane].bounce(bounce)
    }

    /// The vertex in a lane that is not plain, if subpaths can be joined to it.
    #[inline(always)]
    pub(super) fn other(&self, lane: usize) -> Option<&Vertex<'a>> {
        let other = self.others[lane].as_ref();
        other.filter(|vertex| vertex.surface.bsdf.has_density())
    }
}

impl<'a> VertexLanes<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        Self {
            surfaces: DiffuseVertices::new(scene),
            throughput: RgbLanes::default(),
            partial: PartialLanes::default(),
        }
    }

    /// Puts a vertex into a lane; false, and nothing done, if it is not diffuse.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, vertex: &Vertex<'a>) -> bool {
        if !self.surfaces.set_vertex(lane, &vertex.surface) {
            return false;
        }
        self.throughput.set(lane, vertex.throughput);
        self.partial.set(lane, vertex.partial);
        true
    }

    /// The vertex in a lane, which has so many vertices before it.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize, n_vertices: u16) -> Vertex<'a> {
        Vertex {
            surface: self.surfaces.vertex(lane),
            throughput: self.throughput.get(lane),
            partial: self.partial.get(lane),
            media: Media::VACUUM,
            n_vertices,
        }
    }
}

vectorized! {
    fn arrive(walks: &WalkLanes<'_>, vertices: &mut VertexLanes<'_>, weighing: &MisWeights) {
        knowing_heuristic!(weighing => arrive_lanes(walks, vertices, weighing));
    }
}

#[inline(always)]
fn arrive_lanes(walks: &WalkLanes<'_>, vertices: &mut VertexLanes<'_>, weighing: &MisWeights) {
    let comes_from_infinity = walks.comes_from_infinity;
    for lane in 0..LANES {
        let mut carried = walks.carried.get(lane);
        let is_parallel = comes_from_infinity >> lane & 1 != 0;
        carried.arrive(&vertices.surfaces.vertex(lane), is_parallel, weighing);
        vertices.throughput.set(lane, carried.throughput);
        vertices.partial.set(lane, carried.partial);
    }
}

vectorized! {
    fn leave(
        walks: &mut WalkLanes<'_>,
        plain: u32,
        vertices: &VertexLanes<'_>,
        directions: &mut Directions,
        has_roulette: bool,
        weighing: &MisWeights,
    ) {
        knowing_heuristic!(weighing => {
            leave_lanes(walks, plain, vertices, directions, has_roulette, weighing);
        });
    }
}

#[inline(always)]
fn leave_lanes(
    walks: &mut WalkLanes<'_>,
    plain: u32,
    vertices: &VertexLanes<'_>,
    directions: &mut Directions,
    has_roulette: bool,
    weighing: &MisWeights,
) {
    let Directions {
        numbers,
        samples,
        goes_on,
    } = directions;
    for lane in 0..LANES {
        let is_plain = plain >> lane & 1 != 0;
        let mut carried = Carried {
            throughput: vertices.throughput.get(lane),
            partial: vertices.partial.get(lane),
            ..walks.carried.get(lane)
        };
        let surface = vertices.surfaces.vertex(lane);
        let bounce = walks.common.bounces.get(lane);
        let sample = samples.get(lane);
        let mode = walks.mode;
        let survival = carried.leave(&surface, bounce, &sample, mode, has_roulette, weighing);
        let survives = numbers.roulette.get(lane) < survival;
        goes_on.set(lane, u32::from(samples.is_drawn(lane) & survives));
        walks.common.go_on(lane, is_plain, samples);
        walks.carried.set_if(is_plain, lane, carried);
        let receiver = vertices.surfaces.receiver(lane);
        walks.receivers.set_if(is_plain, lane, receiver);
    }
}
