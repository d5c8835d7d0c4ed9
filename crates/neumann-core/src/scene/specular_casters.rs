//! Mirrors and glass, as that which casts caustics.
//!
//! A diffuse surface that is lit by way of a mirror or smooth glass can only be rendered by camera
//! paths that happen to leave it for one of them. Where these things are is known, so more paths
//! may be sent there.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;

use super::geometry::{Geometry, MeshArrays, PlacedMesh};
use crate::bsdf::Bsdf;
use crate::endpoint::Lights;
use crate::endpoint::light::Light;
use crate::material::Material;

/// Something mirror-like: a sphere about it, world space, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecularCaster {
    /// Its centre.
    pub center: Vec3,
    /// Its radius.
    pub radius: f32,
}

/// The radius of a specular caster, in units of the scene's own, is less than this.
const LARGEST: f32 = 0.5;

impl SpecularCaster {
    /// So many are kept of a scene, at most: the largest ones.
    pub const MAX: usize = 4;
}

/// The largest meshes that are mirrors or smooth glass all over, those aside that are nearly the
/// scene itself, if there are lights that paths may meet by way of them.
pub(super) fn specular_casters(
    geometry: &Geometry,
    materials: &[Material],
    lights: &Lights,
) -> Vec<SpecularCaster> {
    // A sky of one radiance is found by whatever leaves the scene.
    let is_even = lights.uniform_environment().is_some();
    let can_be_missed = |light: &Light| match light {
        Light::Area(_) => true,
        Light::Environment(_) => !is_even,
        Light::Point(_) | Light::Spot(_) | Light::Directional(_) => false,
    };
    if lights.n_triangles() == 0 && !lights.as_slice().iter().any(can_be_missed) {
        return Vec::new();
    }
    // From within the sphere of a sea, it is not known where to aim.
    let largest = LARGEST * 0.5 * geometry.min.distance(geometry.max);
    // One for all instances of a mesh.
    let mut spheres = HashMap::new();
    let mut casters: Vec<SpecularCaster> = geometry
        .meshes()
        .iter()
        .filter(|mesh| is_mirror_like(&materials[mesh.material as usize]))
        .map(|mesh| {
            let sphere = spheres
                .entry(Arc::as_ptr(&mesh.arrays))
                .or_insert_with(|| sphere_about(&mesh.arrays));
            placed(mesh, sphere)
        })
        .filter(|caster| caster.radius > 0.0 && caster.radius < largest)
        .collect();
    casters.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    casters.truncate(SpecularCaster::MAX);
    casters
}

fn is_mirror_like(material: &Material) -> bool {
    match material.uniform_bsdf() {
        Some(bsdf @ (Bsdf::Conductor(_) | Bsdf::Dielectric(_))) => !bsdf.has_density(),
        _ => false,
    }
}

/// A sphere about the middle of a mesh's box.
fn sphere_about(arrays: &MeshArrays) -> SpecularCaster {
    let positions = || arrays.positions.iter().copied();
    let min = positions().reduce(Vec3::min).unwrap_or_default();
    let max = positions().reduce(Vec3::max).unwrap_or_default();
    let center = 0.5 * (min + max);
    let radius = positions().map(|p| p.distance(center)).fold(0.0, f32::max);
    SpecularCaster { center, radius }
}

/// The sphere about a mesh, where it stands in the world. A mesh that is sheared may stand out of
/// it a little.
fn placed(mesh: &PlacedMesh, sphere: &SpecularCaster) -> SpecularCaster {
    let Some(placement) = &mesh.placement else {
        return *sphere;
    };
    let affine = placement.world_from_mesh;
    let axes = [0, 1, 2].map(|i| affine.matrix3.col(i).length());
    SpecularCaster {
        center: affine.transform_point3(sphere.center),
        radius: sphere.radius * axes.into_iter().fold(0.0, f32::max),
    }
}
