//! `neumann` alone: the window, or what can be done without one.

use std::path::Path;

use neumann_core::scene::builtin::builtin;

use crate::console;
use crate::failure::Outcome;
use crate::interrupt;
use crate::options::{DisplayOptions, Exposure, GoalOptions, SettingsOptions};
use crate::render::{completeness, refuse_empty, summary};
use crate::series;
use crate::session::{Goal, Session};
use crate::suggest::check_scene_or_subcommand;
use crate::view::{self, NoWindow};

/// The scene where none is named.
const DEFAULT_SCENE: &str = "cornell";
/// Where pictures go if there is no window.
const FOLDER: &str = "neumann-out";

pub(crate) fn run(scene: Option<&str>) -> Outcome {
    let scene = scene.unwrap_or(DEFAULT_SCENE);
    check_scene_or_subcommand(scene)?;
    match view::open(scene) {
        Ok(()) => Ok(()),
        Err(NoWindow::Impossible(reason)) => {
            console::note(&format!("{reason}; rendering to ./{FOLDER} instead"));
            render(scene)
        }
        Err(NoWindow::Failed(error)) => Err(error),
    }
}

fn render(scene: &str) -> Outcome {
    let folder = Path::new(FOLDER);
    series::make_folder(folder)?;
    let options = SettingsOptions::defaults();
    let is_builtin = builtin(scene).is_some();
    let name = scene;
    let (scene, settings) = options.resolve(name)?;
    let session = Session {
        classes: None,
        state: Box::new(options.state(name, &scene, &settings)),
        scene,
        settings,
        pool: options.pool()?,
        goal: Goal::of(&GoalOptions::default())?,
        technique_divisor: None,
        draws_photons: false,
    };
    session.check()?;
    let rendered = session.render(None, None, None, &interrupt::token());
    refuse_empty(&rendered)?;
    let display = DisplayOptions {
        exposure: (!is_builtin).then_some(Exposure::Auto),
        ..DisplayOptions::default()
    };
    let display = display.display(|| rendered.film.total());
    let outputs = series::write(folder, &rendered, &[], display)?;
    console::note(&summary(&rendered));
    console::note(&format!(
        "wrote {} files to ./{FOLDER}; ./{FOLDER}/sheet.png shows the whole series",
        outputs.len()
    ));
    completeness(&rendered)
}
