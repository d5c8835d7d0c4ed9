//! The film keeps its samples whatever becomes of the window.

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_core::film::View;
use neumann_core::integrator::METHODS;
use neumann_core::render::StopRule;
use neumann_viewer::ViewOptions;
use neumann_viewer::app::App;
use neumann_viewer::render_link::RenderLink;
use neumann_viewer::setup::FilmSize;

use crate::support::{app_of, app_on, published};
use crate::{click, harness, harness_of, press, wait};

#[test]
fn pausing_by_key_and_by_button() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::Space);
    assert!(harness.state().session.link.is_paused());
    click(&mut harness, "Resume rendering");
    assert!(!harness.state().session.link.is_paused());
    let n = harness.state().session.link.n_starts();
    press(&mut harness, Key::R);
    assert_eq!(harness.state().session.link.n_starts(), n + 1);
}

#[test]
fn stopping_after_iterations_does_not_restart() {
    let mut harness = harness([1280.0, 1300.0]);
    click(&mut harness, "Stop after: iterations");
    assert_eq!(
        harness.state().session.setup.stop,
        StopRule::Iterations(256)
    );
    assert_eq!(harness.state().session.link.n_starts(), 1);
}

/// A film that is worth something keeps its size, whatever becomes of the window; it gets another
/// one by wish, or where it begins anew anyway.
#[test]
fn panels_and_window_change_their_size_and_the_film_keeps_its_own() {
    let app = app_of(published(), ViewOptions::default());
    let mut harness = harness_of([1280.0, 720.0], app);
    let size = harness.state().session.setup.size;
    assert_eq!(size.0, size.1, "the camera of the scene asks for a square");
    assert!(size.1 > 400, "it fills the room: {size:?}");
    press(&mut harness, Key::Tab);
    std::thread::sleep(std::time::Duration::from_millis(250));
    harness.run_steps(2);
    harness.set_size(egui::vec2(1000.0, 640.0));
    harness.run_steps(2);
    std::thread::sleep(std::time::Duration::from_millis(250));
    harness.run_steps(2);
    let session = &harness.state().session;
    assert_eq!(session.setup.size, size);
    assert_eq!(session.link.n_starts(), 1);
    assert!(session.can_fit());

    // By wish, and the old picture is there meanwhile.
    harness.key_press_modifiers(Modifiers::SHIFT, Key::Z);
    harness.run_steps(3);
    let session = &harness.state().session;
    assert_eq!(session.setup.size, (640, 640));
    assert_eq!(session.link.n_starts(), 2);
    assert!(!session.can_fit());

    // Not while a picture is held, which the next one is to be compared with.
    press(&mut harness, Key::H);
    press(&mut harness, Key::Tab);
    press(&mut harness, Key::CloseBracket);
    assert_eq!(harness.state().session.setup.size, (640, 640));
    harness.state_mut().session.picture.held[0] = None;

    // With what begins anew anyway.
    assert_eq!(harness.state().session.setup.size, (640, 640));
    press(&mut harness, Key::CloseBracket);
    let room = harness.state().session.setup.size;
    assert!(room.1 < 640, "{room:?}");

    // Not if it is to stay.
    harness.state_mut().session.setup.film_size = FilmSize::Locked;
    press(&mut harness, Key::Tab);
    press(&mut harness, Key::CloseBracket);
    assert_eq!(harness.state().session.setup.size, room);
}

/// A film of a tenth of a second, which follows the room when that has come to rest.
fn app_with_young_film() -> App {
    let mut published = published();
    published.stats.seconds = 0.1;
    app_of(published, ViewOptions::default())
}

fn rest(harness: &mut Harness<'_, App>) {
    for _ in 0..2 {
        harness.run_steps(3);
        std::thread::sleep(std::time::Duration::from_millis(250));
    }
    harness.run_steps(3);
}

#[test]
fn text_grows_and_shrinks_and_even_a_young_film_stays() {
    let mut harness = harness_of([1280.0, 720.0], app_with_young_film());
    let size = harness.state().session.setup.size;
    let mut factor_after = |key: Key, n: usize| {
        for _ in 0..n {
            harness.key_press_modifiers(Modifiers::COMMAND, key);
            harness.run_steps(2);
        }
        rest(&mut harness);
        assert_eq!(harness.state().session.setup.size, size);
        assert_eq!(harness.state().session.link.n_starts(), 1);
        harness.ctx.zoom_factor()
    };
    assert!((factor_after(Key::Plus, 3) - 1.3).abs() < 1e-6);
    assert!((factor_after(Key::Minus, 5) - 0.8).abs() < 1e-6);
    assert!((factor_after(Key::Num0, 1) - 1.0).abs() < 1e-6);
    let most = factor_after(Key::Equals, 40);
    assert!(most > 2.0 && most < 3.0, "bars keep their room: {most}");
    assert!((factor_after(Key::Minus, 40) - 0.5).abs() < 1e-6);
    // The window's own size is another matter.
    harness.set_size(egui::vec2(1000.0, 640.0));
    rest(&mut harness);
    assert_ne!(harness.state().session.setup.size, size);
}

#[test]
fn presenting_shows_method_and_filmstrip_alone_and_large_and_keeps_the_samples() {
    let mut harness = harness_of([1920.0, 1080.0], app_with_young_film());
    let has = |harness: &Harness<'_, App>, label: &str| harness.query_by_label(label).is_some();
    let method = format!("method: {}", METHODS[3].name);
    assert_eq!(harness.state().session.setup.method(), METHODS[3]);
    press(&mut harness, Key::F5);
    rest(&mut harness);
    assert!(harness.ctx.zoom_factor() >= 2.0);
    assert!(has(&harness, &method) && has(&harness, "term T^2 L_e"));
    assert!(!has(&harness, "Pause rendering") && !has(&harness, "Scene"));
    click(&mut harness, "sum up to 3");
    assert_eq!(harness.state().viewing.settings.part, View::Upto(3));
    assert_eq!(harness.state().session.link.n_starts(), 1);
    press(&mut harness, Key::Escape);
    rest(&mut harness);
    assert!(has(&harness, "Pause rendering") && !has(&harness, &method));
    assert_eq!(harness.ctx.zoom_factor(), 1.0);
    assert_eq!(harness.state().session.link.n_starts(), 1);
    // A page that is asked for is shown.
    press(&mut harness, Key::F5);
    press(&mut harness, Key::F2);
    assert!(!harness.state().shell.is_presenting);
}

/// The picture of a film that gets another size stays until the new film has as many iterations.
#[test]
fn the_old_picture_stays_until_the_new_film_has_caught_up() {
    let link = RenderLink::live(Some(1), || {}).expect("a thread");
    let mut harness = harness_of([640.0, 420.0], app_on(link, ViewOptions::default()));
    let is_old = |app: &App| app.session.picture.stats.seconds > 1.0;
    wait(&mut harness, |app| app.session.is_current() && is_old(app));
    harness.set_size(egui::vec2(700.0, 440.0));
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::Z);
    harness.run_steps(2);
    let session = &harness.state().session;
    let (size, n_iterations) = (session.picture.size, session.picture.stats.n_iterations);
    assert_ne!(session.setup.size, size);
    let (_, of) = session.catching_up().expect("the old picture stays");
    assert_eq!(of, n_iterations);

    wait(&mut harness, |app| app.session.catching_up().is_none());
    harness.run_steps(2);
    let session = &harness.state().session;
    assert_eq!(session.picture.size, session.setup.size);
    assert!(session.picture.stats.n_iterations >= n_iterations);
}

#[test]
fn display_keys_do_not_render_anew() {
    let mut harness = harness([1280.0, 720.0]);
    for key in [Key::E, Key::T, Key::C, Key::Plus, Key::Plus, Key::X, Key::I] {
        press(&mut harness, key);
    }
    let app = harness.state();
    assert!((app.viewing.settings.exposure_ev - (1.0 / 3.0 - 2.0)).abs() < 1e-6);
    assert!(app.viewing.settings.is_false_colour && app.viewing.settings.is_wiping);
    assert!(app.viewing.settings.zoom.is_some());
    assert!(!app.viewing.settings.is_probing);
    assert_eq!(app.session.link.n_starts(), 1);
}
