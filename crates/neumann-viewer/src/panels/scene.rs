//! The scene: what it is, where others are, its cameras, lights, materials and environment.

use egui::{Key, Ui};
use neumann_core::scene::Backs;
use neumann_core::scene::builtin::BUILTINS;

use crate::app::App;
use crate::notices::Offer;
use crate::scene_source::Wanted;
use crate::theme::GRID;
use crate::widgets::{
    button, fact, fold, heading, hint, paragraph, row_button, switch, text_field,
};

pub(super) fn show(ui: &mut Ui, app: &mut App) {
    about(ui, app);
    ui.add_space(GRID);
    let field = text_field(ui, "path of a scene", &mut app.path);
    let is_entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
    ui.horizontal(|ui| {
        let is_pressed = button(ui, "Open").clicked();
        if (is_pressed || is_entered) && !app.path.trim().is_empty() {
            let path = app.path.trim().to_owned();
            app.open_scene(path);
        }
        if button(ui, "Browse …").clicked() {
            app.background.choose(Wanted::Scene);
        }
    });
    hint(ui, "or drop a .gltf or .glb file on the window");

    if fold(ui, "Built-in scenes", true) {
        crate::gallery::show(ui, app);
    }
    if !app.recent.paths().is_empty() && fold(ui, "Recent", false) {
        let paths = app.recent.paths().to_vec();
        for path in paths {
            let name = std::path::Path::new(&path)
                .file_name()
                .map_or_else(|| path.clone(), |n| n.to_string_lossy().into_owned());
            let response = row_button(ui, &name, "", false);
            if response.clicked() {
                app.open_scene(path.clone());
            }
            response.on_hover_text(path);
        }
    }
    if app.setup.open.is_some() {
        cameras(ui, app);
        backs(ui, app);
        super::lights::show(ui, app);
        super::materials::show(ui, app);
        warnings(ui, app);
    }
}

fn about(ui: &mut Ui, app: &App) {
    let Some(open) = &app.setup.open else {
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
    fact(ui, "triangles", &statistics.n_triangles.to_string());
    fact(
        ui,
        "of them emissive",
        &statistics.n_area_lights.to_string(),
    );
    if statistics.n_punctual_lights > 0 {
        fact(
            ui,
            "punctual lights",
            &statistics.n_punctual_lights.to_string(),
        );
    }
}

fn cameras(ui: &mut Ui, app: &mut App) {
    let Some(open) = &app.setup.open else { return };
    if open.scene.cameras().len() < 2 || !fold(ui, "Cameras", true) {
        return;
    }
    let mut chosen = None;
    for (i, camera) in open.scene.cameras().iter().enumerate() {
        let name = if camera.name.is_empty() {
            format!("camera {i}")
        } else {
            camera.name.clone()
        };
        if row_button(ui, &name, "", i == open.camera).clicked() {
            chosen = Some(i);
        }
    }
    if let Some(i) = chosen {
        app.setup.take_camera(i);
    }
}

/// Whether the camera looks through the backs of single-sided surfaces, where there are any.
fn backs(ui: &mut Ui, app: &mut App) {
    let Some(open) = &app.setup.open else { return };
    if !open.scene.has_backs() {
        return;
    }
    let mut is_on = open.scene.appearance().backs == Backs::SeeThrough;
    let response = switch(ui, "look through backs", &mut is_on);
    if response.changed() {
        app.notices.withdraw(Offer::LookThroughBacks);
        let backs = [Backs::Solid, Backs::SeeThrough][usize::from(is_on)];
        app.setup.choose_backs(backs);
    }
    response.on_hover_text(
        "Single-sided surfaces that the camera sees from behind are left out: the walls of a room \
         from outside, the hull that draws a model's outline. To light they stay solid, unless they are unlit.",
    );
}

fn warnings(ui: &mut Ui, app: &App) {
    let Some(open) = &app.setup.open else { return };
    let warnings = open.scene.warnings();
    if warnings.is_empty() || !fold(ui, "Notices", false) {
        return;
    }
    const MOST: usize = 40;
    for warning in warnings.iter().take(MOST) {
        paragraph(ui, warning);
    }
    if warnings.len() > MOST {
        paragraph(ui, &format!("and {} more", warnings.len() - MOST));
    }
}
