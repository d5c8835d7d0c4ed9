//! `neumann view`: the window.

#[cfg(not(feature = "window"))]
use crate::cli::ViewArguments;
#[cfg(not(feature = "window"))]
use crate::failure::Outcome;
#[cfg(not(feature = "window"))]
use crate::suggest::check_scene;

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
    arguments.scene.as_deref().map_or(Ok(()), check_scene)?;
    Err(anyhow::anyhow!(
        "{NO_WINDOW}; use 'neumann render' or 'neumann series'"
    ))
}
