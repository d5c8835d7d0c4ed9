//! The window: light transport live, bounce by bounce.
//!
//! Rooms, in reading order: [`options`] says how the window begins; [`app`] draws one frame, the
//! same for the window (`window`), for screenshots without a display ([`offscreen`]) and for tests.
//! It holds a [`session`], which is what is rendered ([`setup`]), the line to the renderer
//! ([`render_link`], the only file that talks to it) and the film ([`picture`]); how that is looked
//! at ([`viewing`], [`display`]), beside what it is held against ([`compared`]); and the [`shell`]
//! around it. [`views`] are what can stand on the stage, the picture first. [`filmstrip`],
//! [`panels`], [`top_bar`] and [`status`] are the rest of what one sees; [`keys`] is the one table
//! of keys. [`state`] writes down what has been chosen, and takes it up again. `gone` and `writing`
//! see to a good end when the window is taken away.

pub mod app;
pub mod blind_spots;
pub mod bookmarks;
pub mod camera_control;
pub mod command_line;
pub mod compared;
pub mod display;
pub mod file_list;
pub mod filmstrip;
pub mod flight;
pub mod formula;
pub mod gallery;
mod gone;
pub mod help;
pub mod histogram;
pub mod history;
pub mod keys;
mod memory;
pub mod notices;
pub mod offscreen;
pub mod onlooker;
pub mod options;
pub mod panels;
pub mod pick;
pub mod picture;
pub mod probe;
pub mod recent;
pub mod region;
pub mod render_link;
pub mod save;
pub mod scene_source;
pub mod sending;
pub mod session;
pub mod setup;
pub mod shell;
pub mod state;
pub mod status;
mod surface;
pub mod text_scale;
pub mod theme;
pub mod top_bar;
pub mod viewing;
pub mod views;
pub mod widgets;
mod window;
mod writing;

pub use onlooker::Onlooker;
pub use options::{
    CameraOptions, EnvironmentOptions, Exposure, Screenshot, ViewError, ViewOptions,
};

/// Opens the window and stays until it is closed; or draws it to a file, if a screenshot is asked
/// for.
///
/// # Errors
/// If there is no display or no graphics adapter, or the file cannot be written.
pub fn run(options: ViewOptions) -> Result<(), ViewError> {
    if options.screenshot.is_some() {
        offscreen::run(options)
    } else {
        window::run(options, None)
    }
}

/// Opens the window as [`run`] does, with somebody looking on.
///
/// # Errors
/// As [`run`].
pub fn run_watched(options: ViewOptions, onlooker: &mut dyn Onlooker) -> Result<(), ViewError> {
    window::run(options, Some(onlooker))
}
