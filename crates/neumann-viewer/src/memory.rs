//! What the window remembers from one start to the next: small text files in the user's folder of
//! settings, and what can be made again in that of caches.

use std::io::Write;
use std::path::PathBuf;

use neumann_picture::files::write_atomically;

/// Path of a file of that name; `None` where there is no such folder.
pub(crate) fn file(name: &str) -> Option<PathBuf> {
    config_folder().map(|folder| folder.join("neumann").join(name))
}

/// Folder of what can be made again, by its name; `None` where there is none.
pub(crate) fn cache(name: &str) -> Option<PathBuf> {
    cache_folder().map(|folder| folder.join("neumann").join(name))
}

/// Writes such a file, whole or not at all. What cannot be kept is no reason to trouble anybody.
pub(crate) fn keep(file: &std::path::Path, text: &str) {
    let _ = file.parent().map(std::fs::create_dir_all);
    let _ = write_atomically(file, |writer| Ok(writer.write_all(text.as_bytes())?));
}

/// A scene as it is remembered: a built-in scene's name, or a path that means the same from every
/// folder.
pub(crate) fn lasting(scene: &str) -> String {
    std::fs::canonicalize(scene).map_or_else(|_| scene.to_owned(), |p| p.display().to_string())
}

/// A folder that the environment names.
fn var(name: &str) -> Option<PathBuf> {
    std::env::var_os(name)
        .map(PathBuf::from)
        .filter(|p| p.is_absolute())
}

/// Where programs keep what they can make again.
fn cache_folder() -> Option<PathBuf> {
    if cfg!(target_os = "windows") {
        var("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        var("HOME").map(|home| home.join("Library/Caches"))
    } else {
        var("XDG_CACHE_HOME").or_else(|| var("HOME").map(|home| home.join(".cache")))
    }
}

/// Where programs keep what they remember about their user.
fn config_folder() -> Option<PathBuf> {
    if cfg!(target_os = "windows") {
        var("APPDATA")
    } else if cfg!(target_os = "macos") {
        var("HOME").map(|home| home.join("Library/Application Support"))
    } else {
        var("XDG_CONFIG_HOME").or_else(|| var("HOME").map(|home| home.join(".config")))
    }
}
