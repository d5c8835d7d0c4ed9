//! Sixteen camera paths abreast ([`crate::integrator::abreast`]).
//!
//! Those that meet a plain diffuse surface and aim at a plain triangle make their step together, the others each by itself
//! ([`Walk::step`]).

use glam::Vec3;

use crate::accel::{Hit, HitLanes, RayLanes};
use crate::endpoint::light::PanelLanes;
use crate::endpoint::{Camera, Receiver, SurfacePoint};
use crate::integrator::abreast::PathLanes;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, lanes_of, vectorized};
use crate::radiometry::{Rgb, RgbLanes};
use crate::render::{PixelPath, PixelPlace, Pixels, Sink, Splits};
use crate::sampling::{Sampler, roulette};
use crate::scene::Caster;
use crate::transport::casters::ConeLanes;
use crate::transport::diffuse::{DiffuseSamples, DiffuseVertices};
use crate::transport::reflection::{Aimed, Drawn};
use crate::transport::{Tracer, is_segment};

use super::bsdf::MODE;
use super::connect;
use super::mis::{Path, Walk};

/// Traces the paths of all pixels.
pub(super) fn trace(
    walk: &Walk<'_>,
    camera: &Camera,
    mut pixels: Pixels<'_>,
    tracer: &mut Tracer<'_>,
    sink: &mut Sink<'_>,
) {
    let mut paths = Paths::default();
    let mut step = Step::new(walk);
    loop {
        // A lane without a path takes the next one.
        for lane in lanes_of(!paths.common.rays.mask()) {
            if let Some(split) = paths.split_off.pop() {
                paths.set_split(lane, split);
                continue;
            }
            match pixels.next() {
                Some(pixel) => paths.start(walk, lane, pixel, camera, tracer),
                None => break,
            }
        }
        if paths.common.rays.mask() == 0 {
            return;
        }
        // What do the rays meet? Some go on from there together, the others each by itself.
        let hits = tracer.hits(&paths.common.rays);
        for lane in lanes_of(paths.common.rays.mask()) {
            let Walk {
                scene, max_bounces, ..
            } = *walk;
            let vertices = &mut step.vertices;
            let may_split = walk.splits && paths.common.bounce(lane) == 0;
            if !may_split && paths.common.join(scene, max_bounces, lane, &hits, vertices) {
                step.joined |= 1 << lane;
            } else {
                paths.step(walk, lane, hits[lane].as_ref(), tracer, sink);
            }
        }
        step.take(walk, &mut paths, &hits, tracer, sink);
    }
}

/// The paths of all lanes that have one: [`Path`] lane by lane.
#[derive(Default)]
struct Paths<'t> {
    common: PathLanes<'t>,
    n_events: Lanes<u32>,
    drawn: DrawnLanes,
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

/// [`Drawn`] in each lane; the density is 0 where there is none.
#[derive(Default)]
struct DrawnLanes {
    position: Vec3Lanes,
    normal: Vec3Lanes,
    has_both_sides: Lanes<u32>,
    pdf_w: Lanes<f32>,
}

impl<'t> Paths<'t> {
    fn start(
        &mut self,
        walk: &Walk<'_>,
        lane: usize,
        pixel: PixelPath<'t>,
        camera: &Camera,
        tracer: &mut Tracer<'_>,
    ) {
        self.common.samplers[lane] = pixel.sampler;
        self.places[lane] = pixel.place;
        if walk.splits {
            self.splits[lane] = Some(pixel.splits);
        }
        let u = self.common.samplers[lane].next_2d();
        let ray = camera.ray(pixel.sample.raster, u).ray;
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
        walk: &Walk<'_>,
        lane: usize,
        found: Option<&Hit>,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
    ) {
        let place = self.places[lane];
        sink.start_pixel(place);
        let path = self.get(walk, lane);
        let others = self.splits[lane].into_iter().flat_map(Splits::others);
        let (sampler, split_off) = (&mut self.common.samplers[lane], &mut self.split_off);
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

    fn get(&self, walk: &Walk<'_>, lane: usize) -> Path {
        let pdf_w = self.drawn.pdf_w.get(lane);
        Path {
            ray: self.common.rays.get(lane),
            throughput: self.common.throughput(lane),
            media: self.common.media[lane],
            bounce: self.common.bounce(lane),
            n_events: self.n_events.get(lane),
            drawn: (pdf_w > 0.0).then(|| Drawn {
                from: Receiver::new(
                    self.drawn.position.get(lane),
                    self.drawn.normal.get(lane),
                    self.drawn.has_both_sides.get(lane) != 0,
                ),
                choice: walk.choice,
                pdf_w,
            }),
        }
    }

    fn set(&mut self, lane: usize, path: &Path) {
        let Path {
            throughput,
            media,
            bounce,
            ..
        } = *path;
        self.common.set(lane, &path.ray, throughput, media, bounce);
        self.n_events.set(lane, path.n_events);
        let drawn = &mut self.drawn;
        drawn.pdf_w.set(lane, path.drawn.map_or(0.0, |d| d.pdf_w));
        if let Some(Drawn { from, .. }) = path.drawn {
            drawn.position.set(lane, from.position);
            drawn.normal.set(lane, from.normal);
            drawn
                .has_both_sides
                .set(lane, u32::from(from.has_both_sides()));
        }
    }
}

/// A step of all paths that make it together.
struct Step<'a> {
    /// One bit for each lane that has joined.
    joined: u32,
    vertices: DiffuseVertices<'a>,
    events: Events,
}

/// What is drawn at the vertices, and what comes of it.
#[derive(Default)]
struct Events {
    u_direction: [Lanes<f32>; 3],
    u_roulette: Lanes<f32>,
    panels: PanelLanes,
    cones: ConeLanes,
    /// What comes from the light, if it is seen, its MIS weight, and the ray that tells.
    aimed: RgbLanes,
    wi: Vec3Lanes,
    pdf_w_light: Lanes<f32>,
    pdf_w_bsdf: Lanes<f32>,
    mis_weight: Lanes<f32>,
    shadows: RayLanes,
    is_aimed: Lanes<u32>,
    is_apart: Lanes<u32>,
    samples: DiffuseSamples,
    /// 1 where the path goes on.
    goes_on: Lanes<u32>,
}

impl<'a> Step<'a> {
    fn new(walk: &Walk<'a>) -> Self {
        Self {
            joined: 0,
            vertices: DiffuseVertices::new(walk.scene),
            events: Events::default(),
        }
    }

    /// Takes the step in all lanes that have joined.
    fn take(
        &mut self,
        walk: &Walk<'a>,
        paths: &mut Paths<'_>,
        hits: &HitLanes,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
    ) {
        let Self {
            joined,
            vertices,
            events,
        } = self;
        let mut abreast = std::mem::take(joined);
        if abreast == 0 {
            return;
        }
        vertices.complete(&paths.common.rays);

        // All that is drawn, and which light to aim at.
        let lights = walk.scene.lights();
        for lane in lanes_of(abreast) {
            let bounce = paths.common.bounce(lane);
            // In the order in which a step by itself draws them.
            let [direction, lobe, light, point] = paths.common.samplers[lane].bounce_pairs(bounce);
            let u = [lobe[0], direction[0], direction[1]];
            for (lanes, u) in events.u_direction.iter_mut().zip(u) {
                lanes.set(lane, u);
            }
            events.u_roulette.set(lane, lobe[1]);
            let Some(chosen) = lights.choose(&vertices.receiver(lane), walk.choice, light) else {
                events.panels.clear(lane);
                continue;
            };
            match lights.as_uniform(chosen.light) {
                Some(panel) => events.panels.set(lane, &panel, chosen.pmf, point),
                None => {
                    paths.step(walk, lane, hits[lane].as_ref(), tracer, sink);
                    abreast &= !(1 << lane);
                }
            }
        }

        // Is the light seen?
        aim(vertices, events, paths);
        if !walk.casters.is_empty() {
            events.weigh_beside_casters(walk.casters, vertices);
        }
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
                let value = events.aimed.get(lane) * shares[lane];
                let weight = events.mis_weight.get(lane);
                sink.start_pixel(paths.places[lane]);
                sink.add(connect(paths.common.bounce(lane) + 1, value, weight));
            }
        }

        // On to the next vertices.
        if !walk.casters.is_empty() {
            events.cones.choose(&mut events.u_direction);
        }
        vertices.sample(&events.u_direction, MODE, &mut events.samples);
        if !walk.casters.is_empty() {
            events.sample_casters(vertices);
        }
        go_on(vertices, events, paths, abreast, walk.has_roulette);
        for lane in lanes_of(abreast) {
            if events.goes_on.get(lane) == 0 {
                paths.common.end(lane);
            }
        }
    }
}

impl Events {
    /// MIS weights where some directions are drawn towards casters.
    fn weigh_beside_casters(&mut self, casters: &[Caster], vertices: &DiffuseVertices<'_>) {
        self.cones.see(casters, vertices);
        let Self {
            cones,
            wi,
            pdf_w_light,
            pdf_w_bsdf,
            mis_weight,
            ..
        } = self;
        cones.weigh(wi, pdf_w_light, pdf_w_bsdf, mis_weight);
    }

    /// Draws these directions.
    fn sample_casters(&mut self, vertices: &DiffuseVertices<'_>) {
        let Self {
            cones,
            u_direction,
            samples,
            ..
        } = self;
        cones.sample(vertices, u_direction, MODE, samples);
    }
}

vectorized! {
    /// Aims at the lights.
    fn aim(vertices: &DiffuseVertices<'_>, events: &mut Events, paths: &Paths<'_>) {
        for lane in 0..LANES {
            let vertex = vertices.vertex(lane);
            let aim = events.panels.aim(lane, vertex.point.position);
            let light = aim.as_ref().and_then(|aim| aim.surface);
            let aimed = aim.as_ref().and_then(|aim| Aimed::at(&vertex, aim));
            let is_aimed = aimed.is_some();
            let aimed = aimed.unwrap_or(Aimed {
                wi: Vec3::ZERO,
                value: Rgb::BLACK,
                pdf_w_light: 1.0,
                pdf_w_bsdf: 0.0,
                opacity: 1.0,
            });
            let light = light.unwrap_or(SurfacePoint::NOWHERE);
            let throughput = paths.common.throughput(lane);
            events.aimed.set(lane, throughput * aimed.value);
            events.mis_weight.set(lane, aimed.mis_weight());
            events.wi.set(lane, aimed.wi);
            events.pdf_w_light.set(lane, aimed.pdf_w_light);
            events.pdf_w_bsdf.set(lane, aimed.pdf_w_bsdf);
            let segment = vertex.point.segment_to(&light);
            events.shadows.set_segment(lane, &segment);
            events.is_aimed.set(lane, u32::from(is_aimed));
            events.is_apart.set(lane, u32::from(is_segment(&segment)));
        }
    }
}

vectorized! {
    /// Draws the next rays of the paths that are abreast.
    fn go_on(vertices: &DiffuseVertices<'_>, events: &mut Events, paths: &mut Paths<'_>, abreast: u32, has_roulette: bool) {
        for lane in 0..LANES {
            let is_abreast = abreast >> lane & 1 != 0;
            let samples = &events.samples;
            let throughput = paths.common.throughput(lane) * samples.factor(lane);
            let n_events = paths.n_events.get(lane);
            let survival = if has_roulette {
                roulette::survival_after(n_events, throughput)
            } else {
                1.0
            };
            let goes_on = samples.is_drawn(lane) & (events.u_roulette.get(lane) < survival);
            events.goes_on.set(lane, u32::from(goes_on));
            paths.common.go_on(lane, is_abreast, samples, throughput * (1.0 / survival));
            paths.n_events.set(lane, n_events + u32::from(is_abreast));
            let receiver = vertices.receiver(lane);
            let drawn = &mut paths.drawn;
            drawn.position.set_if(is_abreast, lane, receiver.position);
            drawn.normal.set_if(is_abreast, lane, receiver.normal);
            drawn.has_both_sides.set(lane, drawn.has_both_sides.get(lane) & u32::from(!is_abreast));
            drawn.pdf_w.set_if(is_abreast, lane, samples.pdf_w(lane));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::integrator::abreast::tests::{SCENES, layers, layers_under_even_sky};
    use crate::integrator::path_tracing::mis::{METHOD, N_SPLITS, Path, Walk};
    use crate::integrator::{Integrator, Method};
    use crate::render::{Cancelled, Pass};
    use crate::scene::Scene;

    /// The same paths, one after the other.
    struct OneByOne;

    impl Integrator for OneByOne {
        fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled> {
            let camera = pass.camera();
            let walk = Walk {
                scene,
                max_bounces: pass.max_bounces(),
                choice: crate::endpoint::LightChoice::TreeBesideBsdf,
                has_roulette: true,
                casters: scene.casters(),
                splits: Walk::splits_in(scene),
            };
            pass.split(if walk.splits { N_SPLITS } else { 1 });
            pass.trace_pixels_together(scene, |pixels, tracer, sink| {
                for mut pixel in pixels {
                    sink.start_pixel(pixel.place);
                    let u = pixel.sampler.next_2d();
                    let ray = camera.ray(pixel.sample.raster, u).ray;
                    let path = Path::new(ray, tracer);
                    let mut next = vec![(path, pixel.sampler)];
                    while let Some((path, mut sampler)) = next.pop() {
                        let found = tracer.hit(&path.ray);
                        let others = pixel.splits.others();
                        let mut split_off = Vec::new();
                        let goes_on = walk.step(
                            path,
                            found.as_ref(),
                            tracer,
                            &mut sampler,
                            others,
                            sink,
                            |path, sampler| split_off.push((path, sampler)),
                        );
                        next.extend(split_off);
                        next.extend(goes_on.map(|path| (path, sampler)));
                    }
                }
            })
        }
    }

    static ONE_BY_ONE: Method = Method {
        build: |_| Box::new(OneByOne),
        ..METHOD
    };

    #[test]
    fn paths_abreast_are_those_that_walk_by_themselves() {
        for scene in SCENES {
            let (abreast, alone) = (layers(scene, &METHOD), layers(scene, &ONE_BY_ONE));
            let n_other = abreast.iter().zip(&alone).filter(|(a, b)| a != b).count();
            assert_eq!(n_other, 0, "{scene}: so many of {} values", alone.len());
        }
    }

    #[test]
    fn paths_that_split_abreast_are_those_that_do_by_themselves() {
        for scene in ["cornell", "cornell-glass"] {
            let abreast = layers_under_even_sky(scene, &METHOD);
            let alone = layers_under_even_sky(scene, &ONE_BY_ONE);
            let n_other = abreast.iter().zip(&alone).filter(|(a, b)| a != b).count();
            assert_eq!(n_other, 0, "{scene}: so many of {} values", alone.len());
        }
    }
}
