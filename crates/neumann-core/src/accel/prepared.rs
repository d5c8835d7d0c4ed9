//! Rays made ready for both tests.

use glam::Vec4;

use super::instances::Instance;
use super::wide::{Leaf, WideTree};
use crate::math::Ray;

/// Room for the rounding of three operations on either side of a box. What a ray has met is moved
/// out as well: a triangle in a box right behind may be as near, and count.
pub(super) const FAR_PADDING: f32 = 1.0 + 8.0 * f32::EPSILON;

/// Slack of a distance, relative to how far away the corners of the triangle are along the axis
/// that the ray runs along most: what the test rounds, with room for triangles fifty times as long
/// as they are wide, or seen as small.
pub(super) const DEPTH_SLACK: f32 = 1.0 / 16_384.0;
/// Slack relative to the coordinates of the origin: what an origin on a surface may be off it, and
/// surfaces in one plane off each other.
const ORIGIN_SLACK: f32 = 1.0 / 1_048_576.0;

/// A ray prepared for both tests.
pub(in crate::accel) struct Prepared {
    pub(in crate::accel) origin: [f32; 3],
    pub(in crate::accel) inverse: [f32; 3],
    /// For each axis, the row of a node's bounds that the ray meets first; the next or the one
    /// before is met last.
    pub(in crate::accel) near: [usize; 3],
    /// Axes of the sheared frame; the ray runs along the last.
    pub(in crate::accel) axes: [usize; 3],
    pub(in crate::accel) shear: [f32; 3],
    /// Slack of all distances,
    pub(in crate::accel) slack: f32,
    /// and more for every metre that corners are away along the last axis.
    pub(in crate::accel) slack_of_depth: f32,
    /// No hit has more slack.
    pub(in crate::accel) most_slack: f32,
    /// The triangles that it starts and ends on.
    pub(in crate::accel) ends: [u32; 2],
}

impl Prepared {
    #[inline(always)]
    pub(super) fn new(tree: &WideTree, ray: &Ray) -> Self {
        let reach = ray.origin().abs().max_element();
        Self::reaching(tree, ray, reach)
    }

    /// The ray in the space of an instance's mesh, before `end`.
    #[inline(always)]
    pub(super) fn inside(mesh: &WideTree, instance: &Instance, ray: &Ray, end: f32) -> Self {
        Self::reaching(mesh, &instance.ray_inside(ray, end), instance.reach(ray))
    }

    /// A ray of which the origin is rounded as coordinates of the size `reach` are.
    #[inline(always)]
    fn reaching(tree: &WideTree, ray: &Ray, reach: f32) -> Self {
        let direction = ray.direction_and_one;
        let magnitude = direction.abs();
        // A huge but finite inverse keeps 0 · ∞ out of the slab test.
        let inverse = Vec4::select(
            magnitude.cmplt(Vec4::splat(1e-18)),
            Vec4::splat(1e18).copysign(direction),
            direction.recip(),
        );
        let is_negative = direction.is_negative_bitmask() as usize;
        let (d, inverse) = (direction.to_array(), inverse.to_array());
        // Written so that no branch depends on the direction.
        let [along_x, along_y, along_z, _] = magnitude.to_array();
        let z = usize::from(along_y > along_x);
        let z = if along_z > along_x.max(along_y) { 2 } else { z };
        let [x, y, _] = AXES[z];
        let scale = inverse[z];
        Self {
            origin: ray.origin().to_array(),
            inverse: [inverse[0], inverse[1], inverse[2]],
            near: [0, 1, 2].map(|axis| 2 * axis + (is_negative >> axis & 1)),
            axes: AXES[z],
            shear: [d[x] * scale, d[y] * scale, scale],
            slack: slack_of_origin(reach, scale),
            slack_of_depth: slack_of_depth(scale),
            most_slack: most_slack(tree, ray.origin().abs().max_element(), reach, scale),
            ends: [ray.leaves(), ray.aims_at()],
        }
    }

    /// Slack of a hit of the triangle in a lane of a leaf.
    #[inline(always)]
    pub(super) fn slack_in(&self, leaf: &Leaf, lane: usize) -> f32 {
        let z = self.axes[2];
        let depth = |corner: usize| (leaf.corners[corner][z][lane] - self.origin[z]).abs();
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        larger(larger(depth(0), depth(1)), depth(2)) * self.slack_of_depth + self.slack
    }
}

/// [`Prepared::slack`] from the largest coordinate of the origin and the inverse of the direction
/// along the last axis.
#[inline(always)]
pub(in crate::accel) fn slack_of_origin(reach: f32, scale: f32) -> f32 {
    reach * ORIGIN_SLACK * scale.abs()
}

/// [`Prepared::most_slack`] in a tree, from the largest coordinate of the origin as it is and the
/// one that it is rounded as, and the inverse of the direction along the last axis: no corner is
/// deeper than both coordinates together.
#[inline(always)]
pub(in crate::accel) fn most_slack(tree: &WideTree, origin: f32, reach: f32, scale: f32) -> f32 {
    (tree.reach + origin) * slack_of_depth(scale) + slack_of_origin(reach, scale)
}

/// [`Prepared::slack_of_depth`] from the inverse of the direction along the last axis.
#[inline(always)]
pub(in crate::accel) fn slack_of_depth(scale: f32) -> f32 {
    DEPTH_SLACK * scale.abs()
}

/// The axes of the sheared frame, by the axis that the ray runs along most. Where it does so
/// backwards, corners go around in the other sense; that turns the signs of all edge functions and
/// of their sum, and changes no hit.
pub(in crate::accel) const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];
