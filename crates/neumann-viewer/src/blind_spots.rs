//! What a method cannot see of a scene, for the note on the picture.

use neumann_core::bsdf::microfacet::SMOOTH_ALPHA;
use neumann_core::film::View;
use neumann_core::integrator::Sight;
use neumann_core::scene::Appearance;

/// What is missing from a view of the scene, in a line; `None` if nothing is.
///
/// Emitted light is seen by every method, so the term `L_e` never lacks anything.
#[must_use]
pub fn note(sight: Sight, scene: &Appearance, view: View, n_layers: usize) -> Option<String> {
    let layers = view.layers(n_layers)?;
    if layers.end <= 1 {
        return None;
    }
    let mut missing = Vec::new();
    if !sight.punctual_lights && has_punctual_lights(scene) {
        missing.push("light from point, spot and directional lights");
    }
    if has_smooth_surfaces(scene) {
        if !sight.delta_surfaces {
            missing.push("light by way of mirrors and smooth glass");
        } else if !sight.delta_to_camera {
            missing.push("mirrors and smooth glass seen directly");
        }
    }
    (!missing.is_empty()).then(|| format!("missing: {}", missing.join("; ")))
}

fn has_punctual_lights(scene: &Appearance) -> bool {
    let mut levels = scene.light_levels.iter();
    levels.any(|level| level.is_on && level.brightness > 0.0)
}

fn has_smooth_surfaces(scene: &Appearance) -> bool {
    scene.materials.iter().any(|material| {
        let is_smooth = material.roughness * material.roughness < SMOOTH_ALPHA;
        is_smooth && !material.is_unlit
    })
}

#[cfg(test)]
mod tests {
    use neumann_core::film::View;
    use neumann_core::integrator::method;
    use neumann_core::scene::Scene;
    use neumann_core::scene::builtin::builtin;

    use super::note;

    fn note_on(scene: &str, id: &str, view: View) -> Option<String> {
        let description = builtin(scene).unwrap().load().unwrap();
        let scene = Scene::build(&description);
        note(method(id).unwrap().sight, scene.appearance(), view, 8)
    }

    #[test]
    fn only_what_the_scene_has_can_be_missing() {
        assert_eq!(note_on("cornell", "lt", View::Total), None);
        let glass = note_on("cornell-glass", "lt", View::Total).unwrap();
        assert!(glass.contains("mirrors"), "{glass}");
        assert_eq!(note_on("cornell-glass", "lt", View::Term(0)), None);
        assert_eq!(note_on("cornell-glass", "bdpt", View::Total), None);
    }
}
