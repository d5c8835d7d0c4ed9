//! Sixteen light subpaths abreast ([`crate::integrator::abreast`]).

use glam::{Vec2, Vec3};

use super::{LightEnd, LightVertex};
use crate::accel::RayLanes;
use crate::bsdf::TransportMode;
use crate::endpoint::Camera;
use crate::film::Strategy;
use crate::integrator::bidirectional::connect::{contribution, splat_unshadowed};
use crate::integrator::bidirectional::lanes::{
    Directions, VertexLanes, WalkLanes, knowing_heuristic,
};
use crate::integrator::bidirectional::{Heuristic, Weighing};
use crate::math::lanes::{LANES, Lanes, lanes_of, vectorized};
use crate::radiometry::{Rgb, RgbLanes};
use crate::render::Sink;
use crate::sampling::Sampler;
use crate::transport::{Tracer, is_segment};

/// What the lens sees of the vertices.
#[derive(Default)]
struct Sight {
    /// Where on it a vertex aims.
    u: [Lanes<f32>; 2],
    /// What it sees if nothing is in the way, where on the raster, and the rays that tell.
    value: RgbLanes,
    mis_weight: Lanes<f32>,
    raster: [Lanes<f32>; 2],
    rays: RayLanes,
    is_seen: Lanes<u32>,
    is_apart: Lanes<u32>,
}

impl LightEnd<'_> {
    /// Traces the subpaths that start with these random numbers, each with a number to keep its vertices by.
    pub(in crate::integrator) fn trace(
        &self,
        mut starts: impl Iterator<Item = (usize, Sampler<'static>)>,
        tracer: &mut Tracer<'_>,
        sink: &mut Sink<'_>,
        kept: &mut Vec<(u32, LightVertex)>,
    ) {
        let mut walks = WalkLanes::new(TransportMode::Importance);
        let mut numbers = [0; LANES];
        let mut vertices = VertexLanes::new(self.scene);
        let mut directions = Directions::default();
        let mut sight = Sight::default();
        loop {
            // A lane without a subpath takes the next one.
            for lane in lanes_of(!walks.common.rays.mask()) {
                let started = starts.find_map(|(number, mut sampler)| {
                    let walk = self.start(tracer, &mut sampler)?;
                    Some((number, walk, sampler))
                });
                let Some((number, walk, sampler)) = started else {
                    break;
                };
                numbers[lane] = number as u32;
                walks.common.samplers[lane] = sampler;
                walks.set(lane, &walk);
            }
            if walks.common.rays.mask() == 0 {
                return;
            }
            // What do they meet? Some go on from there together, the others each by itself.
            let hits = tracer.hits(&walks.common.rays);
            let mut abreast = 0;
            for lane in lanes_of(walks.common.rays.mask()) {
                let found = hits[lane].as_ref();
                if walks.join(self.scene, self.max_bounces, lane, &hits, &mut vertices) {
                    abreast |= 1 << lane;
                    if self.camera.has_lens() {
                        self.meet_lens(&walks.get(lane), found, tracer, sink);
                    }
                    continue;
                }
                let mut walk = walks.get(lane);
                let sampler = &mut walks.common.samplers[lane];
                let keep = |vertex| kept.push((numbers[lane], vertex));
                if self.step(&mut walk, found, tracer, sampler, sink, keep) {
                    walks.set(lane, &walk);
                } else {
                    walks.common.end(lane);
                }
            }
            if abreast == 0 {
                continue;
            }
            walks.arrive(abreast, self.scene, &mut vertices, &self.weighing);
            for lane in lanes_of(abreast) {
                let vertex = vertices.get(lane, walks.n_vertices(lane));
                kept.push((numbers[lane], LightVertex::of(&vertex)));
                // In the order in which a step by itself draws them.
                let bounce = walks.common.bounce(lane);
                let [lens, direction, lobe, _] = walks.common.samplers[lane].bounce_pairs(bounce);
                sight.u[0].set(lane, lens[0]);
                sight.u[1].set(lane, lens[1]);
                directions.set(lane, [direction, lobe]);
            }
            if self.has_connections {
                see(&vertices, &mut sight, self.camera, &self.weighing);
                let Sight {
                    rays,
                    is_seen,
                    is_apart,
                    ..
                } = &mut sight;
                rays.set_mask_where(abreast, is_seen, is_apart);
                let shares = tracer.transmittances(rays);
                for lane in lanes_of(abreast) {
                    if sight.is_seen.get(lane) != 0 && shares[lane] > 0.0 {
                        let value = sight.value.get(lane) * shares[lane] / self.n_paths as f32;
                        let strategy = Strategy::connect(walks.n_vertices(lane), 1);
                        let [x, y] = [0, 1].map(|i| sight.raster[i].get(lane));
                        let seen = contribution(value, sight.mis_weight.get(lane), strategy);
                        sink.splat(Vec2::new(x, y), seen);
                    }
                }
            }
            walks.scatter(
                abreast,
                &vertices,
                &mut directions,
                self.has_roulette,
                &self.weighing,
            );
        }
    }
}

vectorized! {
    /// Aims at the lens.
    fn see(vertices: &VertexLanes<'_>, sight: &mut Sight, camera: &Camera, weighing: &Weighing) {
        knowing_heuristic!(weighing => see_lanes(vertices, sight, camera, weighing));
    }
}

#[inline(always)]
fn see_lanes(vertices: &VertexLanes<'_>, sight: &mut Sight, camera: &Camera, weighing: &Weighing) {
    for lane in 0..LANES {
        let vertex = vertices.get(lane, 0);
        let u = [sight.u[0].get(lane), sight.u[1].get(lane)];
        let seen = splat_unshadowed(camera, &vertex, u, weighing);
        let is_seen = seen.is_some();
        let value = seen.as_ref().map_or(Rgb::BLACK, |seen| seen.value);
        let mis_weight = seen.as_ref().map_or(0.0, |seen| seen.mis_weight);
        let raster = seen.as_ref().map_or(Vec2::ZERO, |seen| seen.raster);
        let wi = seen.as_ref().map_or(Vec3::ZERO, |seen| seen.aim.wi);
        let distance = seen.as_ref().map_or(0.0, |seen| seen.aim.distance);
        sight.value.set(lane, value);
        sight.mis_weight.set(lane, mis_weight);
        sight.raster[0].set(lane, raster.x);
        sight.raster[1].set(lane, raster.y);
        let point = &vertex.surface.point;
        let segment = point.segment_to_lens(point.position + wi * distance);
        sight.rays.set_segment(lane, &segment);
        sight.is_seen.set(lane, u32::from(is_seen));
        sight.is_apart.set(lane, u32::from(is_segment(&segment)));
    }
}
