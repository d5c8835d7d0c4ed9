//! Puts a scene together from its parts.
//!
//! Only what the scene shows is read: a broken mesh that no node carries does
//! not matter. A mesh that several nodes carry is read once, unless a skin or
//! morph weights of the node's own make it another shape.

use std::collections::BTreeMap;
use std::path::Path;

use glam::Mat4;

use super::allowance::Allowance;
use super::buffer::Buffers;
use super::error::{Fault, quoted};
use super::json::Item;
use super::mesh::{self, Deformation, ReadMesh};
use super::node::{self, Hierarchy};
use super::notes::Notes;
use super::picture;
use super::skin::Skin;
use super::source::Source;
use super::{
    File, camera, container, environment, extension, ignored, instancing, light, material, morph,
};
use crate::scene::description::{
    DefaultSky, InstanceDescription, LoadReport, MeshDescription, SceneDescription,
};
use crate::scene::{OpeningProgress, OpeningStep};

/// Reads a whole scene; `name` is that of its file.
pub(super) fn scene(
    name: &str,
    bytes: &[u8],
    mut source: Source<'_>,
    progress: &OpeningProgress,
) -> Result<SceneDescription, Fault> {
    let container = container::open(bytes)?;
    let extensions = extension::read(&container.document)?;
    let buffers = Buffers::read(&container, &mut source);
    let file = File {
        allowance: Allowance::new(buffers.n_bytes()),
        document: container.document,
        buffers,
    };
    let document = &file.document;
    let mut notes = Notes::default();
    ignored::note(document, &extensions, &mut notes);

    let root = document.root();
    let scene_index = match document.reference(&root, "scene", "scenes")? {
        None if document.count("scenes") > 0 => Some(0),
        index => index,
    };
    let scene_item = match scene_index {
        Some(index) => Some(document.item("scenes", index)?),
        None => None,
    };
    let hierarchy = node::read(document, scene_item.as_ref(), &mut notes)?;
    let mut materials = material::read(document, &mut notes)?;
    let mut objects = Objects::new(&file);
    let mut lights = Vec::new();
    let mut cameras = Vec::new();
    for (n_read, &index) in hierarchy.nodes.iter().enumerate() {
        progress.reach(OpeningStep::Meshes, n_read, hierarchy.nodes.len());
        let node = document.item("nodes", index)?;
        let world_from_node = hierarchy.world_from_node[index];
        if hierarchy.is_visible[index] {
            objects.add_node(&hierarchy, &node, index, &mut notes)?;
            lights.extend(light::read(document, &node, world_from_node, &mut notes)?);
        }
        cameras.extend(camera::read(document, &node, world_from_node, &mut notes)?);
    }
    let Objects {
        mut meshes,
        instances,
        ..
    } = objects;

    let mut is_used = vec![false; materials.len()];
    for material in meshes.iter().filter_map(|mesh| mesh.material) {
        is_used[material] = true;
    }
    let images = picture::read(&file, &mut source, &mut materials, &is_used, &mut notes)?;
    for mesh in &mut meshes {
        if let Some(index) = mesh.material {
            let textures = material::textures(&mut materials[index]);
            let n_sets = textures
                .iter()
                .filter_map(|t| t.as_ref())
                .map(|t| t.uv_set + 1);
            provide_uv_sets(&file, mesh, n_sets.max().unwrap_or(0), &mut notes)?;
        }
    }

    let environment = match &scene_item {
        Some(scene) => environment::of_scene(scene, &mut source, &mut notes)?,
        None => None,
    };
    note_what_is_left_out(&file, &extensions.ignored, &meshes, &mut notes);
    Ok(SceneDescription {
        name: scene_name(scene_item.as_ref(), name),
        about: about(&root),
        content_hash: source.content_hash(),
        meshes,
        instances,
        materials,
        images,
        lights,
        cameras,
        environment,
        default_sky: DefaultSky::default(),
        report: LoadReport {
            extensions_used: extensions.used,
            extensions_ignored: extensions.ignored,
            files: source.files(),
            n_points_skipped: notes.n_points_skipped,
            n_lines_skipped: notes.n_lines_skipped,
            warnings: notes.into_warnings(),
        },
    })
}

/// Meshes and where they stand, as nodes add them.
struct Objects<'a> {
    file: &'a File<'a>,
    meshes: Vec<MeshDescription>,
    instances: Vec<InstanceDescription>,
    /// By glTF mesh and skin: the range of `meshes`, and which are in the world.
    placed: BTreeMap<(usize, Option<usize>), Vec<Placed>>,
    skins: BTreeMap<usize, Skin>,
}

/// A mesh of the description.
#[derive(Clone, Copy, Debug)]
struct Placed {
    mesh: usize,
    is_in_world: bool,
}

impl<'a> Objects<'a> {
    fn new(file: &'a File<'a>) -> Self {
        Self {
            file,
            meshes: Vec::new(),
            instances: Vec::new(),
            placed: BTreeMap::new(),
            skins: BTreeMap::new(),
        }
    }

    /// Adds the mesh that a node carries, if any, with its copies.
    fn add_node(
        &mut self,
        hierarchy: &Hierarchy,
        node: &Item<'_>,
        index: usize,
        notes: &mut Notes,
    ) -> Result<(), Fault> {
        let document = &self.file.document;
        let Some(mesh) = document.reference(node, "mesh", "meshes")? else {
            return Ok(());
        };
        let skin = document.reference(node, "skin", "skins")?;
        let placed = self.mesh(hierarchy, node, mesh, skin, notes)?;
        let name = node
            .name()
            .map_or_else(|| format!("node {index}"), str::to_owned);
        let world_from_node = hierarchy.world_from_node[index];
        for Placed { mesh, is_in_world } in placed {
            if is_in_world {
                self.add_instance(node, name.clone(), mesh, Mat4::IDENTITY)?;
                continue;
            }
            match instancing::read(self.file, node, name.len())? {
                None => self.add_instance(node, name.clone(), mesh, world_from_node)?,
                Some(copies) => {
                    let instances = copies.into_iter().enumerate();
                    self.instances
                        .extend(instances.map(|(copy, node_from_copy)| InstanceDescription {
                            name: format!("{name} [{copy}]"),
                            mesh,
                            world_from_mesh: world_from_node * node_from_copy,
                        }));
                }
            }
        }
        Ok(())
    }

    fn add_instance(
        &mut self,
        node: &Item<'_>,
        name: String,
        mesh: usize,
        world_from_mesh: Mat4,
    ) -> Result<(), Fault> {
        let size = size_of::<InstanceDescription>() + name.len();
        self.file.allowance.spend(1, size, node.at())?;
        self.instances.push(InstanceDescription {
            name,
            mesh,
            world_from_mesh,
        });
        Ok(())
    }

    /// The meshes for the primitives of a glTF mesh, read when they are new.
    fn mesh(
        &mut self,
        hierarchy: &Hierarchy,
        node: &Item<'_>,
        mesh: usize,
        skin: Option<usize>,
        notes: &mut Notes,
    ) -> Result<Vec<Placed>, Fault> {
        let weights = morph::weights(node)?;
        let key = (mesh, skin);
        if weights.is_none()
            && let Some(placed) = self.placed.get(&key)
        {
            return Ok(placed.clone());
        }
        if let Some(index) = skin
            && !self.skins.contains_key(&index)
        {
            let read = Skin::read(self.file, hierarchy, index, notes)?;
            self.skins.insert(index, read);
        }
        let deformation = Deformation {
            weights: weights.as_deref(),
            skin: skin.and_then(|index| self.skins.get(&index)),
        };
        let mut placed = Vec::new();
        let object = Some(self.meshes.len());
        for ReadMesh { mesh, is_in_world } in mesh::read(self.file, mesh, deformation, notes)? {
            placed.push(Placed {
                mesh: self.meshes.len(),
                is_in_world,
            });
            self.meshes.push(MeshDescription { object, ..mesh });
        }
        if weights.is_none() {
            self.placed.insert(key, placed.clone());
        }
        Ok(placed)
    }
}

/// Gives a mesh zeros for texture coordinates that its material reads in vain.
fn provide_uv_sets(
    file: &File<'_>,
    mesh: &mut MeshDescription,
    n_sets: usize,
    notes: &mut Notes,
) -> Result<(), Fault> {
    if mesh.uv_sets.len() < n_sets {
        notes.warn(format!(
            "mesh {}: its material reads TEXCOORD_{}, which it does not have; zeros stand in",
            quoted(&mesh.name),
            n_sets - 1
        ));
        mesh::pad_uv_sets(file, &mut mesh.uv_sets, n_sets, mesh.positions.len())?;
    }
    Ok(())
}

fn note_what_is_left_out(
    file: &File<'_>,
    ignored: &[String],
    meshes: &[MeshDescription],
    notes: &mut Notes,
) {
    if ignored.iter().any(|name| name == extension::GLOSSINESS) {
        notes.warn(format!(
            "{} is ignored, so that materials look wrong; {}",
            extension::GLOSSINESS,
            extension::CONVERT_GLOSSINESS
        ));
    }
    let n_animations = file.document.count("animations");
    if n_animations > 0 {
        notes.warn(format!(
            "{n_animations} animations are ignored; the scene is shown in the pose of its nodes"
        ));
    }
    let (n_points, n_lines) = (notes.n_points_skipped, notes.n_lines_skipped);
    if n_points + n_lines > 0 {
        notes.warn(format!(
            "{n_points} points and {n_lines} line segments have no surface and are left out"
        ));
    }
    if meshes.is_empty() {
        notes.warn("the scene has no triangles");
    }
}

fn scene_name(scene: Option<&Item<'_>>, file_name: &str) -> String {
    match scene.and_then(Item::name) {
        Some(name) => name.to_owned(),
        None => Path::new(file_name).file_stem().map_or_else(
            || file_name.to_owned(),
            |stem| stem.to_string_lossy().into_owned(),
        ),
    }
}

/// `asset.extras.about`.
fn about(root: &Item<'_>) -> Option<String> {
    let extras = root.child_if_object("asset")?.child_if_object("extras")?;
    extras.text("about").ok().flatten().map(str::to_owned)
}
