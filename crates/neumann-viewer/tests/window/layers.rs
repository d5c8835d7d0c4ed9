//! Layers of expressions and lights: by keyboard and pointer, live, without rendering anew.

use std::sync::Arc;

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_core::film::View as Part;
use neumann_core::radiometry::Rgb;
use neumann_core::render::StopRule;
use neumann_core::scene::Scene;
use neumann_core::scene::builtin::builtin;
use neumann_viewer::app::App;
use neumann_viewer::display::layers::ShownLayer;
use neumann_viewer::options::ViewOptions;
use neumann_viewer::render_link::RenderLink;
use neumann_viewer::views::layers::LayersView;

use crate::support::app_on;
use crate::{click, harness_of, press, wait};

fn view(app: &App) -> &LayersView {
    app.viewing.views.get().expect("a row of VIEWS")
}

fn n_kept(app: &App) -> u32 {
    view(app).film().map_or(0, |film| film.n_iterations())
}

fn shown(harness: &Harness<'_, App>) -> ShownLayer {
    harness.state().viewing.settings.layers.shown
}

/// The view on a scene of three lamps.
fn live(size: [f32; 2]) -> Harness<'static, App> {
    let link = RenderLink::live(Some(1), || {}).expect("a thread");
    let options = ViewOptions {
        size: Some((32, 24)),
        ..ViewOptions::default()
    };
    let mut app = app_on(link, options);
    let lamps = builtin("lamps").expect("a built-in scene");
    let lamps = lamps.load().expect("a scene as it comes");
    app.take_scene("lamps".to_owned(), Arc::new(Scene::build(&lamps)));
    app.session.setup.stop = StopRule::Iterations(6);
    let mut harness = harness_of(size, app);
    wait(&mut harness, |app| app.session.picture.stats.is_done);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::V);
    harness.run_steps(2);
    assert_eq!(harness.state().viewing.views.shown().id, "layers");
    // Iterations that were done are run once more.
    wait(&mut harness, |app| n_kept(app) == 6);
    harness
}

fn mean(pixels: &[Rgb]) -> f64 {
    let sum: f64 = pixels
        .iter()
        .map(|value| f64::from(value.luminance()))
        .sum();
    sum / pixels.len() as f64
}

fn mean_shown(harness: &Harness<'_, App>) -> f64 {
    mean(view(harness.state()).pixels().expect("a picture"))
}

#[test]
fn arrows_choose_layers_and_digits_terms() {
    let mut harness = live([1280.0, 720.0]);
    let all = mean_shown(&harness);
    press(&mut harness, Key::ArrowUp);
    assert_eq!(shown(&harness), ShownLayer::Expression(2), "caustics");
    press(&mut harness, Key::ArrowUp);
    press(&mut harness, Key::ArrowUp);
    assert_eq!(shown(&harness), ShownLayer::Expression(0));
    let direct = mean_shown(&harness);
    for _ in 0..3 {
        press(&mut harness, Key::ArrowDown);
    }
    press(&mut harness, Key::Num1);
    assert_eq!(shown(&harness), ShownLayer::Mix);
    let first_bounce = mean_shown(&harness);
    assert!(
        (first_bounce / direct - 1.0).abs() < 1e-5,
        "{direct} {first_bounce}"
    );
    press(&mut harness, Key::L);
    let mut lights = Vec::new();
    for group in 0..3 {
        press(&mut harness, Key::ArrowDown);
        assert_eq!(shown(&harness), ShownLayer::Light(group));
        lights.push(mean_shown(&harness));
    }
    let sum: f64 = lights.iter().sum();
    assert!((sum / all - 1.0).abs() < 1e-5, "{lights:?} for {all}");
    assert_eq!(
        harness.state().session.link.n_starts(),
        1,
        "nothing restarts"
    );
    press(&mut harness, Key::Escape);
    harness.run_steps(2);
    assert!(
        harness.state().session.link.kept_classes().is_none(),
        "it costs nothing"
    );
}

#[test]
fn lights_are_mixed_without_rendering_anew() {
    let mut harness = live([1280.0, 900.0]);
    let all = mean_shown(&harness);
    let layers = |harness: &mut Harness<'_, App>, name: &str, factor: Rgb| {
        let layers = &mut harness.state_mut().viewing.settings.layers;
        layers.mix.insert(name.to_owned(), factor);
        harness.run_steps(2);
    };
    layers(&mut harness, "sconce bulb", Rgb::BLACK);
    let without = mean_shown(&harness);
    layers(&mut harness, "sconce bulb", Rgb::splat(2.0));
    let twice = mean_shown(&harness);
    assert!(without < 0.9 * all, "{without} of {all}");
    assert!((without + twice - 2.0 * all).abs() < 1e-5 * all);
    assert_eq!(
        harness.state().session.link.n_starts(),
        1,
        "nothing restarts"
    );
    let app = harness.state();
    let saved = app.viewing.views.image(&app.session, &app.viewing.settings);
    assert_eq!(
        saved.map(|saved| saved.name).as_deref(),
        Some("All-light-mixed")
    );
    click(&mut harness, "As rendered");
    assert!((mean_shown(&harness) / all - 1.0).abs() < 1e-6);
    let part = harness.state().viewing.settings.part;
    assert_eq!(part, Part::Total);
}

#[test]
fn expressions_are_added_and_taken_away() {
    let mut harness = live([1280.0, 720.0]);
    let field = harness.get_by_label("glints = L S+ D E");
    field.focus();
    harness.run_steps(2);
    let field = harness.get_by_label("glints = L S+ D E");
    field.type_text("two = L D X E");
    harness.run_steps(2);
    click(&mut harness, "Add");
    assert!(
        harness
            .query_by_label_contains("'X' is no bounce")
            .is_some()
    );
    let texts =
        |harness: &Harness<'_, App>| harness.state().viewing.settings.layers.expressions.clone();
    assert_eq!(texts(&harness).len(), 3);
    for _ in 0..4 {
        press(&mut harness, Key::Backspace);
    }
    let field = harness.get_by_label("glints = L S+ D E");
    field.focus();
    harness.run_steps(2);
    for _ in 0..4 {
        press(&mut harness, Key::Backspace);
    }
    let field = harness.get_by_label("glints = L S+ D E");
    field.type_text("D E");
    harness.run_steps(2);
    click(&mut harness, "Add");
    assert_eq!(
        texts(&harness).last().map(String::as_str),
        Some("two=L DD E")
    );
    assert_eq!(shown(&harness), ShownLayer::Expression(3));
    wait(&mut harness, |app| n_kept(app) == 6);
    assert!(mean_shown(&harness) > 0.0);
    click(&mut harness, "Remove expression");
    assert_eq!(texts(&harness).len(), 3);
    assert_eq!(
        harness.state().session.link.n_starts(),
        1,
        "nothing restarts"
    );
}

#[test]
fn every_size_has_room() {
    for size in [[640.0, 420.0], [1000.0, 640.0]] {
        let harness = live(size);
        for name in ["caustics, ", "All light, mixed, ", "sconce bulb, "] {
            assert!(harness.query_by_label_contains(name).is_some(), "{name}");
        }
    }
}
