//! From a description to world-space geometry; whatever cannot be rendered is
//! left out with a warning that names it.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};

use super::description::{InstanceDescription, MeshDescription, SceneDescription};
use super::geometry::{self, Geometry, MeshArrays, MeshPlacement, PlacedMesh};
use super::subject::{Corners, subject};
use super::{OpeningProgress, OpeningStep};
use crate::accel::{Bvh, TreeQuality};

/// Coordinates beyond this overflow in single precision when squared and multiplied.
const LARGEST_COORDINATE: f32 = 1e9;

/// A mesh is kept once, with a tree of its own, where putting all its copies into the one tree
/// would take so many triangles more; one tree is faster.
const LEAST_SHARED_TRIANGLES: usize = 200_000;

/// Copies of all meshes together come to so many triangles at most.
const MOST_COPIES: usize = 8_000_000;

/// Places all meshes in the world and builds the tree over them.
pub(super) fn geometry(
    description: &SceneDescription,
    default_material: usize,
    quality: TreeQuality,
    progress: &OpeningProgress,
    warnings: &mut Vec<String>,
) -> (Geometry, Bvh) {
    let mut builder = Builder {
        description,
        default_material,
        warnings,
        meshes: Vec::new(),
        n_triangles: 0,
        objects: HashMap::new(),
        n_objects: 0,
    };
    let (shared, single): (Vec<_>, Vec<_>) = {
        let is_shared = meshes_to_share(description);
        let instances = description.instances.iter();
        instances.partition(|i| is_shared.get(i.mesh).copied().unwrap_or(false))
    };
    let n_single = single.len();
    for (n_placed, instance) in single.into_iter().enumerate() {
        progress.reach(OpeningStep::Placing, n_placed, n_single);
        builder.add(instance);
    }
    progress.reach(OpeningStep::Tree, 0, 1);
    builder.finish(&shared, quality)
}

/// Which meshes are kept once for all their instances.
fn meshes_to_share(description: &SceneDescription) -> Vec<bool> {
    let mut n_uses = vec![0usize; description.meshes.len()];
    for instance in &description.instances {
        if let Some(n) = n_uses.get_mut(instance.mesh) {
            *n += 1;
        }
    }
    // Vertices that no triangle uses are copied as well.
    let copies = |(mesh, n): (&MeshDescription, usize)| {
        let size = mesh.triangles.len().max(mesh.positions.len() / 3);
        n.saturating_sub(1).saturating_mul(size)
    };
    let copies: Vec<usize> = description.meshes.iter().zip(n_uses).map(copies).collect();
    // What is copied least, as long as all copies together are few enough.
    let mut by_copies: Vec<usize> = (0..copies.len()).collect();
    by_copies.sort_by_key(|mesh| copies[*mesh]);
    let mut is_shared = vec![false; copies.len()];
    let mut n_copied = 0usize;
    for mesh in by_copies {
        n_copied = n_copied.saturating_add(copies[mesh]);
        is_shared[mesh] = copies[mesh] >= LEAST_SHARED_TRIANGLES || n_copied > MOST_COPIES;
    }
    is_shared
}

/// Geometry on its way.
struct Builder<'a> {
    description: &'a SceneDescription,
    default_material: usize,
    warnings: &'a mut Vec<String>,
    meshes: Vec<PlacedMesh>,
    n_triangles: usize,
    /// Numbers of those objects that may have several meshes, by the object of the description and
    /// its place.
    objects: HashMap<(usize, [u32; 16]), u32>,
    n_objects: u32,
}

impl Builder<'_> {
    /// Number of the object that a mesh is part of where it stands.
    fn object(&mut self, instance: &InstanceDescription) -> u32 {
        let next = self.n_objects;
        let number = match self.description.meshes[instance.mesh].object {
            None => next,
            Some(object) => {
                let place = instance.world_from_mesh.to_cols_array().map(f32::to_bits);
                *self.objects.entry((object, place)).or_insert(next)
            }
        };
        self.n_objects += u32::from(number == next);
        number
    }

    /// Puts a mesh into the world, triangle by triangle.
    fn add(&mut self, instance: &InstanceDescription) {
        let Some(mesh) = self.description.meshes.get(instance.mesh) else {
            return;
        };
        let Some(mut placed) = place(instance, mesh, self.default_material, self.warnings) else {
            return;
        };
        placed.first_triangle = self.n_triangles as u32;
        placed.object = self.object(instance);
        self.n_triangles += placed.arrays.triangles.len();
        self.meshes.push(placed);
    }

    /// Adds the instances of shared meshes, and builds the trees.
    fn finish(mut self, shared: &[&InstanceDescription], quality: TreeQuality) -> (Geometry, Bvh) {
        let first_instance = self.meshes.len();
        let mut n_triangles = self.n_triangles;
        let mut boxes = Boxes::default();
        for mesh in &self.meshes {
            boxes.add(mesh.object, bounds_of(mesh.triangles().flatten()));
        }
        // A mesh and its mirror image, whose triangles are wound the other way, are two.
        let mut numbers = HashMap::new();
        let mut arrays: Vec<Option<Arc<MeshArrays>>> = Vec::new();
        for instance in shared {
            let placement = MeshPlacement::new(instance.world_from_mesh);
            let mesh = &self.description.meshes[instance.mesh];
            let number = *numbers
                .entry((instance.mesh, placement.is_mirrored))
                .or_insert_with(|| {
                    let shared = share(mesh, placement.is_mirrored, self.warnings);
                    arrays.push(shared.map(Arc::new));
                    arrays.len() - 1
                });
            let Some(shared) = &arrays[number] else {
                continue;
            };
            if n_triangles + shared.triangles.len() >= u32::MAX as usize {
                self.warnings.push(format!(
                    "node '{}': more than {} triangles; left out",
                    instance.name,
                    u32::MAX
                ));
                continue;
            }
            // Of its triangles: vertices that none of them uses may be anywhere.
            let used = shared.triangles.iter().flatten();
            let (low, high) = bounds_of(used.map(|v| shared.positions[*v as usize]));
            let box_corners = (0..8).map(|i| {
                let pick = |bit, low, high| if i & bit == 0 { low } else { high };
                placement.world_from_mesh.transform_point3(Vec3::new(
                    pick(1, low.x, high.x),
                    pick(2, low.y, high.y),
                    pick(4, low.z, high.z),
                ))
            });
            let (low, high) = bounds_of(box_corners);
            if !is_sound(&placement, low, high) {
                self.warnings.push(format!(
                    "node '{}': its transform is not finite, flat, or goes beyond 1e9 m; left out",
                    instance.name
                ));
                continue;
            }
            let object = self.object(instance);
            boxes.add(object, (low, high));
            self.meshes.push(PlacedMesh {
                object,
                name: name_of(instance, mesh).clone(),
                first_triangle: n_triangles as u32,
                material: mesh.material.unwrap_or(self.default_material) as u32,
                arrays: Arc::clone(shared),
                placement: Some(Box::new(placement)),
            });
            n_triangles += shared.triangles.len();
        }
        let nothing = (Vec3::NEG_ONE, Vec3::ONE);
        let subject = subject(&boxes.objects).unwrap_or(nothing);
        let (min, max) = boxes.all().unwrap_or(nothing);
        let tree = geometry::tree(&self.meshes, first_instance, quality);
        // Only now, as the tree takes most memory while it is built.
        let mut facets = Vec::with_capacity(self.n_triangles);
        for (number, mesh) in self.meshes[..first_instance].iter().enumerate() {
            facets.extend(mesh.facets(number as u32));
        }
        let geometry = Geometry {
            meshes: self.meshes,
            facets,
            first_instance,
            n_triangles,
            min,
            max,
            subject,
        };
        (geometry, tree)
    }
}

/// Boxes of objects, by their numbers.
#[derive(Default)]
struct Boxes {
    objects: Vec<Corners>,
}

impl Boxes {
    /// Adds a mesh to the box of its object.
    fn add(&mut self, object: u32, (low, high): Corners) {
        let empty = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let length = self.objects.len().max(object as usize + 1);
        self.objects.resize(length, empty);
        let (min, max) = self.objects[object as usize];
        self.objects[object as usize] = (min.min(low), max.max(high));
    }

    /// The box around all of them.
    fn all(&self) -> Option<Corners> {
        let boxes = self.objects.iter().copied();
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

fn bounds_of(points: impl Iterator<Item = Vec3>) -> (Vec3, Vec3) {
    points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), p| {
        (min.min(p), max.max(p))
    })
}

/// True if rays can be taken into the instance and back, and the box around it is where rays are
/// exact enough.
fn is_sound(placement: &MeshPlacement, low: Vec3, high: Vec3) -> bool {
    placement.world_from_mesh.is_finite()
        && placement.world_from_mesh.inverse().is_finite()
        && low.abs().max(high.abs()).max_element() <= LARGEST_COORDINATE
}

fn name_of<'a>(instance: &'a InstanceDescription, mesh: &'a MeshDescription) -> &'a String {
    if instance.name.is_empty() {
        &mesh.name
    } else {
        &instance.name
    }
}

/// A mesh in its own space, for all its instances; `None` if nothing of it can be rendered.
fn share(
    mesh: &MeshDescription,
    is_mirrored: bool,
    warnings: &mut Vec<String>,
) -> Option<MeshArrays> {
    let triangles = sound_triangles(&mesh.name, mesh, &mesh.positions, is_mirrored, warnings);
    if triangles.is_empty() {
        return None;
    }
    let n = mesh.positions.len();
    Some(MeshArrays {
        triangles,
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone().filter(|v| v.len() == n),
        tangents: mesh.tangents.clone().filter(|v| v.len() == n),
        uv_sets: sound_uv_sets(mesh),
        colors: mesh.colors.clone().filter(|v| v.len() == n),
    })
}

fn sound_uv_sets(mesh: &MeshDescription) -> Vec<Vec<Vec2>> {
    let n = mesh.positions.len();
    let sets = mesh.uv_sets.iter().filter(|set| set.len() == n);
    sets.cloned().collect()
}

fn place(
    instance: &InstanceDescription,
    mesh: &MeshDescription,
    default_material: usize,
    warnings: &mut Vec<String>,
) -> Option<PlacedMesh> {
    let name = name_of(instance, mesh);
    if !instance.world_from_mesh.is_finite() {
        warnings.push(format!(
            "node '{name}': its transform is not finite; left out"
        ));
        return None;
    }
    let placement = MeshPlacement::new(instance.world_from_mesh);
    let positions: Vec<Vec3> = mesh
        .positions
        .iter()
        .map(|p| instance.world_from_mesh.transform_point3(*p))
        .collect();
    let is_mirrored = placement.is_mirrored;
    let triangles = sound_triangles(name, mesh, &positions, is_mirrored, warnings);
    if triangles.is_empty() {
        if !mesh.triangles.is_empty() {
            warnings.push(format!(
                "node '{name}': nothing of mesh '{}' is left to render",
                mesh.name
            ));
        }
        return None;
    }
    let n = positions.len();
    let normals = mesh.normals.as_ref().filter(|v| v.len() == n).map(|v| {
        v.iter()
            .map(|normal| {
                (placement.normal_matrix * *normal)
                    .try_normalize()
                    .unwrap_or(Vec3::ZERO)
            })
            .collect::<Vec<_>>()
    });
    let tangents = mesh.tangents.as_ref().filter(|v| v.len() == n).map(|v| {
        v.iter()
            .map(|t| {
                let tangent = placement.tangent(*t);
                let along = tangent.truncate().normalize_or_zero();
                along.extend(tangent.w)
            })
            .collect::<Vec<Vec4>>()
    });
    if normals
        .as_ref()
        .is_some_and(|v| v.iter().any(|n| !n.is_finite() || *n == Vec3::ZERO))
    {
        warnings.push(format!(
            "mesh '{}': some normals have no direction; flat ones are used there",
            mesh.name
        ));
    }
    Some(PlacedMesh {
        name: name.clone(),
        first_triangle: 0,
        object: 0,
        material: mesh.material.unwrap_or(default_material) as u32,
        arrays: Arc::new(MeshArrays {
            triangles,
            positions,
            normals,
            tangents,
            uv_sets: sound_uv_sets(mesh),
            colors: mesh.colors.clone().filter(|v| v.len() == n),
        }),
        placement: None,
    })
}

/// The triangles with finite corners and an area, wound for the world.
fn sound_triangles(
    name: &str,
    mesh: &MeshDescription,
    positions: &[Vec3],
    is_mirrored: bool,
    warnings: &mut Vec<String>,
) -> Vec<[u32; 3]> {
    let (mut n_odd, mut n_flat) = (0usize, 0usize);
    let triangles = mesh
        .triangles
        .iter()
        .filter_map(|&[a, b, c]| {
            let corners = [a, b, c].map(|v| positions.get(v as usize).copied());
            let [Some(p), Some(q), Some(r)] = corners else {
                n_odd += 1;
                return None;
            };
            let is_sound = |v: Vec3| v.is_finite() && v.abs().max_element() <= LARGEST_COORDINATE;
            if !(is_sound(p) && is_sound(q) && is_sound(r)) {
                n_odd += 1;
                return None;
            }
            let cross = (q - p).cross(r - p);
            if cross.try_normalize().is_none() {
                n_flat += 1;
                return None;
            }
            Some(if is_mirrored { [a, c, b] } else { [a, b, c] })
        })
        .collect();
    let mesh_name = &mesh.name;
    if n_odd > 0 {
        warnings.push(format!(
            "node '{name}', mesh '{mesh_name}': {n_odd} triangles with corners that are not finite \
             (or beyond 1e9 m) left out"
        ));
    }
    if n_flat > 0 {
        warnings.push(format!(
            "node '{name}', mesh '{mesh_name}': {n_flat} triangles without area left out"
        ));
    }
    triangles
}
