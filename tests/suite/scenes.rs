//! Does every scene load, render and survive odd values?

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Mat4, Quat, Vec3, Vec4};
use neumann_core::integrator::METHODS;
use neumann_core::math::Ray;
use neumann_core::radiometry::Rgb;
use neumann_core::scene::Scene;
use neumann_core::scene::builtin::BUILTINS;
use neumann_core::scene::description::{
    EnvironmentDescription, InstanceDescription, LightKind, MeshDescription, SceneDescription,
};
use neumann_core::transport::{SurfaceVertex, Tracer};
use neumann_tests::random::Random;
use neumann_tests::renders::{Setup, is_black};
use neumann_tests::scenes::{
    Stage, ball, builtin, builtin_description, emitter, lambert, looking, rectangle, room, scaled,
};
use neumann_tests::statistics::Family;

#[test]
fn built_in_scenes_render_by_every_method() {
    for entry in BUILTINS {
        let scene = builtin(entry.name);
        assert!(
            scene.warnings().is_empty(),
            "{}: {:?}",
            entry.name,
            scene.warnings()
        );
        assert!(
            scene.about().is_some(),
            "{}: no line on what it shows",
            entry.name
        );
        assert!(
            scene.report().extensions_ignored.is_empty(),
            "{}",
            entry.name
        );
        assert!(!scene.cameras().is_empty() && !scene.lights().as_slice().is_empty());
        for &method in METHODS {
            let film = Setup::new(&scene, 24, 16).by(method).film(0, 8);
            let what = format!("{}, {}", entry.name, method.id);
            assert_eq!(film.n_refused(), 0, "{what}");
            assert!(film.total().iter().all(|c| c.is_radiance()), "{what}");
            // Methods that do not aim at lights may miss small ones.
            let aims = method.sight.punctual_lights && method.sight.delta_surfaces;
            assert!(!aims || !is_black(&film.total()), "{what}: black");
        }
    }
}

/// Where a shading normal leans over to the back of its facet, the surface turns black.
#[test]
fn normals_of_built_in_scenes_lean_with_their_facets() {
    for entry in BUILTINS {
        let scene = builtin(entry.name);
        for mesh in scene.geometry().meshes() {
            let Some(normals) = &mesh.arrays.normals else {
                continue;
            };
            for triangle in &mesh.arrays.triangles {
                let vertices = triangle.map(|v| v as usize);
                let [a, b, c] = mesh.corners(vertices);
                let ng = (b - a).cross(c - a).normalize();
                for v in vertices {
                    let cos = ng.dot(normals[v]);
                    assert!(
                        cos > 0.5,
                        "{}, '{}': a normal leans by {:.0}° from its facet near {}",
                        entry.name,
                        mesh.name,
                        cos.acos().to_degrees(),
                        mesh.arrays.positions[v]
                    );
                }
            }
        }
    }
}

/// A lit ball in a diffuse room: what must survive whatever else is in the file.
fn ball_in_room() -> Stage {
    let mut stage = Stage::default();
    stage.add("room", room(), lambert(0.5));
    stage.add("ball", ball(0.4), lambert(0.8));
    let lamp = rectangle(Vec3::Y * 0.99, Vec3::X * 0.5, Vec3::Z * 0.5);
    stage.add("lamp", lamp, emitter(5.0));
    stage.description.cameras = vec![looking(Vec3::new(0.0, 0.0, 0.95), Vec3::ZERO)];
    stage
}

/// The scene renders by every method, nothing is refused, and the rest of it looks as before.
fn assert_renders(description: &SceneDescription, warnings: &[&str]) {
    let scene = Arc::new(Scene::build(description));
    for expected in warnings {
        let is_there = scene.warnings().iter().any(|w| w.contains(expected));
        assert!(
            is_there,
            "no warning names {expected}: {:?}",
            scene.warnings()
        );
    }
    if warnings.is_empty() {
        assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
    }
    let expected = Setup::new(&ball_in_room().scene(), 16, 16).film(0, 4);
    for &method in METHODS {
        let film = Setup::new(&scene, 16, 16).by(method).film(0, 4);
        assert_eq!(film.n_refused(), 0, "{}", method.id);
        if method.id == "pt-mis" {
            assert_eq!(
                film.total(),
                expected.total(),
                "the rest of the scene has changed"
            );
        }
    }
}

#[test]
fn odd_meshes_are_left_out_and_named() {
    let nan = f32::NAN;
    let square = || rectangle(Vec3::new(0.0, -0.8, 0.0), Vec3::X * 0.1, Vec3::Z * 0.1);
    let moved = |positions: Vec<Vec3>| MeshDescription {
        positions,
        ..square()
    };
    let odd: Vec<(&str, MeshDescription)> = vec![
        ("not a number", moved(vec![Vec3::splat(nan); 4])),
        (
            "infinite",
            moved(vec![Vec3::X * f32::INFINITY, Vec3::ZERO, Vec3::X, Vec3::Y]),
        ),
        (
            "too large",
            moved(vec![Vec3::X * 1e30, Vec3::Y * 1e30, Vec3::X, Vec3::Y]),
        ),
        ("one point", moved(vec![Vec3::ONE * 0.2; 4])),
        (
            "one line",
            moved((0..4).map(|i| Vec3::X * i as f32 * 0.1).collect()),
        ),
        (
            "out of range",
            MeshDescription {
                triangles: vec![[0, 1, 99]],
                ..square()
            },
        ),
    ];
    for (name, mesh) in odd {
        let mut stage = ball_in_room();
        stage.add(name, mesh, lambert(0.5));
        assert_renders(&stage.description, &[name]);
    }
    // Half of a mesh may be sound.
    let mut stage = ball_in_room();
    let mut mesh = square();
    mesh.positions[3] = Vec3::splat(nan);
    stage.add("half", mesh, lambert(0.5));
    let scene = stage.scene();
    assert!(scene.warnings().iter().any(|w| w.contains("half")));
    assert_eq!(
        scene.statistics().n_triangles,
        ball_in_room().scene().statistics().n_triangles + 1
    );
}

#[test]
fn odd_transforms_are_left_out_and_named() {
    let transforms = [
        ("flattened to a point", Mat4::from_scale(Vec3::ZERO)),
        ("not finite", Mat4::from_translation(Vec3::splat(f32::NAN))),
        ("far away", Mat4::from_translation(Vec3::splat(1e20))),
    ];
    for (name, world_from_mesh) in transforms {
        let mut stage = ball_in_room();
        stage.add(name, ball(0.2), lambert(0.5));
        if let Some(instance) = stage.description.instances.last_mut() {
            instance.world_from_mesh = world_from_mesh;
        }
        assert_renders(&stage.description, &[name]);
    }
    // Nothing is lost by mirroring: front stays front.
    let mut stage = ball_in_room();
    for instance in &mut stage.description.instances {
        instance.world_from_mesh = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    }
    let batches = |scene: &Arc<Scene>| Setup::new(scene, 16, 16).up_to(4).batches(16, 8, 60);
    let (mirrored, plain) = (batches(&stage.scene()), batches(&ball_in_room().scene()));
    let mut family = Family::default();
    for k in 0..5 {
        let (a, b) = (mirrored.layer(k)[1], plain.layer(k)[1]);
        family.add(a.p_value_against(&b, 1e-5), format!("T{k}: {a:?}, {b:?}"));
    }
    family.judge();
}

#[test]
fn odd_attributes_fall_back() {
    let shapes: Vec<(&str, Vec<Vec3>)> = vec![
        ("no direction", vec![Vec3::ZERO; 4]),
        ("not numbers", vec![Vec3::splat(f32::NAN); 4]),
        ("backwards", vec![Vec3::NEG_Y; 4]),
        ("across", vec![Vec3::X; 4]),
        ("too few", vec![Vec3::Y; 2]),
    ];
    for (name, normals) in shapes {
        let mut stage = ball_in_room();
        let mut mesh = rectangle(Vec3::Y * -0.9, Vec3::Z * 0.3, Vec3::X * 0.3);
        mesh.normals = Some(normals);
        stage.add(name, mesh, lambert(0.5));
        let scene = stage.scene();
        for &method in METHODS {
            let film = Setup::new(&scene, 16, 16).by(method).film(0, 4);
            assert_eq!(film.n_refused(), 0, "{name}, {}", method.id);
        }
    }
}

#[test]
fn odd_lights_and_cameras_render() {
    let mut stage = ball_in_room();
    let black = Rgb::BLACK;
    stage.light(
        LightKind::Point { intensity: black },
        Vec3::ZERO,
        Vec3::NEG_Y,
    );
    let far = Vec3::splat(f32::NAN);
    let intensity = Rgb::WHITE;
    stage.light(LightKind::Point { intensity }, far, Vec3::NEG_Y);
    let intensity = Rgb::new(f32::NAN, 1.0, 1.0);
    stage.light(LightKind::Point { intensity }, Vec3::ZERO, Vec3::NEG_Y);
    assert_renders(&stage.description, &[]);
    // Light within a surface, and a camera that cannot stand anywhere.
    let mut stage = ball_in_room();
    let intensity = Rgb::WHITE;
    stage.light(LightKind::Point { intensity }, Vec3::NEG_Y, Vec3::NEG_Y);
    stage.description.cameras[0].world_from_camera = Mat4::NAN;
    let scene = stage.scene();
    for &method in METHODS {
        let film = Setup::new(&scene, 16, 16).by(method).film(0, 4);
        assert_eq!(film.n_refused(), 0, "{}", method.id);
    }
}

#[test]
fn a_scene_without_light_gets_the_studio() {
    let mut stage = Stage::default();
    stage.add("ball", ball(0.5), lambert(0.5));
    let scene = stage.scene();
    assert!(scene.warnings().iter().any(|w| w.contains("no light")));
    let film = Setup::new(&scene, 16, 16).film(0, 4);
    let total = film.total();
    let (corner, ball) = (total[0].g, total[16 * 8 + 8].g);
    assert!((0.1..0.3).contains(&corner), "the ground: {corner}");
    assert!(ball > 0.2, "the ball is lit: {ball}");
    // Nothing at all is a picture, too.
    let mut nothing = Stage::default();
    nothing.description.environment = Some(EnvironmentDescription::uniform(Rgb::WHITE));
    let scene = nothing.scene();
    for &method in METHODS {
        // What splats sees the sky where its samples fall.
        if !method.sight.delta_to_camera {
            continue;
        }
        let film = Setup::new(&scene, 8, 8).by(method).film(0, 2);
        assert!(
            film.total().iter().all(|c| (c.g - 1.0).abs() < 1e-6),
            "{}",
            method.id
        );
    }
}

/// The default method without its roulette, and with lights chosen alike everywhere, which is exact
/// inside of a sphere: noise would hide small losses.
fn steady(scene: &Arc<Scene>) -> Setup {
    let mut setup = Setup::new(scene, 48, 48).up_to(8);
    let parameters = setup.settings.method.parameters;
    let values = &mut setup.settings.values;
    values
        .set(parameters, "roulette", "off")
        .expect("a switch of the default method");
    values
        .set(parameters, "lights", "power")
        .expect("a choice of the default method");
    setup
}

/// Surfaces must not shadow themselves, nor leak, whatever the unit of the file.
#[test]
fn scale_does_not_matter() {
    for name in ["furnace", "cornell"] {
        let means = |scale: f32| {
            let description = scaled(builtin_description(name), scale);
            let scene = Arc::new(Scene::build(&description));
            steady(&scene).film(0, 32).layer_means()
        };
        let expected = means(1.0);
        for scale in [1e-3f32, 0.3, 1e2, 1e4] {
            for (k, (a, b)) in means(scale).iter().zip(&expected).enumerate() {
                let exact = if name == "furnace" && k < 8 {
                    0.5f64.powi(k as i32)
                } else {
                    b[1]
                };
                // The same random numbers give nearly the same paths at any scale.
                let limit = if name == "furnace" { 0.002 } else { 0.005 };
                assert!(
                    (a[1] - exact).abs() < limit * exact,
                    "{name} at scale {scale}: layer {k} is {:.5e}, not {exact:.5e}",
                    a[1]
                );
            }
        }
    }
}

/// Nor where the scene stands: far from the origin, numbers are coarser.
#[test]
fn place_hardly_matters() {
    let by =
        Mat4::from_translation(Vec3::new(300.0, -150.0, 700.0)) * Mat4::from_rotation_y(PI / 5.0);
    let mut description = builtin_description("furnace");
    for instance in &mut description.instances {
        instance.world_from_mesh = by * instance.world_from_mesh;
    }
    for camera in &mut description.cameras {
        camera.world_from_camera = by * camera.world_from_camera;
    }
    let scene = Arc::new(Scene::build(&description));
    let means = steady(&scene).film(0, 32).layer_means();
    for (k, mean) in means.iter().enumerate().take(8) {
        let exact = 0.5f64.powi(k as i32);
        assert!(
            // Starts of rays are rounded to the grid of coordinates there, 6e-5 m, and some are
            // outside
            // of the facet beside theirs: 0.03 % of the light is lost at every bounce.
            (mean[1] / exact - 1.0).abs() < 0.003,
            "layer {k}: {}",
            mean[1]
        );
    }
}

/// Meshes that are kept once for all their instances look as if each were there by itself: the same
/// ray meets the same point, with the same normals, colour and triangle, also where a transform
/// mirrors and stretches.
#[test]
fn instances_look_like_copies() {
    let shape = ball(0.4);
    let n_vertices = shape.positions.len();
    // As many of it as make a mesh worth keeping once.
    let n_parts = 30_000 / shape.triangles.len();
    let mut mesh = MeshDescription {
        name: "beads".to_owned(),
        material: Some(0),
        colors: Some(Vec::new()),
        normals: Some(Vec::new()),
        ..MeshDescription::default()
    };
    let mut random = Random::new(77);
    for part in 0..n_parts {
        let [x, y] = random.pair();
        let shift = Vec3::new(x, y, random.pair()[0]) * 4.0 - 2.0;
        let first = (part * n_vertices) as u32;
        let positions = shape.positions.iter();
        mesh.positions.extend(positions.map(|p| *p * 0.2 + shift));
        if let Some(normals) = &mut mesh.normals {
            normals.extend(shape.positions.iter().map(|p| p.normalize()));
        }
        if let Some(colors) = &mut mesh.colors {
            let color = Vec4::new(x, y, 0.5, 1.0);
            colors.extend(std::iter::repeat_n(color, n_vertices));
        }
        let triangles = shape.triangles.iter();
        mesh.triangles
            .extend(triangles.map(|t| t.map(|v| v + first)));
    }
    // A vertex that no triangle uses may be anywhere.
    mesh.positions.push(Vec3::NAN);
    if let (Some(normals), Some(colors)) = (&mut mesh.normals, &mut mesh.colors) {
        normals.push(Vec3::Y);
        colors.push(Vec4::ONE);
    }
    let mut shared = SceneDescription {
        materials: vec![lambert(0.8)],
        meshes: vec![mesh.clone()],
        ..SceneDescription::default()
    };
    let mut copied = SceneDescription {
        meshes: Vec::new(),
        ..shared.clone()
    };
    for i in 0..10 {
        let [x, y] = random.pair();
        let world_from_mesh = Mat4::from_scale_rotation_translation(
            Vec3::new(if i % 3 == 0 { -1.0 } else { 1.2 }, 0.7, 1.0),
            Quat::from_rotation_y(6.0 * x) * Quat::from_rotation_x(6.0 * y),
            Vec3::new(8.0 * x - 4.0, 8.0 * y - 4.0, i as f32),
        );
        let instance = |mesh| InstanceDescription {
            name: format!("number {i}"),
            mesh,
            world_from_mesh,
        };
        shared.instances.push(instance(0));
        copied.instances.push(instance(i));
        copied.meshes.push(mesh.clone());
    }
    let [shared, copied] = [shared, copied].map(|d| Scene::build(&d));
    assert_eq!(shared.statistics(), copied.statistics());
    let bytes = [&shared, &copied].map(|scene| scene.bvh().n_bytes());
    assert!(bytes[0] * 5 < bytes[1], "{bytes:?} bytes");
    let bounds = shared.bounds();
    assert!(bounds.0.is_finite() && bounds.1.is_finite(), "{bounds:?}");

    let [mut ours, mut theirs] = [&shared, &copied].map(Tracer::new);
    let (mut n_hits, mut n_other) = (0, 0);
    for _ in 0..20_000 {
        let ([a, b], [c, d]) = (random.pair(), random.pair());
        let origin = Vec3::new(20.0 * a - 10.0, 20.0 * b - 10.0, -12.0);
        let target = Vec3::new(8.0 * c - 4.0, 8.0 * d - 4.0, 5.0);
        let ray = Ray::new(origin, (target - origin).normalize());
        match (ours.vertex(&ray), theirs.vertex(&ray)) {
            (Some(x), Some(y)) if x.triangle == y.triangle => {
                n_hits += 1;
                assert!(x.point.position.abs_diff_eq(y.point.position, 1e-3));
                // At one point of the facet, since a grazing ray's is known less well.
                let [x, y] = [&ours, &theirs].map(|t| t.surface_at(x.triangle, [0.2, 0.5], x.wo));
                // The facets are millimetres wide, and their corners rounded to a micrometre, ten
                // metres away.
                let close = |a: Vec3, b: Vec3| a.abs_diff_eq(b, 1e-2);
                assert!(x.point.position.abs_diff_eq(y.point.position, 1e-5));
                assert!(
                    close(x.point.ng, y.point.ng),
                    "{} {}",
                    x.point.ng,
                    y.point.ng
                );
                assert!(close(x.frame.z, y.frame.z), "{} {}", x.frame.z, y.frame.z);
                let albedo = |v: &SurfaceVertex<'_>| v.bsdf.albedo(1.0).to_array();
                assert!(close(albedo(&x).into(), albedo(&y).into()));
            }
            (None, None) => {}
            // Rounding decides at edges.
            _ => n_other += 1,
        }
    }
    assert!(
        n_hits > 2000 && n_other * 200 < n_hits,
        "{n_hits}, {n_other}"
    );
}
