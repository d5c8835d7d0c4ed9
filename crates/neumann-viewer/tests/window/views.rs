//! Techniques, photons and what pixels hold beside radiance in place of the picture.

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_core::film::{Strategy, TechniqueImage};
use neumann_picture::photons::PhotonColours;
use neumann_viewer::app::App;
use neumann_viewer::views::photons::PhotonView;
use neumann_viewer::views::techniques::TechniqueView;

use crate::support::{app_with_photons, app_with_quantities, app_with_techniques};
use crate::{click, harness, harness_of, press};

fn techniques<'a>(harness: &'a Harness<'_, App>) -> &'a TechniqueView {
    harness.state().viewing.views.get().expect("a row of VIEWS")
}

fn is_apart(harness: &Harness<'_, App>) -> bool {
    harness.state().viewing.views.shown().id == "techniques"
}

#[test]
fn techniques_open_enlarge_and_close() {
    for size in [[1280.0, 720.0], [900.0, 600.0]] {
        let mut harness = harness_of(size, app_with_techniques());
        assert!(!harness.state().session.link.is_recording());
        press(&mut harness, Key::V);
        assert!(harness.state().session.link.is_recording());
        for strategy in ["s=0 t=2", "s=0 t=3", "s=1 t=2", "s=1 t=3", "s=2 t=2"] {
            let label = format!("technique {strategy}");
            assert!(harness.query_by_label(&label).is_some(), "{label}");
        }
        let sum: f64 = techniques(&harness).techniques().map(|t| t.1).sum();
        assert!(sum > 0.5 && sum < 1.0 + 1e-6, "shares add up to {sum}");
        click(&mut harness, "technique image: raw");
        assert_eq!(techniques(&harness).image, TechniqueImage::Raw);
        click(&mut harness, "technique s=1 t=2");
        let enlarged = techniques(&harness).enlarged;
        assert_eq!(enlarged, Some(Strategy::connect(1, 2)));
        click(&mut harness, "enlarged technique s=1 t=2");
        assert_eq!(techniques(&harness).enlarged, None);
        click(&mut harness, "technique s=1 t=3");
        press(&mut harness, Key::F6);
        press(&mut harness, Key::Escape);
        assert!(harness.ctx.memory(|m| m.focused()).is_none());
        assert!(techniques(&harness).enlarged.is_some());
        press(&mut harness, Key::Escape);
        assert!(is_apart(&harness), "back to all of them");
        press(&mut harness, Key::Escape);
        assert!(!is_apart(&harness));
        assert!(!harness.state().session.link.is_recording());
        assert_eq!(
            harness.state().session.link.n_starts(),
            1,
            "a view never restarts"
        );
    }
}

#[test]
fn what_is_saved_is_what_is_shown() {
    let mut harness = harness_of([1280.0, 720.0], app_with_techniques());
    let saved = |harness: &Harness<'_, App>| {
        let app = harness.state();
        let image = app
            .viewing
            .views
            .image(&app.session, &app.viewing.settings)
            .expect("there is something to save");
        let pixels = (image.pixels)();
        (image.name, pixels.width, pixels.height)
    };
    assert_eq!(saved(&harness), ("L".to_owned(), 96, 96));
    press(&mut harness, Key::V);
    let (name, width, _) = saved(&harness);
    assert_eq!(name, "techniques");
    assert!(width > 32 * 5, "all of them on a sheet");
    click(&mut harness, "technique s=1 t=2");
    let name = format!("s=1 t=2-{}", TechniqueImage::default().name());
    assert_eq!(saved(&harness), (name, 32, 32));
}

#[test]
fn techniques_close_with_their_method_and_with_another_view() {
    let mut harness = harness_of([1280.0, 720.0], app_with_techniques());
    click(&mut harness, "Show techniques");
    assert!(harness.state().session.link.is_recording());
    press(&mut harness, Key::CloseBracket);
    assert!(!is_apart(&harness), "pm has none");
    assert!(!harness.state().session.link.is_recording());
    press(&mut harness, Key::V);
    assert!(!is_apart(&harness));
    assert_eq!(harness.state().shell.notices.texts().count(), 1);
    press(&mut harness, Key::OpenBracket);
    press(&mut harness, Key::V);
    press(&mut harness, Key::Num2);
    assert!(!is_apart(&harness), "the view is shown");
}

fn photons<'a>(harness: &'a Harness<'_, App>) -> &'a PhotonView {
    harness.state().viewing.views.get().expect("a row of VIEWS")
}

#[test]
fn photons_are_shown_by_their_key_in_both_colours_and_closed() {
    for size in [[1280.0, 720.0], [640.0, 420.0]] {
        let mut harness = harness_of(size, app_with_photons());
        let shown = |harness: &Harness<'_, App>| harness.state().viewing.views.shown().id;
        assert!(!harness.state().session.link.draws_photons());
        press(&mut harness, Key::P);
        assert_eq!(shown(&harness), "photons");
        assert!(harness.state().session.link.draws_photons());
        let is_said = |harness: &Harness<'_, App>, text: &str| {
            let n = harness.query_all_by_label_contains(text).count();
            assert_eq!(n, 1, "{text}");
        };
        is_said(&harness, "photons by bounce, 9,216 light paths · ");
        is_said(&harness, "legend, bounce, share of photons: 1 ");
        let picture = harness.query_all_by_label_contains("all light").count();
        assert_eq!(picture, 0, "this is no picture of light");
        click(&mut harness, "colour photons by: power");
        assert_eq!(photons(&harness).colours, PhotonColours::Power);
        is_said(&harness, "photons by power, ");
        is_said(&harness, "legend, power in a pixel: ≥ ");
        click(&mut harness, "colour photons by: bounce");
        // A part of the series chooses bounces.
        press(&mut harness, Key::Num2);
        is_said(&harness, "photons by bounce: of bounce 2, ");
        press(&mut harness, Key::Num0);
        is_said(&harness, "no photons: emitted light has none, ");
        press(&mut harness, Key::Escape);
        assert_eq!(shown(&harness), "picture");
        assert!(!harness.state().session.link.draws_photons());
        let n_starts = harness.state().session.link.n_starts();
        assert_eq!(n_starts, 1, "a view never restarts");
    }
}

#[test]
fn photons_are_saved_with_their_legend() {
    let mut harness = harness_of([1280.0, 720.0], app_with_photons());
    press(&mut harness, Key::P);
    let app = harness.state();
    let views = &app.viewing.views;
    let image = views.image(&app.session, &app.viewing.settings);
    let image = image.expect("there is something to save");
    assert_eq!(image.name, "photons-bounce");
    let pixels = (image.pixels)();
    assert!(
        pixels.width > 96 + 200,
        "the legend stands beside the picture"
    );
}

#[test]
fn photons_of_a_method_without_are_refused_in_a_sentence() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::P);
    assert_eq!(harness.state().viewing.views.shown().id, "picture");
    let notice = harness.state().shell.notices.texts().next();
    let notice = notice.expect("it says why").to_owned();
    assert!(
        notice.ends_with("the photons view needs pm or ppm"),
        "{notice}"
    );
    // Photons close with their method.
    let mut harness = harness_of([1280.0, 720.0], app_with_photons());
    click(&mut harness, "Show photons");
    assert_eq!(harness.state().viewing.views.shown().id, "photons");
    press(&mut harness, Key::OpenBracket);
    assert_eq!(harness.state().viewing.views.shown().id, "picture");
    assert!(!harness.state().session.link.draws_photons());
}

fn shown(harness: &Harness<'_, App>) -> &'static str {
    harness.state().viewing.views.shown().id
}

#[test]
fn a_key_steps_through_what_pixels_hold() {
    for size in [[1280.0, 720.0], [640.0, 420.0]] {
        let mut harness = harness_of(size, app_with_quantities());
        for (id, said) in [
            ("albedo", "linear shares"),
            ("normal", "from −1 to 1"),
            ("depth", " m; black where there is nothing"),
            ("error", "root mean square 0.01 W"),
            ("samples", "1 in every pixel"),
        ] {
            press(&mut harness, Key::N);
            assert_eq!(shown(&harness), id);
            let n = harness.query_all_by_label_contains(said).count();
            assert_eq!(n, 1, "{id}: {said}");
            let is_feature = ["albedo", "normal", "depth"].contains(&id);
            let link = &harness.state().session.link;
            assert_eq!(link.traces_features(), is_feature, "{id}");
            assert_eq!(link.n_starts(), 1, "a view never restarts");
        }
        press(&mut harness, Key::N);
        assert_eq!(shown(&harness), "picture");
        harness.key_press_modifiers(Modifiers::SHIFT, Key::N);
        harness.run_steps(2);
        assert_eq!(shown(&harness), "samples");
        press(&mut harness, Key::Escape);
        assert_eq!(shown(&harness), "picture");
        // A term is looked at in the picture.
        press(&mut harness, Key::N);
        press(&mut harness, Key::Num2);
        assert_eq!(shown(&harness), "picture");
    }
}

#[test]
fn what_pixels_hold_is_chosen_on_a_page_and_saved_with_its_legend() {
    let mut harness = harness_of([1280.0, 720.0], app_with_quantities());
    press(&mut harness, Key::F4);
    for (label, id) in [("Depth", "depth"), ("Error", "error"), ("Normal", "normal")] {
        click(&mut harness, &format!("Show: {label}"));
        assert_eq!(shown(&harness), id);
        let app = harness.state();
        let image = app.viewing.views.image(&app.session, &app.viewing.settings);
        let image = image.expect("there is something to save");
        assert_eq!(image.name, id);
        let pixels = (image.pixels)();
        assert!(pixels.width > 96 + 100, "the legend stands beside it");
    }
    click(&mut harness, "Show: Picture");
    assert_eq!(shown(&harness), "picture");
}

#[test]
fn an_error_that_is_not_known_is_not_shown() {
    let mut app = app_with_quantities();
    app.session.picture.stats.estimated_error = None;
    let mut harness = harness_of([1280.0, 720.0], app);
    harness.state_mut().session.picture.stats.estimated_error = None;
    click(&mut harness, "Display");
    click(&mut harness, "Show: Error");
    let said = "the error is not known yet, or by this method not at all";
    assert_eq!(harness.query_all_by_label_contains(said).count(), 1);
}
