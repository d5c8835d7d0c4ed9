//! Every control says what it does: where the pointer rests on it, and to whoever hears it.

use std::collections::BTreeSet;

use egui::Key;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable, by};
use neumann_core::integrator::METHODS;
use neumann_core::render::StopRule;
use neumann_viewer::app::App;
use neumann_viewer::panels::Page;
use neumann_viewer::setup::FilmSize;
use neumann_viewer::views::agree::AgreeView;
use neumann_viewer::views::bias::BiasView;

use crate::support::{app_with_photons, app_with_race, app_with_techniques};
use crate::{click, harness, harness_of, press};

/// Controls of one choice, number or deed. Headings that fold and fields to type into say all by
/// their names.
const ROLES: [Role; 6] = [
    Role::Button,
    Role::RadioButton,
    Role::Slider,
    Role::Switch,
    Role::ColorWell,
    Role::Tab,
];

/// Words of a label, "Type" and "Reset" before the name of a slider counted, too.
const MOST: usize = 4;

/// What the controls that are shown lack.
fn faults(harness: &Harness<'_, App>, where_: &str, faults: &mut BTreeSet<String>) {
    for node in harness.query_all(by().predicate(|node| ROLES.contains(&node.role()))) {
        let node = node.accesskit_node();
        let name = node.label().unwrap_or_default();
        let about = node.description().unwrap_or_default();
        if about.is_empty() || about == name {
            let what = format!("{:?} '{name}' has no tooltip", node.role());
            faults.insert(format!("{where_}: {what}"));
        }
        let words = ["Button", "Slider", "Switch", "Tab"];
        let is_ours = words.contains(&format!("{:?}", node.role()).as_str());
        let n_words = name
            .split_whitespace()
            .filter(|word| *word != "|" && *word != "−");
        if is_ours && !name.starts_with("Use ") && n_words.count() > MOST {
            faults.insert(format!("{where_}: '{name}' has more than {MOST} words"));
        }
    }
}

/// Opens all that folds.
fn unfold(harness: &mut Harness<'_, App>) {
    for name in ["Recent files", "Materials", "Environment"] {
        if harness.query_by_label(name).is_some() {
            click(harness, name);
        }
    }
}

fn walk(harness: &mut Harness<'_, App>, what: &str, all: &mut BTreeSet<String>) {
    for page in Page::ALL {
        harness.state_mut().shell.page = page;
        harness.run_steps(2);
        faults(harness, &format!("{what}, {}", page.title()), all);
    }
}

#[test]
fn every_control_of_pages_and_views_says_what_it_does() {
    let mut all = BTreeSet::new();
    let mut harness = harness([1280.0, 2400.0]);
    harness.state_mut().shell.page = Page::Scene;
    harness.state_mut().shell.recent.add("a/scene.glb");
    harness.run_steps(2);
    unfold(&mut harness);
    let room = harness
        .state()
        .session
        .setup
        .open
        .as_ref()
        .expect("a scene");
    let material = room.scene.appearance().materials[0].name.clone();
    harness.state_mut().shell.material = Some(0);
    harness.run_steps(2);
    assert!(harness.query_by_label("Roughness").is_some(), "{material}");
    walk(&mut harness, "at first", &mut all);

    // A colour has a picker.
    harness.state_mut().shell.page = Page::Scene;
    harness.run_steps(2);
    click(&mut harness, &format!("Base colour of {material}"));
    assert!(harness.query_by_label("Saturation").is_some());
    faults(&harness, "picker", &mut all);
    press(&mut harness, Key::Escape);

    // Everything that a choice brings into view.
    let app = harness.state_mut();
    app.session.setup.stop = StopRule::Seconds(4.0);
    app.session.setup.film_size = FilmSize::Fixed(96, 96);
    let settings = &mut app.viewing.settings;
    (settings.is_false_colour, settings.exposure_ev) = (true, 1.0);
    harness.run_steps(2);
    press(&mut harness, Key::X);
    walk(&mut harness, "wiping", &mut all);
    harness.state_mut().session.setup.stop = StopRule::Iterations(4);
    harness.state_mut().shell.page = Page::Method;
    for method in METHODS {
        press(&mut harness, Key::CloseBracket);
        harness.run_steps(2);
        faults(&harness, method.id, &mut all);
    }

    // A small window has a menu and chips; what lies over it closes.
    let mut small = crate::harness([640.0, 420.0]);
    small.state_mut().shell.notices.failure("This went wrong");
    let ctx = small.ctx.clone();
    small.state_mut().shell.notices.saved(&ctx, "a.png".into());
    small.state_mut().shell.is_menu_open = true;
    small.run_steps(2);
    walk(&mut small, "small", &mut all);

    for (app, key) in [
        (app_with_techniques(), Key::V),
        (app_with_photons(), Key::P),
        (app_with_race(), Key::K),
    ] {
        let mut harness = harness_of([1280.0, 2400.0], app);
        press(&mut harness, key);
        harness.run_steps(8);
        walk(&mut harness, &format!("{key:?}"), &mut all);
        if key == Key::K {
            click(&mut harness, "racer 1: pt-bsdf");
            walk(&mut harness, "menu of the race", &mut all);
            press(&mut harness, Key::Escape);
            click(&mut harness, "picture by pt-nee");
            click(&mut harness, "wipe with: pt-mis");
            walk(&mut harness, "wipe of the race", &mut all);
        }
    }
    let mut lobes = crate::lobe::looking([1280.0, 2400.0]);
    walk(&mut lobes, "lobes", &mut all);
    crate::lobe::open_list(&mut lobes);
    faults(&lobes, "materials of lobes", &mut all);
    let mut harness = crate::live((48, 48), "pt-mis");
    press(&mut harness, Key::Y);
    crate::wait(&mut harness, |app| {
        let view = app.viewing.views.get::<AgreeView>();
        view.is_some_and(|view| view.found.is_some())
    });
    harness.run_steps(2);
    walk(&mut harness, "agreement", &mut all);
    click(&mut harness, "method 1: pt-mis");
    walk(&mut harness, "menu of the agreement", &mut all);
    let mut harness = crate::live((48, 48), "ppm");
    harness.key_press_modifiers(egui::Modifiers::SHIFT, Key::B);
    harness.run_steps(2);
    crate::wait(&mut harness, |app| {
        let view = app.viewing.views.get::<BiasView>();
        view.is_some_and(|view| view.found.is_some())
    });
    harness.run_steps(2);
    walk(&mut harness, "noise and bias", &mut all);
    let all: Vec<_> = all.into_iter().collect();
    assert!(all.is_empty(), "{} faults:\n{}", all.len(), all.join("\n"));
}
