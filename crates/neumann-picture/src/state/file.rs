//! State files: JSON, read with care and written whole or not at all.

use std::fmt;
use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use neumann_core::memory::free_bytes;
use neumann_core::scene::SkyChoice;
use neumann_core::scene::builtin::builtin;
use serde_json::Value;

use super::{EnvironmentState, State};
use crate::PictureError;
use crate::exr_file::read_metadata;
use crate::files::{film_bytes, write_atomically};

/// A state file cannot be used.
#[derive(Debug, PartialEq, Eq)]
pub struct StateError {
    /// The file.
    pub path: PathBuf,
    /// The field that is wrong; empty where it is the file itself.
    pub field: String,
    /// What is wrong with it, and what to do.
    pub what: String,
}

impl fmt::Display for StateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.path.display())?;
        if !self.field.is_empty() {
            write!(f, "{}: ", self.field)?;
        }
        write!(f, "{}", self.what)
    }
}

impl std::error::Error for StateError {}

/// A larger file is no state.
const MAX_BYTES: u64 = 4 << 20;

impl State {
    /// Reads a state file, or the header of an .exr that the window saved, and what is odd about
    /// it. Paths in it are taken from its own folder.
    ///
    /// # Errors
    /// If it cannot be read, a field is not what it should be, or the scene's file is not there.
    pub fn read(path: &Path) -> Result<(Self, Vec<String>), StateError> {
        let is_picture = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        let folder = path.parent().unwrap_or(Path::new(""));
        if is_picture {
            let state = Self::of_picture(path)?.placed(path, folder)?;
            return Ok((state, Vec::new()));
        }
        Self::from_text(&Self::text_of(path)?, path, folder)
    }

    /// Reads a state from what is no file, and what is odd about it; `name` is what errors call it.
    /// Paths in it are taken from the current folder.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_from(reader: impl Read, name: &str) -> Result<(Self, Vec<String>), StateError> {
        let name = Path::new(name);
        Self::from_text(&limited_text(reader, name)?, name, Path::new(""))
    }

    fn from_text(
        text: &str,
        path: &Path,
        folder: &Path,
    ) -> Result<(Self, Vec<String>), StateError> {
        let (state, mut warnings) = Self::parse(text).map_err(|(field, what)| StateError {
            path: path.to_owned(),
            field,
            what,
        })?;
        let state = state.placed(path, folder)?;
        for warning in &mut warnings {
            *warning = format!("{}: {warning}", path.display());
        }
        Ok((state, warnings))
    }

    /// With its paths taken from `folder`, if what it asks for is there.
    fn placed(mut self, path: &Path, folder: &Path) -> Result<Self, StateError> {
        let error = |field: &str, what: String| StateError {
            path: path.to_owned(),
            field: field.to_owned(),
            what,
        };
        self.resolve(folder);
        self.check_scene().map_err(|what| error("scene", what))?;
        let sized = if self.size.is_some() {
            "size"
        } else {
            "region.of"
        };
        self.check_memory().map_err(|what| error(sized, what))?;
        Ok(self)
    }

    /// The state in the header of a picture.
    fn of_picture(path: &Path) -> Result<Self, StateError> {
        let error = |what: String| StateError {
            path: path.to_owned(),
            field: String::new(),
            what,
        };
        let metadata = read_metadata(path).map_err(|cause| {
            let cause = cause.to_string();
            let name = format!("{}: ", path.display());
            error(cause.strip_prefix(&name).unwrap_or(&cause).to_owned())
        })?;
        let state = metadata.state.map(|state| *state);
        state.ok_or_else(|| {
            let what =
                "no state in its header; 'neumann render' and Ctrl Shift E in the window write one";
            error(what.to_owned())
        })
    }

    /// The text of a state file.
    fn text_of(path: &Path) -> Result<String, StateError> {
        match File::open(path) {
            Ok(file) => limited_text(file, path),
            Err(cause) => Err(StateError {
                path: path.to_owned(),
                field: String::new(),
                what: format!("cannot read: {cause}"),
            }),
        }
    }

    /// Reads a state from its text, and what is odd about it; the field and what is wrong with it
    /// otherwise.
    ///
    /// # Errors
    /// If it is not JSON, or a field is not what it should be.
    pub fn parse(text: &str) -> Result<(Self, Vec<String>), (String, String)> {
        let mut reader = serde_json::Deserializer::from_str(text);
        let state: Self = serde_path_to_error::deserialize(&mut reader).map_err(|error| {
            let field = match error.path().to_string() {
                path if path == "." => String::new(),
                path => path,
            };
            let cause = error.into_inner();
            let remedy = if cause.is_data() {
                "mend it, or leave it out"
            } else {
                "not the JSON of a state; Ctrl Shift S in the window writes one, Ctrl Shift C \
                 copies one"
            };
            (field, format!("{cause}; {remedy}"))
        })?;
        reader.end().map_err(|cause| {
            let what = format!("{cause}; take away what follows the state");
            (String::new(), what)
        })?;
        let mut warnings = state.check()?;
        let whole: Value = serde_json::from_str(text).unwrap_or_default();
        let known = serde_json::to_value(&state).unwrap_or_default();
        for field in unknown("", &whole, &known) {
            warnings.push(format!("{field}: there is no such field; it is ignored"));
        }
        Ok((state, warnings))
    }

    /// As the text of a file.
    #[must_use]
    pub fn to_text(&self) -> String {
        // Only maps with odd keys cannot be written, and there are none.
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        text + "\n"
    }

    /// As a text of one line.
    #[must_use]
    pub fn to_line(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Writes a state file.
    ///
    /// # Errors
    /// If the place cannot be written to.
    pub fn write(&self, path: &Path) -> Result<(), PictureError> {
        let text = self.to_text();
        write_atomically(path, |writer| Ok(writer.write_all(text.as_bytes())?))
    }

    /// Takes relative paths from `folder`.
    fn resolve(&mut self, folder: &Path) {
        if builtin(&self.scene).is_none() {
            self.scene = folder.join(&self.scene).display().to_string();
        }
        if self.environment.sky != EnvironmentState::OWN
            && let SkyChoice::File(map) = SkyChoice::from_word(&self.environment.sky)
        {
            self.environment.sky = folder.join(map).display().to_string();
        }
    }

    fn check_memory(&self) -> Result<(), String> {
        let size = self.size.or(self.region.map(|region| region.of));
        let (Some([width, height]), Some(free)) = (size, free_bytes()) else {
            return Ok(());
        };
        let needed = film_bytes(width, height, self.layers);
        if needed <= free {
            return Ok(());
        }
        Err(format!(
            "a film of {width}x{height} with {} layers needs {:.1} GB, but {:.1} GB of memory are \
             free; choose a smaller size or fewer layers",
            self.layers,
            needed as f64 * 1e-9,
            free as f64 * 1e-9
        ))
    }

    fn check_scene(&self) -> Result<(), String> {
        if builtin(&self.scene).is_some() || Path::new(&self.scene).exists() {
            return Ok(());
        }
        Err(format!(
            "there is no file {}; put the scene there, or name another one",
            self.scene
        ))
    }
}

/// All that there is to read, as the text of a state.
fn limited_text(reader: impl Read, path: &Path) -> Result<String, StateError> {
    let error = |what: String| StateError {
        path: path.to_owned(),
        field: String::new(),
        what,
    };
    let mut text = String::new();
    match reader.take(MAX_BYTES + 1).read_to_string(&mut text) {
        Err(cause) => Err(error(format!("cannot read: {cause}"))),
        Ok(n) if n as u64 > MAX_BYTES => {
            let what = "too large for a state file; Ctrl Shift S in the window writes one";
            Err(error(what.to_owned()))
        }
        Ok(_) => Ok(text),
    }
}

/// The fields of `whole` that `known` lacks, with the way to them.
fn unknown(way: &str, whole: &Value, known: &Value) -> Vec<String> {
    match (whole, known) {
        (Value::Object(whole), Value::Object(known)) => {
            let fields = whole.iter().flat_map(|(name, value)| {
                let way = if way.is_empty() {
                    name.clone()
                } else {
                    format!("{way}.{name}")
                };
                match known.get(name) {
                    Some(known) => unknown(&way, value, known),
                    None => vec![way],
                }
            });
            fields.collect()
        }
        (Value::Array(whole), Value::Array(known)) => {
            let pairs = whole.iter().zip(known).enumerate();
            pairs
                .flat_map(|(i, (whole, known))| unknown(&format!("{way}[{i}]"), whole, known))
                .collect()
        }
        _ => Vec::new(),
    }
}
