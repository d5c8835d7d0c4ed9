//! Subpaths side by side, from either end ([`crate::integrator::lanes`]).

use super::walk::{Carried, CarriedLanes, of_first};
use super::{Heuristic, MisWeights, Vertex, Walk};
use crate::accel::HitLanes;
use crate::bsdf::TransportMode;
use crate::endpoint::ReceiverLanes;
use crate::integrator::lanes::{DirectionNumbers, PathLanes};
use crate::math::lanes::{LANES, Lanes, lanes_of, vectorized};
use crate::pass::Sink;
use crate::radiometry::RgbLanes;
use crate::scene::Scene;
use crate::scene::bodies::Media;
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

    /// Takes those that have met plain surfaces (one bit for each) to the vertices there:
    /// [`Walk::arrive`].
    pub(super) fn arrive(
        &mut self,
        together: u32,
        scene: &Scene,
        vertices: &mut VertexLanes<'_>,
        weighing: &MisWeights,
    ) {
        vertices.surfaces.complete(&self.common.rays);
        arrive(self, vertices, weighing);
        if weighing.has_others() {
            for lane in lanes_of(together) {
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

    /// Draws directions and leaves the vertices; ends those that go nowhere: [`Walk::scatter`].
    pub(super) fn scatter(
        &mut self,
        together: u32,
        vertices: &VertexLanes<'_>,
        directions: &mut Directions,
        has_roulette: bool,
        weighing: &MisWeights,
    ) {
        let Directions {
            numbers, samples, ..
        } = directions;
        vertices.surfaces.sample(&numbers.bsdf, self.mode, samples);
        leave(self, together, vertices, directions, has_roulette, weighing);
        self.has_receiver |= together;
        self.comes_from_infinity &= !together;
        self.is_specular &= !together;
        for lane in lanes_of(together) {
            if directions.goes_on.get(lane) == 0 {
                self.common.end(lane);
            }
        }
    }

    /// Lets the subpath of a lane join those that make their next step together.
    #[inline(always)]
    pub(super) fn join<'s>(
        &self,
        scene: &'s Scene,
        max_bounces: u32,
        lane: usize,
        hits: &HitLanes,
        vertices: &mut VertexLanes<'s>,
    ) -> bool {
        let surfaces = &mut vertices.surfaces;
        self.common.join(scene, max_bounces, lane, hits, surfaces)
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
        together: u32,
        vertices: &VertexLanes<'_>,
        directions: &mut Directions,
        has_roulette: bool,
        weighing: &MisWeights,
    ) {
        knowing_heuristic!(weighing => {
            leave_lanes(walks, together, vertices, directions, has_roulette, weighing);
        });
    }
}

#[inline(always)]
fn leave_lanes(
    walks: &mut WalkLanes<'_>,
    together: u32,
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
        let is_together = together >> lane & 1 != 0;
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
        walks.common.go_on(lane, is_together, samples);
        walks.carried.set_if(is_together, lane, carried);
        let receiver = vertices.surfaces.receiver(lane);
        walks.receivers.set_if(is_together, lane, receiver);
    }
}
