//! What is transported, and in which measure its densities are.

pub mod measure;
pub mod rgb;

pub use rgb::Rgb;
