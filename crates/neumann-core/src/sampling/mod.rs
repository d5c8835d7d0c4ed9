//! Random numbers, and how to draw from densities.

mod rng;

pub use rng::Sampler;
