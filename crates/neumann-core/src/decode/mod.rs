//! Packed files and streams into numbers, each in the format that they keep.
//!
//! Whatever is decoded is paid for from the process's [`memory`](crate::memory) before it is
//! allocated; decoders of others run under [`quietly`].
//!
//! | file | what it reads |
//! |---|---|
//! | [`meshopt`], [`draco`] | geometry of glTF |
//! | [`bitmap`] | PNG, JPEG, WebP: textures |
//! | [`radiance_hdr`] | Radiance HDR |
//! | [`openexr`] | OpenEXR, layer by layer |
//!
//! Textures and OpenEXR are the crate's feature `pictures`; Radiance HDR is always read.

pub mod bitmap;
pub mod draco;
pub mod meshopt;
#[cfg(feature = "pictures")]
pub mod openexr;
pub mod radiance_hdr;
mod radiances;
mod texels;

use std::panic::{AssertUnwindSafe, catch_unwind};

use thiserror::Error;

pub use radiances::{Radiances, StoredRadiances};
pub use texels::{Indexed, StoredTexels, Texels};

use crate::memory::Shortage;

/// Why something could not be decoded; the text goes on from its name.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum DecodeError {
    /// The file is at fault, or of a kind that cannot be read.
    #[error("{0}")]
    Content(String),
    /// Its format is one of the feature `pictures`, without which the crate was built.
    #[error("cannot be read by this build, whose neumann-core lacks the feature `pictures`")]
    NoDecoder,
    /// The picture does not fit.
    #[error(transparent)]
    Memory(#[from] Shortage),
}

impl DecodeError {
    /// What a decoder of others says.
    pub(crate) fn broken(error: impl std::fmt::Display) -> Self {
        Self::Content(format!("cannot be decoded ({error})"))
    }
}

/// Runs a decoder of others; should it panic on odd bytes, that is an error.
///
/// # Errors
/// Those of the decoder, and its panics.
pub fn quietly<T>(decode: impl FnOnce() -> Result<T, DecodeError>) -> Result<T, DecodeError> {
    catch_unwind(AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err(DecodeError::broken("the decoder gave up")))
}
