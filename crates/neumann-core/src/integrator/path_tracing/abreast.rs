//! Sixteen paths abreast, for speed alone.
//!
//! Each lane has a path, and takes that of the next pixel when it ends. Where a path meets a plain diffuse surface and
//! a plain triangle is what it aims at, as most do in most scenes, it makes its step in vectors, together with the other
//! lanes; from anywhere else, by itself ([`Walk::step`]). Either way the step is the same to the last bit: both are
//! made of the same functions.

use glam::Vec3;

use crate::accel::Hit;
use crate::endpoint::light::{Light, PanelLanes};
use crate::endpoint::{Camera, SurfacePoint};
use crate::math::Ray;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, vectorized};
use crate::radiometry::Rgb;
use crate::render::{PixelPath, PixelPlace, Pixels, Sink};
use crate::sampling::{Sampler, roulette};
use crate::transport::diffuse::{DiffuseHit, DiffuseVertices};
use crate::transport::reflection::{Aimed, Drawn, light_sample};
use crate::transport::{Tracer, VertexSample, segment};

use super::bsdf::{MODE, bsdf_numbers};
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
    let mut lanes: [Option<Lane<'_>>; LANES] = std::array::from_fn(|_| None);
    let mut step = Step {
        vertices: DiffuseVertices::new(walk.scene),
        events: Events::default(),
        joined: [false; LANES],
    };
    loop {
        // A lane without a path takes the next one.
        for lane in &mut lanes {
            if lane.is_none() {
                *lane = pixels.next().map(|pixel| Lane::start(pixel, camera));
            }
        }
        if lanes.iter().all(Option::is_none) {
            return;
        }
        // What do the rays meet?
        for (number, place) in lanes.iter_mut().enumerate() {
            step.joined[number] = false;
            if let Some(lane) = place {
                let found = tracer.hit(&lane.path.ray);
                let is_joined = found.is_some_and(|hit| step.join(walk, number, lane, &hit));
                if !is_joined && !lane.step(walk, found.as_ref(), tracer, sink) {
                    *place = None;
                }
            }
        }
        // The others go on together.
        step.take(walk, &mut lanes, tracer, sink);
    }
}

/// A path with what belongs to it.
struct Lane<'t> {
    path: Path,
    sampler: Sampler<'t>,
    place: PixelPlace,
}

impl<'t> Lane<'t> {
    #[inline(always)]
    fn start(pixel: PixelPath<'t>, camera: &Camera) -> Self {
        let PixelPath {
            sample,
            mut sampler,
            place,
        } = pixel;
        Self {
            path: Path::new(camera.ray(sample.raster, sampler.next_2d()).ray),
            sampler,
            place,
        }
    }

    /// A step by itself; false where the path ends.
    fn step(
        &mut self,
        walk: &Walk<'_>,
        found: Option<&Hit>,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
    ) -> bool {
        sink.start_pixel(self.place);
        let next = walk.step(self.path, found, tracer, &mut self.sampler, sink);
        self.path = next.unwrap_or(self.path);
        next.is_some()
    }
}

/// A step of all paths that make it together.
struct Step<'a> {
    vertices: DiffuseVertices<'a>,
    events: Events,
    joined: [bool; LANES],
}

/// What is drawn at the vertices, and what comes of it.
#[derive(Default)]
struct Events {
    throughput: Vec3Lanes,
    n_events: Lanes<u32>,
    u_direction: [Lanes<f32>; 3],
    u_roulette: Lanes<f32>,
    panels: PanelLanes,
    /// What comes from the light, if it is seen, its MIS weight, and both ends of the ray that tells.
    aimed: Vec3Lanes,
    mis_weight: Lanes<f32>,
    from: Vec3Lanes,
    to: Vec3Lanes,
    is_aimed: Lanes<u32>,
    /// The next ray, and what has become of the throughput.
    origin: Vec3Lanes,
    direction: Vec3Lanes,
    pdf_w: Lanes<f32>,
    goes_on: Lanes<u32>,
}

impl<'a> Step<'a> {
    /// Puts a path into its lane, if what it has met is plain enough.
    #[inline(always)]
    fn join(&mut self, walk: &Walk<'a>, number: usize, lane: &mut Lane<'_>, hit: &Hit) -> bool {
        let path = &lane.path;
        if path.bounce >= walk.max_bounces || !path.medium.is_vacuum() {
            return false;
        }
        let Some(diffuse) = DiffuseHit::of(walk.scene, hit) else {
            return false;
        };
        self.vertices
            .set(number, &diffuse, -path.ray.direction());
        let Rgb { r, g, b } = path.throughput;
        self.events.throughput.set(number, Vec3::new(r, g, b));
        self.events.n_events.set(number, path.n_events);
        self.joined[number] = true;
        true
    }

    /// Takes the step in all lanes that have joined.
    fn take(
        &mut self,
        walk: &Walk<'a>,
        lanes: &mut [Option<Lane<'_>>; LANES],
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
    ) {
        let Self {
            vertices,
            events,
            joined,
        } = self;
        vertices.complete();

        // Which light to aim at, and all that is drawn.
        for number in 0..LANES {
            let Some(lane) = lanes[number].as_mut().filter(|_| joined[number]) else {
                continue;
            };
            let sampler = &mut lane.sampler;
            let u = bsdf_numbers(sampler, lane.path.bounce);
            for (lanes, u) in events.u_direction.iter_mut().zip(u) {
                lanes.set(number, u);
            }
            let u = light_sample(sampler);
            events.u_roulette.set(number, sampler.next_1d());
            let lights = walk.scene.lights();
            let receiver = vertices.vertex(number).receiver();
            match lights.choose(&receiver, walk.choice, u.choice[0]) {
                Some((index, pmf)) => {
                    if let Light::Area(light) = &lights.as_slice()[index]
                        && let Some(panel) = light.as_uniform()
                    {
                        events.panels.set(number, &panel, pmf, u.point);
                    } else {
                        todo!()
                    }
                }
                None => events.panels.clear(number),
            }
        }
        aim(vertices, events);

        // Is the light seen?
        for number in 0..LANES {
            let Some(lane) = lanes[number].as_mut().filter(|_| joined[number]) else {
                continue;
            };
            if events.is_aimed.get(number) == 0 {
                continue;
            }
            let line = segment(events.from.get(number), events.to.get(number));
            let share = line.map_or(1.0, |ray| tracer.transmittance(&ray));
            if share > 0.0 {
                let aimed = Rgb::from(events.aimed.get(number).to_array());
                let value = lane.path.throughput * (aimed * share);
                sink.start_pixel(lane.place);
                sink.add(connect(
                    lane.path.bounce + 1,
                    value,
                    events.mis_weight.get(number),
                ));
            }
        }

        // On to the next vertices.
        go_on(vertices, events, walk.has_roulette);
        for number in 0..LANES {
            if !joined[number] {
                continue;
            }
            let Some(lane) = lanes[number].as_mut() else {
                continue;
            };
            if events.goes_on.get(number) == 0 {
                lanes[number] = None;
                continue;
            }
            let path = &mut lane.path;
            path.ray = Ray::new(events.origin.get(number), events.direction.get(number));
            path.throughput = Rgb::from(events.throughput.get(number).to_array());
            path.drawn = Some(Drawn {
                from: vertices.vertex(number).receiver(),
                choice: walk.choice,
                pdf_w: events.pdf_w.get(number),
            });
            path.bounce += 1;
            path.n_events += 1;
        }
    }
}

vectorized! {
    /// Aims at the lights.
    fn aim(vertices: &DiffuseVertices<'_>, events: &mut Events) {
        for lane in 0..LANES {
            let vertex = vertices.vertex(lane);
            let aim = events.panels.aim(lane, vertex.point.position);
            let light = aim.as_ref().and_then(|aim| aim.surface);
            let aimed = aim.as_ref().and_then(|aim| Aimed::at(&vertex, aim));
            let is_aimed = aimed.is_some();
            let aimed = aimed.unwrap_or(Aimed {
                value: Rgb::BLACK,
                pdf_w_light: 1.0,
                pdf_w_bsdf: 0.0,
            });
            let light = light.unwrap_or(SurfacePoint {
                position: Vec3::ZERO,
                error: 0.0,
                ng: Vec3::ZERO,
            });
            let wi = aim.map_or(Vec3::ZERO, |aim| aim.wi);
            let Rgb { r, g, b } = aimed.value;
            events.aimed.set(lane, Vec3::new(r, g, b));
            events.mis_weight.set(lane, aimed.mis_weight());
            events.from.set(lane, vertex.point.off_surface(wi));
            events.to.set(lane, light.off_surface(-wi));
            events.is_aimed.set(lane, u32::from(is_aimed));
        }
    }
}

vectorized! {
    /// Draws the next rays.
    fn go_on(vertices: &DiffuseVertices<'_>, events: &mut Events, has_roulette: bool) {
        for lane in 0..LANES {
            let vertex = vertices.vertex(lane);
            let u = [0, 1, 2].map(|i| events.u_direction[i].get(lane));
            let throughput = Rgb::from(events.throughput.get(lane).to_array());
            let sample = vertex.sample(u, MODE);
            let is_drawn = sample.is_some();
            let sample = sample.unwrap_or(VertexSample { wi: Vec3::ZERO, f_cos: Rgb::BLACK, pdf_w: 1.0, is_delta: false });
            let throughput = throughput * sample.throughput();
            let n_events = events.n_events.get(lane);
            let survival = if has_roulette { roulette::survival_after(n_events, throughput) } else { 1.0 };
            let goes_on = is_drawn & (events.u_roulette.get(lane) < survival);
            let Rgb { r, g, b } = throughput * (1.0 / survival);
            events.throughput.set(lane, Vec3::new(r, g, b));
            events.origin.set(lane, vertex.point.off_surface(sample.wi));
            events.direction.set(lane, sample.wi);
            events.pdf_w.set(lane, sample.pdf_w);
            events.goes_on.set(lane, u32::from(goes_on));
        }
    }
}
