//! Reads glTF files into a [`SceneDescription`].
//!
//! Any bytes end in a description or in a [`LoadError`] that names file, field,
//! problem and remedy: never in a panic, and never with more memory or time
//! than in proportion to what the files hold. So this reader works on the plain
//! JSON with checked accessors of its own, one concern a file:
//!
//! | file | what it knows |
//! |---|---|
//! | `container`, `json` | GLB chunks; typed access to JSON |
//! | `extension`, `ignored` | what is honoured, and what is lost where it is not |
//! | `source`, `uri` | files, data URIs, what may be read |
//! | `buffer`, `meshopt`, `accessor`, `allowance` | typed arrays, and how much of them |
//! | `node`, `instancing` | hierarchy, transforms, visibility, copies |
//! | `mesh`, `draco`, `topology`, `morph`, `skin` | primitives into triangles |
//! | `material`, `texture`, `picture`, `factor` | looks |
//! | `light`, `camera`, `environment` | both ends of a path |
//!
//! Left out, with a note in the report: animations (the pose of the file is
//! shown), points and lines, KTX2 textures.

mod accessor;
mod allowance;
mod assemble;
mod buffer;
mod camera;
mod container;
mod draco;
mod environment;
mod error;
mod extension;
mod factor;
mod ignored;
mod instancing;
mod json;
mod light;
mod material;
mod mesh;
mod meshopt;
mod morph;
mod node;
mod notes;
mod picture;
mod skin;
mod source;
#[cfg(test)]
mod tests;
mod texture;
mod topology;
mod uri;

use std::path::Path;

use self::allowance::Allowance;
use self::buffer::Buffers;
use self::error::{Fault, one_line};
use self::json::Document;
use self::source::Source;
use super::OpeningProgress;
use super::description::{EnvironmentDescription, SceneDescription};
use crate::memory::Share;

pub use self::error::LoadError;

/// What a scene file may do.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Lets relative URIs, and symbolic links, leave the scene's folder.
    ///
    /// Absolute paths, other schemes than `data:` and anything but regular
    /// files stay refused.
    pub allow_outside: bool,
    /// Lets relative URIs, and symbolic links, lead to files and through folders whose names
    /// begin with a point; the folder that the scene is in may have any name.
    pub allow_hidden: bool,
    /// Is told how far the file has been read.
    pub progress: OpeningProgress,
}

/// A file while it is read.
#[derive(Debug)]
struct File<'a> {
    document: Document,
    buffers: Buffers<'a>,
    allowance: Allowance,
}

/// Reads a `.gltf` or `.glb` file and everything it refers to.
///
/// # Errors
/// When the file, or a buffer or environment map that it needs, cannot be read
/// or contradicts itself. Images that cannot be read only cost a warning.
pub fn load_file(path: &Path, options: &LoadOptions) -> Result<SceneDescription, LoadError> {
    let name = path.display().to_string();
    let mut memory = Share::default();
    let remedy = "give the path of a .gltf or .glb file";
    let bytes = read_named_file(path, &name, remedy, &mut memory)?;
    Source::beside(path, &bytes, options)
        .and_then(|source| assemble::scene(&name, &bytes, source, &options.progress))
        .map_err(|fault| fault.in_file(&name))
}

/// Reads a scene that is in memory.
///
/// `name` stands for the file in messages; `resolve` yields the bytes behind a
/// relative URI (percent-decoded), or `None`.
///
/// # Errors
/// As [`load_file`].
pub fn load_bytes(
    name: &str,
    bytes: &[u8],
    resolve: &dyn Fn(&str) -> Option<Vec<u8>>,
) -> Result<SceneDescription, LoadError> {
    let unwatched = OpeningProgress::default();
    assemble::scene(name, bytes, Source::memory(bytes, resolve), &unwatched)
        .map_err(|fault| fault.in_file(name))
}

/// An environment map from a file of its own.
#[derive(Clone, Debug)]
pub struct EnvironmentFile {
    /// The map.
    pub environment: EnvironmentDescription,
    /// What the user should know about it, each a sentence that names the file.
    pub warnings: Vec<String>,
}

/// Reads a lat-long environment map, `.hdr` or `.exr`.
///
/// Texels that are negative or not a number become 0, infinite ones the
/// brightest finite value of the map; that is a warning.
///
/// # Errors
/// When the file cannot be read, is neither of the two formats, or does not fit into memory.
pub fn load_environment(path: &Path) -> Result<EnvironmentFile, LoadError> {
    let name = path.display().to_string();
    let mut memory = Share::default();
    let remedy = "give the path of a .hdr or .exr file";
    let bytes = read_named_file(path, &name, remedy, &mut memory)?;
    environment_from_bytes(&name, &bytes)
}

/// Reads an environment map that is in memory; its first bytes tell the format.
///
/// # Errors
/// As [`load_environment`].
pub fn environment_from_bytes(name: &str, bytes: &[u8]) -> Result<EnvironmentFile, LoadError> {
    let decoded = environment::decode(name, bytes).map_err(|fault| fault.in_file(name))?;
    let warnings = decoded.warnings.iter();
    Ok(EnvironmentFile {
        environment: decoded.environment,
        warnings: warnings
            .map(|w| one_line(&format!("{name}: {w}")))
            .collect(),
    })
}

fn read_named_file(
    path: &Path,
    name: &str,
    remedy: &str,
    memory: &mut Share,
) -> Result<Vec<u8>, LoadError> {
    source::read_regular_file(path, source::LARGEST_FILE, memory)
        .map_err(|error| Fault::undecoded("", "", error, remedy).in_file(name))
}
