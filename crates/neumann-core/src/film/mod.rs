//! What was measured: the terms of `L = Σ_k T^k L_e`, kept apart by bounce.
//!
//! A [`Frame`] is one iteration, one complete estimate of the image; a
//! [`Film`] is the mean of its frames. Both hold K bounce layers `T0 … T(K-1)`
//! and one tail layer for every bounce `k ≥ K`, so that the layers always add
//! up to L. Everything here is linear, unclamped radiance; exposure, tone
//! curve and false colour happen on the way to the screen.

mod batch_means;
mod classes;
pub mod contribution;
pub mod features;
#[allow(clippy::module_inception, reason = "the Film itself")]
mod film;
mod fireflies;
mod frame;
mod layer_spread;
mod light_groups;
mod means;
mod sample_map;
pub mod techniques;
mod tile;
pub mod view;

pub use classes::{ClassError, ClassFilm, PathClasses};
pub(crate) use classes::{ClassRecord, ClassShape};
pub use contribution::{Contribution, Joint, Strategy};
pub use features::Features;
pub use film::{Film, FilmError, Spread};
pub use fireflies::Firefly;
pub use frame::{Frame, PhotonReport};
pub(crate) use frame::{LitLayers, Slot, TILE, TILE_PIXELS, TileBounds, TileGrid, add_to_tile};
pub use light_groups::{LightGroup, LightGroupError};
pub use sample_map::SampleMap;
pub use techniques::{TechniqueCell, TechniqueFilm, TechniqueImage, TechniqueRow, TechniqueTable};
pub(crate) use tile::{FilmTile, NextFilm};
pub use view::View;

/// Number of bounce layers (the tail not counted) where nothing else is asked for.
pub const DEFAULT_LAYERS: usize = 8;
