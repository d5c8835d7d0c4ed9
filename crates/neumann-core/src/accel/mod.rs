//! Finds what a ray meets.

mod bvh;
mod triangle;

pub use bvh::{Bvh, Hit};
