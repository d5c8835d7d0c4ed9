//! Random numbers, and how to draw from densities.

pub mod discrete;
pub mod mis;
mod numbers;
mod points;
mod rng;
pub mod roulette;
mod sobol;
mod tile_numbers;
pub mod warp;

pub use numbers::{BounceNumbers, StartNumbers};
pub use rng::Sampler;
pub use tile_numbers::TileNumbers;
