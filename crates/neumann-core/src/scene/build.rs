//! From a description to world-space geometry; whatever cannot be rendered is
//! left out with a warning that names it.

use glam::{Mat3, Vec3, Vec4};

use super::description::{InstanceDescription, MeshDescription, SceneDescription};
use super::geometry::{Facet, Geometry, PlacedMesh};
use crate::accel::Bvh;

/// Coordinates beyond this overflow in single precision when squared and multiplied.
const LARGEST_COORDINATE: f32 = 1e9;

/// Places all meshes in the world and builds the tree over them.
pub(super) fn geometry(
    description: &SceneDescription,
    default_material: usize,
    warnings: &mut Vec<String>,
) -> Geometry {
    let mut meshes = Vec::new();
    let mut facets = Vec::new();
    let mut corners: Vec<[Vec3; 3]> = Vec::new();
    for instance in &description.instances {
        let Some(mesh) = description.meshes.get(instance.mesh) else {
            continue;
        };
        let Some(mut placed) = place(instance, mesh, default_material, warnings) else {
            continue;
        };
        placed.first_triangle = corners.len() as u32;
        let number = meshes.len() as u32;
        for triangle in &placed.triangles {
            let of_triangle = placed.corners(triangle.map(|v| v as usize));
            corners.push(of_triangle);
            facets.push(Facet::new(&of_triangle, number));
        }
        meshes.push(placed);
    }
    let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for corner in corners.iter().flatten() {
        min = min.min(*corner);
        max = max.max(*corner);
    }
    if corners.is_empty() {
        (min, max) = (Vec3::NEG_ONE, Vec3::ONE);
    }
    Geometry {
        bvh: Bvh::new(&corners),
        meshes,
        facets,
        min,
        max,
    }
}

fn place(
    instance: &InstanceDescription,
    mesh: &MeshDescription,
    default_material: usize,
    warnings: &mut Vec<String>,
) -> Option<PlacedMesh> {
    let name = if instance.name.is_empty() {
        &mesh.name
    } else {
        &instance.name
    };
    let world_from_mesh = instance.world_from_mesh;
    let linear = Mat3::from_mat4(world_from_mesh);
    if !world_from_mesh.is_finite() {
        warnings.push(format!(
            "node '{name}': its transform is not finite; left out"
        ));
        return None;
    }
    let positions: Vec<Vec3> = mesh
        .positions
        .iter()
        .map(|p| world_from_mesh.transform_point3(*p))
        .collect();
    let determinant = linear.determinant();
    let is_mirrored = determinant < 0.0;
    let normal_matrix = Mat3::from_cols(
        linear.y_axis.cross(linear.z_axis),
        linear.z_axis.cross(linear.x_axis),
        linear.x_axis.cross(linear.y_axis),
    ) * if is_mirrored { -1.0 } else { 1.0 };
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
                (normal_matrix * *normal)
                    .try_normalize()
                    .unwrap_or(Vec3::ZERO)
            })
            .collect::<Vec<_>>()
    });
    let tangents = mesh.tangents.as_ref().filter(|v| v.len() == n).map(|v| {
        v.iter()
            .map(|t| {
                let along = (linear * t.truncate()).normalize_or_zero();
                along.extend(if is_mirrored { -t.w } else { t.w })
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
        material: mesh.material.unwrap_or(default_material) as u32,
        triangles,
        normals,
        tangents,
        uv_sets: mesh
            .uv_sets
            .iter()
            .filter(|set| set.len() == n)
            .cloned()
            .collect(),
        colors: mesh.colors.as_ref().filter(|v| v.len() == n).cloned(),
        positions,
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
            "node '{name}', mesh '{mesh_name}': {n_odd} triangles with corners that are not finite (or beyond 1e9 m) left out"
        ));
    }
    if n_flat > 0 {
        warnings.push(format!(
            "node '{name}', mesh '{mesh_name}': {n_flat} triangles without area left out"
        ));
    }
    triangles
}
