//! A bounding volume hierarchy over triangles.

use glam::Vec3;

use super::abreast::{HitLanes, RayLanes};
use super::build::{TreeQuality, tree_of_triangles};
use super::hits::{Best, Crossing, Hit, Met, Occlusion, PackedHit};
use super::instances::{Instances, Placement};
use super::portable;
use super::traverse::OcclusionLanes;
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
/// Taking sixteen rays through a small tree together takes as long as about so many that walk it
/// one by one.
#[cfg(target_arch = "x86_64")]
const FEWEST_TOGETHER: u32 = 9;

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

    /// A tree over triangles that stand in the world themselves, whose indices come first, and over
    /// meshes (`meshes[mesh][triangle]`, in their own space) that stand there as placed.
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

    /// What the ray meets first, if anything, as far as single precision can tell.
    #[inline]
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.meet(ray).hit
    }

    /// True if anything is in the way of the ray before its end, as far as single precision can
    /// tell.
    #[must_use]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        match self.look(ray) {
            Occlusion::Clear => false,
            Occlusion::Stopped => true,
            Occlusion::Unsure => {
                let mut is_occluded = false;
                self.crossings(ray, &mut |crossing| {
                    let t = crossing.hit.t;
                    is_occluded |= t > 0.0 && t < ray.t_max();
                    ray.t_max()
                });
                is_occluded
            }
        }
    }

    /// What the ray meets first.
    #[inline]
    pub(crate) fn meet(&self, ray: &Ray) -> Met {
        let hit = match &self.instances {
            None if self.tree.nodes.is_empty() => PackedHit::from(Best::none_before(ray.t_max())),
            None => match self.kernel {
                Kernel::Portable => portable::closest(&self.tree, ray),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx2 => avx2::plain::closest(&self.tree, ray),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx512 => avx2::avx512::closest(&self.tree, ray),
            },
            Some(instances) => match self.kernel {
                Kernel::Portable => portable::closest_of_all(&self.tree, instances, ray),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx2 => avx2::plain::closest_of_all(&self.tree, instances, ray),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx512 => avx2::avx512::closest_of_all(&self.tree, instances, ray),
            },
        };
        hit.into()
    }

    /// Hands everything that the ray meets before its end to `found`, in no order, as far as single
    /// precision can tell.
    pub fn each_hit(&self, ray: &Ray, found: &mut dyn FnMut(Hit)) {
        self.crossings(ray, &mut |crossing| {
            if crossing.hit.t > 0.0 && crossing.hit.t < ray.t_max() {
                found(crossing.hit);
            }
            ray.t_max()
        });
    }

    /// Whether anything is in the way of the ray before its end.
    #[inline]
    pub(crate) fn look(&self, ray: &Ray) -> Occlusion {
        let sight = if self.tree.nodes.is_empty() {
            Occlusion::Clear
        } else {
            match self.kernel {
                Kernel::Portable => portable::any(&self.tree, ray),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx2 => avx2::plain::any(&self.tree, ray),
                #[cfg(target_arch = "x86_64")]
                Kernel::Avx512 => avx2::avx512::any(&self.tree, ray),
            }
        };
        match &self.instances {
            Some(instances) if sight != Occlusion::Stopped => {
                let inside = match self.kernel {
                    Kernel::Portable => portable::any_of_instances(instances, ray),
                    #[cfg(target_arch = "x86_64")]
                    Kernel::Avx2 => avx2::plain::any_of_instances(instances, ray),
                    #[cfg(target_arch = "x86_64")]
                    Kernel::Avx512 => avx2::avx512::any_of_instances(instances, ray),
                };
                if inside == Occlusion::Clear {
                    sight
                } else {
                    inside
                }
            }
            _ => sight,
        }
    }

    /// Hands everything that the ray meets, or may meet, to `visit`, in any order: each triangle
    /// once. `visit` says beyond which
    /// distance nothing is wanted any more.
    pub(crate) fn crossings(&self, ray: &Ray, visit: &mut dyn FnMut(&Crossing) -> f32) {
        let instances = self.instances.as_deref();
        match self.kernel {
            Kernel::Portable => portable::crossings(&self.tree, instances, ray, visit),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx2 => avx2::plain::crossings(&self.tree, instances, ray, visit),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx512 => avx2::avx512::crossings(&self.tree, instances, ray, visit),
        }
    }

    /// What the rays meet first, if anything, and one bit for each lane that is not sure of it.
    pub(crate) fn closest_hits(&self, rays: &RayLanes) -> (HitLanes, u32) {
        if !self.begins_abreast(rays) {
            let (mut found, mut unsure) = ([None; LANES], 0);
            for lane in lanes_of(rays.mask()) {
                let met = self.meet(&rays.get(lane));
                found[lane] = met.hit;
                unsure |= u32::from(!met.is_sure) << lane;
            }
            return (found, unsure);
        }
        let mut hits = [Hit::none_before(0.0); LANES];
        let unsure = match self.kernel {
            Kernel::Portable => portable::closest_of_lanes(&self.tree, rays, &mut hits),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx2 => avx2::plain::closest_of_lanes(&self.tree, rays, &mut hits),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx512 if self.go_together(rays) => {
                avx512::closest_of_lanes(&self.tree, rays, &mut hits)
            }
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx512 => avx2::avx512::closest_of_lanes(&self.tree, rays, &mut hits),
        };
        (hits.map(|hit| hit.is_there().then_some(hit)), unsure)
    }

    /// Whether anything is in the way of the rays before their ends.
    pub(crate) fn occluded(&self, rays: &RayLanes) -> OcclusionLanes {
        if !self.begins_abreast(rays) {
            let mut lanes = OcclusionLanes::default();
            for lane in lanes_of(rays.mask()) {
                let sight = self.look(&rays.get(lane));
                lanes.stopped |= u32::from(sight == Occlusion::Stopped) << lane;
                lanes.unsure |= u32::from(sight == Occlusion::Unsure) << lane;
            }
            return lanes;
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

    /// Boxes (minimum and maximum) that together hold everything that a ray could meet: those of
    /// the uppermost nodes, at most `n_nodes` of triangles, and as many of instances.
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
