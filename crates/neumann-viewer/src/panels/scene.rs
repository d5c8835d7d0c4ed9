//! The scene: what it is, where others are, its lights, materials and environment.

use egui::Ui;
use neumann_core::scene::Backs;
use neumann_core::scene::builtin::BUILTINS;

use crate::notices::{Notices, Offer};
use crate::scene_source::Wanted;
use crate::session::Session;
use crate::setup::Setup;
use crate::shell::Shell;
use crate::theme::GRID;
use crate::widgets::{
    button, fact, fold, heading, hint, paragraph, path_field, row_button, rule, settled, switch,
};

pub(super) fn show(ui: &mut Ui, session: &mut Session, shell: &mut Shell) {
    let setup = &mut session.setup;
    about(ui, setup);
    ui.add_space(GRID);
    let is_entered = path_field(ui, "Scene path", &mut shell.fields.scene);
    ui.horizontal(|ui| {
        let about =
            "Opens the file at this path, a scene or a state, or a built-in scene by its name.";
        let is_pressed = button(ui, "Open scene").on_hover_text(about).clicked();
        if (is_pressed || is_entered) && !shell.fields.scene.trim().is_empty() {
            let path = shell.fields.scene.trim().to_owned();
            shell.open_scene(path);
        }
        let about = "Chooses a scene or a state among the files. (Ctrl O)";
        if button(ui, "Browse …").on_hover_text(about).clicked() {
            shell.background.choose(Wanted::Scene);
        }
    });
    hint(ui, "Or drop a .gltf or .glb file here");

    if fold(ui, "Built-in scenes", true) {
        let open = setup.open.as_ref().map(|open| open.source.as_str());
        if let Some(name) = crate::gallery::show(ui, &mut shell.gallery, open) {
            shell.open_scene(name);
        }
    }
    if !shell.recent.paths().is_empty() && fold(ui, "Recent files", false) {
        let paths = shell.recent.paths().to_vec();
        for path in paths {
            let name = std::path::Path::new(&path)
                .file_name()
                .map_or_else(|| path.clone(), |n| n.to_string_lossy().into_owned());
            let response = row_button(ui, &name, "", false);
            if response.clicked() {
                shell.open_scene(path.as_str());
            }
            response.on_hover_text(path);
        }
    }
    if setup.open.is_some() {
        rule(ui);
        heading(ui, "Edits");
        paragraph(ui, "Shift click on the picture shows the material there.");
        ui.add_space(GRID / 2.0);
        super::history::show(ui, &session.history, shell);
        backs(ui, setup, &mut shell.notices);
        super::lights::show(ui, setup, shell);
        super::materials::show(ui, setup, shell);
        warnings(ui, setup);
    }
}

fn about(ui: &mut Ui, setup: &Setup) {
    let Some(open) = &setup.open else {
        heading(ui, "No scene");
        paragraph(ui, "Open one below.");
        return;
    };
    heading(ui, open.short_name());
    let builtin = BUILTINS.iter().find(|b| b.name == open.source);
    let about = open.scene.about().or(builtin.map(|b| b.about));
    let about = about.unwrap_or_else(|| open.scene.name());
    if about != open.short_name() {
        paragraph(ui, about);
    }
    ui.add_space(GRID / 2.0);
    let statistics = open.scene.statistics();
    fact(ui, "Triangles", &statistics.n_triangles.to_string());
    fact(
        ui,
        "Emissive triangles",
        &statistics.n_area_lights.to_string(),
    );
    if statistics.n_punctual_lights > 0 {
        fact(
            ui,
            "Punctual lights",
            &statistics.n_punctual_lights.to_string(),
        );
    }
}

/// Whether the camera looks through the backs of single-sided surfaces, where there are any.
fn backs(ui: &mut Ui, setup: &mut Setup, notices: &mut Notices) {
    let Some(open) = &setup.open else { return };
    // Glass has no back: a material that is made transparent may have been the last one with one.
    if !settled(ui, "backs", open.scene.has_backs()) {
        return;
    }
    let mut is_on = open.scene.appearance().backs == Backs::SeeThrough;
    let response = switch(ui, "Look through backs", &mut is_on);
    if response.changed() {
        notices.withdraw(|offer| matches!(offer, Offer::LookThroughBacks));
        let backs = [Backs::Solid, Backs::SeeThrough][usize::from(is_on)];
        setup.choose_backs(backs);
    }
    response.on_hover_text(
        "Single-sided surfaces that the camera sees from behind are left out: the walls of a room \
         from outside, the hull that draws a model's outline. To light they stay solid, unless \
         they are unlit.",
    );
}

fn warnings(ui: &mut Ui, setup: &Setup) {
    let Some(open) = &setup.open else { return };
    let warnings = open.scene.warnings();
    if warnings.is_empty() || !fold(ui, "Warnings", false) {
        return;
    }
    const MOST: usize = 40;
    for warning in warnings.iter().take(MOST) {
        paragraph(ui, warning);
    }
    if warnings.len() > MOST {
        paragraph(ui, &format!("And {} more", warnings.len() - MOST));
    }
}
