//! Files that nobody here made: what they may take, and what a person is told about them.

use neumann_picture::image_file::read_image;
use serde_json::Value;

use super::{Folder, stderr_of};

/// A glTF file with a texture of 16384 by 16384 texels of one bit, 33 kB or so.
fn scene_with_a_huge_texture(folder: &Folder) {
    const SIDE: usize = 16384;
    let mut picture = Vec::new();
    let mut encoder = png::Encoder::new(&mut picture, SIDE as u32, SIDE as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    let rows = vec![0xff; SIDE * SIDE / 8];
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&rows).unwrap();
    writer.finish().unwrap();
    std::fs::write(folder.join("huge.png"), picture).unwrap();
    let corners: [[f32; 3]; 3] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = corners
        .iter()
        .flatten()
        .flat_map(|c| c.to_le_bytes())
        .collect();
    std::fs::write(folder.join("triangle.bin"), bytes).unwrap();
    let scene = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
        "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
        "textures":[{"source":0}],"images":[{"uri":"huge.png"}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
                     {"componentType":5126,"count":3,"type":"VEC2"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "buffers":[{"uri":"triangle.bin","byteLength":36}]}"#;
    std::fs::write(folder.join("huge.gltf"), scene).unwrap();
}

#[test]
fn files_stay_within_the_memory_that_they_are_allowed() {
    let folder = Folder::new();
    scene_with_a_huge_texture(&folder);
    // One bit a texel: 33.6 MB.
    folder.succeed("render huge.gltf -o a.exr --iterations 1 --size 8x8 --memory 40M");
    let output = folder.run("info huge.gltf --memory 30M");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{error}");
    for part in ["huge.gltf", "huge.png", "33.6 MB", "31.5 MB", "--memory"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    let output = folder.run("compare a.exr a.exr --memory 1k");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(
        error.contains("a.exr") && error.contains("--memory"),
        "{error}"
    );
    folder.succeed("compare a.exr a.exr --memory 1G");
}

/// A white square that faces the camera, with something that is not honoured and no light.
fn write_square(folder: &Folder, material: &Value) {
    let corners = [
        [-1f32, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [-1.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ];
    let bytes: Vec<u8> = corners
        .as_flattened()
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    std::fs::write(folder.join("square.bin"), &bytes).unwrap();
    let scene = serde_json::json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_materials_clearcoat", "KHR_xmp_json_ld"],
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [
            { "attributes": { "POSITION": 0 }, "mode": 5, "material": 0 }] }],
        "materials": [material],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
            "min": [-1, -1, 0], "max": [1, 1, 0] }],
        "bufferViews": [{ "buffer": 0, "byteLength": 48 }],
        "buffers": [{ "uri": "square.bin", "byteLength": 48 }],
    });
    std::fs::write(folder.join("square.gltf"), scene.to_string()).unwrap();
}

#[test]
fn what_lights_a_file_and_what_it_lacks_is_said_at_once() {
    let folder = Folder::new();
    let clearcoat = serde_json::json!({ "extensions": { "KHR_materials_clearcoat": {} } });
    write_square(&folder, &clearcoat);
    let render = "render square.gltf --size 16x16 --iterations 1 -o s.exr -o s.png";
    let told = stderr_of(&folder, render);
    assert!(told.contains("KHR_materials_clearcoat is ignored: clear coats are missing"));
    assert!(!told.contains("KHR_xmp_json_ld"), "the picture is the same");
    assert!(told.contains("the built-in sky 'studio' is added"));
    let studio = folder.film("s.exr");
    let n_lit = studio.film.total().iter().filter(|c| c.g > 0.05).count();
    assert!(n_lit > 200, "{n_lit} of 256 pixels");
    // By name, with a turn; and none.
    let told = stderr_of(
        &folder,
        &format!("{render} --env sun --env-rotation 30 --env-intensity 0.5"),
    );
    assert!(!told.contains("sky"), "{told}");
    let told = stderr_of(&folder, &format!("{render} --env none"));
    assert!(!told.contains("sky"), "{told}");
    assert!(
        folder
            .film("s.exr")
            .film
            .total()
            .iter()
            .all(|c| c.is_black())
    );
    let told = folder.fail(&format!("{render} --env none --env-rotation 3"), 2);
    assert!(told.contains("--env"), "{told}");
    let told = folder.fail(&format!("{render} --env ./sun"), 2);
    assert!(told.contains("./sun"), "a file, not the sky: {told}");
    // What was added by default can be turned as well.
    folder.succeed(&format!("{render} --env-intensity 0.5"));
    let half = folder.film("s.exr");
    for (a, b) in studio.film.total().iter().zip(half.film.total()) {
        assert!((0.5 * a.g - b.g).abs() < 1e-5);
    }
}

#[test]
fn pictures_beyond_the_screen_are_told_and_exposed_by_themselves() {
    let folder = Folder::new();
    write_square(&folder, &serde_json::json!({}));
    let render = "render square.gltf --size 16x16 --iterations 1 --env-intensity 1000 -o s.png";
    let told = stderr_of(&folder, render);
    assert!(
        told.contains("of what is lit is shown as white; try --exposure auto"),
        "{told}"
    );
    let told = stderr_of(&folder, &format!("{render} --exposure auto"));
    assert!(
        told.contains("exposure -") && !told.contains("try"),
        "{told}"
    );
    let image = read_image(&folder.join("s.png")).unwrap();
    let mean = image.pixels.iter().map(|p| p.g).sum::<f32>() / image.pixels.len() as f32;
    assert!((0.1..0.5).contains(&mean), "{mean}");
    let told = stderr_of(&folder, &format!("{render} --exposure -40"));
    assert!(told.contains("shown as black"), "{told}");
}
