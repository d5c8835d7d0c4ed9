//! Methods that race in place of the picture.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_picture::compare::compare;
use neumann_picture::race::Measure;
use neumann_viewer::app::App;
use neumann_viewer::views::race::RaceView;

use crate::support::app_with_race;
use crate::{click, harness_of, live, press, wait};

const SIZE: [f32; 2] = [1280.0, 720.0];

fn race(app: &App) -> &RaceView {
    app.viewing.views.get().expect("a row of VIEWS")
}

/// True once each method has so many points.
fn has_points(app: &App, n: usize) -> bool {
    let standings = &race(app).report.standings;
    !standings.is_empty() && standings.iter().all(|s| s.curve.len() >= n)
}

fn n_of_film(app: &App) -> u32 {
    app.session
        .link
        .read(|published| published.film.n_iterations())
}

#[test]
fn one_key_races_three_methods_by_equal_time_and_their_errors_are_those_of_compare() {
    let mut harness = live((48, 48), "pt-nee");
    press(&mut harness, Key::K);
    wait(&mut harness, |app| has_points(app, 4));
    // Once an iteration is a small part of it, all have had the same time.
    wait(&mut harness, |app| {
        let seconds = || race(app).report.standings.iter().map(|s| s.seconds);
        let least = seconds().fold(f64::INFINITY, f64::min);
        let most = seconds().fold(0.0, f64::max);
        most > 0.5 && most - least < 0.03 * most
    });
    let view = race(harness.state());
    let report = &view.report;
    let names: Vec<_> = report.standings.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["pt-bsdf", "pt-nee", "pt-mis"]);
    let reference = report.reference.as_ref().expect("a reference");
    let display = harness.state().viewing.settings.display();
    for standing in &report.standings {
        let image = standing.image.as_ref().expect("a picture");
        let compared = compare(image, reference, &display).expect("pictures of one size");
        let last = standing.curve.last().expect("a point");
        assert_eq!(last.comparison, compared, "{}", standing.name);
    }
    // All of it is told.
    for label in [
        "racer 1: pt-bsdf",
        "picture by pt-mis",
        "picture by reference",
        "quality",
    ] {
        assert!(harness.query_by_label(label).is_some(), "{label}");
    }
    let n = harness
        .query_all_by_label_contains("time to relMSE")
        .count();
    assert_eq!(n, 1);
    click(&mut harness, "error: FLIP");
    assert_eq!(race(harness.state()).measure, Measure::Flip);
    let n = harness.query_all_by_label_contains("time to FLIP").count();
    assert_eq!(n, 1);
}

#[test]
fn the_film_rests_while_methods_race_and_goes_on_where_it_was() {
    let mut harness = live((48, 48), "pt-nee");
    press(&mut harness, Key::K);
    wait(&mut harness, |app| has_points(app, 1));
    let before = n_of_film(harness.state());
    wait(&mut harness, |app| has_points(app, 3));
    let app = harness.state();
    assert_eq!(n_of_film(app), before, "it rests");
    assert!(!app.session.link.is_paused(), "nobody has paused it");
    assert_eq!(app.session.link.n_starts(), 1);
    press(&mut harness, Key::Escape);
    let app = harness.state();
    assert_eq!(app.viewing.views.shown().id, "picture");
    assert!(
        race(app).report.standings.is_empty(),
        "memory is given back"
    );
    assert!(n_of_film(app) >= before, "no sample is lost");
    wait(&mut harness, |app| n_of_film(app) > before);
    assert_eq!(
        harness.state().session.link.n_starts(),
        1,
        "a view never restarts"
    );
    // A pause is one of the race as well.
    press(&mut harness, Key::K);
    wait(&mut harness, |app| has_points(app, 2));
    press(&mut harness, Key::Space);
    let seconds = |app: &App| {
        race(app)
            .report
            .standings
            .iter()
            .map(|s| s.seconds)
            .sum::<f64>()
    };
    let settled = |harness: &mut Harness<'_, App>| {
        std::thread::sleep(Duration::from_millis(300));
        harness.run_steps(2);
        seconds(harness.state())
    };
    let paused_at = settled(&mut harness);
    assert_eq!(settled(&mut harness), paused_at);
    press(&mut harness, Key::Space);
    wait(&mut harness, |app| seconds(app) > paused_at);
    press(&mut harness, Key::K);
    // What was paused before stays so.
    press(&mut harness, Key::Space);
    press(&mut harness, Key::K);
    press(&mut harness, Key::K);
    assert!(harness.state().session.link.is_paused());
}

#[test]
fn a_change_begins_the_race_anew() {
    let mut harness = live((48, 48), "pt-nee");
    press(&mut harness, Key::K);
    wait(&mut harness, |app| has_points(app, 3));
    let n_points = |app: &App| race(app).report.standings[0].curve.len();
    // Another method of the picture is of no account.
    press(&mut harness, Key::CloseBracket);
    assert!(n_points(harness.state()) >= 3);
    let deeper = |app: &mut App| {
        app.session.setup.max_bounces = 2;
        app.session.setup.is_changed = true;
    };
    deeper(harness.state_mut());
    harness.run_steps(2);
    std::thread::sleep(Duration::from_millis(200));
    harness.run_steps(2);
    let standings = &race(harness.state()).report.standings;
    assert!(
        standings.iter().all(|s| s.curve.len() < 3),
        "it begins anew"
    );
    wait(&mut harness, |app| has_points(app, 1));
}

#[test]
fn methods_are_changed_added_and_taken_away() {
    let mut harness = live((48, 48), "pt-nee");
    press(&mut harness, Key::K);
    harness.run_steps(2);
    click(&mut harness, "Add method");
    assert!(harness.query_by_label("racer 4: bdpt").is_some());
    assert!(
        harness.query_by_label("Add method").is_none(),
        "four at most"
    );
    click(&mut harness, "racer 1: pt-bsdf");
    click(&mut harness, "lt");
    assert!(harness.query_by_label("racer 1: lt").is_some());
    // Parameters of its own.
    click(&mut harness, "racer 3: pt-mis");
    let field = "method:parameter=value";
    harness.get_by_label(field).focus();
    harness.run_steps(1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.get_by_label(field).type_text("pt-mis:roulette=of");
    harness.run_steps(1);
    press(&mut harness, Key::Enter);
    let n = harness.query_all_by_label_contains("roulette").count();
    assert!(n > 0, "it says what is wrong");
    harness.get_by_label(field).focus();
    harness.run_steps(1);
    harness.get_by_label(field).type_text("f");
    harness.run_steps(1);
    press(&mut harness, Key::Enter);
    assert!(
        harness
            .query_by_label("racer 3: pt-mis:roulette=off")
            .is_some()
    );
    for n_left in [3, 2] {
        harness.run_steps(1);
        let last = harness.query_all_by_label_contains("racer 2: ").next();
        last.expect("a button").click();
        harness.run_steps(3);
        click(&mut harness, "Remove method");
        assert_eq!(race(harness.state()).entries.len(), n_left);
    }
    let first = harness.query_all_by_label_contains("racer 1: ").next();
    first.expect("a button").click();
    harness.run_steps(3);
    assert!(
        harness.query_by_label("Remove method").is_none(),
        "two at least"
    );
    press(&mut harness, Key::Escape);
    assert_eq!(
        harness.state().viewing.views.shown().id,
        "race",
        "one step back"
    );
}

/// A folder of its own.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("neumann-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

#[test]
fn a_reference_is_kept_for_the_next_race_and_a_broken_one_is_rendered_anew() {
    let folder = folder("race-cache");
    let mut harness = live((48, 48), "pt-nee");
    let view = harness.state_mut().viewing.views.get_mut::<RaceView>();
    view.expect("a row of VIEWS").cache = Some(folder.clone());
    let files = || -> Vec<PathBuf> {
        let entries = std::fs::read_dir(&folder).into_iter().flatten();
        entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .collect()
    };
    press(&mut harness, Key::K);
    wait(&mut harness, |_| !files().is_empty());
    press(&mut harness, Key::K);
    let said = |app: &App, words: &str| race(app).report.reference_words.contains(words);
    press(&mut harness, Key::K);
    wait(&mut harness, |app| said(app, "from the cache"));
    press(&mut harness, Key::K);
    std::thread::sleep(Duration::from_millis(300));
    for file in files() {
        std::fs::write(file, "no picture at all").expect("a file");
    }
    press(&mut harness, Key::K);
    wait(&mut harness, |app| has_points(app, 1));
    assert!(!said(harness.state(), "from the cache"));
    press(&mut harness, Key::K);
    let _ = std::fs::remove_dir_all(&folder);
}

#[test]
fn what_is_shown_is_enlarged_and_saved_with_its_curves() {
    let mut harness = harness_of(SIZE, app_with_race());
    press(&mut harness, Key::K);
    let (w, h) = {
        let app = harness.state();
        let image = app.viewing.views.image(&app.session, &app.viewing.settings);
        let image = image.expect("there is something to save");
        assert_eq!(image.name, "race");
        let pixels = (image.pixels)();
        (pixels.width, pixels.height)
    };
    assert!(w > 4 * 96 && h > 96 + 300, "pictures and curves: {w}x{h}");
    let n = harness.query_all_by_label_contains("pt-mis 0.98 s").count();
    assert_eq!(n, 1, "time to the worst error");
    click(&mut harness, "picture by pt-mis");
    assert_eq!(race(harness.state()).enlarged, Some(2));
    // Another one right of a line, which the arrows move.
    click(&mut harness, "wipe with: reference");
    let at = |harness: &Harness<'_, App>| race(harness.state()).wipe.map(|w| (w.with, w.at));
    assert_eq!(at(&harness), Some((3, 0.5)));
    harness.get_by_label("wipe line").focus();
    harness.run_steps(3);
    press(&mut harness, Key::ArrowLeft);
    assert_eq!(at(&harness), Some((3, 0.48)));
    let n = harness
        .query_all_by_label_contains("wipe with: pt-mis")
        .count();
    assert_eq!(n, 0, "not with itself");
    click(&mut harness, "wipe with: alone");
    assert_eq!(at(&harness), None);
    press(&mut harness, Key::Escape);
    assert_eq!(race(harness.state()).enlarged, None);
    assert_eq!(harness.state().viewing.views.shown().id, "race");
    // The arrows choose the quality, and Backspace gives it back.
    harness.get_by_label("quality").focus();
    harness.run_steps(3);
    press(&mut harness, Key::ArrowDown);
    assert!(race(harness.state()).quality.is_some());
    press(&mut harness, Key::Backspace);
    assert_eq!(race(harness.state()).quality, None);
}

#[test]
fn the_windows_own_reference_is_what_methods_are_judged_by() {
    let mut harness = live((48, 48), "pt-nee");
    press(&mut harness, Key::H);
    harness.state_mut().shell.refer_to_held(0);
    harness.run_steps(3);
    press(&mut harness, Key::K);
    wait(&mut harness, |app| has_points(app, 1));
    let report = &race(harness.state()).report;
    assert!(
        report.reference_words.starts_with("A, pt-nee"),
        "{}",
        report.reference_words
    );
    let held = harness.state().session.picture.held[0].as_ref().expect("A");
    let reference = report.reference.as_ref().expect("a reference");
    assert_eq!(reference.pixels, *held.pixels);
}

#[test]
fn a_race_ends_at_once() {
    let mut harness = live((48, 48), "pt-nee");
    press(&mut harness, Key::K);
    wait(&mut harness, |app| has_points(app, 1));
    let image = race(harness.state()).report.standings[0].image.clone();
    let image = Arc::downgrade(&image.expect("a picture"));
    let start = Instant::now();
    press(&mut harness, Key::K);
    while image.strong_count() > 0 {
        assert!(start.elapsed() < Duration::from_secs(2), "it goes on");
        std::thread::sleep(Duration::from_millis(5));
    }
    let took = start.elapsed();
    // On an idle machine it takes a few milliseconds.
    assert!(took < Duration::from_millis(900), "{took:?}");
}
