//! Colours side by side.

use super::Rgb;
use crate::math::lanes::side_by_side;

side_by_side! {
    /// A colour in each lane.
    pub(crate) struct RgbLanes of Rgb { r: f32, g: f32, b: f32 }
}
