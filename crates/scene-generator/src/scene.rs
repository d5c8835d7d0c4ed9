//! A scene under construction: geometry, materials, placed objects, cameras.
//!
//! Geometry is stored once however many materials and nodes use it: a glTF mesh
//! is a list of (geometry, material) pairs, and the same list placed twice is
//! the same mesh.

use glam::{DMat3, DQuat, DVec3};
use serde_json::{Value, json};

use crate::glb;
use crate::material::Material;
use crate::mesh::Mesh;
use crate::rounded;

/// Index of a geometry added to a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Geometry(usize);

/// Index of a material added to a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surface(usize);

/// A geometry and what it is made of.
pub(crate) type Part = (Geometry, Surface);

/// Scale, then rotation, then translation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
}

impl Placement {
    /// Where the mesh was modelled.
    pub(crate) const IDENTITY: Self = Self {
        translation: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
        scale: DVec3::ONE,
    };

    /// Moved to a point, metres.
    pub(crate) fn at(translation: DVec3) -> Self {
        Self {
            translation,
            ..Self::IDENTITY
        }
    }

    /// The same, rotated.
    pub(crate) fn turned(self, rotation: DQuat) -> Self {
        Self { rotation, ..self }
    }

    /// The same, scaled.
    pub(crate) fn scaled(self, scale: DVec3) -> Self {
        Self { scale, ..self }
    }

    fn to_json(self) -> Value {
        let mut node = json!({});
        if self.rotation != DQuat::IDENTITY {
            node["rotation"] = json!(self.rotation.to_array().map(rounded));
        }
        if self.scale != DVec3::ONE {
            node["scale"] = json!(self.scale.to_array().map(rounded));
        }
        if self.translation != DVec3::ZERO {
            node["translation"] = json!(self.translation.to_array().map(rounded));
        }
        node
    }
}

/// A perspective camera at `eye` that looks at `target`, with +Y up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    /// Shown to the user.
    pub(crate) name: &'static str,
    /// Metres.
    pub(crate) eye: DVec3,
    /// Metres.
    pub(crate) target: DVec3,
    /// Vertical, degrees.
    pub(crate) field_of_view: f64,
    /// Width over height.
    pub(crate) aspect_ratio: f64,
    /// Lens diameter, metres; 0 is a pinhole. It focuses on the target.
    pub(crate) aperture: f64,
}

/// A scene under construction.
#[derive(Debug)]
pub(crate) struct Scene {
    about: &'static str,
    geometries: Vec<(String, Mesh)>,
    materials: Vec<Material>,
    meshes: Vec<Vec<Part>>,
    nodes: Vec<Value>,
    cameras: Vec<Value>,
    environment: Option<&'static str>,
}

impl Scene {
    /// An empty scene; `about` is one line on what it shows.
    pub(crate) fn new(about: &'static str) -> Self {
        Self {
            about,
            geometries: Vec::new(),
            materials: Vec::new(),
            meshes: Vec::new(),
            nodes: Vec::new(),
            cameras: Vec::new(),
            environment: None,
        }
    }

    /// One line on what the scene shows.
    pub(crate) fn about(&self) -> &'static str {
        self.about
    }

    /// Adds a shape to place later.
    pub(crate) fn geometry(&mut self, name: &str, mesh: Mesh) -> Geometry {
        self.geometries.push((name.to_owned(), mesh));
        Geometry(self.geometries.len() - 1)
    }

    /// Adds a material to use later.
    pub(crate) fn material(&mut self, material: Material) -> Surface {
        self.materials.push(material);
        Surface(self.materials.len() - 1)
    }

    /// Places an object made of the given parts.
    pub(crate) fn place(&mut self, name: &str, parts: &[Part], placement: Placement) {
        let known = self.meshes.iter().position(|mesh| mesh == parts);
        let mesh = known.unwrap_or_else(|| {
            self.meshes.push(parts.to_vec());
            self.meshes.len() - 1
        });
        let mut node = placement.to_json();
        node["mesh"] = json!(mesh);
        node["name"] = json!(name);
        self.nodes.push(node);
    }

    /// Adds a shape and places it where it was modelled.
    pub(crate) fn add(&mut self, name: &str, mesh: Mesh, surface: Surface) {
        let geometry = self.geometry(name, mesh);
        self.place(name, &[(geometry, surface)], Placement::IDENTITY);
    }

    /// Adds a camera; the first one is the default.
    pub(crate) fn camera(&mut self, camera: Camera) {
        let back = (camera.eye - camera.target).normalize();
        let right = DVec3::Y.cross(back).normalize();
        let rotation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
        let mut node = Placement::at(camera.eye).turned(rotation).to_json();
        node["camera"] = json!(self.cameras.len());
        node["name"] = json!(camera.name);
        self.nodes.push(node);

        let mut description = json!({
            "name": camera.name,
            "perspective": {
                "aspectRatio": rounded(camera.aspect_ratio),
                "yfov": rounded(camera.field_of_view.to_radians()),
                "znear": 0.01,
            },
            "type": "perspective",
        });
        if camera.aperture > 0.0 {
            let lens = json!({
                "aperture": rounded(camera.aperture),
                "focusDistance": rounded(camera.eye.distance(camera.target)),
            });
            description["extras"] = json!({ "neumann": { "lens": lens } });
        }
        self.cameras.push(description);
    }

    /// Surrounds the scene with a latitude-longitude image beside its file.
    pub(crate) fn surround(&mut self, uri: &'static str) {
        self.environment = Some(uri);
    }

    /// The scene as a binary glTF file.
    pub(crate) fn to_glb(&self) -> Vec<u8> {
        let mut buffer = glb::Buffer::default();
        let geometries: Vec<_> = self
            .geometries
            .iter()
            .map(|(_, mesh)| buffer.push(mesh))
            .collect();
        let meshes: Vec<_> = self
            .meshes
            .iter()
            .map(|parts| self.mesh_json(parts, &geometries))
            .collect();

        let mut extensions: Vec<_> = self
            .materials
            .iter()
            .flat_map(Material::extensions)
            .collect();
        extensions.sort();
        extensions.dedup();

        let mut scene = json!({
            "name": self.about,
            "nodes": (0..self.nodes.len()).collect::<Vec<_>>(),
        });
        if let Some(uri) = self.environment {
            let environment = json!({ "intensity": 1.0, "rotationDegrees": 0.0, "uri": uri });
            scene["extras"] = json!({ "neumann": { "environment": environment } });
        }

        let mut document = json!({
            "asset": {
                "copyright": "Built-in scene of neumann, MIT OR Apache-2.0",
                "extras": { "about": self.about },
                "generator": "neumann scene-generator",
                "version": "2.0",
            },
            "cameras": self.cameras,
            "materials": self.materials.iter().map(Material::to_json).collect::<Vec<_>>(),
            "meshes": meshes,
            "nodes": self.nodes,
            "scene": 0,
            "scenes": [scene],
        });
        if !extensions.is_empty() {
            document["extensionsUsed"] = json!(extensions);
        }
        buffer.finish(document)
    }

    fn mesh_json(&self, parts: &[Part], geometries: &[Value]) -> Value {
        let mut names = Vec::new();
        let mut primitives = Vec::new();
        for &(Geometry(geometry), Surface(surface)) in parts {
            let mut primitive = geometries[geometry].clone();
            primitive["material"] = json!(surface);
            primitives.push(primitive);
            names.push(format!(
                "{} ({})",
                self.geometries[geometry].0,
                self.materials[surface].name()
            ));
        }
        json!({ "name": names.join(" + "), "primitives": primitives })
    }
}
