//! Scenes and states opened lately, kept from one start to the next: one path a line.

use std::path::PathBuf;

use crate::memory;

/// Paths of scenes and states, latest first.
#[derive(Clone, Debug, Default)]
pub struct Recent {
    paths: Vec<String>,
    /// Where they are kept; `None` keeps them for this run only.
    file: Option<PathBuf>,
}

const N_KEPT: usize = 8;

impl Recent {
    /// Those of earlier runs.
    #[must_use]
    pub fn load() -> Self {
        let file = memory::file("recent.txt");
        let text = file
            .as_ref()
            .and_then(|file| std::fs::read_to_string(file).ok())
            .unwrap_or_default();
        Self {
            paths: text.lines().take(N_KEPT).map(str::to_owned).collect(),
            file,
        }
    }

    /// The paths, latest first.
    #[must_use]
    pub fn paths(&self) -> &[String] {
        &self.paths
    }

    /// Puts a path first.
    pub fn add(&mut self, path: &str) {
        let path = memory::lasting(path);
        self.paths.retain(|p| *p != path);
        self.paths.insert(0, path);
        self.paths.truncate(N_KEPT);
        if let Some(file) = &self.file {
            memory::keep(file, &(self.paths.join("\n") + "\n"));
        }
    }
}
