//! A tree over lights, from which one is chosen in proportion to a bound of what it sends to a
//! point.
//!
//! After [Conty & Kulla 2018] and \[PBR4\] 12.6.3. From the root down, each step goes on to one
//! child with probability proportional to its importance, `I cos θ cos θ_i / d²`: an estimate of
//! what its lights send to the receiver. It is 0 only where bounds say that none of them can reach
//! it.
//!
//! Unlike the sources, a node has up to four children, whose importances are found together, and
//! the cosines are not the best that the bounds allow: a closed lantern would count as if all of it
//! faced the receiver. With `V` the vector sum of the lights' axes, by intensity, and `m` its
//! length over the sum of intensities, the mean of `max(0, cos θ)` over the lights is that of a
//! single direction for m = 1, and in general close to `1/4 + V·ω / 2`, the first two terms of
//! the clamped cosine in spherical harmonics.

use glam::Vec4;

use super::bounds::LightBounds;
use super::receiver::{Chosen, Receiver};

/// Children of a node.
pub(super) const WIDTH: usize = 4;

/// A tree over lights that have a place.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    /// The root comes first.
    nodes: Vec<Node>,
    /// `places[light]`: the lane that leads to it, or `NOWHERE`.
    places: Vec<u32>,
}

/// A lane of a node, as `node * WIDTH + lane`.
const NOWHERE: u32 = u32::MAX;
/// Marks a child that is a light.
const LIGHT: u32 = 1 << 31;

/// The children, lane by lane.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// A sphere around the lights, world space, metres.
    center: [Vec4; 3],
    radius: Vec4,
    /// Mean axis of the lights, unit.
    axis: [Vec4; 3],
    /// How much they have that axis in common: `m`, from 0 to 1.
    unity: Vec4,
    /// Cosine of the angle about the axis beyond which none of them shines.
    cos_reach: Vec4,
    /// -1 where some light shines both ways, else 1.
    side: Vec4,
    /// 0 in lanes without a child.
    intensity: Vec4,
    /// The most that `1 / d²` counts, 1/m²: its mean over a ball, seen from the middle.
    nearest: Vec4,
    children: [u32; WIDTH],
    /// The lane that leads here.
    parent: u32,
}

/// Importances of a node's children.
#[derive(Clone, Copy, Debug)]
pub(super) struct Importances {
    lanes: [f32; WIDTH],
    /// Their sum: about what all of the lights send to the receiver, W/m², but for the tree's
    /// scale.
    pub(super) sum: f32,
}

/// Cosines are known to this much: lights so close to the edge of what they reach are not ruled
/// out.
const MARGIN: f32 = 2e-3;
/// Of lights that may reach a receiver, each cosine counts as this much at least, since it is only
/// estimated.
const LEAST_COSINE: f32 = 0.02;
/// The smallest squared distance, m²: keeps importances finite.
const NEAREST: f32 = 1e-30;

impl LightTree {
    /// A tree without nodes, for lights of numbers below `n_lights`.
    pub(super) fn empty(n_lights: usize) -> Self {
        Self {
            nodes: Vec::new(),
            places: vec![NOWHERE; n_lights],
        }
    }

    /// Adds a node with no children yet; `parent` is the node and lane that lead to it.
    pub(super) fn push(&mut self, parent: Option<(usize, usize)>) -> usize {
        let index = self.nodes.len();
        let mut node = Node::EMPTY;
        if let Some((above, lane)) = parent {
            node.parent = (above * WIDTH + lane) as u32;
            self.nodes[above].children[lane] = index as u32;
        }
        self.nodes.push(node);
        index
    }

    /// Sets the bounds of a lane, with intensities in units of `1 / scale`.
    pub(super) fn set_lane(&mut self, node: usize, lane: usize, bounds: &LightBounds, scale: f64) {
        self.nodes[node].set(lane, bounds, scale);
    }

    /// Makes a light the child of a lane.
    pub(super) fn set_light(&mut self, node: usize, lane: usize, light: usize) {
        self.nodes[node].children[lane] = LIGHT | light as u32;
        self.places[light] = (node * WIDTH + lane) as u32;
    }

    /// True if no light has a place.
    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// True if the lights are few and nothing but their strength tells them apart, as the two
    /// halves of a rectangle.
    pub(super) fn is_one_place(&self) -> bool {
        let [node] = self.nodes.as_slice() else {
            return false;
        };
        (1..WIDTH)
            .filter(|lane| node.intensity[*lane] > 0.0)
            .all(|lane| {
                let is_same = |v: &Vec4| v[lane] == v[0];
                node.center.iter().chain(&node.axis).all(is_same)
                    && [node.radius, node.unity, node.cos_reach, node.side]
                        .iter()
                        .all(is_same)
            })
    }

    /// True if a light is in the tree.
    #[inline]
    pub(super) fn has(&self, light: usize) -> bool {
        self.places[light] != NOWHERE
    }

    /// Importances of the root's children.
    #[inline]
    pub(super) fn root(&self, at: &Receiver) -> Importances {
        self.nodes[0].importances(at)
    }

    /// The light that `u` in [0, 1) falls on, with what is left of `u` for a part of it; `None`
    /// where the way ends at lights that cannot
    /// reach the receiver after all.
    #[inline]
    pub(super) fn sample(&self, at: &Receiver, root: Importances, mut u: f32) -> Option<Chosen> {
        let mut pmf = 1.0;
        let mut node = &self.nodes[0];
        let mut importances = root;
        loop {
            let lane = importances.pick(&mut u)?;
            pmf *= importances.pmf(lane);
            let child = node.children[lane];
            if child & LIGHT != 0 {
                return Some(Chosen {
                    light: (child & !LIGHT) as usize,
                    pmf,
                    part: u,
                });
            }
            node = &self.nodes[child as usize];
            importances = node.importances(at);
        }
    }

    /// The probability with which [`Self::sample`] comes to a light of the tree.
    pub(super) fn pmf(&self, at: &Receiver, root: Importances, light: usize) -> f32 {
        let mut pmf = 1.0;
        let mut place = self.places[light] as usize;
        loop {
            let (index, lane) = (place / WIDTH, place % WIDTH);
            if index == 0 {
                return pmf * root.pmf(lane);
            }
            let node = &self.nodes[index];
            pmf *= node.importances(at).pmf(lane);
            if pmf == 0.0 {
                return 0.0;
            }
            place = node.parent as usize;
        }
    }
}

impl Importances {
    /// The lane that `u` falls on; `u` becomes where in it, in [0, 1).
    #[inline]
    fn pick(&self, u: &mut f32) -> Option<usize> {
        let mut rest = *u * self.sum;
        let mut picked = None;
        for (lane, importance) in self.lanes.into_iter().enumerate() {
            if importance > 0.0 {
                picked = Some(lane);
                if rest < importance {
                    break;
                }
                rest -= importance;
            }
        }
        let lane = picked?;
        *u = (rest / self.lanes[lane]).min(1.0 - f32::EPSILON);
        Some(lane)
    }

    #[inline]
    fn pmf(&self, lane: usize) -> f32 {
        if self.lanes[lane] > 0.0 {
            self.lanes[lane] / self.sum
        } else {
            0.0
        }
    }
}

impl Node {
    const EMPTY: Self = Self {
        center: [Vec4::ZERO; 3],
        radius: Vec4::ZERO,
        axis: [Vec4::ZERO; 3],
        unity: Vec4::ZERO,
        cos_reach: Vec4::ONE,
        side: Vec4::ONE,
        intensity: Vec4::ZERO,
        nearest: Vec4::ZERO,
        children: [NOWHERE; WIDTH],
        parent: NOWHERE,
    };

    fn set(&mut self, lane: usize, bounds: &LightBounds, scale: f64) {
        let center = bounds.center();
        let axis = bounds.vector.normalize_or(bounds.axis);
        for i in 0..3 {
            self.center[i][lane] = center[i];
            self.axis[i][lane] = axis[i];
        }
        // A little more than half the diagonal, for what rounding does.
        let radius = (bounds.max - center).length() * 1.0001 + center.length() * 1e-6;
        let intensity = (f64::from(bounds.intensity) * scale) as f32;
        self.radius[lane] = radius;
        self.unity[lane] = bounds.unity();
        self.cos_reach[lane] = bounds.reach_about(axis).cos();
        self.side[lane] = if bounds.is_two_sided { -1.0 } else { 1.0 };
        self.intensity[lane] = intensity;
        self.nearest[lane] = 3.0 / (radius * radius).max(NEAREST);
    }

    /// Importances of the children (compare \[PBR4\] 12.6.3).
    #[inline]
    fn importances(&self, at: &Receiver) -> Importances {
        let away = [0, 1, 2].map(|i| Vec4::splat(at.position[i]) - self.center[i]);
        let dot = |a: [Vec4; 3]| a[0] * away[0] + a[1] * away[1] + a[2] * away[2];
        let distance_squared = dot(away).max(Vec4::splat(NEAREST));
        let over_distance_squared = distance_squared.recip();
        let over_distance = over_distance_squared.sqrt();

        // The angle θ_b that the sphere takes up, seen from the receiver.
        let radius_squared = self.radius * self.radius;
        let is_inside = distance_squared.cmple(radius_squared);
        let sin_b = self.radius * over_distance;
        let cos_b = sin_from_cos(sin_b);

        // Cosines of the angle θ between the mean axis and the direction to the receiver, and of
        // θ_i between the normal and the direction to the lights; where light from both sides
        // counts, the better one.
        let both_sides = |cos: Vec4, side: Vec4| cos.max(cos * side);
        let cos_axis = both_sides(dot(self.axis) * over_distance, self.side);
        let normal = at.normal.to_array().map(Vec4::splat);
        let cos_normal = both_sides(-dot(normal) * over_distance, Vec4::splat(at.side));

        // The best cosines that bounds allow: of θ - θ_b and θ_i - θ_b.
        let best_axis = cos_less(cos_axis, cos_b, sin_b);
        let best_normal = cos_less(cos_normal, cos_b, sin_b);
        let margin = Vec4::splat(MARGIN);
        let is_reached = best_axis.cmpgt(self.cos_reach - margin) & best_normal.cmpgt(-margin);

        // The mean cosine at the lights: of one direction, or of many; and that at the receiver.
        let one = cos_axis.max(Vec4::ZERO);
        let many = (Vec4::splat(0.25) + 0.5 * self.unity * cos_axis).max(Vec4::ZERO);
        let unity_squared = self.unity * self.unity;
        let at_lights = many + (one - many) * (unity_squared * unity_squared);
        let at_receiver = 0.5 * (cos_normal.max(Vec4::ZERO) + best_normal);

        let least = Vec4::splat(LEAST_COSINE);
        let cosines = at_lights.max(least) * at_receiver.max(least);
        let cosines = Vec4::select(is_reached, cosines, Vec4::ZERO);
        // Within the sphere, lights are on all sides.
        let cosines = Vec4::select(is_inside, Vec4::splat(0.25), cosines);
        let importance = self.intensity * cosines * over_distance_squared.min(self.nearest);
        Importances {
            lanes: importance.to_array(),
            sum: importance.element_sum(),
        }
    }
}

/// Cosine of `max(0, a - b)`, for angles from 0 to π.
#[inline]
fn cos_less(cos_a: Vec4, cos_b: Vec4, sin_b: Vec4) -> Vec4 {
    let cos = cos_a * cos_b + sin_from_cos(cos_a) * sin_b;
    Vec4::select(cos_a.cmpge(cos_b), Vec4::ONE, cos)
}

#[inline]
fn sin_from_cos(cos: Vec4) -> Vec4 {
    (Vec4::ONE - cos * cos).max(Vec4::ZERO).sqrt()
}
