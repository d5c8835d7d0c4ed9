//! Vertex connection and merging: bidirectional path tracing and photon mapping, combined.
//!
//! After I. Georgiev, J. Křivánek, T. Davidovič, Ph. Slusallek, Light Transport Simulation with
//! Vertex Connection and Merging, SIGGRAPH Asia 2012, and Georgiev's implementation report of the
//! same year, whose equation numbers stand in [`super::bidirectional::weights`]. Each iteration has
//! two passes:
//!
//! 1. light paths: every vertex is aimed at the lens and kept;
//! 2. camera paths: every vertex is joined with emitters, with the vertices of one light path by a
//!    segment (vertex connection), and with all light vertices within a radius as if they were at
//!    the same point (vertex merging): a photon map query, seen as one more technique to sample the
//!    path.
//!
//! Three numbers run along with each walk, `d_vcm`, `d_vc` and `d_vm`, from which the weight of any
//! joint follows. The radius shrinks from iteration to iteration, so that the bias of merging
//! vanishes.

use crate::film::PhotonReport;
use crate::integrator::{
    Integrator, Method, Parameter, ParameterKind, ParameterValues, PassIntegrator, Radius, Sight,
};
use crate::pass::{Cancelled, Collected, Pass, PixelPath};
use crate::photons::HashGrid;
use crate::scene::Scene;
use crate::transport::reflection::start_sample;

use super::bdpt::{HEURISTIC, heuristic};
use super::bidirectional::{
    CameraEnd, CameraScratch, Heuristic, LightEnd, LightVertex, Mergeable, Merging, MisWeights,
    ToLens, Walk, numbered,
};
use super::light_tracing::ROULETTE;

/// The row of the registry.
pub static METHOD: Method = Method {
    id: "vcm",
    title: "VCM",
    name: "Vertex connection and merging",
    about: "Bidirectional path tracing that also merges nearby vertices, as photon mapping does: \
            each way of joining \
            paths counts where it is good.",
    blind_spots: "Lights without extent seen by way of mirrors or smooth glass alone: nothing \
                  can be joined there.",
    formula: "I ≈ Σ w C_{s,t} + Σ w f Φ / N π r²,  w = n p / Σ n p",
    pseudo_code: include_str!("pseudo_code/vcm.txt"),
    sight: Sight::FULL,
    bias: Some("merging blurs by its radius, which shrinks with every iteration"),
    has_techniques: true,
    has_photons: false,
    parameters: &[
        Radius::INITIAL,
        Radius::UNIT,
        Radius::ALPHA,
        Parameter {
            name: "connect",
            title: "Connect vertices",
            unit: "",
            about: "Join subpaths by segments; without, it is bidirectional photon mapping.",
            kind: ParameterKind::Switch { default: true },
        },
        Parameter {
            name: "merge",
            title: "Merge vertices",
            unit: "",
            about: "Join subpaths where their vertices are close; without, it is bidirectional \
                    path tracing.",
            kind: ParameterKind::Switch { default: true },
        },
        HEURISTIC,
        ROULETTE,
    ],
    build: |values: &ParameterValues| {
        Integrator::Passes(Box::new(Vcm {
            radius: Radius::of(values),
            has_connections: values.switch("connect"),
            has_merges: values.switch("merge"),
            heuristic: heuristic(values),
            has_roulette: values.switch(ROULETTE.name),
            n_light_paths: None,
            paths: Collected::default(),
            grid: HashGrid::default(),
        }))
    },
};

struct Vcm {
    radius: Radius,
    has_connections: bool,
    has_merges: bool,
    heuristic: Heuristic,
    has_roulette: bool,
    /// Light paths in an iteration, once it is known how long they are.
    n_light_paths: Option<usize>,
    /// What the last iteration's light paths left; kept for its memory.
    paths: Collected<LightVertex>,
    grid: HashGrid<Mergeable>,
}

/// Memory that light vertices and their index may take, bytes: fewer light paths are traced where
/// they would take more.
const MEMORY: usize = 1 << 30;
/// Paths whose lengths are looked at to know how many fit.
const PILOT: usize = 4096;

impl PassIntegrator for Vcm {
    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled> {
        let max_bounces = pass.max_bounces();
        let camera = pass.camera();
        let (has_connections, has_merges) = (self.has_connections, self.has_merges);
        let has_roulette = self.has_roulette;
        let n_paths = self.n_light_paths(scene, pass)?;
        let radius = self.radius.at(scene, camera, pass.iteration());
        let light_paths_per_pixel = n_paths as f32 / pass.n_pixels() as f32;
        let mut weighing = MisWeights::connections(self.heuristic, light_paths_per_pixel);
        if has_merges {
            weighing = weighing.merges(n_paths, radius, has_connections);
        }

        // First pass: light paths.
        let light = LightEnd {
            scene,
            camera,
            n_paths,
            max_bounces,
            has_roulette,
            to_lens: if has_connections {
                ToLens::AimedOrMet
            } else {
                ToLens::Never
            },
            weighing,
        };
        let numbers = pass.light_numbers(n_paths);
        pass.collect_light_paths_together(
            &mut self.paths,
            scene,
            n_paths,
            numbers,
            |paths, tracer, sink, kept| {
                let keep = |number, vertex| kept.push((number, vertex));
                light.trace(numbered(paths), tracer, sink, keep);
            },
        )?;
        let paths = &self.paths;
        if has_merges {
            self.grid.fill(&paths.items, radius, Mergeable::of);
        }
        let grid = has_merges.then_some(&self.grid);
        pass.report(PhotonReport {
            radius: if has_merges { radius } else { 0.0 },
            n_paths,
            n_vertices: paths.items.len(),
            bytes: size_of_val(paths.items.as_slice()) + grid.map_or(0, HashGrid::bytes),
        });

        // Second pass: camera paths.
        let camera = CameraEnd {
            scene,
            camera,
            max_bounces,
            has_roulette,
            has_connections,
            merging: grid.map(|grid| Merging::new(grid, paths, radius)),
            weighing,
        };
        let shift = pass.light_path_shift(n_paths);
        let scratch = || CameraScratch::new(scene);
        pass.trace_pixels_together_with(scene, scratch, |scratch, pixels, tracer, sink| {
            let light_path = |pixel: &PixelPath<'_>| {
                let path = (pixel.sample.index + shift) % n_paths;
                (path as u32, paths.of_path(path))
            };
            camera.trace(pixels, light_path, scratch, tracer, sink);
        })
    }
}

impl Vcm {
    /// As many light paths as pixels, or fewer if their vertices would take too much memory.
    fn n_light_paths(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<usize, Cancelled> {
        if let Some(n) = self.n_light_paths {
            return Ok(n);
        }
        let n_pixels = pass.n_pixels();
        // A vertex, its copy in the grid, and its share of the grid's table and order.
        let bytes = size_of::<LightVertex>() + size_of::<Mergeable>() + 12;
        let longest = n_pixels.saturating_mul(pass.max_bounces() as usize + 1);
        let n = if longest.saturating_mul(bytes) <= MEMORY {
            n_pixels
        } else {
            let n_vertices = self.mean_length(scene, pass)?;
            let fits = MEMORY as f64 / (bytes as f64 * 1.1 * n_vertices.max(0.1));
            n_pixels.min(fits as usize).max(1)
        };
        self.n_light_paths = Some(n);
        Ok(n)
    }

    /// Vertices that a light path leaves on average.
    fn mean_length(&self, scene: &Scene, pass: &mut Pass<'_>) -> Result<f64, Cancelled> {
        let (max_bounces, has_roulette) = (pass.max_bounces(), self.has_roulette);
        let weighing = MisWeights::one_technique();
        let numbers = pass.fixed_light_numbers();
        let paths =
            pass.trace_light_paths(scene, PILOT, numbers, |_, tracer, sampler, _, kept| {
                let Some(start) = scene.lights().start(&start_sample(&sampler.start())) else {
                    return;
                };
                let mut walk = Walk::from_light(&start, tracer, &weighing);
                while let Some(vertex) = walk.meet(tracer, &weighing) {
                    if vertex.surface.bsdf.has_density() {
                        kept.push(());
                    }
                    let u = sampler.bounce(walk.bounce());
                    if walk.bounce() == max_bounces
                        || !walk.scatter(&vertex, tracer, &u, has_roulette, &weighing)
                    {
                        return;
                    }
                }
            })?;
        Ok(paths.items.len() as f64 / PILOT as f64)
    }
}
