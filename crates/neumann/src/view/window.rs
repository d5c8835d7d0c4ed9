//! From the command line to the window.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use neumann_core::render::StopRule;
use neumann_core::scene::SkyChoice;
use neumann_picture::state::State;
use neumann_viewer::{CameraOptions, EnvironmentOptions, Screenshot, ViewError, ViewOptions};

use super::NoWindow;
use crate::cli::ViewArguments;
use crate::console;
use crate::failure::{OrBadInput, Outcome, bad_input};
use crate::options::Exposure;
use crate::outputs;
use crate::session::check_film;
use crate::suggest::check_scene;

/// Opens the window with a scene.
pub(crate) fn open(scene: &str) -> Result<(), NoWindow> {
    let options = ViewOptions {
        scene: scene.to_owned(),
        ..ViewOptions::default()
    };
    neumann_viewer::run(options).map_err(no_window)
}

/// What is missing, and the remedy; the libraries' own words are of no help to anybody here.
fn no_window(error: ViewError) -> NoWindow {
    match error {
        ViewError::NoDisplay(_) => NoWindow::Impossible(
            "no display to open a window on; set DISPLAY or WAYLAND_DISPLAY".to_owned(),
        ),
        ViewError::NoAdapter(_) => NoWindow::Impossible(
            "no graphics adapter; install a Vulkan driver (on Debian: apt install \
             mesa-vulkan-drivers)"
                .to_owned(),
        ),
        error @ ViewError::TooLarge { .. } => NoWindow::Failed(bad_input(error)),
        error @ (ViewError::Gone | ViewError::Other(_)) => NoWindow::Failed(error.into()),
    }
}

pub(crate) fn run(arguments: &ViewArguments) -> Outcome {
    arguments.scene.as_deref().map_or(Ok(()), check_scene)?;
    let state = arguments.state.as_deref().map(read_state).transpose()?;
    if let Some(path) = &arguments.screenshot {
        if outputs::kind(path)? != outputs::Kind::Png {
            return Err(bad_input("--screenshot: use a name that ends in .png"));
        }
        let path = std::slice::from_ref(path);
        outputs::check(path)?;
        let scene = arguments
            .scene
            .as_ref()
            .or(state.as_ref().map(|s| &s.scene));
        let inputs = scene.map(PathBuf::from);
        outputs::refuse_inputs(path, inputs.iter().chain(&arguments.state))?;
        let sky = arguments.settings.environment.env.as_ref();
        outputs::refuse_inputs(path, sky.and_then(SkyChoice::file))?;
    }
    if let Some((width, height)) = arguments.settings.size {
        let layers = state.as_ref().map(|state| state.layers);
        let layers = layers.unwrap_or(arguments.settings.layers as usize);
        check_film(width, height, layers)?;
    }
    let options = ViewOptions {
        state: state.map(Box::new),
        ..options(arguments)?
    };
    neumann_viewer::run(options).map_err(|error| match no_window(error) {
        NoWindow::Impossible(what) => {
            anyhow!("{what}, or use 'neumann render' or 'neumann series'")
        }
        NoWindow::Failed(error) => error,
    })
}

/// Reads a state; what is odd about it is told.
fn read_state(path: &Path) -> Outcome<State> {
    let read = match path.to_str() {
        Some("-") => State::read_from(std::io::stdin().lock(), "standard input"),
        _ => State::read(path),
    };
    let (state, warnings) = read.or_bad_input()?;
    for warning in warnings {
        console::note(&format!("warning: {warning}"));
    }
    Ok(state)
}

fn options(arguments: &ViewArguments) -> Outcome<ViewOptions> {
    let (settings, camera) = (&arguments.settings, &arguments.settings.camera);
    let environment = &settings.environment;
    let stop = match (arguments.iterations, arguments.time) {
        (Some(n), None) => StopRule::Iterations(n),
        (None, Some(seconds)) => StopRule::Seconds(seconds),
        (None, None) => StopRule::Never,
        (Some(_), Some(_)) => {
            return Err(bad_input(
                "--iterations and --time: the window stops by one of them",
            ));
        }
    };
    let screenshot = match &arguments.screenshot {
        None => None,
        Some(path) => Some(Screenshot {
            path: path.clone(),
            after_iterations: arguments.after,
            size: (
                u32::try_from(arguments.window_size.0)?,
                u32::try_from(arguments.window_size.1)?,
            ),
            light_theme: arguments.light_theme,
        }),
    };
    Ok(ViewOptions {
        scene: arguments.scene.clone().unwrap_or_default(),
        state: None,
        integrator: Some(settings.integrator.clone()),
        set: settings.set.clone(),
        camera: CameraOptions {
            camera: camera.camera.clone(),
            eye: camera.eye,
            target: camera.target,
            up: camera.up,
            fov: camera.fov,
            aperture: camera.aperture,
            focus: camera.focus,
        },
        environment: EnvironmentOptions {
            sky: environment.env.clone(),
            intensity: environment.env_intensity,
            rotation: environment.env_rotation,
        },
        backs: settings.backs,
        max_bounces: Some(settings.max_bounces),
        layers: Some(settings.layers as usize),
        seed: Some(settings.seed),
        size: settings.size,
        stop,
        part: arguments.view.part(),
        quantity: arguments.view.quantity(),
        exposure: match arguments.display.exposure {
            None => neumann_viewer::Exposure::ForScene,
            Some(Exposure::Stops(stops)) => neumann_viewer::Exposure::Stops(stops),
            Some(Exposure::Auto) => neumann_viewer::Exposure::Auto,
        },
        tone: arguments.display.tone,
        threads: settings.threads.map(|n| n as usize),
        screenshot,
        allow_outside: settings.load.allow_outside,
        allow_hidden: settings.load.allow_hidden,
    })
}
