//! What views beside the picture look at is part of a state.

use egui::Key;
use neumann_core::integrator::METHODS;
use neumann_picture::race::Entrant;
use neumann_picture::state::{LobesOf, LookedAt, State};
use neumann_viewer::views::entry::Entry;
use neumann_viewer::views::hemisphere::HemisphereView;
use neumann_viewer::views::inspect::InspectView;
use neumann_viewer::views::lobe::{Choice, LobeView};
use neumann_viewer::views::race::RaceView;

use crate::support::{app, app_with_race};
use crate::{harness_of, state_of, wait};

#[test]
fn a_state_has_what_views_look_at() {
    let mut first = harness_of(app());
    let naive = METHODS.iter().position(|m| m.id == "naive");
    let setup = &mut first.state_mut().session.setup;
    setup.choose_method(naive.expect("a method"));
    first.run_steps(2);
    let views = &mut first.state_mut().viewing.views;
    views.get_mut::<InspectView>().expect("a view").pixel = Some([5, 60]);
    views.get_mut::<HemisphereView>().expect("a view").pixel = Some([90, 7]);
    views.get_mut::<LobeView>().expect("a view").choice = Some(Choice::Material(0));
    let bdpt = METHODS
        .iter()
        .position(|m| m.id == "bdpt")
        .expect("a method");
    let own = Entrant::parse("pt-mis:roulette=off").expect("a method");
    // With usual parameters of its own, whatever its page has.
    let usual = Entrant::parse("lt").expect("a method");
    let race = vec![Entry::OfPage(bdpt), Entry::Own(own), Entry::Own(usual)];
    // The method of the picture is not among them.
    views
        .get_mut::<RaceView>()
        .expect("a view")
        .enter(race.clone());
    for (key, id) in [
        (Key::Q, "inspect"),
        (Key::U, "hemisphere"),
        (Key::O, "lobe"),
    ] {
        first.key_press(key);
        first.run_steps(4);
        let saved = state_of(&first);
        assert_eq!(saved.view, id);
        assert_eq!(saved.looked_at.inspected, Some([5, 60]));
        assert_eq!(saved.looked_at.hemisphere, Some([90, 7]));
        assert_eq!(saved.looked_at.lobes, Some(LobesOf::Material(0)));
        let (read, warnings) = State::parse(&saved.to_text()).expect("a state");
        assert_eq!((&read, warnings.len()), (&saved, 0));
        let mut second = harness_of(app());
        // What it looked at before is forgotten.
        for key in [Key::Q, Key::U, Key::O, Key::K] {
            second.key_press(key);
            second.run_steps(2);
        }
        second.state_mut().open_state(Box::new(read));
        wait(&mut second, |app| !app.is_loading());
        second.run_steps(4);
        assert_eq!(state_of(&second), saved);
        let views = &second.state().viewing.views;
        assert_eq!(views.get::<RaceView>().expect("a view").entries, race);
    }
    // A race that is shown at once is that of the state.
    let mut saved = state_of(&first);
    saved.view = "race".to_owned();
    let mut second = harness_of(app());
    second.state_mut().open_state(Box::new(saved.clone()));
    wait(&mut second, |app| !app.is_loading());
    second.run_steps(4);
    assert_eq!(state_of(&second), saved);
    // A pixel may lie beyond the film that was shown before.
    saved.size = Some([200, 150]);
    saved.looked_at.inspected = Some([150, 120]);
    saved.looked_at.hemisphere = Some([199, 149]);
    saved.looked_at.lobes = Some(LobesOf::Pixel([120, 149]));
    for view in ["inspect", "hemisphere", "lobe"] {
        saved.view = view.to_owned();
        let mut second = harness_of(app());
        second.state_mut().open_state(Box::new(saved.clone()));
        wait(&mut second, |app| !app.is_loading());
        second.run_steps(4);
        assert_eq!(state_of(&second), saved);
    }
    // Nothing is looked at yet.
    saved.looked_at = LookedAt::default();
    saved.view = "picture".to_owned();
    second.state_mut().open_state(Box::new(saved.clone()));
    wait(&mut second, |app| !app.is_loading());
    second.run_steps(4);
    assert_eq!(state_of(&second), saved);
}

#[test]
fn a_race_is_part_of_a_state() {
    let mut first = harness_of(app_with_race());
    first.key_press(Key::K);
    first.run_steps(2);
    let saved = state_of(&first);
    assert_eq!(saved.view, "race");
    let mut second = harness_of(app_with_race());
    second.state_mut().open_state(Box::new(saved));
    wait(&mut second, |app| !app.is_loading());
    assert_eq!(second.state().viewing.views.shown().id, "race");
}
