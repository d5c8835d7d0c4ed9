//! Bidirectional path tracing: every way to cut a path in two, combined.
//!
//! A path of k + 2 vertices can be made by a light subpath of s and a camera subpath of t = k + 2 -
//! s of them: run into an emitter (s = 0, naive path tracing), aim at a light (s = 1), connect two
//! vertices, aim at the lens (t = 1, light tracing), run into it (t = 0). Each is good at some
//! paths and poor at others; multiple importance sampling takes the best of all ([Veach 1997] ch.
//! 10). The weights run along with the walks, see [`crate::integrator::bidirectional::weights`].
//!
//! Emitters seen directly are left to the camera (s = 0, t = 2).

use crate::integrator::bidirectional::{
    CameraEnd, CameraScratch, Heuristic, LightEnd, LightPath, MisWeights, ToLens,
};
use crate::integrator::{
    Integrator, Method, Parameter, ParameterKind, ParameterValues, PassIntegrator, Sight,
};
use crate::pass::{Cancelled, Collected, Pass, PixelPath, Pixels};
use crate::scene::Scene;

use super::light_tracing::ROULETTE;

/// The row of the registry.
pub static METHOD: Method = Method {
    id: "bdpt",
    title: "BDPT",
    name: "Bidirectional path tracing",
    about: "Paths are begun at both ends and joined in every possible way, each way weighed by \
            how well it \
            samples the path.",
    blind_spots: "Lights without extent that are seen, by way of mirrors or smooth glass alone, \
                  from the camera, or from \
                  a surface seen so: neither end can be aimed at the other.",
    formula: "I ≈ Σ w_{s,t} C_{s,t},  w_{s,t} = p_{s,t} / Σ p_{i,j}",
    pseudo_code: include_str!("pseudo_code/bdpt.txt"),
    sight: Sight::FULL,
    bias: None,
    has_techniques: true,
    has_photons: false,
    parameters: &[HEURISTIC, ROULETTE],
    build: |values: &ParameterValues| {
        Integrator::Passes(Box::new(Bidirectional {
            heuristic: heuristic(values),
            has_roulette: values.switch(ROULETTE.name),
        }))
    },
};

/// How techniques are combined.
pub(super) const HEURISTIC: Parameter = Parameter {
    name: "heuristic",
    title: "MIS heuristic",
    unit: "",
    about: "How techniques are weighed: by density, by its square, or all alike, which shows why \
            the others matter.",
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

impl PassIntegrator for Bidirectional {
    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled> {
        // One light path for each camera path.
        let n_paths = pass.n_pixels();
        let numbers = pass.light_numbers(n_paths);
        let shift = pass.light_path_shift(n_paths);
        let (camera, max_bounces) = (pass.camera(), pass.max_bounces());
        let weighing = MisWeights::connections(self.heuristic, 1.0);
        let light = LightEnd {
            scene,
            camera,
            n_paths,
            max_bounces,
            has_roulette: self.has_roulette,
            to_lens: ToLens::AimedOrMet,
            weighing,
        };
        let camera = CameraEnd {
            scene,
            camera,
            max_bounces,
            has_roulette: self.has_roulette,
            has_connections: true,
            merging: None,
            weighing,
        };
        let scratch = || (CameraScratch::new(scene), Vec::new(), Collected::default());
        pass.trace_pixels_together_with(scene, scratch, |scratch, pixels, tracer, sink| {
            let (scratch, kept, paths) = scratch;
            // As many light paths, each vertex of them aimed at the lens.
            let light_path = |(number, index): (usize, usize)| {
                let path = (index + shift) % n_paths;
                LightPath {
                    path: path as u32,
                    number: number as u32,
                    sampler: numbers.path(path),
                }
            };
            let starts = pixels.indices().map(light_path);
            kept.clear();
            light.trace(starts, tracer, sink, |number, vertex| {
                kept.push((number, vertex));
            });
            paths.sort(kept, Pixels::MOST);
            // Its camera paths, each joined with one of them.
            let light_path = |pixel: &PixelPath<'_>| {
                let path = (pixel.sample.index + shift) % n_paths;
                (path as u32, paths.of_path(pixel.number()))
            };
            camera.trace(pixels, light_path, scratch, tracer, sink);
        })
    }
}
