//! What the command hands to the window.

use std::path::PathBuf;

use glam::Vec3;
use neumann_core::film::View;
use neumann_core::render::StopRule;
use neumann_core::scene::{Backs, SkyChoice};
use neumann_picture::quantity::Quantity;
use neumann_picture::state::State;
use neumann_picture::tone::ToneCurve;

/// How the window begins.
#[derive(Clone, Debug, Default)]
pub struct ViewOptions {
    /// Name of a built-in scene, or a path; empty for `cornell`.
    pub scene: String,
    /// All that was chosen when a state was saved; stands for scene, method, camera, environment,
    /// backs, depth, view and exposure.
    pub state: Option<Box<State>>,
    /// Id of a method.
    pub integrator: Option<String>,
    /// Parameters of the method, as `--set` gives them.
    pub set: Vec<(String, String)>,
    /// Where the camera stands.
    pub camera: CameraOptions,
    /// Environment in place of the scene's.
    pub environment: EnvironmentOptions,
    /// What the camera makes of the backs of single-sided surfaces.
    pub backs: Backs,
    /// Terms with `k` up to and including this one are computed.
    pub max_bounces: Option<u32>,
    /// Bounce layers kept apart.
    pub layers: Option<usize>,
    /// Seed of all random numbers.
    pub seed: Option<u64>,
    /// Size of the film; otherwise it follows the window.
    pub size: Option<(usize, usize)>,
    /// When rendering is done.
    pub stop: StopRule,
    /// Which part of the series is shown.
    pub part: View,
    /// What stands in place of the picture, if anything.
    pub quantity: Option<Quantity>,
    /// Exposure.
    pub exposure: Exposure,
    /// Tone curve.
    pub tone: ToneCurve,
    /// Threads that render; all that there are, if `None`.
    pub threads: Option<usize>,
    /// Draw the window to a file instead of on a display.
    pub screenshot: Option<Screenshot>,
    /// Let relative URIs leave the scene's folder.
    pub allow_outside: bool,
    /// Let relative URIs lead to hidden files and folders.
    pub allow_hidden: bool,
}

/// How bright radiance is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Exposure {
    /// By itself for a file of the user's own, 0 for a built-in scene, whose lights are made for
    /// it.
    #[default]
    ForScene,
    /// Multiplied by 2 to this power.
    Stops(f32),
    /// By itself.
    Auto,
}

/// A picture of the window itself.
#[derive(Clone, Debug)]
pub struct Screenshot {
    /// The PNG file.
    pub path: PathBuf,
    /// Iterations at full resolution to wait for.
    pub after_iterations: u32,
    /// Size of the window, pixels.
    pub size: (u32, u32),
    /// The light theme.
    pub light_theme: bool,
}

/// Which camera, and what about it is different.
#[derive(Clone, Debug, Default)]
pub struct CameraOptions {
    /// Name or number of a camera of the file.
    pub camera: Option<String>,
    /// Where it stands.
    pub eye: Option<Vec3>,
    /// What it looks at.
    pub target: Option<Vec3>,
    /// What is up for it.
    pub up: Option<Vec3>,
    /// Vertical angle of view, degrees.
    pub fov: Option<f32>,
    /// Diameter of the lens opening, metres.
    pub aperture: Option<f32>,
    /// Distance of what is sharp, metres.
    pub focus: Option<f32>,
}

/// An environment in place of the scene's.
#[derive(Clone, Debug, Default)]
pub struct EnvironmentOptions {
    /// A built-in sky, none, or a map.
    pub sky: Option<SkyChoice>,
    /// Factor.
    pub intensity: Option<f32>,
    /// Turn about the vertical, degrees.
    pub rotation: Option<f32>,
}

impl ViewOptions {
    /// Refuses pictures that a device with textures of at most so many pixels cannot draw.
    pub(crate) fn check_sizes(&self, largest: usize) -> Result<(), ViewError> {
        let picture = self.size.map(|size| ("--size", size));
        let window = self.screenshot.as_ref().map(|shot| {
            let (width, height) = shot.size;
            ("--window-size", (width as usize, height as usize))
        });
        for (option, size) in picture.into_iter().chain(window) {
            if size.0.max(size.1) > largest {
                return Err(ViewError::TooLarge {
                    option,
                    size,
                    largest,
                });
            }
        }
        Ok(())
    }
}

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// There is no display to open a window on.
    #[error(
        "no display to open a window on ({0}); set DISPLAY or WAYLAND_DISPLAY, or use 'neumann \
         render' or 'neumann series'"
    )]
    NoDisplay(String),
    /// There is no graphics adapter, not even a software one.
    #[error(
        "no graphics adapter ({0}); install a Vulkan driver (on Debian a software one is in \
         mesa-vulkan-drivers), or use 'neumann render' or 'neumann series'"
    )]
    NoAdapter(String),
    /// Something is larger than the graphics device can draw.
    #[error(
        "{option} {}x{}: the graphics device draws at most {largest} pixels each way; choose a \
         smaller size",
        size.0, size.1
    )]
    TooLarge {
        /// The option that asked for it.
        option: &'static str,
        /// What was asked for.
        size: (usize, usize),
        /// What can be had.
        largest: usize,
    },
    /// The window went away while it was open.
    #[error("the window is gone: its display has ended, or another program has closed it")]
    Gone,
    /// Something else.
    #[error("{0}")]
    Other(String),
}
