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
//! be wrong: a share of the
//! triangle's depth, seen from the origin, and of the origin's coordinates. Where a hit may lie
//! before the start, behind the end
//! or on the other side of another hit, the answer says that it is not sure, and double precision
//! decides
//! (`transport::crossings`). The triangle that a ray starts on, and the one that it ends on, are
//! not met.

use std::marker::PhantomData;
use std::mem::MaybeUninit;

use glam::Vec4;

use super::Hit;
use super::abreast::{BoxHitLanes, PreparedLanes, RayLanes};
use super::bvh::{Best, Crossing, Sight};
use super::instances::{Instance, Instances};
use super::wide::{LEAF, LEAF_SIZE, Leaf, Node, STACK_SIZE, WIDTH, WideTree};
use crate::math::Ray;
use crate::math::lanes::lanes_of;

/// Room for the rounding of three operations on either side of a box. What a ray has met is moved out as well: a triangle in a box
/// right behind may be as near, and count.
pub(super) const FAR_PADDING: f32 = 1.0 + 8.0 * f32::EPSILON;

/// Slack of a distance, relative to how far away the corners of the triangle are along the axis
/// that the ray runs along most: what
/// the test rounds, with room for triangles fifty times as long as they are wide, or seen as small.
pub(super) const DEPTH_SLACK: f32 = 1.0 / 16_384.0;
/// Slack relative to the coordinates of the origin: what an origin on a surface may be off it, and
/// surfaces in one plane off each
/// other.
const ORIGIN_SLACK: f32 = 1.0 / 1_048_576.0;

/// A ray prepared for both tests.
pub(super) struct Prepared {
    pub(super) origin: [f32; 3],
    pub(super) inverse: [f32; 3],
    /// For each axis, the row of a node's bounds that the ray meets first; the next or the one before is met last.
    pub(super) near: [usize; 3],
    /// Axes of the sheared frame; the ray runs along the last.
    pub(super) axes: [usize; 3],
    pub(super) shear: [f32; 3],
    /// Slack of all distances,
    pub(super) slack: f32,
    /// and more for every metre that corners are away along the last axis.
    pub(super) slack_of_depth: f32,
    /// The triangles that it starts and ends on.
    pub(super) ends: [u32; 2],
}

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
    /// Distances of those that are hit, and barycentric coordinates of their second and third corner.
    pub(super) t: [f32; LEAF_SIZE],
    pub(super) v: [f32; LEAF_SIZE],
    pub(super) w: [f32; LEAF_SIZE],
    pub(super) slack: [f32; LEAF_SIZE],
}

impl LaneHits {
    pub(super) const NONE: Self = Self {
        mask: 0,
        t: [0.0; LEAF_SIZE],
        v: [0.0; LEAF_SIZE],
        w: [0.0; LEAF_SIZE],
        slack: [0.0; LEAF_SIZE],
    };
}

/// Both tests, for all children of a node and all triangles of a leaf at once. All kernels yield the same bits.
pub(super) trait Kernel {
    /// The children whose boxes the ray meets before `t_max`.
    fn meet_boxes(node: &Node, ray: &Prepared, t_max: f32) -> BoxHits;
    /// Hits that may be behind the origin and before `t_max`, slack taken into account, but for
    /// those of the triangles that the ray starts
    /// and ends on.
    fn meet_triangles(leaf: &Leaf, ray: &Prepared, t_max: f32) -> LaneHits;
    /// Asks for the memory of a node or leaf that will be visited, if the tree is far.
    fn prefetch(tree: &WideTree, child: u32);
}

/// What is done at the leaves of a tree. Not a closure, since those cannot be made to be inlined, and vector
/// instructions must be.
trait Visitor {
    /// Looks into a leaf that the ray meets before `end`, and yields where the ray ends now.
    fn visit(&mut self, leaf: usize, end: f32) -> f32;
}

/// The same where any hit will do.
trait AnyVisitor {
    /// True if the ray is stopped in the leaf.
    fn stops(&mut self, leaf: usize) -> bool;
}

/// Walks the nodes whose boxes the ray meets before `end`, nearest first.
#[inline(always)]
fn walk<K: Kernel>(tree: &WideTree, prepared: &Prepared, end: f32, visitor: &mut impl Visitor) {
    let root = K::meet_boxes(&tree.nodes[0], prepared, end);
    walk_below_root::<K>(tree, prepared, end, root, visitor);
}

/// The same where it is known already which children of the root are met.
#[inline(always)]
fn walk_below_root<K: Kernel>(
    tree: &WideTree,
    prepared: &Prepared,
    mut end: f32,
    root: BoxHits,
    visitor: &mut impl Visitor,
) {
    let (mut stack, mut top) = (Stack::new(), 0);
    let mut node = &tree.nodes[0];
    let BoxHits { mut mask, mut near } = root;
    loop {
        let mut current = LEAF;
        let is_met = mask != 0;
        if is_met {
            let next = |mask: &mut u32| {
                let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
                *mask &= *mask - 1;
                let child = node.children[lane];
                K::prefetch(tree, child);
                u64::from(near[lane].to_bits()) << 32 | u64::from(child)
            };
            // The nearest child is next; the others wait, the farthest at the bottom.
            let mut nearest = next(&mut mask);
            let bottom = top;
            while mask != 0 {
                let other = next(&mut mask);
                stack.insert_descending(bottom, top, other.max(nearest));
                top += 1;
                nearest = other.min(nearest);
            }
            current = nearest as u32;
        }
        // Leaves on the way to the next node.
        let mut is_next = is_met;
        while !is_next || current & LEAF != 0 {
            if is_next {
                end = visitor.visit((current & !LEAF) as usize, end);
            }
            if top == 0 {
                return;
            }
            top -= 1;
            let entry = stack.get(top);
            current = entry as u32;
            is_next = f32::from_bits((entry >> 32) as u32) <= end * FAR_PADDING;
        }
        node = &tree.nodes[current as usize];
        BoxHits { mask, near } = K::meet_boxes(node, prepared, end);
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
            if visitor.stops((current & !LEAF) as usize) {
                return true;
            }
        };
        node = &tree.nodes[current as usize];
        mask = K::meet_boxes(node, prepared, end).mask;
    }
}

/// The first triangles that rays meet, or what stands for none; lanes without a ray are left alone.
/// One bit is set for each lane
/// that is not sure.
#[inline(always)]
pub(super) fn closest_of_lanes<K: Kernel>(
    tree: &WideTree,
    rays: &RayLanes,
    hits: &mut [Hit],
) -> u32 {
    let mut unsure = 0;
    let prepared = PreparedLanes::new(rays);
    let root = BoxHitLanes::new(&tree.nodes[0], rays, &prepared);
    for lane in lanes_of(rays.mask()) {
        let (prepared, end) = (prepared.get(lane), rays.end(lane));
        let mut triangles = Triangles::<K> {
            tree,
            prepared: &prepared,
            best: Best::none_before(end),
            kernel: PhantomData,
        };
        walk_below_root::<K>(tree, &prepared, end, root.get(lane), &mut triangles);
        hits[lane] = triangles.best.hit;
        unsure |= u32::from(!triangles.best.is_sure()) << lane;
    }
    unsure
}

/// Whether the ray of each lane meets any triangle before its end.
#[inline(always)]
pub(super) fn any_of_lanes<K: Kernel>(tree: &WideTree, rays: &RayLanes) -> SightLanes {
    let prepared = PreparedLanes::new(rays);
    let root = BoxHitLanes::new(&tree.nodes[0], rays, &prepared);
    let mut lanes = SightLanes::default();
    for lane in lanes_of(rays.mask()) {
        let (prepared, end) = (prepared.get(lane), rays.end(lane));
        let mut triangles = AnyTriangle::<K> {
            tree,
            prepared: &prepared,
            end,
            is_sure: true,
            kernel: PhantomData,
        };
        let root = root.get(lane).mask;
        let is_stopped = walk_below_root_until::<K>(tree, &prepared, end, root, &mut triangles);
        lanes.stopped |= u32::from(is_stopped) << lane;
        lanes.unsure |= u32::from(!is_stopped & !triangles.is_sure) << lane;
    }
    lanes
}

/// [`Sight`] in each lane: one bit for each that is stopped, or not sure.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SightLanes {
    pub(crate) stopped: u32,
    pub(crate) unsure: u32,
}

/// Puts the first triangle of a leaf that the ray meets into `best`, if it is before that.
#[inline(always)]
pub(super) fn meet_leaf<K: Kernel>(leaf: &Leaf, prepared: &Prepared, best: &mut Best) {
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
        best.offer(hit, lanes.slack[lane]);
    }
}

/// Whether any triangle of a leaf is in the way of a ray before its end.
#[inline(always)]
pub(super) fn look_into_leaf<K: Kernel>(leaf: &Leaf, prepared: &Prepared, end: f32) -> Sight {
    let lanes = K::meet_triangles(leaf, prepared, end);
    let is_between = |lane: usize| {
        let (t, slack) = (lanes.t[lane], lanes.slack[lane]);
        lanes.mask >> lane & 1 != 0 && t - slack > 0.0 && t + slack < end
    };
    let is_stopped = lanes.mask != 0 && (0..LEAF_SIZE).any(is_between);
    Sight::new(is_stopped, lanes.mask == 0)
}

/// The first triangle that the ray meets, or what stands for none.
#[inline(always)]
pub(super) fn closest<K: Kernel>(tree: &WideTree, ray: &Ray) -> Best {
    closest_prepared::<K>(tree, &Prepared::new(ray), ray.t_max())
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

/// Whether the ray meets any triangle before its end.
#[inline(always)]
pub(super) fn any<K: Kernel>(tree: &WideTree, ray: &Ray) -> Sight {
    any_prepared::<K>(tree, &Prepared::new(ray), ray.t_max())
}

#[inline(always)]
fn any_prepared<K: Kernel>(tree: &WideTree, prepared: &Prepared, end: f32) -> Sight {
    let mut triangles = AnyTriangle::<K> {
        tree,
        prepared,
        end,
        is_sure: true,
        kernel: PhantomData,
    };
    let is_stopped = walk_until::<K>(tree, prepared, end, &mut triangles);
    Sight::new(is_stopped, triangles.is_sure)
}

/// The first triangle that the ray meets, of those in the world and of those of instances.
#[inline(always)]
pub(super) fn closest_of_all<K: Kernel>(tree: &WideTree, instances: &Instances, ray: &Ray) -> Best {
    let prepared = Prepared::new(ray);
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

/// Whether the ray meets any triangle of an instance before its end.
#[inline(always)]
pub(super) fn any_of_instances<K: Kernel>(instances: &Instances, ray: &Ray) -> Sight {
    let mut inside = AnyInside::<K> {
        instances,
        ray,
        is_sure: true,
        kernel: PhantomData,
    };
    let (prepared, end) = (Prepared::new(ray), ray.t_max());
    let is_stopped = walk_until::<K>(&instances.tree, &prepared, end, &mut inside);
    Sight::new(is_stopped, inside.is_sure)
}

/// Hands all hits to `visit`, in any order, which says where the ray ends from then on.
#[inline(always)]
pub(super) fn crossings<K: Kernel>(
    tree: &WideTree,
    instances: Option<&Instances>,
    ray: &Ray,
    visit: &mut dyn FnMut(&Crossing) -> f32,
) {
    let prepared = Prepared::new(ray);
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

/// The triangles of a leaf.
struct Triangles<'a, K> {
    tree: &'a WideTree,
    prepared: &'a Prepared,
    best: Best,
    kernel: PhantomData<K>,
}

impl<K: Kernel> Visitor for Triangles<'_, K> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize, _end: f32) -> f32 {
        meet_leaf::<K>(&self.tree.leaves[leaf], self.prepared, &mut self.best);
        self.best.end()
    }
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
    fn stops(&mut self, leaf: usize) -> bool {
        let sight = look_into_leaf::<K>(&self.tree.leaves[leaf], self.prepared, self.end);
        self.is_sure &= sight != Sight::Unsure;
        sight == Sight::Stopped
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
    fn visit(&mut self, leaf: usize, _end: f32) -> f32 {
        let leaf = &self.tree.leaves[leaf];
        let lanes = K::meet_triangles(leaf, self.prepared, self.end);
        for lane in 0..LEAF_SIZE {
            // Unused lanes repeat the first triangle.
            let is_repeated = lane > 0 && leaf.triangles[lane] == leaf.triangles[0];
            if lanes.mask >> lane & 1 == 0 || is_repeated {
                continue;
            }
            let crossing = Crossing {
                hit: Hit {
                    t: lanes.t[lane],
                    triangle: leaf.triangles[lane] + self.first_triangle,
                    barycentrics: [lanes.v[lane], lanes.w[lane]],
                },
                slack: lanes.slack[lane],
            };
            self.end = self.end.min((self.visit)(&crossing));
        }
        self.end
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
    fn visit(&mut self, leaf: usize, end: f32) -> f32 {
        let instance = &self.instances.instances[leaf];
        let prepared = Prepared::inside(instance, self.ray, end);
        let mesh = &self.instances.meshes[instance.mesh];
        let found = closest_prepared::<K>(mesh, &prepared, end);
        self.best.offer_all(&found, instance.first_triangle);
        self.best.end()
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
    fn stops(&mut self, leaf: usize) -> bool {
        let instance = &self.instances.instances[leaf];
        let end = self.ray.t_max();
        let prepared = Prepared::inside(instance, self.ray, end);
        let sight = any_prepared::<K>(&self.instances.meshes[instance.mesh], &prepared, end);
        self.is_sure &= sight != Sight::Unsure;
        sight == Sight::Stopped
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
    fn visit(&mut self, leaf: usize, end: f32) -> f32 {
        let instance = &self.instances.instances[leaf];
        let prepared = Prepared::inside(instance, self.ray, end);
        let mesh = &self.instances.meshes[instance.mesh];
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

impl Prepared {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        let reach = ray.origin().abs().max_element();
        Self::reaching(ray, reach)
    }

    /// The ray in the space of an instance's mesh, before `end`.
    #[inline(always)]
    fn inside(instance: &Instance, ray: &Ray, end: f32) -> Self {
        Self::reaching(&instance.ray_inside(ray, end), instance.reach(ray))
    }

    /// A ray of which the origin is rounded as coordinates of the size `reach` are.
    #[inline(always)]
    fn reaching(ray: &Ray, reach: f32) -> Self {
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
            ends: [ray.leaves(), ray.aims_at()],
        }
    }
}

/// [`Prepared::slack`] from the largest coordinate of the origin and the inverse of the direction
/// along the last axis.
#[inline(always)]
pub(super) fn slack_of_origin(reach: f32, scale: f32) -> f32 {
    reach * ORIGIN_SLACK * scale.abs()
}

/// [`Prepared::slack_of_depth`] from the inverse of the direction along the last axis.
#[inline(always)]
pub(super) fn slack_of_depth(scale: f32) -> f32 {
    DEPTH_SLACK * scale.abs()
}

/// The axes of the sheared frame, by the axis that the ray runs along most. Where it does so backwards, corners go around in the
/// other sense; that turns the signs of all edge functions and of their sum, and changes no hit.
pub(super) const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

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

/// Nodes and leaves still to visit: distance in the upper half, child in the lower. How many there are is kept apart, so
/// that it can be in a register.
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
