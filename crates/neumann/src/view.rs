//! `neumann view`: the window.

use std::path::Path;

use neumann_core::scene::builtin::builtin;

#[cfg(not(feature = "window"))]
use crate::cli::ViewArguments;
use crate::failure::{Outcome, bad_input};

#[cfg(feature = "window")]
mod window;

/// Why no window was opened.
pub(crate) enum NoWindow {
    /// There can be none here: what is missing, and the remedy.
    Impossible(String),
    /// Something went wrong.
    #[cfg_attr(
        not(feature = "window"),
        expect(dead_code, reason = "without a window nothing goes wrong with it")
    )]
    Failed(anyhow::Error),
}

/// Refuses what is neither a built-in scene nor a file, before a window opens.
pub(crate) fn check_scene(scene: &str) -> Outcome {
    if builtin(scene).is_some() || Path::new(scene).exists() {
        return Ok(());
    }
    Err(bad_input(format!(
        "{scene}: neither a built-in scene nor a file; 'neumann list scenes' and 'neumann --help' show what there is"
    )))
}

#[cfg(feature = "window")]
pub(crate) use window::{open, run};

#[cfg(not(feature = "window"))]
const NO_WINDOW: &str = "this build has no window (build it with the feature 'window')";

/// Opens the window with a scene.
#[cfg(not(feature = "window"))]
pub(crate) fn open(_scene: &str) -> Result<(), NoWindow> {
    Err(NoWindow::Impossible(NO_WINDOW.to_owned()))
}

#[cfg(not(feature = "window"))]
pub(crate) fn run(arguments: &ViewArguments) -> Outcome {
    check_scene(&arguments.scene)?;
    Err(anyhow::anyhow!(
        "{NO_WINDOW}; use 'neumann render' or 'neumann series'"
    ))
}
