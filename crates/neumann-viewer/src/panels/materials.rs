//! Materials: the one chosen from the list can be edited.

use egui::Ui;
use neumann_core::radiometry::Rgb;
use neumann_core::scene::description::MaterialDescription;

use crate::setup::Setup;
use crate::widgets::{Slider, button, color_sliders, fold, hint, row_button};

pub(super) fn show(ui: &mut Ui, setup: &mut Setup, edited_one: &mut Option<usize>) {
    let Some(open) = &setup.open else { return };
    if !fold(ui, "Materials", false) {
        return;
    }
    let appearance = open.scene.appearance();
    // The last one is the default of meshes without a material.
    let n_materials = appearance.materials.len().saturating_sub(1);
    if n_materials == 0 {
        hint(ui, "the file has none");
    }
    let mut edited: Option<(usize, MaterialDescription)> = None;
    for (i, material) in appearance.materials.iter().take(n_materials).enumerate() {
        let name = if material.name.is_empty() {
            format!("material {i}")
        } else {
            material.name.clone()
        };
        let is_chosen = *edited_one == Some(i);
        let original = open.original.materials.get(i);
        let remark = if original == Some(material) {
            ""
        } else {
            "edited"
        };
        if row_button(ui, &name, remark, is_chosen).clicked() {
            *edited_one = (!is_chosen).then_some(i);
        }
        if is_chosen {
            let mut changed = material.clone();
            if ui.push_id(i, |ui| editor(ui, &mut changed, original)).inner {
                edited = Some((i, changed));
            }
        }
    }
    if let Some((i, material)) = edited {
        let mut appearance = appearance.clone();
        appearance.materials[i] = material;
        setup.dress(appearance);
    }
}

/// The controls of one material; true when it was changed.
fn editor(
    ui: &mut Ui,
    material: &mut MaterialDescription,
    original: Option<&MaterialDescription>,
) -> bool {
    let mut is_changed = color_sliders(ui, "Base colour", &mut material.base_color, 1.0);
    let default = MaterialDescription::default();
    let original = original.unwrap_or(&default);
    let mut number = |name: &str, value: &mut f32, home: f32, min: f64, max: f64| {
        let mut wide = f64::from(*value);
        let slider = Slider::new(name, min, max).default(f64::from(home));
        if slider.show(ui, &mut wide).changed() {
            *value = wide as f32;
            is_changed = true;
        }
    };
    number(
        "Roughness",
        &mut material.roughness,
        original.roughness,
        0.0,
        1.0,
    );
    number(
        "Metallic",
        &mut material.metallic,
        original.metallic,
        0.0,
        1.0,
    );
    number(
        "Specular",
        &mut material.specular,
        original.specular,
        0.0,
        1.0,
    );
    number(
        "Transmission",
        &mut material.transmission,
        original.transmission,
        0.0,
        1.0,
    );
    number(
        "Index of refraction",
        &mut material.ior,
        original.ior,
        1.0,
        3.0,
    );
    let mut strength = f64::from(material.emission.max_channel());
    let emission = Slider::new("Emission", 0.0, 1000.0)
        .logarithmic(true)
        .default(f64::from(original.emission.max_channel()))
        .about("Radiance of the brightest channel, W m⁻² sr⁻¹.");
    if emission.show(ui, &mut strength).changed() {
        material.emission = with_strength(material.emission, original.emission, strength as f32);
        is_changed = true;
    }
    if material != original && button(ui, "As in the file").clicked() {
        material.clone_from(original);
        is_changed = true;
    }
    is_changed
}

/// The same hue with another largest channel; that of the file, or white, where there was none.
fn with_strength(now: Rgb, original: Rgb, strength: f32) -> Rgb {
    let hue = [now, original]
        .into_iter()
        .find(|c| !c.is_black())
        .unwrap_or(Rgb::WHITE);
    hue * (strength / hue.max_channel())
}
