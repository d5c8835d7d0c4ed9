//! A camera vertex connected to the vertices of a light subpath, all at once.
//!
//! Where both ends of a connection are diffuse, as most are in most scenes, it is one lane of a vector; the others are
//! made one by one ([`super::connect::connect`]). Either way they are the same to the last bit.

use super::connect::{connect, connect_unshadowed, contribution};
use super::{Heuristic, Partial, Vertex, Weighing};
use crate::accel::RayLanes;
use crate::bsdf::{Bsdf, Lambert};
use crate::film::{Contribution, Strategy};
use crate::math::lanes::{LANES, Lanes, lanes_of, vectorized};
use crate::radiometry::{Rgb, RgbLanes};
use crate::scene::Scene;
use crate::transport::diffuse::DiffuseVertices;
use crate::transport::{Medium, SurfaceVertex, Tracer, are_apart};

/// Connections that are made at once, at least: fewer are sooner made one by one.
const FEWEST: u32 = 2;

/// The vertices of a light subpath, to be connected to those of a camera subpath.
pub(in crate::integrator) struct LightSubpath<'a> {
    vertices: Vec<Vertex<'a>>,
    /// One bit for each of the first [`LANES`] that is diffuse.
    diffuse: u32,
    lanes: VertexLanes<'a>,
    joints: JointLanes,
}

/// Diffuse vertices, each in the lane of its number.
struct VertexLanes<'a> {
    surfaces: DiffuseVertices<'a>,
    throughput: RgbLanes,
    d_vcm: Lanes<f32>,
    d_vc: Lanes<f32>,
    d_vm: Lanes<f32>,
}

/// What a camera vertex makes of them.
#[derive(Default)]
struct JointLanes {
    value: RgbLanes,
    mis_weight: Lanes<f32>,
    segments: RayLanes,
    is_joined: Lanes<u32>,
    is_apart: Lanes<u32>,
}

impl<'a> LightSubpath<'a> {
    /// An empty one.
    pub(in crate::integrator) fn new(scene: &'a Scene) -> Self {
        Self {
            vertices: Vec::with_capacity(32),
            diffuse: 0,
            lanes: VertexLanes {
                surfaces: DiffuseVertices::new(scene),
                throughput: RgbLanes::default(),
                d_vcm: Lanes::default(),
                d_vc: Lanes::default(),
                d_vm: Lanes::default(),
            },
            joints: JointLanes::default(),
        }
    }

    /// Takes all vertices out.
    pub(in crate::integrator) fn clear(&mut self) {
        self.vertices.clear();
        self.diffuse = 0;
    }

    /// Adds the next vertex.
    #[inline]
    pub(in crate::integrator) fn push(&mut self, vertex: Vertex<'a>) {
        let lane = self.vertices.len();
        if lane < LANES && self.lanes.surfaces.set_vertex(lane, &vertex.surface) {
            self.diffuse |= 1 << lane;
            self.lanes.throughput.set(lane, vertex.throughput);
            self.lanes.d_vcm.set(lane, vertex.partial.d_vcm);
            self.lanes.d_vc.set(lane, vertex.partial.d_vc);
            self.lanes.d_vm.set(lane, vertex.partial.d_vm);
        }
        self.vertices.push(vertex);
    }

    /// s ≥ 2: connects all vertices to one of a camera subpath, as far as that leaves a path short enough.
    #[inline]
    pub(in crate::integrator) fn connect(
        &mut self,
        tracer: &mut Tracer<'_>,
        camera: &Vertex<'_>,
        max_bounces: u32,
        weighing: &Weighing,
        mut add: impl FnMut(Contribution),
    ) {
        let is_short =
            |light: &Vertex<'_>| u32::from(light.n_vertices + camera.n_vertices) <= max_bounces + 2;
        let n = self.vertices.partition_point(is_short);
        let mut abreast = 0;
        if let Bsdf::Lambert(lambert) = camera.surface.bsdf
            && camera.medium.is_vacuum()
            && camera.surface.material.absorption().is_none()
        {
            abreast = self.diffuse & !(!0 << n.min(LANES));
            if abreast.count_ones() < FEWEST {
                abreast = 0;
            } else {
                join(camera, lambert, &self.lanes, weighing, &mut self.joints);
            }
        }
        let joints = &mut self.joints;
        let mut segments = 0;
        for lane in lanes_of(abreast) {
            segments |= (joints.is_joined.get(lane) & joints.is_apart.get(lane)) << lane;
        }
        joints.segments.set_mask(segments);
        let shares = if segments == 0 {
            [1.0; LANES]
        } else {
            tracer.transmittances(&joints.segments)
        };
        for (number, light) in self.vertices[..n].iter().enumerate() {
            if number >= LANES || abreast >> number & 1 == 0 {
                if let Some(found) = connect(tracer, camera, light, weighing) {
                    add(found);
                }
            } else if joints.is_joined.get(number) != 0 && shares[number] > 0.0 {
                add(contribution(
                    joints.value.get(number) * shares[number],
                    joints.mis_weight.get(number),
                    Strategy::connect(light.n_vertices, camera.n_vertices),
                ));
            }
        }
    }
}

vectorized! {
    /// Connects a diffuse vertex to those of all lanes.
    fn join(camera: &Vertex<'_>, lambert: Lambert, lights: &VertexLanes<'_>, weighing: &Weighing, joints: &mut JointLanes) {
        // Which heuristic it is has to be known before the loop, or no vectors are made of it.
        match weighing.heuristic() {
            Heuristic::Balance => join_lanes(camera, lambert, lights, &weighing.with(Heuristic::Balance), joints),
            Heuristic::Power => join_lanes(camera, lambert, lights, &weighing.with(Heuristic::Power), joints),
            Heuristic::Average => join_lanes(camera, lambert, lights, &weighing.with(Heuristic::Average), joints),
            Heuristic::Never => join_lanes(camera, lambert, lights, &weighing.with(Heuristic::Never), joints),
        }
    }
}

#[inline(always)]
fn join_lanes(
    camera: &Vertex<'_>,
    lambert: Lambert,
    lights: &VertexLanes<'_>,
    weighing: &Weighing,
    joints: &mut JointLanes,
) {
    let camera = Vertex {
        surface: SurfaceVertex {
            bsdf: Bsdf::Lambert(lambert),
            ..camera.surface
        },
        ..*camera
    };
    for lane in 0..LANES {
        let light = Vertex {
            surface: lights.surfaces.vertex(lane),
            throughput: lights.throughput.get(lane),
            partial: Partial {
                d_vcm: lights.d_vcm.get(lane),
                d_vc: lights.d_vc.get(lane),
                d_vm: lights.d_vm.get(lane),
            },
            medium: Medium::VACUUM,
            n_vertices: 0,
        };
        let joint = connect_unshadowed(&camera, &light, weighing);
        let value = joint.as_ref().map_or(Rgb::BLACK, |joint| joint.value);
        joints.value.set(lane, value);
        joints
            .mis_weight
            .set(lane, joint.as_ref().map_or(0.0, |joint| joint.mis_weight));
        joints.is_joined.set(lane, u32::from(joint.is_some()));
        let (from, to) = (&camera.surface.point, &light.surface.point);
        let towards = to.position - from.position;
        let origin = from.off_surface(towards);
        let apart = to.off_surface(-towards) - origin;
        joints.segments.set_segment(lane, origin, apart);
        joints.is_apart.set(lane, u32::from(are_apart(apart)));
    }
}

#[cfg(test)]
mod tests {
    use super::{LightSubpath, connect};
    use crate::endpoint::Camera;
    use crate::film::Contribution;
    use crate::integrator::bidirectional::{Heuristic, Vertex, Walk, Weighing};
    use crate::sampling::Sampler;
    use crate::scene::Scene;
    use crate::scene::builtin::builtin;
    use crate::transport::Tracer;
    use crate::transport::reflection::start_sample;

    const MAX_BOUNCES: u32 = 9;

    /// The vertices of a subpath.
    fn subpath<'a>(
        mut walk: Walk,
        tracer: &mut Tracer<'a>,
        sampler: &mut Sampler<'_>,
        weighing: &Weighing,
    ) -> Vec<Vertex<'a>> {
        let mut vertices = Vec::new();
        while let Some(vertex) = walk.meet(tracer, weighing) {
            if vertex.surface.bsdf.has_density() {
                vertices.push(vertex);
            }
            sampler.start_bounce(walk.bounce());
            if walk.bounce() == MAX_BOUNCES || !walk.scatter(&vertex, sampler, false, weighing) {
                break;
            }
        }
        vertices
    }

    #[test]
    fn connections_at_once_are_those_made_one_by_one() {
        for name in ["cornell", "cornell-glass", "lamps"] {
            let scene = Scene::build(&builtin(name).unwrap().load().unwrap());
            let camera = Camera::new(&scene.cameras()[0], 1, 1);
            let mut tracer = Tracer::new(&scene);
            let mut light_subpath = LightSubpath::new(&scene);
            let (mut n_connections, mut n_abreast) = (0, 0);
            for heuristic in [Heuristic::Balance, Heuristic::Power, Heuristic::Average] {
                let weighing = Weighing::connections(heuristic, 1.0).merges(100, 0.01, true);
                for i in 0..300 {
                    let mut sampler = Sampler::new(31, i, 0);
                    let Some(start) = scene.lights().start(&start_sample(&mut sampler)) else {
                        continue;
                    };
                    let walk = Walk::from_light(&start, &weighing);
                    light_subpath.clear();
                    let lights = subpath(walk, &mut tracer, &mut sampler, &weighing);
                    for light in &lights {
                        light_subpath.push(*light);
                    }
                    let mut sampler = Sampler::new(32, i, 0);
                    let raster = sampler.next_2d().into();
                    let walk = Walk::from_camera(&camera, raster, sampler.next_2d(), &weighing);
                    for vertex in subpath(walk, &mut tracer, &mut sampler, &weighing) {
                        let mut found: Vec<Contribution> = Vec::new();
                        light_subpath.connect(&mut tracer, &vertex, MAX_BOUNCES, &weighing, |c| {
                            found.push(c);
                        });
                        let is_short = |light: &&Vertex<'_>| {
                            u32::from(light.n_vertices + vertex.n_vertices) <= MAX_BOUNCES + 2
                        };
                        let expected: Vec<Contribution> = lights
                            .iter()
                            .filter(is_short)
                            .filter_map(|light| connect(&mut tracer, &vertex, light, &weighing))
                            .collect();
                        let bits = |found: &[Contribution]| -> Vec<_> {
                            let of = |c: &Contribution| (c.value, c.mis_weight, c.strategy);
                            found.iter().map(of).collect()
                        };
                        assert_eq!(bits(&found), bits(&expected), "{name}, {heuristic:?}");
                        n_connections += found.len();
                        n_abreast += light_subpath.diffuse.count_ones();
                    }
                }
            }
            assert!(n_connections > 1000, "{name}: only {n_connections}");
            assert!(n_abreast > 1000, "{name}: only {n_abreast}");
        }
    }
}
