//! Whole files, made here, and what they must become.

use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};

use super::{LoadError, environment_from_bytes, load_bytes};
use crate::radiometry::Rgb;
use crate::scene::description::{Lens, Projection, SceneDescription};

/// A glTF file under construction, with one buffer.
#[derive(Clone, Debug)]
pub(super) struct Builder {
    pub(super) json: Value,
    pub(super) bytes: Vec<u8>,
}

impl Builder {
    /// One node with one mesh of one primitive that has no attributes yet.
    pub(super) fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {}}]}],
            "accessors": [], "bufferViews": [],
            "buffers": [{"uri": "b.bin"}],
        });
        let bytes = Vec::new();
        Self { json, bytes }
    }

    /// Appends a view of these bytes.
    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.push("bufferViews", view)
    }

    /// Appends an accessor to packed floats.
    pub(super) fn floats(&mut self, kind: &str, n_components: usize, floats: &[f32]) -> usize {
        let bytes: Vec<u8> = floats.iter().flat_map(|f| f.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let count = floats.len() / n_components;
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": 5126, "type": kind, "count": count}),
        )
    }

    /// Appends an accessor to bytes as unsigned integers.
    pub(super) fn u8s(&mut self, kind: &str, n_components: usize, integers: &[u8]) -> usize {
        let view = self.view(integers);
        let count = integers.len() / n_components;
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": 5121, "type": kind, "count": count}),
        )
    }

    /// Appends to a top-level array.
    pub(super) fn push(&mut self, collection: &str, value: Value) -> usize {
        if !self.json[collection].is_array() {
            self.json[collection] = json!([]);
        }
        let array = self.json[collection].as_array_mut().unwrap();
        array.push(value);
        array.len() - 1
    }

    /// The first primitive.
    pub(super) fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// The file's text.
    pub(super) fn text(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0]["byteLength"] = json!(self.bytes.len());
        json.to_string().into_bytes()
    }

    pub(super) fn load(&self) -> Result<SceneDescription, LoadError> {
        let resolve = |uri: &str| (uri == "b.bin").then(|| self.bytes.clone());
        load_bytes("test.gltf", &self.text(), &resolve)
    }
}

/// A unit square in the xy plane, as four vertices without indices.
pub(super) fn square() -> Builder {
    let mut builder = Builder::new();
    let corners = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.];
    let positions = builder.floats("VEC3", 3, &corners);
    builder.primitive()["attributes"]["POSITION"] = json!(positions);
    builder.primitive()["mode"] = json!(5);
    builder
}

#[test]
fn strips_fans_and_index_types() {
    let mut builder = square();
    let scene = builder.load().unwrap();
    assert_eq!(scene.meshes[0].triangles, [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(scene.instances[0].name, "node 0");
    assert_eq!(scene.name, "test");
    assert!(scene.report.warnings.is_empty());

    builder.primitive()["mode"] = json!(6);
    assert_eq!(
        builder.load().unwrap().meshes[0].triangles,
        [[1, 2, 0], [2, 3, 0]]
    );
    let indices = builder.u8s("SCALAR", 1, &[3, 2, 1, 9]);
    builder.primitive()["indices"] = json!(indices);
    builder.primitive()["mode"] = json!(4);
    builder.json["accessors"][indices]["count"] = json!(3);
    let mesh = builder.load().unwrap().meshes.remove(0);
    assert_eq!(mesh.positions.len(), 3, "vertex 0 is not named");
    assert_eq!(mesh.triangles, [[2, 1, 0]]);
    assert_eq!(mesh.positions[2], Vec3::new(1.0, 1.0, 0.0));

    builder.json["accessors"][indices]["count"] = json!(4);
    builder.primitive()["mode"] = json!(5);
    let error = builder.load().unwrap_err();
    assert!(error.problem.contains("index 3 is 9, but there are 4"));
    assert_eq!(error.field, "accessors[1]");
}

#[test]
fn quantised_interleaved_attributes() {
    let mut builder = Builder::new();
    let mut bytes = Vec::new();
    for (x, y) in [(0_i16, 0_i16), (32767, 0), (0, -32768)] {
        bytes.extend([x, y, 0, 0].iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend([0_i8, 0, 127, 0].map(|v| v as u8));
        bytes.extend([255_u8, 0, 51, 0]);
    }
    let view = builder.view(&bytes);
    builder.json["bufferViews"][view]["byteStride"] = json!(16);
    for (key, offset, component, kind) in [
        ("POSITION", 0, 5122, "VEC3"),
        ("NORMAL", 8, 5120, "VEC3"),
        ("COLOR_0", 12, 5121, "VEC3"),
        ("TEXCOORD_1", 12, 5121, "VEC2"),
    ] {
        let accessor = builder.push(
            "accessors",
            json!({"bufferView": view, "byteOffset": offset, "componentType": component,
                   "type": kind, "count": 3, "normalized": true}),
        );
        builder.primitive()["attributes"][key] = json!(accessor);
    }
    let mesh = builder.load().unwrap().meshes.remove(0);
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, -Vec3::Y]);
    assert_eq!(mesh.normals.unwrap(), [Vec3::Z; 3]);
    assert_eq!(mesh.colors.unwrap()[1], Vec4::new(1.0, 0.0, 0.2, 1.0));
    assert_eq!(mesh.uv_sets, [[Vec2::ZERO; 3], [Vec2::X; 3]]);

    builder.json["accessors"][0]["count"] = json!(4);
    let error = builder.load().unwrap_err();
    assert_eq!(error.field, "accessors[0].count");
}

#[test]
fn sparse_accessors_over_data_and_over_nothing() {
    let mut builder = square();
    let indices = builder.view(&[1, 3]);
    let ten = [10_f32; 6].map(f32::to_le_bytes).concat();
    let values = builder.view(&ten);
    builder.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": indices, "componentType": 5121},
        "values": {"bufferView": values},
    });
    let ten = Vec3::splat(10.0);
    let mesh = builder.load().unwrap().meshes.remove(0);
    assert_eq!(mesh.positions, [Vec3::ZERO, ten, Vec3::Y, ten]);

    let accessor = builder.json["accessors"][0].as_object_mut().unwrap();
    accessor.remove("bufferView");
    let mesh = builder.load().unwrap().meshes.remove(0);
    assert_eq!(mesh.positions, [Vec3::ZERO, ten, Vec3::ZERO, ten]);

    builder.json["accessors"][0]["count"] = json!(4_000_000_000_u64);
    assert!(builder.load().unwrap_err().problem.contains("bufferView"));
}

#[test]
fn shared_accessors_do_not_multiply() {
    let mut builder = Builder::new();
    let positions = builder.push(
        "accessors",
        json!({"componentType": 5126, "type": "VEC3", "count": 1 << 24}),
    );
    let primitive = json!({"attributes": {"POSITION": positions}, "mode": 5});
    builder.json["meshes"][0]["primitives"] = json!(vec![primitive; 1000]);
    let error = builder.load().unwrap_err();
    assert!(error.problem.contains("out of proportion"));
}

#[test]
fn points_and_lines_are_counted() {
    let mut builder = square();
    builder.primitive()["mode"] = json!(0);
    let mut lines = builder.primitive().clone();
    lines["mode"] = json!(3);
    builder.json["meshes"][0]["primitives"]
        .as_array_mut()
        .unwrap()
        .push(lines);
    let report = builder.load().unwrap().report;
    assert_eq!((report.n_points_skipped, report.n_lines_skipped), (4, 3));
    assert_eq!(report.warnings.len(), 2, "left out; no triangles");
}

#[test]
fn skins_follow_their_joints_and_morphs_their_weights() {
    let mut builder = square();
    let joints = builder.u8s("VEC4", 4, &[0, 1, 0, 0].repeat(4));
    let weights = builder.u8s("VEC4", 4, &[255, 255, 0, 0].repeat(4));
    let moved = builder.floats("VEC3", 3, &[0.0, 0.0, 1.0].repeat(4));
    let mut inverse_binds = glam::Mat4::IDENTITY.to_cols_array().to_vec();
    inverse_binds.extend(glam::Mat4::from_translation(Vec3::Y).to_cols_array());
    let inverse_binds = builder.floats("MAT4", 16, &inverse_binds);
    builder.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    builder.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    builder.primitive()["targets"] = json!([{}, {"POSITION": moved}]);
    builder.json["meshes"][0]["weights"] = json!([1, 0.5]);
    builder.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": inverse_binds}]);
    builder.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
        {"translation": [2, 0, 0]}, {"translation": [4, 0, 0]},
    ]);
    let scene = builder.load().unwrap();
    assert_eq!(scene.instances[0].world_from_mesh, glam::Mat4::IDENTITY);
    assert_eq!(scene.meshes[0].positions[0], Vec3::new(3.0, 0.5, 0.5));

    builder.json["skins"][0]["joints"] = json!([1]);
    assert!(
        builder
            .load()
            .unwrap_err()
            .problem
            .contains("names joint 1")
    );
}

#[test]
fn meshes_are_shared_and_instanced() {
    let mut builder = square();
    let translations = builder.floats("VEC3", 3, &[0., 0., 1., 0., 0., 2.]);
    builder.json["nodes"] = json!([
        {"mesh": 0, "name": "one"}, {"mesh": 0, "scale": [-1, 1, 1], "name": "many",
         "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translations}}}},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": false}}},
    ]);
    let scene = builder.load().unwrap();
    assert_eq!(scene.meshes.len(), 1);
    let names: Vec<&str> = scene.instances.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(names, ["one", "many [0]", "many [1]"]);
    let corner = scene.instances[2].world_from_mesh.transform_point3(Vec3::X);
    assert_eq!(corner, Vec3::new(-1.0, 0.0, 2.0));
}

#[cfg(feature = "pictures")]
#[test]
fn broken_images_cost_a_warning() {
    let mut builder = square();
    let image = builder.view(b"\x89PNG\r\n\x1a\nnot really");
    builder.json["images"] = json!([{"uri": "missing.png"}, {"bufferView": image}]);
    builder.json["textures"] = json!([{"source": 0}, {"source": 1}]);
    builder.json["materials"] = json!([
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "normalTexture": {"index": 1}},
        {"emissiveTexture": {"index": 0}},
    ]);
    builder.primitive()["material"] = json!(0);
    let scene = builder.load().unwrap();
    assert!(scene.materials[0].base_color_texture.is_none());
    assert!(scene.materials[0].normal_texture.is_none());
    assert!(scene.images.is_empty());
    assert_eq!(scene.report.warnings.len(), 2, "unused images are not read");
    assert!(scene.report.warnings[0].contains("missing.png"));

    builder.json["materials"][0]["normalTexture"]["index"] = json!(2);
    let error = builder.load().unwrap_err();
    assert_eq!(error.field, "materials[0].normalTexture.index");
}

/// A square that shines as a tiny PNG says.
fn textured_square() -> Builder {
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(2, 1, image::Rgba([1, 2, 3, 4]))
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let mut builder = square();
    let view = builder.view(png.get_ref());
    builder.json["images"] = json!([{}, {"bufferView": view, "name": "tiny"}]);
    builder.json["textures"] = json!([{"source": 1}]);
    builder.json["materials"] = json!([{"emissiveTexture": {"index": 0, "texCoord": 1}}]);
    builder.primitive()["material"] = json!(0);
    builder
}

#[cfg(not(feature = "pictures"))]
#[test]
fn pictures_need_their_feature() {
    let errors = [
        textured_square().load().unwrap_err(),
        environment_from_bytes("sky.exr", &exr()).unwrap_err(),
    ];
    for error in errors {
        assert!(
            error.to_string().contains("lacks the feature `pictures`"),
            "{error}"
        );
    }
    assert!(square().load().is_ok());
    assert!(environment_from_bytes("sky.hdr", &hdr()).is_ok());
}

#[cfg(feature = "pictures")]
#[test]
fn textures_find_their_images_and_coordinates() {
    let scene = textured_square().load().unwrap();
    let texture = scene.materials[0].emission_texture.unwrap();
    assert_eq!((texture.image, texture.uv_set), (0, 1));
    assert_eq!(scene.images[0].name, "tiny");
    let texel = scene.images[0].texels.rgba(2, 1, 0).map(|c| c * 255.0);
    assert_eq!(texel.map(f32::round), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(scene.meshes[0].uv_sets.len(), 2);
    assert!(scene.report.warnings[0].contains("TEXCOORD_1"));
}

#[test]
fn cameras_whose_rays_would_not_be_finite_are_named() {
    let mut builder = square();
    let lens = |aperture: f64, focus: f64| {
        json!({"type": "perspective", "perspective": {"yfov": 0.5}, "name": "eye", "extras":
            {"neumann": {"lens": {"aperture": aperture, "focusDistance": focus}}}})
    };
    let flat = |ymag: f64| {
        json!({"type": "orthographic", "name": "flat",
               "orthographic": {"xmag": 1, "ymag": ymag, "znear": 0, "zfar": 1}})
    };
    builder.json["cameras"] = json!([
        lens(0.1, 1e-39),
        lens(1.0, 1e-4),
        lens(1e-9, 1e-8),
        flat(1e38),
        flat(1e-30),
        flat(2.0),
    ]);
    builder.json["nodes"] = json!([
        {"mesh": 0}, {"camera": 0}, {"camera": 1}, {"camera": 2}, {"camera": 3}, {"camera": 4},
        {"camera": 5},
    ]);
    builder.json["scenes"] = json!([{"nodes": [0, 1, 2, 3, 4, 5, 6]}]);
    let scene = builder.load().unwrap();
    let has_lens: Vec<bool> = scene.cameras.iter().map(|c| c.lens.is_some()).collect();
    assert_eq!(has_lens, [false, false, true, false]);
    let warnings = scene.report.warnings.join("\n");
    for named in ["a focus at 1e-39 m", "1000 times", "ymag is 1e38,"] {
        assert!(warnings.contains(named), "{named}: {warnings}");
    }
}

#[test]
fn cameras_lights_environment_and_texts() {
    let mut builder = square();
    builder.json["asset"]["extras"] = json!({"about": "a square"});
    builder.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.5}, "name": "eye",
         "extras": {"neumann": {"lens": {"aperture": 0.1, "focusDistance": 2}}}},
        {"type": "perspective", "perspective": {"yfov": 4}},
    ]);
    builder.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "spot", "intensity": -3}, {"type": "laser"}]}});
    let light = |k| json!({"KHR_lights_punctual": {"light": k}});
    builder.json["nodes"] = json!([
        {"mesh": 0}, {"camera": 0}, {"camera": 1},
        {"extensions": light(0)}, {"extensions": light(1)},
    ]);
    builder.json["scenes"] = json!([{"name": "s", "nodes": [0, 1, 2, 3, 4], "extras": {"neumann":
        {"environment": {"color": [1, 2, 3], "intensity": 2, "rotationDegrees": 180}}}}]);
    let scene = builder.load().unwrap();
    assert_eq!(scene.name, "s");
    assert_eq!(scene.about.as_deref(), Some("a square"));
    assert_eq!(scene.cameras.len(), 1);
    assert_eq!(scene.cameras[0].name, "eye");
    let (aperture, focus_distance) = (0.1, 2.0);
    assert_eq!(
        scene.cameras[0].lens,
        Some(Lens {
            aperture,
            focus_distance
        })
    );
    let yfov = 0.5;
    assert_eq!(
        scene.cameras[0].projection,
        Projection::Perspective { yfov }
    );
    assert_eq!(scene.lights.len(), 1);
    let environment = scene.environment.unwrap();
    assert_eq!(environment.texels.get(0), Rgb::new(1.0, 2.0, 3.0));
    assert_eq!(environment.intensity, 2.0);
    assert!((environment.rotation - std::f32::consts::PI).abs() < 1e-6);
    assert_eq!(scene.report.warnings.len(), 3, "{:?}", scene.report);
}

/// A tiny map in the flat form of Radiance HDR.
pub(super) fn hdr() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
    bytes.extend([128, 0, 0, 129, 0, 128, 0, 130]);
    bytes
}

/// A tiny map as EXR, with one odd texel.
pub(super) fn exr() -> Vec<u8> {
    use exr::prelude::{Image, SpecificChannels, WritableImage};
    let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| match at.x() {
        0 => (f32::INFINITY, -1.0, f32::NAN),
        x => (x as f32, 0.5, 0.25),
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_channels((4, 2), channels)
        .write()
        .to_buffered(&mut bytes)
        .unwrap();
    bytes.into_inner()
}

#[cfg(feature = "pictures")]
#[test]
fn environment_maps_of_both_formats() {
    let load = |bytes: &[u8]| environment_from_bytes("sky", bytes).unwrap().environment;
    let map = load(&hdr());
    assert_eq!((map.width, map.height), (2, 1));
    let texels: Vec<Rgb> = map.texels.iter().collect();
    assert_eq!(texels, [Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 2.0, 0.0)]);
    let map = load(&exr());
    assert_eq!((map.width, map.height), (4, 2));
    assert_eq!(map.texels.get(0), Rgb::new(3.0, 0.0, 0.0));
    assert_eq!(map.texels.get(7), Rgb::new(3.0, 0.5, 0.25));
    assert!(environment_from_bytes("sky", b"P6 1 1").is_err());
}

/// A square whose attribute is made of the numbers.
fn square_with(attribute: &str, kind: &str, numbers: &[f32]) -> SceneDescription {
    let mut builder = square();
    let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let view = builder.view(&bytes);
    let n = numbers.len() / 4;
    let accessors = builder.json["accessors"].as_array_mut().unwrap();
    accessors.push(json!({"bufferView": view, "componentType": 5126, "count": 4, "type": kind}));
    let index = accessors.len() - 1;
    assert!(n > 0);
    builder.primitive()["attributes"][attribute] = json!(index);
    builder.load().unwrap()
}

#[test]
fn numbers_that_are_none_are_mended_and_counted() {
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let scene = square_with(
        "TEXCOORD_0",
        "VEC2",
        &[0.5, nan, inf, 0.0, 1.0, 1.0, 0.0, 1.0],
    );
    let uvs = &scene.meshes[0].uv_sets[0];
    assert_eq!(uvs[..3], [Vec2::ZERO, Vec2::ZERO, Vec2::ONE]);
    let warning = &scene.report.warnings[0];
    assert!(warning.contains("2 of 4 TEXCOORD_0"), "{warning}");

    let mut colors = [0.5; 16];
    colors[6] = nan;
    let scene = square_with("COLOR_0", "VEC4", &colors);
    let colors = scene.meshes[0].colors.as_ref().unwrap();
    assert_eq!(colors[..2], [Vec4::splat(0.5), Vec4::ONE]);
    let warning = &scene.report.warnings[0];
    assert!(warning.contains("1 of 4 vertex colours"), "{warning}");
}
