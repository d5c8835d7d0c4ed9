//! Walks from both ends of a path, and the four ways to join them.
//!
//! A path of n vertices can be made by a light subpath of s and a camera subpath of t = n - s
//! vertices that are connected, or by subpaths with s + t = n + 1 whose ends are merged. [`walk`]
//! makes the subpaths, [`connect`] joins them, and [`weights`] says how much each technique counts.

mod abreast;
pub mod connect;
pub mod walk;
pub mod weights;

pub(super) use abreast::LightSubpath;
pub use walk::{Vertex, Walk};
pub use weights::{Heuristic, Partial, Weighing};
