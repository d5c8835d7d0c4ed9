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
//!
//! Single precision cannot tell everything. So every hit has a *slack*, by which its distance may
//! be wrong: a share of the triangle's depth, seen from the origin, and of the origin's
//! coordinates. Where a hit may lie before the start, behind the end or on the other side of
//! another hit, the answer says that it is not sure, and double precision decides
//! (`transport::crossings`). The triangle that a ray starts on, and the one that it ends on, are
//! not met. Nor are the others of their leaves, where those lie side by side in one plane
//! ([`super::wide::FLAT`]): such leaves are not even looked into.
//!
//! What slack is right for one triangle takes as long to compute as half of the test. So the test
//! asks whether a hit may count by a slack that is enough for all triangles, and the right one is
//! computed for the few hits that are left.

use std::mem::MaybeUninit;

use super::prepared::{FAR_PADDING, Prepared};
use super::wide::{FLAT, LEAF, LEAF_SIZE, Leaf, Node, STACK_SIZE, WIDTH, WideTree};

mod all;
mod any;
mod closest;

pub(super) use all::crossings;
#[cfg(target_arch = "x86_64")]
pub(super) use any::look_into_leaf;
pub(super) use any::{OcclusionLanes, any, any_of_instances, any_of_lanes};
#[cfg(target_arch = "x86_64")]
pub(super) use closest::meet_leaf;
pub(super) use closest::{closest, closest_of_all, closest_of_lanes};

/// Which children of a node are met.
pub(super) struct BoxHits {
    /// One bit for each child.
    pub(super) mask: u32,
    /// Distances of those that are met.
    pub(super) near: [f32; WIDTH],
}

/// Which triangles of a leaf are hit.
pub(super) struct LaneHits {
    /// One bit for each triangle.
    pub(super) mask: u32,
    /// Distances of those that are hit, and barycentric coordinates of their second and third
    /// corner.
    pub(super) t: [f32; LEAF_SIZE],
    pub(super) v: [f32; LEAF_SIZE],
    pub(super) w: [f32; LEAF_SIZE],
}

impl LaneHits {
    pub(super) const NONE: Self = Self {
        mask: 0,
        t: [0.0; LEAF_SIZE],
        v: [0.0; LEAF_SIZE],
        w: [0.0; LEAF_SIZE],
    };
}

/// Both tests, for all children of a node and all triangles of a leaf at once. All kernels yield
/// the same bits.
pub(super) trait Kernel {
    /// The children whose boxes the ray meets before `t_max`.
    fn meet_boxes(node: &Node, ray: &Prepared, t_max: f32) -> BoxHits;
    /// Hits that may be behind the origin and before `t_max`, given the most slack that any has,
    /// but for those of the triangles that the ray starts and ends on.
    fn meet_triangles(leaf: &Leaf, ray: &Prepared, t_max: f32) -> LaneHits;
    /// True if the ray starts or ends on a triangle of the leaf.
    fn is_at_end(leaf: &Leaf, ray: &Prepared) -> bool;
    /// Asks for the memory of a node or leaf that will be visited, if the tree is far.
    fn prefetch(tree: &WideTree, child: u32);
}

/// What is done at the leaves of a tree. Not a closure, since those cannot be made to be inlined,
/// and vector instructions must be.
trait Visitor {
    /// Looks into a leaf that the ray meets before `end`, given the link to it, and yields where
    /// the ray ends now.
    fn visit(&mut self, leaf: u32, end: f32) -> f32;
}

/// The same where any hit will do.
trait AnyVisitor {
    /// True if the ray is stopped in the leaf that a link leads to.
    fn stops(&mut self, leaf: u32) -> bool;
}

/// True if the ray meets nothing in a leaf that a link leads to, since it starts or ends on one of
/// the triangles, which lie in one plane.
#[inline(always)]
fn passes<K: Kernel>(prepared: &Prepared, link: u32, leaf: &Leaf) -> bool {
    link & FLAT != 0 && K::is_at_end(leaf, prepared)
}

/// Walks the nodes whose boxes the ray meets before `end`, nearest first.
#[inline(always)]
fn walk<K: Kernel>(tree: &WideTree, prepared: &Prepared, end: f32, visitor: &mut impl Visitor) {
    let BoxHits { mask, near } = K::meet_boxes(&tree.nodes[0], prepared, end);
    walk_below_root::<K>(tree, prepared, end, mask, |child| near[child], visitor);
}

/// The same where it is known already which children of the root are met, and where.
#[inline(always)]
fn walk_below_root<K: Kernel>(
    tree: &WideTree,
    prepared: &Prepared,
    mut end: f32,
    mask: u32,
    near: impl Fn(usize) -> f32,
    visitor: &mut impl Visitor,
) {
    let mut stack = Stack::new();
    if mask == 0 {
        return;
    }
    let (mut current, mut top) = stack.push_all::<K>(0, tree, &tree.nodes[0], mask, near);
    loop {
        let is_met = if current & LEAF != 0 {
            end = visitor.visit(current, end);
            false
        } else {
            let node = &tree.nodes[current as usize];
            let BoxHits { mask, near } = K::meet_boxes(node, prepared, end);
            if mask != 0 {
                let near = |child: usize| near[child];
                (current, top) = stack.push_all::<K>(top, tree, node, mask, near);
            }
            mask != 0
        };
        // What waits is next, unless it begins behind what was met since.
        let mut is_next = is_met;
        while !is_next {
            if top == 0 {
                return;
            }
            top -= 1;
            let entry = stack.get(top);
            current = entry as u32;
            is_next = f32::from_bits((entry >> 32) as u32) <= end * FAR_PADDING;
        }
    }
}

/// Walks the nodes whose boxes the ray meets, in any order, until a leaf stops it; true if one did.
#[inline(always)]
fn walk_until<K: Kernel>(
    tree: &WideTree,
    prepared: &Prepared,
    end: f32,
    visitor: &mut impl AnyVisitor,
) -> bool {
    let root = K::meet_boxes(&tree.nodes[0], prepared, end).mask;
    walk_below_root_until::<K>(tree, prepared, end, root, visitor)
}

/// The same where it is known already which children of the root are met.
#[inline(always)]
fn walk_below_root_until<K: Kernel>(
    tree: &WideTree,
    prepared: &Prepared,
    end: f32,
    root: u32,
    visitor: &mut impl AnyVisitor,
) -> bool {
    let (mut stack, mut top) = (Stack::new(), 0);
    let mut node = &tree.nodes[0];
    let mut mask = root;
    loop {
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
            mask &= mask - 1;
            K::prefetch(tree, node.children[lane]);
            stack.set(top, u64::from(node.children[lane]));
            top += 1;
        }
        // Leaves on the way to the next node.
        let current = loop {
            if top == 0 {
                return false;
            }
            top -= 1;
            let current = stack.get(top) as u32;
            if current & LEAF == 0 {
                break current;
            }
            if visitor.stops(current) {
                return true;
            }
        };
        node = &tree.nodes[current as usize];
        mask = K::meet_boxes(node, prepared, end).mask;
    }
}

/// Where an edge is met as exactly as single precision can tell, double precision decides.
#[cold]
#[inline(never)]
pub(super) fn decide_in_double(
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

/// Nodes and leaves still to visit: distance in the upper half, child in the lower. How many there
/// are is kept apart, so that it can be in a register.
struct Stack([MaybeUninit<u64>; STACK_SIZE]);

impl Stack {
    #[inline(always)]
    fn new() -> Self {
        Self([const { MaybeUninit::uninit() }; STACK_SIZE])
    }

    #[inline(always)]
    fn set(&mut self, i: usize, entry: u64) {
        self.0[i].write(entry);
    }

    /// Adds the children of a node that are met, the farthest first. Yields the nearest, which is
    /// next and not added, and how many entries there are then.
    #[inline(always)]
    fn push_all<K: Kernel>(
        &mut self,
        bottom: usize,
        tree: &WideTree,
        node: &Node,
        mut mask: u32,
        near: impl Fn(usize) -> f32,
    ) -> (u32, usize) {
        let next = |mask: &mut u32| {
            let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
            *mask &= *mask - 1;
            let child = node.children[lane];
            K::prefetch(tree, child);
            u64::from(near(lane).to_bits()) << 32 | u64::from(child)
        };
        let mut top = bottom;
        let mut nearest = next(&mut mask);
        while mask != 0 {
            let other = next(&mut mask);
            self.insert_descending(bottom, top, other.max(nearest));
            top += 1;
            nearest = other.min(nearest);
        }
        (nearest as u32, top)
    }

    /// Inserts among the entries from `bottom` to `top`, keeping them in descending order.
    #[inline(always)]
    fn insert_descending(&mut self, bottom: usize, top: usize, entry: u64) {
        let mut i = top;
        while i > bottom && self.get(i - 1) < entry {
            self.set(i, self.get(i - 1));
            i -= 1;
        }
        self.set(i, entry);
    }

    #[inline(always)]
    // Zeroing the stack for every ray costs as much as a node.
    #[allow(unsafe_code, reason = "the stack is not initialised")]
    fn get(&self, i: usize) -> u64 {
        // SAFETY: callers read below the top, which was written.
        unsafe { self.0[i].assume_init() }
    }
}
