//! What can go wrong while a scene is read, in one line each.
//!
//! Every message names the file, the field (as `accessors[3].count`), what is
//! wrong with it and what to do. Inside of the loader a [`Fault`] knows no
//! file; the public functions add it.

use std::fmt::{self, Display, Formatter};

use thiserror::Error;

use crate::decode::DecodeError;
use crate::memory::{REMEDY, Shortage};

/// Advice for files that contradict themselves.
pub(super) const EXPORT_AGAIN: &str =
    "the file is damaged or its exporter is at fault: fetch or export it again";

/// Why a scene, or an environment map, could not be read.
///
/// Its text is one line: file, field, problem, remedy.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub struct LoadError {
    /// The file, as it was named to the loader.
    pub file: String,
    /// Where in the file, as `accessors[3].count`; empty for the file as a whole.
    pub field: String,
    /// What is wrong.
    pub problem: String,
    /// What to do about it.
    pub remedy: String,
}

impl Display for LoadError {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let colon = if self.field.is_empty() { "" } else { ": " };
        let line = format!(
            "{}: {}{colon}{}; {}",
            self.file, self.field, self.problem, self.remedy
        );
        f.write_str(&one_line(&line))
    }
}

/// A [`LoadError`] that does not know its file yet.
#[derive(Clone, Debug)]
pub(super) struct Fault {
    pub(super) field: String,
    pub(super) problem: String,
    pub(super) remedy: String,
}

impl Fault {
    /// A fault of the named field.
    pub(super) fn new(
        field: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            field: field.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// A field that contradicts the format or the rest of the file.
    pub(super) fn broken(field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::new(field, problem, EXPORT_AGAIN)
    }

    /// What does not fit into memory; `name` says what, empty for the field itself.
    pub(super) fn short(field: impl Into<String>, name: &str, shortage: Shortage) -> Self {
        let space = if name.is_empty() { "" } else { " " };
        Self::new(field, format!("{name}{space}{shortage}"), REMEDY)
    }

    /// What could not be decoded; `name` says what, as of [`Self::short`], and `remedy` what to do
    /// about its content.
    pub(super) fn undecoded(
        field: impl Into<String>,
        name: &str,
        error: DecodeError,
        remedy: &str,
    ) -> Self {
        let space = if name.is_empty() { "" } else { " " };
        let remedy = match error {
            DecodeError::Memory(shortage) => return Self::short(field, name, shortage),
            DecodeError::Content(_) => remedy,
            DecodeError::NoDecoder => "build it with that feature",
        };
        Self::new(field, format!("{name}{space}{error}"), remedy)
    }

    /// Adds the file's name.
    pub(super) fn in_file(self, file: &str) -> LoadError {
        LoadError {
            file: file.to_owned(),
            field: self.field,
            problem: self.problem,
            remedy: self.remedy,
        }
    }

    /// Field and problem without the remedy, for warnings.
    pub(super) fn what(&self) -> String {
        if self.field.is_empty() {
            self.problem.clone()
        } else {
            format!("{}: {}", self.field, self.problem)
        }
    }
}

/// A name from the file, quoted, short and without control characters.
pub(super) fn quoted(name: &str) -> String {
    const LONGEST: usize = 80;
    let mut short: String = name.chars().take(LONGEST).collect();
    if short.len() < name.len() {
        short.push('…');
    }
    format!("\"{}\"", one_line(&short))
}

/// The text with control characters (line ends, escape codes) replaced.
pub(super) fn one_line(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Fault, quoted};

    #[test]
    fn message_is_one_line_with_file_field_problem_and_remedy() {
        let error = Fault::new("accessors[3].count", "is\n-1", "fix it").in_file("a.gltf");
        assert_eq!(
            error.to_string(),
            "a.gltf: accessors[3].count: is -1; fix it"
        );
        let whole = Fault::new("", "is empty", "fix it").in_file("a.gltf");
        assert_eq!(whole.to_string(), "a.gltf: is empty; fix it");
    }

    #[test]
    fn long_names_are_cut() {
        assert!(quoted(&"x".repeat(1000)).chars().count() < 90);
        assert_eq!(quoted("a\u{1b}b"), "\"a b\"");
    }
}
