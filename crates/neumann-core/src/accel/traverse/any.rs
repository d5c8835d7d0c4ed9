//! Whether anything is in the way of a ray.

use std::marker::PhantomData;

use super::{AnyVisitor, Kernel, passes, walk_below_root_until, walk_until};
use crate::accel::abreast::{BoxHitLanes, PreparedLanes, RayLanes};
use crate::accel::hits::Occlusion;
use crate::accel::instances::Instances;
use crate::accel::prepared::Prepared;
use crate::accel::wide::{LEAF_SIZE, Leaf, WideTree, leaf_of};
use crate::math::Ray;
use crate::math::lanes::lanes_of;

/// [`Occlusion`] in each lane: one bit for each that is stopped, or not sure.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OcclusionLanes {
    pub(crate) stopped: u32,
    pub(crate) unsure: u32,
}

/// Whether the ray meets any triangle before its end.
#[inline(always)]
pub(in crate::accel) fn any<K: Kernel>(tree: &WideTree, ray: &Ray) -> Occlusion {
    any_prepared::<K>(tree, &Prepared::new(tree, ray), ray.t_max())
}

#[inline(always)]
fn any_prepared<K: Kernel>(tree: &WideTree, prepared: &Prepared, end: f32) -> Occlusion {
    let mut triangles = AnyTriangle::<K> {
        tree,
        prepared,
        end,
        is_sure: true,
        kernel: PhantomData,
    };
    let is_stopped = walk_until::<K>(tree, prepared, end, &mut triangles);
    Occlusion::new(is_stopped, triangles.is_sure)
}

/// Whether the ray of each lane meets any triangle before its end.
#[inline(always)]
pub(in crate::accel) fn any_of_lanes<K: Kernel>(
    tree: &WideTree,
    rays: &RayLanes,
) -> OcclusionLanes {
    let prepared = PreparedLanes::new(tree, rays);
    let root = BoxHitLanes::new(&tree.nodes[0], rays, &prepared);
    let mut lanes = OcclusionLanes::default();
    for lane in lanes_of(rays.mask()) {
        let (prepared, end) = (prepared.get(lane), rays.end(lane));
        let mut triangles = AnyTriangle::<K> {
            tree,
            prepared: &prepared,
            end,
            is_sure: true,
            kernel: PhantomData,
        };
        let root = root.mask(lane);
        let is_stopped = walk_below_root_until::<K>(tree, &prepared, end, root, &mut triangles);
        lanes.stopped |= u32::from(is_stopped) << lane;
        lanes.unsure |= u32::from(!is_stopped & !triangles.is_sure) << lane;
    }
    lanes
}

/// Whether the ray meets any triangle of an instance before its end.
#[inline(always)]
pub(in crate::accel) fn any_of_instances<K: Kernel>(instances: &Instances, ray: &Ray) -> Occlusion {
    let mut inside = AnyInside::<K> {
        instances,
        ray,
        is_sure: true,
        kernel: PhantomData,
    };
    let (prepared, end) = (Prepared::new(&instances.tree, ray), ray.t_max());
    let is_stopped = walk_until::<K>(&instances.tree, &prepared, end, &mut inside);
    Occlusion::new(is_stopped, inside.is_sure)
}

/// Whether any triangle of a leaf is in the way of a ray before its end.
#[inline(always)]
pub(in crate::accel) fn look_into_leaf<K: Kernel>(
    leaf: &Leaf,
    prepared: &Prepared,
    end: f32,
) -> Occlusion {
    let lanes = K::meet_triangles(leaf, prepared, end);
    let mut mask = lanes.mask;
    let mut is_sure = true;
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize & (LEAF_SIZE - 1);
        mask &= mask - 1;
        let t = lanes.t[lane];
        let is_between = |slack: f32| t - slack > 0.0 && t + slack < end;
        if is_between(prepared.most_slack) {
            return Occlusion::Stopped;
        }
        let slack = prepared.slack_in(leaf, lane);
        if is_between(slack) {
            return Occlusion::Stopped;
        }
        is_sure &= t + slack <= 0.0 || t - slack >= end;
    }
    Occlusion::new(false, is_sure)
}

/// The same where any will do.
struct AnyTriangle<'a, K> {
    tree: &'a WideTree,
    prepared: &'a Prepared,
    end: f32,
    is_sure: bool,
    kernel: PhantomData<K>,
}

impl<K: Kernel> AnyVisitor for AnyTriangle<'_, K> {
    #[inline(always)]
    fn stops(&mut self, link: u32) -> bool {
        let leaf = &self.tree.leaves[leaf_of(link)];
        if passes::<K>(self.prepared, link, leaf) {
            return false;
        }
        let sight = look_into_leaf::<K>(leaf, self.prepared, self.end);
        self.is_sure &= sight != Occlusion::Unsure;
        sight == Occlusion::Stopped
    }
}

/// The same where any hit will do.
struct AnyInside<'a, K> {
    instances: &'a Instances,
    ray: &'a Ray,
    is_sure: bool,
    kernel: PhantomData<K>,
}

impl<K: Kernel> AnyVisitor for AnyInside<'_, K> {
    #[inline(always)]
    fn stops(&mut self, link: u32) -> bool {
        let instance = &self.instances.instances[leaf_of(link)];
        let mesh = &self.instances.meshes[instance.mesh];
        let end = self.ray.t_max();
        let prepared = Prepared::inside(mesh, instance, self.ray, end);
        let sight = any_prepared::<K>(mesh, &prepared, end);
        self.is_sure &= sight != Occlusion::Unsure;
        sight == Occlusion::Stopped
    }
}
