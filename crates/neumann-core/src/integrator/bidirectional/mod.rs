//! Walks from both ends of a path, and the four ways to join them.
//!
//! A path of n vertices can be made by a light subpath of s and a camera subpath of t = n - s
//! vertices that are connected, or by subpaths with s + t = n + 1 whose ends are merged. [`walk`]
//! makes the subpaths, [`connect`] joins them, and [`weights`] says how much each technique counts.
//! `LightEnd` and `CameraEnd` are all of that put together: what is done from either end, step by
//! step.

mod camera;
pub mod connect;
mod lanes;
mod light;
mod merging;
mod subpath;
pub mod walk;
pub mod weights;

pub(super) use camera::{CameraEnd, CameraScratch};
pub(super) use light::{LightEnd, LightPath, LightVertex, ToLens, numbered};
pub(super) use merging::{Mergeable, Merging};
pub use walk::{Vertex, Walk};
pub use weights::{Heuristic, MisWeights, Partial};
