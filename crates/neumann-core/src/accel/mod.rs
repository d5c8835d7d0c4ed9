//! Finds what a ray meets.
//!
//! `build` makes a `binary` tree, by `clusters` and `reinsertion`; `collapse` makes a `wide` one of
//! it, with nodes of eight children and leaves of four triangles; `traverse` walks it. The two
//! tests that it asks for, of boxes and of triangles, are written over arrays for any processor
//! (`portable`) and in vectors for those with AVX2 (`avx2`), which are compiled once more for those
//! with AVX-512; which of the three runs is chosen when the tree is built. `instances` is for
//! meshes that stand in the world many times. Many rays at once begin their walk in vectors
//! (`abreast`); through a small tree they go on together (`avx512`).

mod abreast;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod binary;
mod build;
mod bvh;
mod clusters;
mod collapse;
mod hits;
mod instances;
mod memory;
mod portable;
mod prepared;
mod reinsertion;
mod traverse;
mod wide;

pub(crate) use abreast::{HitLanes, RayLanes};
pub use build::TreeQuality;
pub use bvh::Bvh;
pub use hits::Hit;
pub(crate) use hits::Occlusion;
pub use instances::Placement;
