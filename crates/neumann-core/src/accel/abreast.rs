//! Rays side by side.
//!
//! They are prepared, and meet the children of the root, sixteen at once in vectors. From there on
//! each walks by itself: rays that have been scattered soon go different ways, and a vector of
//! which few lanes are wanted is slower than the vectors of boxes and triangles that a single ray
//! meets. Only a small tree is walked together to its end, where vectors are long enough
//! ([`super::avx512`]).

use glam::Vec3;

use super::hits::Hit;
use super::prepared::{AXES, FAR_PADDING, Prepared, most_slack, slack_of_depth, slack_of_origin};
use super::wide::{Node, WIDTH, WideTree};
use crate::math::Ray;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, lanes_of};
use crate::math::ray::{LENS, NO_TRIANGLE};

/// A ray in each lane, or none.
#[derive(Clone, Debug)]
pub(crate) struct RayLanes {
    origin: Vec3Lanes,
    direction: Vec3Lanes,
    end: Lanes<f32>,
    /// The triangles that they start on,
    leaves: Lanes<u32>,
    /// and those that they end on.
    aims_at: Lanes<u32>,
    /// One bit for each lane that has one.
    is_there: u32,
}

/// What the rays of all lanes meet first; `None` where there is no ray, or nothing is met.
pub(crate) type HitLanes = [Option<Hit>; LANES];

impl Default for RayLanes {
    fn default() -> Self {
        Self {
            origin: Vec3Lanes::default(),
            direction: Vec3Lanes::default(),
            end: Lanes::default(),
            leaves: Lanes([NO_TRIANGLE; LANES]),
            aims_at: Lanes([NO_TRIANGLE; LANES]),
            is_there: 0,
        }
    }
}

impl RayLanes {
    /// Puts a ray into a lane.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, ray: &Ray) {
        self.origin.set(lane, ray.origin());
        self.direction.set(lane, ray.direction());
        self.end.set(lane, ray.t_max());
        self.leaves.set(lane, ray.leaves());
        self.aims_at.set(lane, ray.aims_at());
        self.is_there |= 1 << lane;
    }

    /// The ray of a lane.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Ray {
        Ray::with_end(
            self.origin.get(lane),
            self.direction.get(lane),
            self.end.get(lane),
        )
        .leaving(self.leaves.get(lane))
        .aimed_at(self.aims_at.get(lane))
    }

    /// The distance at which the ray of a lane ends.
    #[inline(always)]
    pub(super) fn end(&self, lane: usize) -> f32 {
        self.end.get(lane)
    }

    /// Those distances.
    #[inline(always)]
    pub(super) fn ends(&self) -> &Lanes<f32> {
        &self.end
    }

    /// The triangles that the rays start on, and those that they end on.
    #[inline(always)]
    pub(super) fn triangles(&self) -> [&Lanes<u32>; 2] {
        [&self.leaves, &self.aims_at]
    }

    /// Where the ray of a lane starts.
    #[inline(always)]
    pub(crate) fn origin(&self, lane: usize) -> Vec3 {
        self.origin.get(lane)
    }

    /// Where the ray of a lane goes.
    #[inline(always)]
    pub(crate) fn direction(&self, lane: usize) -> Vec3 {
        self.direction.get(lane)
    }

    /// Gives a lane another ray with the same end, from a point of a triangle, if it is to be
    /// there.
    #[inline(always)]
    pub(crate) fn replace(
        &mut self,
        lane: usize,
        is_replaced: bool,
        (origin, leaves): (Vec3, u32),
        direction: Vec3,
    ) {
        self.origin.set_if(is_replaced, lane, origin);
        self.direction.set_if(is_replaced, lane, direction);
        self.leaves.set_if(is_replaced, lane, leaves);
    }

    /// Puts a ray that ends into a lane; not there before [`Self::set_mask`] says so.
    #[inline(always)]
    pub(crate) fn set_segment(&mut self, lane: usize, segment: &Ray) {
        self.origin.set(lane, segment.origin());
        self.direction.set(lane, segment.direction());
        self.end.set(lane, segment.t_max());
        self.leaves.set(lane, segment.leaves());
        self.aims_at.set(lane, segment.aims_at());
    }

    /// Puts the ray of a lane of others into a lane; not there before [`Self::set_mask`] says so.
    #[inline(always)]
    pub(crate) fn copy(&mut self, lane: usize, others: &Self, of: usize) {
        self.origin.set(lane, others.origin.get(of));
        self.direction.set(lane, others.direction.get(of));
        self.end.set(lane, others.end.get(of));
        self.leaves.set(lane, others.leaves.get(of));
        self.aims_at.set(lane, others.aims_at.get(of));
    }

    /// True if the lens is at one end of any of them.
    pub(crate) fn meet_lens(&self) -> bool {
        let is_lens = |lane| [self.leaves.get(lane), self.aims_at.get(lane)].contains(&LENS);
        lanes_of(self.is_there).any(is_lens)
    }

    /// One bit for each lane that has a ray.
    #[inline(always)]
    pub(crate) fn mask(&self) -> u32 {
        self.is_there
    }

    /// Says that of some lanes (one bit for each) those have rays of which both numbers are 1.
    #[inline(always)]
    pub(crate) fn set_mask_where(&mut self, lanes: u32, a: &Lanes<u32>, b: &Lanes<u32>) {
        self.is_there = 0;
        for lane in lanes_of(lanes) {
            self.is_there |= (a.get(lane) & b.get(lane)) << lane;
        }
    }

    /// Says which lanes have rays.
    #[inline(always)]
    pub(crate) fn set_mask(&mut self, mask: u32) {
        self.is_there = mask;
    }
}

/// [`Prepared`], in each lane.
pub(super) struct PreparedLanes<'a> {
    rays: &'a RayLanes,
    pub(super) origin: Vec3Lanes,
    pub(super) inverse: [Lanes<f32>; 3],
    /// 1 where the direction is negative along an axis.
    pub(super) is_negative: [Lanes<u32>; 3],
    /// The axis that the ray runs along most.
    pub(super) along: Lanes<u32>,
    pub(super) shear: [Lanes<f32>; 3],
    pub(super) slack: Lanes<f32>,
    most_slack: Lanes<f32>,
}

impl<'a> PreparedLanes<'a> {
    #[inline(always)]
    pub(super) fn new(tree: &WideTree, rays: &'a RayLanes) -> Self {
        let mut prepared = Self {
            rays,
            origin: rays.origin,
            inverse: [Lanes::default(); 3],
            is_negative: [Lanes::default(); 3],
            along: Lanes::default(),
            shear: [Lanes::default(); 3],
            slack: Lanes::default(),
            most_slack: Lanes::default(),
        };
        for lane in 0..LANES {
            let d = rays.direction.get(lane).to_array();
            let inverse = d.map(|d| {
                if d.abs() < 1e-18 {
                    1e18f32.copysign(d)
                } else {
                    1.0 / d
                }
            });
            let is_negative = d.map(|d| d.to_bits() >> 31);
            let [x, y, z] = d.map(f32::abs);
            let is_y = y > x;
            let is_z = z > if x > y { x } else { y };
            // Of three, the one that goes with the axis.
            let pick = |of_x, of_y, of_z| {
                if is_z {
                    of_z
                } else if is_y {
                    of_y
                } else {
                    of_x
                }
            };
            let scale = pick(inverse[0], inverse[1], inverse[2]);
            let across = [pick(d[1], d[2], d[0]), pick(d[2], d[0], d[1])];
            for axis in 0..3 {
                prepared.inverse[axis].set(lane, inverse[axis]);
                prepared.is_negative[axis].set(lane, is_negative[axis]);
            }
            prepared.along.set(
                lane,
                if is_z {
                    2
                } else if is_y {
                    1
                } else {
                    0
                },
            );
            prepared.shear[0].set(lane, across[0] * scale);
            prepared.shear[1].set(lane, across[1] * scale);
            prepared.shear[2].set(lane, scale);
            let reach = rays.origin.get(lane).abs().max_element();
            prepared.slack.set(lane, slack_of_origin(reach, scale));
            prepared
                .most_slack
                .set(lane, most_slack(tree, reach, reach, scale));
        }
        prepared
    }

    /// That of one lane.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> Prepared {
        let is_negative = [0, 1, 2].map(|axis| self.is_negative[axis].get(lane) as usize);
        let z = self.along.get(lane) as usize % 3;
        Prepared {
            origin: self.origin.get(lane).to_array(),
            inverse: [0, 1, 2].map(|axis| self.inverse[axis].get(lane)),
            near: [0, 1, 2].map(|axis| 2 * axis + is_negative[axis] % 2),
            axes: AXES[z],
            shear: [0, 1, 2].map(|axis| self.shear[axis].get(lane)),
            slack: self.slack.get(lane),
            slack_of_depth: slack_of_depth(self.shear[2].get(lane)),
            most_slack: self.most_slack.get(lane),
            ends: self.rays.triangles().map(|lanes| lanes.get(lane)),
        }
    }
}

/// [`BoxHits`](super::traverse::BoxHits), in each lane.
#[derive(Default)]
pub(super) struct BoxHitLanes {
    near: [Lanes<f32>; WIDTH],
    mask: Lanes<u32>,
}

impl BoxHitLanes {
    /// The children of a node that the rays meet.
    #[inline(always)]
    pub(super) fn new(node: &Node, rays: &RayLanes, prepared: &PreparedLanes<'_>) -> Self {
        let mut hits = Self::default();
        for child in 0..WIDTH {
            let low = [0, 2, 4].map(|row| node.bounds[row][child]);
            let high = [1, 3, 5].map(|row| node.bounds[row][child]);
            for lane in 0..LANES {
                let origin = prepared.origin.get(lane).to_array();
                let (mut near, mut far) = (0.0, f32::INFINITY);
                for axis in 0..3 {
                    let (o, inverse) = (origin[axis], prepared.inverse[axis].get(lane));
                    let is_negative = prepared.is_negative[axis].get(lane) != 0;
                    let (low, high) = (low[axis], high[axis]);
                    let (first, last) = if is_negative {
                        (high, low)
                    } else {
                        (low, high)
                    };
                    let t = (first - o) * inverse;
                    near = if t > near { t } else { near };
                    let t = (last - o) * inverse;
                    far = if t < far { t } else { far };
                }
                let t_max = rays.end.get(lane);
                let end = if far < t_max { far } else { t_max };
                hits.near[child].set(lane, near);
                let is_met = u32::from(near <= end * FAR_PADDING);
                hits.mask.set(lane, hits.mask.get(lane) | is_met << child);
            }
        }
        hits
    }

    /// The children that the ray of a lane meets, one bit for each.
    #[inline(always)]
    pub(super) fn mask(&self, lane: usize) -> u32 {
        self.mask.get(lane)
    }

    /// How far away the ray of a lane meets a child.
    #[inline(always)]
    pub(super) fn near(&self, child: usize, lane: usize) -> f32 {
        self.near[child].get(lane)
    }
}
