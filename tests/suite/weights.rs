//! Do the running weights equal those written out?
//!
//! Paths of real scenes, from one to six bounces, over rough and smooth surfaces, with each kind of
//! light and camera. For each of them the density of every technique is multiplied out vertex by
//! vertex, in double precision; the weights that follow must be those of the running quantities,
//! and add to one.

use neumann_core::bsdf::TransportMode;
use neumann_core::endpoint::light::LightSample;
use neumann_core::endpoint::{Aim, Camera, CameraRay, LensHit, LightChoice, Spread, Start};
use neumann_core::integrator::bidirectional::weights::{EndDensities, JointDensities};
use neumann_core::integrator::bidirectional::{Heuristic, MisWeights, Partial, Walk};
use neumann_core::scene::Scene;
use neumann_core::scene::description::{CameraDescription, Lens, Projection};
use neumann_core::transport::{SurfaceVertex, Tracer};
use neumann_tests::lights::light_sample;
use neumann_tests::random::Random;
use neumann_tests::scenes::builtin;
use neumann_tests::studio::studios;

use glam::Vec2;

/// A vertex on a surface, seen from the light's side and from the camera's.
struct Between {
    /// Density with which the light's walk goes on to the camera's side, 1/sr (a delta lobe's
    /// probability).
    light_pdf: f64,
    /// Density with which the camera's walk goes on to the light's side.
    camera_pdf: f64,
    /// Cosines with the geometric normal towards the light's and the camera's side.
    light_cos: f64,
    camera_cos: f64,
    is_delta: bool,
}

/// A path: the light aimed at, surfaces counted from the light, the camera.
struct Path {
    aim: Aim,
    surfaces: Vec<Between>,
    /// `distances[i]`: from vertex i to vertex i + 1, the light being 0.
    distances: Vec<f64>,
    camera: CameraRay,
    lens_aim: Aim,
}

fn uniform(random: &mut Random) -> f32 {
    random.pair()[0]
}

/// A path of `n` surfaces, walked from the camera and closed by aiming at a light.
fn path(scene: &Scene, camera: &Camera, size: f32, n: usize, random: &mut Random) -> Option<Path> {
    let mut tracer = Tracer::new(scene);
    let raster = Vec2::new(uniform(random), uniform(random)) * size;
    let u_lens = [uniform(random), uniform(random)];
    let start = camera.ray(raster, u_lens);
    let mut ray = start.ray;
    let mut vertices: Vec<SurfaceVertex<'_>> = Vec::new();
    let mut surfaces = Vec::new();
    let mut distances = Vec::new();
    loop {
        let vertex = tracer.vertex(&ray)?;
        distances.push(f64::from(vertex.distance));
        vertices.push(vertex);
        if vertices.len() == n {
            break;
        }
        let u = [uniform(random), uniform(random), uniform(random)];
        let sample = vertex.sample(u, TransportMode::Radiance)?;
        surfaces.push(Between {
            light_pdf: f64::from(vertex.pdf_w_reverse(&sample, TransportMode::Radiance)),
            camera_pdf: f64::from(sample.pdf_w),
            light_cos: f64::from(vertex.cos_g(sample.wi)),
            camera_cos: f64::from(vertex.cos_g(vertex.wo)),
            is_delta: sample.is_delta,
        });
        ray = vertex.ray(sample.wi);
    }
    let last = vertices.last()?;
    let u = LightSample {
        choice: [uniform(random), uniform(random)],
        point: [uniform(random), uniform(random)],
        direction: [0.0; 2],
    };
    let aim = scene
        .lights()
        .aim(&last.receiver(), LightChoice::Tree, &u)?;
    last.scattering(aim.wi, TransportMode::Radiance)?;
    let densities = last.densities(aim.wi);
    surfaces.push(Between {
        light_pdf: f64::from(densities.reverse),
        camera_pdf: f64::from(densities.forward),
        light_cos: f64::from(last.cos_g(aim.wi)),
        camera_cos: f64::from(last.cos_g(last.wo)),
        is_delta: false,
    });
    distances.push(f64::from(aim.distance));
    surfaces.reverse();
    distances.reverse();
    let (lens_aim, _) = camera.aim(vertices[0].point.position, u_lens)?;
    Some(Path {
        aim,
        surfaces,
        distances,
        camera: start,
        lens_aim,
    })
}

fn square(x: f64) -> f64 {
    x * x
}

impl Path {
    fn is_light_far(&self) -> bool {
        self.aim.distance.is_infinite()
    }

    /// Density with which the light's own point (or direction, or place in a list) is aimed at from
    /// the first surface.
    fn pdf_aim(&self) -> f64 {
        let pdf_w = f64::from(self.aim.pdf_w);
        if self.is_light_far() || self.aim.is_delta {
            pdf_w
        } else {
            pdf_w * f64::from(self.aim.cos_at_endpoint) / square(self.distances[0])
        }
    }

    /// Density with which it is started from.
    fn pdf_start(&self) -> f64 {
        let (pdf_a, pdf_w) = (self.aim.start.pdf_a, self.aim.start.pdf_w);
        match self.aim.spread {
            Spread::Parallel { pdf_a: across } => f64::from(pdf_a / across) * f64::from(pdf_w),
            Spread::Point { .. } => f64::from(pdf_a),
        }
    }

    /// Densities of all techniques: without a merge by s, then merges by vertex; zero where one
    /// cannot make the path.
    fn densities(&self, eta: f64, light_paths: f64) -> (Vec<f64>, Vec<f64>) {
        let m = self.surfaces.len();
        let v = |i: usize| &self.surfaces[i - 1];
        let across = |spread: Spread, d: f64| f64::from(spread.pdf_a_across(d as f32));
        // Light subpaths of s vertices: for s = 1 the light is aimed at, for s ≥ 2 it is started
        // from.
        let mut light = vec![1.0; m + 3];
        light[1] = self.pdf_aim();
        light[2] = self.pdf_start() * across(self.aim.spread, self.distances[0]) * v(1).light_cos;
        for i in 1..m {
            light[i + 2] =
                light[i + 1] * v(i).light_pdf * v(i + 1).light_cos / square(self.distances[i]);
        }
        light[m + 2] =
            light[m + 1] * v(m).light_pdf * f64::from(self.camera.cos) / square(self.distances[m]);
        // Camera subpaths of t vertices.
        let mut camera = vec![1.0; m + 3];
        camera[1] = f64::from(self.camera.densities.pdf_a);
        camera[2] = camera[1] * across(self.camera.spread, self.distances[m]) * v(m).camera_cos;
        for t in 3..=m + 1 {
            let i = m + 2 - t;
            camera[t] =
                camera[t - 1] * v(i + 1).camera_pdf * v(i).camera_cos / square(self.distances[i]);
        }
        // Whoever runs into the light meets as much of it as there is.
        camera[m + 2] = camera[m + 1] * v(1).camera_pdf * f64::from(self.aim.opacity);
        if !self.is_light_far() {
            camera[m + 2] *= f64::from(self.aim.cos_at_endpoint) / square(self.distances[0]);
        }
        let can_join = |i: usize| i == 0 || i == m + 1 || !v(i).is_delta;
        let joined = (0..=m + 2)
            .map(|s| {
                let is_possible = match s {
                    0 => !self.aim.is_delta,
                    s if s == m + 2 => !self.camera.is_delta,
                    s => can_join(s - 1) && can_join(s),
                };
                let n = if s > m { light_paths } else { 1.0 };
                f64::from(u8::from(is_possible)) * light[s] * camera[m + 2 - s] * n
            })
            .collect();
        let merged = (1..=m)
            .map(|i| f64::from(u8::from(!v(i).is_delta)) * light[i + 1] * camera[m + 2 - i] * eta)
            .collect();
        (joined, merged)
    }

    /// The same techniques' weights by the running quantities.
    fn running(&self, weighing: &MisWeights) -> (Vec<f32>, Vec<f32>) {
        let m = self.surfaces.len();
        let v = |i: usize| &self.surfaces[i - 1];
        let d2 = |i: usize| square(self.distances[i]) as f32;
        let start = Start {
            position: glam::Vec3::ZERO,
            triangle: neumann_core::math::ray::NO_TRIANGLE,
            ng: self.aim.wi,
            direction: -self.aim.wi,
            value: self.aim.value,
            cos: self.aim.cos_at_endpoint,
            densities: self.aim.start,
            light: 0,
            spread: self.aim.spread,
            on_triangle: None,
            opacity: self.aim.opacity,
            is_delta_position: self.aim.is_delta,
            is_delta_direction: false,
        };
        // Quantities at each surface, walked from the light,
        let mut at_light = vec![Partial::default()];
        let mut partial = weighing.of_light(&start);
        for i in 1..=m {
            let is_far = i == 1 && matches!(self.aim.spread, Spread::Parallel { .. });
            let d2 = if is_far { 1.0 } else { d2(i - 1) };
            partial = weighing.arrive(partial, d2, v(i).light_cos as f32);
            if i == 1 {
                let aim_over_start = self.pdf_aim() / self.pdf_start();
                partial = weighing.choose(partial, aim_over_start as f32);
            }
            at_light.push(partial);
            let (forward, reverse) = (v(i).light_pdf as f32, v(i).camera_pdf as f32);
            let cos = v(i).camera_cos as f32;
            partial = weighing.scatter(partial, cos, forward, reverse, v(i).is_delta);
        }
        let leaving_for_lens = partial;
        // and walked from the camera.
        let mut at_camera = vec![Partial::default(); m + 1];
        let mut partial = weighing.of_camera(&self.camera);
        for i in (1..=m).rev() {
            let is_far = i == m && matches!(self.camera.spread, Spread::Parallel { .. });
            let d2 = if is_far { 1.0 } else { d2(i) };
            partial = weighing.arrive(partial, d2, v(i).camera_cos as f32);
            at_camera[i] = partial;
            let (forward, reverse) = (v(i).camera_pdf as f32, v(i).light_pdf as f32);
            let cos = v(i).light_cos as f32;
            partial = weighing.scatter(partial, cos, forward, reverse, v(i).is_delta);
        }
        let leaving_for_light = partial;
        let joined = (0..=m + 2)
            .map(|s| match s {
                0 if self.aim.is_delta => 0.0,
                0 if self.is_light_far() => {
                    weighing.hit(leaving_for_light, self.aim.pdf_w, self.aim.start)
                }
                0 => {
                    let cos = self.aim.cos_at_endpoint;
                    let at = weighing.arrive(leaving_for_light, d2(0), cos);
                    let mut start = self.aim.start;
                    start.pdf_a /= self.aim.opacity;
                    weighing.hit(at, self.pdf_aim() as f32 / self.aim.opacity, start)
                }
                s if s == m + 2 => {
                    if self.camera.is_delta {
                        return 0.0;
                    }
                    let at = weighing.arrive(leaving_for_lens, d2(m), self.camera.cos);
                    let lens = LensHit {
                        raster: Vec2::ZERO,
                        importance: 1.0,
                        distance: self.distances[m] as f32,
                        cos: self.camera.cos,
                        start: self.camera.densities,
                    };
                    weighing.lens(at, &lens)
                }
                1 if v(1).is_delta => 0.0,
                1 => weighing.next_event(at_camera[1], &self.aim, &end(v(1), true)),
                s if s == m + 1 && v(m).is_delta => 0.0,
                s if s == m + 1 => weighing.splat(at_light[m], &self.lens_aim, &end(v(m), false)),
                s if v(s - 1).is_delta || v(s).is_delta => 0.0,
                s => {
                    let joint = JointDensities {
                        camera_forward: v(s).camera_pdf as f32,
                        camera_reverse: v(s).light_pdf as f32,
                        light_forward: v(s - 1).light_pdf as f32,
                        light_reverse: v(s - 1).camera_pdf as f32,
                        camera_cos: v(s).light_cos as f32,
                        light_cos: v(s - 1).camera_cos as f32,
                        distance_squared: d2(s - 1),
                    };
                    weighing.connect(at_camera[s], at_light[s - 1], &joint)
                }
            })
            .collect();
        let merged = (1..=m)
            .map(|i| {
                if v(i).is_delta {
                    return 0.0;
                }
                let (forward, reverse) = (v(i).camera_pdf as f32, v(i).light_pdf as f32);
                weighing.merge(at_camera[i], at_light[i], forward, reverse)
            })
            .collect();
        (joined, merged)
    }
}

/// Densities at a vertex that aims at the light, or at the lens.
fn end(vertex: &Between, at_light: bool) -> EndDensities {
    let (camera, light) = (vertex.camera_pdf as f32, vertex.light_pdf as f32);
    if at_light {
        EndDensities {
            forward: camera,
            reverse: light,
            cos: vertex.light_cos as f32,
        }
    } else {
        EndDensities {
            forward: light,
            reverse: camera,
            cos: vertex.camera_cos as f32,
        }
    }
}

fn cameras(scene: &Scene) -> Vec<Camera> {
    let pinhole = scene.cameras()[0].clone();
    let lens = Some(Lens {
        aperture: 0.2,
        focus_distance: 1.5,
    });
    let orthographic = CameraDescription {
        projection: Projection::Orthographic { ymag: 0.8 },
        ..pinhole.clone()
    };
    [
        pinhole.clone(),
        CameraDescription { lens, ..pinhole },
        orthographic,
    ]
    .map(|description| Camera::new(&description, 64, 64))
    .into()
}

/// Holds running weights against written-out ones over many paths; yields how many paths there
/// were, and how many of them had a mirror-like vertex.
fn check(
    scene: &Scene,
    name: &str,
    heuristic: Heuristic,
    eta_and_radius: Option<(usize, f32)>,
    light_paths: f32,
) -> (usize, usize) {
    let mut random = Random::new(77);
    let (mut n_paths, mut n_specular) = (0, 0);
    let mut weighing = MisWeights::connections(heuristic, light_paths);
    let mut eta = 0.0;
    if let Some((n, radius)) = eta_and_radius {
        weighing = weighing.merges(n, radius, true);
        eta = std::f64::consts::PI * f64::from(radius) * f64::from(radius) * n as f64;
    }
    for (c, camera) in cameras(scene).iter().enumerate() {
        for n in 1..=6 {
            for _ in 0..60 {
                let Some(path) = path(scene, camera, 64.0, n, &mut random) else {
                    continue;
                };
                n_paths += 1;
                n_specular += usize::from(path.surfaces.iter().any(|s| s.is_delta));
                let (joined, merged) = path.densities(eta, f64::from(light_paths));
                let counts = |p: f64| match heuristic {
                    Heuristic::Balance => p,
                    Heuristic::Power => p * p,
                    Heuristic::Average => f64::from(u8::from(p > 0.0)),
                    Heuristic::Never => 0.0,
                };
                let all = || joined.iter().chain(&merged);
                let sum: f64 = all().map(|p| counts(*p)).sum();
                if !sum.is_normal() {
                    continue;
                }
                let (running_joined, running_merged) = path.running(&weighing);
                // Without merges their weights mean nothing.
                let running = running_joined.iter().chain(&running_merged);
                let mut total = 0.0;
                for (i, (p, w)) in all().zip(running).enumerate() {
                    if i >= joined.len() && eta == 0.0 {
                        continue;
                    }
                    let exact = counts(*p) / sum;
                    total += f64::from(*w);
                    assert!(
                        (f64::from(*w) - exact).abs() < 1e-4,
                        "{name}, camera {c}, {n} surfaces, technique {i}: {w}, written out \
                         {exact}; {joined:?} {merged:?}"
                    );
                }
                assert!((total - 1.0).abs() < 1e-4, "{name}: weights add to {total}");
            }
        }
    }
    (n_paths, n_specular)
}

#[test]
fn running_weights_are_the_written_out_ones() {
    let mut n_specular = 0;
    let mut scenes = studios();
    for name in ["cornell-glass", "sky", "caustic", "many"] {
        scenes.push((name, builtin(name)));
    }
    for (name, scene) in &scenes {
        for heuristic in [Heuristic::Balance, Heuristic::Power, Heuristic::Average] {
            for merges in [None, Some((4096, 0.02)), Some((1_000_000, 0.1))] {
                let (n_paths, n) = check(scene, name, heuristic, merges, 1.0);
                assert!(n_paths > 100, "{name}: only {n_paths} paths");
                n_specular += n;
            }
        }
        // Fewer light paths than pixels.
        check(scene, name, Heuristic::Balance, Some((4096, 0.02)), 0.3);
    }
    assert!(
        n_specular > 1000,
        "only {n_specular} paths with a mirror-like vertex"
    );
}

/// A light's walk begins with the probability of its light to be aimed at from where it lands, over
/// that of being started from: the two are chosen differently.
#[test]
fn walks_from_lights_know_both_choices() {
    let mut random = Random::new(78);
    let weighing = MisWeights::connections(Heuristic::Power, 1.0);
    let (mut n_walks, mut n_different) = (0, 0);
    let mut scenes = studios();
    scenes.push(("many", builtin("many")));
    for (name, scene) in &scenes {
        let lights = scene.lights();
        for _ in 0..200 {
            let Some(start) = lights.start(&light_sample(&mut random)) else {
                continue;
            };
            let mut tracer = Tracer::new(scene);
            let mut walk = Walk::from_light(&start, &mut tracer, &weighing);
            let Some(vertex) = walk.meet(&mut tracer, &weighing) else {
                continue;
            };
            let surface = &vertex.surface;
            // Where it is aimed at from there, with densities in the same measure.
            let aimed = lights.pmf_aim(&surface.receiver(), LightChoice::Tree, start.light);
            let ratio = f64::from(aimed) / f64::from(lights.pmf_start(start.light));
            let cos = f64::from(surface.cos_g(surface.wo));
            let across = f64::from(start.spread.pdf_a_across(surface.distance));
            let expected = square(ratio / (across * cos));
            let found = f64::from(vertex.partial.d_vcm);
            assert!(
                (found / expected - 1.0).abs() < 1e-3,
                "{name}: {found}, expected {expected}"
            );
            n_walks += 1;
            n_different += usize::from((ratio - 1.0).abs() > 0.1);
        }
    }
    assert!(n_walks > 1000 && n_different > n_walks / 10);
}
