//! glTF files: edits of a document that uses nearly everything, GLB containers, and accessors
//! of all kinds, whose meshes are built and traced.

use std::sync::{Arc, LazyLock};

use arbitrary::{Result, Unstructured};
use neumann_core::film::Film;
use neumann_core::integrator::{ParameterValues, method};
use neumann_core::render::{CancelToken, RenderSettings, Renderer, WorkerPool};
use neumann_core::scene::Scene;
use neumann_core::scene::description::SceneDescription;
use neumann_core::scene::load::load_bytes;
use serde_json::{Value, json};

use crate::Target;

/// Edits of a document: the structure stays, values do not.
pub(crate) const SCENE_JSON: Target = Target {
    name: "scene-json",
    run: |bytes| {
        let (mut document, buffer) = everything();
        let mut input = Unstructured::new(bytes);
        while !input.is_empty() {
            if edit(&mut document, &mut input).is_err() {
                break;
            }
        }
        load_and_render(document.to_string().as_bytes(), &buffer)
    },
    // No edit, one, and a few.
    seeds: || vec![vec![], vec![9, 0, 3], (0..24).collect()],
};

/// Bytes of a container, or of a document.
pub(crate) const GLB: Target = Target {
    name: "glb",
    run: |bytes| load_and_render(bytes, &everything().1),
    seeds: || {
        let (document, buffer) = everything();
        vec![
            container(&document, &buffer),
            document.to_string().into_bytes(),
        ]
    },
};

/// A primitive whose accessors are of any kind, over any bytes.
pub(crate) const ACCESSORS: Target = Target {
    name: "accessors",
    run: |bytes| match primitive(&mut Unstructured::new(bytes)) {
        Ok((document, buffer)) => load_and_render(document.to_string().as_bytes(), &buffer),
        Err(_) => false,
    },
    // All zero, and everything mixed.
    seeds: || {
        let mixed = (0..400_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8);
        vec![vec![0; 200], mixed.collect()]
    },
};

/// A square with a texture in a file of its own.
pub(crate) fn textured_square() -> Vec<u8> {
    let floats =
        |numbers: &[f32]| -> Vec<u8> { numbers.iter().flat_map(|n| n.to_le_bytes()).collect() };
    let positions = floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    let uvs = floats(&[0., 0., 1., 0., 0., 1.]);
    let data = |bytes: &[u8]| {
        let text: String = bytes.iter().map(|b| format!("%{b:02x}")).collect();
        json!({"uri": format!("data:,{text}"), "byteLength": bytes.len()})
    };
    let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}], "textures": [{"source": 0}], "images": [{"uri": "fuzz.png"}],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
        "materials": [material],
        "buffers": [data(&positions), data(&uvs)],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 1, "byteLength": 24}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}],
    })
    .to_string()
    .into_bytes()
}

/// A document that uses nearly everything the loader knows, and its buffer `b.bin`.
fn everything() -> (Value, Vec<u8>) {
    let mut file = Pieces::default();
    let position = file.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.]);
    let joints = file.bytes("VEC4", &[0, 1, 0, 0].repeat(4));
    let weights = file.bytes("VEC4", &[255, 255, 0, 0].repeat(4));
    let moved = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let uvs = file.floats("VEC2", &[0., 0., 1., 0., 0., 1., 1., 1.]);
    let tangents = file.floats("VEC4", &[1., 0., 0., 1.].repeat(4));
    let indices = file.bytes("SCALAR", &[0, 1, 2, 2, 1, 3]);
    let (sparse_indices, sparse_values) = (file.view(&[1]), file.view(&[0; 12]));
    file.accessors[moved]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": sparse_indices, "componentType": 5121},
        "values": {"bufferView": sparse_values}});
    let picture = (crate::pictures::PICTURE.seeds)();
    let picture = file.view(picture.first().map_or(&[], Vec::as_slice));
    let texture = json!({"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform":
        {"offset": [0, 0], "rotation": 1, "scale": [1, 1], "texCoord": 1}}});
    let attributes = json!({"POSITION": position, "NORMAL": moved, "TANGENT": tangents,
        "TEXCOORD_0": uvs, "COLOR_0": weights, "JOINTS_0": joints, "WEIGHTS_0": weights});
    let document = json!({
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "b.bin", "byteLength": file.buffer.len()}],
        "bufferViews": file.views,
        "accessors": file.accessors,
        "images": [{"bufferView": picture, "mimeType": "image/png"}],
        "samplers": [{"wrapS": 33071, "magFilter": 9728}],
        "textures": [{"source": 0, "sampler": 0}],
        "materials": [{
            "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "baseColorTexture": texture,
                "metallicFactor": 0, "roughnessFactor": 0.5},
            "normalTexture": texture, "emissiveFactor": [1, 1, 1], "emissiveTexture": texture,
            "alphaMode": "MASK", "alphaCutoff": 0.5,
            "extensions": {
                "KHR_materials_emissive_strength": {"emissiveStrength": 5},
                "KHR_materials_ior": {"ior": 1.5},
                "KHR_materials_transmission": {"transmissionFactor": 1},
                "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2,
                    "attenuationColor": [1, 1, 1]},
                "KHR_materials_specular": {"specularFactor": 1,
                    "specularColorFactor": [1, 1, 1]}}}],
        "meshes": [{"weights": [0.5], "primitives": [
            {"attributes": attributes, "indices": indices, "material": 0,
             "targets": [{"POSITION": moved}]},
            {"attributes": {"POSITION": position}, "mode": 5},
            {"attributes": {"POSITION": position}, "mode": 1}]}],
        "skins": [{"joints": [1, 2]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5},
            "extras": {"neumann": {"lens": {"aperture": 0.1, "focusDistance": 2}}}}],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "spot", "intensity": 3, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 1}},
            {"type": "directional", "color": [1, 0.5, 1]}]}},
        "nodes": [
            {"mesh": 0, "skin": 0}, {"translation": [1, 2, 3], "children": [2, 3]},
            {"rotation": [0, 0, 0, 1], "scale": [1, 1, 1],
             "extensions": {"KHR_lights_punctual": {"light": 1}}},
            {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
             "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": position}}}},
            {"camera": 0, "translation": [0.5, 0.5, 4],
             "extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 4], "extras": {"neumann":
            {"environment": {"uri": "sky.hdr", "intensity": 1, "rotationDegrees": 90}}}}],
    });
    (document, file.buffer)
}

/// A buffer and what describes it, as they grow.
#[derive(Default)]
struct Pieces {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Pieces {
    fn view(&mut self, bytes: &[u8]) -> usize {
        let (start, length) = (self.buffer.len(), bytes.len());
        self.views
            .push(json!({"buffer": 0, "byteOffset": start, "byteLength": length}));
        self.buffer.extend(bytes);
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn accessor(&mut self, kind: &str, component: u32, n: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let count = n / n_components(kind);
        let is_normalized = component != 5126 && kind == "VEC4";
        self.accessors
            .push(json!({"bufferView": view, "componentType": component,
            "count": count, "type": kind, "normalized": is_normalized}));
        self.accessors.len() - 1
    }

    fn floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        self.accessor(kind, 5126, numbers.len(), &bytes)
    }

    fn bytes(&mut self, kind: &str, numbers: &[u8]) -> usize {
        self.accessor(kind, 5121, numbers.len(), numbers)
    }
}

fn n_components(kind: &str) -> usize {
    match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "MAT3" => 9,
        "MAT4" => 16,
        _ => 4,
    }
}

/// The same as GLB.
fn container(document: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut document = document.clone();
    document["buffers"][0] = json!({"byteLength": buffer.len()});
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let word = |n: usize| (n as u32).to_le_bytes();
    let length = 28 + json.len() + buffer.len();
    [
        b"glTF\x02\0\0\0".as_slice(),
        &word(length),
        &word(json.len()),
        b"JSON",
        &json,
        &word(buffer.len()),
        b"BIN\0",
        buffer,
    ]
    .concat()
}

/// Replaces, removes or copies one value somewhere in the document.
fn edit(document: &mut Value, input: &mut Unstructured<'_>) -> Result<()> {
    let n_values = n_values(document);
    let mut at = usize::from(input.arbitrary::<u16>()?) % n_values;
    let odd = match input.int_in_range(0..=17)? {
        0 => json!(input.arbitrary::<i8>()?),
        1 => json!(input.arbitrary::<u32>()?),
        2 => {
            let real = f64::from(input.arbitrary::<f32>()?);
            json!(if real.is_finite() { real } else { 1e39 })
        }
        3 => {
            let mut from = usize::from(input.arbitrary::<u16>()?) % n_values;
            value(document, &mut from).unwrap_or_default()
        }
        4 => json!(-1),
        5 => json!(u64::MAX),
        6 => json!(16_777_216),
        7 => json!(-1e39),
        8 => json!(1e300),
        9 => json!(1e-40),
        10 => json!(null),
        11 => json!([]),
        12 => json!({}),
        13 => json!("VEC3"),
        14 => json!("data:;base64,AAAA"),
        15 => json!("BLEND"),
        16 => json!(true),
        _ => json!([0, 1, 0.5]),
    };
    replace(document, &mut at, &odd);
    Ok(())
}

fn n_values(value: &Value) -> usize {
    1 + match value {
        Value::Array(values) => values.iter().map(n_values).sum::<usize>(),
        Value::Object(fields) => fields.values().map(n_values).sum::<usize>(),
        _ => 0,
    }
}

/// The value that is reached after `n_left` others.
fn value(document: &Value, n_left: &mut usize) -> Option<Value> {
    if *n_left == 0 {
        return Some(document.clone());
    }
    *n_left -= 1;
    match document {
        Value::Array(values) => values.iter().find_map(|v| value(v, n_left)),
        Value::Object(fields) => fields.values().find_map(|v| value(v, n_left)),
        _ => None,
    }
}

/// Replaces the value that is reached after `n_left` others.
fn replace(value: &mut Value, n_left: &mut usize, odd: &Value) -> bool {
    if *n_left == 0 {
        *value = odd.clone();
        return true;
    }
    *n_left -= 1;
    match value {
        Value::Array(values) => values.iter_mut().any(|v| replace(v, n_left, odd)),
        Value::Object(fields) => fields.values_mut().any(|v| replace(v, n_left, odd)),
        _ => false,
    }
}

/// A document with one primitive; nearly all of it may be wrong.
fn primitive(input: &mut Unstructured<'_>) -> Result<(Value, Vec<u8>)> {
    const COMPONENTS: [u32; 7] = [5126, 5121, 5123, 5125, 5120, 5122, 5124];
    const KINDS: [&str; 7] = ["VEC3", "VEC2", "VEC4", "SCALAR", "MAT3", "MAT4", "VEC9"];
    const ATTRIBUTES: [&str; 7] = [
        "NORMAL",
        "TANGENT",
        "TEXCOORD_0",
        "TEXCOORD_1",
        "COLOR_0",
        "JOINTS_0",
        "WEIGHTS_0",
    ];
    let mut views = Vec::new();
    let mut accessors = Vec::new();
    let mut attributes = serde_json::Map::new();
    attributes.insert("POSITION".to_owned(), json!(0));
    let n_accessors = input.int_in_range(1..=6)?;
    let count = input.int_in_range(3..=40)?;
    for i in 0..n_accessors {
        let offset = input.int_in_range(0..=64)? * if input.ratio(1, 8)? { 1 } else { 4 };
        views.push(json!({"buffer": 0, "byteOffset": offset,
            "byteLength": input.int_in_range(0..=900)? + 480}));
        if input.ratio(1, 8)? {
            views[i]["byteStride"] = json!(input.int_in_range(0..=260)?);
        }
        // Positions are mostly what they should be.
        let (kind, component) = if i == 0 && !input.ratio(1, 16)? {
            ("VEC3", 5126)
        } else {
            (*input.choose(&KINDS)?, *input.choose(&COMPONENTS)?)
        };
        let n = if input.ratio(1, 16)? {
            input.int_in_range(0..=100_000)?
        } else {
            count
        };
        accessors.push(
            json!({"bufferView": i, "componentType": component, "type": kind,
            "count": n, "normalized": input.arbitrary::<bool>()?}),
        );
        if input.ratio(1, 8)? {
            accessors[i]["byteOffset"] = json!(input.int_in_range(0..=64)?);
        }
        if input.ratio(1, 8)? {
            let view = input.int_in_range(0..=n_accessors)?;
            accessors[i]["sparse"] = json!({"count": input.int_in_range(0..=9)?,
                "indices": {"bufferView": view, "componentType": *input.choose(&COMPONENTS)?},
                "values": {"bufferView": view}});
        }
        if i > 0 {
            attributes.insert((*input.choose(&ATTRIBUTES)?).to_owned(), json!(i));
        }
    }
    let mut primitive = json!({"attributes": attributes, "mode": input.int_in_range(0..=7)?,
        "material": 0});
    if input.ratio(1, 3)? {
        primitive["indices"] = json!(input.int_in_range(0..=n_accessors)?);
    }
    if input.ratio(1, 8)? {
        let target = input.int_in_range(0..=n_accessors)?;
        primitive["targets"] = json!([{"POSITION": target, "NORMAL": target}]);
    }
    let mut material = json!({"emissiveFactor": [1, 1, 1], "doubleSided": true});
    if input.ratio(1, 4)? {
        material["alphaMode"] = json!("BLEND");
    }
    // Small finite numbers, with any bytes among them.
    let mut buffer = Vec::new();
    for _ in 0..360 {
        let number = f32::from(input.arbitrary::<i8>()?) / 16.0;
        buffer.extend(number.to_le_bytes());
    }
    for _ in 0..input.int_in_range(0..=8)? {
        let at = input.int_in_range(0..=buffer.len() - 4)?;
        buffer[at..at + 4].copy_from_slice(&input.arbitrary::<[u8; 4]>()?);
    }
    let document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}], "meshes": [{"primitives": [primitive]}],
        "materials": [material], "accessors": accessors, "bufferViews": views,
        "buffers": [{"uri": "b.bin", "byteLength": buffer.len()}],
    });
    Ok((document, buffer))
}

/// Larger scenes are only loaded: they would take longer, and show nothing more.
const MOST_TRIANGLES: usize = 2000;

/// Loads a scene and checks what every description promises; then builds and renders it.
fn load_and_render(bytes: &[u8], buffer: &[u8]) -> bool {
    let sky = (crate::pictures::HDR.seeds)().swap_remove(0);
    let resolve = |uri: &str| match uri {
        "b.bin" => Some(buffer.to_vec()),
        "sky.hdr" => Some(sky.clone()),
        _ => None,
    };
    let description = match load_bytes("fuzz.gltf", bytes, &resolve) {
        Ok(description) => description,
        Err(error) => {
            let text = error.to_string();
            assert!(!text.contains('\n') && text.contains("fuzz.gltf"), "{text}");
            return false;
        }
    };
    check(&description);
    let n_triangles: usize = description
        .instances
        .iter()
        .map(|instance| description.meshes[instance.mesh].triangles.len())
        .sum();
    if n_triangles <= MOST_TRIANGLES {
        render(&description);
    }
    true
}

fn check(scene: &SceneDescription) {
    for mesh in &scene.meshes {
        let n_vertices = mesh.positions.len();
        let mut corners = mesh.triangles.iter().flatten();
        assert!(corners.all(|&corner| (corner as usize) < n_vertices));
        assert!(mesh.uv_sets.iter().all(|set| set.len() == n_vertices));
        assert!(mesh.normals.iter().all(|n| n.len() == n_vertices));
        assert!(mesh.tangents.iter().all(|t| t.len() == n_vertices));
        assert!(mesh.colors.iter().all(|c| c.len() == n_vertices));
        assert!(mesh.material.is_none_or(|m| m < scene.materials.len()));
        let mut material = mesh.material.iter().map(|&m| &scene.materials[m]);
        assert!(material.all(|m| {
            let textures = [&m.base_color_texture, &m.normal_texture];
            textures.into_iter().flatten().all(|texture| {
                texture.image < scene.images.len() && texture.uv_set < mesh.uv_sets.len()
            })
        }));
    }
    assert!(scene.instances.iter().all(|i| i.mesh < scene.meshes.len()));
    for material in &scene.materials {
        assert!(material.emission.is_radiance());
        assert!((0.0..=1.0).contains(&material.roughness));
        assert!(material.ior.is_finite() && material.ior >= 1.0);
    }
}

static POOL: LazyLock<Option<WorkerPool>> = LazyLock::new(|| WorkerPool::new(Some(1), || ()).ok());

/// One iteration of a few pixels, from the camera and from the lights.
fn render(description: &SceneDescription) {
    let scene = Arc::new(Scene::build(description));
    let (Some(camera), Some(pool)) = (scene.cameras().first(), &*POOL) else {
        return;
    };
    let mut settings = RenderSettings::new(camera.clone(), 4, 4);
    settings.max_bounces = 3;
    for id in ["pt-mis", "bdpt"] {
        let Some(method) = method(id) else { continue };
        settings.method = method;
        settings.values = ParameterValues::defaults(method.parameters);
        let mut film = Film::new(settings.width, settings.height, settings.n_layers);
        let mut renderer = Renderer::new(Arc::clone(&scene), settings.clone(), pool.clone(), 0);
        if let Ok(iteration) = renderer.iterate_after(&film, &CancelToken::default()) {
            iteration.add_to(&mut film);
        }
        assert!(film.total().iter().all(|radiance| radiance.is_radiance()));
    }
}
