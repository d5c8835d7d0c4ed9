//! A bounding volume hierarchy over triangles.

use glam::Vec3;

use super::abreast::{HitLanes, RayLanes};
use super::build::{TreeQuality, tree_of_triangles};
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

    /// Hands everything that the ray meets before its end to `found`, in no order. All kernels find
    /// the same, so that it is written for any processor.
    pub fn each_hit(&self, ray: &Ray, found: &mut dyn FnMut(Hit)) {
        if !self.tree.nodes.is_empty() {
            portable::each(&self.tree, ray, found);
        }
        if let Some(instances) = &self.instances {
            portable::each_of_instances(instances, ray, found);
        }
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
mod tests;
