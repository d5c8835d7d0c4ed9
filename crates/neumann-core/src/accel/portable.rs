//! Both tests over plain arrays, for any processor: compilers make four-wide code of it.

use super::abreast::RayLanes;
use super::hits::{Crossing, Hit, Occlusion, PackedHit};
use super::instances::Instances;
use super::prepared::{FAR_PADDING, Prepared};
use super::traverse::{self, BoxHits, Kernel, LaneHits, OcclusionLanes, decide_in_double};
use super::wide::{LEAF_SIZE, Leaf, Node, WIDTH, WideTree};
use crate::math::Ray;

struct Portable;

#[inline(never)]
pub(super) fn closest(tree: &WideTree, ray: &Ray) -> PackedHit {
    traverse::closest::<Portable>(tree, ray).into()
}

#[inline(never)]
pub(super) fn any(tree: &WideTree, ray: &Ray) -> Occlusion {
    traverse::any::<Portable>(tree, ray)
}

#[inline(never)]
pub(super) fn closest_of_lanes(tree: &WideTree, rays: &RayLanes, hits: &mut [Hit]) -> u32 {
    traverse::closest_of_lanes::<Portable>(tree, rays, hits)
}

#[inline(never)]
pub(super) fn any_of_lanes(tree: &WideTree, rays: &RayLanes) -> OcclusionLanes {
    traverse::any_of_lanes::<Portable>(tree, rays)
}

#[inline(never)]
pub(super) fn closest_of_all(tree: &WideTree, instances: &Instances, ray: &Ray) -> PackedHit {
    traverse::closest_of_all::<Portable>(tree, instances, ray).into()
}

#[inline(never)]
pub(super) fn any_of_instances(instances: &Instances, ray: &Ray) -> Occlusion {
    traverse::any_of_instances::<Portable>(instances, ray)
}

#[inline(never)]
pub(super) fn crossings(
    tree: &WideTree,
    instances: Option<&Instances>,
    ray: &Ray,
    visit: &mut dyn FnMut(&Crossing) -> f32,
) {
    traverse::crossings::<Portable>(tree, instances, ray, visit);
}

impl Kernel for Portable {
    #[inline(always)]
    fn meet_boxes(node: &Node, ray: &Prepared, t_max: f32) -> BoxHits {
        let mut near = [0f32; WIDTH];
        let mut far = [f32::INFINITY; WIDTH];
        for axis in 0..3 {
            let (o, inverse) = (ray.origin[axis], ray.inverse[axis]);
            let first = &node.bounds[ray.near[axis]];
            let last = &node.bounds[ray.near[axis] ^ 1];
            for lane in 0..WIDTH {
                let t = (first[lane] - o) * inverse;
                near[lane] = if t > near[lane] { t } else { near[lane] };
            }
            for lane in 0..WIDTH {
                let t = (last[lane] - o) * inverse;
                far[lane] = if t < far[lane] { t } else { far[lane] };
            }
        }
        let mut mask = 0u32;
        for lane in 0..WIDTH {
            let end = if far[lane] < t_max { far[lane] } else { t_max };
            mask |= u32::from(near[lane] <= end * FAR_PADDING) << lane;
        }
        BoxHits { mask, near }
    }

    #[inline(always)]
    fn meet_triangles(leaf: &Leaf, ray: &Prepared, t_max: f32) -> LaneHits {
        let [kx, ky, kz] = ray.axes;
        let [sx, sy, sz] = ray.shear;
        let (ox, oy, oz) = (ray.origin[kx], ray.origin[ky], ray.origin[kz]);
        let mut x = [[0f32; LEAF_SIZE]; 3];
        let mut y = [[0f32; LEAF_SIZE]; 3];
        let mut z = [[0f32; LEAF_SIZE]; 3];
        for corner in 0..3 {
            let c = &leaf.corners[corner];
            for lane in 0..LEAF_SIZE {
                let depth = c[kz][lane] - oz;
                z[corner][lane] = depth;
                x[corner][lane] = c[kx][lane] - ox - sx * depth;
                y[corner][lane] = c[ky][lane] - oy - sy * depth;
            }
        }
        let mut u = [0f32; LEAF_SIZE];
        let mut v = [0f32; LEAF_SIZE];
        let mut w = [0f32; LEAF_SIZE];
        let mut on_edge = false;
        for lane in 0..LEAF_SIZE {
            u[lane] = x[2][lane] * y[1][lane] - y[2][lane] * x[1][lane];
            v[lane] = x[0][lane] * y[2][lane] - y[0][lane] * x[2][lane];
            w[lane] = x[1][lane] * y[0][lane] - y[1][lane] * x[0][lane];
            on_edge |= u[lane] == 0.0 || v[lane] == 0.0 || w[lane] == 0.0;
        }
        if on_edge {
            decide_in_double(&x, &y, &mut u, &mut v, &mut w);
        }
        let mut hits = LaneHits::NONE;
        for lane in 0..LEAF_SIZE {
            let is_outside = (u[lane] < 0.0 || v[lane] < 0.0 || w[lane] < 0.0)
                && (u[lane] > 0.0 || v[lane] > 0.0 || w[lane] > 0.0);
            let determinant = u[lane] + v[lane] + w[lane];
            let inverse = 1.0 / determinant;
            let scaled = u[lane] * z[0][lane] + v[lane] * z[1][lane] + w[lane] * z[2][lane];
            let t = sz * scaled * inverse;
            hits.t[lane] = t;
            hits.v[lane] = v[lane] * inverse;
            hits.w[lane] = w[lane] * inverse;
            let is_there = determinant != 0.0 && !ray.ends.contains(&leaf.triangles[lane]);
            let is_between = t + ray.most_slack > 0.0 && t - ray.most_slack < t_max;
            let is_hit = !is_outside && is_there && is_between;
            hits.mask |= u32::from(is_hit) << lane;
        }
        hits
    }

    #[inline(always)]
    fn is_at_end(leaf: &Leaf, ray: &Prepared) -> bool {
        leaf.triangles
            .iter()
            .any(|triangle| ray.ends.contains(triangle))
    }

    #[inline(always)]
    fn prefetch(_tree: &WideTree, _child: u32) {}
}
