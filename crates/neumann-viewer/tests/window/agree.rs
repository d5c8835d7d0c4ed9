//! The agreement map: two methods that render in turn while one looks.

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_core::film::View as Part;
use neumann_picture::agreement::{FEWEST, Grain};
use neumann_viewer::app::App;
use neumann_viewer::views::agree::{AgreeView, Found};
use neumann_viewer::views::entry::Entry;

use crate::{click, harness, live, press, wait};

fn of(app: &App) -> &AgreeView {
    app.viewing.views.get().expect("a row of VIEWS")
}

fn found(app: &App) -> Option<&Found> {
    of(app).found.as_deref()
}

fn n_batches(app: &App) -> usize {
    found(app).map_or(0, |found| found.n_batches)
}

/// The view once there is a verdict on the methods of these ids.
fn judged(ids: [&str; 2]) -> Harness<'static, App> {
    let mut harness = live((48, 48), ids[0]);
    press(&mut harness, Key::Y);
    assert_eq!(harness.state().viewing.views.shown().id, "agree");
    let name = |app: &App, i: usize| of(app).entries[i].entrant(&app.session.setup).name;
    assert_eq!(name(harness.state(), 0), ids[0]);
    if name(harness.state(), 1) != ids[1] {
        let label = format!("method 2: {}", name(harness.state(), 1));
        click(&mut harness, &label);
        click(&mut harness, ids[1]);
    }
    wait(&mut harness, |app| n_batches(app) >= FEWEST + 4);
    harness.run_steps(2);
    harness
}

/// How the whole picture is saved.
fn saved(app: &App) -> (String, Vec<[u8; 3]>) {
    let views = &app.viewing.views;
    let shown = views.image(&app.session, &app.viewing.settings);
    let shown = shown.expect("something to save");
    (shown.name, (shown.pixels)().pixels)
}

#[test]
fn what_agrees_is_grey_and_the_film_rests_meanwhile() {
    let mut harness = judged(["pt-mis", "bdpt"]);
    let n_of_film = |app: &App| app.session.link.read(|p| p.film.n_iterations());
    let before = n_of_film(harness.state());
    let agreement = &found(harness.state()).expect("a verdict").agreement;
    assert!(agreement.is_judged() && agreement.holds());
    let n = harness.query_all_by_label("T2: noise alone").count();
    assert_eq!(n, 1, "a row of the table");
    let caption = harness.query_all_by_label_contains("by each method: noise alone");
    assert!(caption.count() > 0);
    let n = n_batches(harness.state());
    wait(&mut harness, |app| n_batches(app) > n);
    assert_eq!(n_of_film(harness.state()), before, "it rests");
    press(&mut harness, Key::Escape);
    let app = harness.state();
    assert_eq!(app.viewing.views.shown().id, "picture");
    assert!(of(app).found.is_none(), "memory is given back");
    wait(&mut harness, |app| n_of_film(app) > before);
    assert_eq!(harness.state().session.link.n_starts(), 1);
}

#[test]
fn a_bias_is_told_in_its_bounce_and_digits_choose_its_map() {
    // Without light between diffuse surfaces.
    let mut harness = judged(["pt-mis", "drt"]);
    let agreement = &found(harness.state()).expect("a verdict").agreement;
    assert!(!agreement.holds());
    for (key, part, label) in [
        (Key::Num1, Part::Term(1), "T1: noise alone"),
        (Key::Num2, Part::Term(2), "T2: the methods differ"),
        (Key::L, Part::Total, "L: the methods differ"),
    ] {
        press(&mut harness, key);
        assert_eq!(harness.state().viewing.settings.part, part);
        let row = harness.query_all_by_label(label);
        assert_eq!(row.count(), 1, "{label}");
    }
    click(&mut harness, "T2: the methods differ");
    assert_eq!(harness.state().viewing.settings.part, Part::Term(2));
    let words = "drt found no light at all";
    assert!(harness.query_all_by_label_contains(words).count() > 0);
    press(&mut harness, Key::Num0);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::Num2);
    harness.run_steps(2);
    let words = "partial sums are not compared";
    assert!(harness.query_by_label_contains(words).is_some());
}

#[test]
fn what_is_saved_is_the_sheet_of_the_command_with_the_chosen_grain() {
    let mut harness = judged(["pt-mis", "drt"]);
    press(&mut harness, Key::Space);
    let settled = |harness: &mut Harness<'_, App>| {
        std::thread::sleep(std::time::Duration::from_millis(400));
        harness.run_steps(2);
        n_batches(harness.state())
    };
    let n = settled(&mut harness);
    assert_eq!(settled(&mut harness), n, "Space pauses");
    assert!(harness.query_by_label_contains("paused (Space)").is_some());
    let (name, blocks) = saved(harness.state());
    assert_eq!(name, "agree");
    assert_eq!(saved(harness.state()).1, blocks);
    click(&mut harness, "Coloured: pixels");
    assert_eq!(of(harness.state()).grain, Grain::Pixels);
    assert_ne!(saved(harness.state()).1, blocks);
    press(&mut harness, Key::Space);
    wait(&mut harness, |app| n_batches(app) > n);
    // Longer batches are others.
    click(&mut harness, "Iterations a batch: 4");
    wait(&mut harness, |app| {
        found(app).is_some_and(|f| f.n_iterations == 4)
    });
}

#[test]
fn a_method_is_held_against_one_that_sees_the_same_and_esc_closes_its_menu_first() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::Y);
    let entries = of(harness.state()).entries.clone();
    assert_eq!(entries.len(), 2);
    assert_ne!(entries[0], entries[1]);
    let label = {
        let app = harness.state();
        let name = entries[0].entrant(&app.session.setup).name;
        format!("method 1: {name}")
    };
    click(&mut harness, &label);
    assert!(
        harness
            .query_by_label_contains("method:parameter")
            .is_some()
    );
    press(&mut harness, Key::Escape);
    assert!(
        harness
            .query_by_label_contains("method:parameter")
            .is_none()
    );
    assert_eq!(harness.state().viewing.views.shown().id, "agree");
    // It stays who was chosen, as long as the method of the picture is among them.
    press(&mut harness, Key::Y);
    assert_eq!(harness.state().viewing.views.shown().id, "picture");
    press(&mut harness, Key::Y);
    assert_eq!(of(harness.state()).entries, entries);
    assert!(matches!(entries[0], Entry::OfPage(_)));
}
