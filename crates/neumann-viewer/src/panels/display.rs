//! How the picture is shown: nothing here renders anew.

use std::path::PathBuf;

use egui::Ui;
use neumann_picture::false_colour::ColourMap;
use neumann_picture::histogram::Channels;
use neumann_picture::tone::ToneCurve;

use crate::compared::{Compared, Side};
use crate::display::{Against, ViewSettings};
use crate::keys::Action;
use crate::picture::Picture;
use crate::scene_source::Wanted;
use crate::session::Session;
use crate::shell::Shell;
use crate::theme::GRID;
use crate::viewing::Viewing;
use crate::views::{self, VIEWS, Views};
use crate::widgets::{
    Slider, button, choice_row, choice_rows, fact, heading, hint, paragraph, path_field, rule,
    significant, switch,
};

pub(super) fn show(ui: &mut Ui, session: &Session, viewing: &mut Viewing, shell: &mut Shell) {
    choose_view(ui, &viewing.views, shell);
    let is_picture = viewing.views.shown().id == VIEWS[0].id;
    let viewing = &mut viewing.settings;
    heading(ui, "Exposure and tone");
    let mut ev = f64::from(viewing.exposure_ev);
    let slider = Slider::new("Exposure", -16.0, 16.0)
        .unit("EV")
        .default(0.0)
        .about("Radiance is multiplied by 2 to this power. (E, Shift E)");
    if slider.show(ui, &mut ev).changed() {
        viewing.exposure_ev = ev as f32;
        viewing.is_auto = false;
    }
    let about = "The exposure follows the picture. (Ctrl E)";
    let response = switch(ui, "Automatic exposure", &mut viewing.is_auto).on_hover_text(about);
    if response.changed() && viewing.is_auto {
        viewing.exposure_ev = session.picture.auto_exposure(viewing.part);
    }
    let names = ToneCurve::ALL.map(ToneCurve::name);
    let chosen = ToneCurve::ALL.iter().position(|t| *t == viewing.tone);
    if let Some(i) = choice_row(ui, "Tone curve", &names, about_tone, chosen.unwrap_or(0)) {
        viewing.tone = ToneCurve::ALL[i];
    }
    if is_picture {
        histogram(ui, session, viewing, shell);
    }
    rule(ui);
    heading(ui, "False colour");
    let about = "Each luminance has a colour; the legend says which. (C)";
    switch(ui, "Luminance as colour", &mut viewing.is_false_colour).on_hover_text(about);
    if viewing.is_false_colour {
        let names = ColourMap::ALL.map(ColourMap::name);
        let chosen = ColourMap::ALL.iter().position(|m| *m == viewing.map);
        let about = |i: usize| format!("Low to high luminance: {}.", ColourMap::ALL[i].about());
        if let Some(i) = choice_row(ui, "Colour map", &names, about, chosen.unwrap_or(0)) {
            viewing.map = ColourMap::ALL[i];
        }
        let mut stops = f64::from(viewing.map_stops);
        let slider = Slider::new("Luminance range", 2.0, 24.0)
            .unit("stops")
            .default(10.0)
            .about("Range of luminances, below the exposure's white, that has colours.");
        slider.show(ui, &mut stops);
        viewing.map_stops = stops as f32;
    }
    rule(ui);
    heading(ui, "Magnify");
    let size = viewing
        .zoom
        .map_or_else(|| "fits the window".to_owned(), |z| format!("{z:.2} ×"));
    fact(ui, "Magnification", &size);
    ui.horizontal(|ui| {
        for (name, about, action) in [
            ("−", "Shows the pixels half as large. (−)", Action::Zoom(-1)),
            ("+", "Shows the pixels twice as large. (+)", Action::Zoom(1)),
            (
                "Fit picture",
                "Shows the whole picture. (Z)",
                Action::ZoomFit,
            ),
        ] {
            if button(ui, name).on_hover_text(about).clicked() {
                shell.act(ui.ctx(), action);
            }
        }
    });
    hint(ui, "Ctrl wheel magnifies, right drag moves");
    let about = "Shows what the pixel under the pointer holds. (I)";
    switch(ui, "Pixel values", &mut viewing.is_probing).on_hover_text(about);
    compare(ui, session, viewing, shell);
    save(ui, shell);
}

/// How bright the pixels are, and which of them the screen cannot tell apart.
fn histogram(ui: &mut Ui, session: &Session, viewing: &ViewSettings, shell: &mut Shell) {
    let histogram = &mut shell.histogram;
    let names = ["luminance", "R G B"];
    let chosen = usize::from(histogram.channels == Channels::Rgb);
    let about = |i: usize| {
        let of = ["the luminance of pixels", "their red, green and blue"][i];
        format!("How many pixels there are of each brightness, by {of}.")
    };
    if let Some(i) = choice_row(ui, "Histogram", &names, about, chosen) {
        histogram.channels = [Channels::Luminance, Channels::Rgb][i];
    }
    ui.add_space(GRID / 2.0);
    histogram.update(session, viewing);
    if let Some(rest) = histogram.rest(session) {
        ui.ctx().request_repaint_after(rest);
    }
    histogram.show(ui);
}

/// What stands in place of the picture.
fn choose_view(ui: &mut Ui, views: &Views, shell: &mut Shell) {
    let rows: Vec<_> = views::choice().collect();
    let titles: Vec<_> = rows.iter().map(|row| row.title).collect();
    let shown = rows.iter().position(|row| row.id == views.shown().id);
    let about = |i: usize| format!("{} (N)", rows[i].about);
    if let Some(i) = choice_rows(ui, "Show", &titles, about, 3, shown) {
        shell.act(ui.ctx(), Action::View(rows[i].id));
    }
    rule(ui);
}

/// What a tone curve does, in a sentence.
fn about_tone(index: usize) -> String {
    let about = match ToneCurve::ALL[index] {
        ToneCurve::None => "No curve: what is brighter than white is cut off.",
        ToneCurve::Reinhard => "x / (1 + x) in each channel: nothing is cut off, all is darker.",
        ToneCurve::Aces => "The film look of the Academy's reference transform.",
        ToneCurve::Agx => "Film-like: bright colours fade to white.",
        ToneCurve::Neutral => "True colours up to 0.8; brighter ones are compressed.",
    };
    about.to_owned()
}

fn compare(ui: &mut Ui, session: &Session, viewing: &mut ViewSettings, shell: &mut Shell) {
    rule(ui);
    heading(ui, "Compare");
    let picture = &session.picture;
    for (i, name) in ["A", "B"].into_iter().enumerate() {
        let text = match (Side::held(i, session), i) {
            (Some(held), _) => held.label(),
            (None, 0) => "nothing held".to_owned(),
            (None, _) => "the live picture".to_owned(),
        };
        fact(ui, name, &text);
    }
    ui.horizontal(|ui| {
        let about = "Keeps the picture as it is now, to compare with. (H)";
        if button(ui, "Hold as A").on_hover_text(about).clicked() {
            shell.act(ui.ctx(), Action::HoldA);
        }
        let about = "Keeps the picture as it is now, in place of the live one. (Shift H)";
        if button(ui, "Hold as B").on_hover_text(about).clicked() {
            shell.act(ui.ctx(), Action::HoldB);
        }
    });
    let is_held = picture.held[0].is_some();
    let mut is_wiping = viewing.is_wiping;
    let mut is_less = viewing.difference == Some(Against::Held);
    ui.add_enabled_ui(is_held, |ui| {
        let about = "Shows A left of a line that can be dragged, and B right of it. (X)";
        let wipe = switch(ui, "Wipe A | B", &mut is_wiping).on_hover_text(about);
        if wipe.changed() {
            shell.act(ui.ctx(), Action::Wipe);
        }
        let about = "Shows A less B, in colours: where A is brighter, and where darker.";
        let less = switch(ui, "Difference A − B", &mut is_less).on_hover_text(about);
        if less.changed() {
            viewing.difference = is_less.then_some(Against::Held);
            viewing.is_wiping = false;
        }
    });
    if viewing.is_wiping {
        let mut place = f64::from(viewing.wipe);
        Slider::new("Wipe position", 0.0, 1.0)
            .default(0.5)
            .about("Where the line stands: 0 is the left edge of the picture, 1 the right one.")
            .show(ui, &mut place);
        viewing.wipe = place as f32;
    }
    reference(ui, picture, viewing, shell);
    let compared = Compared::of(session, viewing);
    if let Compared::Refused(why) = &compared {
        paragraph(ui, why);
    }
    if let Some(measured) = session.measuring.of(session, &compared) {
        fact(ui, "relMSE", &significant(measured.rel_mse, 3));
        fact(ui, "FLIP", &significant(measured.flip, 3));
    }
}

fn reference(ui: &mut Ui, picture: &Picture, viewing: &mut ViewSettings, shell: &mut Shell) {
    ui.add_space(GRID);
    match &picture.reference {
        Some(reference) => {
            fact(ui, "Reference", &reference.name);
            if let Some(origin) = &reference.origin {
                hint(ui, &origin.words());
            }
        }
        None => paragraph(
            ui,
            "No reference; load an EXR to see the difference from it.",
        ),
    }
    let is_entered = path_field(ui, "Reference path", &mut shell.fields.reference);
    ui.horizontal(|ui| {
        let about = "Takes the .exr file at this path for the reference.";
        let load = button(ui, "Load reference").on_hover_text(about);
        let is_pressed = load.clicked() && !shell.fields.reference.trim().is_empty();
        if is_pressed || is_entered {
            let path = PathBuf::from(shell.fields.reference.trim());
            shell.background.open_reference(path);
        }
        let about = "Chooses a reference among the files.";
        if button(ui, "Browse …").on_hover_text(about).clicked() {
            shell.background.choose(Wanted::Reference);
        }
    });
    for (i, name) in ["Use A as reference", "Use B as reference"]
        .into_iter()
        .enumerate()
    {
        let is_held = picture.held[i].is_some();
        ui.add_enabled_ui(is_held, |ui| {
            let about = "Compares with what is held, as with a reference from a file.";
            if button(ui, name).on_hover_text(about).clicked() {
                shell.refer_to_held(i);
            }
        });
    }
    let mut is_difference = viewing.difference == Some(Against::Reference);
    ui.add_enabled_ui(picture.reference.is_some(), |ui| {
        let about = "Shows the picture less the reference, in colours. (G)";
        let name = "Difference from reference";
        let response = switch(ui, name, &mut is_difference).on_hover_text(about);
        if response.changed() {
            viewing.difference = is_difference.then_some(Against::Reference);
            viewing.is_wiping = false;
        }
    });
}

fn save(ui: &mut Ui, shell: &mut Shell) {
    rule(ui);
    heading(ui, "Save and copy");
    ui.horizontal(|ui| {
        let about = "Writes what is shown to a PNG file in the current folder. (Ctrl S)";
        if button(ui, "Save PNG").on_hover_text(about).clicked() {
            shell.act(ui.ctx(), Action::SavePng);
        }
        let about = "Writes what is shown to a PNG file of a name to be chosen.";
        if button(ui, "Save as …").on_hover_text(about).clicked() {
            shell.save_as();
        }
    });
    ui.horizontal_wrapped(|ui| {
        for (name, about, action) in [
            (
                "Copy state",
                "Copies all that is chosen as text, to paste elsewhere. (Ctrl Shift C)",
                Action::CopyState,
            ),
            (
                "Copy command",
                "Copies the command that renders the same. (Ctrl Shift L)",
                Action::CopyCommand,
            ),
        ] {
            if button(ui, name).on_hover_text(about).clicked() {
                shell.act(ui.ctx(), action);
            }
        }
    });
    let about = "Shows the picture and its layers in tev while they are rendered. (Ctrl Shift T)";
    let mut is_on = shell.sending.is_on();
    if switch(ui, "Send to tev", &mut is_on)
        .on_hover_text(about)
        .changed()
    {
        shell.act(ui.ctx(), Action::SendToTev);
    }
}
