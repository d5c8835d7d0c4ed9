//! Noise and the bias of a radius: a method that renders at two radii while one looks.

use egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_core::film::View as Part;
use neumann_picture::radius_bias::Half;
use neumann_viewer::app::App;
use neumann_viewer::views::bias::BiasView;

use crate::{click, live, press, wait};

fn of(app: &App) -> &BiasView {
    app.viewing.views.get().expect("a row of VIEWS")
}

fn n_renders(app: &App) -> usize {
    of(app).found().map_or(0, |found| found.n_renders)
}

fn saved(app: &App) -> (String, Vec<[u8; 3]>) {
    let views = &app.viewing.views;
    let shown = views.image(&app.session, &app.viewing.settings);
    let shown = shown.expect("something to save");
    (shown.name, (shown.pixels)().pixels)
}

fn measured() -> Harness<'static, App> {
    let mut harness = live((48, 48), "ppm");
    harness.key_press_modifiers(egui::Modifiers::SHIFT, Key::B);
    harness.run_steps(2);
    assert_eq!(harness.state().viewing.views.shown().id, "bias");
    wait(&mut harness, |app| n_renders(app) >= 3);
    harness.run_steps(2);
    harness
}

#[test]
fn the_error_is_split_live_and_digits_choose_the_part() {
    let mut harness = measured();
    let n_of_film = |app: &App| app.session.link.read(|p| p.film.n_iterations());
    let before = n_of_film(harness.state());
    let is_said = |harness: &Harness<'_, App>, text: &str| {
        let n = harness.query_all_by_label_contains(text).count();
        assert!(n > 0, "{text}");
    };
    is_said(&harness, "Radius bias of L; ");
    is_said(&harness, "ppm after 4 iterations, L: relative error ");
    press(&mut harness, Key::Num1);
    harness.run_steps(2);
    is_said(&harness, "ppm after 4 iterations, T1: relative error ");
    is_said(&harness, "T1: mostly noise");
    let (name, bias) = saved(harness.state());
    assert_eq!(name, "bias-T1");
    click(&mut harness, "L: mostly noise");
    assert_eq!(harness.state().viewing.settings.part, Part::Total);
    harness.run_steps(2);
    let (name, whole) = saved(harness.state());
    assert_eq!(name, "bias-L");
    assert_ne!(whole, bias);
    click(&mut harness, "Map: noise");
    assert_eq!(of(harness.state()).half, Half::Noise);
    is_said(&harness, "Noise of L; ");
    let n = n_renders(harness.state());
    wait(&mut harness, |app| n_renders(app) > n);
    press(&mut harness, Key::Space);
    let settled = |harness: &mut Harness<'_, App>| {
        std::thread::sleep(std::time::Duration::from_millis(400));
        harness.run_steps(2);
        n_renders(harness.state())
    };
    let n = settled(&mut harness);
    assert_eq!(settled(&mut harness), n, "Space pauses");
    press(&mut harness, Key::Space);
    assert_eq!(n_of_film(harness.state()), before, "the film rests");
    click(&mut harness, "Iterations a render: 1");
    wait(&mut harness, |app| {
        of(app).found().is_some_and(|found| found.n_iterations == 1)
    });
    press(&mut harness, Key::Escape);
    let app = harness.state();
    assert_eq!(app.viewing.views.shown().id, "picture");
    assert!(of(app).found.is_none(), "memory is given back");
    assert_eq!(app.session.link.n_starts(), 1, "a view never restarts");
}

#[test]
fn a_method_without_a_radius_is_refused_in_a_sentence() {
    let mut harness = live((48, 48), "pt-mis");
    harness.key_press_modifiers(egui::Modifiers::SHIFT, Key::B);
    harness.run_steps(2);
    let app = harness.state();
    assert_eq!(app.viewing.views.shown().id, "picture");
    let said: Vec<_> = app.shell.notices.texts().collect();
    assert!(
        said.iter()
            .any(|text| text.contains("choose pm, ppm or vcm")),
        "{said:?}"
    );
}

#[test]
fn what_cannot_be_measured_is_said_in_place_of_the_map() {
    let mut harness = live((48, 48), "pm");
    let setup = &mut harness.state_mut().session.setup;
    let method = setup.method();
    let values = &mut setup.values[setup.method];
    values
        .set(method.parameters, "nearest", "40")
        .expect("a parameter");
    setup.is_changed = true;
    harness.key_press_modifiers(egui::Modifiers::SHIFT, Key::B);
    harness.run_steps(2);
    wait(&mut harness, |app| of(app).found.is_some());
    harness.run_steps(2);
    assert!(of(harness.state()).found().is_none());
    let n = harness.query_all_by_label_contains("set it to 0").count();
    assert!(n > 0);
}
