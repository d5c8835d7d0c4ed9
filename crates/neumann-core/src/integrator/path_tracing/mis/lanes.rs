//! Sixteen camera paths side by side ([`crate::integrator::lanes`]).
//!
//! Those that meet a plain diffuse surface and aim at a plain triangle make their step together,
//! the others each by itself ([`PathTracer::step`]).

use crate::accel::{Hit, HitLanes};
use crate::endpoint::light::PanelLanes;
use crate::endpoint::{Camera, SurfacePoint};
use crate::integrator::lanes::{DirectionNumbers, PathLanes, Unseen};
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, lanes_of, vectorized};
use crate::pass::{PixelPath, PixelPlace, PixelSink, Pixels, Splits};
use crate::sampling::Sampler;
use crate::scene::SpecularCaster;
use crate::transport::Tracer;
use crate::transport::diffuse::{DiffuseSamples, DiffuseVertices};
use crate::transport::reflection::Aimed;
use crate::transport::specular_casters::ConeLanes;

use super::walk::{Carried, CarriedLanes, Path, PathTracer};
use crate::integrator::path_tracing::bsdf::MODE;
use crate::integrator::path_tracing::connect;

/// Traces the paths of all pixels.
pub(super) fn trace(
    walk: &PathTracer<'_>,
    camera: &Camera,
    mut pixels: Pixels<'_>,
    tracer: &mut Tracer<'_>,
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
        let taken = paths.common.taken();
        if taken == 0 {
            return;
        }
        // What do the rays meet? Some go on from there together, the others each by itself.
        let hits = tracer.hits(&paths.common.rays);
        let mut together = 0;
        for lane in lanes_of(taken) {
            let (scene, max_bounces) = (walk.scene, walk.max_bounces);
            let vertices = &mut step.vertices;
            let may_split = walk.splits && paths.common.bounces.get(lane) == 0;
            if !may_split && paths.common.join(scene, max_bounces, lane, &hits, vertices) {
                together |= 1 << lane;
            } else {
                paths.step(walk, lane, hits[lane].as_ref(), tracer, sink);
            }
        }
        if together != 0 {
            step.take(walk, together, &mut paths, &hits, tracer, sink);
        }
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

    /// A step of one path by itself.
    #[inline(never)]
    fn step(
        &mut self,
        walk: &PathTracer<'_>,
        lane: usize,
        found: Option<&Hit>,
        tracer: &mut Tracer<'_>,
        sink: &mut PixelSink<'_>,
    ) {
        let place = self.places[lane];
        sink.start_pixel(place);
        let path = self.get(lane);
        let others = self.splits[lane].into_iter().flat_map(Splits::others);
        let (sampler, split_off) = (&self.common.samplers[lane], &mut self.split_off);
        let next = walk.step(
            path,
            found,
            tracer,
            sampler,
            others,
            sink,
            |path, sampler| {
                split_off.push(Split {
                    path,
                    sampler,
                    place,
                });
            },
        );
        match next {
            Some(path) => self.set(lane, &path),
            None => self.common.end(lane),
        }
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

/// A step of all paths that make it together.
struct Step<'a> {
    vertices: DiffuseVertices<'a>,
    events: StepLanes,
}

/// What is drawn at the vertices, and what comes of it.
#[derive(Default)]
struct StepLanes {
    numbers: DirectionNumbers,
    panels: PanelLanes,
    cones: ConeLanes,
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
            events: StepLanes::default(),
        }
    }

    /// Takes the step in some lanes (one bit for each).
    fn take(
        &mut self,
        walk: &PathTracer<'a>,
        mut together: u32,
        paths: &mut Paths<'_>,
        hits: &HitLanes,
        tracer: &mut Tracer<'_>,
        sink: &mut PixelSink<'_>,
    ) {
        let Self { vertices, events } = self;
        vertices.complete(&paths.common.rays);

        // All that is drawn, and which light to aim at.
        let lights = walk.scene.lights();
        for lane in lanes_of(together) {
            let common = &paths.common;
            let u = common.samplers[lane].bounce(common.bounces.get(lane));
            events.numbers.set(lane, &u);
            let receiver = vertices.receiver(lane);
            let Some(chosen) = lights.choose(&receiver, walk.choice, u.light) else {
                events.panels.clear(lane);
                continue;
            };
            match lights.as_uniform(chosen.light) {
                Some(panel) => {
                    let point = u.point_on_light;
                    events.panels.set(lane, &panel, chosen.pmf, point);
                }
                None => {
                    paths.step(walk, lane, hits[lane].as_ref(), tracer, sink);
                    together &= !(1 << lane);
                }
            }
        }

        // Is the light seen?
        aim(vertices, events, paths);
        if !walk.specular_casters.is_empty() {
            events.weigh_beside_cones(walk.specular_casters, vertices);
        }
        for seen in events.light.see(together, tracer) {
            let bounce = paths.common.bounces.get(seen.lane) + 1;
            sink.start_pixel(paths.places[seen.lane]);
            sink.add(connect(bounce, seen.value, seen.mis_weight));
        }

        // On to the next vertices.
        if !walk.specular_casters.is_empty() {
            events.cones.choose(&mut events.numbers.bsdf);
        }
        vertices.sample(&events.numbers.bsdf, MODE, &mut events.samples);
        if !walk.specular_casters.is_empty() {
            events.sample_cones(vertices);
        }
        leave(vertices, events, paths, together, walk);
        for lane in lanes_of(together) {
            if events.goes_on.get(lane) == 0 {
                paths.common.end(lane);
            }
        }
    }
}

impl StepLanes {
    /// MIS weights where some directions are drawn towards specular casters.
    fn weigh_beside_cones(&mut self, casters: &[SpecularCaster], vertices: &DiffuseVertices<'_>) {
        self.cones.see(casters, vertices);
        let weights = self.light.mis_weights();
        self.cones
            .weigh(&self.wi, &self.pdf_w_light, &self.pdf_w_bsdf, weights);
    }

    /// Draws these directions.
    fn sample_cones(&mut self, vertices: &DiffuseVertices<'_>) {
        let u = &self.numbers.bsdf;
        self.cones.sample(vertices, u, MODE, &mut self.samples);
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
