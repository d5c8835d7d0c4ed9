//! Photon mapping, with a fixed radius (`pm`) and with one that shrinks (`ppm`).
//!
//! Two passes (Jensen 2001, ch. 5-7). First, photons: light paths leave a photon wherever they land
//! on a surface that is not mirror-like. Then, like path tracing with a question to the photon map
//! in place of the recursion: at the first hit that is rough enough, the light that scatters there
//! is estimated from the photons around it. Mirrors, glass and sharp reflections on the way are
//! followed as a path tracer does.
//!
//! `pm` keeps one map for all iterations, as on the slides: its blotches do not go away. `ppm`
//! makes a new map with a smaller radius in each iteration (the probabilistic form of Knaus and
//! Zwicker 2011), so that the mean converges to the true image.

use std::sync::Arc;

use crate::endpoint::LightChoice;
use crate::film::{Contribution, PhotonReport, Strategy};
use crate::integrator::{
    Integrator, Method, Parameter, ParameterKind, ParameterValues, PassIntegrator, Radius, Sight,
};
use crate::math::Ray;
use crate::pass::{Cancelled, Collected, Pass, PixelSink};
use crate::photons::{HashGrid, Kernel, Near, Photon, PhotonMap};
use crate::radiometry::Rgb;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::bodies::Media;
use crate::transport::reflection::{Drawn, aim_at_light, light_sample, start_sample};
use crate::transport::{SurfaceVertex, Tracer, VertexSample};

use super::bidirectional::{MisWeights, Walk};
use super::path_tracing::bsdf::MODE;
use super::path_tracing::{add_unlit, connect, hit};

/// The row of `pm`.
pub static METHOD: Method = Method {
    id: "pm",
    title: "photons",
    name: "Photon mapping",
    about: "Photons are traced from the lights and kept; then the light at each surface is read \
            off the photons \
            around it.",
    blind_spots: BLIND_SPOTS,
    formula: "T L ≈ Σ f Φ K_r / N,  the photons within r",
    pseudo_code: include_str!("pseudo_code/pm.txt"),
    sight: Sight::FULL,
    bias: Some("photons are counted within a fixed radius, and one map is kept for good"),
    has_techniques: false,
    has_photons: true,
    parameters: &[
        Radius::INITIAL,
        Radius::UNIT,
        PATHS,
        KERNEL,
        Parameter {
            name: "nearest",
            title: "Nearest photons",
            unit: "",
            about: "Shrink the radius to that many photons where there are more; 0 takes all \
                    within the radius.",
            kind: ParameterKind::Integer {
                default: 0,
                min: 0,
                max: 1000,
            },
        },
        ROUGHNESS,
        Parameter {
            name: "gather",
            title: "Final gather",
            unit: "rays",
            about: "Ask the map not where the camera looks but where so many rays from there \
                    end; lights are aimed at.",
            kind: ParameterKind::Integer {
                default: 0,
                min: 0,
                max: 64,
            },
        },
        Parameter {
            name: "map",
            title: "Photon map",
            unit: "",
            about: "Keep one map for all iterations, or trace a new one for each.",
            kind: ParameterKind::Choice {
                default: 0,
                options: &["kept", "renewed"],
            },
        },
    ],
    build: |values: &ParameterValues| {
        Integrator::Passes(Box::new(PhotonMapping {
            is_kept: values.choice("map") == 0,
            n_nearest: values.integer("nearest") as usize,
            n_gather: values.integer("gather") as u32,
            ..PhotonMapping::of(values)
        }))
    },
};

/// The row of `ppm`.
pub static PROGRESSIVE: Method = Method {
    id: "ppm",
    title: "prog. photons",
    name: "Progressive photon mapping",
    about: "A new photon map for each iteration, with a smaller radius each time: blur and \
            blotches both go away.",
    blind_spots: BLIND_SPOTS,
    formula: "T L ≈ Σ f Φ K_i / N,  r_i² = r_1² i^{α − 1}",
    pseudo_code: include_str!("pseudo_code/ppm.txt"),
    sight: Sight::FULL,
    bias: Some("photons are counted within a radius, which shrinks with every iteration"),
    has_techniques: false,
    has_photons: true,
    parameters: &[
        Radius::INITIAL,
        Radius::UNIT,
        Radius::ALPHA,
        PATHS,
        KERNEL,
        ROUGHNESS,
    ],
    build: |values: &ParameterValues| Integrator::Passes(Box::new(PhotonMapping::of(values))),
};

const BLIND_SPOTS: &str =
    "Lights without extent seen by way of mirrors or smooth glass alone: no photon rests there.";

const PATHS: Parameter = Parameter {
    name: "paths",
    title: "Light paths",
    unit: "per pixel",
    about: "Light paths traced for a photon map, for each pixel of the film.",
    kind: ParameterKind::Real {
        default: 1.0,
        min: 0.001,
        max: 16.0,
        is_logarithmic: true,
    },
};

const KERNEL: Parameter = Parameter {
    name: "kernel",
    title: "Kernel",
    unit: "",
    about: "Whether all photons within the radius count alike, or nearer ones more.",
    kind: ParameterKind::Choice {
        default: 0,
        options: &["constant", "epanechnikov"],
    },
};

const ROUGHNESS: Parameter = Parameter {
    name: "roughness",
    title: "Roughness threshold",
    unit: "",
    about: "The map is asked at surfaces of at least this roughness; sharper reflections are \
            followed.",
    kind: ParameterKind::Real {
        default: 0.3,
        min: 0.0,
        max: 1.0,
        is_logarithmic: false,
    },
};

/// What lights aimed at are chosen by.
const CHOICE: LightChoice = LightChoice::Tree;

/// Photons that a map has at most; fewer paths are traced where there would be more.
const MAX_PHOTONS: usize = 12_000_000;

struct PhotonMapping {
    radius: Radius,
    paths_per_pixel: f32,
    kernel: Kernel,
    roughness: f32,
    is_kept: bool,
    n_nearest: usize,
    n_gather: u32,
    kept: Option<Traced>,
}

/// Photons with the paths that have left them.
struct Traced {
    map: Arc<PhotonMap>,
    /// The photons themselves are in the map alone.
    paths: Collected<Photon>,
}

impl PhotonMapping {
    fn of(values: &ParameterValues) -> Self {
        Self {
            radius: Radius::of(values),
            paths_per_pixel: values.real(PATHS.name) as f32,
            kernel: match values.choice(KERNEL.name) {
                0 => Kernel::Constant,
                _ => Kernel::Epanechnikov,
            },
            roughness: values.real(ROUGHNESS.name) as f32,
            is_kept: false,
            n_nearest: 0,
            n_gather: 0,
            kept: None,
        }
    }
}

impl PassIntegrator for PhotonMapping {
    fn shows_its_error(&self) -> bool {
        !self.is_kept
    }

    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled> {
        // First pass.
        let traced = self.traced(scene, pass)?;
        let map = &traced.map;
        pass.report(PhotonReport {
            radius: map.radius,
            n_paths: map.n_paths,
            n_vertices: map.grid.len(),
            bytes: map.grid.bytes(),
        });
        // Second pass.
        let done = self.trace_camera(scene, pass, &traced);
        self.keep(traced);
        done
    }

    fn photons(
        &mut self,
        scene: &Scene,
        pass: &mut Pass<'_>,
    ) -> Result<Option<Arc<PhotonMap>>, Cancelled> {
        let traced = self.traced(scene, pass)?;
        let map = Arc::clone(&traced.map);
        self.keep(traced);
        Ok(Some(map))
    }
}

impl PhotonMapping {
    /// The photons of an iteration: those that are kept, or new ones.
    fn traced(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<Traced, Cancelled> {
        match self.kept.take() {
            Some(traced) => Ok(traced),
            None => self.trace_photons(scene, pass),
        }
    }

    fn keep(&mut self, traced: Traced) {
        if self.is_kept {
            self.kept = Some(traced);
        }
    }

    /// Light paths, a photon wherever one lands on a surface that is not mirror-like.
    fn trace_photons(&self, scene: &Scene, pass: &mut Pass<'_>) -> Result<Traced, Cancelled> {
        let max_bounces = pass.max_bounces();
        let wanted = (pass.n_pixels() as f32 * self.paths_per_pixel).ceil() as usize;
        let n_paths = wanted.clamp(1, MAX_PHOTONS / (max_bounces as usize).clamp(1, 6));
        let numbers = if self.is_kept {
            pass.fixed_light_numbers()
        } else {
            pass.light_numbers(n_paths)
        };
        let weighing = MisWeights::one_technique();
        let mut paths = pass.trace_light_paths(
            scene,
            n_paths,
            numbers,
            |index, tracer, sampler, _, photons| {
                tracer.next_light_path(index as u32);
                let Some(start) = scene.lights().start(&start_sample(&sampler.start())) else {
                    return;
                };
                let mut walk = Walk::from_light(&start, tracer, &weighing);
                while let Some(vertex) = walk.meet(tracer, &weighing) {
                    if walk.bounce() == max_bounces {
                        return;
                    }
                    if vertex.surface.bsdf.has_density() {
                        photons.push(vertex.photon());
                    }
                    let u = sampler.bounce(walk.bounce());
                    if !walk.scatter(&vertex, tracer, &u, true, &weighing) {
                        return;
                    }
                }
            },
        )?;
        let iteration = if self.is_kept { 0 } else { pass.iteration() };
        let radius = self.radius.at(scene, pass.camera(), iteration);
        let grid = HashGrid::new(&paths.items, radius, |photon| *photon);
        // The grid has copies.
        paths.items = Vec::new();
        let map = Arc::new(PhotonMap {
            grid,
            radius,
            n_paths,
            iteration,
        });
        Ok(Traced { map, paths })
    }

    /// Camera paths, up to the first surface that is rough enough.
    fn trace_camera(
        &self,
        scene: &Scene,
        pass: &mut Pass<'_>,
        traced: &Traced,
    ) -> Result<(), Cancelled> {
        let camera = pass.camera();
        let eye = Eye {
            scene,
            traced,
            mapping: self,
            max_bounces: pass.max_bounces(),
        };
        pass.trace_pixels_with(scene, Vec::new, |near, sample, tracer, sampler, sink| {
            let ray = camera.ray(sample.raster, sampler.start().lens).ray;
            let segment = Segment {
                ray,
                throughput: Rgb::WHITE,
                media: tracer.begin_at_camera(&ray),
                drawn: Drawn::NOWHERE,
                leaves_emitters: false,
                bounce: 0,
            };
            eye.follow(segment, self.n_gather, tracer, sampler, sink, near);
        })
    }
}

/// What camera paths know.
struct Eye<'a> {
    scene: &'a Scene,
    traced: &'a Traced,
    mapping: &'a PhotonMapping,
    max_bounces: u32,
}

/// A camera path on its way.
#[derive(Clone, Copy)]
struct Segment {
    ray: Ray,
    throughput: Rgb,
    media: Media,
    /// Where the ray's direction was drawn.
    drawn: Drawn,
    /// True where emitters have been aimed at for good.
    leaves_emitters: bool,
    /// Scattering events so far.
    bounce: u32,
}

impl Eye<'_> {
    /// Follows a path through mirrors, glass and sharp reflections to where the map is asked;
    /// `n_gather` rays go on from there first.
    fn follow(
        &self,
        mut path: Segment,
        n_gather: u32,
        tracer: &mut Tracer<'_>,
        sampler: &Sampler<'_>,
        sink: &mut PixelSink<'_>,
        near: &mut Vec<Near>,
    ) {
        let lights = self.scene.lights();
        loop {
            // What does the ray meet? L_e counts, against having been aimed at.
            let ray = path.ray;
            let Some(vertex) = tracer.meet(&ray, &mut path.media, &mut path.throughput) else {
                let radiance = lights.environment_radiance(path.ray.direction());
                if !radiance.is_black() {
                    let direction = path.ray.direction();
                    let weight =
                        path.weight(|d| d.mis_weight_of_environment(tracer, CHOICE, direction));
                    sink.add(hit(path.bounce, path.throughput * radiance, weight));
                }
                return;
            };
            if path.bounce == 0 {
                add_unlit(tracer, &vertex, sink);
            }
            let emitted = tracer.emitted(&vertex);
            if !emitted.is_black() {
                let weight = path.weight(|d| d.mis_weight(tracer, CHOICE, &vertex));
                sink.add(hit(path.bounce, path.throughput * emitted, weight));
            }
            if path.bounce == self.max_bounces {
                return;
            }

            let u = sampler.bounce(path.bounce);
            let has_density = vertex.bsdf.has_density();
            let is_rough = has_density && vertex.bsdf.roughness() >= self.mapping.roughness;
            if is_rough && n_gather == 0 {
                // Rough enough: what scatters here is read off the map.
                self.ask_map(&vertex, &path, sink, near);
            } else if has_density {
                // A light aimed at, against running into it.
                let light = light_sample(&u);
                if let Some(aimed) = aim_at_light(tracer, &vertex, path.media, CHOICE, &light) {
                    let value = path.throughput * aimed.value;
                    // Rays of a final gather leave emitters to the light aimed at.
                    let weight = if is_rough { 1.0 } else { aimed.mis_weight() };
                    sink.add(connect(path.bounce + 1, value, weight));
                }
            }
            if is_rough && n_gather > 0 {
                self.gather(&vertex, &path, tracer, sampler, sink, near);
            }

            // Mirror-like and sharp lobes are followed.
            let Some(sample) = vertex.sample(u.bsdf(), MODE) else {
                return;
            };
            if is_rough && !sample.is_delta {
                return;
            }
            tracer.leaves(&vertex, &sample, MODE, 1.0);
            path = path.beyond(&vertex, &sample);
        }
    }

    /// Final gather: rays by the BSDF's density, followed to where the map is asked.
    fn gather(
        &self,
        vertex: &SurfaceVertex<'_>,
        path: &Segment,
        tracer: &mut Tracer<'_>,
        sampler: &Sampler<'_>,
        sink: &mut PixelSink<'_>,
        near: &mut Vec<Near>,
    ) {
        let n = self.mapping.n_gather;
        tracer.splits(n);
        for i in 0..n {
            let numbers = sampler.branch(path.bounce, i);
            let u = numbers.bounce(path.bounce).bsdf();
            let Some(sample) = vertex.sample(u, MODE) else {
                continue;
            };
            if sample.is_delta {
                continue;
            }
            tracer.leaves(vertex, &sample, MODE, 1.0);
            let mut ray = path.beyond(vertex, &sample);
            ray.throughput *= 1.0 / n as f32;
            // Emitters met by these rays have been aimed at already.
            ray.leaves_emitters = true;
            self.follow(ray, 0, tracer, &numbers, sink, near);
        }
    }

    /// Density estimation: `Σ f Φ K`.
    fn ask_map(
        &self,
        vertex: &SurfaceVertex<'_>,
        path: &Segment,
        sink: &mut PixelSink<'_>,
        near: &mut Vec<Near>,
    ) {
        let Traced { map, paths } = self.traced;
        let n_nearest = self.mapping.n_nearest;
        let kernel = self.mapping.kernel;
        let x = vertex.point.position;
        let mut add = |number: u32, distance_squared: f32, radius_squared: f32| {
            let photon = &map.grid.entries()[number as usize];
            let strategy = Strategy::merge(photon.n_vertices, path.bounce as u16 + 2);
            if strategy.bounce() > self.max_bounces {
                return;
            }
            if let Some(scattered) = photon.scattered(vertex) {
                if sink.is_observed() {
                    sink.merges(paths.path_of(map.grid.item_of(number)));
                }
                let weight = kernel.at(distance_squared, radius_squared) / map.n_paths as f32;
                sink.add(Contribution {
                    value: path.throughput * scattered.f_power * weight,
                    mis_weight: 1.0,
                    bounce: strategy.bounce(),
                    strategy,
                });
            }
        };
        map.grid.find(x, near);
        let mut r2 = map.radius * map.radius;
        if n_nearest > 0 && near.len() > n_nearest {
            // The disk reaches to the first photon that is left out.
            near.select_nth_unstable_by(n_nearest, |a, b| {
                let by_distance = a.distance_squared.total_cmp(&b.distance_squared);
                by_distance.then(a.number.cmp(&b.number))
            });
            r2 = near[n_nearest].distance_squared;
            near.truncate(n_nearest);
            near.sort_unstable_by_key(|near| near.number);
        }
        for found in near.iter() {
            add(found.number, found.distance_squared, r2);
        }
    }
}

impl Segment {
    /// MIS weight of light that was run into, against having been aimed at.
    #[inline]
    fn weight(&self, of: impl Fn(&Drawn) -> f32) -> f32 {
        if self.leaves_emitters {
            0.0
        } else {
            of(&self.drawn)
        }
    }

    fn beyond(&self, vertex: &SurfaceVertex<'_>, sample: &VertexSample) -> Self {
        Self {
            ray: vertex.ray(sample.wi),
            throughput: self.throughput * sample.throughput(),
            media: vertex.media_towards(sample.wi, self.media),
            drawn: Drawn::at(vertex, sample),
            leaves_emitters: false,
            bounce: self.bounce + 1,
        }
    }
}
