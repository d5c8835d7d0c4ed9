//! Sixteen particles abreast ([`crate::integrator::abreast`]).

use glam::{Vec2, Vec3};

use crate::accel::{Hit, HitLanes, RayLanes};
use crate::endpoint::light::PanelLanes;
use crate::endpoint::{Camera, Spread, Start, StartDensities, SurfacePoint};
use crate::integrator::abreast::PathLanes;
use crate::integrator::bidirectional::connect::see_panel_unshadowed;
use crate::math::Ray;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, lanes_of, vectorized};
use crate::math::ray::NO_TRIANGLE;
use crate::radiometry::{Rgb, RgbLanes};
use crate::render::{LightPaths, Sink};
use crate::sampling::{Sampler, roulette};
use crate::scene::bodies::Media;
use crate::transport::diffuse::{DiffuseSamples, DiffuseVertices};
use crate::transport::{Tracer, is_segment};

use super::{MODE, Path, Walk, see_unshadowed, splat};

/// Traces the particles.
pub(super) fn trace(
    walk: &Walk<'_>,
    mut numbers: LightPaths,
    tracer: &mut Tracer<'_>,
    sink: &mut Sink<'_>,
) {
    let mut paths = Paths::default();
    let mut vertices = DiffuseVertices::new(walk.scene);
    let mut starts = Starts::default();
    let mut events = Events::default();
    loop {
        // A lane without a particle takes the next one that leaves a light. Those of plain triangles start together.
        let (mut together, mut is_last) = (0, false);
        for lane in lanes_of(!paths.common.rays.mask()) {
            let Some(mut sampler) = numbers.next() else {
                is_last = true;
                break;
            };
            if starts.choose(walk, lane, &sampler) {
                together |= 1 << lane;
            } else if let Some(path) = walk.start(tracer, &mut sampler, sink) {
                paths.set(lane, &path);
            }
            paths.common.samplers[lane] = sampler;
        }
        if together != 0 {
            starts.take(walk, together, &mut paths, tracer, sink);
        }
        if paths.common.rays.mask() == 0 {
            if is_last {
                return;
            }
            continue;
        }
        // Where do they land? Some go on from there together, the others each by itself.
        let hits = tracer.hits(&paths.common.rays);
        let mut abreast = 0;
        for lane in lanes_of(paths.common.rays.mask()) {
            let Walk {
                scene, max_bounces, ..
            } = *walk;
            if paths
                .common
                .join(scene, max_bounces, lane, &hits, &mut vertices)
            {
                abreast |= 1 << lane;
            } else {
                paths.step(walk, lane, &hits, tracer, sink);
            }
        }
        if abreast == 0 {
            continue;
        }
        vertices.complete(&paths.common.rays);

        // All that is drawn.
        for lane in lanes_of(abreast) {
            let bounce = paths.common.bounce(lane);
            // In the order in which a step by itself draws them.
            let [lens, direction, lobe, _] = paths.common.samplers[lane].bounce_pairs(bounce);
            events.u_lens[0].set(lane, lens[0]);
            events.u_lens[1].set(lane, lens[1]);
            let u = [lobe[0], direction[0], direction[1]];
            for (lanes, u) in events.u_direction.iter_mut().zip(u) {
                lanes.set(lane, u);
            }
            events.u_roulette.set(lane, lobe[1]);
        }

        // What scatters there, seen by the lens.
        see(&vertices, &mut events, &paths, walk.camera);
        let bounce = |lane| paths.common.bounce(lane) + 1;
        let Events { sight, .. } = &mut events;
        sight.splat(abreast, walk.n_paths, bounce, tracer, sink);

        // On to the next vertices.
        vertices.sample(&events.u_direction, MODE, &mut events.samples);
        go_on(&mut events, &mut paths, abreast, walk.has_roulette);
        for lane in lanes_of(abreast) {
            if events.goes_on.get(lane) == 0 || paths.common.bounce(lane) >= walk.max_bounces {
                paths.common.end(lane);
            }
        }
    }
}

/// The particles of all lanes that have one: [`Path`] lane by lane.
#[derive(Default)]
struct Paths {
    common: PathLanes<'static>,
    power: Lanes<f32>,
}

impl Paths {
    /// A step of one particle by itself.
    #[inline(never)]
    fn step(
        &mut self,
        walk: &Walk<'_>,
        lane: usize,
        hits: &HitLanes,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
    ) {
        let path = Path {
            ray: self.common.rays.get(lane),
            throughput: self.common.throughput(lane),
            media: self.common.media[lane],
            bounce: self.common.bounce(lane),
            power: self.power.get(lane),
        };
        let found: Option<&Hit> = hits[lane].as_ref();
        match walk.step(path, found, tracer, &mut self.common.samplers[lane], sink) {
            Some(path) => self.set(lane, &path),
            None => self.common.end(lane),
        }
    }

    fn set(&mut self, lane: usize, path: &Path) {
        let Path {
            throughput,
            media,
            bounce,
            power,
            ..
        } = *path;
        self.common.set(lane, &path.ray, throughput, media, bounce);
        self.power.set(lane, power);
    }
}

/// Particles that start together from plain triangles.
#[derive(Default)]
struct Starts {
    panels: PanelLanes,
    u_direction: [Lanes<f32>; 2],
    u_lens: [Lanes<f32>; 2],
    origin: Vec3Lanes,
    leaves: Lanes<u32>,
    direction: Vec3Lanes,
    power: RgbLanes,
    is_started: Lanes<u32>,
    /// What the lens sees of where they start.
    sight: Sight,
}

/// What the lens sees, if nothing is in the way, where on the raster, and the rays that tell.
#[derive(Default)]
struct Sight {
    seen: RgbLanes,
    raster: [Lanes<f32>; 2],
    rays: RayLanes,
    is_seen: Lanes<u32>,
    is_apart: Lanes<u32>,
}

impl Starts {
    /// Chooses the light of a lane's particle; false if it is no plain triangle, or may be within a
    /// body.
    fn choose(&mut self, walk: &Walk<'_>, lane: usize, sampler: &Sampler<'_>) -> bool {
        // In the order in which a start by itself draws them.
        let [direction, choice, point, lens] = sampler.start_pairs();
        let lights = walk.scene.lights();
        if walk.scene.bodies().hold_lights() {
            return false;
        }
        let Some(chosen) = lights.choose_start(choice) else {
            return false;
        };
        let Some(panel) = lights.as_uniform(chosen.light) else {
            return false;
        };
        self.panels.set(lane, &panel, chosen.pmf, point);
        for i in 0..2 {
            self.u_direction[i].set(lane, direction[i]);
            self.u_lens[i].set(lane, lens[i]);
        }
        true
    }

    /// Sends out the particles of the lanes that have been chosen for; the lens may see where they start.
    fn take(
        &mut self,
        walk: &Walk<'_>,
        lanes: u32,
        paths: &mut Paths,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
    ) {
        start(self, walk.camera);
        let mut started = 0;
        for lane in lanes_of(lanes) {
            started |= self.is_started.get(lane) << lane;
        }
        self.sight.splat(started, walk.n_paths, |_| 0, tracer, sink);
        if walk.max_bounces == 0 {
            return;
        }
        for lane in lanes_of(started) {
            let power = self.power.get(lane);
            let path = Path {
                ray: Ray::new(self.origin.get(lane), self.direction.get(lane))
                    .leaving(self.leaves.get(lane)),
                throughput: power,
                media: Media::VACUUM,
                bounce: 0,
                power: power.max_channel(),
            };
            paths.set(lane, &path);
        }
    }
}

impl Sight {
    /// Adds what is seen of the lanes after so many scattering events each.
    fn splat(
        &mut self,
        lanes: u32,
        n_paths: usize,
        bounce: impl Fn(usize) -> u32,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
    ) {
        self.rays
            .set_mask_where(lanes, &self.is_seen, &self.is_apart);
        let shares = tracer.transmittances(&self.rays);
        for lane in lanes_of(lanes) {
            if self.is_seen.get(lane) != 0 && shares[lane] > 0.0 {
                let value = self.seen.get(lane) * shares[lane] / n_paths as f32;
                let [x, y] = [0, 1].map(|i| self.raster[i].get(lane));
                sink.splat(Vec2::new(x, y), splat(bounce(lane), value));
            }
        }
    }

    /// Sets the ray that tells whether a point is seen from another one so far away along `wi`.
    #[inline(always)]
    fn set_ray(&mut self, lane: usize, point: &SurfacePoint, wi: Vec3, distance: f32) {
        let segment = point.segment_to_lens(point.position + wi * distance);
        self.rays.set_segment(lane, &segment);
        self.is_apart.set(lane, u32::from(is_segment(&segment)));
    }

    /// Sets what is seen of it, and where.
    #[inline(always)]
    fn set(&mut self, lane: usize, is_seen: bool, raster: Vec2, value: Rgb) {
        self.is_seen.set(lane, u32::from(is_seen));
        self.raster[0].set(lane, raster.x);
        self.raster[1].set(lane, raster.y);
        self.seen.set(lane, value);
    }
}

vectorized! {
    /// Starts particles, and aims at the lens from there.
    fn start(starts: &mut Starts, camera: &Camera) {
        for lane in 0..LANES {
            let u = [starts.u_direction[0].get(lane), starts.u_direction[1].get(lane)];
            let started = starts.panels.start(lane, u);
            let is_started = started.is_some();
            let start = started.unwrap_or(NOWHERE);
            starts.is_started.set(lane, u32::from(is_started));
            let ray = start.ray();
            starts.origin.set(lane, ray.origin());
            starts.leaves.set(lane, ray.leaves());
            starts.direction.set(lane, ray.direction());
            starts.power.set(lane, start.throughput());
            let u = [starts.u_lens[0].get(lane), starts.u_lens[1].get(lane)];
            let panels = &starts.panels;
            let seen = see_panel_unshadowed(camera, &start, u, |wo| panels.radiance(lane, wo));
            let is_seen = seen.is_some();
            let raster = seen.as_ref().map_or(Vec2::ZERO, |(raster, ..)| *raster);
            let value = seen.as_ref().map_or(Rgb::BLACK, |(_, value, _)| *value);
            let wi = seen.as_ref().map_or(Vec3::ZERO, |(.., aim)| aim.wi);
            let distance = seen.as_ref().map_or(0.0, |(.., aim)| aim.distance);
            starts.sight.set(lane, is_seen, raster, value);
            starts.sight.set_ray(lane, &start.point(), wi, distance);
        }
    }
}

/// In the place of a start that does not take place.
const NOWHERE: Start = Start {
    position: Vec3::ZERO,
    triangle: NO_TRIANGLE,
    ng: Vec3::Z,
    direction: Vec3::Z,
    value: Rgb::BLACK,
    cos: 1.0,
    densities: StartDensities {
        pdf_a: 1.0,
        pdf_w: 1.0,
    },
    spread: Spread::Point { pdf_w: 1.0 },
    light: 0,
    on_triangle: None,
    opacity: 1.0,
    is_delta_position: false,
    is_delta_direction: false,
};

/// What is drawn at the vertices, and what comes of it.
#[derive(Default)]
struct Events {
    u_lens: [Lanes<f32>; 2],
    u_direction: [Lanes<f32>; 3],
    u_roulette: Lanes<f32>,
    sight: Sight,
    samples: DiffuseSamples,
    /// 1 where the particle goes on.
    goes_on: Lanes<u32>,
}

vectorized! {
    /// Aims at the lens.
    fn see(vertices: &DiffuseVertices<'_>, events: &mut Events, paths: &Paths, camera: &Camera) {
        for lane in 0..LANES {
            let vertex = vertices.vertex(lane);
            let u = [events.u_lens[0].get(lane), events.u_lens[1].get(lane)];
            let seen = see_unshadowed(camera, &vertex, u);
            let is_seen = seen.is_some();
            let share = seen.as_ref().map_or(Rgb::BLACK, |(seen, _)| seen.share);
            let raster = seen.as_ref().map_or(Vec2::ZERO, |(seen, _)| seen.raster);
            let wi = seen.as_ref().map_or(Vec3::ZERO, |(_, aim)| aim.wi);
            let distance = seen.as_ref().map_or(0.0, |(_, aim)| aim.distance);
            let value = paths.common.throughput(lane) * share;
            events.sight.set(lane, is_seen, raster, value);
            events.sight.set_ray(lane, &vertex.point, wi, distance);
        }
    }
}

vectorized! {
    /// Takes the particles that are abreast on along the directions that were drawn.
    fn go_on(events: &mut Events, paths: &mut Paths, abreast: u32, has_roulette: bool) {
        for lane in 0..LANES {
            let is_abreast = abreast >> lane & 1 != 0;
            let samples = &events.samples;
            let throughput = paths.common.throughput(lane) * samples.factor(lane);
            let survival = if has_roulette {
                let relative = throughput / paths.power.get(lane);
                roulette::survival_after(paths.common.bounce(lane), relative)
            } else {
                1.0
            };
            let goes_on = samples.is_drawn(lane) & (events.u_roulette.get(lane) < survival);
            events.goes_on.set(lane, u32::from(goes_on));
            paths.common.go_on(lane, is_abreast, samples, throughput * (1.0 / survival));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::integrator::abreast::tests::{SCENES, layers};
    use crate::integrator::light_tracing::{METHOD, Walk};
    use crate::integrator::{Integrator, Method};
    use crate::render::{Cancelled, Pass};
    use crate::scene::Scene;

    /// The same particles, one after the other.
    struct OneByOne;

    impl Integrator for OneByOne {
        fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled> {
            let n_paths = pass.n_pixels();
            let walk = Walk {
                scene,
                camera: pass.camera(),
                n_paths,
                max_bounces: pass.max_bounces(),
                has_roulette: true,
            };
            let numbers = pass.light_numbers(n_paths);
            pass.trace_light_paths_together(scene, n_paths, numbers, |paths, tracer, sink| {
                for mut sampler in paths {
                    let mut next = walk.start(tracer, &mut sampler, sink);
                    while let Some(path) = next {
                        let found = tracer.hit(&path.ray);
                        next = walk.step(path, found.as_ref(), tracer, &mut sampler, sink);
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
    fn particles_abreast_are_those_that_walk_by_themselves() {
        for scene in SCENES {
            let (abreast, alone) = (layers(scene, &METHOD), layers(scene, &ONE_BY_ONE));
            // What falls on one pixel may be added in another order.
            for (a, b) in abreast.iter().zip(&alone) {
                let apart = (*a - *b).map(f32::abs).max_channel();
                assert!(apart <= 1e-5 * b.max_channel(), "{scene}: {a:?}, {b:?}");
            }
        }
    }
}
