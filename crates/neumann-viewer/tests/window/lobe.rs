//! Lobes of materials: which one, by pointer and by keyboard, and how they are plotted.

use std::sync::Arc;

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_core::scene::Scene;
use neumann_core::scene::builtin::builtin;
use neumann_picture::lobe::{Plotted, Radius};
use neumann_viewer::app::App;
use neumann_viewer::views::lobe::{Choice, LobeView};

use crate::{click, harness, press, wait};

fn of(app: &App) -> &LobeView {
    app.viewing.views.get().expect("a row of VIEWS")
}

fn shown(harness: &Harness<'_, App>) -> &'static str {
    harness.state().viewing.views.shown().id
}

fn is_complete(app: &App) -> bool {
    of(app)
        .found()
        .is_some_and(|found| !found.albedo.is_empty())
}

/// The view once it knows all of what it shows; of a scene with several materials.
pub(crate) fn looking(size: [f32; 2]) -> Harness<'static, App> {
    let mut harness = harness(size);
    let description = builtin("sky").expect("a built-in scene");
    let description = description.load().expect("a scene as it comes");
    let scene = Arc::new(Scene::build(&description));
    harness.state_mut().take_scene("sky".to_owned(), scene);
    harness.run_steps(4);
    press(&mut harness, Key::O);
    assert_eq!(shown(&harness), "lobe");
    wait(&mut harness, is_complete);
    harness.run_steps(2);
    harness
}

/// Opens the list of materials.
pub(crate) fn open_list(harness: &mut Harness<'_, App>) {
    let row = format!("Material: {}", name_now(harness));
    click(harness, &row);
}

fn name_now(harness: &Harness<'_, App>) -> String {
    let app = harness.state();
    let material = of(app).surface().expect("a surface").material;
    let scene = &app.session.setup.open.as_ref().expect("a scene").scene;
    scene.materials()[material].parameters().name.clone()
}

#[test]
fn materials_are_stepped_through_and_chosen_by_keyboard() {
    let mut harness = looking([1280.0, 900.0]);
    let first = of(harness.state()).choice;
    assert_eq!(first, Some(Choice::Pixel([48, 48])), "the middle");
    let n = harness
        .state()
        .session
        .setup
        .open
        .as_ref()
        .expect("a scene");
    let n = n.scene.materials().len();
    let begun = of(harness.state()).surface().expect("a surface").material;
    for step in 1..=n {
        press(&mut harness, Key::ArrowRight);
        let wanted = (begun + step) % n;
        assert_eq!(of(harness.state()).choice, Some(Choice::Material(wanted)));
        wait(&mut harness, |app| {
            of(app).surface().map(|s| s.material) == Some(wanted) && is_complete(app)
        });
        harness.run_steps(1);
        let label = format!("Material: {}", name_now(&harness));
        assert!(harness.query_by_label(&label).is_some(), "{label}");
    }
    // Pixels are moved through as in other views.
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowDown);
    harness.run_steps(2);
    assert_eq!(of(harness.state()).choice, Some(Choice::Pixel([48, 49])));
    let starts = harness.state().session.link.n_starts();
    open_list(&mut harness);
    click(&mut harness, "chrome");
    wait(&mut harness, |app| {
        let found = of(app).found();
        found.is_some_and(|f| f.reciprocity.is_none() && !f.albedo.is_empty())
    });
    harness.run_steps(2);
    let mirrors = harness.query_all_by_label_contains(", mirror-like ");
    assert_eq!(mirrors.count(), 4, "an arrow in each plot");
    assert_eq!(
        harness.state().session.link.n_starts(),
        starts,
        "a view never restarts"
    );
    press(&mut harness, Key::Escape);
    assert_eq!(shown(&harness), "picture");
    assert!(
        of(harness.state()).found().is_none(),
        "memory is given back"
    );
}

#[test]
fn the_list_closes_first() {
    let mut harness = looking([1280.0, 900.0]);
    open_list(&mut harness);
    assert!(harness.query_by_label("brushed copper").is_some());
    press(&mut harness, Key::Escape);
    assert!(harness.query_by_label("brushed copper").is_none());
    assert_eq!(shown(&harness), "lobe");
}

#[test]
fn plots_angles_and_turns_can_be_chosen() {
    let mut harness = looking([1280.0, 900.0]);
    click(&mut harness, "plot: f cos θ");
    click(&mut harness, "distance from the middle: log");
    let plot = of(harness.state()).plot;
    assert_eq!(
        (plot.plotted, plot.radius),
        (Plotted::Product, Radius::Logarithmic)
    );
    let cosines = harness.query_all_by_label_contains("polar plot of f cos θ");
    assert_eq!(cosines.count(), 4);
    let before = of(harness.state()).turn;
    let name = "lobe in space, viewer at 60°";
    harness.get_by_label(name).focus();
    harness.run_steps(1);
    press(&mut harness, Key::ArrowRight);
    press(&mut harness, Key::ArrowUp);
    let turn = of(harness.state()).turn;
    assert!(turn.yaw > before.yaw && turn.pitch > before.pitch);
    assert_eq!(
        of(harness.state()).choice,
        Some(Choice::Pixel([48, 48])),
        "no step"
    );
    harness.get_by_label("Angle 2").focus();
    harness.run_steps(1);
    press(&mut harness, Key::ArrowRight);
    let angle = of(harness.state()).angles[1];
    assert!(angle > 30.0, "{angle}");
    wait(&mut harness, |app| {
        of(app)
            .found()
            .is_some_and(|found| found.views[1].angle == angle)
    });
    let found = of(harness.state()).found().expect("lobes");
    assert!(!found.albedo.is_empty(), "the curve is kept");
}

#[test]
fn what_is_saved_is_what_is_plotted() {
    let mut harness = looking([1280.0, 900.0]);
    let saved = |harness: &Harness<'_, App>| {
        let app = harness.state();
        let image = app.viewing.views.image(&app.session, &app.viewing.settings);
        let image = image.expect("there is something to save");
        assert_eq!(image.name, format!("lobe-{}", name_now(harness)));
        (image.pixels)()
    };
    let plain = saved(&harness);
    click(&mut harness, "distance from the middle: log");
    let log = saved(&harness);
    assert_eq!((plain.width, plain.height), (log.width, log.height));
    let pairs = plain.pixels.iter().zip(&log.pixels);
    let n = pairs.filter(|(a, b)| a != b).count();
    assert!(n > 1000, "{n} pixels differ");
}

#[test]
fn every_size_has_all_four() {
    for size in [[640.0, 420.0], [1000.0, 640.0]] {
        let harness = looking(size);
        let plots = harness.query_all_by_label_contains("polar plot of f, viewer at ");
        assert_eq!(plots.count(), 4, "{size:?}");
        let curve = harness.query_all_by_label_contains("albedo over the angle: ");
        assert_eq!(curve.count(), 1, "{size:?}");
    }
}
