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
    let slider = Slider::new("Exposure", -16.0, 16.0).unit("EV").default(0.0);
    if slider.show(ui, &mut ev).changed() {
        viewing.exposure_ev = ev as f32;
        viewing.is_auto = false;
    }
    if switch(ui, "Automatic", &mut viewing.is_auto).changed() && viewing.is_auto {
        viewing.exposure_ev = session.picture.auto_exposure(viewing.part);
    }
    let names = ToneCurve::ALL.map(ToneCurve::name);
    let chosen = ToneCurve::ALL.iter().position(|t| *t == viewing.tone);
    if let Some(i) = choice_row(ui, "Tone curve", &names, chosen.unwrap_or(0)) {
        viewing.tone = ToneCurve::ALL[i];
    }
    if is_picture {
        histogram(ui, session, viewing, shell);
    }
    rule(ui);
    heading(ui, "False colour");
    switch(ui, "Luminance as colour", &mut viewing.is_false_colour);
    if viewing.is_false_colour {
        let names = ColourMap::ALL.map(ColourMap::name);
        let chosen = ColourMap::ALL.iter().position(|m| *m == viewing.map);
        if let Some(i) = choice_row(ui, "Colours", &names, chosen.unwrap_or(0)) {
            viewing.map = ColourMap::ALL[i];
        }
        let mut stops = f64::from(viewing.map_stops);
        let slider = Slider::new("Span", 2.0, 24.0).unit("stops").default(10.0);
        slider.show(ui, &mut stops);
        viewing.map_stops = stops as f32;
    }
    rule(ui);
    heading(ui, "Magnify");
    let size = viewing
        .zoom
        .map_or_else(|| "whole picture".to_owned(), |z| format!("{z:.2} ×"));
    fact(ui, "Pixels", &size);
    ui.horizontal(|ui| {
        for (name, action) in [
            ("−", Action::Zoom(-1)),
            ("+", Action::Zoom(1)),
            ("Whole", Action::ZoomFit),
        ] {
            if button(ui, name).clicked() {
                shell.act(ui.ctx(), action);
            }
        }
    });
    hint(ui, "or the wheel with Ctrl; right drag moves");
    switch(ui, "Values of the pixel", &mut viewing.is_probing);
    compare(ui, session, viewing, shell);
    save(ui, shell);
}

/// How bright the pixels are, and which of them the screen cannot tell apart.
fn histogram(ui: &mut Ui, session: &Session, viewing: &ViewSettings, shell: &mut Shell) {
    let histogram = &mut shell.histogram;
    let names = ["luminance", "R G B"];
    let chosen = usize::from(histogram.channels == Channels::Rgb);
    if let Some(i) = choice_row(ui, "Histogram", &names, chosen) {
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
        if button(ui, "Hold as A").clicked() {
            shell.act(ui.ctx(), Action::HoldA);
        }
        if button(ui, "Hold as B").clicked() {
            shell.act(ui.ctx(), Action::HoldB);
        }
    });
    let is_held = picture.held[0].is_some();
    let mut is_wiping = viewing.is_wiping;
    let mut is_less = viewing.difference == Some(Against::Held);
    ui.add_enabled_ui(is_held, |ui| {
        if switch(ui, "Wipe A | B", &mut is_wiping).changed() {
            shell.act(ui.ctx(), Action::Wipe);
        }
        if switch(ui, "A − B", &mut is_less).changed() {
            viewing.difference = is_less.then_some(Against::Held);
            viewing.is_wiping = false;
        }
    });
    if viewing.is_wiping {
        let mut place = f64::from(viewing.wipe);
        Slider::new("Place of the wipe", 0.0, 1.0)
            .default(0.5)
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
    let is_entered = path_field(ui, "Path of a reference", &mut shell.fields.reference);
    ui.horizontal(|ui| {
        let is_pressed = button(ui, "Load").clicked() && !shell.fields.reference.trim().is_empty();
        if is_pressed || is_entered {
            let path = PathBuf::from(shell.fields.reference.trim());
            shell.background.open_reference(path);
        }
        if button(ui, "Browse …").clicked() {
            shell.background.choose(Wanted::Reference);
        }
    });
    for (i, name) in ["Use A as reference", "Use B as reference"]
        .into_iter()
        .enumerate()
    {
        let is_held = picture.held[i].is_some();
        ui.add_enabled_ui(is_held, |ui| {
            if button(ui, name).clicked() {
                shell.refer_to_held(i);
            }
        });
    }
    let mut is_difference = viewing.difference == Some(Against::Reference);
    ui.add_enabled_ui(picture.reference.is_some(), |ui| {
        if switch(ui, "Difference", &mut is_difference).changed() {
            viewing.difference = is_difference.then_some(Against::Reference);
            viewing.is_wiping = false;
        }
    });
}

fn save(ui: &mut Ui, shell: &mut Shell) {
    rule(ui);
    heading(ui, "Save what is shown");
    ui.horizontal(|ui| {
        if button(ui, "Save").clicked() {
            shell.act(ui.ctx(), Action::SavePng);
        }
        if button(ui, "Save as …").clicked() {
            shell.save_as();
        }
    });
}
