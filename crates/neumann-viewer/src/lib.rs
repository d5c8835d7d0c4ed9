//! The window: light transport live, bounce by bounce.
//!
//! Rooms, in reading order: [`options`] says how the window begins; [`app`] owns
//! all state and draws one frame, the same for the window (`window`), for
//! screenshots without a display ([`offscreen`]) and for tests. [`setup`] is what is
//! rendered, [`display`] how it is looked at,
//! [`techniques`] what each technique of a bidirectional method adds; [`render_link`] is the only file that
//! talks to the renderer. [`filmstrip`], [`stage`], [`panels`], [`top_bar`] and
//! [`status`] are what one sees; [`keys`] is the one table of keys.

pub mod app;
pub mod blind_spots;
pub mod camera_control;
pub mod display;
pub mod filmstrip;
pub mod formula;
pub mod gallery;
pub mod help;
pub mod keys;
pub mod latency;
pub mod notices;
pub mod offscreen;
pub mod options;
pub mod panels;
pub mod picture;
pub mod probe;
pub mod recent;
pub mod render_link;
pub mod save;
pub mod scene_source;
pub mod session;
pub mod setup;
pub mod shell;
pub mod stage;
pub mod status;
mod surface;
pub mod techniques;
pub mod theme;
pub mod top_bar;
pub mod viewing;
pub mod widgets;
mod window;

pub use options::{
    CameraOptions, EnvironmentOptions, Exposure, Screenshot, ViewError, ViewOptions,
};

/// Opens the window and stays until it is closed; or draws it to a file, if a screenshot is asked for.
///
/// # Errors
/// If there is no display or no graphics adapter, or the file cannot be written.
pub fn run(options: ViewOptions) -> Result<(), ViewError> {
    if options.screenshot.is_some() {
        offscreen::run(options)
    } else {
        window::run(options, None).map(|_| ())
    }
}
