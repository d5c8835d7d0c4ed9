//! What can go wrong with a picture: the file, what, and the remedy.

use std::io;
use std::path::{Path, PathBuf};

use neumann_core::decode::DecodeError;
use neumann_core::memory::REMEDY;

/// A picture could not be read, written or made.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The operating system refused.
    #[error("{}: cannot {action}: {cause}{}", path.display(), remedy(cause))]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried, as in "cannot …".
        action: &'static str,
        /// What the system said.
        cause: io::Error,
    },
    /// The destination is no place for a file.
    #[error("{}: {what}", path.display())]
    Destination {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and what to do.
        what: String,
    },
    /// The content is not what it should be.
    #[error("{}: {what}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and what to do.
        what: String,
    },
    /// No tev listens.
    #[error(
        "{address}: no tev can be reached: {cause}; start tev, or give the address where it listens"
    )]
    NoTev {
        /// Where it was sought.
        address: String,
        /// What the system said.
        cause: io::Error,
    },
    /// A tev has gone.
    #[error("{address}: tev takes no more pictures: {cause}")]
    TevGone {
        /// Where it was.
        address: String,
        /// What the system said.
        cause: io::Error,
    },
    /// Two pictures do not fit each other.
    #[error("{0}")]
    Mismatch(String),
}

impl PictureError {
    pub(crate) fn io(path: &Path, action: &'static str, cause: io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            action,
            cause,
        }
    }

    pub(crate) fn content(path: &Path, what: impl Into<String>) -> Self {
        Self::Content {
            path: path.to_owned(),
            what: what.into(),
        }
    }

    pub(crate) fn decode(path: &Path, error: DecodeError) -> Self {
        let remedy = match error {
            DecodeError::Content(_) => "name a flat picture in .exr, .png, .jpg, .webp or .hdr",
            DecodeError::NoDecoder => "build it with that feature",
            DecodeError::Memory(_) => REMEDY,
        };
        Self::content(path, format!("{error}; {remedy}"))
    }

    pub(crate) fn destination(path: &Path, what: impl Into<String>) -> Self {
        Self::Destination {
            path: path.to_owned(),
            what: what.into(),
        }
    }
}

fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound => "; check the path",
        io::ErrorKind::PermissionDenied => "; choose a place that you may use",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "; free some space or choose another place"
        }
        io::ErrorKind::ReadOnlyFilesystem => "; choose a place that can be written to",
        _ => "",
    }
}
