//! Vectors come from glam; here is what glam does not have.

pub mod frame;
pub mod ray;

pub use frame::Frame;
pub use ray::Ray;
