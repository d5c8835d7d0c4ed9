//! Meshes that stand in the world many times: one tree over the instances, one for each mesh.

use glam::{Affine3A, Vec3};

use super::binary::Aabb;
use super::build::{TreeQuality, tree_of_items, tree_of_triangles};
use super::wide::WideTree;
use crate::math::Ray;

/// Instances of meshes, with a tree over them.
#[derive(Debug, Default)]
pub(super) struct Instances {
    pub(super) tree: WideTree,
    pub(super) instances: Vec<Instance>,
    /// `meshes[mesh]`, each in its own space.
    pub(super) meshes: Vec<WideTree>,
}

/// A mesh that stands somewhere in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instance {
    mesh_from_world: Affine3A,
    /// The same with all numbers positive: bounds what the transform of a point rounds.
    magnitudes: Affine3A,
    pub(super) mesh: usize,
    /// Index of its first triangle among those of the scene.
    pub(super) first_triangle: u32,
}

/// Where a mesh stands.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// Index of the mesh.
    pub mesh: usize,
    /// Takes mesh space to world space; invertible.
    pub world_from_mesh: Affine3A,
    /// Index of its first triangle among those of the scene.
    pub first_triangle: u32,
}

/// Room for the rounding of a transform and its inverse, relative to the size of what is
/// transformed and its distance from the origin.
const BOX_PADDING: f32 = 32.0 * f32::EPSILON;

impl Instances {
    /// Trees over `meshes[mesh][triangle]` and over their placements.
    pub(super) fn new(
        meshes: &[Vec<[Vec3; 3]>],
        placements: &[Placement],
        quality: TreeQuality,
    ) -> Self {
        let meshes: Vec<WideTree> = meshes
            .iter()
            .map(|m| tree_of_triangles(m, quality))
            .collect();
        let boxes: Vec<Aabb> = placements
            .iter()
            .map(|placement| {
                let [min, max] = meshes[placement.mesh].bounds;
                let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
                for i in 0..8 {
                    let pick =
                        |bit: usize, axis: usize| if i & bit == 0 { min[axis] } else { max[axis] };
                    let corner = Vec3::new(pick(1, 0), pick(2, 1), pick(4, 2));
                    let p = placement.world_from_mesh.transform_point3(corner);
                    (low, high) = (low.min(p), high.max(p));
                }
                let padding = BOX_PADDING * low.abs().max(high.abs()).max_element();
                Aabb::of(&[low - padding, high + padding])
            })
            .collect();
        Self {
            tree: tree_of_items(&boxes, quality),
            instances: placements
                .iter()
                .map(|p| {
                    let mesh_from_world = p.world_from_mesh.inverse();
                    let columns = mesh_from_world.to_cols_array_2d();
                    Instance {
                        mesh_from_world,
                        magnitudes: Affine3A::from_cols_array_2d(&columns.map(|c| c.map(f32::abs))),
                        mesh: p.mesh,
                        first_triangle: p.first_triangle,
                    }
                })
                .collect(),
            meshes,
        }
    }

    /// Memory that they take, bytes.
    pub(super) fn n_bytes(&self) -> usize {
        let meshes: usize = self.meshes.iter().map(WideTree::n_bytes).sum();
        self.tree.n_bytes() + size_of_val(self.instances.as_slice()) + meshes
    }
}

impl Instance {
    /// The ray in the mesh's space: its direction is not of unit length there, so that distances
    /// stay those of the world.
    #[inline(always)]
    pub(super) fn ray_inside(&self, ray: &Ray, t_max: f32) -> Ray {
        let origin = self.mesh_from_world.transform_point3(ray.origin());
        let direction = self.mesh_from_world.transform_vector3(ray.direction());
        Ray::with_end(origin, direction, t_max)
            .leaving(ray.leaves().wrapping_sub(self.first_triangle))
            .aimed_at(ray.aims_at().wrapping_sub(self.first_triangle))
    }

    /// How large the coordinates were that the origin of [`Self::ray_inside`] is made of.
    #[inline(always)]
    pub(super) fn reach(&self, ray: &Ray) -> f32 {
        let origin = ray.origin().abs();
        self.magnitudes.transform_point3(origin).max_element()
    }
}
