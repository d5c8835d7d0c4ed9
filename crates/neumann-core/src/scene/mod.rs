//! What the light meets.
//!
//! [`description`] mirrors a file, [`load`] fills it in, [`Scene::build`] makes it
//! ready to trace: world-space [`geometry`], a tree over it, materials and lights.
//! [`Appearance`] is the part that can be edited without building the tree anew.

mod appearance;
pub mod bodies;
mod build;
pub mod builtin;
pub mod description;
pub mod geometry;
mod lighting;
pub mod load;
mod progress;
#[allow(clippy::module_inception, reason = "the Scene itself")]
mod scene;
mod sky;
mod specular_casters;
mod subject;

pub use appearance::{Appearance, Backs, Level};
pub use builtin::open;
pub use progress::{OpeningProgress, OpeningStep};
pub use scene::{BetterTree, Scene, Statistics};
pub use sky::{Sky, SkyChoice};
pub use specular_casters::SpecularCaster;
