//! The first hit of a ray.

use std::marker::PhantomData;

use super::{Kernel, Visitor, passes, walk, walk_below_root};
use crate::accel::abreast::{BoxHitLanes, PreparedLanes, RayLanes};
use crate::accel::hits::Best;
use crate::accel::hits::Hit;
use crate::accel::instances::Instances;
use crate::accel::prepared::Prepared;
use crate::accel::wide::{LEAF_SIZE, Leaf, WideTree, leaf_of};
use crate::math::Ray;
use crate::math::lanes::lanes_of;

/// The first triangle that the ray meets, or what stands for none.
#[inline(always)]
pub(in crate::accel) fn closest<K: Kernel>(tree: &WideTree, ray: &Ray) -> Best {
    closest_prepared::<K>(tree, &Prepared::new(tree, ray), ray.t_max())
}

#[inline(always)]
fn closest_prepared<K: Kernel>(tree: &WideTree, prepared: &Prepared, end: f32) -> Best {
    let mut triangles = Triangles::<K> {
        tree,
        prepared,
        best: Best::none_before(end),
        kernel: PhantomData,
    };
    walk::<K>(tree, prepared, end, &mut triangles);
    triangles.best
}

/// The first triangles that rays meet, or what stands for none; lanes without a ray are left alone.
/// One bit is set for each lane that is not sure.
#[inline(always)]
pub(in crate::accel) fn closest_of_lanes<K: Kernel>(
    tree: &WideTree,
    rays: &RayLanes,
    hits: &mut [Hit],
) -> u32 {
    let mut unsure = 0;
    let prepared = PreparedLanes::new(tree, rays);
    let root = BoxHitLanes::new(&tree.nodes[0], rays, &prepared);
    for lane in lanes_of(rays.mask()) {
        let (prepared, end) = (prepared.get(lane), rays.end(lane));
        let mut triangles = Triangles::<K> {
            tree,
            prepared: &prepared,
            best: Best::none_before(end),
            kernel: PhantomData,
        };
        let near = |child: usize| root.near(child, lane);
        walk_below_root::<K>(tree, &prepared, end, root.mask(lane), near, &mut triangles);
        hits[lane] = triangles.best.hit;
        unsure |= u32::from(!triangles.best.is_sure()) << lane;
    }
    unsure
}

/// The first triangle that the ray meets, of those in the world and of those of instances.
#[inline(always)]
pub(in crate::accel) fn closest_of_all<K: Kernel>(
    tree: &WideTree,
    instances: &Instances,
    ray: &Ray,
) -> Best {
    let prepared = Prepared::new(tree, ray);
    let best = if tree.nodes.is_empty() {
        Best::none_before(ray.t_max())
    } else {
        closest_prepared::<K>(tree, &prepared, ray.t_max())
    };
    let end = best.end();
    let mut inside = Inside::<K> {
        instances,
        ray,
        best,
        kernel: PhantomData,
    };
    walk::<K>(&instances.tree, &prepared, end, &mut inside);
    inside.best
}

/// Puts the first triangle of a leaf that the ray meets into `best`, if it is before that.
#[inline(always)]
pub(in crate::accel) fn meet_leaf<K: Kernel>(leaf: &Leaf, prepared: &Prepared, best: &mut Best) {
    let lanes = K::meet_triangles(leaf, prepared, best.end());
    let mut mask = lanes.mask;
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize & (LEAF_SIZE - 1);
        mask &= mask - 1;
        let hit = Hit {
            t: lanes.t[lane],
            triangle: leaf.triangles[lane],
            barycentrics: [lanes.v[lane], lanes.w[lane]],
        };
        best.offer(hit, prepared.slack_in(leaf, lane));
    }
}

/// The triangles of a leaf.
struct Triangles<'a, K> {
    tree: &'a WideTree,
    prepared: &'a Prepared,
    best: Best,
    kernel: PhantomData<K>,
}

impl<K: Kernel> Visitor for Triangles<'_, K> {
    #[inline(always)]
    fn visit(&mut self, link: u32, end: f32) -> f32 {
        let leaf = &self.tree.leaves[leaf_of(link)];
        if passes::<K>(self.prepared, link, leaf) {
            return end;
        }
        meet_leaf::<K>(leaf, self.prepared, &mut self.best);
        self.best.end()
    }
}

/// The mesh of an instance.
struct Inside<'a, K> {
    instances: &'a Instances,
    ray: &'a Ray,
    best: Best,
    kernel: PhantomData<K>,
}

impl<K: Kernel> Visitor for Inside<'_, K> {
    #[inline(always)]
    fn visit(&mut self, link: u32, end: f32) -> f32 {
        let instance = &self.instances.instances[leaf_of(link)];
        let mesh = &self.instances.meshes[instance.mesh];
        let prepared = Prepared::inside(mesh, instance, self.ray, end);
        let found = closest_prepared::<K>(mesh, &prepared, end);
        self.best.offer_all(&found, instance.first_triangle);
        self.best.end()
    }
}
