//! Sixteen camera paths side by side ([`crate::integrator::lanes`]).
//!
//! Those that meet a plain diffuse surface and aim at a plain triangle make their step in vectors,
//! the others each by itself. [`Step::scatter`] has the order of a step.

use crate::endpoint::light::PanelLanes;
use crate::endpoint::{Camera, SurfacePoint};
use crate::integrator::lanes::{DirectionNumbers, PathLanes, Unseen};
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, lanes_of, vectorized};
use crate::pass::{PixelPath, PixelPlace, PixelSink, Pixels, Splits};
use crate::sampling::Sampler;
use crate::transport::Tracer;
use crate::transport::diffuse::{DiffuseSamples, DiffuseVertices};
use crate::transport::reflection::Aimed;
use crate::transport::specular_casters::ConesLanes;

use super::alone::Alone;
use super::walk::{Carried, CarriedLanes, N_SPLITS, Path, PathTracer};
use crate::integrator::path_tracing::bsdf::MODE;
use crate::integrator::path_tracing::connect;

/// Traces the paths of all pixels.
pub(super) fn trace<'a>(
    walk: &PathTracer<'a>,
    camera: &Camera,
    mut pixels: Pixels<'_>,
    tracer: &mut Tracer<'a>,
    sink: &mut PixelSink<'_>,
) {
    let mut paths = Paths::new(sink);
    let mut step = Step::new(walk);
    loop {
        // A lane without a path takes the next one.
        for lane in lanes_of(paths.common.free()) {
            if let Some(split) = paths.split_off.pop() {
                paths.set_split(lane, split);
                continue;
            }
            match pixels.next() {
                Some(pixel) => paths.start(walk, lane, pixel, camera, tracer),
                None => break,
            }
        }
        if paths.common.taken() == 0 {
            return;
        }
        let met = step.meet(walk, &mut paths, tracer, sink);
        if walk.splits {
            step.split(walk, met, &mut paths, tracer, sink);
        }
        step.scatter(walk, met, &mut paths, tracer, sink);
    }
}

/// The paths of all lanes that have one: [`Path`] lane by lane.
struct Paths<'t> {
    common: PathLanes<'t>,
    carried: CarriedLanes,
    places: [PixelPlace; LANES],
    splits: [Option<Splits<'t>>; LANES],
    /// Paths that others have split into, waiting for a lane.
    split_off: Vec<Split<'t>>,
}

/// A path that another one has split into.
struct Split<'t> {
    path: Path,
    sampler: Sampler<'t>,
    place: PixelPlace,
}

impl<'t> Paths<'t> {
    fn new(sink: &PixelSink<'_>) -> Self {
        Self {
            common: PathLanes::new(sink),
            carried: CarriedLanes::default(),
            places: [PixelPlace::default(); LANES],
            splits: [None; LANES],
            split_off: Vec::new(),
        }
    }

    fn start(
        &mut self,
        walk: &PathTracer<'_>,
        lane: usize,
        pixel: PixelPath<'t>,
        camera: &Camera,
        tracer: &mut Tracer<'_>,
    ) {
        let lens = pixel.sampler.start().lens;
        self.common.samplers[lane] = pixel.sampler;
        self.places[lane] = pixel.place;
        if walk.splits {
            self.splits[lane] = Some(pixel.splits);
        }
        let ray = camera.ray(pixel.sample.raster, lens).ray;
        self.set(lane, &Path::new(ray, tracer));
    }

    fn set_split(&mut self, lane: usize, split: Split<'t>) {
        self.common.samplers[lane] = split.sampler;
        self.places[lane] = split.place;
        self.set(lane, &split.path);
    }

    fn get(&self, lane: usize) -> Path {
        Path {
            ray: self.common.rays.get(lane),
            carried: self.carried.get(lane),
            media: self.common.media[lane],
            bounce: self.common.bounces.get(lane),
        }
    }

    fn set(&mut self, lane: usize, path: &Path) {
        self.common.set(lane, &path.ray, path.media, path.bounce);
        self.carried.set(lane, path.carried);
    }
}

/// A step of all paths, from vertex to vertex.
struct Step<'a> {
    /// Plain vertices,
    vertices: DiffuseVertices<'a>,
    /// the lanes that have them (one bit for each),
    plain: u32,
    /// and the vertices of other lanes.
    others: [Option<Alone<'a>>; LANES],
    events: StepLanes,
}

/// What is drawn at the vertices, and what comes of it.
#[derive(Default)]
struct StepLanes {
    numbers: DirectionNumbers,
    panels: PanelLanes,
    cones: ConesLanes,
    /// 1 where a direction is drawn from a cone.
    is_aimed: Lanes<u32>,
    /// What comes from the lights.
    light: Unseen,
    wi: Vec3Lanes,
    pdf_w_light: Lanes<f32>,
    pdf_w_bsdf: Lanes<f32>,
    samples: DiffuseSamples,
    /// 1 where the path goes on.
    goes_on: Lanes<u32>,
}

impl<'a> Step<'a> {
    fn new(walk: &PathTracer<'a>) -> Self {
        Self {
            vertices: DiffuseVertices::new(walk.scene),
            plain: 0,
            others: [const { None }; LANES],
            events: StepLanes::default(),
        }
    }

    /// What do the rays meet? Adds the light that they run into, and returns the lanes of which the
    /// paths go on from a vertex.
    fn meet(
        &mut self,
        walk: &PathTracer<'a>,
        paths: &mut Paths<'_>,
        tracer: &mut Tracer<'a>,
        sink: &mut PixelSink<'_>,
    ) -> u32 {
        let hits = tracer.hits(&paths.common.rays);
        self.plain = 0;
        let taken = paths.common.taken();
        for lane in lanes_of(taken) {
            let vertices = &mut self.vertices;
            if paths
                .common
                .join(walk.scene, walk.max_bounces, lane, &hits, vertices)
            {
                self.plain |= 1 << lane;
                continue;
            }
            sink.start_pixel(paths.places[lane]);
            let mut path = paths.get(lane);
            match walk.meet(&mut path, hits[lane].as_ref(), tracer, sink) {
                Some(vertex) => {
                    paths.set(lane, &path);
                    self.others[lane] = Some(Alone::at(vertex));
                }
                None => paths.common.end(lane),
            }
        }
        if self.plain != 0 {
            self.vertices.complete(&paths.common.rays);
        }
        paths.common.taken()
    }

    /// Lets paths split at their first vertex. All but one of each wait for a lane.
    fn split(
        &mut self,
        walk: &PathTracer<'a>,
        met: u32,
        paths: &mut Paths<'_>,
        tracer: &mut Tracer<'a>,
        sink: &mut PixelSink<'_>,
    ) {
        let mut firsts = 0;
        for lane in lanes_of(met) {
            let is_plain = self.plain >> lane & 1 != 0;
            let has_density = |other: &Alone<'_>| other.vertex.bsdf.has_density();
            let has_density = is_plain || self.others[lane].as_ref().is_some_and(has_density);
            if has_density && paths.common.bounces.get(lane) == 0 {
                firsts |= 1 << lane;
                let mut carried = paths.carried.get(lane);
                carried.throughput *= 1.0 / f32::from(N_SPLITS);
                paths.carried.set(lane, carried);
                tracer.splits(u32::from(N_SPLITS));
            }
        }
        for split in 1..usize::from(N_SPLITS) {
            let (common, carried) = (paths.common.clone(), paths.carried);
            for lane in lanes_of(firsts) {
                if let Some(splits) = &paths.splits[lane] {
                    paths.common.samplers[lane] = splits.sampler(split);
                }
            }
            self.scatter(walk, firsts, paths, tracer, sink);
            for lane in lanes_of(firsts & paths.common.taken()) {
                paths.split_off.push(Split {
                    path: paths.get(lane),
                    sampler: paths.common.samplers[lane].clone(),
                    place: paths.places[lane],
                });
            }
            (paths.common, paths.carried) = (common, carried);
        }
    }

    /// Aims at lights from the vertices of some lanes (one bit for each), and takes the paths on to
    /// the next rays.
    fn scatter(
        &mut self,
        walk: &PathTracer<'a>,
        lanes: u32,
        paths: &mut Paths<'_>,
        tracer: &mut Tracer<'a>,
        sink: &mut PixelSink<'_>,
    ) {
        let plain = self.draw_numbers(walk, lanes & self.plain, lanes, paths);
        let lanes = (plain, lanes & !plain);
        self.draw(walk, lanes);
        self.aim(walk, lanes, paths, tracer, sink);
        self.leave(walk, lanes, paths, tracer);
    }

    /// Draws all numbers, and chooses the lights to aim at: returns the lanes that aim at plain
    /// triangles from plain vertices.
    fn draw_numbers(
        &mut self,
        walk: &PathTracer<'a>,
        mut plain: u32,
        lanes: u32,
        paths: &Paths<'_>,
    ) -> u32 {
        let Self {
            vertices,
            others,
            events,
            ..
        } = self;
        let lights = walk.scene.lights();
        for lane in lanes_of(lanes) {
            let u = paths.common.samplers[lane].bounce(paths.common.bounces.get(lane));
            if plain >> lane & 1 != 0 {
                let receiver = vertices.receiver(lane);
                match lights.choose(&receiver, walk.choice, u.light) {
                    None => events.panels.clear(lane),
                    Some(chosen) => match lights.as_uniform(chosen.light) {
                        Some(panel) => {
                            events
                                .panels
                                .set(lane, &panel, chosen.pmf, u.point_on_light);
                        }
                        None => {
                            plain &= !(1 << lane);
                            others[lane] = Some(Alone::at(vertices.vertex(lane)));
                        }
                    },
                }
                events.numbers.set(lane, &u);
            }
            if let Some(other) = &mut others[lane] {
                other.u = u;
            }
        }
        plain
    }

    /// Draws directions from the BSDFs, or towards mirrors and glass.
    fn draw(&mut self, walk: &PathTracer<'a>, (plain, others): (u32, u32)) {
        let Self {
            vertices, events, ..
        } = self;
        if plain != 0 {
            let has_casters = !walk.specular_casters.is_empty();
            if has_casters {
                events.cones.see(walk.specular_casters, vertices);
                let u = &mut events.numbers.bsdf;
                events.cones.choose(u, &mut events.is_aimed);
            }
            vertices.sample(&events.numbers.bsdf, MODE, &mut events.samples);
            if has_casters {
                events.sample_cones(vertices);
            }
        }
        for lane in lanes_of(others) {
            let Some(other) = &mut self.others[lane] else {
                continue;
            };
            other.draw(walk);
        }
    }

    /// The next events.
    fn aim(
        &mut self,
        walk: &PathTracer<'a>,
        (plain, others): (u32, u32),
        paths: &Paths<'_>,
        tracer: &mut Tracer<'a>,
        sink: &mut PixelSink<'_>,
    ) {
        if plain != 0 {
            let events = &mut self.events;
            aim(&self.vertices, events, paths);
            if !walk.specular_casters.is_empty() {
                events.weigh_beside_cones();
            }
            for seen in events.light.see(plain, tracer) {
                let bounce = paths.common.bounces.get(seen.lane) + 1;
                sink.start_pixel(paths.places[seen.lane]);
                sink.add(connect(bounce, seen.value, seen.mis_weight));
            }
        }
        for lane in lanes_of(others) {
            if let Some(other) = &self.others[lane]
                && let Some(found) = other.aim(walk, &paths.get(lane), tracer)
            {
                sink.start_pixel(paths.places[lane]);
                sink.add(found);
            }
        }
    }

    /// On to the next rays.
    fn leave(
        &mut self,
        walk: &PathTracer<'a>,
        (plain, others): (u32, u32),
        paths: &mut Paths<'_>,
        tracer: &mut Tracer<'a>,
    ) {
        if plain != 0 {
            leave(&self.vertices, &mut self.events, paths, plain, walk);
            for lane in lanes_of(plain) {
                if self.events.goes_on.get(lane) == 0 {
                    paths.common.end(lane);
                }
            }
        }
        for lane in lanes_of(others) {
            let other = self.others[lane].as_ref();
            match other.and_then(|other| other.leave(walk, paths.get(lane), tracer)) {
                Some(path) => paths.set(lane, &path),
                None => paths.common.end(lane),
            }
        }
    }
}

impl StepLanes {
    /// MIS weights where some directions are drawn towards specular casters.
    fn weigh_beside_cones(&mut self) {
        let weights = self.light.mis_weights();
        self.cones
            .weigh(&self.wi, &self.pdf_w_light, &self.pdf_w_bsdf, weights);
    }

    /// Draws these directions.
    fn sample_cones(&mut self, vertices: &DiffuseVertices<'_>) {
        let u = &self.numbers.bsdf;
        self.cones
            .sample(vertices, u, &self.is_aimed, MODE, &mut self.samples);
    }
}

vectorized! {
    /// Aims at the lights.
    fn aim(vertices: &DiffuseVertices<'_>, events: &mut StepLanes, paths: &Paths<'_>) {
        for lane in 0..LANES {
            let vertex = vertices.vertex(lane);
            let aim = events.panels.aim(lane, vertex.point.position);
            let light = aim.as_ref().and_then(|aim| aim.surface);
            let aimed = aim.as_ref().and_then(|aim| Aimed::at(&vertex, aim));
            let is_aimed = aimed.is_some();
            let aimed = aimed.unwrap_or(Aimed::NOWHERE);
            let light = light.unwrap_or(SurfacePoint::NOWHERE);
            let value = paths.carried.get(lane).throughput * aimed.value;
            let ray = vertex.point.segment_to(&light);
            events.light.set(lane, is_aimed, value, aimed.mis_weight(), &ray);
            events.wi.set(lane, aimed.wi);
            events.pdf_w_light.set(lane, aimed.pdf_w_light);
            events.pdf_w_bsdf.set(lane, aimed.pdf_w_bsdf);
        }
    }
}

vectorized! {
    /// Leaves the vertices along the directions that were drawn.
    fn leave(
        vertices: &DiffuseVertices<'_>,
        events: &mut StepLanes,
        paths: &mut Paths<'_>,
        together: u32,
        walk: &PathTracer<'_>,
    ) {
        for lane in 0..LANES {
            let is_together = together >> lane & 1 != 0;
            let samples = &events.samples;
            let mut carried: Carried = paths.carried.get(lane);
            let (surface, sample) = (vertices.vertex(lane), samples.get(lane));
            let survival = walk.leave(&mut carried, &surface, &sample);
            let survives = events.numbers.roulette.get(lane) < survival;
            events.goes_on.set(lane, u32::from(samples.is_drawn(lane) & survives));
            paths.common.go_on(lane, is_together, samples);
            paths.carried.set_if(is_together, lane, carried);
        }
    }
}
