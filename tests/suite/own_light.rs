//! Which scenes get the built-in sky: those whose own light hardly shows what the camera sees.

use glam::Vec3;
use neumann_core::radiometry::Rgb;
use neumann_core::render::lit;
use neumann_core::scene::builtin::BUILTINS;
use neumann_core::scene::description::{DefaultSky, LightKind, MaterialDescription};
use neumann_core::scene::{Scene, Sky, SkyChoice};
use neumann_tests::renders::Setup;
use neumann_tests::scenes::{
    Stage, ball, builtin_description, emitter, lambert, looking, rectangle, room,
};

fn gets_sky(stage: &Stage) -> bool {
    lit(Scene::build(&stage.description)).has_default_sky()
}

/// A ball with a glowing patch just above its front.
fn ball_with_patch(radiance: f32) -> Stage {
    let mut stage = Stage::default();
    stage.add("ball", ball(1.0), lambert(0.5));
    let patch = rectangle(Vec3::Z * 1.01, Vec3::X * 0.2, Vec3::Y * 0.1);
    stage.add("patch", patch, emitter(radiance));
    stage
}

/// A room seen from inside, with a small lamp under its ceiling.
fn room_with_lamp(radiance: f32) -> Stage {
    let mut stage = Stage::default();
    stage.add("room", room(), lambert(0.7));
    let lamp = rectangle(Vec3::Y * 0.98, Vec3::X * 0.2, Vec3::Z * 0.2);
    stage.add("lamp", lamp, emitter(radiance));
    let camera = looking(Vec3::Z * 0.9, Vec3::ZERO);
    stage.description.cameras.push(camera);
    stage
}

fn unlit(albedo: f32) -> MaterialDescription {
    MaterialDescription {
        is_unlit: true,
        ..lambert(albedo)
    }
}

#[test]
fn built_in_scenes_stay_as_they_are() {
    for entry in BUILTINS {
        let mut description = builtin_description(entry.name);
        // They say so themselves; here the pilot has to see it.
        assert_eq!(description.default_sky, DefaultSky::Never);
        description.default_sky = DefaultSky::WhereDim;
        let scene = lit(Scene::build(&description));
        assert!(!scene.has_default_sky(), "{}", entry.name);
        assert!(scene.warnings().is_empty(), "{}", entry.name);
    }
}

#[test]
fn a_glowing_detail_is_no_light() {
    for radiance in [0.5, 1.0, 20.0] {
        let stage = ball_with_patch(radiance);
        assert!(gets_sky(&stage), "{radiance}");
        let scene = lit(Scene::build(&stage.description));
        let warning = scene.warnings().last().unwrap();
        assert!(warning.contains("'studio' is added"), "{warning}");
    }
    // A flame in a closed lantern.
    let mut stage = Stage::default();
    stage.add("lantern", ball(1.0), lambert(0.3));
    stage.add("flame", ball(0.1), emitter(100.0));
    assert!(gets_sky(&stage));
    // An emitter that is black lights nothing.
    let mut stage = Stage::default();
    stage.add("ball", ball(1.0), lambert(0.5));
    stage.light(
        LightKind::Point {
            intensity: Rgb::BLACK,
        },
        Vec3::Z * 3.0,
        Vec3::Z,
    );
    assert!(gets_sky(&stage));
}

#[test]
fn a_lamp_that_lights_what_is_seen_is_one() {
    // However dim: exposure shows it.
    for radiance in [100.0, 1.0, 0.1] {
        assert!(!gets_sky(&room_with_lamp(radiance)), "{radiance}");
    }
    // Out of sight.
    let mut stage = room_with_lamp(5.0);
    stage.description.cameras[0] = looking(Vec3::Z * 0.9, Vec3::NEG_Y);
    assert!(!gets_sky(&stage));
    // A large panel that glows a little.
    let mut stage = ball_with_patch(1.0);
    let panel = rectangle(Vec3::new(0.0, 0.0, 4.0), Vec3::NEG_X * 3.0, Vec3::Y * 3.0);
    stage.add("panel", panel, emitter(0.8));
    stage
        .description
        .cameras
        .push(looking(Vec3::new(2.5, 0.5, 2.5), Vec3::ZERO));
    assert!(!gets_sky(&stage));
    // A point light.
    let mut stage = ball_with_patch(1.0);
    stage.light(
        LightKind::Point {
            intensity: Rgb::splat(1.0),
        },
        Vec3::new(1.0, 1.0, 3.0),
        Vec3::Z,
    );
    assert!(!gets_sky(&stage));
    // A spot on a stage that is dark otherwise; not if it is put out.
    for intensity in [40.0, 1e-4] {
        let mut stage = Stage::default();
        let floor = rectangle(Vec3::ZERO, Vec3::Z * 3.0, Vec3::X * 3.0);
        stage.add("floor", floor, lambert(0.6));
        let kind = LightKind::Spot {
            intensity: Rgb::splat(intensity),
            inner_cone: 0.10,
            outer_cone: 0.14,
        };
        stage.light(kind, Vec3::new(0.5, 3.0, 0.5), Vec3::NEG_Y);
        let camera = looking(Vec3::new(0.0, 3.0, 3.0), Vec3::ZERO);
        stage.description.cameras.push(camera);
        assert_eq!(gets_sky(&stage), intensity < 1.0, "{intensity}");
    }
}

#[test]
fn what_is_unlit_needs_no_light() {
    let mut stage = Stage::default();
    stage.add("ball", ball(1.0), unlit(0.6));
    assert!(!gets_sky(&stage));
    // Beside it is something that does.
    stage.add(
        "floor",
        rectangle(Vec3::NEG_Y, Vec3::Z * 3.0, Vec3::X * 3.0),
        lambert(0.6),
    );
    assert!(gets_sky(&stage));
}

#[test]
fn nobody_gets_a_sky_against_their_will() {
    let mut stage = ball_with_patch(1.0);
    SkyChoice::None.apply(&mut stage.description).unwrap();
    assert!(!gets_sky(&stage));
    let mut dark = Stage::default();
    dark.add("ball", ball(1.0), lambert(0.5));
    SkyChoice::None.apply(&mut dark.description).unwrap();
    assert!(!gets_sky(&dark));
    let film = Setup::new(&dark.scene(), 8, 8).film(0, 1);
    assert!(film.total().iter().all(|c| c.is_black()));
    SkyChoice::Builtin(Sky::Sun)
        .apply(&mut stage.description)
        .unwrap();
    let scene = lit(Scene::build(&stage.description));
    let environment = scene.appearance().environment.as_ref().unwrap();
    assert_eq!(environment.name, "sun");
    assert!(!scene.has_default_sky());
}
