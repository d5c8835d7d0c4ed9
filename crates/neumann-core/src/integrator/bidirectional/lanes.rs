//! Subpaths side by side, from either end ([`crate::integrator::abreast`]).

use super::{Heuristic, Partial, Vertex, Walk, Weighing};
use crate::accel::HitLanes;
use crate::bsdf::TransportMode;
use crate::endpoint::Receiver;
use crate::integrator::abreast::PathLanes;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, lanes_of, vectorized};
use crate::radiometry::RgbLanes;
use crate::sampling::roulette;
use crate::scene::Scene;
use crate::scene::bodies::Media;
use crate::transport::diffuse::{DiffuseSamples, DiffuseVertices};

use super::walk::of_first;

/// [`Partial`] in each lane.
#[derive(Clone, Copy, Default)]
pub(super) struct PartialLanes {
    d_vcm: Lanes<f32>,
    d_vc: Lanes<f32>,
    d_vm: Lanes<f32>,
}

/// The subpaths of all lanes that have one: [`Walk`] lane by lane.
pub(super) struct WalkLanes<'t> {
    mode: TransportMode,
    pub(super) common: PathLanes<'t>,
    initial: Lanes<f32>,
    partial: PartialLanes,
    /// Place and normal of the latest vertex.
    from: [Vec3Lanes; 2],
    /// The light that each starts at.
    lights: [Option<u32>; LANES],
    // One bit for each lane.
    has_receiver: u32,
    has_both_sides: u32,
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
    u: [Lanes<f32>; 3],
    u_roulette: Lanes<f32>,
    samples: DiffuseSamples,
    /// 1 where the subpath goes on.
    goes_on: Lanes<u32>,
}

/// Evaluates an expression with a [`Weighing`] of which the compiler knows the heuristic, or no vectors are made of what it does.
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

impl PartialLanes {
    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> Partial {
        Partial {
            d_vcm: self.d_vcm.get(lane),
            d_vc: self.d_vc.get(lane),
            d_vm: self.d_vm.get(lane),
        }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, partial: Partial) {
        self.d_vcm.set(lane, partial.d_vcm);
        self.d_vc.set(lane, partial.d_vc);
        self.d_vm.set(lane, partial.d_vm);
    }

    #[inline(always)]
    fn set_if(&mut self, is_set: bool, lane: usize, partial: Partial) {
        self.d_vcm.set_if(is_set, lane, partial.d_vcm);
        self.d_vc.set_if(is_set, lane, partial.d_vc);
        self.d_vm.set_if(is_set, lane, partial.d_vm);
    }
}

impl WalkLanes<'_> {
    /// No subpath yet.
    pub(super) fn new(mode: TransportMode) -> Self {
        Self {
            mode,
            common: PathLanes::default(),
            initial: Lanes::default(),
            partial: PartialLanes::default(),
            from: [Vec3Lanes::default(); 2],
            lights: [None; LANES],
            has_receiver: 0,
            has_both_sides: 0,
            comes_from_infinity: 0,
            is_specular: 0,
        }
    }

    /// Vertices of the subpath of a lane, the one that it has just met included.
    #[inline(always)]
    pub(super) fn n_vertices(&self, lane: usize) -> u16 {
        self.common.bounce(lane) as u16 + 2
    }

    /// The subpath of a lane.
    pub(super) fn get(&self, lane: usize) -> Walk {
        let is = |bits: u32| bits >> lane & 1 != 0;
        let [position, normal] = [0, 1].map(|i| self.from[i].get(lane));
        Walk {
            mode: self.mode,
            ray: self.common.rays.get(lane),
            throughput: self.common.throughput(lane),
            initial: self.initial.get(lane),
            partial: self.partial.get(lane),
            media: self.common.media[lane],
            n_vertices: self.common.bounce(lane) as u16 + 1,
            receiver: is(self.has_receiver)
                .then(|| Receiver::new(position, normal, is(self.has_both_sides))),
            light: self.lights[lane].map(|light| light as usize),
            comes_from_infinity: is(self.comes_from_infinity),
            is_specular: is(self.is_specular),
        }
    }

    /// Puts a subpath into a lane, beside its random numbers.
    pub(super) fn set(&mut self, lane: usize, walk: &Walk) {
        let bounce = u32::from(walk.n_vertices) - 1;
        self.common
            .set(lane, &walk.ray, walk.throughput, walk.media, bounce);
        self.initial.set(lane, walk.initial);
        self.partial.set(lane, walk.partial);
        self.lights[lane] = walk.light.map(|light| light as u32);
        if let Some(receiver) = walk.receiver {
            self.from[0].set(lane, receiver.position);
            self.from[1].set(lane, receiver.normal);
        }
        let set = |bits: &mut u32, is: bool| *bits = *bits & !(1 << lane) | u32::from(is) << lane;
        set(&mut self.has_receiver, walk.receiver.is_some());
        let has_both_sides = walk.receiver.is_some_and(|r| r.has_both_sides());
        set(&mut self.has_both_sides, has_both_sides);
        set(&mut self.comes_from_infinity, walk.comes_from_infinity);
        set(&mut self.is_specular, walk.is_specular);
    }

    /// Takes those that have met plain surfaces (one bit for each) to the vertices there: [`Walk::arrive`].
    pub(super) fn arrive(
        &mut self,
        abreast: u32,
        scene: &Scene,
        vertices: &mut VertexLanes<'_>,
        weighing: &Weighing,
    ) {
        vertices.surfaces.complete(&self.common.rays);
        arrive(self, vertices, weighing);
        if weighing.has_others() {
            for lane in lanes_of(abreast) {
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
        abreast: u32,
        vertices: &VertexLanes<'_>,
        directions: &mut Directions,
        has_roulette: bool,
        weighing: &Weighing,
    ) {
        let Directions { u, samples, .. } = directions;
        vertices.surfaces.sample(u, self.mode, samples);
        go_on(self, abreast, vertices, directions, has_roulette, weighing);
        self.has_receiver |= abreast;
        self.has_both_sides &= !abreast;
        self.comes_from_infinity &= !abreast;
        self.is_specular &= !abreast;
        for lane in lanes_of(abreast) {
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

impl Directions {
    /// Sets what is drawn in a lane: two pairs of numbers, in the order of [`Walk::scatter`].
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, [direction, lobe]: [[f32; 2]; 2]) {
        let u = [lobe[0], direction[0], direction[1]];
        for (lanes, u) in self.u.iter_mut().zip(u) {
            lanes.set(lane, u);
        }
        self.u_roulette.set(lane, lobe[1]);
    }
}

vectorized! {
    fn arrive(walks: &WalkLanes<'_>, vertices: &mut VertexLanes<'_>, weighing: &Weighing) {
        knowing_heuristic!(weighing => arrive_lanes(walks, vertices, weighing));
    }
}

#[inline(always)]
fn arrive_lanes(walks: &WalkLanes<'_>, vertices: &mut VertexLanes<'_>, weighing: &Weighing) {
    let comes_from_infinity = walks.comes_from_infinity;
    for lane in 0..LANES {
        let surface = vertices.surfaces.vertex(lane);
        vertices.throughput.set(lane, walks.common.throughput(lane));
        let is_parallel = comes_from_infinity >> lane & 1 != 0;
        let d2 = surface.distance * surface.distance;
        let d2 = if is_parallel { 1.0 } else { d2 };
        let partial = walks.partial.get(lane);
        let arrived = weighing.arrive(partial, d2, surface.cos_g(surface.wo));
        let partial = if weighing.has_others() {
            arrived
        } else {
            partial
        };
        vertices.partial.set(lane, partial);
    }
}

vectorized! {
    fn go_on(
        walks: &mut WalkLanes<'_>,
        abreast: u32,
        vertices: &VertexLanes<'_>,
        directions: &mut Directions,
        has_roulette: bool,
        weighing: &Weighing,
    ) {
        knowing_heuristic!(weighing => {
            go_on_lanes(walks, abreast, vertices, directions, has_roulette, weighing);
        });
    }
}

#[inline(always)]
fn go_on_lanes(
    walks: &mut WalkLanes<'_>,
    abreast: u32,
    vertices: &VertexLanes<'_>,
    directions: &mut Directions,
    has_roulette: bool,
    weighing: &Weighing,
) {
    for lane in 0..LANES {
        let is_abreast = abreast >> lane & 1 != 0;
        let samples = &directions.samples;
        let throughput = vertices.throughput.get(lane) * samples.factor(lane);
        let survival = if has_roulette {
            let relative = throughput / walks.initial.get(lane);
            roulette::survival_after(walks.common.bounce(lane), relative)
        } else {
            1.0
        };
        let goes_on = samples.is_drawn(lane) & (directions.u_roulette.get(lane) < survival);
        directions.goes_on.set(lane, u32::from(goes_on));
        walks
            .common
            .go_on(lane, is_abreast, samples, throughput * (1.0 / survival));

        let surface = vertices.surfaces.vertex(lane);
        let sample = samples.get(lane);
        let reverse = surface.pdf_w_reverse(&sample, walks.mode);
        let before = vertices.partial.get(lane);
        let partial = weighing.scatter(
            before,
            surface.cos_g(sample.wi),
            sample.pdf_w,
            reverse,
            false,
        );
        let partial = if weighing.has_others() {
            partial
        } else {
            before
        };
        walks.partial.set_if(is_abreast, lane, partial);
        let receiver = vertices.surfaces.receiver(lane);
        walks.from[0].set_if(is_abreast, lane, receiver.position);
        walks.from[1].set_if(is_abreast, lane, receiver.normal);
    }
}
