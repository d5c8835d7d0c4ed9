//! Layered OpenEXR files: a film and its history.
//!
//! One part, one flat list of channels, as tev, DJV, Nuke and `OpenImageIO` expect:
//!
//! | channels | content |
//! |---|---|
//! | `R G B` | L, the mean of all iterations |
//! | `T0.R … T7.B`, `tail.R …` | the terms, and everything beyond them; they add up to L |
//! | `variance.R …` | estimated variance of `R G B`: of the mean, not of one iteration |
//! | `albedo.R …`, `normal.X …`, `depth.Z` | what the camera sees first |
//! | `expression.NAME.R …` | a class of paths, on request |
//! | `light.NAME.R …`, `light.NAME.T1.R …` | the light of a source, on request, and its terms |
//! | `mix.R …` | L with the light of each source multiplied, on request |
//!
//! Floats of 32 bits (16 on request), ZIP compression over 16 rows, no loss. The header says how
//! the picture was made ([`Metadata`]) and how its iterations spread (`spread`), so such a file is
//! also the checkpoint of its render, with a checksum for every channel (`checksum`). Files of
//! other programs are read for their `R G B` (or `Y`) and their layers.

mod beside;
mod checksum;
mod difference;
mod metadata;
mod planes;
mod ranges;
mod read;
mod spread;
mod write;

pub use beside::Beside;
pub use difference::Difference;
pub use metadata::{Metadata, appearance_text, camera_text, environment_text};
pub(crate) use planes::channel_name;
pub use ranges::IterationRanges;
pub use read::{Checkpoint, is_panorama, read_exr, read_layer, read_layers, read_metadata};
pub use write::{
    Clamped, Precision, write_exr, write_exr_as, write_image_exr, write_techniques_exr,
};
pub(crate) use write::{layer_names, layer_of};

#[cfg(test)]
mod tests;
