//! Finds what a ray meets.
//!
//! obvhs builds a binary tree; `wide` collapses it into nodes of eight children and
//! leaves of four triangles; `traverse` walks it. The code that does so is written once, over
//! fixed-size arrays, and compiled twice: for any processor, and for those with AVX2 and
//! FMA, chosen when the tree is built.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod bvh;
mod instances;
mod portable;
mod traverse;
mod wide;

pub use bvh::{Bvh, Hit};
pub use instances::Placement;
