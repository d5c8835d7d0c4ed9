//! A bounding volume hierarchy over triangles.

use glam::Vec3;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::triangle::Triangle;
use rayon::prelude::*;

use super::abreast::{HitLanes, RayLanes};
use super::instances::{Instances, Placement};
use super::portable;
use super::wide::WideTree;
#[cfg(target_arch = "x86_64")]
use super::{avx2, avx512};
use crate::math::Ray;
use crate::math::lanes::{LANES, lanes_of};

/// A tree over triangles, and over instances of meshes.
pub struct Bvh {
    tree: WideTree,
    instances: Option<Box<Instances>>,
    kernel: Kernel,
    quality: TreeQuality,
}

/// Preparing sixteen rays in vectors takes as long as preparing about so many one by one.
const FEWEST_ABREAST: u32 = 6;
/// Taking sixteen rays through a small tree together takes as long as about so many that walk it one by one.
#[cfg(target_arch = "x86_64")]
const FEWEST_TOGETHER: u32 = 9;

/// How much work goes into a tree. What a ray meets is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeQuality {
    /// Soon there: neighbours on a space-filling curve are merged as they come.
    Quick,
    /// Soon walked: the best merge among many, and nodes put back where they cost least.
    Full,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance along the ray, metres.
    pub t: f32,
    /// Index of the triangle.
    pub triangle: u32,
    /// Barycentric coordinates of the second and third corner.
    pub barycentrics: [f32; 2],
}

/// A hit as a kernel hands it back: in two registers. By way of memory, the first read of it would have to wait for the
/// pieces that were written.
#[derive(Clone, Copy)]
pub(super) struct PackedHit(u64, u64);

impl From<Hit> for PackedHit {
    #[inline(always)]
    fn from(hit: Hit) -> Self {
        let pair = |a: u32, b: u32| u64::from(a) << 32 | u64::from(b);
        let [u, v] = hit.barycentrics;
        Self(
            pair(hit.t.to_bits(), hit.triangle),
            pair(u.to_bits(), v.to_bits()),
        )
    }
}

impl From<PackedHit> for Hit {
    #[inline(always)]
    fn from(PackedHit(a, b): PackedHit) -> Self {
        let upper = |x: u64| f32::from_bits((x >> 32) as u32);
        Self {
            t: upper(a),
            triangle: a as u32,
            barycentrics: [upper(b), f32::from_bits(b as u32)],
        }
    }
}

/// Which compilation of the traversal runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kernel {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl std::fmt::Debug for Bvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Bvh({} bytes)", self.n_bytes())
    }
}

impl Bvh {
    /// The best tree over triangles with finite corners.
    #[must_use]
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        Self::with_instances(triangles, &[], &[], TreeQuality::Full)
    }

    /// A tree over triangles that stand in the world themselves, whose indices come first, and over meshes
    /// (`meshes[mesh][triangle]`, in their own space) that stand there as placed.
    #[must_use]
    pub fn with_instances(
        triangles: &[[Vec3; 3]],
        meshes: &[Vec<[Vec3; 3]>],
        placements: &[Placement],
        quality: TreeQuality,
    ) -> Self {
        Self {
            tree: tree_of_triangles(triangles, quality),
            instances: (!placements.is_empty())
                .then(|| Box::new(Instances::new(meshes, placements, quality))),
            kernel: Kernel::best(),
            quality,
        }
    }

    /// How much work went into it.
    #[must_use]
    pub fn quality(&self) -> TreeQuality {
        self.quality
    }

    /// What the ray meets first, if anything.
    #[inline]
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = PackedHit::from(Hit::none_before(ray.t_max()));
        if !self.tree.nodes.is_empty() {
            hit = match self.kernel {
                Kernel::Portable => portable::closest(&self.tree, ray),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx2 => avx2::plain::closest(&self.tree, ray),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx512 => avx2::avx512::closest(&self.tree, ray),
            };
        }
        if let Some(instances) = &self.instances {
            hit = match self.kernel {
                Kernel::Portable => portable::closest_of_instances(instances, ray, hit),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx2 => avx2::plain::closest_of_instances(instances, ray, hit),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx512 => avx2::avx512::closest_of_instances(instances, ray, hit),
            };
        }
        let hit = Hit::from(hit);
        hit.is_there().then_some(hit)
    }

    /// True if anything is in the way of the ray before its end.
    #[inline]
    #[must_use]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        let is_occluded = !self.tree.nodes.is_empty()
            && match self.kernel {
                Kernel::Portable => portable::any(&self.tree, ray),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx2 => avx2::plain::any(&self.tree, ray),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx512 => avx2::avx512::any(&self.tree, ray),
            };
        match &self.instances {
            None => is_occluded,
            Some(_) if is_occluded => true,
            Some(instances) => match self.kernel {
                Kernel::Portable => portable::any_of_instances(instances, ray),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx2 => avx2::plain::any_of_instances(instances, ray),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx512 => avx2::avx512::any_of_instances(instances, ray),
            },
        }
    }

    /// What the rays meet first, if anything.
    pub(crate) fn closest_hits(&self, rays: &RayLanes) -> HitLanes {
        let mut found = [None; LANES];
        if !self.begins_abreast(rays) {
            for lane in lanes_of(rays.mask()) {
                found[lane] = self.closest_hit(&rays.get(lane));
            }
            return found;
        }
        let mut hits = [Hit::none_before(0.0); LANES];
        match self.kernel {
            Kernel::Portable => portable::closest_of_lanes(&self.tree, rays, &mut hits),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx2 => avx2::plain::closest_of_lanes(&self.tree, rays, &mut hits),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx512 if self.go_together(rays) => {
                avx512::closest_of_lanes(&self.tree, rays, &mut hits);
            }
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx512 => avx2::avx512::closest_of_lanes(&self.tree, rays, &mut hits),
        }
        hits.map(|hit| hit.is_there().then_some(hit))
    }

    /// One bit for each lane of which anything is in the way of the ray before its end.
    pub(crate) fn occluded(&self, rays: &RayLanes) -> u32 {
        if !self.begins_abreast(rays) {
            let bit = |lane: usize| u32::from(self.is_occluded(&rays.get(lane))) << lane;
            return lanes_of(rays.mask()).fold(0, |mask, lane| mask | bit(lane));
        }
        match self.kernel {
            Kernel::Portable => portable::any_of_lanes(&self.tree, rays),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx2 => avx2::plain::any_of_lanes(&self.tree, rays),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx512 if self.go_together(rays) => avx512::any_of_lanes(&self.tree, rays),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx512 => avx2::avx512::any_of_lanes(&self.tree, rays),
        }
    }

    /// True if rays begin their walks together, which is sooner unless they are few.
    #[inline]
    fn begins_abreast(&self, rays: &RayLanes) -> bool {
        rays.mask().count_ones() >= FEWEST_ABREAST
            && self.instances.is_none()
            && !self.tree.nodes.is_empty()
    }

    /// True if they had better go on together, given vectors of sixteen.
    #[cfg(target_arch = "x86_64")]
    #[inline]
    fn go_together(&self, rays: &RayLanes) -> bool {
        self.tree.is_small() && rays.mask().count_ones() >= FEWEST_TOGETHER
    }

    /// Boxes (minimum and maximum) that together hold everything that a ray could meet: those of the uppermost nodes, at
    /// most `n_nodes` of triangles, and as many of instances.
    #[must_use]
    pub fn boxes(&self, n_nodes: usize) -> Vec<[Vec3; 2]> {
        let mut boxes = self.tree.boxes(n_nodes);
        if let Some(instances) = &self.instances {
            boxes.extend(instances.tree.boxes(n_nodes));
        }
        boxes
    }

    /// Memory that it takes, bytes.
    #[must_use]
    pub fn n_bytes(&self) -> usize {
        self.tree.n_bytes() + self.instances.as_ref().map_or(0, |i| i.n_bytes())
    }
}

impl Hit {
    /// What stands for no hit before `t`.
    #[inline]
    pub(super) fn none_before(t: f32) -> Self {
        Self {
            t,
            triangle: u32::MAX,
            barycentrics: [0.0; 2],
        }
    }

    /// True unless it stands for no hit.
    #[inline]
    pub(super) fn is_there(&self) -> bool {
        self.triangle != u32::MAX
    }

    /// True if a ray has this one rather than the other: it is nearer, or as near and of a lower index.
    #[inline]
    pub(super) fn is_before(&self, other: &Self) -> bool {
        self.t < other.t || (self.t == other.t && self.triangle < other.triangle)
    }
}

/// A binary tree with one item in each leaf. Reinsertion of half the nodes makes nearly the best tree at half its time; big
/// scenes get less of it.
pub(super) fn binary_tree<T: Boundable>(items: &[T], quality: TreeQuality) -> Bvh2 {
    let n = items.len();
    let (search, threshold, reinserted) = match quality {
        TreeQuality::Quick => (PlocSearchDistance::Minimum, 0, 0.0),
        TreeQuality::Full if n > 500_000 => (PlocSearchDistance::Medium, WIDENED_AFTER, 0.15),
        TreeQuality::Full => (PlocSearchDistance::Medium, WIDENED_AFTER, 0.5),
    };
    let mut tree = PlocBuilder::with_capacity(n).build(
        search,
        items,
        (0..n as u32).collect(),
        SortPrecision::U64,
        threshold,
    );
    if reinserted > 0.0 {
        ReinsertionOptimizer::default().run(&mut tree, reinserted, None);
    }
    tree
}

/// Rounds of merging neighbours before the search for them widens: obvhs's own for trees of medium quality.
const WIDENED_AFTER: usize = 3;

/// A wide tree over triangles with finite corners.
pub(super) fn tree_of_triangles(triangles: &[[Vec3; 3]], quality: TreeQuality) -> WideTree {
    if triangles.is_empty() {
        return WideTree::default();
    }
    // What the builder works with is gone before the wide tree is made, which takes most memory.
    let binary = binary_tree(&for_builder(triangles), quality);
    let tree = WideTree::of_triangles(&binary, triangles);
    if tree.fits_stack() {
        return tree;
    }
    WideTree::of_triangles(&halves(&for_builder(triangles)), triangles)
}

/// Triangles as obvhs has them.
fn for_builder(triangles: &[[Vec3; 3]]) -> Vec<Triangle> {
    triangles
        .par_iter()
        .map(|t| Triangle {
            v0: t[0].into(),
            v1: t[1].into(),
            v2: t[2].into(),
        })
        .collect()
}

/// A binary tree that is no deeper than it must be: items in the order of their middles along the longest axis, halved again
/// and again. A way out should another tree be too deep to be walked; no triangles are known that make it so.
pub(super) fn halves<T: Boundable>(items: &[T]) -> Bvh2 {
    let boxes: Vec<Aabb> = items.iter().map(Boundable::aabb).collect();
    let mut order: Vec<u32> = (0..items.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default()];
    let mut stack = vec![(0, 0..items.len())];
    while let Some((index, range)) = stack.pop() {
        let mut bounds = Aabb::empty();
        for item in &order[range.clone()] {
            bounds.extend(boxes[*item as usize].min);
            bounds.extend(boxes[*item as usize].max);
        }
        if range.len() == 1 {
            nodes[index] = Bvh2Node::new(bounds, 1, range.start as u32);
            continue;
        }
        let axis = bounds.largest_axis();
        let middle = range.len() / 2;
        order[range.clone()].select_nth_unstable_by(middle, |a, b| {
            let center = |item: &u32| boxes[*item as usize].center()[axis];
            center(a).total_cmp(&center(b)).then(a.cmp(b))
        });
        let children = nodes.len();
        nodes[index] = Bvh2Node::new(bounds, 0, children as u32);
        nodes.extend([Bvh2Node::default(); 2]);
        let cut = range.start + middle;
        stack.push((children, range.start..cut));
        stack.push((children + 1, cut..range.end));
    }
    Bvh2 {
        nodes,
        primitive_indices: order,
        ..Bvh2::default()
    }
}

impl Kernel {
    /// Those that this processor can run, the fastest first.
    fn available() -> impl Iterator<Item = Self> {
        let all = [
            #[cfg(target_arch = "x86_64")]
            Self::Avx512,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2,
            Self::Portable,
        ];
        all.into_iter().filter(|kernel| kernel.is_available())
    }

    fn is_available(self) -> bool {
        match self {
            Self::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => {
                std::is_x86_feature_detected!("avx2")
                    && std::is_x86_feature_detected!("fma")
                    && std::is_x86_feature_detected!("bmi1")
                    && std::is_x86_feature_detected!("lzcnt")
            }
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.is_available()
                    && std::is_x86_feature_detected!("avx512f")
                    && std::is_x86_feature_detected!("avx512vl")
                    && std::is_x86_feature_detected!("avx512bw")
                    && std::is_x86_feature_detected!("avx512dq")
            }
        }
    }

    fn best() -> Self {
        Self::available().next().unwrap_or(Self::Portable)
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Quat, Vec3};
    use rayon::prelude::*;

    use super::super::abreast::RayLanes;
    use super::super::wide::{STACK_SIZE, WIDTH, WideTree};
    use super::{Bvh, Hit, Kernel, Placement, TreeQuality, for_builder, halves};
    use crate::math::Ray;
    use crate::math::lanes::LANES;
    use crate::sampling::{Sampler, warp};

    /// A closed, bumpy sphere.
    fn sphere(n: usize, scale: f32) -> Vec<[Vec3; 3]> {
        let at = |i: usize, j: usize| {
            let theta = std::f32::consts::PI * i as f32 / n as f32;
            let phi = std::f32::consts::TAU * (j % (2 * n)) as f32 / (2 * n) as f32;
            let bump = if i == 0 || i == n {
                1.0
            } else {
                1.0 + 0.1 * (5.0 * phi).sin()
            };
            let (st, ct) = if i == n {
                (0.0, -1.0)
            } else if i == 0 {
                (0.0, 1.0)
            } else {
                theta.sin_cos()
            };
            Vec3::new(st * phi.cos(), ct, st * phi.sin()) * (bump * scale)
        };
        let mut triangles = Vec::new();
        for i in 0..n {
            for j in 0..2 * n {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                if i + 1 < n {
                    triangles.push([a, b, c]);
                }
                if i > 0 {
                    triangles.push([a, c, d]);
                }
            }
        }
        triangles
    }

    #[test]
    fn the_tree_finds_what_a_loop_over_all_triangles_finds() {
        let triangles = sphere(24, 1.0);
        let bvh = Bvh::new(&triangles);
        let single: Vec<Bvh> = triangles.iter().map(|t| Bvh::new(&[*t])).collect();
        for i in 0..2000 {
            let mut sampler = Sampler::new(3, i, 0);
            let origin = warp::uniform_sphere(sampler.next_2d()) * 2.0;
            let ray = Ray::new(origin, warp::uniform_sphere(sampler.next_2d()));
            let best = single
                .iter()
                .enumerate()
                .filter_map(|(k, b)| b.closest_hit(&ray).map(|h| (h.t, k as u32)))
                .min_by(|a, b| a.partial_cmp(b).unwrap());
            let hit = bvh.closest_hit(&ray).map(|h| (h.t, h.triangle));
            assert_eq!(hit, best, "ray {i}");
            assert_eq!(bvh.is_occluded(&ray), best.is_some());
        }
    }

    /// Rays at corners and edges, which the next triangle must catch where the first misses.
    #[test]
    fn no_ray_slips_through_a_closed_mesh() {
        const N_RAYS: u64 = 10_000_000;
        let scales = [1e-3, 1e-1, 1.0, 1e2, 1e4];
        let kernels: Vec<Kernel> = Kernel::available().collect();
        let n = N_RAYS / (scales.len() * kernels.len()) as u64;
        for scale in scales {
            let triangles = sphere(40, scale);
            let mut bvh = Bvh::new(&triangles);
            for &kernel in &kernels {
                bvh.kernel = kernel;
                let slips = |i: u64| {
                    let mut sampler = Sampler::new(5, i, 0);
                    let origin = warp::uniform_sphere(sampler.next_2d()) * (0.5 * scale);
                    let triangle = &triangles[i as usize % triangles.len()];
                    let along = if i.is_multiple_of(2) {
                        0.0
                    } else {
                        sampler.next_1d()
                    };
                    let target = triangle[0] + (triangle[1] - triangle[0]) * along;
                    let ray = Ray::new(origin, (target - origin).normalize());
                    bvh.closest_hit(&ray).is_none() || !bvh.is_occluded(&ray)
                };
                let slipped = (0..n).into_par_iter().find_any(|i| slips(*i));
                assert_eq!(slipped, None, "ray at scale {scale}, {kernel:?}");
            }
        }
    }

    #[test]
    fn kernels_agree_to_the_bit() {
        let triangles = sphere(40, 1.0);
        let mut bvh = Bvh::new(&triangles);
        for i in 0..100_000 {
            let mut sampler = Sampler::new(6, i, 0);
            let origin = warp::uniform_sphere(sampler.next_2d()) * 1.5;
            let ray = Ray::new(origin, warp::uniform_sphere(sampler.next_2d()));
            let answer = |kernel: Kernel| {
                bvh.kernel = kernel;
                let hit = bvh.closest_hit(&ray);
                let bits =
                    hit.map(|h| (h.triangle, h.t.to_bits(), h.barycentrics.map(f32::to_bits)));
                (bits, bvh.is_occluded(&ray))
            };
            let answers: Vec<_> = Kernel::available().map(answer).collect();
            assert!(
                answers.iter().all(|a| *a == answers[0]),
                "ray {i}: {answers:?}"
            );
        }
    }

    #[test]
    fn rays_abreast_meet_what_they_meet_alone() {
        rays_abreast_meet_what_they_meet_alone_in(&sphere(40, 1.0));
    }

    #[test]
    fn rays_go_together_through_a_small_tree() {
        let mut triangles = sphere(3, 1.0);
        assert!(Bvh::new(&triangles).tree.is_small());
        rays_abreast_meet_what_they_meet_alone_in(&triangles);
        // Half inside another, which makes it deeper, with some of the triangles there twice.
        triangles.extend(sphere(3, 1.3).into_iter().take(10));
        triangles.extend_from_within(2..6);
        let bvh = Bvh::new(&triangles);
        let (n_nodes, n_leaves) = (bvh.tree.nodes.len(), bvh.tree.leaves.len());
        assert!(bvh.tree.is_small() && n_nodes > 1, "{n_nodes}, {n_leaves}");
        rays_abreast_meet_what_they_meet_alone_in(&triangles);
    }

    fn rays_abreast_meet_what_they_meet_alone_in(triangles: &[[Vec3; 3]]) {
        let mut bvh = Bvh::new(triangles);
        let (mut n_hits, mut n_occluded) = (0, 0);
        for i in 0..20_000 {
            let mut rays = RayLanes::default();
            for lane in 0..LANES {
                let mut sampler = Sampler::new(16, i, lane as u32);
                let origin = warp::uniform_sphere(sampler.next_2d()) * 1.5;
                let towards = match lane {
                    // Along the axes, forwards and backwards, where a direction has zeros of either sign.
                    0 => Vec3::X,
                    1 => -Vec3::Y,
                    2 => Vec3::new(-0.0, 0.0, 1.0),
                    3 => continue,
                    // At corners and edges.
                    4 => triangles[i as usize % triangles.len()][0] - origin,
                    5 => {
                        let [a, b, _] = triangles[i as usize % triangles.len()];
                        a + (b - a) * sampler.next_1d() - origin
                    }
                    _ => warp::uniform_sphere(sampler.next_2d()),
                };
                let ray = if lane % 2 == 0 {
                    Ray::new(origin, towards.normalize())
                } else {
                    Ray::with_end(origin, towards * 1.7, 1.0)
                };
                rays.set(lane, &ray);
            }
            for kernel in Kernel::available() {
                bvh.kernel = kernel;
                let hits = bvh.closest_hits(&rays);
                let occluded = bvh.occluded(&rays);
                for (lane, found) in hits.into_iter().enumerate() {
                    let is_there = rays.mask() >> lane & 1 != 0;
                    let alone = is_there.then(|| rays.get(lane));
                    let bits = |hit: Option<Hit>| {
                        hit.map(|h| (h.triangle, h.t.to_bits(), h.barycentrics.map(f32::to_bits)))
                    };
                    let hit = alone.and_then(|ray| bvh.closest_hit(&ray));
                    assert_eq!(bits(found), bits(hit), "{kernel:?}, {i}, lane {lane}");
                    let is_occluded = alone.is_some_and(|ray| bvh.is_occluded(&ray));
                    assert_eq!(occluded >> lane & 1 != 0, is_occluded, "{kernel:?}, {i}");
                    n_hits += u32::from(hit.is_some());
                    n_occluded += u32::from(is_occluded);
                }
            }
        }
        assert!(n_hits > 100_000 && n_occluded > 100_000);
    }

    #[test]
    fn of_two_triangles_at_one_distance_the_lower_index_is_hit() {
        let t = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let ray = Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z);
        let mut triangles = vec![t; 9];
        triangles[0] = t.map(|v| v - Vec3::Z);
        assert_eq!(Bvh::new(&triangles).closest_hit(&ray).unwrap().triangle, 1);
    }

    #[test]
    fn trees_of_any_quality_are_hit_alike() {
        let triangles = sphere(40, 1.0);
        let [quick, full] = [TreeQuality::Quick, TreeQuality::Full]
            .map(|quality| Bvh::with_instances(&triangles, &[], &[], quality));
        let mut halved = Bvh::new(&triangles);
        halved.tree = WideTree::of_triangles(&halves(&for_builder(&triangles)), &triangles);
        assert!(quick.tree.nodes.len() != full.tree.nodes.len(), "the same");
        // Six thousand triangles: thirteen halvings.
        assert!(halved.tree.depth <= 13);
        for i in 0..100_000 {
            let mut sampler = Sampler::new(12, i, 0);
            let origin = 2.0 * warp::uniform_sphere(sampler.next_2d());
            let mut target = warp::uniform_sphere(sampler.next_2d());
            if i % 2 == 0 {
                // A corner, where several triangles are as near but for rounding.
                target = triangles[i as usize / 2 % triangles.len()][0];
            }
            let towards = target - origin;
            let ray = Ray::new(origin, towards.normalize());
            let answers = [&quick, &full, &halved].map(|bvh| {
                let hit = bvh.closest_hit(&ray);
                (hit.map(|h| (h.triangle, h.t)), bvh.is_occluded(&ray))
            });
            assert!(answers[0] == answers[1] && answers[0] == answers[2]);
        }
    }

    #[test]
    fn a_tree_that_is_too_deep_to_be_walked_is_told() {
        // Triangles far apart, each half as far as the last: the deepest tree that single precision has room for.
        let triangles: Vec<[Vec3; 3]> = (-90..30)
            .map(|i| [Vec3::X, Vec3::ONE, Vec3::new(1.0, 0.0, 1.0)].map(|p| p * 2f32.powi(i)))
            .collect();
        assert!(Bvh::new(&triangles).tree.fits_stack());
        let tree = WideTree {
            depth: STACK_SIZE / (WIDTH - 1) + 1,
            ..WideTree::default()
        };
        assert!(!tree.fits_stack());
    }

    #[test]
    fn instances_are_hit_where_their_triangles_would_be() {
        let mesh = sphere(12, 0.5);
        let ground = vec![[
            Vec3::new(-9.0, -2.0, -9.0),
            Vec3::new(0.0, -2.0, 9.0),
            Vec3::new(9.0, -2.0, -9.0),
        ]];
        let mut flat = ground.clone();
        let mut placements = Vec::new();
        for i in 0..40 {
            let mut sampler = Sampler::new(8, i, 0);
            let world_from_mesh = Affine3A::from_scale_rotation_translation(
                // One in four is mirrored.
                Vec3::new(if i % 4 == 0 { -0.7 } else { 1.2 }, 0.8, 1.0),
                Quat::from_axis_angle(warp::uniform_sphere(sampler.next_2d()), 2.0),
                warp::uniform_sphere(sampler.next_2d()) * 3.0,
            );
            placements.push(Placement {
                mesh: 0,
                world_from_mesh,
                first_triangle: flat.len() as u32,
            });
            flat.extend(
                mesh.iter()
                    .map(|t| t.map(|v| world_from_mesh.transform_point3(v))),
            );
        }
        let mut instanced = Bvh::with_instances(&ground, &[mesh], &placements, TreeQuality::Full);
        let flattened = Bvh::new(&flat);
        for kernel in Kernel::available() {
            instanced.kernel = kernel;
            let mut n_hits = 0;
            for i in 0..20_000 {
                let mut sampler = Sampler::new(9, i, 0);
                let origin = warp::uniform_sphere(sampler.next_2d()) * 5.0;
                let target = warp::uniform_sphere(sampler.next_2d()) * 3.0;
                let ray = Ray::new(origin, (target - origin).normalize());
                let [a, b] = [&instanced, &flattened].map(|bvh| bvh.closest_hit(&ray));
                // Rounding may decide otherwise at a silhouette, and among neighbours at an edge.
                if let (Some(a), Some(b)) = (a, b) {
                    n_hits += 1;
                    let apart = (a.t - b.t).abs();
                    assert!(
                        apart < 1e-4 || a.triangle != b.triangle,
                        "ray {i}: {a:?} {b:?}"
                    );
                }
                assert_eq!(instanced.is_occluded(&ray), a.is_some(), "ray {i}");
                n_hits -= i32::from(a.is_some() != b.is_some()) * 1000;
            }
            assert!(n_hits > 10_000, "{n_hits} agree");
        }
    }

    #[test]
    fn an_empty_tree_is_missed() {
        let ray = Ray::new(Vec3::ZERO, Vec3::X);
        assert!(Bvh::new(&[]).closest_hit(&ray).is_none());
        assert!(!Bvh::new(&[]).is_occluded(&ray));
    }
}
