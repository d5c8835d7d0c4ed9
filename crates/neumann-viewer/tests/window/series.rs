//! The filmstrip, the bar of methods, and the keys of both.

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use neumann_core::film::View;
use neumann_core::integrator::METHODS;
use neumann_viewer::ViewOptions;
use neumann_viewer::app::App;

use crate::support::{app_of, published_with};
use crate::{click, harness, harness_of, press};

#[test]
fn thumbnails_choose_the_view() {
    for size in [[1280.0, 720.0], [900.0, 600.0]] {
        let mut harness = harness(size);
        if size[0] < 1000.0 {
            click(&mut harness, "row: terms");
        }
        click(&mut harness, "term T^2 L_e");
        assert_eq!(harness.state().viewing.settings.part, View::Term(2));
        if size[0] < 1000.0 {
            click(&mut harness, "row: sums");
        }
        click(&mut harness, "sum up to 3");
        assert_eq!(harness.state().viewing.settings.part, View::Upto(3));
        assert_eq!(
            harness.state().session.link.n_starts(),
            1,
            "a view never restarts"
        );
    }
}

/// Where there is no room for all places of the strip it scrolls to the one that is chosen.
#[test]
fn a_long_strip_scrolls_to_what_is_chosen() {
    for size in [[1000.0, 640.0], [640.0, 420.0]] {
        let options = ViewOptions {
            size: Some((96, 96)),
            layers: Some(16),
            ..ViewOptions::default()
        };
        let mut harness = harness_of(size, app_of(published_with(16), options));
        press(&mut harness, Key::Num0);
        harness.run_steps(20);
        let tile = |harness: &Harness<'_, App>, name: &str| {
            let mut found = harness.query_all_by_label(name);
            found.next().map(|node| node.rect())
        };
        let first = tile(&harness, "term L_e").expect("it is seen");
        assert!(tile(&harness, "tail").is_none(), "{size:?}: no room for it");
        assert!(first.width() > 40.0, "{size:?}: {first:?}");
        for _ in 0..16 {
            press(&mut harness, Key::ArrowRight);
        }
        harness.run_steps(20);
        let last = tile(&harness, "tail").expect("the tail is chosen");
        assert!(last.right() <= size[0], "{size:?}: {last:?}");
        assert!(tile(&harness, "term L_e").is_none(), "{size:?}");
    }
}

#[test]
fn keys_choose_the_view() {
    let mut harness = harness([1280.0, 720.0]);
    let mut after = |key: Key, modifiers: Modifiers| {
        harness.key_press_modifiers(modifiers, key);
        harness.run_steps(2);
        harness.state().viewing.settings.part
    };
    assert_eq!(after(Key::Num3, Modifiers::NONE), View::Term(3));
    assert_eq!(after(Key::ArrowRight, Modifiers::NONE), View::Term(4));
    assert_eq!(after(Key::ArrowDown, Modifiers::NONE), View::Upto(4));
    assert_eq!(after(Key::Num1, Modifiers::SHIFT), View::Upto(1));
    assert_eq!(after(Key::ArrowUp, Modifiers::NONE), View::Term(1));
    assert_eq!(after(Key::ArrowLeft, Modifiers::NONE), View::Term(0));
    assert_eq!(after(Key::L, Modifiers::NONE), View::Total);
    assert_eq!(after(Key::Num9, Modifiers::NONE), View::Tail);
    assert_eq!(
        harness.state().session.link.n_starts(),
        1,
        "a view never restarts"
    );
}

#[test]
fn methods_change_by_click_and_by_key_and_keep_camera_and_view() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::Num2);
    let camera = harness.state().session.setup.settings().unwrap().camera;
    click(&mut harness, &format!("method: {}", METHODS[0].id));
    assert_eq!(harness.state().session.setup.method(), METHODS[0]);
    press(&mut harness, Key::CloseBracket);
    assert_eq!(harness.state().session.setup.method(), METHODS[1]);
    press(&mut harness, Key::OpenBracket);
    let app = harness.state();
    let job = app.session.link.started().unwrap();
    assert_eq!(job.settings.method, METHODS[0]);
    assert_eq!(
        job.settings.camera.world_from_camera,
        camera.world_from_camera
    );
    assert_eq!(app.viewing.settings.part, View::Term(2));
    assert_eq!(app.session.link.n_starts(), 4);
}

#[test]
fn every_method_can_be_reached_and_keeps_camera_view_and_exposure() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::Num3);
    press(&mut harness, Key::E);
    let camera = harness.state().session.setup.settings().unwrap().camera;
    let first = harness.state().session.setup.method;
    for (key, step) in [
        (Key::CloseBracket, 1),
        (Key::OpenBracket, METHODS.len() - 1),
    ] {
        for n in 1..=METHODS.len() {
            press(&mut harness, key);
            let app = harness.state();
            let expected = METHODS[(first + n * step) % METHODS.len()];
            let job = app.session.link.started().unwrap();
            assert_eq!(job.settings.method, expected);
            assert_eq!(
                job.settings.camera.world_from_camera,
                camera.world_from_camera
            );
            assert_eq!(app.viewing.settings.part, View::Term(3));
            assert!((app.viewing.settings.exposure_ev - (1.0 / 3.0 - 2.0)).abs() < 1e-6);
        }
    }
}

#[test]
fn terms_tell_their_error() {
    let harness = harness([1280.0, 720.0]);
    let picture = &harness.state().session.picture;
    assert_eq!(picture.error(View::Term(0)), None, "nothing is known");
    assert_eq!(picture.error(View::Term(3)), Some(0.03));
    assert_eq!(picture.error(View::Tail), Some(0.08));
    assert_eq!(picture.error(View::Total), Some(0.01));
    assert_eq!(picture.error(View::Upto(3)), None);
    let node = harness.get_by_label("term T^3 L_e");
    let said = node.accesskit_node().description();
    let said = said.expect("what it shows");
    assert!(said.ends_with("of the energy, error about 3 %"), "{said}");
}
