//! The method: what it is, what it cannot see, its parameters, how deep and how long.

use egui::Ui;
use neumann_core::integrator::{
    METHODS, NOTATION, Parameter, ParameterKind, ParameterValues, Value,
};
use neumann_core::render::StopRule;

use crate::formula;
use crate::keys::Action;
use crate::panels::Page;
use crate::render_link::RenderLink;
use crate::session::Session;
use crate::setup::Setup;
use crate::shell::Shell;
use crate::theme::{GRID, Palette};
use crate::views::{VIEWS, Views};
use crate::widgets::{
    Slider, button, choice_row, explained_choice, fold, heading, paragraph, rule, switch,
};

pub(super) fn show(ui: &mut Ui, session: &mut Session, views: &Views, shell: &mut Shell) {
    let setup = &mut session.setup;
    let method = setup.method();
    heading(ui, method.name);
    paragraph(ui, method.about);
    if !method.blind_spots.is_empty() {
        ui.add_space(GRID / 2.0);
        paragraph(ui, &format!("Cannot see: {}", method.blind_spots));
    }
    if let Some(bias) = method.bias {
        ui.add_space(GRID / 2.0);
        paragraph(ui, &format!("Biased: {bias}"));
    }
    ui.add_space(GRID);
    formula::lines(ui, method.formula, Palette::of(ui).text);
    if fold(ui, "Pseudo-code", false) {
        formula::lines(ui, method.pseudo_code, Palette::of(ui).text);
        ui.add_space(GRID);
        paragraph(ui, &NOTATION.replace('\n', " "));
    }
    view_buttons(ui, setup, views, shell);
    ui.add_space(GRID);
    let values = &mut setup.values[setup.method];
    for parameter in METHODS[setup.method].parameters {
        setup.is_changed |= parameter_row(ui, parameter, values);
    }
    rule(ui);
    heading(ui, "Series");
    let mut bounces = f64::from(setup.max_bounces);
    let longest = Slider::new("Maximum bounces", 0.0, 128.0)
        .step(1.0)
        .default(16.0)
        .about("Terms with more scattering events than this are not computed.");
    if longest.show(ui, &mut bounces).changed() {
        setup.max_bounces = bounces as u32;
        setup.is_changed = true;
    }
    let mut layers = setup.n_layers as f64;
    let kept = Slider::new("Terms kept apart", 1.0, 16.0)
        .step(1.0)
        .default(8.0)
        .about("Light scattered more often goes into the tail.");
    if kept.show(ui, &mut layers).changed() {
        setup.n_layers = layers as usize;
        setup.is_changed = true;
    }
    let mut seed = setup.seed as f64;
    let seeds = Slider::new("Seed", 0.0, 999.0)
        .step(1.0)
        .default(0.0)
        .about("Chooses the random numbers; the same seed makes the same picture.");
    if seeds.show(ui, &mut seed).changed() {
        setup.seed = seed as u64;
        setup.is_changed = true;
    }
    rule(ui);
    heading(ui, "Run");
    run(ui, setup, &mut session.link);
}

/// A button for each view that this method and scene can be shown by.
fn view_buttons(ui: &mut Ui, setup: &Setup, views: &Views, shell: &mut Shell) {
    let of_page = VIEWS.iter().filter(|row| row.page == Page::Method);
    let shown = of_page.filter(|row| (row.refusal)(setup).is_none());
    ui.add_space(GRID);
    ui.horizontal_wrapped(|ui| {
        for row in shown {
            let (name, about) = if views.shown().id == row.id {
                ("Show picture", "Goes back to the picture.")
            } else {
                (row.title, row.about)
            };
            let key = row.key.as_ref().map(|line| format!(" ({})", line.keys));
            let about = format!("{about}{}", key.unwrap_or_default());
            if button(ui, name).on_hover_text(about).clicked() {
                shell.act(ui.ctx(), Action::View(row.id));
            }
        }
    });
}

fn run(ui: &mut Ui, setup: &mut Setup, link: &mut RenderLink) {
    ui.horizontal(|ui| {
        let is_paused = link.is_paused();
        let (name, about) = if is_paused {
            ("Resume", "Goes on with the samples that are there. (Space)")
        } else {
            (
                "Pause",
                "Keeps all samples; Resume goes on with them. (Space)",
            )
        };
        if button(ui, name).on_hover_text(about).clicked() {
            link.pause(!is_paused);
        }
        let about = "Begins anew, without the samples so far. (R)";
        if button(ui, "Restart").on_hover_text(about).clicked() {
            setup.is_changed = true;
        }
    });
    let before = setup.stop;
    let chosen = match before {
        StopRule::Never => 0,
        StopRule::Iterations(_) => 1,
        StopRule::Seconds(_) => 2,
    };
    const ENDS: [&str; 3] = [
        "Rendering goes on until it is paused.",
        "Rendering ends after so many iterations.",
        "Rendering ends after so many seconds, pauses left out.",
    ];
    let about = |i: usize| format!("{} A change of it begins nothing anew.", ENDS[i]);
    let names = ["never", "iterations", "seconds"];
    match choice_row(ui, "Stop after", &names, about, chosen) {
        Some(0) => setup.stop = StopRule::Never,
        Some(1) => setup.stop = StopRule::Iterations(256),
        Some(_) => setup.stop = StopRule::Seconds(60.0),
        None => {}
    }
    match &mut setup.stop {
        StopRule::Never => {}
        StopRule::Iterations(n) => {
            let mut number = f64::from(*n);
            let slider = Slider::new("Iterations", 1.0, 65536.0)
                .step(1.0)
                .about("Iterations after which rendering ends.")
                .logarithmic(true);
            slider.show(ui, &mut number);
            *n = number as u32;
        }
        StopRule::Seconds(seconds) => {
            let slider = Slider::new("Time", 1.0, 36000.0)
                .unit("s")
                .about("Time of rendering after which it ends.")
                .logarithmic(true);
            slider.show(ui, seconds);
        }
    }
    if setup.stop != before {
        link.stop_after(setup.stop);
    }
}

/// What 0 means, where it is no number.
fn word_for_zero(parameter: &str) -> &'static str {
    match parameter {
        "gather" => "off",
        "nearest" => "all",
        _ => "",
    }
}

/// A control for a parameter; true when its value was changed.
fn parameter_row(ui: &mut Ui, parameter: &'static Parameter, values: &mut ParameterValues) -> bool {
    let current = values.value(parameter.name);
    let value = current.unwrap_or_else(|| parameter.default_value());
    let changed = match (parameter.kind, value) {
        (ParameterKind::Integer { default, min, max }, Value::Integer(v)) => {
            let mut number = v as f64;
            Slider::new(parameter.title, min as f64, max as f64)
                .step(1.0)
                .default(default as f64)
                .unit(parameter.unit)
                .about(parameter.about)
                .zero(word_for_zero(parameter.name))
                .logarithmic(min > 0 && max / min.max(1) > 100)
                .show(ui, &mut number)
                .changed()
                .then_some(Value::Integer(number as i64))
        }
        (
            ParameterKind::Real {
                default,
                min,
                max,
                is_logarithmic,
            },
            Value::Real(v),
        ) => {
            let mut number = v;
            Slider::new(parameter.title, min, max)
                .default(default)
                .unit(parameter.unit)
                .about(parameter.about)
                .logarithmic(is_logarithmic)
                .show(ui, &mut number)
                .changed()
                .then_some(Value::Real(number))
        }
        (ParameterKind::Switch { .. }, Value::Switch(v)) => {
            let mut is_on = v;
            let response = switch(ui, parameter.title, &mut is_on);
            let is_changed = response.changed();
            response.on_hover_text(parameter.about);
            is_changed.then_some(Value::Switch(is_on))
        }
        (ParameterKind::Choice { options, .. }, Value::Choice(v)) => {
            explained_choice(ui, parameter.title, parameter.about, options, v).map(Value::Choice)
        }
        _ => None,
    };
    match changed.filter(|new| *new != value) {
        Some(new) => {
            values.put(parameter.name, new);
            true
        }
        None => false,
    }
}
