//! Lights: on or off, brighter or darker; the environment.

use std::path::PathBuf;
use std::sync::Arc;

use egui::Ui;
use neumann_core::radiometry::Rgb;
use neumann_core::scene::{Appearance, Level, Sky};

use crate::notices::{Notices, Offer};
use crate::pick::Picked;
use crate::scene_source::Wanted;
use crate::setup::{Setup, name_or};
use crate::shell::Shell;
use crate::widgets::{
    Slider, button, explained_choice, fold, fold_opened, hint, hue_row, path_field, settled, switch,
};

pub(super) fn show(ui: &mut Ui, setup: &mut Setup, shell: &mut Shell) {
    let Some(open) = &setup.open else { return };
    let mut edited = None;
    if fold(ui, "Lights", true) {
        let mut appearance = open.scene.appearance().clone();
        if lights(ui, &mut appearance) {
            edited = Some(appearance);
        }
    }
    let reveals = shell.reveals_pick && shell.picked == Some(Picked::Sky);
    if fold_opened(ui, "Environment", false, reveals) {
        let are_lights_edited = edited.is_some();
        let mut appearance = edited.unwrap_or_else(|| open.scene.appearance().clone());
        let is_changed = environment(ui, setup, shell, &mut appearance);
        edited = (is_changed || are_lights_edited).then_some(appearance);
    }
    if let Some(appearance) = edited {
        setup.dress(appearance);
    }
}

/// Takes the sky away, says what that means, and offers to put it back.
pub(crate) fn remove_sky(setup: &mut Setup, notices: &mut Notices) {
    let Some(former) = setup.snapshot() else {
        return;
    };
    notices.withdraw(|o| matches!(o, Offer::RemoveSky | Offer::PutSkyBack(_)));
    setup.choose_sky(None);
    let is_dark = setup
        .open
        .as_ref()
        .is_some_and(|open| open.scene.lights().is_empty());
    let text = if is_dark {
        "The sky is removed, and nothing shines now"
    } else {
        "The sky is removed"
    };
    notices.offer(text, "Restore sky", Offer::PutSkyBack(Box::new(former)));
}

fn lights(ui: &mut Ui, appearance: &mut Appearance) -> bool {
    /// More would make the panel a phone book.
    const MOST: usize = 24;
    let materials = appearance.materials.iter().enumerate();
    let emitters = materials.filter(|(_, material)| !material.emission.is_black());
    let emitters: Vec<usize> = emitters.map(|(i, _)| i).collect();
    // A material becomes a light, or no longer is one, while its emission is dragged further down.
    let emitters = settled(ui, "emitters", emitters);
    let n_lights = emitters.len() + appearance.lights.len();
    let mut is_changed = false;
    for i in emitters.iter().copied().take(MOST) {
        let level = appearance.material_levels.get_mut(i);
        if let (Some(material), Some(level)) = (appearance.materials.get_mut(i), level) {
            let name = name_or(&material.name, "Material", i);
            let color = &mut material.emission;
            let row = ui.push_id(("Material", i), |ui| light_row(ui, &name, level, color));
            is_changed |= row.inner;
        }
    }
    let lights = appearance
        .lights
        .iter_mut()
        .zip(&mut appearance.light_levels);
    let room = MOST.saturating_sub(emitters.len());
    for (i, (light, level)) in lights.enumerate().take(room) {
        let name = name_or(&light.name, "Light", i);
        let mut strength = light.kind.strength();
        let row = ui.push_id(("Light", i), |ui| {
            light_row(ui, &name, level, &mut strength)
        });
        if row.inner {
            light.kind.set_strength(strength);
            is_changed = true;
        }
    }
    if n_lights == 0 {
        hint(ui, "None but the environment");
    } else if n_lights > MOST {
        hint(ui, &format!("And {} more", n_lights - MOST));
    }
    is_changed
}

/// A light: on or off, brightness, colour.
fn light_row(ui: &mut Ui, name: &str, level: &mut Level, color: &mut Rgb) -> bool {
    let about = "Switches the light on or off.";
    let mut is_changed = switch(ui, name, &mut level.is_on)
        .on_hover_text(about)
        .changed();
    if level.is_on {
        let mut brightness = f64::from(level.brightness);
        let slider = Slider::new("Brightness", 0.01, 100.0)
            .unit("×")
            .about("Factor on the radiance or intensity that the file says.")
            .logarithmic(true)
            .default(1.0);
        if slider.show(ui, &mut brightness).changed() {
            level.brightness = brightness as f32;
            is_changed = true;
        }
        is_changed |= hue_row(ui, "Colour", name, color, "Colour of the light.");
    }
    is_changed
}

fn environment(
    ui: &mut Ui,
    setup: &mut Setup,
    shell: &mut Shell,
    appearance: &mut Appearance,
) -> bool {
    let mut is_changed = false;
    // Whatever it is called, a sky is named by its formula: a file of that name has an ending.
    let now = appearance.environment.as_ref();
    let chosen = match now {
        None => Some(Sky::ALL.len()),
        Some(map) => Sky::ALL.iter().position(|sky| sky.name() == map.name),
    };
    let mut names: Vec<&str> = Sky::ALL.iter().map(|sky| sky.name()).collect();
    names.push("none");
    let clicked = explained_choice(
        ui,
        "Sky",
        "What stands around the scene and shines from all sides.",
        &names,
        chosen.unwrap_or(usize::MAX),
    );
    if let Some(i) = clicked.filter(|i| Some(*i) != chosen) {
        match Sky::ALL.get(i) {
            Some(sky) => {
                let is_of_sky = |o: &Offer| matches!(o, Offer::RemoveSky | Offer::PutSkyBack(_));
                shell.notices.withdraw(is_of_sky);
                setup.choose_sky(Some(*sky));
            }
            None => remove_sky(setup, &mut shell.notices),
        }
        return false;
    }
    if let Some(map) = &appearance.environment {
        hint(ui, &format!("{}, {} × {}", map.name, map.width, map.height));
        let mut rotation = f64::from(map.rotation.to_degrees());
        let (level, tint) = (
            &mut appearance.environment_level,
            &mut appearance.environment_tint,
        );
        is_changed |= light_row(ui, "Environment light", level, tint);
        let slider = Slider::new("Rotation", -180.0, 180.0)
            .unit("°")
            .about("Turn of the environment about the vertical.")
            .default(0.0);
        if slider.show(ui, &mut rotation).changed()
            && let Some(map) = &mut appearance.environment
        {
            Arc::make_mut(map).rotation = (rotation as f32).to_radians();
            is_changed = true;
        }
    }
    let is_entered = path_field(ui, "Environment map path", &mut shell.fields.environment);
    ui.horizontal(|ui| {
        let about = "Takes the .hdr or .exr file at this path for the environment.";
        let is_pressed = button(ui, "Load map").on_hover_text(about).clicked();
        if (is_pressed || is_entered) && !shell.fields.environment.trim().is_empty() {
            let path = PathBuf::from(shell.fields.environment.trim());
            shell.background.open_environment(path);
        }
        let about = "Chooses an environment map among the files.";
        if button(ui, "Browse …").on_hover_text(about).clicked() {
            shell.background.choose(Wanted::Environment);
        }
    });
    is_changed
}
