//! Random numbers, and how to draw from densities.

pub mod discrete;
pub mod mis;
mod rng;
pub mod roulette;
mod sobol;
pub mod warp;

pub use rng::Sampler;
