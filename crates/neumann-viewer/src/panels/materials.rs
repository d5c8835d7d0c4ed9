//! Materials: the one chosen from the list can be edited.

use egui::Ui;
use neumann_core::radiometry::Rgb;
use neumann_core::scene::Scene;
use neumann_core::scene::description::MaterialDescription;

use crate::pick::Picked;
use crate::setup::{Setup, name_or};
use crate::shell::Shell;
use crate::widgets::{
    Slider, button, color_row, color_sliders, fold_opened, hint, hue_row, paragraph, row_button,
    settled,
};

pub(super) fn show(ui: &mut Ui, setup: &mut Setup, shell: &mut Shell) {
    let Some(open) = &setup.open else { return };
    let reveals = shell.reveals_pick && matches!(shell.picked, Some(Picked::Surface { .. }));
    if !fold_opened(ui, "Materials", false, reveals) {
        return;
    }
    let appearance = open.scene.appearance();
    let n_materials = n_listed(&open.scene);
    if n_materials == 0 {
        hint(ui, "The file has none");
    }
    let mut edited: Option<(usize, MaterialDescription)> = None;
    for (i, material) in appearance.materials.iter().take(n_materials).enumerate() {
        let name = name_or(&material.name, "Material", i);
        let is_chosen = shell.material == Some(i);
        let original = open.original.materials.get(i);
        let remark = if original == Some(material) {
            ""
        } else {
            "edited"
        };
        let row = row_button(ui, &name, remark, is_chosen);
        let row = row.on_hover_text("Shows the values of the material, or hides them.");
        if row.clicked() {
            shell.material = (!is_chosen).then_some(i);
        }
        if !is_chosen {
            continue;
        }
        if reveals {
            row.scroll_to_me(Some(egui::Align::Min));
        }
        if let Some(Picked::Surface { material, place }) = &shell.picked
            && *material == i
        {
            paragraph(ui, place);
        }
        let mut changed = material.clone();
        let edits = ui.push_id(i, |ui| editor(ui, &name, &mut changed, original));
        if edits.inner {
            edited = Some((i, changed));
        }
    }
    if let Some((i, material)) = edited {
        let mut appearance = appearance.clone();
        appearance.materials[i] = material;
        setup.dress(appearance);
    }
}

/// The last material is the default of meshes without one; it is listed where there are some.
fn n_listed(scene: &Scene) -> usize {
    let n = scene.appearance().materials.len();
    let mut meshes = scene.geometry().meshes().iter();
    let is_used = meshes.any(|mesh| mesh.material as usize + 1 == n);
    if is_used { n } else { n.saturating_sub(1) }
}

/// The controls of one material; true when it was changed.
fn editor(
    ui: &mut Ui,
    name: &str,
    material: &mut MaterialDescription,
    original: Option<&MaterialDescription>,
) -> bool {
    let default = MaterialDescription::default();
    let original = original.unwrap_or(&default);
    let mut is_changed = color_sliders(
        ui,
        "Base colour",
        name,
        &mut material.base_color,
        "Multiplies the texture of the base colour, if there is one.",
    );
    let mut number = |name: &str, value: &mut f32, home: f32, (min, max): (f64, f64), about| {
        let mut wide = f64::from(*value);
        let slider = Slider::new(name, min, max)
            .default(f64::from(home))
            .about(about);
        if slider.show(ui, &mut wide).changed() {
            *value = wide as f32;
            is_changed = true;
        }
    };
    number(
        "Roughness",
        &mut material.roughness,
        original.roughness,
        (0.0, 1.0),
        "Perceptual roughness: 0 is a mirror, 1 is matt.",
    );
    number(
        "Metallic",
        &mut material.metallic,
        original.metallic,
        (0.0, 1.0),
        "0 is a dielectric, 1 a metal.",
    );
    number(
        "Specular",
        &mut material.specular,
        original.specular,
        (0.0, 1.0),
        "Strength of the dielectric's reflection.",
    );
    number(
        "Transmission",
        &mut material.transmission,
        original.transmission,
        (0.0, 1.0),
        "Share of the light that passes into the dielectric instead of being scattered back.",
    );
    number(
        "Index of refraction",
        &mut material.ior,
        original.ior,
        (1.0, 3.0),
        "Bends light that passes, and decides how much is reflected: 1.5 is glass, 1.33 water.",
    );
    is_changed |= color_row(
        ui,
        "Specular colour",
        name,
        &mut material.specular_color,
        "Colour of the dielectric's reflection at normal incidence.",
    );
    if let Some(volume) = &mut material.volume
        && volume.attenuation_distance.is_finite()
    {
        is_changed |= color_row(
            ui,
            "Volume colour",
            name,
            &mut volume.attenuation_color,
            "Transmittance of the inside over its attenuation distance.",
        );
    }
    is_changed |= emission(ui, name, material, original);
    let is_edited = settled(ui, "edited", material != original);
    let about = "Takes all values of the material from the file again.";
    if is_edited && button(ui, "Reset material").on_hover_text(about).clicked() {
        material.clone_from(original);
        is_changed = true;
    }
    is_changed
}

/// Emission: its strength, and its colour apart from it.
fn emission(
    ui: &mut Ui,
    name: &str,
    material: &mut MaterialDescription,
    original: &MaterialDescription,
) -> bool {
    let key = ui.scope_id().with("hue of emission");
    let kept = ui.data(|d| d.get_temp::<[f32; 3]>(key));
    let kept = kept.map_or(Rgb::BLACK, |[r, g, b]| Rgb::new(r, g, b));
    let mut strength = f64::from(material.emission.max_channel());
    let slider = Slider::new("Emission", 0.0, 1000.0)
        .logarithmic(true)
        .default(f64::from(original.emission.max_channel()))
        .unit("W m⁻² sr⁻¹")
        .about("Radiance of the brightest channel.");
    let mut is_changed = slider.show(ui, &mut strength).changed();
    if is_changed {
        let hues = [material.emission, kept, original.emission];
        material.emission = with_strength(hues, strength as f32);
    }
    is_changed |= hue_row(
        ui,
        "Emission colour",
        name,
        &mut material.emission,
        "Colour of what the material emits.",
    );
    // A lamp that is turned down to nothing comes back with its colour.
    if !material.emission.is_black() {
        ui.data_mut(|d| d.insert_temp(key, material.emission.to_array()));
    }
    is_changed
}

/// The first hue that is one, white otherwise, with that largest channel.
fn with_strength(hues: [Rgb; 3], strength: f32) -> Rgb {
    let hue = hues.into_iter().find(|c| !c.is_black());
    let hue = hue.unwrap_or(Rgb::WHITE);
    hue * (strength / hue.max_channel())
}
