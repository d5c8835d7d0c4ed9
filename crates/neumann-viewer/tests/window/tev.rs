//! The picture and its layers in tev, as long as that is wanted.

use std::time::{Duration, Instant};

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_viewer::ViewOptions;
use neumann_viewer::app::App;
use neumann_viewer::panels::Page;
use neumann_viewer::render_link::RenderLink;

use crate::support::{app, app_on, published};
use crate::{click, harness_of, wait};
use fake::FakeTev;

#[path = "../../../../tests/support/tev.rs"]
mod fake;

fn toggle(harness: &mut Harness<'_, App>) {
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::T);
    harness.run_steps(2);
}

fn says(app: &App, words: &str) -> bool {
    app.shell.notices.texts().any(|text| text.contains(words))
}

#[test]
fn tev_has_the_layers_of_the_film() {
    let fake = FakeTev::listen();
    let mut harness = harness_of([1280.0, 720.0], app());
    harness.state_mut().shell.sending.address = fake.address().to_owned();
    toggle(&mut harness);
    wait(&mut harness, |app| says(app, "The picture goes to tev at"));
    wait(&mut harness, |_| {
        let images = fake.so_far().images;
        images.values().any(|image| image.n_updates == 10)
    });
    harness.run_steps(20);
    toggle(&mut harness);
    assert!(says(harness.state(), "tev gets no more pictures"));
    let received = fake.finish();
    let image = &received.images["furnace, pt-mis"];
    let film = published().film;
    assert_eq!(image.n_updates, 10, "what has not changed is sent once");
    assert_eq!(image.order[..4], ["R", "G", "B", "T0.R"]);
    for (name, layer) in [("T3", 3), ("tail", 8)] {
        let layer = film.layer(layer);
        for (channel, at) in ["R", "G", "B"].into_iter().zip(0..) {
            let wanted: Vec<f32> = layer.iter().map(|p| p.to_array()[at]).collect();
            let name = format!("{name}.{channel}");
            assert_eq!(image.channels[&name], wanted, "{name}");
        }
    }
    let reds: Vec<f32> = film.total().iter().map(|p| p.r).collect();
    assert_eq!(image.channels["R"], reds);
}

#[test]
fn what_is_rendered_goes_there_until_tev_leaves() {
    let fake = FakeTev::leaving_after(1 + 3 * 10);
    let options = ViewOptions {
        size: Some((32, 32)),
        ..ViewOptions::default()
    };
    let link = RenderLink::live(Some(1), || {}).expect("a thread");
    let mut harness = harness_of([1280.0, 720.0], app_on(link, options));
    harness.state_mut().shell.sending.address = fake.address().to_owned();
    let starts = harness.state().session.link.n_starts();
    let begun = Instant::now();
    toggle(&mut harness);
    wait(&mut harness, |app| says(app, "tev takes no more pictures"));
    assert!(begun.elapsed() >= Duration::from_millis(600), "with pauses");
    assert!(!harness.state().shell.sending.is_on());
    assert_eq!(harness.state().session.link.n_starts(), starts);
    let received = fake.finish();
    assert!(received.images.values().any(|image| image.size == (32, 32)));
}

#[test]
fn where_nobody_listens_a_notice_says_so() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("a port").to_string();
    drop(listener);
    let mut harness = harness_of([1280.0, 2400.0], app());
    harness
        .state_mut()
        .shell
        .sending
        .address
        .clone_from(&address);
    harness.state_mut().shell.page = Page::Display;
    harness.run_steps(2);
    click(&mut harness, "Send to tev");
    let words = format!("No tev listens at {address}; start it");
    wait(&mut harness, |app| says(app, &words));
    assert!(!harness.state().shell.sending.is_on());
    assert!(harness.query_by_label("Send to tev").is_some());
}
