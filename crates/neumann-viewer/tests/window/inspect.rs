//! The inspector: which pixel, which path, which vertex, by pointer and by keyboard.

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_core::film::View as Part;
use neumann_viewer::app::App;
use neumann_viewer::views::inspect::InspectView;

use crate::{click, harness, press, wait};

fn of(app: &App) -> &InspectView {
    app.viewing.views.get().expect("a row of VIEWS")
}

fn shown(harness: &Harness<'_, App>) -> &'static str {
    harness.state().viewing.views.shown().id
}

/// The inspector once it has replayed all that the film has.
fn inspecting(size: [f32; 2]) -> Harness<'static, App> {
    let mut harness = harness(size);
    press(&mut harness, Key::Q);
    assert_eq!(shown(&harness), "inspect");
    wait(&mut harness, |app| of(app).found().n_iterations() == 64);
    harness
}

#[test]
fn a_pixel_is_replayed_up_to_what_the_film_has() {
    let mut harness = inspecting([1280.0, 720.0]);
    assert_eq!(of(harness.state()).pixel, Some([48, 48]), "the middle");
    let total = of(harness.state()).found().total().mean;
    assert!(total.luminance() > 0.0);
    assert!(
        harness
            .query_by_label("Pixel 48, 48: 64 iterations")
            .is_some()
    );
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowRight);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowUp);
    harness.run_steps(2);
    assert_eq!(of(harness.state()).pixel, Some([49, 47]));
    wait(&mut harness, |app| of(app).found().n_iterations() == 64);
    assert_eq!(
        harness.state().session.link.n_starts(),
        1,
        "a view never restarts"
    );
}

#[test]
fn paths_are_chosen_and_walked_by_arrows() {
    let mut harness = inspecting([1280.0, 720.0]);
    assert!(of(harness.state()).chosen().is_none());
    press(&mut harness, Key::ArrowDown);
    let brightest = of(harness.state()).found().paths()[0].1.value();
    let chosen = of(harness.state()).chosen().expect("the first").value();
    assert_eq!(chosen, brightest);
    press(&mut harness, Key::ArrowDown);
    let second = of(harness.state()).chosen().expect("the second").value();
    assert!(second.luminance() <= brightest.luminance());
    press(&mut harness, Key::ArrowRight);
    assert_eq!(of(harness.state()).list.vertex, 1);
    press(&mut harness, Key::ArrowLeft);
    press(&mut harness, Key::ArrowLeft);
    assert_eq!(of(harness.state()).list.vertex, 0, "the eye is the first");
    let part = harness.state().viewing.settings.part;
    assert_eq!(
        part,
        Part::Total,
        "arrows choose no other part of the series here"
    );
    press(&mut harness, Key::Escape);
    assert!(of(harness.state()).chosen().is_none());
    assert_eq!(shown(&harness), "inspect");
    press(&mut harness, Key::Escape);
    assert_eq!(shown(&harness), "picture");
    assert_eq!(
        of(harness.state()).found().n_iterations(),
        0,
        "memory is given back"
    );
}

#[test]
fn terms_and_expressions_choose_the_paths() {
    let mut harness = inspecting([1280.0, 720.0]);
    let bounces = |harness: &Harness<'_, App>| {
        let view = of(harness.state());
        let listed = view.listed().map(|path| path.contribution.bounce);
        let mut bounces: Vec<u32> = listed.collect();
        bounces.sort_unstable();
        bounces.dedup();
        bounces
    };
    assert!(bounces(&harness).len() > 2, "{:?}", bounces(&harness));
    press(&mut harness, Key::Num2);
    harness.run_steps(2);
    assert_eq!(bounces(&harness), [2]);
    press(&mut harness, Key::L);
    let views = &mut harness.state_mut().viewing.views;
    let view: &mut InspectView = views.get_mut().expect("a row of VIEWS");
    "L D E".clone_into(&mut view.list.only);
    harness.run_steps(2);
    assert_eq!(bounces(&harness), [1]);
    let views = &mut harness.state_mut().viewing.views;
    let view: &mut InspectView = views.get_mut().expect("a row of VIEWS");
    "L X E".clone_into(&mut view.list.only);
    harness.run_steps(2);
    let error = harness.query_by_label_contains("'X' is no bounce");
    assert!(error.is_some());
}

#[test]
fn what_is_saved_has_the_paths_that_are_drawn() {
    let mut harness = inspecting([1280.0, 720.0]);
    let saved = |harness: &Harness<'_, App>| {
        let app = harness.state();
        let image = app.viewing.views.image(&app.session, &app.viewing.settings);
        let image = image.expect("there is something to save");
        assert_eq!(image.name, "pixel-48-48");
        (image.pixels)()
    };
    // An expression that no path has leaves none to be drawn.
    let views = &mut harness.state_mut().viewing.views;
    let view: &mut InspectView = views.get_mut().expect("a row of VIEWS");
    "L G{60} E".clone_into(&mut view.list.only);
    harness.run_steps(2);
    let without = saved(&harness);
    let views = &mut harness.state_mut().viewing.views;
    let view: &mut InspectView = views.get_mut().expect("a row of VIEWS");
    view.list.only.clear();
    harness.run_steps(2);
    let with = saved(&harness);
    assert_eq!((with.width, with.height), (without.width, without.height));
    let pairs = with.pixels.iter().zip(&without.pixels);
    let n = pairs.filter(|(a, b)| a != b).count();
    assert!(n > 50, "{n} pixels differ");
}

#[test]
fn every_size_has_room_for_picture_and_figures() {
    for size in [[640.0, 420.0], [1000.0, 640.0]] {
        let mut harness = inspecting(size);
        press(&mut harness, Key::ArrowDown);
        click(&mut harness, "Fireflies");
        click(&mut harness, "Techniques");
        let techniques = harness.query_all_by_label_contains("s=0 t=2");
        assert!(techniques.count() > 0);
    }
}
