//! The chart of what the terms are worth.

use egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_core::film::View as Part;
use neumann_viewer::app::App;
use neumann_viewer::views::energy::EnergyView;

use crate::{click, harness, press};

fn of<'a>(harness: &'a Harness<'_, App>) -> &'a EnergyView {
    harness.state().viewing.views.get().expect("a row of VIEWS")
}

/// Layer k of the film has 2^-(k + 1) of the light.
#[test]
fn the_decay_of_the_terms_is_read_off_the_film() {
    for size in [[640.0, 420.0], [1280.0, 720.0]] {
        let mut harness = harness(size);
        press(&mut harness, Key::J);
        let energy = of(&harness).energy.clone().expect("there is a picture");
        assert_eq!(energy.terms.len(), 9);
        let decay = energy.decay.expect("all terms are known");
        assert!((decay.ratio[0] - 0.5).abs() < 1e-3, "{decay:?}");
        let bar = harness.query_by_label_contains("T1  2");
        assert!(
            bar.is_some(),
            "a bar has a name for those who do not see it"
        );
        let label = harness.get_by_label_contains("T3  ").rect();
        assert!(label.width() > 5.0);
        press(&mut harness, Key::Num3);
        assert_eq!(harness.state().viewing.settings.part, Part::Term(3));
        press(&mut harness, Key::Escape);
        assert!(of(&harness).energy.is_none(), "closed");
        assert_eq!(harness.state().session.link.n_starts(), 1);
    }
}

#[test]
fn the_chart_is_saved_with_its_numbers() {
    let mut harness = harness([1280.0, 720.0]);
    click(&mut harness, "Energy of the terms");
    let app = harness.state();
    let image = app.viewing.views.image(&app.session, &app.viewing.settings);
    let image = image.expect("there is something to save");
    assert_eq!(image.name, "energy");
    let pixels = (image.pixels)();
    assert!(pixels.width > 960 && pixels.height > 480 + 9 * 20);
}
