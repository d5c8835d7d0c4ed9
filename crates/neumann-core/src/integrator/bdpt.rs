//! Bidirectional path tracing: every way to cut a path in two, combined.
//!
//! A path of k + 2 vertices can be made by a light subpath of s and a camera subpath of t = k + 2 - s
//! of them: run into an emitter (s = 0, naive path tracing), aim at a light (s = 1), connect two vertices, aim
//! at the lens (t = 1, light tracing), run into it (t = 0). Each is good at some paths and poor at others;
//! multiple importance sampling takes the best of all ([Veach 1997] ch. 10). The weights run along with
//! the walks, see [`crate::integrator::bidirectional::weights`].
//!
//! Emitters seen directly are left to the camera (s = 0, t = 2).

use crate::integrator::bidirectional::connect::{
    hit_emitter, hit_environment, hit_lens, next_event, splat,
};
use crate::integrator::bidirectional::{Heuristic, LightSubpath, Walk, Weighing};
use crate::integrator::{Integrator, Method, Parameter, ParameterKind, ParameterValues, Sight};
use crate::render::{Cancelled, Pass};
use crate::scene::Scene;
use crate::transport::reflection::{light_sample, start_sample};

use super::light_tracing::{ROULETTE, lens_sample};
use super::path_tracing::add_unlit;

/// The row of the registry.
pub static METHOD: Method = Method {
    id: "bdpt",
    title: "BDPT",
    name: "Bidirectional path tracing",
    about: "Paths are begun at both ends and joined in every possible way, each way weighed by how well it \
            samples the path.",
    blind_spots: "Lights without extent that are seen, by way of mirrors or smooth glass alone, from the camera, or from \
                  a surface seen so: neither end can be aimed at the other.",
    sight: Sight::FULL,
    bias: None,
    has_techniques: true,
    parameters: &[HEURISTIC, ROULETTE],
    build: |values: &ParameterValues| {
        Box::new(Bidirectional {
            heuristic: heuristic(values),
            has_roulette: values.switch(ROULETTE.name),
        })
    },
};

/// How techniques are combined.
pub(super) const HEURISTIC: Parameter = Parameter {
    name: "heuristic",
    title: "Combine by",
    unit: "",
    about: "How techniques are weighed: by density, by its square, or all alike, which shows why the others matter.",
    kind: ParameterKind::Choice {
        default: 0,
        options: &["balance", "power", "average"],
    },
};

pub(super) fn heuristic(values: &ParameterValues) -> Heuristic {
    match values.choice(HEURISTIC.name) {
        1 => Heuristic::Power,
        2 => Heuristic::Average,
        _ => Heuristic::Balance,
    }
}

struct Bidirectional {
    heuristic: Heuristic,
    has_roulette: bool,
}

impl Integrator for Bidirectional {
    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled> {
        let max_bounces = pass.max_bounces();
        let camera = pass.camera();
        let has_roulette = self.has_roulette;
        // One light path for each camera path.
        let n_paths = pass.n_pixels();
        let numbers = pass.light_numbers(n_paths);
        let shift = pass.light_path_shift(n_paths);
        let weighing = Weighing::connections(self.heuristic, 1.0);
        let room = || LightSubpath::new(scene);
        pass.trace_pixels_with(scene, room, |lights, sample, tracer, sampler, sink| {
            // The light path, each vertex of it aimed at the lens.
            lights.clear();
            let numbers = &mut numbers.path((sample.index + shift) % n_paths);
            if let Some(start) = scene.lights().start(&start_sample(numbers)) {
                let mut walk = Walk::from_light(&start, &weighing);
                loop {
                    let before = walk;
                    let vertex = walk.meet(tracer, &weighing);
                    if camera.has_lens() {
                        let met = vertex.as_ref();
                        if let Some((raster, seen)) =
                            hit_lens(camera, &before, met, n_paths, &weighing)
                        {
                            sink.splat(raster, seen);
                        }
                    }
                    let Some(vertex) = vertex else { break };
                    if walk.bounce() == max_bounces {
                        break;
                    }
                    numbers.start_bounce(walk.bounce());
                    if vertex.surface.bsdf.has_density() {
                        let u = lens_sample(numbers);
                        if let Some((raster, seen)) =
                            splat(tracer, camera, &vertex, u, n_paths, &weighing)
                        {
                            sink.splat(raster, seen);
                        }
                        lights.push(vertex);
                    }
                    if !walk.scatter(&vertex, numbers, has_roulette, &weighing) {
                        break;
                    }
                }
            }

            // The camera path.
            let u = lens_sample(sampler);
            let mut walk = Walk::from_camera(camera, sample.raster, u, &weighing);
            loop {
                // s = 0: L_e where the path runs into it.
                let Some(vertex) = walk.meet(tracer, &weighing) else {
                    if let Some(found) = hit_environment(tracer, &walk, &weighing) {
                        sink.add(found);
                    }
                    return;
                };
                if walk.bounce() == 0 {
                    add_unlit(tracer, &vertex.surface, sink);
                }
                if let Some(found) = hit_emitter(tracer, &walk, &vertex, &weighing) {
                    sink.add(found);
                }
                if walk.bounce() == max_bounces {
                    return;
                }
                sampler.start_bounce(walk.bounce());
                if vertex.surface.bsdf.has_density() {
                    // s = 1: a light aimed at.
                    let u = light_sample(sampler);
                    if let Some(found) = next_event(tracer, &vertex, &u, &weighing) {
                        sink.add(found);
                    }
                    // s ≥ 2: every vertex of the light path that leaves the path short enough.
                    lights.connect(tracer, &vertex, max_bounces, &weighing, |found| {
                        sink.add(found);
                    });
                }
                if !walk.scatter(&vertex, sampler, has_roulette, &weighing) {
                    return;
                }
            }
        })
    }
}
