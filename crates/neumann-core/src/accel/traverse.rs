//! Walks a wide tree along a ray.
//!
//! The triangle test is the watertight one of Woop, Benthin and Wald 2013: corners are
//! sheared into a frame in which the ray runs along +z from the origin, and two triangles that
//! share an edge compute the same edge function for it (with products rounded alike,
//! so no fused multiply-add there), so that no ray slips between them. Boxes are met with
//! their far side moved out by the rounding error ([PBR4] 6.8.2).
//!
//! Of two triangles at the same distance the one with the lower index is hit: the answer does
//! not depend on the shape of the tree.

use std::mem::MaybeUninit;

use super::Hit;
use super::wide::{LEAF, LEAF_SIZE, Leaf, Node, WIDTH, WideTree};
use crate::math::Ray;

/// Entries that the stack has room for.
pub(super) const STACK_SIZE: usize = 256;

/// Room for the rounding of three operations on either side of a box.
const FAR_PADDING: f32 = 1.0 + 8.0 * f32::EPSILON;

/// A ray prepared for both tests.
struct Prepared {
    origin: [f32; 3],
    inverse: [f32; 3],
    /// For each axis, the row of a node's bounds that the ray meets first.
    near: [usize; 3],
    axes: [usize; 3],
    shear: [f32; 3],
}

/// What the lanes of a leaf yield.
struct LaneHits {
    t: [f32; LEAF_SIZE],
    v: [f32; LEAF_SIZE],
    w: [f32; LEAF_SIZE],
    is_hit: [bool; LEAF_SIZE],
}

/// The first triangle that the ray meets.
#[inline(always)]
pub(super) fn closest(tree: &WideTree, ray: &Ray) -> Option<Hit> {
    let prepared = Prepared::new(ray);
    let mut best = Hit {
        t: ray.t_max,
        triangle: u32::MAX,
        barycentrics: [0.0; 2],
    };
    let mut stack = Stack::new();
    let mut current = 0u32;
    loop {
        if current & LEAF == 0 {
            let (mut mask, near) = meet_boxes(&tree.nodes[current as usize], &prepared, best.t);
            if mask != 0 {
                let children = &tree.nodes[current as usize].children;
                let entry =
                    |lane: usize| u64::from(near[lane].to_bits()) << 32 | u64::from(children[lane]);
                let next = |mask: &mut u32| {
                    let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
                    *mask &= *mask - 1;
                    entry(lane)
                };
                let mut nearest = next(&mut mask);
                if mask == 0 {
                    current = nearest as u32;
                    continue;
                }
                // The nearest child is next; the others wait, the farthest at the bottom.
                let bottom = stack.len();
                while mask != 0 {
                    let mut other = next(&mut mask);
                    if other < nearest {
                        std::mem::swap(&mut other, &mut nearest);
                    }
                    stack.insert_descending(bottom, other);
                }
                current = nearest as u32;
                continue;
            }
        } else {
            let leaf = &tree.leaves[(current & !LEAF) as usize];
            let lanes = meet_triangles(leaf, &prepared, best.t);
            for lane in 0..LEAF_SIZE {
                let triangle = leaf.triangles[lane];
                let t = lanes.t[lane];
                if lanes.is_hit[lane] && (t < best.t || (t == best.t && triangle < best.triangle)) {
                    best = Hit {
                        t,
                        triangle,
                        barycentrics: [lanes.v[lane], lanes.w[lane]],
                    };
                }
            }
        }
        loop {
            let Some(entry) = stack.pop() else {
                return (best.triangle != u32::MAX).then_some(best);
            };
            if f32::from_bits((entry >> 32) as u32) <= best.t {
                current = entry as u32;
                break;
            }
        }
    }
}

/// True if the ray meets any triangle before its end.
#[inline(always)]
pub(super) fn any(tree: &WideTree, ray: &Ray) -> bool {
    let prepared = Prepared::new(ray);
    let mut stack = Stack::new();
    let mut current = 0u32;
    loop {
        if current & LEAF == 0 {
            let (mut mask, _) = meet_boxes(&tree.nodes[current as usize], &prepared, ray.t_max);
            let children = &tree.nodes[current as usize].children;
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
                mask &= mask - 1;
                stack.push(u64::from(children[lane]));
            }
        } else {
            let leaf = &tree.leaves[(current & !LEAF) as usize];
            let lanes = meet_triangles(leaf, &prepared, ray.t_max);
            for lane in 0..LEAF_SIZE {
                if lanes.is_hit[lane] && lanes.t[lane] < ray.t_max {
                    return true;
                }
            }
        }
        let Some(entry) = stack.pop() else {
            return false;
        };
        current = entry as u32;
    }
}

impl Prepared {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        let (origin, d) = (ray.origin.to_array(), ray.direction.to_array());
        // A huge but finite inverse keeps 0 · ∞ out of the slab test.
        let inverse = d.map(|c| {
            if c.abs() < 1e-18 {
                1e18f32.copysign(c)
            } else {
                1.0 / c
            }
        });
        let magnitude = d.map(f32::abs);
        let z = if magnitude[0] > magnitude[1] {
            if magnitude[0] > magnitude[2] { 0 } else { 2 }
        } else if magnitude[1] > magnitude[2] {
            1
        } else {
            2
        };
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if d[z] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        let scale = 1.0 / d[z];
        Self {
            origin,
            inverse,
            near: [0, 1, 2].map(|axis| 2 * axis + usize::from(d[axis].is_sign_negative())),
            axes: [x, y, z],
            shear: [d[x] * scale, d[y] * scale, scale],
        }
    }
}

/// A bit for each child whose box the ray meets before `t_max`, and the distances.
#[inline(always)]
fn meet_boxes(node: &Node, ray: &Prepared, t_max: f32) -> (u32, [f32; WIDTH]) {
    let mut near = [0f32; WIDTH];
    let mut far = [t_max; WIDTH];
    for axis in 0..3 {
        let (o, inverse) = (ray.origin[axis], ray.inverse[axis]);
        let first = &node.bounds[ray.near[axis]];
        let last = &node.bounds[ray.near[axis] ^ 1];
        for lane in 0..WIDTH {
            let t = (first[lane] - o) * inverse;
            near[lane] = if t > near[lane] { t } else { near[lane] };
        }
        for lane in 0..WIDTH {
            let t = (last[lane] - o) * inverse * FAR_PADDING;
            far[lane] = if t < far[lane] { t } else { far[lane] };
        }
    }
    let mut mask = 0u32;
    for lane in 0..WIDTH {
        mask |= u32::from(near[lane] <= far[lane]) << lane;
    }
    (mask, near)
}

/// Hits with `0 < t <= t_max`, lane by lane.
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
    let mut hits = LaneHits {
        t: [0.0; LEAF_SIZE],
        v: [0.0; LEAF_SIZE],
        w: [0.0; LEAF_SIZE],
        is_hit: [false; LEAF_SIZE],
    };
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
        hits.is_hit[lane] = !is_outside && determinant != 0.0 && t > 0.0 && t <= t_max;
    }
    hits
}

/// Where an edge is met as exactly as single precision can tell, double precision decides.
#[cold]
#[inline(never)]
fn decide_in_double(
    x: &[[f32; LEAF_SIZE]; 3],
    y: &[[f32; LEAF_SIZE]; 3],
    u: &mut [f32; LEAF_SIZE],
    v: &mut [f32; LEAF_SIZE],
    w: &mut [f32; LEAF_SIZE],
) {
    let d = |a: f32, b: f32, c: f32, d: f32| {
        (f64::from(a) * f64::from(b) - f64::from(c) * f64::from(d)) as f32
    };
    for lane in 0..LEAF_SIZE {
        if u[lane] != 0.0 && v[lane] != 0.0 && w[lane] != 0.0 {
            continue;
        }
        u[lane] = d(x[2][lane], y[1][lane], y[2][lane], x[1][lane]);
        v[lane] = d(x[0][lane], y[2][lane], y[0][lane], x[2][lane]);
        w[lane] = d(x[1][lane], y[0][lane], y[1][lane], x[0][lane]);
    }
}

/// Nodes and leaves still to visit: distance in the upper half, child in the lower.
struct Stack {
    entries: [MaybeUninit<u64>; STACK_SIZE],
    len: usize,
}

impl Stack {
    #[inline(always)]
    fn new() -> Self {
        Self {
            entries: [const { MaybeUninit::uninit() }; STACK_SIZE],
            len: 0,
        }
    }

    #[inline(always)]
    fn len(&self) -> usize {
        self.len
    }

    #[inline(always)]
    fn push(&mut self, entry: u64) {
        self.entries[self.len].write(entry);
        self.len += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<u64> {
        self.len = self.len.checked_sub(1)?;
        Some(self.entry(self.len))
    }

    /// Inserts above `bottom`, keeping what is there in descending order.
    #[inline(always)]
    fn insert_descending(&mut self, bottom: usize, entry: u64) {
        let mut i = self.len;
        while i > bottom && self.entry(i - 1) < entry {
            self.entries[i].write(self.entry(i - 1));
            i -= 1;
        }
        self.entries[i].write(entry);
        self.len += 1;
    }

    #[inline(always)]
    #[allow(
        unsafe_code,
        reason = "zeroing the stack for every ray costs as much as a node"
    )]
    fn entry(&self, i: usize) -> u64 {
        // SAFETY: callers read below `len` (or below the entry being inserted), which was written.
        unsafe { self.entries[i].assume_init() }
    }
}
