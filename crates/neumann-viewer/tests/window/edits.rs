//! Edits: undone and redone, picked in the picture, coloured, and steady under the hand.

use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Key, Modifiers, PointerButton, Pos2, Rect, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use glam::Mat4;
use neumann_core::radiometry::Rgb;
use neumann_core::scene::builtin::builtin;
use neumann_core::scene::description::{LightDescription, LightKind};
use neumann_core::scene::{Appearance, Scene};
use neumann_viewer::app::App;
use neumann_viewer::history::MOST_STEPS;
use neumann_viewer::panels::Page;
use neumann_viewer::pick::Picked;

use crate::{click, drag, harness, press, wait};

/// The window on the built-in scene `sky`, with a lamp.
fn sky(size: [f32; 2]) -> Harness<'static, App> {
    let mut harness = harness(size);
    let sky = builtin("sky").expect("a built-in scene");
    let mut sky = sky.load().expect("a scene as it comes");
    sky.lights.push(LightDescription {
        name: "lamp".to_owned(),
        world_from_light: Mat4::from_translation(glam::Vec3::Y * 5.0),
        kind: LightKind::Point {
            intensity: Rgb::new(4.0, 2.0, 1.0),
        },
    });
    let scene = Arc::new(Scene::build(&sky));
    harness.state_mut().take_scene("sky".to_owned(), scene);
    harness.run_steps(3);
    harness
}

fn appearance(harness: &Harness<'_, App>) -> Appearance {
    let open = harness.state().session.setup.open.as_ref();
    open.expect("a scene").scene.appearance().clone()
}

fn eye(harness: &Harness<'_, App>) -> glam::Vec3 {
    let camera = harness.state().session.setup.camera.as_ref();
    camera.expect("a camera").eye()
}

fn notices(harness: &Harness<'_, App>) -> Vec<String> {
    let notices = &harness.state().shell.notices;
    notices.texts().map(str::to_owned).collect()
}

fn with(harness: &mut Harness<'_, App>, modifiers: Modifiers, key: Key) {
    harness.key_press_modifiers(modifiers, key);
    harness.run_steps(2);
}

fn undo(harness: &mut Harness<'_, App>) {
    with(harness, Modifiers::COMMAND, Key::Z);
}

fn redo(harness: &mut Harness<'_, App>) {
    with(harness, Modifiers::COMMAND, Key::Y);
}

fn click_at(harness: &mut Harness<'_, App>, at: Pos2, modifiers: Modifiers) {
    harness.event_modifiers(egui::Event::PointerMoved(at), modifiers);
    for pressed in [true, false] {
        let event = egui::Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers,
        };
        harness.event_modifiers(event, modifiers);
    }
    harness.run_steps(4);
}

/// Name and place of every slider on the page.
fn sliders(harness: &Harness<'_, App>) -> Vec<(String, Rect)> {
    let nodes = harness.query_all_by_role(Role::Slider);
    nodes
        .map(|node| {
            let label = node.accesskit_node().label().unwrap_or_default();
            (label, node.rect())
        })
        .collect()
}

fn slider(harness: &Harness<'_, App>, name: &str) -> Rect {
    let all = sliders(harness);
    let found = all.iter().find(|(label, _)| label == name);
    found.unwrap_or_else(|| panic!("{name} in {all:?}")).1
}

fn share(rect: Rect, x: f32) -> Pos2 {
    pos2(egui::lerp(rect.x_range(), x), rect.center().y)
}

#[test]
fn a_drag_of_the_camera_is_one_step_and_comes_back() {
    let mut harness = sky([1280.0, 720.0]);
    let home = eye(&harness);
    let middle = harness.get_by_label_contains("picture: ").rect().center();
    let way: Vec<Pos2> = (0..12)
        .map(|i| middle + vec2(9.0 * i as f32, 3.0))
        .collect();
    drag(&mut harness, &way, |_| {});
    let moved = eye(&harness);
    assert!((moved - home).length() > 0.1);
    press(&mut harness, Key::W);
    let flown = eye(&harness);
    assert_ne!(flown, moved);

    undo(&mut harness);
    assert_eq!(eye(&harness), moved, "the flight");
    assert_eq!(notices(&harness), ["Undid: camera move"]);
    undo(&mut harness);
    assert_eq!(eye(&harness), home, "the whole drag");
    undo(&mut harness);
    assert_eq!(notices(&harness), ["Nothing to undo"]);
    redo(&mut harness);
    assert_eq!(eye(&harness), moved);
    with(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(eye(&harness), flown);
    assert_eq!(notices(&harness), ["Redid: camera move"]);
    let job = harness.state().session.link.started().expect("it renders");
    let eye_of_job = job.settings.camera.world_from_camera.w_axis.truncate();
    assert_eq!(eye_of_job, flown);

    // What is edited after an undo is the end of what could be redone.
    undo(&mut harness);
    press(&mut harness, Key::CloseBracket);
    redo(&mut harness);
    assert_eq!(notices(&harness), ["Nothing to redo"]);
    undo(&mut harness);
    assert_eq!(notices(&harness), ["Undid: choice of drt"]);
    assert_eq!(eye(&harness), moved);
}

#[test]
fn a_turn_of_the_wheel_is_one_step() {
    let mut harness = sky([1280.0, 720.0]);
    let home = eye(&harness);
    let middle = harness.get_by_label_contains("picture: ").rect().center();
    harness.hover_at(middle);
    for _ in 0..3 {
        harness.event(egui::Event::MouseWheel {
            unit: egui::MouseWheelUnit::Line,
            delta: vec2(0.0, 1.0),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Wheel,
            modifiers: Modifiers::NONE,
        });
        harness.run_steps(3);
    }
    let near = eye(&harness);
    assert_ne!(near, home);
    // Long enough for the wheel to have come to rest.
    harness.run_steps(120);
    undo(&mut harness);
    assert_eq!(eye(&harness), home);
}

#[test]
fn a_drag_of_a_slider_is_one_step_and_says_of_what() {
    let mut harness = sky([1280.0, 2600.0]);
    press(&mut harness, Key::F2);
    click(&mut harness, "Materials");
    click(&mut harness, "clay");
    let before = appearance(&harness).materials[1].roughness;
    let track = slider(&harness, "Roughness");
    let way: Vec<Pos2> = (0..10)
        .map(|i| share(track, 0.2 + 0.07 * i as f32))
        .collect();
    drag(&mut harness, &way, |_| {});
    let after = appearance(&harness).materials[1].roughness;
    assert_ne!(before, after);
    click(&mut harness, "lamp");
    undo(&mut harness);
    assert_eq!(notices(&harness), ["Undid: lamp switched off"]);
    assert!(appearance(&harness).light_levels[0].is_on);
    // The buttons do the same.
    click(&mut harness, "Undo");
    assert_eq!(notices(&harness), ["Undid: roughness of clay"]);
    assert_eq!(appearance(&harness).materials[1].roughness, before);
    click(&mut harness, "Redo");
    assert_eq!(appearance(&harness).materials[1].roughness, after);
    assert_eq!(notices(&harness), ["Redid: roughness of clay"]);
}

#[test]
fn the_history_is_bounded_and_begins_anew_with_a_scene() {
    let mut harness = sky([1280.0, 720.0]);
    let home = eye(&harness);
    for _ in 0..MOST_STEPS + 5 {
        press(&mut harness, Key::W);
    }
    for _ in 0..MOST_STEPS {
        undo(&mut harness);
    }
    assert_eq!(notices(&harness), ["Undid: camera move"]);
    assert_ne!(eye(&harness), home);
    undo(&mut harness);
    assert_eq!(notices(&harness), ["Nothing to undo"]);
    let furnace = builtin("furnace").expect("a built-in scene");
    let furnace = Scene::build(&furnace.load().expect("a scene as it comes"));
    let harness_state = harness.state_mut();
    harness_state.take_scene("furnace".to_owned(), Arc::new(furnace));
    harness.run_steps(2);
    redo(&mut harness);
    assert_eq!(notices(&harness), ["Nothing to redo"]);
}

#[test]
fn a_sky_that_is_removed_comes_back_by_its_notice_and_by_undo() {
    let mut harness = sky([1280.0, 2600.0]);
    press(&mut harness, Key::F2);
    click(&mut harness, "Environment");
    let is_there = |harness: &Harness<'_, App>| appearance(harness).environment.is_some();
    assert!(is_there(&harness));
    click(&mut harness, "Sky: none");
    assert!(!is_there(&harness));
    press(&mut harness, Key::W);
    click(&mut harness, "Restore sky");
    assert!(is_there(&harness));
    undo(&mut harness);
    assert!(!is_there(&harness), "the notice's own step");
    undo(&mut harness);
    undo(&mut harness);
    assert!(is_there(&harness));
    assert_eq!(notices(&harness), ["Undid: choice of the environment"]);
}

#[test]
fn a_text_field_keeps_its_own_undo() {
    let mut harness = sky([1280.0, 2600.0]);
    press(&mut harness, Key::W);
    let flown = eye(&harness);
    press(&mut harness, Key::F2);
    harness.get_by_label("Scene path").focus();
    harness.run_steps(2);
    undo(&mut harness);
    assert_eq!(eye(&harness), flown);
    assert!(notices(&harness).is_empty());
}

#[test]
fn what_lies_under_the_pointer_is_picked_with_its_material() {
    let mut harness = sky([1280.0, 720.0]);
    let picture = harness
        .state()
        .viewing
        .placement
        .expect("a picture")
        .visible;
    let starts = harness.state().session.link.n_starts();
    click_at(&mut harness, picture.center(), Modifiers::SHIFT);
    let shell = &harness.state().shell;
    assert_eq!(shell.page, Page::Scene);
    let Some(Picked::Surface { material, place }) = shell.picked.clone() else {
        panic!("{:?}", shell.picked);
    };
    assert_eq!(shell.material, Some(material));
    assert!(place.contains("triangle "), "{place}");
    // Its controls are on the screen, though the page is long.
    let name = appearance(&harness).materials[material].name.clone();
    harness.run_steps(30);
    let row = harness.get_by_label(&name).rect();
    assert!(row.top() > 40.0 && row.bottom() < 600.0, "{row:?}");
    assert!(harness.query_by_label(&place).is_some());

    // The sky, and a click that is none of it.
    click_at(
        &mut harness,
        picture.center_top() + vec2(0.0, 6.0),
        Modifiers::SHIFT,
    );
    assert_eq!(harness.state().shell.picked, Some(Picked::Sky));
    assert!(harness.query_by_label("Sky: none").is_some(), "it is open");
    press(&mut harness, Key::F1);
    click_at(&mut harness, picture.center(), Modifiers::NONE);
    assert_eq!(harness.state().shell.page, Page::Method);

    // By the keyboard: where the pointer is, or else the middle.
    harness.remove_cursor();
    harness.run_steps(2);
    with(&mut harness, Modifiers::SHIFT, Key::I);
    assert_eq!(harness.state().shell.page, Page::Scene);
    assert_eq!(harness.state().shell.material, Some(material));
    assert_eq!(harness.state().session.link.n_starts(), starts);
}

#[test]
fn colours_are_picked_and_strengths_stay() {
    let mut harness = sky([1280.0, 2600.0]);
    press(&mut harness, Key::F2);
    let before = appearance(&harness).lights[0].kind.strength();
    click(&mut harness, "Colour of lamp");
    harness.run_steps(10);
    assert_eq!(
        appearance(&harness).lights[0].kind.strength(),
        before,
        "only looked at"
    );
    let field = harness.get_by_label("Hue and saturation").rect();
    let way: Vec<Pos2> = (1..8)
        .map(|i| field.min + 0.1 * i as f32 * field.size())
        .collect();
    drag(&mut harness, &way, |_| {});
    let after = appearance(&harness).lights[0].kind.strength();
    assert_ne!(after, before);
    let strengths = [before, after].map(|c| c.max_channel());
    assert!(
        (strengths[1] / strengths[0] - 1.0).abs() < 1e-4,
        "{strengths:?}"
    );
    // Its numbers can be edited, and grey keeps the hue for the way back.
    let track = slider(&harness, "Saturation");
    drag(
        &mut harness,
        &[share(track, 0.5), share(track, 0.0)],
        |_| {},
    );
    let Rgb { r, g, b } = appearance(&harness).lights[0].kind.strength();
    assert!(r == g && g == b, "{r} {g} {b}");
    drag(
        &mut harness,
        &[share(track, 0.3), share(track, 1.0)],
        |_| {},
    );
    let full = appearance(&harness).lights[0].kind.strength();
    let brightest = |c: Rgb| {
        let channels = c.to_array();
        channels.iter().position(|v| *v == c.max_channel())
    };
    assert_eq!(brightest(full), brightest(after));
    press(&mut harness, Key::Escape);
    assert!(harness.query_by_label("Hue and saturation").is_none());
    for _ in 0..3 {
        undo(&mut harness);
        assert_eq!(notices(&harness), ["Undid: colour of lamp"]);
    }
    assert_eq!(appearance(&harness).lights[0].kind.strength(), before);
}

/// A lamp is turned down to nothing and up again: it keeps its colour.
#[test]
fn emission_keeps_its_colour_through_black() {
    let mut harness = sky([1280.0, 2600.0]);
    press(&mut harness, Key::F2);
    click(&mut harness, "Materials");
    click(&mut harness, "clay");
    let app = harness.state_mut();
    let mut red = app
        .session
        .setup
        .snapshot()
        .expect("a scene")
        .appearance
        .as_ref()
        .clone();
    red.materials[1].emission = Rgb::new(8.0, 2.0, 1.0);
    app.session.setup.dress(red);
    harness.run_steps(3);
    let emission = |harness: &Harness<'_, App>| appearance(harness).materials[1].emission;
    let track = slider(&harness, "Emission");
    drag(
        &mut harness,
        &[share(track, 0.5), share(track, 0.0)],
        |_| {},
    );
    assert!(emission(&harness).is_black());
    let track = slider(&harness, "Emission");
    drag(
        &mut harness,
        &[share(track, 0.3), share(track, 0.7)],
        |_| {},
    );
    let Rgb { r, g, b } = emission(&harness);
    assert!(r > 0.0 && (r / g - 4.0).abs() < 1e-3 && (r / b - 8.0).abs() < 1e-3);
}

/// Whatever a slider changes, neither it nor its range moves while it is held: a material that
/// begins to shine joins the lights above its own controls only when the hand has let go.
#[test]
fn no_slider_moves_under_the_hand() {
    let mut harness = sky([1280.0, 3200.0]);
    harness.state_mut().viewing.settings.is_auto = true;
    let mut n = 0;
    for page in [Key::F1, Key::F2, Key::F3, Key::F4] {
        press(&mut harness, page);
        if page == Key::F2 {
            for name in ["Environment", "Materials", "clay"] {
                click(&mut harness, name);
            }
        }
        for i in 0..sliders(&harness).len() {
            // An edit may have brought rows, which are gone again by now.
            let all = sliders(&harness);
            let (name, track) = all[i].clone();
            let way = [0.3, 0.6, 0.99, 0.4, 0.01, 0.0, 0.2].map(|x| share(track, x));
            drag(&mut harness, &way, |harness| {
                let now = sliders(harness);
                let is_there = now.contains(&(name.clone(), track));
                assert!(is_there, "{name} at {track:?} is gone: {now:?}");
            });
            n += 1;
            if harness.state().session.history.to_undo().is_some() {
                undo(&mut harness);
            }
            assert_eq!(
                sliders(&harness).len(),
                all.len(),
                "{name}: undone in one step"
            );
        }
    }
    assert!(n > 20, "{n} sliders");
}

/// The page is scrolled to its end, which is where it would become shorter.
#[test]
fn a_slider_stays_where_the_page_gets_shorter() {
    let mut harness = sky([1280.0, 640.0]);
    press(&mut harness, Key::F2);
    harness.state_mut().shell.material = None;
    click_at(&mut harness, pos2(400.0, 350.0), Modifiers::SHIFT);
    harness.run_steps(30);
    let track = slider(&harness, "Emission");
    drag(
        &mut harness,
        &[share(track, 0.3), share(track, 0.5)],
        |_| {},
    );
    harness.hover_at(pos2(1150.0, 300.0));
    for _ in 0..10 {
        harness.event(egui::Event::MouseWheel {
            unit: egui::MouseWheelUnit::Line,
            delta: vec2(0.0, -100.0),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Wheel,
            modifiers: Modifiers::NONE,
        });
        harness.run_steps(10);
    }
    harness.run_steps(30);
    let track = slider(&harness, "Emission");
    assert!(track.bottom() < 560.0, "it is on the screen: {track:?}");
    drag(
        &mut harness,
        &[share(track, 0.5), share(track, 0.2), share(track, 0.0)],
        |harness| {
            assert_eq!(slider(harness, "Emission"), track);
        },
    );
}

/// A press on the knob alone changes nothing, wherever it is taken.
#[test]
fn a_knob_stays_where_it_is_taken() {
    let mut harness = sky([1280.0, 2600.0]);
    press(&mut harness, Key::F2);
    click(&mut harness, "Materials");
    click(&mut harness, "clay");
    let starts = harness.state().session.link.n_starts();
    let before = appearance(&harness).materials[1].roughness;
    let track = slider(&harness, "Roughness");
    let inner = track.shrink2(vec2(5.0, 0.0));
    let knob = share(inner, before);
    let at = knob + vec2(4.0, 0.0);
    drag(&mut harness, &[at, at], |_| {});
    assert_eq!(appearance(&harness).materials[1].roughness, before);
    assert_eq!(harness.state().session.link.n_starts(), starts);
    let step = 0.1 * inner.width() * if before > 0.5 { -1.0 } else { 1.0 };
    drag(&mut harness, &[at, at + vec2(step, 0.0)], |_| {});
    let moved = appearance(&harness).materials[1].roughness - before;
    assert!((moved.abs() - 0.1).abs() < 1e-3, "{moved}");
    wait(&mut harness, |app| app.session.history.to_undo().is_some());
}
