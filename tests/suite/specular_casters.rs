//! Are the paths that diffuse surfaces send to mirrors and glass drawn and weighed right, and do
//! they pay?

use std::sync::Arc;

use glam::Vec3;
use neumann_core::bsdf::TransportMode;
use neumann_core::integrator::{Value, method};
use neumann_core::math::Ray;
use neumann_core::radiometry::Rgb;
use neumann_core::render::{CancelToken, Renderer};
use neumann_core::scene::description::{
    EnvironmentDescription, MaterialDescription, MeshDescription,
};
use neumann_core::scene::{Scene, SpecularCaster};
use neumann_core::transport::Tracer;
use neumann_core::transport::specular_casters::Cones;
use neumann_tests::cells::SphereCells;
use neumann_tests::random::Random;
use neumann_tests::renders::{Block, Setup, pool};
use neumann_tests::scenes::{Stage, above_square, ball, emitter, lambert, looking, rectangle};
use neumann_tests::statistics::Family;

use super::adaptive::squared_error;
use super::sampling::test_directions_within;

fn mirror() -> MaterialDescription {
    MaterialDescription {
        base_color: Rgb::WHITE,
        metallic: 1.0,
        roughness: 0.0,
        ..MaterialDescription::default()
    }
}

fn glass() -> MaterialDescription {
    MaterialDescription {
        base_color: Rgb::WHITE,
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        ..MaterialDescription::default()
    }
}

fn plastic(roughness: f32) -> MaterialDescription {
    MaterialDescription {
        base_color: Rgb::splat(0.6),
        metallic: 0.0,
        roughness,
        ..MaterialDescription::default()
    }
}

fn ball_at(center: Vec3, radius: f32) -> MeshDescription {
    let mut mesh = ball(radius);
    for position in &mut mesh.positions {
        *position += center;
    }
    mesh
}

fn setup(scene: &Arc<Scene>, aims_at_specular_casters: bool) -> Setup {
    let method = method("pt-mis").expect("a method of the registry");
    let mut setup = Setup::new(scene, 48, 32).by(method).up_to(4);
    setup
        .settings
        .values
        .put("casters", Value::Switch(aims_at_specular_casters));
    setup
}

#[test]
fn directions_are_drawn_with_their_density() {
    let caster = |x, y, z, radius| SpecularCaster {
        center: Vec3::new(x, y, z),
        radius,
    };
    let sets = [
        vec![caster(0.0, 0.0, 3.0, 1.0)],
        // One over another, one that the horizon cuts, one about the vertex.
        vec![
            caster(2.0, 1.0, 2.0, 0.8),
            caster(1.0, 0.5, 1.2, 0.3),
            caster(-2.0, 1.0, 0.1, 0.9),
            caster(0.0, 0.1, 0.0, 5.0),
        ],
        // Below, and far away.
        vec![caster(0.0, 0.0, -3.0, 1.0), caster(9.0, 9.0, 40.0, 1.5)],
    ];
    let mut family = Family::default();
    let mut random = Random::new(11);
    let cells = SphereCells::even(16, 24);
    let mode = TransportMode::Radiance;
    for (name, material) in [("diffuse", lambert(0.7)), ("plastic", plastic(0.5))] {
        let mut stage = Stage::default();
        let floor = rectangle(Vec3::ZERO, Vec3::X * 9.0, Vec3::Y * 9.0);
        stage.add("floor", floor, material);
        let scene = stage.scene();
        let mut tracer = Tracer::new(&scene);
        let wo = Vec3::new(0.3, -0.2, 1.0).normalize();
        let vertex = tracer.vertex(&Ray::new(wo, -wo)).expect("the floor is met");
        for (i, casters) in sets.iter().enumerate() {
            let cones = Cones::seen_from(&vertex, casters).expect("the floor is diffuse");
            test_directions_within(
                1e-3,
                &mut family,
                &format!("{name}, set {i}"),
                &cells,
                |wi| {
                    let pdf_w = vertex.pdf_w(wi, mode);
                    let is_scattered = wi.z > 0.0;
                    f64::from(u8::from(is_scattered)) * f64::from(cones.mixed(wi, pdf_w))
                },
                || {
                    let sample = cones.sample(&vertex, random.triple(), mode)?;
                    let mixed = cones.mixed(sample.wi, vertex.pdf_w(sample.wi, mode));
                    assert!((sample.pdf_w / mixed - 1.0).abs() < 1e-3);
                    assert!((sample.wi.length() - 1.0).abs() < 1e-5);
                    Some(sample.wi)
                },
            );
        }
    }
    family.judge();
}

/// A mirror ball and one of glass between a diffuse floor, a wall that is coated in part with a
/// mirror-like coat, and a lamp.
fn still_life() -> Arc<Scene> {
    let mut stage = Stage::default();
    let floor = rectangle(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0);
    stage.add("floor", floor, lambert(0.7));
    let wall = rectangle(Vec3::new(0.0, 2.0, -3.0), Vec3::X * 4.0, Vec3::Y * 2.0);
    stage.add("wall", wall, plastic(0.0));
    let wall = rectangle(Vec3::new(-4.0, 2.0, 0.0), Vec3::Y * 2.0, Vec3::Z * 3.0);
    stage.add("second wall", wall, plastic(0.6));
    let lamp = rectangle(Vec3::new(0.0, 4.0, 0.0), Vec3::X * 1.5, Vec3::Z * 1.5);
    stage.add("lamp", lamp, emitter(3.0));
    stage.add("mirror", ball_at(Vec3::new(-1.2, 0.8, -0.5), 0.6), mirror());
    stage.add("glass", ball_at(Vec3::new(1.2, 0.9, 0.3), 0.6), glass());
    stage.description.cameras = vec![looking(Vec3::new(0.5, 2.0, 3.5), Vec3::new(0.0, 0.6, 0.0))];
    stage.scene()
}

#[test]
fn paths_sent_to_mirrors_and_glass_tend_to_the_same() {
    let scene = still_life();
    assert_eq!(scene.specular_casters().len(), 2);
    let batches = |aims_at_specular_casters, stream| {
        setup(&scene, aims_at_specular_casters).batches(64, 48, stream)
    };
    let (found, expected) = (batches(true, 80), batches(false, 81));
    assert_eq!(found.n_refused(), 0);
    let mut family = Family::default();
    for layer in 0..=4 {
        for block in Block::grid(&found.films[0], 3, 2) {
            let (a, b) = (found.block(block, layer), expected.block(block, layer));
            for channel in 0..3 {
                let (a, b) = (a[channel], b[channel]);
                let what = format!("T{layer} {block:?} channel {channel}: {a:?} {b:?}");
                family.add(a.p_value_against(&b, 1e-5), what);
            }
        }
    }
    family.judge();
}

/// A floor under a ball of glass and a lamp.
#[test]
fn caustics_have_less_error_for_the_same_rays() {
    let mut stage = Stage::default();
    let floor = rectangle(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0);
    stage.add("floor", floor, lambert(0.7));
    let lamp = rectangle(Vec3::new(0.0, 6.0, 0.0), Vec3::X * 0.4, Vec3::Z * 0.4);
    stage.add("lamp", lamp, emitter(50.0));
    stage.add("glass", ball_at(Vec3::new(0.0, 2.0, 0.0), 0.5), glass());
    stage.description.cameras = vec![above_square(2.0, 10.0)];
    let scene = stage.scene();
    let work = |aims_at_specular_casters| {
        let setup = setup(&scene, aims_at_specular_casters);
        let mut renderer = Renderer::new(Arc::clone(&scene), setup.settings.clone(), pool(), 0);
        let n_rays: u64 = (0..16)
            .map(|_| renderer.iterate(&CancelToken::default()).unwrap().n_rays())
            .sum();
        squared_error(&setup.batches(32, 16, 82)) * n_rays as f64
    };
    let gain = work(false) / work(true);
    assert!(gain > 2.0, "{gain}");
}

#[test]
fn only_what_may_cast_caustics_of_some_light_is_a_specular_caster() {
    let scene = |material: MaterialDescription, has_lamp: bool| {
        let mut stage = Stage::default();
        stage.add(
            "floor",
            rectangle(Vec3::ZERO, Vec3::Z, Vec3::X),
            lambert(0.5),
        );
        for i in 0..6 {
            let radius = 0.1 * (i + 1) as f32;
            stage.add(
                "ball",
                ball_at(Vec3::Y * i as f32, radius),
                material.clone(),
            );
        }
        if !has_lamp {
            stage.description.environment = Some(EnvironmentDescription::uniform(Rgb::WHITE));
        } else {
            stage.add(
                "lamp",
                rectangle(Vec3::Y * 9.0, Vec3::X, Vec3::Z),
                emitter(1.0),
            );
        }
        stage.scene()
    };
    let with_lamp = scene(glass(), true);
    let radii: Vec<f32> = with_lamp
        .specular_casters()
        .iter()
        .map(|c| c.radius)
        .collect();
    assert_eq!(radii.len(), SpecularCaster::MAX);
    for (radius, expected) in radii.iter().zip([0.6, 0.5, 0.4, 0.3]) {
        assert!((radius - expected).abs() < 1e-5, "{radii:?}");
    }
    // A sky of one radiance is found by whatever leaves the scene.
    assert!(scene(glass(), false).specular_casters().is_empty());
    assert!(scene(plastic(0.5), true).specular_casters().is_empty());
}
