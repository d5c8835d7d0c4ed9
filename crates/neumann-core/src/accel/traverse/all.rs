//! All hits of a ray.

use std::marker::PhantomData;

use super::{Kernel, Visitor, passes, walk};
use crate::accel::hits::Crossing;
use crate::accel::hits::Hit;
use crate::accel::instances::Instances;
use crate::accel::prepared::Prepared;
use crate::accel::wide::{LEAF_SIZE, WideTree, leaf_of};
use crate::math::Ray;

/// Hands all hits to `visit`, in any order, which says where the ray ends from then on.
#[inline(always)]
pub(in crate::accel) fn crossings<K: Kernel>(
    tree: &WideTree,
    instances: Option<&Instances>,
    ray: &Ray,
    visit: &mut dyn FnMut(&Crossing) -> f32,
) {
    let prepared = Prepared::new(tree, ray);
    let mut end = ray.t_max();
    if !tree.nodes.is_empty() {
        let mut all = AllTriangles::<K> {
            tree,
            prepared: &prepared,
            first_triangle: 0,
            end,
            visit: &mut *visit,
            kernel: PhantomData,
        };
        walk::<K>(tree, &prepared, end, &mut all);
        end = all.end;
    }
    if let Some(instances) = instances {
        let mut all = AllInside::<K> {
            instances,
            ray,
            visit,
            kernel: PhantomData,
        };
        walk::<K>(&instances.tree, &prepared, end, &mut all);
    }
}

/// The same where all are wanted.
struct AllTriangles<'a, K> {
    tree: &'a WideTree,
    prepared: &'a Prepared,
    first_triangle: u32,
    end: f32,
    visit: &'a mut dyn FnMut(&Crossing) -> f32,
    kernel: PhantomData<K>,
}

impl<K: Kernel> Visitor for AllTriangles<'_, K> {
    #[inline(always)]
    fn visit(&mut self, link: u32, _end: f32) -> f32 {
        let leaf = &self.tree.leaves[leaf_of(link)];
        if passes::<K>(self.prepared, link, leaf) {
            return self.end;
        }
        let lanes = K::meet_triangles(leaf, self.prepared, self.end);
        for lane in 0..LEAF_SIZE {
            // Unused lanes repeat the first triangle.
            let is_repeated = lane > 0 && leaf.triangles[lane] == leaf.triangles[0];
            if lanes.mask >> lane & 1 == 0 || is_repeated {
                continue;
            }
            let (t, slack) = (lanes.t[lane], self.prepared.slack_in(leaf, lane));
            if t + slack <= 0.0 || t - slack >= self.end {
                continue;
            }
            let crossing = Crossing {
                hit: Hit {
                    t,
                    triangle: leaf.triangles[lane] + self.first_triangle,
                    barycentrics: [lanes.v[lane], lanes.w[lane]],
                },
                slack,
            };
            self.end = self.end.min((self.visit)(&crossing));
        }
        self.end
    }
}

/// The same where all are wanted.
struct AllInside<'a, K> {
    instances: &'a Instances,
    ray: &'a Ray,
    visit: &'a mut dyn FnMut(&Crossing) -> f32,
    kernel: PhantomData<K>,
}

impl<K: Kernel> Visitor for AllInside<'_, K> {
    #[inline(always)]
    fn visit(&mut self, link: u32, end: f32) -> f32 {
        let instance = &self.instances.instances[leaf_of(link)];
        let mesh = &self.instances.meshes[instance.mesh];
        let prepared = Prepared::inside(mesh, instance, self.ray, end);
        let mut all = AllTriangles::<K> {
            tree: mesh,
            prepared: &prepared,
            first_triangle: instance.first_triangle,
            end,
            visit: &mut *self.visit,
            kernel: PhantomData,
        };
        walk::<K>(mesh, &prepared, end, &mut all);
        all.end
    }
}
