//! Is *each bounce* right?
//!
//! Scenes whose terms `T^k L_e` are known in closed form, for every row of `METHODS`: the white
//! furnace (inside a closed surface of emission E and albedo a, term k is `a^k E` exactly), form
//! factors, lights over a plane, a sky over a convex body, radiance through an interface.

use std::sync::Arc;

use glam::Vec3;
use neumann_core::integrator::{METHODS, Method};
use neumann_core::radiometry::Rgb;
use neumann_core::scene::Scene;
use neumann_core::scene::description::{
    EnvironmentDescription, LightKind, MaterialDescription, VolumeDescription,
};
use neumann_tests::renders::{Setup, is_black};
use neumann_tests::scenes::{
    Stage, above_square, ball, builtin, emitter, lambert, looking, rectangle, smooth_octahedron,
};
use neumann_tests::statistics::{Estimate, Family};

/// What a method may be off beside its standard error: rounding of single precision.
const ROUNDING: f64 = 2e-5;

/// Batches of renders and iterations in each.
const N_BATCHES: u32 = 16;
const N_ITERATIONS: u32 = 8;

/// True if a method computes bounce k where everything is diffuse.
fn sees(method: &Method, bounce: usize) -> bool {
    method
        .sight
        .diffuse_bounces
        .is_none_or(|n| bounce <= n as usize)
}

#[test]
fn furnace() {
    let scene = builtin("furnace");
    for &method in METHODS {
        let setup = Setup::new(&scene, 64, 64)
            .by(method)
            .with_many_photons()
            .up_to(9);
        let batches = setup.batches(N_BATCHES, N_ITERATIONS, 30);
        assert_eq!(batches.n_refused(), 0, "{}", method.id);
        let n_layers = setup.settings.n_layers;
        for k in 0..=n_layers {
            if !sees(method, k) {
                let is_dark = batches.films.iter().all(|film| is_black(&film.layers()[k]));
                assert!(is_dark, "{}: layer {k} is beyond its sight", method.id);
                continue;
            }
            // The tail holds bounces 8 and 9.
            let exact = if k < n_layers {
                0.5f64.powi(k as i32)
            } else {
                0.5f64.powi(8) + 0.5f64.powi(9)
            };
            for e in batches.layer(k) {
                let apart = (e.mean - exact).abs();
                assert!(
                    apart < 5.0 * e.standard_error + ROUNDING * exact,
                    "{}, layer {k}: {e:?}, exact {exact}",
                    method.id
                );
                // Where the render is sharp enough to tell, 0.2 % is the limit.
                if 4.0 * e.standard_error < 0.002 * exact {
                    assert!(
                        apart < 0.002 * exact,
                        "{}, layer {k}: off by {:.3} %",
                        method.id,
                        100.0 * apart / exact
                    );
                }
            }
        }
        // At most k = 3 is so noisy for any method that the limit would not be asked for.
        let error = batches.layer(usize::from(sees(method, 2)) * 2)[0].standard_error;
        assert!(error < 1e-3, "{}: the test has lost its edge", method.id);
    }
}

#[test]
fn layers_add_up() {
    for name in ["cornell-glass", "sky", "plates"] {
        let scene = builtin(name);
        for &method in METHODS {
            let film = Setup::new(&scene, 24, 16).by(method).film(0, 6);
            for (pixel, total) in film.total().into_iter().enumerate() {
                let sum = (0..=film.n_layers())
                    .map(|layer| film.layer_at(layer, pixel))
                    .fold(Rgb::BLACK, |sum, value| sum + value);
                let apart = (sum - total).map(f32::abs).max_channel();
                assert!(
                    apart <= 3e-6 * total.max_channel(),
                    "{name}, {}: layers add to {sum:?}, L is {total:?}",
                    method.id
                );
            }
        }
    }
}

/// Means of one layer over the film by every method that can see it, against a known value.
fn test_layer(
    scene: &Arc<Scene>,
    camera: &neumann_core::scene::description::CameraDescription,
    layer: usize,
    exact: f64,
    can_see: impl Fn(&Method) -> bool,
) {
    let mut family = Family::default();
    for &method in METHODS.iter().filter(|m| can_see(m)) {
        let setup = Setup::seen_by(scene, camera.clone(), 32, 32)
            .by(method)
            .with_many_photons()
            .up_to(layer as u32 + 1);
        let estimate = |n| -> Estimate { setup.batches(N_BATCHES, n, 31).layer(layer)[1] };
        let mut e = estimate(N_ITERATIONS);
        if e.standard_error >= 0.02 * exact {
            // Light paths that have to find a small film need more of them.
            e = estimate(16 * N_ITERATIONS);
        }
        family.add(
            e.p_value(exact, ROUNDING),
            format!("{}, layer {layer}: {e:?}, exact {exact}", method.id),
        );
        assert!(
            e.standard_error < 0.05 * exact,
            "{}: {e:?} is too noisy to tell",
            method.id
        );
    }
    assert!(family.len() >= 2, "no two methods see this scene");
    family.judge();
}

/// Form factor between two directly opposed squares of edge `a` at distance `c`
/// (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-11).
fn form_factor(a: f64, c: f64) -> f64 {
    let x = a / c;
    let r = (1.0 + x * x).sqrt();
    2.0 / (std::f64::consts::PI * x * x)
        * (((1.0 + x * x).powi(2) / (1.0 + 2.0 * x * x)).sqrt().ln() + 2.0 * x * r * (x / r).atan()
            - 2.0 * x * x.atan())
}

#[test]
fn form_factor_of_opposed_squares() {
    let mut stage = Stage::default();
    let (half, distance) = (0.5, 0.8);
    let (x, z) = (Vec3::X * half, Vec3::Z * half);
    stage.add("floor", rectangle(Vec3::ZERO, z, x), lambert(0.6));
    stage.add("lamp", rectangle(Vec3::Y * distance, x, z), emitter(3.0));
    let exact = 0.6 * 3.0 * form_factor(1.0, f64::from(distance));
    let camera = above_square(half, 0.4);
    test_layer(&stage.scene(), &camera, 1, exact, |_| true);
}

#[test]
fn point_light_over_a_plane() {
    let mut stage = Stage::default();
    let intensity = Rgb::splat(5.0);
    let height = 0.7f32;
    stage.add(
        "floor",
        rectangle(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0),
        lambert(0.5),
    );
    stage.light(
        LightKind::Point { intensity },
        Vec3::Y * height,
        Vec3::NEG_Y,
    );
    // Irradiance `I cos / d²` is intensity times solid angle, so the mean over the square seen
    // is that of the square: `4 atan(a² / (h sqrt(2 a² + h²)))` for half its edge a.
    let (a, h) = (0.5f64, f64::from(height));
    let solid_angle = 4.0 * (a * a / (h * (2.0 * a * a + h * h).sqrt())).atan();
    let exact = 0.5 / std::f64::consts::PI * 5.0 * solid_angle / (4.0 * a * a);
    let camera = above_square(0.5, 0.3);
    test_layer(&stage.scene(), &camera, 1, exact, |m| {
        m.sight.punctual_lights
    });
}

#[test]
fn spot_light_over_a_plane() {
    // All of the plane that is seen is within the inner cone.
    let mut stage = Stage::default();
    let kind = LightKind::Spot {
        intensity: Rgb::splat(5.0),
        inner_cone: 0.9,
        outer_cone: 1.2,
    };
    stage.add(
        "floor",
        rectangle(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0),
        lambert(0.5),
    );
    stage.light(kind, Vec3::Y * 0.7, Vec3::NEG_Y);
    let (a, h) = (0.5f64, f64::from(0.7f32));
    let solid_angle = 4.0 * (a * a / (h * (2.0 * a * a + h * h).sqrt())).atan();
    let exact = 0.5 / std::f64::consts::PI * 5.0 * solid_angle / (4.0 * a * a);
    let camera = above_square(0.5, 0.3);
    // The corner of the square is seen under atan(0.707 / 0.7) = 0.79.
    test_layer(&stage.scene(), &camera, 1, exact, |m| {
        m.sight.punctual_lights
    });
}

#[test]
fn directional_light_on_a_plane() {
    let mut stage = Stage::default();
    let irradiance = Rgb::splat(2.0);
    let direction = Vec3::new(0.6, -0.8, 0.0);
    stage.add(
        "floor",
        rectangle(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0),
        lambert(0.5),
    );
    stage.light(LightKind::Directional { irradiance }, Vec3::Y, direction);
    let exact = 0.5 / std::f64::consts::PI * 2.0 * 0.8;
    let camera = above_square(0.5, 0.3);
    test_layer(&stage.scene(), &camera, 1, exact, |m| {
        m.sight.punctual_lights
    });
}

#[test]
fn uniform_sky_over_a_convex_body() {
    let mut stage = Stage::default();
    stage.add("ball", ball(1.0), lambert(0.7));
    stage.description.environment = Some(EnvironmentDescription::uniform(Rgb::splat(1.5)));
    let scene = stage.scene();
    // So close that the ball fills the picture.
    let camera = looking(Vec3::new(0.1, 0.2, 1.05), Vec3::ZERO);
    test_layer(&scene, &camera, 1, 0.7 * 1.5, |_| true);
    for &method in METHODS {
        let film = Setup::seen_by(&scene, camera.clone(), 16, 16)
            .by(method)
            .film(0, 2);
        assert!(is_black(&film.layers()[0]), "{}: no sky is seen", method.id);
        assert!(
            is_black(&film.layers()[2]),
            "{}: a convex body does not see itself",
            method.id
        );
    }
}

/// The same over facets whose shading normals lean up to 55° away: a surface gives back all of its
/// albedo whatever its normals, also where they face away from the camera.
#[test]
fn uniform_sky_over_a_coarse_body() {
    let mut stage = Stage::default();
    stage.add("body", smooth_octahedron(Vec3::ZERO, 1.0), lambert(0.7));
    stage.description.environment = Some(EnvironmentDescription::uniform(Rgb::splat(1.5)));
    let scene = stage.scene();
    // So close that one face fills the picture, and is seen from low angles at its edges.
    let camera = looking(Vec3::new(0.43, 0.38, 0.34), Vec3::ZERO);
    test_layer(&scene, &camera, 1, 0.7 * 1.5, |_| true);
}

/// Radiance shrinks by the square of the index on its way out of glass: a lamp inside of a
/// solid, seen straight through its smooth surface, shows `(1 - F) L / n²`.
#[test]
fn radiance_through_an_interface() {
    let mut stage = Stage::default();
    let (x, z) = (Vec3::X * 20.0, Vec3::Z * 20.0);
    let glass = MaterialDescription {
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        volume: Some(VolumeDescription {
            attenuation_color: Rgb::splat(0.5),
            attenuation_distance: 0.25,
        }),
        ..MaterialDescription::default()
    };
    stage.add("surface", rectangle(Vec3::ZERO, z, x), glass);
    stage.add("lamp", rectangle(Vec3::Y * -0.5, z, x), emitter(2.0));
    // The lamp is half a metre down, twice the distance over which half is absorbed.
    let exact = (1.0 - 0.04) * 2.0 * 0.25 / 2.25;
    let camera = above_square(0.1, 0.5);
    test_layer(&stage.scene(), &camera, 1, exact, |m| {
        m.sight.delta_surfaces && m.sight.delta_to_camera
    });
}

/// A lamp of one side is black from behind and lights nothing there.
#[test]
fn lamps_emit_from_their_front() {
    for is_double_sided in [false, true] {
        let mut stage = Stage::default();
        let (x, z) = (Vec3::X, Vec3::Z);
        stage.add("floor", rectangle(Vec3::ZERO, z, x), lambert(0.5));
        let material = MaterialDescription {
            is_double_sided,
            ..emitter(1.0)
        };
        // Its front is up, away from the floor.
        let lamp = rectangle(Vec3::new(0.7, 0.5, 0.0), z, x * 0.3);
        stage.add("lamp", lamp, material);
        let scene = stage.scene();
        for &method in METHODS {
            let film = |eye: Vec3, target: Vec3| {
                Setup::seen_by(&scene, looking(eye, target), 32, 32)
                    .by(method)
                    .film(0, 8)
            };
            let above = film(Vec3::new(0.7, 0.9, 0.0), Vec3::X * 0.7);
            assert!(!is_black(&above.layers()[0]), "{}: the front", method.id);
            let below = film(Vec3::new(0.0, 0.4, 0.0), Vec3::new(0.7, 0.45, 0.0));
            let [seen, lit] = [0, 1].map(|k| !is_black(&below.layers()[k]));
            assert_eq!(seen, is_double_sided, "{}: the back is seen", method.id);
            assert_eq!(lit, is_double_sided, "{}: the back lights", method.id);
        }
    }
}

/// A cut leaves out what is beyond it, and nothing else.
#[test]
fn depth_cut() {
    let scene = builtin("cornell");
    for &method in METHODS {
        let setup = Setup::new(&scene, 16, 16).by(method);
        let deep = setup.clone().up_to(12).film(0, 3);
        for max_bounces in [0u32, 1, 3] {
            let cut = setup.clone().up_to(max_bounces).film(0, 3);
            for (k, layer) in cut.layers().iter().enumerate() {
                if k > max_bounces as usize {
                    assert!(is_black(layer), "{}: bounce {k} was cut", method.id);
                } else {
                    assert_eq!(layer, &deep.layers()[k], "{}: bounce {k}", method.id);
                }
            }
        }
    }
}
