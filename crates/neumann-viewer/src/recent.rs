//! Scenes and states opened lately, kept from one start to the next: one path a line.

use std::path::PathBuf;

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
        let file = config_folder().map(|folder| folder.join("neumann").join("recent.txt"));
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
        let path = std::fs::canonicalize(path)
            .map_or_else(|_| path.to_owned(), |p| p.display().to_string());
        self.paths.retain(|p| *p != path);
        self.paths.insert(0, path);
        self.paths.truncate(N_KEPT);
        let Some(file) = &self.file else { return };
        // A list that cannot be kept is no reason to trouble anybody.
        let _ = file
            .parent()
            .map_or(Ok(()), std::fs::create_dir_all)
            .and_then(|()| std::fs::write(file, self.paths.join("\n") + "\n"));
    }
}

/// Where programs keep what they remember about their user.
fn config_folder() -> Option<PathBuf> {
    let var = |name| {
        std::env::var_os(name)
            .map(PathBuf::from)
            .filter(|p| p.is_absolute())
    };
    if cfg!(target_os = "windows") {
        var("APPDATA")
    } else if cfg!(target_os = "macos") {
        var("HOME").map(|home| home.join("Library/Application Support"))
    } else {
        var("XDG_CONFIG_HOME").or_else(|| var("HOME").map(|home| home.join(".config")))
    }
}
