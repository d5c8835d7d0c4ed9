//! Files with random damage must end in a description or an error, soon.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::tests::{Builder, exr, hdr, square};
use super::{environment_from_bytes, load_bytes};
use crate::radiometry::Rgb;
use crate::scene::description::SceneDescription;

/// Far more than any case needs, far less than a hang.
const LONGEST: Duration = Duration::from_secs(20);

/// `SplitMix64`: damage must be the same on every run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n.max(1) as u64) as usize
    }
}

/// A file that uses nearly everything the loader knows.
fn everything() -> Builder {
    let mut b = square();
    let joints = b.u8s("VEC4", 4, &[0, 1, 0, 0].repeat(4));
    let weights = b.u8s("VEC4", 4, &[255, 255, 0, 0].repeat(4));
    let moved = b.floats("VEC3", 3, &[0.0, 0.0, 1.0].repeat(4));
    let uvs = b.floats("VEC2", 2, &[0., 0., 1., 0., 0., 1., 1., 1.]);
    let tangents = b.floats("VEC4", 4, &[1., 0., 0., 1.].repeat(4));
    let indices = b.u8s("SCALAR", 1, &[0, 1, 2, 2, 1, 3]);
    let (sparse_indices, sparse_values) = (b.view(&[1]), b.view(&[0; 12]));
    b.json["accessors"][moved]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": sparse_indices, "componentType": 5121},
        "values": {"bufferView": sparse_values}});
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbaImage::new(2, 2)
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let png = b.view(png.get_ref());
    let sky = b.view(&hdr());
    b.json["images"] = json!([{"bufferView": png, "mimeType": "image/png"}, {"bufferView": sky}]);
    b.json["samplers"] = json!([{"wrapS": 33071, "magFilter": 9728}]);
    b.json["textures"] = json!([{"source": 0, "sampler": 0}]);
    let texture = json!({"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform":
        {"offset": [0, 0], "rotation": 1, "scale": [1, 1], "texCoord": 1}}});
    b.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1],
        "baseColorTexture": texture, "metallicFactor": 0, "roughnessFactor": 0.5},
        "normalTexture": texture, "emissiveFactor": [1, 1, 1], "alphaMode": "MASK",
        "alphaCutoff": 0.5, "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 5},
            "KHR_materials_ior": {"ior": 1.5}, "KHR_materials_transmission":
            {"transmissionFactor": 1}, "KHR_materials_volume": {"thicknessFactor": 1,
            "attenuationDistance": 2, "attenuationColor": [1, 1, 1]},
            "KHR_materials_specular": {"specularFactor": 1, "specularColorFactor": [1, 1, 1]}}}]);
    let attributes = json!({"POSITION": 0, "NORMAL": moved, "TANGENT": tangents,
        "TEXCOORD_0": uvs, "COLOR_0": weights, "JOINTS_0": joints, "WEIGHTS_0": weights});
    b.json["meshes"] = json!([{"weights": [0.5], "primitives": [
        {"attributes": attributes, "indices": indices, "material": 0,
         "targets": [{"POSITION": moved}]},
        {"attributes": {"POSITION": 0}, "mode": 5}, {"attributes": {"POSITION": 0}, "mode": 1}]}]);
    b.json["skins"] = json!([{"joints": [1, 2]}]);
    b.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.5},
        "extras": {"neumann": {"lens": {"aperture": 0.1, "focusDistance": 2}}}}]);
    b.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "spot", "intensity": 3, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 1}}]}});
    b.json["nodes"] = json!([
        {"mesh": 0, "skin": 0}, {"translation": [1, 2, 3], "children": [2, 3]},
        {"rotation": [0, 0, 0, 1], "scale": [1, 1, 1]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
         "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}},
        {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]);
    b.json["scene"] = json!(0);
    b.json["scenes"] = json!([{"nodes": [0, 1, 4], "extras": {"neumann":
        {"environment": {"uri": "sky.hdr", "intensity": 1, "rotationDegrees": 90}}}}]);
    b.json["buffers"][0]["byteLength"] = json!(b.bytes.len());
    b
}

/// The same file as GLB.
fn glb(builder: &Builder) -> Vec<u8> {
    let mut builder = builder.clone();
    builder.json["buffers"][0] = json!({});
    let mut json = builder.text();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    let length = 28 + json.len() + builder.bytes.len();
    bytes.extend((length as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((builder.bytes.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(builder.bytes);
    bytes
}

/// Replaces one value somewhere in the document.
fn damage_value(value: &mut Value, dice: &mut Dice) {
    let mut n_left = dice.below(count(value));
    let odd = [
        json!(0),
        json!(1),
        json!(-1),
        json!(2),
        json!(3.5),
        json!(255),
        json!(5125),
        json!(16_777_216),
        json!(4_294_967_295_u32),
        json!(u64::MAX),
        json!(-1e39),
        json!(1e300),
        json!(null),
        json!([]),
        json!({}),
        json!("VEC3"),
        json!("data:;base64,AAAA"),
        json!(true),
    ];
    let odd = odd[dice.below(odd.len())].clone();
    replace(value, &mut n_left, &odd);
}

fn count(value: &Value) -> usize {
    match value {
        Value::Array(values) => 1 + values.iter().map(count).sum::<usize>(),
        Value::Object(fields) => 1 + fields.values().map(count).sum::<usize>(),
        _ => 1,
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

fn damage_bytes(bytes: &mut Vec<u8>, dice: &mut Dice) {
    for _ in 0..=dice.below(4) {
        let at = dice.below(bytes.len());
        match dice.below(4) {
            0 if at < bytes.len() => bytes[at] = dice.below(256) as u8,
            1 if at < bytes.len() => bytes[at] ^= 1 << dice.below(8),
            2 => bytes.truncate(at),
            _ => {
                let end = (at + dice.below(8)).min(bytes.len());
                bytes.drain(at..end);
            }
        }
    }
}

fn load(bytes: &[u8], builder: &Builder) -> bool {
    let start = Instant::now();
    let resolve = |uri: &str| match uri {
        "b.bin" => Some(builder.bytes.clone()),
        "sky.hdr" => Some(hdr()),
        _ => None,
    };
    let loaded = load_bytes("mutant", bytes, &resolve);
    assert!(start.elapsed() < LONGEST);
    match &loaded {
        Ok(scene) => check(scene),
        Err(error) => assert!(!error.to_string().contains('\n')),
    }
    loaded.is_ok()
}

/// What every description promises.
fn check(scene: &SceneDescription) {
    for mesh in &scene.meshes {
        let n_vertices = mesh.positions.len();
        let mut corners = mesh.triangles.iter().flatten();
        assert!(corners.all(|&corner| (corner as usize) < n_vertices));
        assert!(mesh.uv_sets.iter().all(|set| set.len() == n_vertices));
        assert!(mesh.normals.iter().all(|n| n.len() == n_vertices));
        assert!(mesh.tangents.iter().all(|t| t.len() == n_vertices));
        assert!(mesh.colors.iter().all(|c| c.len() == n_vertices));
        let mut material = mesh.material.iter().map(|&m| &scene.materials[m]);
        assert!(material.all(|m| {
            let textures = [m.base_color_texture, m.normal_texture];
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

#[test]
fn the_undamaged_files_load() {
    let builder = everything();
    assert!(load(&builder.text(), &builder));
    assert!(load(&glb(&builder), &builder));
}

#[test]
fn odd_values_end_in_a_description_or_an_error() {
    let mut dice = Dice(1);
    let builder = everything();
    let mut n_loaded = 0;
    for _ in 0..3000 {
        let mut mutant = builder.clone();
        for _ in 0..=dice.below(3) {
            damage_value(&mut mutant.json, &mut dice);
        }
        n_loaded += usize::from(load(mutant.json.to_string().as_bytes(), &builder));
    }
    assert!((200..2800).contains(&n_loaded), "{n_loaded} loaded");
}

#[test]
fn odd_bytes_end_in_a_description_or_an_error() {
    let mut dice = Dice(2);
    let builder = everything();
    for file in [glb(&builder), builder.text()] {
        for _ in 0..1500 {
            let mut mutant = file.clone();
            damage_bytes(&mut mutant, &mut dice);
            load(&mutant, &builder);
        }
    }
}

#[test]
fn odd_environments_end_in_a_map_or_an_error() {
    let mut dice = Dice(3);
    for file in [hdr(), exr()] {
        for _ in 0..500 {
            let mut mutant = file.clone();
            damage_bytes(&mut mutant, &mut dice);
            let start = Instant::now();
            if let Ok(file) = environment_from_bytes("mutant", &mutant) {
                let map = file.environment;
                assert_eq!(map.texels.len(), map.width * map.height);
                assert!(map.texels.iter().all(Rgb::is_radiance));
            }
            assert!(start.elapsed() < LONGEST);
        }
    }
}
