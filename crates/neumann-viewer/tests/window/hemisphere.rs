//! The hemisphere over a surface point: which pixel, which term, by pointer and by keyboard.

use std::sync::Arc;

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_core::film::View as Part;
use neumann_core::render::hemisphere::Estimator;
use neumann_viewer::app::App;
use neumann_viewer::views::hemisphere::HemisphereView;

use crate::{harness, press, wait};

fn of(app: &App) -> &HemisphereView {
    app.viewing.views.get().expect("a row of VIEWS")
}

fn shown(harness: &Harness<'_, App>) -> &'static str {
    harness.state().viewing.views.shown().id
}

fn n_passes(app: &App) -> u32 {
    of(app).found().map_or(0, |found| found.n_passes())
}

/// The view once it has looked around for a while.
fn looking(size: [f32; 2]) -> Harness<'static, App> {
    let mut harness = harness(size);
    press(&mut harness, Key::U);
    assert_eq!(shown(&harness), "hemisphere");
    wait(&mut harness, |app| n_passes(app) >= 8);
    harness
}

#[test]
fn estimates_go_on_until_another_pixel_is_chosen() {
    let mut harness = looking([1280.0, 720.0]);
    assert_eq!(of(harness.state()).pixel, Some([48, 48]), "the middle");
    let before = n_passes(harness.state());
    wait(&mut harness, |app| n_passes(app) > before);
    harness.run_steps(2);
    for name in ["BSDF sampling: ", "light sampling: ", "MIS: ", "pictures: "] {
        assert!(harness.query_by_label_contains(name).is_some(), "{name}");
    }
    let found = of(harness.state()).found().expect("a surface");
    let (mis, pictures) = (
        found.estimate_by(Estimator::Mis).measured(),
        found.integral(),
    );
    let apart = f64::from((mis.mean.luminance() - pictures.mean.luminance()).abs());
    let bound = mis.interval.unwrap_or(0.0) + pictures.interval.unwrap_or(0.0);
    assert!(apart < 3.0 * bound, "{mis:?} {pictures:?}");
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowRight);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowUp);
    harness.run_steps(2);
    assert_eq!(of(harness.state()).pixel, Some([49, 47]));
    wait(&mut harness, |app| n_passes(app) >= 1);
    let n_starts = harness.state().session.link.n_starts();
    assert_eq!(n_starts, 1, "a view never restarts");
    press(&mut harness, Key::Escape);
    assert_eq!(shown(&harness), "picture");
    assert!(
        of(harness.state()).found().is_none(),
        "memory is given back"
    );
}

#[test]
fn digits_choose_what_arrives() {
    let mut harness = looking([1280.0, 720.0]);
    assert!(harness.query_by_label_contains("what arrives").is_none());
    press(&mut harness, Key::Num1);
    harness.run_steps(2);
    assert_eq!(harness.state().viewing.settings.part, Part::Term(1));
    assert!(harness.query_by_label_contains("what arrives").is_some());
}

/// Of another term another sheet is saved, since other light arrives.
#[test]
fn what_is_saved_is_of_the_chosen_term() {
    let mut harness = looking([1280.0, 720.0]);
    let found = Arc::clone(of(harness.state()).found().expect("a surface"));
    let saved = |harness: &Harness<'_, App>| {
        let app = harness.state();
        let image = app.viewing.views.image(&app.session, &app.viewing.settings);
        let image = image.expect("there is something to save");
        assert_eq!(image.name, "hemisphere-48-48");
        (image.pixels)()
    };
    let all = saved(&harness);
    press(&mut harness, Key::Num0);
    let first = saved(&harness);
    assert_eq!((all.width, all.height), (first.width, first.height));
    // Only the first picture and the fourth depend on it; the others go on, though.
    let pairs = all.pixels.iter().zip(&first.pixels);
    let n = pairs.filter(|(a, b)| a != b).count();
    assert!(
        n > 500,
        "{n} pixels differ; {} directions",
        found.n_passes()
    );
}

#[test]
fn every_size_has_room_for_pictures_and_figures() {
    for size in [[640.0, 420.0], [1000.0, 640.0]] {
        let harness = looking(size);
        let pictures = harness.query_all_by_label_contains(": white: ");
        assert_eq!(
            pictures.count(),
            6,
            "and the one that is shown as the picture is"
        );
    }
}
