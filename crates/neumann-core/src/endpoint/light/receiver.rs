//! The point that lights are aimed at from, and the light that it has chosen.

use glam::Vec3;

use crate::math::lanes::side_by_side;

/// A point of a surface that lights are aimed at from.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// World space, metres.
    pub position: Vec3,
    /// Shading normal, unit, on the side that light is scattered from.
    pub normal: Vec3,
    /// 1 if only light on the side of the normal counts, -1 if light from either side does.
    pub(super) side: f32,
}

side_by_side! {
    /// A receiver in each lane.
    pub(crate) struct ReceiverLanes of Receiver { position: Vec3, normal: Vec3, side: f32 }
}

impl Receiver {
    /// In the place of a point that is not there.
    pub const NOWHERE: Self = Self {
        position: Vec3::ZERO,
        normal: Vec3::Z,
        side: 1.0,
    };

    /// A point that scatters what comes from the normal's side, or from both sides.
    #[inline]
    #[must_use]
    pub fn new(position: Vec3, normal: Vec3, has_both_sides: bool) -> Self {
        Self {
            position,
            normal,
            side: if has_both_sides { -1.0 } else { 1.0 },
        }
    }

    /// True if it scatters what comes from either side.
    #[inline]
    #[must_use]
    pub fn has_both_sides(&self) -> bool {
        self.side < 0.0
    }
}

/// A light that has been chosen.
#[derive(Clone, Copy, Debug)]
pub struct Chosen {
    /// Which one.
    pub light: usize,
    /// Its probability.
    pub pmf: f32,
    /// A number in [0, 1) to choose a part of it by.
    pub part: f32,
}
