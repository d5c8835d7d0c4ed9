//! A bounding volume hierarchy over triangles.
//!
//! obvhs builds the tree; the triangle test is our own, watertight one. Of two
//! triangles at the same distance the one with the lower index is hit, so that the
//! answer does not depend on the order in which the tree is walked.

use std::time::Duration;

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;

use super::triangle::{Corners, ShearedRay, corners};
use crate::math::Ray;

/// A tree over triangles.
pub struct Bvh {
    tree: Bvh2,
    /// Corners in the order of the leaves.
    corners: Vec<Corners>,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance along the ray, metres.
    pub t: f32,
    /// Index of the triangle.
    pub triangle: u32,
    /// Barycentric coordinates of the second and third corner.
    pub barycentrics: [f32; 2],
}

impl std::fmt::Debug for Bvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Bvh({} triangles)", self.corners.len())
    }
}

impl Bvh {
    /// A tree over triangles with finite corners.
    #[must_use]
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        let for_builder: Vec<Triangle> = triangles
            .iter()
            .map(|t| Triangle {
                v0: t[0].into(),
                v1: t[1].into(),
                v2: t[2].into(),
            })
            .collect();
        let params = if triangles.len() > 200_000 {
            BvhBuildParams::medium_build()
        } else {
            BvhBuildParams::slow_build()
        };
        let tree = build_bvh2_from_tris(&for_builder, params, &mut Duration::default());
        let corners = tree
            .primitive_indices
            .iter()
            .map(|i| corners(&triangles[*i as usize]))
            .collect();
        Self { tree, corners }
    }

    /// What the ray meets first, if anything.
    #[inline]
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        if self.corners.is_empty() {
            return None;
        }
        let sheared = ShearedRay::new(ray.origin, ray.direction);
        let mut best: Option<Hit> = None;
        let mut limit = ray.t_max;
        let traversal = traversal_ray(ray);
        self.tree
            .ray_traverse(traversal, &mut obvhs::ray::RayHit::none(), |_, slot| {
                let Some(hit) = sheared.intersect(&self.corners[slot], limit) else {
                    return f32::INFINITY;
                };
                let triangle = self.tree.primitive_indices[slot];
                let is_better =
                    best.is_none_or(|b| hit.t < b.t || (hit.t == b.t && triangle < b.triangle));
                if is_better {
                    limit = hit.t;
                    best = Some(Hit {
                        t: hit.t,
                        triangle,
                        barycentrics: hit.barycentrics,
                    });
                }
                hit.t
            });
        best
    }

    /// True if anything is in the way of the ray before its end.
    #[inline]
    #[must_use]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        if self.corners.is_empty() {
            return false;
        }
        let sheared = ShearedRay::new(ray.origin, ray.direction);
        !self.tree.ray_traverse_miss(traversal_ray(ray), |_, slot| {
            match sheared.intersect(&self.corners[slot], ray.t_max) {
                Some(hit) if hit.t < ray.t_max => hit.t,
                _ => f32::INFINITY,
            }
        })
    }
}

fn traversal_ray(ray: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(ray.origin.into(), ray.direction.into(), 0.0, ray.t_max)
}
