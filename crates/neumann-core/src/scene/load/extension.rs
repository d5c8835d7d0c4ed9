//! Which glTF extensions are honoured.

use super::error::{Fault, quoted};
use super::json::Document;

/// Extensions that are read and mean what they say.
const SUPPORTED: [&str; 15] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Not read, but a file that requires them can be shown without: `basisu` textures are
/// dropped, each with a warning; of variants the materials that the primitives name are shown.
const TOLERATED: [&str; 2] = ["KHR_texture_basisu", "KHR_materials_variants"];

/// Materials of another kind than glTF's own.
pub(super) const GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";

/// What to do about them.
pub(super) const CONVERT_GLOSSINESS: &str = "convert the file with \
    'npx @gltf-transform/cli metalrough in.glb out.glb'";

/// The extensions that a file uses, sorted by what becomes of them.
#[derive(Debug, Default)]
pub(super) struct Extensions {
    pub(super) used: Vec<String>,
    pub(super) ignored: Vec<String>,
}

/// True if an extension is read and means what it says.
pub(super) fn is_supported(name: &str) -> bool {
    SUPPORTED.contains(&name)
}

/// Reads `extensionsUsed` and refuses what `extensionsRequired` asks in vain.
pub(super) fn read(document: &Document) -> Result<Extensions, Fault> {
    let root = document.root();
    let mut extensions = Extensions::default();
    for key in ["extensionsUsed", "extensionsRequired"] {
        for (i, value) in root.list(key)?.iter().enumerate() {
            let field = format!("{key}[{i}]");
            let Some(name) = value.as_str() else {
                return Err(Fault::broken(field, "is not a string"));
            };
            let is_supported = SUPPORTED.contains(&name);
            if key == "extensionsRequired" && !is_supported && !TOLERATED.contains(&name) {
                return Err(unsupported(&field, name));
            }
            let list = if is_supported {
                &mut extensions.used
            } else {
                &mut extensions.ignored
            };
            list.push(name.to_owned());
        }
    }
    for list in [&mut extensions.used, &mut extensions.ignored] {
        list.sort();
        list.dedup();
    }
    Ok(extensions)
}

fn unsupported(field: &str, name: &str) -> Fault {
    let remedy = match name {
        GLOSSINESS => CONVERT_GLOSSINESS,
        _ => "export the scene without this extension",
    };
    Fault::new(
        field,
        format!("requires {}, which cannot be read", quoted(name)),
        remedy,
    )
}

#[cfg(test)]
mod tests {
    use super::super::json::Document;
    use super::{GLOSSINESS, read};

    #[test]
    fn unsupported_requirements_are_named() {
        let parse = |text: &str| Document::parse(text.as_bytes()).unwrap();
        let document = parse(
            r#"{"extensionsUsed":["KHR_materials_ior","KHR_x"],
                "extensionsRequired":["KHR_texture_transform"]}"#,
        );
        let extensions = read(&document).unwrap();
        assert_eq!(
            extensions.used,
            ["KHR_materials_ior", "KHR_texture_transform"]
        );
        assert_eq!(extensions.ignored, ["KHR_x"]);
        let document = parse(r#"{"extensionsRequired":["KHR_x"]}"#);
        let fault = read(&document).unwrap_err();
        assert!(fault.problem.contains("KHR_x"));
        assert_eq!(fault.field, "extensionsRequired[0]");
        let document = parse(&format!(r#"{{"extensionsRequired":["{GLOSSINESS}"]}}"#));
        assert!(read(&document).unwrap_err().remedy.contains("metalrough"));
        let document = parse(r#"{"extensionsRequired":["KHR_materials_variants"]}"#);
        assert_eq!(read(&document).unwrap().ignored, ["KHR_materials_variants"]);
    }
}
