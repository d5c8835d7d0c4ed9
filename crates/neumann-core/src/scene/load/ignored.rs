//! What is lost where a file uses an extension that is not honoured: one sentence each.

use std::collections::BTreeSet;

use super::error::quoted;
use super::extension::Extensions;
use super::json::Document;
use super::notes::Notes;

/// Extensions that change the picture, and what it lacks without them.
const LOSSES: [(&str, &str); 17] = [
    (
        "ADOBE_materials_thin_transparency",
        "its glass is opaque; use KHR_materials_transmission",
    ),
    (
        "CESIUM_RTC",
        "its offset is left out, so that things may stand elsewhere",
    ),
    (
        "EXT_lights_ies",
        "lights of a measured distribution shine as plain ones, or not at all",
    ),
    (
        "EXT_lights_image_based",
        "its light is missing; give an environment map with --env instead",
    ),
    ("EXT_texture_avif", "its AVIF textures are missing"),
    ("KHR_gaussian_splatting", "splats are missing"),
    (
        "KHR_materials_anisotropy",
        "brushed surfaces reflect alike in every direction",
    ),
    ("KHR_materials_clearcoat", "clear coats are missing"),
    (
        "KHR_materials_diffuse_transmission",
        "light that seeps through thin surfaces is missing",
    ),
    (
        "KHR_materials_dispersion",
        "glass does not part light into colours",
    ),
    (
        "KHR_materials_iridescence",
        "the colours of thin films are missing",
    ),
    ("KHR_materials_sheen", "the sheen of cloth is missing"),
    (
        "KHR_materials_variants",
        "of the variants, the materials that the meshes themselves name are shown",
    ),
    (
        "KHR_materials_volume_scatter",
        "volumes absorb light, but do not scatter it",
    ),
    (
        "KHR_techniques_webgl",
        "materials with shaders of their own are shown without them",
    ),
    ("MSFT_texture_dds", "its DDS textures are missing"),
    ("VRMC_materials_mtoon", "cartoon shading is missing"),
];

/// Extensions without which the picture is the same, or of which others tell what is missing.
const HARMLESS: [&str; 23] = [
    "AGI_articulations",
    "AGI_stk_metadata",
    "CESIUM_primitive_outline",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_audio_emitter",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_texture_basisu",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",
    "VRM",
    "VRMC_vrm",
];

/// Warns of every extension that is not honoured and changes the picture, whether the file lists it
/// or not.
pub(super) fn note(document: &Document, extensions: &Extensions, notes: &mut Notes) {
    let mut names: BTreeSet<&str> = document.extensions_in_use();
    names.extend(extensions.ignored.iter().map(String::as_str));
    names.retain(|name| !super::extension::is_supported(name) && !HARMLESS.contains(name));
    let mut unknown = Vec::new();
    for name in names {
        match LOSSES.iter().find(|(extension, _)| *extension == name) {
            Some((_, loss)) => notes.warn(format!("{name} is ignored: {loss}")),
            None => unknown.push(quoted(name)),
        }
    }
    if !unknown.is_empty() {
        notes.warn(format!(
            "unknown extensions are ignored, and what they add is missing: {}",
            unknown.join(", ")
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::super::extension;
    use super::super::json::Document;
    use super::super::notes::Notes;
    use super::{HARMLESS, LOSSES, note};

    fn warnings(text: &str) -> Vec<String> {
        let document = Document::parse(text.as_bytes()).unwrap();
        let mut notes = Notes::default();
        note(&document, &extension::read(&document).unwrap(), &mut notes);
        notes.into_warnings()
    }

    #[test]
    fn what_changes_the_picture_is_told_in_a_line_each() {
        let told = warnings(
            r#"{"extensionsUsed":["KHR_materials_clearcoat","KHR_materials_ior",
                    "KHR_xmp_json_ld","ACME_glitter"],
                "materials":[{"extensions":{"KHR_materials_clearcoat":{},
                    "KHR_materials_sheen":{"sheenColorTexture":{"index":0,
                        "extensions":{"KHR_texture_transform":{},"ACME_twist":{}}}}}}]}"#,
        );
        assert_eq!(told.len(), 3, "{told:?}");
        assert!(told[0].starts_with("KHR_materials_clearcoat is ignored"));
        assert!(
            told[1].starts_with("KHR_materials_sheen is ignored"),
            "used without being listed"
        );
        assert!(told[2].contains("ACME_glitter") && told[2].contains("ACME_twist"));
        assert!(warnings(r#"{"extensionsUsed":["KHR_materials_unlit"]}"#).is_empty());
    }

    #[test]
    fn no_extension_is_listed_twice_or_honoured() {
        let losses = LOSSES.map(|(name, _)| name);
        let mut names: Vec<_> = losses.iter().chain(&HARMLESS).collect();
        assert!(names.iter().all(|name| !extension::is_supported(name)));
        let n = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), n);
    }
}
