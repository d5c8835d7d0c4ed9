//! What is transported, and in which measure its densities are.

mod lanes;
pub mod measure;
pub mod rgb;

pub(crate) use lanes::RgbLanes;
pub use rgb::Rgb;
