//! The window through its accessibility tree: what a person can press, and what follows.
//!
//! The renderer is replaced by a small film that never changes, so nothing here depends on time.

mod agree;
mod bias;
mod compared;
mod controls;
mod edits;
mod energy;
mod files;
mod film;
mod hemisphere;
mod histogram;
mod inspect;
mod kept_views;
mod layers;
mod lobe;
mod race;
mod region;
mod series;
#[path = "../support/mod.rs"]
mod support;
mod tev;
mod views;
mod words;

use egui::{Key, Pos2, Theme};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_viewer::ViewOptions;
use neumann_viewer::app::App;
use neumann_viewer::render_link::RenderLink;

use support::{app, app_on};

fn harness(size: [f32; 2]) -> Harness<'static, App> {
    harness_of(size, app())
}

fn harness_of(size: [f32; 2], app: App) -> Harness<'static, App> {
    let mut harness = Harness::builder()
        .with_size(size)
        .with_pixels_per_point(1.0)
        .with_theme(Theme::Dark)
        .build_ui_state(|ui, app: &mut App| app.ui(ui), app);
    harness.run_steps(4);
    harness
}

/// The window on a renderer with one thread, with a film of a few pixels.
fn live(size: (usize, usize), integrator: &str) -> Harness<'static, App> {
    let link = RenderLink::live(Some(1), || {}).expect("a thread");
    let options = ViewOptions {
        size: Some(size),
        integrator: Some(integrator.to_owned()),
        ..ViewOptions::default()
    };
    let mut harness = harness_of([1280.0, 720.0], app_on(link, options));
    wait(&mut harness, |app| {
        app.session.picture.stats.n_iterations > 3
    });
    harness
}

fn press(harness: &mut Harness<'_, App>, key: Key) {
    harness.key_press(key);
    harness.run_steps(2);
}

fn click(harness: &mut Harness<'_, App>, label: &str) {
    harness.get_by_label(label).click();
    harness.run_steps(3);
}

/// Presses at the first place, goes to each of the others, and lets go.
fn drag(harness: &mut Harness<'_, App>, way: &[Pos2], mut look: impl FnMut(&Harness<'_, App>)) {
    harness.hover_at(way[0]);
    harness.run_steps(1);
    harness.drag_at(way[0]);
    harness.run_steps(1);
    for at in way {
        harness.hover_at(*at);
        harness.run_steps(1);
        look(harness);
    }
    harness.drop_at(*way.last().expect("a way"));
    harness.run_steps(2);
}

fn wait(harness: &mut Harness<'_, App>, is_done: impl Fn(&App) -> bool) {
    for _ in 0..1000 {
        harness.run_steps(2);
        if is_done(harness.state()) {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    panic!("nothing came from the background");
}
