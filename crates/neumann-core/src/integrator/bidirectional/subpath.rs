//! A camera vertex connected to the vertices of a light subpath, all at once.
//!
//! Where both ends of a connection are diffuse, as most are in most scenes, it is one lane of a
//! vector; the others are made one by one ([`super::connect::connect`]). Either way they are the
//! same to the last bit.

use super::connect::{connect, connect_unshadowed, contribution};
use super::lanes::{VertexLanes, knowing_heuristic};
use super::{Heuristic, MisWeights, Vertex};
use crate::bsdf::{Bsdf, Lambert};
use crate::film::{Contribution, Strategy};
use crate::integrator::lanes::Unseen;
use crate::math::lanes::{LANES, vectorized};
use crate::pass::PixelPlace;
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::{SurfaceVertex, Tracer};

/// The vertices of a light subpath, to be connected to those of a camera subpath.
pub(super) struct LightSubpath<'a> {
    /// Those that are diffuse, each in a lane, in their order, as far as there is scratch;
    diffuse: VertexLanes<'a>,
    /// how many vertices of the subpath end with each of them.
    n_vertices: [u16; LANES],
    n_diffuse: usize,
    /// The rest.
    others: Vec<Vertex<'a>>,
    /// What a camera vertex makes of the diffuse ones.
    joined: Unseen,
}

/// Connections of which it is not known yet whether anything is in between: asked when there are
/// enough for all lanes, and at the end of each step.
#[derive(Default)]
pub(super) struct Waiting {
    n: usize,
    light: Unseen,
    /// Vertices of the light's and of the camera's subpath.
    n_vertices: [[u16; 2]; LANES],
    places: [PixelPlace; LANES],
}

impl Waiting {
    /// Hands what is seen of all to `add`, with the place that it belongs to.
    pub(super) fn see(
        &mut self,
        tracer: &mut Tracer<'_>,
        mut add: impl FnMut(PixelPlace, Contribution),
    ) {
        if self.n == 0 {
            return;
        }
        for seen in self.light.see(!(!0 << self.n), tracer) {
            let [s, t] = self.n_vertices[seen.lane];
            let found = contribution(seen.value, seen.mis_weight, Strategy::connect(s, t));
            add(self.places[seen.lane], found);
        }
        self.n = 0;
    }
}

impl<'a> LightSubpath<'a> {
    /// An empty one.
    pub(super) fn new(scene: &'a Scene) -> Self {
        Self {
            diffuse: VertexLanes::new(scene),
            n_vertices: [0; LANES],
            n_diffuse: 0,
            others: Vec::new(),
            joined: Unseen::default(),
        }
    }

    /// Takes all vertices out.
    pub(super) fn clear(&mut self) {
        self.n_diffuse = 0;
        self.others.clear();
    }

    /// Adds the next vertex.
    #[inline]
    pub(super) fn push(&mut self, vertex: &Vertex<'a>) {
        let lane = self.n_diffuse;
        if lane < LANES && self.diffuse.set(lane, vertex) {
            self.n_vertices[lane] = vertex.n_vertices;
            self.n_diffuse += 1;
        } else {
            self.others.push(*vertex);
        }
    }

    /// s ≥ 2: connects all vertices to one of a camera subpath, as far as that leaves a path
    /// short enough. What comes of it is handed to `add`, or waits to be seen, and belongs to
    /// `place`.
    #[allow(clippy::too_many_arguments, reason = "a path with all its ends")]
    #[inline]
    pub(super) fn connect(
        &mut self,
        tracer: &mut Tracer<'_>,
        camera: &Vertex<'_>,
        max_bounces: u32,
        weighing: &MisWeights,
        waiting: &mut Waiting,
        place: PixelPlace,
        mut add: impl FnMut(PixelPlace, Contribution),
    ) {
        let is_short =
            |n_vertices: u16| u32::from(n_vertices + camera.n_vertices) <= max_bounces + 2;
        let diffuse = &self.n_vertices[..self.n_diffuse];
        let n = diffuse.partition_point(|n_vertices| is_short(*n_vertices));
        if let Bsdf::Lambert(lambert) = camera.surface.bsdf
            && camera.media.is_vacuum()
            && !tracer.scene.bodies().have_leaks()
        {
            if n > 0 {
                let joined = &mut self.joined;
                join(camera, lambert, &self.diffuse, weighing, joined);
                for lane in 0..n {
                    if !joined.is_there(lane) {
                        continue;
                    }
                    let to = waiting.n;
                    waiting.light.copy(to, joined, lane);
                    waiting.n_vertices[to] = [self.n_vertices[lane], camera.n_vertices];
                    waiting.places[to] = place;
                    waiting.n += 1;
                    if waiting.n == LANES {
                        waiting.see(tracer, &mut add);
                    }
                }
            }
        } else {
            for lane in 0..n {
                let light = self.diffuse.get(lane, self.n_vertices[lane]);
                if let Some(found) = connect(tracer, camera, &light, weighing) {
                    add(place, found);
                }
            }
        }
        for light in &self.others {
            if is_short(light.n_vertices)
                && let Some(found) = connect(tracer, camera, light, weighing)
            {
                add(place, found);
            }
        }
    }
}

vectorized! {
    /// Connects a diffuse vertex to those of all lanes.
    fn join(
        camera: &Vertex<'_>,
        lambert: Lambert,
        lights: &VertexLanes<'_>,
        weighing: &MisWeights,
        joined: &mut Unseen,
    ) {
        knowing_heuristic!(weighing => join_lanes(camera, lambert, lights, weighing, joined));
    }
}

#[inline(always)]
fn join_lanes(
    camera: &Vertex<'_>,
    lambert: Lambert,
    lights: &VertexLanes<'_>,
    weighing: &MisWeights,
    joined: &mut Unseen,
) {
    let camera = Vertex {
        surface: SurfaceVertex {
            bsdf: Bsdf::Lambert(lambert),
            ..camera.surface
        },
        ..*camera
    };
    for lane in 0..LANES {
        let light = lights.get(lane, 0);
        let joint = connect_unshadowed(&camera, &light, weighing);
        let value = joint.as_ref().map_or(Rgb::BLACK, |joint| joint.value);
        let mis_weight = joint.as_ref().map_or(0.0, |joint| joint.mis_weight);
        let (from, to) = (&camera.surface.point, &light.surface.point);
        joined.set(
            lane,
            joint.is_some(),
            value,
            mis_weight,
            &from.segment_to(to),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::{LightSubpath, Waiting, connect};
    use crate::endpoint::Camera;
    use crate::film::Contribution;
    use crate::integrator::bidirectional::{Heuristic, MisWeights, Vertex, Walk};
    use crate::render::PixelPlace;
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
        sampler: &Sampler<'_>,
        weighing: &MisWeights,
    ) -> Vec<Vertex<'a>> {
        let mut vertices = Vec::new();
        while let Some(vertex) = walk.meet(tracer, weighing) {
            if vertex.surface.bsdf.has_density() {
                vertices.push(vertex);
            }
            let u = sampler.bounce(walk.bounce());
            if walk.bounce() == MAX_BOUNCES || !walk.scatter(&vertex, tracer, &u, false, weighing) {
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
            let mut waiting = Waiting::default();
            let (mut n_connections, mut n_abreast) = (0, 0);
            for heuristic in [Heuristic::Balance, Heuristic::Power, Heuristic::Average] {
                let weighing = MisWeights::connections(heuristic, 1.0).merges(100, 0.01, true);
                for i in 0..300 {
                    let sampler = Sampler::new(31, i, 0);
                    let Some(start) = scene.lights().start(&start_sample(&sampler.start())) else {
                        continue;
                    };
                    let walk = Walk::from_light(&start, &mut tracer, &weighing);
                    light_subpath.clear();
                    let lights = subpath(walk, &mut tracer, &sampler, &weighing);
                    for light in &lights {
                        light_subpath.push(light);
                    }
                    let sampler = Sampler::new(32, i, 0);
                    let u = sampler.start();
                    let raster = u.film.into();
                    let walk = Walk::from_camera(&camera, raster, u.lens, &mut tracer, &weighing);
                    for vertex in subpath(walk, &mut tracer, &sampler, &weighing) {
                        let mut found: Vec<Contribution> = Vec::new();
                        let mut add = |_, c| found.push(c);
                        light_subpath.connect(
                            &mut tracer,
                            &vertex,
                            MAX_BOUNCES,
                            &weighing,
                            &mut waiting,
                            PixelPlace::default(),
                            &mut add,
                        );
                        waiting.see(&mut tracer, &mut add);
                        let is_short = |light: &&Vertex<'_>| {
                            u32::from(light.n_vertices + vertex.n_vertices) <= MAX_BOUNCES + 2
                        };
                        let mut expected: Vec<Contribution> = lights
                            .iter()
                            .filter(is_short)
                            .filter_map(|light| connect(&mut tracer, &vertex, light, &weighing))
                            .collect();
                        let bits = |found: &mut [Contribution]| -> Vec<_> {
                            found.sort_by_key(|c| c.strategy.s);
                            let of = |c: &Contribution| (c.value, c.mis_weight, c.strategy);
                            found.iter().map(of).collect()
                        };
                        assert_eq!(
                            bits(&mut found),
                            bits(&mut expected),
                            "{name}, {heuristic:?}"
                        );
                        n_connections += found.len();
                        n_abreast += light_subpath.n_diffuse;
                    }
                }
            }
            assert!(n_connections > 1000, "{name}: only {n_connections}");
            assert!(n_abreast > 1000, "{name}: only {n_abreast}");
        }
    }
}
