//! Views of a scene that are kept, named, gone to and forgotten.

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::{Vec2, Vec3};
use neumann_viewer::app::App;

use crate::{click, harness, press};

fn press_with(harness: &mut Harness<'_, App>, modifiers: Modifiers, key: Key) {
    harness.key_press_modifiers(modifiers, key);
    harness.run_steps(2);
}

fn eye(harness: &Harness<'_, App>) -> Vec3 {
    let control = harness.state().session.setup.camera.as_ref();
    control.expect("a camera").eye()
}

fn orbit(harness: &mut Harness<'_, App>, angle: f32) {
    let setup = &mut harness.state_mut().session.setup;
    let control = setup.camera.as_mut().expect("a camera");
    control.orbit(Vec2::new(angle, 0.0));
    setup.is_changed = true;
    harness.run_steps(2);
}

fn names(harness: &Harness<'_, App>) -> Vec<String> {
    let views = &harness.state().session.setup.views;
    views.iter().map(|view| view.name.clone()).collect()
}

#[test]
fn keys_keep_views_and_go_to_them() {
    let mut harness = harness([1280.0, 720.0]);
    let both = Modifiers::COMMAND | Modifiers::SHIFT;
    press_with(&mut harness, Modifiers::COMMAND, Key::Num1);
    let notice = harness.state().shell.notices.texts().next();
    let notice = notice.expect("it says why").to_owned();
    assert!(notice.contains("Ctrl Shift 1 keeps"), "{notice}");
    let first = eye(&harness);
    press_with(&mut harness, both, Key::Num1);
    orbit(&mut harness, 0.5);
    let second = eye(&harness);
    // There are no gaps: the fifth view is the second one here.
    press_with(&mut harness, both, Key::Num5);
    assert_eq!(names(&harness), ["View 1", "View 2"]);
    let n_starts = harness.state().session.link.n_starts();
    press_with(&mut harness, Modifiers::COMMAND, Key::Num1);
    assert_eq!(eye(&harness), first);
    assert_eq!(harness.state().session.link.n_starts(), n_starts + 1);
    press_with(&mut harness, Modifiers::COMMAND, Key::Num2);
    assert_eq!(eye(&harness), second);
    // The same number once more takes the place of what was there.
    orbit(&mut harness, 0.25);
    let third = eye(&harness);
    press_with(&mut harness, both, Key::Num1);
    assert_eq!(names(&harness).len(), 2);
    orbit(&mut harness, 0.25);
    press_with(&mut harness, Modifiers::COMMAND, Key::Num1);
    assert_eq!(eye(&harness), third);
    // They outlive the scene that was opened in between.
    let kept = harness.state().shell.bookmarks.of("furnace");
    assert_eq!(kept, harness.state().session.setup.views);
    assert_eq!(kept.len(), 2);
}

#[test]
fn the_camera_page_keeps_names_goes_to_and_forgets() {
    let mut harness = harness([1280.0, 900.0]);
    press(&mut harness, Key::F3);
    let first = eye(&harness);
    click(&mut harness, "Keep view");
    orbit(&mut harness, 0.5);
    click(&mut harness, "Keep view");
    harness.get_by_label("Name of the view").focus();
    harness.run_steps(2);
    harness
        .get_by_label("Name of the view")
        .type_text(" from behind");
    harness.run_steps(2);
    assert_eq!(names(&harness), ["View 1", "View 2 from behind"]);
    press(&mut harness, Key::Escape);
    let kept = harness.state().shell.bookmarks.of("furnace");
    assert_eq!(kept[1].name, "View 2 from behind");
    click(&mut harness, "View 1");
    assert_eq!(eye(&harness), first);
    orbit(&mut harness, -0.5);
    let replaced = eye(&harness);
    click(&mut harness, "Replace");
    click(&mut harness, "View 2 from behind");
    click(&mut harness, "View 1");
    assert_eq!(eye(&harness), replaced);
    click(&mut harness, "Remove");
    assert_eq!(names(&harness), ["View 2 from behind"]);
    assert_eq!(harness.state().shell.bookmarks.of("furnace").len(), 1);
}
