//! Colours side by side.

use super::Rgb;
use crate::math::lanes::Lanes;

/// A colour in each lane.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RgbLanes {
    r: Lanes<f32>,
    g: Lanes<f32>,
    b: Lanes<f32>,
}

impl RgbLanes {
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Rgb {
        Rgb::new(self.r.get(lane), self.g.get(lane), self.b.get(lane))
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, value: Rgb) {
        self.r.set(lane, value.r);
        self.g.set(lane, value.g);
        self.b.set(lane, value.b);
    }

    /// Sets a lane if `is_set`, without a branch.
    #[inline(always)]
    pub(crate) fn set_if(&mut self, is_set: bool, lane: usize, value: Rgb) {
        self.r.set_if(is_set, lane, value.r);
        self.g.set_if(is_set, lane, value.g);
        self.b.set_if(is_set, lane, value.b);
    }
}
