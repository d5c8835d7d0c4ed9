//! Random numbers, and how to draw from densities.

pub mod discrete;
pub mod mis;
mod pixel_numbers;
mod rng;
pub mod roulette;
mod sobol;
pub mod warp;

pub use pixel_numbers::PixelNumbers;
pub use rng::Sampler;
