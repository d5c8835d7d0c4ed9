//! Vertex connection and merging: bidirectional path tracing and photon mapping, combined.
//!
//! After I. Georgiev, J. Křivánek, T. Davidovič, Ph. Slusallek, Light Transport Simulation with Vertex Connection and
//! Merging, SIGGRAPH Asia 2012, and Georgiev's implementation report of the same year, whose equation
//! numbers stand in [`super::bidirectional::weights`]. Each iteration has two passes:
//!
//! 1. light paths: every vertex is aimed at the lens and kept;
//! 2. camera paths: every vertex is joined with emitters, with the vertices of one light path by a segment
//!    (vertex connection), and with all light vertices within a radius as if they were at the same point
//!    (vertex merging): a photon map query, seen as one more technique to sample the path.
//!
//! Three numbers run along with each walk, `d_vcm`, `d_vc` and `d_vm`, from which the weight of any joint
//! follows. The radius shrinks from iteration to iteration, so that the bias of merging vanishes.

use glam::Vec3;

use crate::film::{Contribution, PhotonReport, Strategy};
use crate::integrator::{
    Integrator, Method, Parameter, ParameterKind, ParameterValues, Radius, Sight,
};
use crate::photons::{HashGrid, Near, Photon, Placed, Search};
use crate::render::{Cancelled, Collected, Pass, Sink};
use crate::scene::Scene;
use crate::transport::Tracer;
use crate::transport::reflection::{light_sample, start_sample};

use super::bdpt::{HEURISTIC, heuristic};
use super::bidirectional::connect::{hit_emitter, hit_environment, hit_lens, next_event, splat};
use super::bidirectional::{Heuristic, LightSubpath, Partial, Vertex, Walk, Weighing};
use super::light_tracing::{ROULETTE, lens_sample};
use super::path_tracing::{add_unlit, hit};

/// The row of the registry.
pub static METHOD: Method = Method {
    id: "vcm",
    title: "VCM",
    name: "Vertex connection and merging",
    about: "Bidirectional path tracing that also merges nearby vertices, as photon mapping does: each way of joining \
            paths counts where it is good.",
    blind_spots: "Lights without extent seen by way of mirrors or smooth glass alone: nothing can be joined there.",
    sight: Sight::FULL,
    bias: Some("merging blurs by its radius, which shrinks with every iteration"),
    has_techniques: true,
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
            about: "Join subpaths where their vertices are close; without, it is bidirectional path tracing.",
            kind: ParameterKind::Switch { default: true },
        },
        HEURISTIC,
        ROULETTE,
    ],
    build: |values: &ParameterValues| {
        Box::new(Vcm {
            radius: Radius::of(values),
            has_connections: values.switch("connect"),
            has_merges: values.switch("merge"),
            heuristic: heuristic(values),
            has_roulette: values.switch(ROULETTE.name),
            n_light_paths: None,
            paths: Collected::default(),
            grid: HashGrid::default(),
        })
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

/// A light vertex as merging needs it: one line of a processor's cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Mergeable {
    photon: Photon,
    d_vcm: f32,
    d_vm: f32,
}

impl Mergeable {
    /// The quantities that merging needs.
    #[inline]
    fn partial(&self) -> Partial {
        Partial {
            d_vcm: self.d_vcm,
            d_vc: 0.0,
            d_vm: self.d_vm,
        }
    }
}

impl Placed for Mergeable {
    #[inline]
    fn position(&self) -> Vec3 {
        self.photon.position
    }
}

/// A light vertex as connecting needs it: also what makes the surface there again.
#[derive(Clone, Copy, Debug)]
struct LightVertex {
    photon: Photon,
    partial: Partial,
    triangle: u32,
    barycentrics: [f32; 2],
}

/// Memory that light vertices and their index may take, bytes: fewer light paths are traced where they would take more.
const MEMORY: usize = 1 << 30;
/// Paths whose lengths are looked at to know how many fit.
const PILOT: usize = 4096;

impl Integrator for Vcm {
    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled> {
        let max_bounces = pass.max_bounces();
        let camera = pass.camera();
        let (has_connections, has_merges) = (self.has_connections, self.has_merges);
        let has_roulette = self.has_roulette;
        let n_paths = self.n_light_paths(scene, pass)?;
        let radius = self.radius.at(scene, pass.iteration());
        let light_paths_per_pixel = n_paths as f32 / pass.n_pixels() as f32;
        let mut weighing = Weighing::connections(self.heuristic, light_paths_per_pixel);
        if has_merges {
            weighing = weighing.merges(n_paths, radius, has_connections);
        }

        // First pass: light paths.
        let numbers = pass.light_numbers(n_paths);
        pass.trace_light_paths_into(
            &mut self.paths,
            scene,
            n_paths,
            numbers,
            |_, tracer, sampler, sink, kept| {
                let Some(start) = scene.lights().start(&start_sample(sampler)) else {
                    return;
                };
                let mut walk = Walk::from_light(&start, &weighing);
                loop {
                    let before = walk;
                    let vertex = walk.meet(tracer, &weighing);
                    if has_connections && camera.has_lens() {
                        let found = hit_lens(camera, &before, vertex.as_ref(), n_paths, &weighing);
                        if let Some((raster, seen)) = found {
                            sink.splat(raster, seen);
                        }
                    }
                    let Some(vertex) = vertex else { return };
                    if walk.bounce() == max_bounces {
                        return;
                    }
                    if vertex.surface.bsdf.has_density() {
                        kept.push(LightVertex::of(&vertex));
                    }
                    sampler.start_bounce(walk.bounce());
                    if has_connections && vertex.surface.bsdf.has_density() {
                        let u = lens_sample(sampler);
                        let found = splat(tracer, camera, &vertex, u, n_paths, &weighing);
                        if let Some((raster, seen)) = found {
                            sink.splat(raster, seen);
                        }
                    }
                    if !walk.scatter(&vertex, sampler, has_roulette, &weighing) {
                        return;
                    }
                }
            },
        )?;
        let paths = &self.paths;
        if has_merges {
            self.grid.fill(&paths.items, radius, LightVertex::mergeable);
        }
        let grid = has_merges.then_some(&self.grid);
        pass.report(PhotonReport {
            radius: if has_merges { radius } else { 0.0 },
            n_paths,
            n_vertices: paths.items.len(),
            bytes: size_of_val(paths.items.as_slice()) + grid.map_or(0, HashGrid::bytes),
        });

        // Second pass: camera paths.
        let per_merge = std::f32::consts::FRAC_1_PI / (radius * radius * n_paths as f32);
        // All light vertices near one of the camera's.
        let merge = |vertex: &Vertex<'_>, near: &[Near], sink: &mut Sink<'_>| {
            for found in near {
                let light = &self.grid.entries()[found.number as usize];
                let strategy = Strategy::merge(light.photon.n_vertices, vertex.n_vertices);
                if strategy.bounce() > max_bounces {
                    continue;
                }
                let Some(scattered) = light.photon.scattered(&vertex.surface) else {
                    continue;
                };
                sink.add(Contribution {
                    value: vertex.throughput * scattered.f_power * per_merge,
                    mis_weight: weighing.merge(
                        vertex.partial,
                        light.partial(),
                        scattered.scattering.pdf_w_forward,
                        scattered.scattering.pdf_w_reverse,
                    ),
                    bounce: strategy.bounce(),
                    strategy,
                });
            }
        };
        let shift = pass.light_path_shift(n_paths);
        let room = || (LightSubpath::new(scene), Vec::new());
        pass.trace_pixels_with(
            scene,
            room,
            |(lights, near), sample, tracer, sampler, sink| {
                lights.clear();
                if has_connections {
                    let path = paths.of_path((sample.index + shift) % n_paths);
                    for vertex in path {
                        lights.push(vertex.restored(tracer));
                    }
                }
                let u = lens_sample(sampler);
                let mut walk = Walk::from_camera(camera, sample.raster, u, &weighing);
                // The vertex that is still to be merged, with its search. What it looks for is far away in memory, so it
                // is taken step by step, and comes to its end one vertex later.
                let mut merging: Option<(Vertex<'_>, Search)> = None;
                loop {
                    let met = walk.meet(tracer, &weighing);
                    if let Some((_, search)) = &merging {
                        self.grid.finish(search, near);
                    }
                    let Some(vertex) = met else {
                        if has_connections {
                            if let Some(found) = hit_environment(tracer, &walk, &weighing) {
                                sink.add(found);
                            }
                        } else if walk.is_specular {
                            let radiance =
                                scene.lights().environment_radiance(walk.ray.direction());
                            let bounce = u32::from(walk.n_vertices) - 1;
                            sink.add(hit(bounce, walk.throughput * radiance, 1.0));
                        }
                        break;
                    };
                    let bounce = walk.bounce();
                    if bounce == 0 {
                        add_unlit(tracer, &vertex.surface, sink);
                    }
                    if has_connections {
                        if let Some(found) = hit_emitter(tracer, &walk, &vertex, &weighing) {
                            sink.add(found);
                        }
                    } else if walk.is_specular {
                        // Merging alone cannot find light by way of mirrors only.
                        let emitted = tracer.emitted(&vertex.surface);
                        sink.add(hit(bounce, vertex.throughput * emitted, 1.0));
                    }
                    if bounce == max_bounces {
                        break;
                    }
                    sampler.start_bounce(bounce);
                    let joins = vertex.surface.bsdf.has_density();
                    let search = grid
                        .filter(|_| joins)
                        .map(|grid| grid.begin(vertex.surface.point.position));
                    if joins && has_connections {
                        let u = light_sample(sampler);
                        if let Some(found) = next_event(tracer, &vertex, &u, &weighing) {
                            sink.add(found);
                        }
                        lights.connect(tracer, &vertex, max_bounces, &weighing, |found| {
                            sink.add(found);
                        });
                    }
                    if let Some((before, _)) = merging.take() {
                        merge(&before, near, sink);
                    }
                    if let Some(search) = search {
                        self.grid.approach(&search);
                        merging = Some((vertex, search));
                    }
                    if !walk.scatter(&vertex, sampler, has_roulette, &weighing) {
                        if let Some((_, search)) = &merging {
                            self.grid.finish(search, near);
                        }
                        break;
                    }
                }
                if let Some((last, _)) = merging {
                    merge(&last, near, sink);
                }
            },
        )
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
        let weighing = Weighing::one_technique();
        let numbers = pass.fixed_light_numbers();
        let paths =
            pass.trace_light_paths(scene, PILOT, numbers, |_, tracer, sampler, _, kept| {
                let Some(start) = scene.lights().start(&start_sample(sampler)) else {
                    return;
                };
                let mut walk = Walk::from_light(&start, &weighing);
                while let Some(vertex) = walk.meet(tracer, &weighing) {
                    if vertex.surface.bsdf.has_density() {
                        kept.push(());
                    }
                    sampler.start_bounce(walk.bounce());
                    if walk.bounce() == max_bounces
                        || !walk.scatter(&vertex, sampler, has_roulette, &weighing)
                    {
                        return;
                    }
                }
            })?;
        Ok(paths.items.len() as f64 / PILOT as f64)
    }
}

impl LightVertex {
    fn of(vertex: &Vertex<'_>) -> Self {
        Self {
            photon: vertex.photon(),
            partial: vertex.partial,
            triangle: vertex.surface.triangle,
            barycentrics: vertex.surface.barycentrics,
        }
    }

    fn mergeable(&self) -> Mergeable {
        Mergeable {
            photon: self.photon,
            d_vcm: self.partial.d_vcm,
            d_vm: self.partial.d_vm,
        }
    }

    /// The vertex as its walk had it.
    fn restored<'a>(&self, tracer: &Tracer<'a>) -> Vertex<'a> {
        let photon = &self.photon;
        Vertex {
            surface: tracer.surface_at(self.triangle, self.barycentrics, photon.wo),
            throughput: photon.power,
            partial: self.partial,
            // A segment's absorption is that on the camera vertex's side of it.
            medium: crate::transport::Medium::VACUUM,
            n_vertices: photon.n_vertices,
        }
    }
}
