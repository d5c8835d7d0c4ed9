//! The histogram of the Display page follows picture and exposure.

use egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_viewer::app::App;

use crate::{click, harness, press};

fn says(harness: &Harness<'_, App>, text: &str) -> bool {
    harness.query_all_by_label_contains(text).count() > 0
}

#[test]
fn it_says_what_cannot_be_told_apart() {
    let mut harness = harness([1280.0, 720.0]);
    harness.state_mut().viewing.settings.exposure_ev = -1.0;
    press(&mut harness, Key::F4);
    assert!(says(&harness, "histogram: nothing too dark or too bright"));
    harness.state_mut().viewing.settings.exposure_ev = 12.0;
    harness.run_steps(2);
    assert!(says(&harness, "histogram: 0 % too dark, 100 % too bright"));
    harness.state_mut().viewing.settings.exposure_ev = -15.0;
    harness.run_steps(2);
    assert!(says(&harness, "histogram: 100 % too dark, 0 % too bright"));
    // One channel that is too bright counts where channels are counted.
    harness.state_mut().viewing.settings.exposure_ev = 0.05;
    harness.run_steps(2);
    assert!(says(&harness, "histogram: nothing too dark"));
    click(&mut harness, "Histogram: R G B");
    assert!(!says(&harness, "histogram: nothing too dark"));
    assert!(says(&harness, " too bright"));
    // What has another scale has no exposure to be too bright for.
    press(&mut harness, Key::N);
    assert!(!says(&harness, "histogram: "));
}
