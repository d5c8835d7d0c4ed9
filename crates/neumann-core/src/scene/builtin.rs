//! The scenes that come with the program, and opening any scene by name or path.

use std::path::Path;

use super::description::{DefaultSky, SceneDescription};
use super::load::{self, LoadError, LoadOptions};

/// A scene that comes with the program.
#[derive(Clone, Copy)]
pub struct Builtin {
    /// Its name.
    pub name: &'static str,
    /// What it is there to show.
    pub about: &'static str,
    glb: &'static [u8],
}

macro_rules! builtins {
    ($($name:literal: $about:literal),* $(,)?) => {
        &[$(Builtin {
            name: $name,
            about: $about,
            glb: include_bytes!(concat!("../../../../assets/scenes/", $name, ".glb")),
        }),*]
    };
}

/// All of them.
pub static BUILTINS: &[Builtin] = builtins! {
    "cornell": "the classic: exact Lambert, one area light",
    "cornell-glass": "mirror and glass sphere: caustics and specular paths",
    "bleed": "colour bleeding: strong higher bounces",
    "plates": "Veach's four glossy plates and lights of several sizes: why MIS",
    "lamps": "light that reaches the room mostly off shade and ceiling: why bidirectional",
    "caustic": "glass over a diffuse floor, small light",
    "pool": "tiles under rippled water, small light: specular-diffuse-specular paths",
    "furnace": "closed sphere, emission 1, albedo 0.5: T^k L_e is 0.5^k exactly",
    "sky": "objects under an environment map",
    "many": "a few hundred small lights",
};

static SKY: &[u8] = include_bytes!("../../../../assets/scenes/sky.hdr");

impl std::fmt::Debug for Builtin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Builtin").field(&self.name).finish()
    }
}

/// The built-in scene of that name.
#[must_use]
pub fn builtin(name: &str) -> Option<&'static Builtin> {
    BUILTINS.iter().find(|b| b.name == name)
}

impl Builtin {
    /// Its description.
    ///
    /// # Errors
    /// Never for the scenes as they come; the loader is the one for files.
    pub fn load(&self) -> Result<SceneDescription, LoadError> {
        let mut description = load::load_bytes(self.name, self.glb, &|uri| {
            (uri == "sky.hdr").then(|| SKY.to_vec())
        })?;
        // They are lit as they are meant to be.
        description.default_sky = DefaultSky::Never;
        // The file's own name is a sentence on what it is there to show.
        self.name.clone_into(&mut description.name);
        Ok(description)
    }
}

/// Opens a built-in scene by its name, or a `.gltf` or `.glb` file by its path.
///
/// # Errors
/// If it is neither, or the file cannot be read as a scene.
pub fn open(name_or_path: &str, options: &LoadOptions) -> Result<SceneDescription, LoadError> {
    match builtin(name_or_path) {
        Some(scene) => scene.load(),
        None => load::load_file(Path::new(name_or_path), options),
    }
}
