//! Vectors come from glam; here is what glam does not have.

pub mod frame;
pub(crate) mod lanes;
mod prefetch;
pub mod ray;
pub mod triangle;

pub use frame::Frame;
pub(crate) use prefetch::prefetch;
pub use ray::Ray;
