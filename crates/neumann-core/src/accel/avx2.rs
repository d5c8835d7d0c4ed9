//! Both tests in vectors of eight and four, for processors with AVX2, or with AVX-512 too.
//!
//! The same operations in the same order as in [`super::portable`], so that the bits agree.
//!
//! Unsafe are the vector instructions alone; `Bvh` calls this module only where the processor has
//! them.
#![allow(unsafe_code, reason = "vector instructions")]

use std::arch::x86_64::{
    __m128, __m256, _CMP_EQ_OQ, _CMP_GT_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _CMP_NEQ_UQ, _MM_HINT_T0,
    _mm_add_ps, _mm_and_ps, _mm_andnot_ps, _mm_castsi128_ps, _mm_cmp_ps, _mm_cmpeq_epi32,
    _mm_div_ps, _mm_load_ps, _mm_load_si128, _mm_movemask_ps, _mm_mul_ps, _mm_or_ps, _mm_or_si128,
    _mm_prefetch, _mm_set1_epi32, _mm_set1_ps, _mm_setzero_ps, _mm_store_ps, _mm_sub_ps,
    _mm256_cmp_ps, _mm256_load_ps, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
    _mm256_set1_ps, _mm256_setzero_ps, _mm256_store_ps, _mm256_sub_ps,
};

use super::prepared::{FAR_PADDING, Prepared};
use super::traverse::{BoxHits, Kernel, LaneHits, decide_in_double};
use super::wide::{LEAF, LEAF_SIZE, Leaf, Node, WIDTH, WideTree, leaf_of};

pub(super) struct Avx2;

/// Room for a vector in memory.
#[repr(C, align(32))]
struct Aligned<const N: usize>([f32; N]);

/// The walks, compiled for processors that have some features.
macro_rules! compile_for {
    ($features:literal) => {
        use super::Avx2;
        use crate::accel::abreast::RayLanes;
        use crate::accel::hits::Hit;
        use crate::accel::hits::{Crossing, Occlusion, PackedHit};
        use crate::accel::instances::Instances;
        use crate::accel::traverse::{self, OcclusionLanes};
        use crate::accel::wide::WideTree;
        use crate::math::Ray;

        pub(in crate::accel) fn closest(tree: &WideTree, ray: &Ray) -> PackedHit {
            // SAFETY: `Bvh` chooses this module only where all of the features were detected.
            unsafe { closest_with_features(tree, ray) }
        }

        pub(in crate::accel) fn any(tree: &WideTree, ray: &Ray) -> Occlusion {
            // SAFETY: as above.
            unsafe { any_with_features(tree, ray) }
        }

        pub(in crate::accel) fn closest_of_lanes(
            tree: &WideTree,
            rays: &RayLanes,
            hits: &mut [Hit],
        ) -> u32 {
            // SAFETY: as above.
            unsafe { closest_of_lanes_with_features(tree, rays, hits) }
        }

        pub(in crate::accel) fn any_of_lanes(tree: &WideTree, rays: &RayLanes) -> OcclusionLanes {
            // SAFETY: as above.
            unsafe { any_of_lanes_with_features(tree, rays) }
        }

        pub(in crate::accel) fn closest_of_all(
            tree: &WideTree,
            instances: &Instances,
            ray: &Ray,
        ) -> PackedHit {
            // SAFETY: as above.
            unsafe { closest_of_all_with_features(tree, instances, ray) }
        }

        pub(in crate::accel) fn any_of_instances(instances: &Instances, ray: &Ray) -> Occlusion {
            // SAFETY: as above.
            unsafe { any_of_instances_with_features(instances, ray) }
        }

        pub(in crate::accel) fn crossings(
            tree: &WideTree,
            instances: Option<&Instances>,
            ray: &Ray,
            visit: &mut dyn FnMut(&Crossing) -> f32,
        ) {
            // SAFETY: as above.
            unsafe { crossings_with_features(tree, instances, ray, visit) }
        }

        #[target_feature(enable = $features)]
        fn closest_of_lanes_with_features(
            tree: &WideTree,
            rays: &RayLanes,
            hits: &mut [Hit],
        ) -> u32 {
            traverse::closest_of_lanes::<Avx2>(tree, rays, hits)
        }

        #[target_feature(enable = $features)]
        fn any_of_lanes_with_features(tree: &WideTree, rays: &RayLanes) -> OcclusionLanes {
            traverse::any_of_lanes::<Avx2>(tree, rays)
        }

        #[target_feature(enable = $features)]
        fn closest_of_all_with_features(
            tree: &WideTree,
            instances: &Instances,
            ray: &Ray,
        ) -> PackedHit {
            traverse::closest_of_all::<Avx2>(tree, instances, ray).into()
        }

        #[target_feature(enable = $features)]
        fn any_of_instances_with_features(instances: &Instances, ray: &Ray) -> Occlusion {
            traverse::any_of_instances::<Avx2>(instances, ray)
        }

        #[target_feature(enable = $features)]
        fn crossings_with_features(
            tree: &WideTree,
            instances: Option<&Instances>,
            ray: &Ray,
            visit: &mut dyn FnMut(&Crossing) -> f32,
        ) {
            traverse::crossings::<Avx2>(tree, instances, ray, visit);
        }

        #[target_feature(enable = $features)]
        fn closest_with_features(tree: &WideTree, ray: &Ray) -> PackedHit {
            traverse::closest::<Avx2>(tree, ray).into()
        }

        #[target_feature(enable = $features)]
        fn any_with_features(tree: &WideTree, ray: &Ray) -> Occlusion {
            traverse::any::<Avx2>(tree, ray)
        }
    };
}

/// With what came with AVX2.
pub(super) mod plain {
    compile_for!("avx2,fma,bmi1,lzcnt");
}

/// The same with AVX-512: its vectors are no longer here, but there are twice as many registers, so
/// that less of a ray has to be read from memory again and again.
pub(super) mod avx512 {
    compile_for!("avx2,fma,bmi1,lzcnt,avx512f,avx512vl,avx512bw,avx512dq");
}

/// The triangles of a leaf that a ray starts and ends on.
///
/// # Safety
/// It must be inlined into a function that has the features.
#[inline(always)]
unsafe fn at_ends(leaf: &Leaf, ray: &Prepared) -> __m128 {
    // SAFETY: the caller's; indices are four numbers at a multiple of 16 bytes.
    unsafe {
        let triangles = _mm_load_si128(leaf.triangles.as_ptr().cast());
        let [starts, ends] = ray
            .ends
            .map(|end| _mm_cmpeq_epi32(triangles, _mm_set1_epi32(end as i32)));
        _mm_castsi128_ps(_mm_or_si128(starts, ends))
    }
}

impl Kernel for Avx2 {
    #[inline(always)]
    fn meet_boxes(node: &Node, ray: &Prepared, t_max: f32) -> BoxHits {
        // SAFETY: inlined into functions that have the features; rows are eight floats at
        // multiples of 32 bytes.
        unsafe {
            let row = |i: usize| _mm256_load_ps(node.bounds[i].as_ptr());
            let mut near: __m256 = _mm256_setzero_ps();
            let mut far: __m256 = _mm256_set1_ps(f32::INFINITY);
            for axis in 0..3 {
                let origin = _mm256_set1_ps(ray.origin[axis]);
                let inverse = _mm256_set1_ps(ray.inverse[axis]);
                let first = row(ray.near[axis]);
                let last = row(ray.near[axis] ^ 1);
                near = _mm256_max_ps(_mm256_mul_ps(_mm256_sub_ps(first, origin), inverse), near);
                far = _mm256_min_ps(_mm256_mul_ps(_mm256_sub_ps(last, origin), inverse), far);
            }
            far = _mm256_min_ps(far, _mm256_set1_ps(t_max));
            far = _mm256_mul_ps(far, _mm256_set1_ps(FAR_PADDING));
            let mut distances = Aligned([0.0; WIDTH]);
            _mm256_store_ps(distances.0.as_mut_ptr(), near);
            BoxHits {
                mask: _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far)) as u32,
                near: distances.0,
            }
        }
    }

    #[inline(always)]
    fn meet_triangles(leaf: &Leaf, ray: &Prepared, t_max: f32) -> LaneHits {
        // SAFETY: as above; coordinates are four floats at multiples of 16 bytes.
        unsafe {
            let [kx, ky, kz] = ray.axes;
            let [sx, sy, sz] = ray.shear.map(|s| _mm_set1_ps(s));
            let [ox, oy, oz] = [kx, ky, kz].map(|axis| _mm_set1_ps(ray.origin[axis]));
            let sheared = |corner: usize| {
                let c = &leaf.corners[corner];
                let depth = _mm_sub_ps(_mm_load_ps(c[kz].as_ptr()), oz);
                let x = _mm_sub_ps(_mm_load_ps(c[kx].as_ptr()), ox);
                let y = _mm_sub_ps(_mm_load_ps(c[ky].as_ptr()), oy);
                [
                    _mm_sub_ps(x, _mm_mul_ps(sx, depth)),
                    _mm_sub_ps(y, _mm_mul_ps(sy, depth)),
                    depth,
                ]
            };
            let [a, b, c] = [sheared(0), sheared(1), sheared(2)];
            let edge = |p: &[__m128; 3], q: &[__m128; 3]| {
                _mm_sub_ps(_mm_mul_ps(p[0], q[1]), _mm_mul_ps(p[1], q[0]))
            };
            let mut u = edge(&c, &b);
            let mut v = edge(&a, &c);
            let mut w = edge(&b, &a);
            let zero = _mm_setzero_ps();
            let is_zero = |x| _mm_cmp_ps::<_CMP_EQ_OQ>(x, zero);
            let on_edge = _mm_or_ps(_mm_or_ps(is_zero(u), is_zero(v)), is_zero(w));
            if _mm_movemask_ps(on_edge) != 0 {
                let stored = |x: __m128| {
                    let mut lanes = Aligned([0.0; LEAF_SIZE]);
                    _mm_store_ps(lanes.0.as_mut_ptr(), x);
                    lanes
                };
                let xs = [a[0], b[0], c[0]].map(|x| stored(x).0);
                let ys = [a[1], b[1], c[1]].map(|y| stored(y).0);
                let [mut us, mut vs, mut ws] = [u, v, w].map(stored);
                decide_in_double(&xs, &ys, &mut us.0, &mut vs.0, &mut ws.0);
                [u, v, w] = [us, vs, ws].map(|lanes| _mm_load_ps(lanes.0.as_ptr()));
            }
            let is_negative = |x| _mm_cmp_ps::<_CMP_LT_OQ>(x, zero);
            let is_positive = |x| _mm_cmp_ps::<_CMP_GT_OQ>(x, zero);
            let some_negative =
                _mm_or_ps(_mm_or_ps(is_negative(u), is_negative(v)), is_negative(w));
            let some_positive =
                _mm_or_ps(_mm_or_ps(is_positive(u), is_positive(v)), is_positive(w));
            let determinant = _mm_add_ps(_mm_add_ps(u, v), w);
            let is_inside = _mm_andnot_ps(
                _mm_and_ps(some_negative, some_positive),
                _mm_cmp_ps::<_CMP_NEQ_UQ>(determinant, zero),
            );
            if _mm_movemask_ps(is_inside) == 0 {
                return LaneHits::NONE;
            }
            // Many rays start on one of the triangles that are left.
            let is_inside = _mm_andnot_ps(at_ends(leaf, ray), is_inside);
            if _mm_movemask_ps(is_inside) == 0 {
                return LaneHits::NONE;
            }
            let inverse = _mm_div_ps(_mm_set1_ps(1.0), determinant);
            let scaled = _mm_add_ps(
                _mm_add_ps(_mm_mul_ps(u, a[2]), _mm_mul_ps(v, b[2])),
                _mm_mul_ps(w, c[2]),
            );
            let t = _mm_mul_ps(_mm_mul_ps(sz, scaled), inverse);
            let slack = _mm_set1_ps(ray.most_slack);
            let is_between = _mm_and_ps(
                _mm_cmp_ps::<_CMP_GT_OQ>(_mm_add_ps(t, slack), zero),
                _mm_cmp_ps::<_CMP_LT_OQ>(_mm_sub_ps(t, slack), _mm_set1_ps(t_max)),
            );
            let mut hits = LaneHits::NONE;
            hits.mask = _mm_movemask_ps(_mm_and_ps(is_inside, is_between)) as u32;
            if hits.mask != 0 {
                let stored = |x: __m128| {
                    let mut lanes = Aligned([0.0; LEAF_SIZE]);
                    _mm_store_ps(lanes.0.as_mut_ptr(), x);
                    lanes.0
                };
                hits.t = stored(t);
                hits.v = stored(_mm_mul_ps(v, inverse));
                hits.w = stored(_mm_mul_ps(w, inverse));
            }
            hits
        }
    }

    #[inline(always)]
    fn is_at_end(leaf: &Leaf, ray: &Prepared) -> bool {
        // SAFETY: as above.
        unsafe { _mm_movemask_ps(at_ends(leaf, ray)) != 0 }
    }

    #[inline(always)]
    fn prefetch(tree: &WideTree, child: u32) {
        if !tree.is_far {
            return;
        }
        // SAFETY: prefetching has no effect but on speed, whatever the address.
        unsafe {
            let start = if child & LEAF == 0 {
                tree.nodes
                    .as_ptr()
                    .wrapping_add(child as usize)
                    .cast::<i8>()
            } else {
                let leaf = leaf_of(child);
                tree.leaves.as_ptr().wrapping_add(leaf).cast::<i8>()
            };
            _mm_prefetch::<_MM_HINT_T0>(start);
            _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(64));
            _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(128));
            _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(192));
        }
    }
}
