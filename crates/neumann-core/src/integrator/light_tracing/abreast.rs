//! Sixteen particles abreast ([`crate::integrator::abreast`]).

use glam::{Vec2, Vec3};

use crate::accel::{Hit, HitLanes, RayLanes};
use crate::endpoint::Camera;
use crate::integrator::abreast::PathLanes;
use crate::math::lanes::{LANES, Lanes, lanes_of, vectorized};
use crate::radiometry::{Rgb, RgbLanes};
use crate::render::{LightPaths, Sink};
use crate::sampling::roulette;
use crate::transport::diffuse::{DiffuseSamples, DiffuseVertices};
use crate::transport::{Tracer, are_apart};

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
    let mut events = Events::default();
    loop {
        // A lane without a particle takes the next one that leaves a light.
        for lane in lanes_of(!paths.common.rays.mask()) {
            let started = numbers.find_map(|mut sampler| {
                let path = walk.start(tracer, &mut sampler, sink)?;
                Some((path, sampler))
            });
            let Some((path, sampler)) = started else {
                break;
            };
            paths.common.samplers[lane] = sampler;
            paths.set(lane, &path);
        }
        if paths.common.rays.mask() == 0 {
            return;
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
        let mut sight = 0;
        for lane in lanes_of(abreast) {
            sight |= (events.is_seen.get(lane) & events.is_apart.get(lane)) << lane;
        }
        events.sight.set_mask(sight);
        let shares = tracer.transmittances(&events.sight);
        for lane in lanes_of(abreast) {
            if events.is_seen.get(lane) != 0 && shares[lane] > 0.0 {
                let value = events.seen.get(lane) * shares[lane] / walk.n_paths as f32;
                let [x, y] = [0, 1].map(|i| events.raster[i].get(lane));
                sink.splat(Vec2::new(x, y), splat(paths.common.bounce(lane) + 1, value));
            }
        }

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
            medium: self.common.media[lane],
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
            medium,
            bounce,
            power,
            ..
        } = *path;
        self.common.set(lane, &path.ray, throughput, medium, bounce);
        self.power.set(lane, power);
    }
}

/// What is drawn at the vertices, and what comes of it.
#[derive(Default)]
struct Events {
    u_lens: [Lanes<f32>; 2],
    u_direction: [Lanes<f32>; 3],
    u_roulette: Lanes<f32>,
    /// What the lens sees, if nothing is in the way, where on the raster, and the ray that tells.
    seen: RgbLanes,
    raster: [Lanes<f32>; 2],
    sight: RayLanes,
    is_seen: Lanes<u32>,
    is_apart: Lanes<u32>,
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
            events.seen.set(lane, paths.common.throughput(lane) * share);
            events.raster[0].set(lane, raster.x);
            events.raster[1].set(lane, raster.y);
            let origin = vertex.point.off_surface(wi);
            let apart = vertex.point.position + wi * distance - origin;
            events.sight.set_segment(lane, origin, apart);
            events.is_seen.set(lane, u32::from(is_seen));
            events.is_apart.set(lane, u32::from(are_apart(apart)));
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
