//! Panels, camera, and what things are called.

use std::sync::Arc;

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::Vec3;
use neumann_core::film::View;
use neumann_core::scene::Scene;
use neumann_core::scene::builtin::builtin;
use neumann_viewer::app::App;
use neumann_viewer::panels::Page;

use crate::{click, harness, press};

#[test]
fn a_slider_steps_with_the_keyboard_and_resets() {
    let mut harness = harness([1280.0, 960.0]);
    assert_eq!(harness.state().session.setup.max_bounces, 16);
    harness
        .get_by_role_and_label(egui::accesskit::Role::Slider, "Maximum bounces")
        .focus();
    harness.run_steps(2);
    press(&mut harness, Key::ArrowRight);
    assert_eq!(harness.state().session.setup.max_bounces, 17);
    assert_eq!(
        harness.state().viewing.settings.part,
        View::Total,
        "the arrow stays with the slider"
    );
    assert_eq!(harness.state().session.link.n_starts(), 2);
    click(&mut harness, "Reset maximum bounces");
    assert_eq!(harness.state().session.setup.max_bounces, 16);
}

#[test]
fn parameters_of_the_method_can_be_changed() {
    let mut harness = harness([1280.0, 960.0]);
    let method = harness.state().session.setup.method();
    let parameter = method.parameters.first().expect("pt-mis has roulette");
    let before = harness.state().session.setup.settings().unwrap().values;
    click(&mut harness, parameter.title);
    let after = harness
        .state()
        .session
        .link
        .started()
        .unwrap()
        .settings
        .values
        .clone();
    assert_ne!(before, after);
}

#[test]
fn tab_hides_the_panels_and_f6_gives_them_the_keyboard() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::Tab);
    assert!(harness.state().shell.is_bare);
    press(&mut harness, Key::Tab);
    assert!(!harness.state().shell.is_bare);
    press(&mut harness, Key::Tab);
    press(&mut harness, Key::F6);
    assert!(!harness.state().shell.is_bare);
    assert!(harness.get_by_label("Method").is_focused(), "its page");
    press(&mut harness, Key::F6);
    assert!(harness.ctx.memory(|m| m.focused()).is_none());
    press(&mut harness, Key::F6);
    press(&mut harness, Key::Tab);
    assert!(
        !harness.state().shell.is_bare,
        "Tab goes on to the next control"
    );
    press(&mut harness, Key::Escape);
    assert!(harness.ctx.memory(|m| m.focused()).is_none());
}

#[test]
fn the_camera_moves_and_comes_home() {
    let mut harness = harness([1280.0, 720.0]);
    let home = harness.state().session.setup.camera.as_ref().unwrap().eye();
    press(&mut harness, Key::W);
    assert_ne!(
        harness.state().session.setup.camera.as_ref().unwrap().eye(),
        home
    );
    press(&mut harness, Key::Home);
    assert_eq!(
        harness.state().session.setup.camera.as_ref().unwrap().eye(),
        home
    );
}

/// The ground of the built-in `sky` is eighty metres wide, and its largest ball not two.
#[test]
fn all_is_framed_without_the_ground_and_the_wheel_changes_how_fast_one_flies() {
    let mut harness = harness([1280.0, 720.0]);
    let sky = builtin("sky").expect("a built-in scene");
    let sky = sky.load().expect("a scene as it comes");
    let scene = Arc::new(Scene::build(&sky));
    harness
        .state_mut()
        .take_scene("sky".to_owned(), Arc::clone(&scene));
    harness.run_steps(2);
    press(&mut harness, Key::F);
    let camera = |harness: &Harness<'_, App>| harness.state().session.setup.camera.clone().unwrap();
    let framed = camera(&harness);
    let distance = (framed.eye() - framed.target()).length();
    assert!(distance > 3.0 && distance < 12.0, "{distance} m away");
    let aimed = (framed.target() - Vec3::Y * framed.target().y).length();
    assert!(aimed < 3.0, "at what stands there: {}", framed.target());

    let step = |harness: &mut Harness<'_, App>| {
        let before = camera(harness).eye();
        press(harness, Key::D);
        (camera(harness).eye() - before).length()
    };
    let slow = step(&mut harness);
    assert!(slow > 0.0 && slow < distance / 4.0, "{slow} m");
    let middle = harness.get_by_label_contains("picture: ").rect().center();
    harness.hover_at(middle);
    harness.key_down(Key::D);
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 4.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(20);
    harness.key_up(Key::D);
    harness.run_steps(2);
    let now = camera(&harness);
    let apart = (now.eye() - now.target()).length();
    assert!((apart - distance).abs() < 1e-3, "the wheel does not dolly");
    let fast = step(&mut harness);
    assert!(fast > 1.5 * slow, "{slow} m, then {fast} m");
}

#[test]
fn the_title_names_scene_and_method_and_cameras_stand_on_their_page() {
    let mut harness = harness([1280.0, 720.0]);
    assert_eq!(harness.state().title(), "furnace – pt-mis – neumann");
    press(&mut harness, Key::CloseBracket);
    assert_eq!(harness.state().title(), "furnace – drt – neumann");
    let room = builtin("cornell").expect("a built-in scene");
    let mut room = room.load().expect("a scene as it comes");
    room.cameras[0].name = "front".to_owned();
    let mut back = room.cameras[0].clone();
    back.name = "back".to_owned();
    back.world_from_camera.w_axis.z += 1.0;
    room.cameras.push(back.clone());
    let scene = Arc::new(Scene::build(&room));
    harness.state_mut().take_scene("room.glb".to_owned(), scene);
    harness.state_mut().shell.page = Page::Scene;
    harness.run_steps(2);
    assert!(harness.query_by_label("back").is_none());
    press(&mut harness, Key::F3);
    click(&mut harness, "back");
    let camera = harness.state().session.setup.settings().unwrap().camera;
    assert_eq!(camera.world_from_camera, back.world_from_camera);
    assert_eq!(harness.state().title(), "room – drt – neumann");
}

#[test]
fn figures_choices_and_items_of_the_bar_say_what_they_are() {
    let mut harness = harness([1280.0, 800.0]);
    let bar = harness.get_by_label("method: bdpt").rect().center();
    let pause = harness.get_by_label("Pause rendering").rect().center();
    let status = harness.get_by_label_contains("estimated error").rect();
    let choice = harness.get_by_label("Choose lights: tree").rect().center();
    for (at, about) in [
        (bar, "Bidirectional path tracing. "),
        (pause, "Keeps all samples"),
        (
            status.left_center() + egui::vec2(24.0, 0.0),
            "Complete estimates",
        ),
        (choice, "The light to aim at is chosen"),
    ] {
        harness.hover_at(at);
        for _ in 0..8 {
            std::thread::sleep(std::time::Duration::from_millis(100));
            harness.run_steps(4);
        }
        let n = harness.query_all_by_label_contains(about).count();
        assert!(n > 0, "{about}");
    }
}

#[test]
fn a_light_can_be_switched_off_and_a_material_edited() {
    let mut harness = harness([1280.0, 2400.0]);
    press(&mut harness, Key::F2);
    let app = harness.state_mut();
    let material = app
        .session
        .setup
        .open
        .as_ref()
        .unwrap()
        .scene
        .appearance()
        .materials[0]
        .name
        .clone();
    harness.run_steps(2);
    click(&mut harness, &material);
    let scene = &harness.state().session.setup.open.as_ref().unwrap().scene;
    assert!(!scene.appearance().material_levels[0].is_on);
    assert_eq!(harness.state().session.link.n_starts(), 2);

    // What stands below does not undo it.
    click(&mut harness, "Environment");
    click(&mut harness, &material);
    let scene = &harness.state().session.setup.open.as_ref().unwrap().scene;
    assert!(scene.appearance().material_levels[0].is_on);
    assert_eq!(harness.state().session.link.n_starts(), 3);
}

#[test]
fn help_lists_the_keys_and_escape_closes_it() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::Questionmark);
    assert!(harness.state().shell.is_help_open);
    assert!(harness.query_by_label("keys").is_some());
    press(&mut harness, Key::Escape);
    assert!(!harness.state().shell.is_help_open);
}
