//! A region is rendered alone, and the picture around it stays.

use std::sync::Arc;

use egui::{Key, Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use half::f16;
use neumann_core::film::View;
use neumann_core::scene::Scene;
use neumann_core::scene::builtin::builtin;
use neumann_core::scene::description::Crop;
use neumann_viewer::app::App;
use neumann_viewer::display::Slot;
use neumann_viewer::probe::Reading;
use neumann_viewer::render_link::RenderLink;
use neumann_viewer::{ViewOptions, command_line};

use crate::support::app_on;
use crate::{click, drag, harness_of, press, wait};

const SIDE: usize = 96;
const REGION: Crop = Crop {
    of: [SIDE, SIDE],
    at: [24, 36],
    size: [48, 24],
};

fn n_iterations(app: &App) -> u32 {
    app.session.picture.stats.n_iterations
}

fn is_full(app: &App, n: u32) -> bool {
    let session = &app.session;
    session.is_current() && session.picture.divisor == 1 && n_iterations(app) >= n
}

/// The window on cornell while it renders a film of a fixed size.
fn live(window: [f32; 2]) -> Harness<'static, App> {
    live_with(window, Some((SIDE, SIDE)))
}

fn live_with(window: [f32; 2], size: Option<(usize, usize)>) -> Harness<'static, App> {
    let link = RenderLink::live(Some(1), || {}).expect("a thread");
    let options = ViewOptions {
        size,
        ..ViewOptions::default()
    };
    let mut app = app_on(link, options);
    let cornell = builtin("cornell").expect("a built-in scene");
    let cornell = cornell.load().expect("a scene as it comes");
    app.take_scene("cornell".to_owned(), Arc::new(Scene::build(&cornell)));
    let mut harness = harness_of(window, app);
    wait(&mut harness, |app| is_full(app, 4));
    harness
}

/// The place on the screen of a share of the picture's width and height.
fn place(harness: &Harness<'_, App>, x: f32, y: f32) -> Pos2 {
    let placement = harness.state().viewing.placement.expect("a picture");
    let film = placement.film;
    film.min + vec2(x, y) * film.size()
}

/// Draws the region, from its lower left corner.
fn draw(harness: &mut Harness<'_, App>) {
    let way = [(0.25, 0.625), (0.5, 0.5), (0.75, 0.375)];
    let way = way.map(|(x, y)| place(harness, x, y));
    drag(harness, &way, |_| {});
}

fn label(harness: &Harness<'_, App>, part: &str) -> bool {
    harness.query_by_label_contains(part).is_some()
}

/// The pixels on the screen as they are uploaded, those within the region apart.
fn shown(harness: &Harness<'_, App>) -> (Vec<[f16; 4]>, Vec<[f16; 4]>, f32) {
    let planes = harness.state().session.picture.planes.lock();
    let plane = planes.plane(Slot::Live);
    assert_eq!((plane.width, plane.height), (SIDE, SIDE));
    let pixels = plane.pixels.chunks_exact(4).enumerate();
    let (mut within, mut around) = (Vec::new(), Vec::new());
    for (i, pixel) in pixels {
        let at = [i % SIDE, i / SIDE];
        let is_in = |k: usize| (REGION.at[k]..REGION.at[k] + REGION.size[k]).contains(&at[k]);
        let side = if is_in(0) && is_in(1) {
            &mut within
        } else {
            &mut around
        };
        side.push([pixel[0], pixel[1], pixel[2], pixel[3]]);
    }
    (within, around, plane.scale)
}

#[test]
fn a_dragged_region_is_rendered_alone_and_what_is_around_it_stays() {
    let mut harness = live([1280.0, 720.0]);
    press(&mut harness, Key::B);
    assert!(label(&harness, "drag a rectangle"));
    let eye = harness.state().session.setup.camera.as_ref().unwrap().eye();
    draw(&mut harness);
    let setup = &harness.state().session.setup;
    assert_eq!(setup.region, Some(REGION));
    assert_eq!(setup.camera.as_ref().unwrap().eye(), eye, "no orbit");
    assert!(harness.state().viewing.settings.drawing.is_none());
    let around = harness.state().session.picture.around.as_ref();
    let n = around.expect("the whole picture is kept").job.clone();
    assert_eq!(n.settings.width, SIDE);

    wait(&mut harness, |app| is_full(app, 3));
    let (first, before, scale) = shown(&harness);
    let n = n_iterations(harness.state());
    wait(&mut harness, |app| is_full(app, n + 3));
    let (within, after, same) = shown(&harness);
    assert_eq!((before, scale), (after, same), "to the bit");
    assert_ne!(first, within);
    assert!(label(&harness, "region 48 × 24 at 24, 36"));
    let name = "End the region";
    assert!(harness.query_by_label(name).is_some());

    // All samples are in the region.
    let session = &harness.state().session;
    let (film, metadata) = session.film().expect("a film");
    assert_eq!((film.width(), film.height()), (48, 24));
    assert!(metadata.camera.ends_with("; region 24 36 48 24 of 96 96"));
    let settings = &harness.state().viewing.settings;
    let command = command_line::of(session, settings).unwrap().text;
    let words = " --size 96x96 --region 24,36,48,24 ";
    assert!(command.contains(words), "{command}");
    assert_eq!(session.shown_size(), (SIDE, SIDE));

    // A camera that moves keeps its region; nothing of the other camera stands around it.
    let control = harness.state_mut().session.setup.camera.as_mut().unwrap();
    control.orbit(glam::Vec2::new(0.3, 0.0));
    harness.state_mut().session.setup.is_changed = true;
    harness.run_steps(1);
    wait(&mut harness, |app| is_full(app, 1));
    assert_eq!(harness.state().session.setup.region, Some(REGION));
    let (within, around, _) = shown(&harness);
    let is_lit = |pixels: &[[f16; 4]]| pixels.iter().any(|p| p[0] > f16::ZERO);
    assert!(is_lit(&within) && !is_lit(&around));
}

#[test]
fn a_region_begins_with_the_picture_and_ends_with_it() {
    let mut harness = live([1280.0, 720.0]);
    harness.state_mut().session.link.pause(true);
    harness.run_steps(3);
    let (_, before, scale) = shown(&harness);
    let n = n_iterations(harness.state());
    let first = probed(harness.state());
    for by_button in [false, true] {
        press(&mut harness, Key::B);
        draw(&mut harness);
        harness.state_mut().session.link.pause(false);
        wait(&mut harness, |app| is_full(app, 2));
        let (within, around, same) = shown(&harness);
        assert!(before == around && scale == same, "to the bit");
        harness.state_mut().session.link.pause(true);
        if by_button {
            click(&mut harness, "End the region");
        } else {
            press(&mut harness, Key::Escape);
        }
        assert!(harness.state().session.setup.region.is_none());
        // The picture from before is shown until the whole film has as many iterations.
        assert_eq!(harness.state().session.catching_up(), Some((0, n)));
        assert!(harness.state().session.is_after_region());
        let (old, around, _) = shown(&harness);
        assert!(before == around && old != within);
        // It is what is probed, too, though another film has begun.
        assert_eq!(probed(harness.state()), first);
    }
    harness.state_mut().session.link.pause(false);
    wait(&mut harness, |app| app.session.catching_up().is_none());
    wait(&mut harness, |app| is_full(app, n));
    let session = &harness.state().session;
    assert_eq!(session.picture.size, (SIDE, SIDE));
    assert!(session.picture.around.is_none(), "its memory is given back");
    assert!(session.region().is_none());
}

/// What is read in the middle of the picture.
fn probed(app: &App) -> Reading {
    let settings = &app.viewing.settings;
    neumann_viewer::views::picture::read(&app.session, settings, [0.5, 0.5])
}

#[test]
fn a_picture_that_stays_is_what_is_probed() {
    let mut harness = live_with([640.0, 420.0], None);
    wait(&mut harness, |app| is_full(app, 12));
    let first = probed(harness.state());
    // The picture is left with more iterations than the next film has for a while.
    let n = n_iterations(harness.state());
    harness.set_size(vec2(720.0, 460.0));
    harness.run_steps(3);
    harness.state_mut().session.fit();
    harness.run_steps(1);
    let before = harness.state().session.picture.stats.n_iterations;
    assert!(before >= n && harness.state().session.catching_up().is_some());
    let generation = harness.state().session.link.generation();
    let is_new = |app: &App| app.session.link.read(|p| p.generation == generation);
    wait(&mut harness, is_new);
    let app = harness.state();
    assert!(
        app.session.catching_up().is_some(),
        "it has caught up already"
    );
    let reading = probed(app);
    let planes = app.session.picture.planes.lock();
    let plane = planes.plane(Slot::Live);
    let index = 4 * (plane.height / 2 * plane.width + plane.width / 2);
    let red = plane.pixels[index].to_f32() * plane.scale;
    let red = neumann_viewer::widgets::significant(f64::from(red), 3);
    assert!(
        reading.lines[1].starts_with(&format!("{red} ")),
        "{reading:?}"
    );
    assert_eq!(
        reading.lines[0], first.lines[0],
        "a place of the picture that stays"
    );
}

#[test]
fn a_window_of_another_size_keeps_the_region_and_the_film() {
    let mut harness = live_with([640.0, 420.0], None);
    press(&mut harness, Key::B);
    draw(&mut harness);
    let size = harness.state().session.setup.size;
    let region = harness.state().session.setup.region;
    assert!(region.is_some());
    harness.set_size(vec2(720.0, 460.0));
    harness.run_steps(3);
    wait(&mut harness, |app| is_full(app, 2));
    harness.state_mut().session.link.pause(true);
    harness.run_steps(2);
    assert!(harness.state().session.can_fit());
    assert_eq!(harness.state().session.setup.region, region);
    press(&mut harness, Key::B);
    let session = &harness.state().session;
    assert_eq!((session.setup.region, session.setup.size), (None, size));
    assert!(session.is_after_region() && session.catching_up().is_some());
}

#[test]
fn what_is_probed_is_in_the_region_or_outside_it() {
    let mut harness = live([640.0, 420.0]);
    press(&mut harness, Key::B);
    draw(&mut harness);
    wait(&mut harness, |app| is_full(app, 2));
    harness.state_mut().session.link.pause(true);
    harness.run_steps(2);
    let app = harness.state();
    let read = |x: f32, y: f32| {
        let settings = &app.viewing.settings;
        neumann_viewer::views::picture::read(&app.session, settings, [x, y])
    };
    let pixel = |x: usize| (x as f32 + 0.5) / SIDE as f32;
    let outside = read(pixel(23), pixel(40));
    assert_eq!(outside.lines, ["x 23  y 40", "outside the region"]);
    let inside = read(pixel(30), pixel(40));
    assert_eq!(inside.lines[0], "x 30  y 40");
    let value = app.session.link.read(|published| {
        let index = (40 - REGION.at[1]) * published.film.width() + 30 - REGION.at[0];
        published.film.radiance(View::Total, index)
    });
    let first = neumann_viewer::widgets::significant(f64::from(value.r), 4);
    assert!(inside.lines[1].starts_with(&first), "{:?}", inside.lines);

    // Nothing is put aside of two films in one picture.
    press(&mut harness, Key::H);
    assert!(harness.state().session.picture.held[0].is_none());
}

#[test]
fn drawing_a_region_can_be_left() {
    let mut harness = live([1280.0, 720.0]);
    let n_starts = harness.state().session.link.n_starts();
    for key in [Key::Escape, Key::B] {
        press(&mut harness, Key::B);
        assert!(harness.state().viewing.settings.drawing.is_some());
        press(&mut harness, key);
        assert!(harness.state().viewing.settings.drawing.is_none());
    }
    // Too small a rectangle is none.
    press(&mut harness, Key::B);
    let at = place(&harness, 0.5, 0.5);
    drag(&mut harness, &[at, at + vec2(9.0, 9.0)], |_| {});
    assert!(harness.state().viewing.settings.drawing.is_some());
    assert!(harness.state().session.setup.region.is_none());
    assert_eq!(harness.state().session.link.n_starts(), n_starts);

    // A film of another size has no region.
    draw(&mut harness);
    assert!(harness.state().session.setup.region.is_some());
    let setup = &mut harness.state_mut().session.setup;
    setup.film_size = neumann_viewer::setup::FilmSize::Fixed(64, 64);
    setup.is_changed = true;
    harness.run_steps(3);
    let session = &harness.state().session;
    assert_eq!(session.setup.region, None);
    assert_eq!(session.link.started().unwrap().settings.width, 64);
}
