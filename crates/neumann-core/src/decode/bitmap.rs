//! PNG, JPEG and WebP, in the channels and the depth of their files.
//!
//! The format is told by the first bytes; names and MIME types are often wrong. Gamma, profiles and
//! EXIF turn nothing: glTF says so.

#[cfg(feature = "pictures")]
mod codecs;

use super::texels::Texels;
use super::{DecodeError, quietly};
use crate::memory::Share;

/// A decoded picture.
#[derive(Clone, Debug)]
pub struct Bitmap {
    /// Texels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width` times `height` of them.
    pub texels: Texels,
}

/// What the head of a file says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Texels per row, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// What the decoded texels will take, bytes.
    pub n_bytes: u64,
    /// What the decoder takes beside them while it works, bytes; a bound.
    pub n_working_bytes: u64,
}

/// Reads the head of a file.
///
/// # Errors
/// If it is of no known format, broken, or has no texels.
pub fn header(bytes: &[u8]) -> Result<Header, DecodeError> {
    let header = quietly(|| codecs::header(bytes))?;
    if header.width == 0 || header.height == 0 {
        return Err(DecodeError::Content("has no texels".to_owned()));
    }
    Ok(header)
}

/// Decodes a picture into `memory`, which pays for the `n_bytes` of its [`header`].
///
/// # Errors
/// If it is broken, or the system has no memory for it.
pub fn decode(bytes: &[u8], memory: Share) -> Result<Bitmap, DecodeError> {
    let (width, height, stored) = quietly(|| codecs::decode(bytes))?;
    let texels = Texels::new(stored, memory);
    if !texels.fill(width, height) {
        return Err(DecodeError::Content("has no texels".to_owned()));
    }
    Ok(Bitmap {
        width,
        height,
        texels,
    })
}

/// True if the bytes begin as one of the formats do.
#[must_use]
pub fn is_bitmap(bytes: &[u8]) -> bool {
    codecs::is_known(bytes)
}

/// Stands in for the decoders in a build without them.
#[cfg(not(feature = "pictures"))]
mod codecs {
    use super::{DecodeError, Header};
    use crate::decode::StoredTexels;

    pub(super) fn is_known(_: &[u8]) -> bool {
        false
    }

    pub(super) fn header(_: &[u8]) -> Result<Header, DecodeError> {
        Err(DecodeError::NoDecoder)
    }

    pub(super) fn decode(_: &[u8]) -> Result<(usize, usize, StoredTexels), DecodeError> {
        Err(DecodeError::NoDecoder)
    }
}
