//! Sixteen rays together through a small tree, in vectors of sixteen, for processors with AVX-512.
//!
//! Each box and each triangle is tested against all of them at once. Few of the lanes are wanted at
//! most triangles, but hardly a branch depends on where a single ray goes, which costs a ray that
//! walks by itself more than the tests.
//!
//! The same operations in the same order as in [`super::portable`], so that the bits agree.
//!
//! Unsafe are the vector instructions alone; `Bvh` calls this module only where the processor has
//! them.
#![allow(unsafe_code, reason = "vector instructions")]

use std::arch::x86_64::{
    __m512, __m512i, __mmask16, _CMP_EQ_OQ, _CMP_GT_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _mm512_abs_ps,
    _mm512_add_epi32, _mm512_add_ps, _mm512_and_si512, _mm512_castps_si512, _mm512_cmp_ps_mask,
    _mm512_cmpeq_epi32_mask, _mm512_div_ps, _mm512_load_ps, _mm512_load_si512, _mm512_loadu_ps,
    _mm512_mask_blend_epi32, _mm512_mask_blend_ps, _mm512_mask_cmp_ps_mask,
    _mm512_mask_cmplt_epu32_mask, _mm512_max_ps, _mm512_min_ps, _mm512_movepi32_mask,
    _mm512_mul_ps, _mm512_or_si512, _mm512_permutexvar_ps, _mm512_set1_epi32, _mm512_set1_ps,
    _mm512_setzero_ps, _mm512_store_ps, _mm512_store_si512, _mm512_sub_ps, _mm512_test_epi32_mask,
};

use super::abreast::{PreparedLanes, RayLanes};
use super::avx2::Avx2;
use super::hits::{Best as BestOfOne, Hit, Occlusion};
use super::prepared::{DEPTH_SLACK, FAR_PADDING};
use super::traverse::{self, OcclusionLanes};
use super::wide::{FLAT, LEAF, LEAF_SIZE, Leaf, Node, SMALL_LEAVES, WIDTH, WideTree, leaf_of};
use crate::math::lanes::{Lanes, lanes_of};

pub(super) fn closest_of_lanes(tree: &WideTree, rays: &RayLanes, hits: &mut [Hit]) -> u32 {
    // SAFETY: `Bvh` chooses this module only where all of the features were detected.
    unsafe { closest_with_features(tree, rays, hits) }
}

pub(super) fn any_of_lanes(tree: &WideTree, rays: &RayLanes) -> OcclusionLanes {
    // SAFETY: as above.
    unsafe { any_with_features(tree, rays) }
}

#[target_feature(enable = "avx2,fma,bmi1,lzcnt,avx512f,avx512vl,avx512bw,avx512dq")]
fn closest_with_features(tree: &WideTree, rays: &RayLanes, hits: &mut [Hit]) -> u32 {
    let prepared = PreparedLanes::new(tree, rays);
    let mut packet = Packet::new(tree, rays, &prepared);
    packet.walk::<false>(tree, rays.mask() as __mmask16);
    let found = packet.best.stored();
    for lane in lanes_of(rays.mask()) {
        hits[lane] = found.get(lane);
    }
    u32::from(packet.as_near | packet.at_start) & rays.mask()
}

#[target_feature(enable = "avx2,fma,bmi1,lzcnt,avx512f,avx512vl,avx512bw,avx512dq")]
fn any_with_features(tree: &WideTree, rays: &RayLanes) -> OcclusionLanes {
    let prepared = PreparedLanes::new(tree, rays);
    let mut packet = Packet::new(tree, rays, &prepared);
    packet.walk::<true>(tree, rays.mask() as __mmask16);
    let (stopped, unsure) = (packet.stopped, packet.as_near | packet.at_start);
    OcclusionLanes {
        stopped: u32::from(stopped) & rays.mask(),
        unsure: u32::from(unsure & !stopped) & rays.mask(),
    }
}

/// Rays as both tests need them, and what they have met so far.
struct Packet<'a> {
    prepared: &'a PreparedLanes<'a>,
    origin: [__m512; 3],
    inverse: [__m512; 3],
    is_negative: [__mmask16; 3],
    /// For each axis of the sheared frame, where a leaf has the coordinates of a corner.
    rows: [__m512i; 3],
    sheared_origin: [__m512; 3],
    shear: [__m512; 3],
    /// The triangles that the rays start and end on.
    ends: [__m512i; 2],
    /// Slack of all distances: as of triangles that reach through the whole tree. Twice of it is
    /// between two that are apart for sure.
    slack: __m512,
    twice: __m512,
    best: Best,
    /// Twice the slack behind the best.
    limit: __m512,
    /// Rays of which another hit is as near as the best, or one is as near as the end, where any
    /// will do,
    as_near: __mmask16,
    /// or of which a triangle is where they start.
    at_start: __mmask16,
    /// Rays that have met something for sure, where any will do.
    stopped: __mmask16,
}

/// The nearest hits; those with the index `u32::MAX` stand for none.
#[derive(Clone, Copy)]
struct Best {
    t: __m512,
    triangle: __m512i,
    v: __m512,
    w: __m512,
}

/// [`Best`] in memory.
#[derive(Default)]
struct Found {
    t: Lanes<f32>,
    triangle: Lanes<u32>,
    v: Lanes<f32>,
    w: Lanes<f32>,
}

#[inline(always)]
fn load(lanes: &Lanes<f32>) -> __m512 {
    // SAFETY: sixteen numbers at a multiple of 64 bytes.
    unsafe { _mm512_load_ps(lanes.0.as_ptr()) }
}

#[inline(always)]
fn load_integers(lanes: &Lanes<u32>) -> __m512i {
    // SAFETY: as above.
    unsafe { _mm512_load_si512(lanes.0.as_ptr().cast()) }
}

#[inline(always)]
fn store(lanes: &mut Lanes<f32>, x: __m512) {
    // SAFETY: room for sixteen numbers at a multiple of 64 bytes.
    unsafe { _mm512_store_ps(lanes.0.as_mut_ptr(), x) }
}

#[inline(always)]
fn store_integers(lanes: &mut Lanes<u32>, x: __m512i) {
    // SAFETY: as above.
    unsafe { _mm512_store_si512(lanes.0.as_mut_ptr().cast(), x) }
}

impl<'a> Packet<'a> {
    #[target_feature(enable = "avx2,fma,bmi1,lzcnt,avx512f,avx512vl,avx512bw,avx512dq")]
    fn new(tree: &WideTree, rays: &RayLanes, prepared: &'a PreparedLanes<'a>) -> Self {
        let origin = prepared.origin.axes().map(load);
        let along = load_integers(&prepared.along);
        let [is_y, is_z] =
            [1, 2].map(|axis| _mm512_cmpeq_epi32_mask(along, _mm512_set1_epi32(axis)));
        // Of what goes with x, y and z, the one of the axis that a ray runs along.
        let pick = |of_x, of_y, of_z| {
            let of_xy = _mm512_mask_blend_ps(is_y, of_x, of_y);
            _mm512_mask_blend_ps(is_z, of_xy, of_z)
        };
        let [x, y, z] = origin;
        let row = |of_x: i32, of_y: i32, of_z: i32| {
            let at = |axis: i32| _mm512_set1_epi32(axis * LEAF_SIZE as i32);
            let of_xy = _mm512_mask_blend_epi32(is_y, at(of_x), at(of_y));
            _mm512_mask_blend_epi32(is_z, of_xy, at(of_z))
        };
        // Along each axis, how far away the farther side of everything is.
        let [low, high] = tree.bounds.map(|side| side.to_array());
        let reach = [0, 1, 2].map(|axis| {
            let to = |side: f32| _mm512_abs_ps(_mm512_sub_ps(_mm512_set1_ps(side), origin[axis]));
            _mm512_max_ps(to(low[axis]), to(high[axis]))
        });
        let depth = pick(reach[0], reach[1], reach[2]);
        let shear = prepared.shear.each_ref().map(load);
        let slack_of_depth = _mm512_mul_ps(_mm512_abs_ps(shear[2]), _mm512_set1_ps(DEPTH_SLACK));
        let slack = _mm512_add_ps(_mm512_mul_ps(depth, slack_of_depth), load(&prepared.slack));
        let twice = _mm512_add_ps(slack, slack);
        let end = load(rays.ends());
        Self {
            prepared,
            ends: rays.triangles().map(load_integers),
            slack,
            twice,
            limit: _mm512_add_ps(end, twice),
            as_near: 0,
            at_start: 0,
            stopped: 0,
            origin,
            inverse: prepared.inverse.each_ref().map(load),
            is_negative: prepared
                .is_negative
                .each_ref()
                .map(|lanes| _mm512_test_epi32_mask(load_integers(lanes), load_integers(lanes))),
            rows: [row(1, 2, 0), row(2, 0, 1), row(0, 1, 2)],
            sheared_origin: [pick(y, z, x), pick(z, x, y), pick(x, y, z)],
            shear,
            best: Best {
                t: end,
                triangle: _mm512_set1_epi32(-1),
                v: _mm512_setzero_ps(),
                w: _mm512_setzero_ps(),
            },
        }
    }

    /// Walks the tree with `lanes`, which end where they are stopped if `ANY` hit will do.
    #[target_feature(enable = "avx2,fma,bmi1,lzcnt,avx512f,avx512vl,avx512bw,avx512dq")]
    fn walk<const ANY: bool>(&mut self, tree: &WideTree, lanes: __mmask16) {
        let mut nodes = [(0, lanes); SMALL_LEAVES];
        let (mut n_met, mut n_nodes) = (0, 1);
        while n_met < n_nodes {
            let (node, lanes) = nodes[n_met];
            n_met += 1;
            let node = &tree.nodes[node as usize];
            for child in 0..WIDTH {
                let met = lanes & self.meet_box(node, child) & !self.stopped;
                let link = node.children[child];
                if met == 0 {
                    continue;
                }
                if link & LEAF != 0 {
                    let leaf = &tree.leaves[leaf_of(link)];
                    let met = met & !self.pass(link, leaf);
                    if met != 0 {
                        self.meet_leaf::<ANY>(leaf, met);
                    }
                } else {
                    nodes[n_nodes] = (link, met);
                    n_nodes += 1;
                }
            }
        }
    }

    /// Which rays meet a child of a node before their ends.
    #[target_feature(enable = "avx2,fma,bmi1,lzcnt,avx512f,avx512vl,avx512bw,avx512dq")]
    #[inline]
    fn meet_box(&self, node: &Node, child: usize) -> __mmask16 {
        let mut near = _mm512_setzero_ps();
        let mut far = _mm512_set1_ps(f32::INFINITY);
        for axis in 0..3 {
            let low = _mm512_set1_ps(node.bounds[2 * axis][child]);
            let high = _mm512_set1_ps(node.bounds[2 * axis + 1][child]);
            let first = _mm512_mask_blend_ps(self.is_negative[axis], low, high);
            let last = _mm512_mask_blend_ps(self.is_negative[axis], high, low);
            let distance =
                |side| _mm512_mul_ps(_mm512_sub_ps(side, self.origin[axis]), self.inverse[axis]);
            near = _mm512_max_ps(distance(first), near);
            far = _mm512_min_ps(distance(last), far);
        }
        far = _mm512_mul_ps(_mm512_min_ps(far, self.limit), _mm512_set1_ps(FAR_PADDING));
        _mm512_cmp_ps_mask::<_CMP_LE_OQ>(near, far)
    }

    /// Which rays meet nothing in a leaf, since they start or end on one of the triangles, which
    /// lie in one plane.
    #[target_feature(enable = "avx2,fma,bmi1,lzcnt,avx512f,avx512vl,avx512bw,avx512dq")]
    #[inline]
    fn pass(&self, link: u32, leaf: &Leaf) -> __mmask16 {
        if link & FLAT == 0 {
            return 0;
        }
        let mut pass = 0;
        for triangle in leaf.triangles {
            let index = _mm512_set1_epi32(triangle as i32);
            let [starts, ends] = self.ends.map(|end| _mm512_cmpeq_epi32_mask(end, index));
            pass |= starts | ends;
        }
        pass
    }

    /// Meets the triangles of a leaf.
    #[target_feature(enable = "avx2,fma,bmi1,lzcnt,avx512f,avx512vl,avx512bw,avx512dq")]
    fn meet_leaf<const ANY: bool>(&mut self, leaf: &Leaf, mut lanes: __mmask16) {
        let [sx, sy, sz] = self.shear;
        let [ox, oy, oz] = self.sheared_origin;
        let zero = _mm512_setzero_ps();
        // Coordinates of a corner, with what follows them in memory: four x, four y, four z.
        let start = std::ptr::from_ref(leaf).cast::<f32>();
        // SAFETY: a leaf is nine times four coordinates and four indices, of four bytes each.
        let corners = [0, 1, 2].map(|i| unsafe { _mm512_loadu_ps(start.add(3 * LEAF_SIZE * i)) });
        for (i, triangle) in leaf.triangles.into_iter().enumerate() {
            if i > 0 && triangle == leaf.triangles[0] {
                break;
            }
            let [x, y, z] = self
                .rows
                .map(|row| _mm512_add_epi32(row, _mm512_set1_epi32(i as i32)));
            let sheared = |corner| {
                let depth = _mm512_sub_ps(_mm512_permutexvar_ps(z, corner), oz);
                let x = _mm512_sub_ps(_mm512_permutexvar_ps(x, corner), ox);
                let y = _mm512_sub_ps(_mm512_permutexvar_ps(y, corner), oy);
                [
                    _mm512_sub_ps(x, _mm512_mul_ps(sx, depth)),
                    _mm512_sub_ps(y, _mm512_mul_ps(sy, depth)),
                    depth,
                ]
            };
            let [a, b, c] = [
                sheared(corners[0]),
                sheared(corners[1]),
                sheared(corners[2]),
            ];
            let edge = |p: &[__m512; 3], q: &[__m512; 3]| {
                _mm512_sub_ps(_mm512_mul_ps(p[0], q[1]), _mm512_mul_ps(p[1], q[0]))
            };
            let (u, v, w) = (edge(&c, &b), edge(&a, &c), edge(&b, &a));
            let is_zero = |x| _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(x, zero);
            let on_edge = lanes & (is_zero(u) | is_zero(v) | is_zero(w));
            if on_edge != 0 {
                // Double precision decides, ray by ray.
                self.meet_leaf_alone::<ANY>(leaf, on_edge);
                lanes &= !on_edge;
            }
            // No edge function is zero now, so that all three have the sign of one or not.
            let [u_bits, v_bits, w_bits] = [u, v, w].map(|x| _mm512_castps_si512(x));
            let or = _mm512_or_si512(_mm512_or_si512(u_bits, v_bits), w_bits);
            let and = _mm512_and_si512(_mm512_and_si512(u_bits, v_bits), w_bits);
            let inside = lanes & (!_mm512_movepi32_mask(or) | _mm512_movepi32_mask(and));
            if inside == 0 {
                continue;
            }
            let index = _mm512_set1_epi32(triangle as i32);
            let [starts, ends] = self.ends.map(|end| _mm512_cmpeq_epi32_mask(end, index));
            let inside = inside & !(starts | ends);
            let determinant = _mm512_add_ps(_mm512_add_ps(u, v), w);
            let inverse = _mm512_div_ps(_mm512_set1_ps(1.0), determinant);
            let scaled = _mm512_add_ps(
                _mm512_add_ps(_mm512_mul_ps(u, a[2]), _mm512_mul_ps(v, b[2])),
                _mm512_mul_ps(w, c[2]),
            );
            let t = _mm512_mul_ps(_mm512_mul_ps(sz, scaled), inverse);
            let (low, high) = (_mm512_sub_ps(t, self.slack), _mm512_add_ps(t, self.slack));
            let clear = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(inside, low, zero);
            let near = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(inside, high, zero)
                & _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, self.limit);
            let best = self.best;
            if ANY {
                let between = _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(clear, high, best.t);
                self.stopped |= between;
                self.as_near |= near & !between;
                continue;
            }
            self.at_start |= near & !clear;
            let ahead = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(near, t, zero);
            let nearer = _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(ahead, t, best.t);
            let equal = _mm512_mask_cmp_ps_mask::<_CMP_EQ_OQ>(ahead, t, best.t);
            let is_hit = nearer | _mm512_mask_cmplt_epu32_mask(equal, index, best.triangle);
            let apart = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(_mm512_add_ps(t, self.twice), best.t);
            self.as_near = (self.as_near & !is_hit) | (ahead & !apart);
            self.best = Best {
                t: _mm512_mask_blend_ps(is_hit, best.t, t),
                triangle: _mm512_mask_blend_epi32(is_hit, best.triangle, index),
                v: _mm512_mask_blend_ps(is_hit, best.v, _mm512_mul_ps(v, inverse)),
                w: _mm512_mask_blend_ps(is_hit, best.w, _mm512_mul_ps(w, inverse)),
            };
            self.limit = _mm512_add_ps(self.best.t, self.twice);
        }
    }

    /// The same, ray by ray.
    #[target_feature(enable = "avx2,fma,bmi1,lzcnt,avx512f,avx512vl,avx512bw,avx512dq")]
    #[cold]
    #[inline(never)]
    fn meet_leaf_alone<const ANY: bool>(&mut self, leaf: &Leaf, lanes: __mmask16) {
        let mut found = self.best.stored();
        let mut slack = Lanes::default();
        store(&mut slack, self.slack);
        for lane in lanes_of(u32::from(lanes)) {
            let prepared = self.prepared.get(lane);
            let hit = found.get(lane);
            if ANY {
                match traverse::look_into_leaf::<Avx2>(leaf, &prepared, hit.t) {
                    Occlusion::Clear => (),
                    Occlusion::Stopped => self.stopped |= 1 << lane,
                    Occlusion::Unsure => self.as_near |= 1 << lane,
                }
                continue;
            }
            let is_alone = self.as_near >> lane & 1 == 0;
            let mut best = BestOfOne::found(hit, slack.get(lane), is_alone);
            traverse::meet_leaf::<Avx2>(leaf, &prepared, &mut best);
            found.set(lane, &best.hit);
            self.as_near = self.as_near & !(1 << lane) | u16::from(!best.is_alone()) << lane;
            self.at_start |= u16::from(!best.is_start_clear()) << lane;
        }
        self.best = Best {
            t: load(&found.t),
            triangle: load_integers(&found.triangle),
            v: load(&found.v),
            w: load(&found.w),
        };
        self.limit = _mm512_add_ps(self.best.t, self.twice);
    }
}

impl Best {
    #[target_feature(enable = "avx512f")]
    #[inline]
    fn stored(&self) -> Found {
        let mut found = Found::default();
        store(&mut found.t, self.t);
        store_integers(&mut found.triangle, self.triangle);
        store(&mut found.v, self.v);
        store(&mut found.w, self.w);
        found
    }
}

impl Found {
    #[inline(always)]
    fn get(&self, lane: usize) -> Hit {
        Hit {
            t: self.t.get(lane),
            triangle: self.triangle.get(lane),
            barycentrics: [self.v.get(lane), self.w.get(lane)],
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, hit: &Hit) {
        self.t.set(lane, hit.t);
        self.triangle.set(lane, hit.triangle);
        self.v.set(lane, hit.barycentrics[0]);
        self.w.set(lane, hit.barycentrics[1]);
    }
}
