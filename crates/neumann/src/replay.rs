//! `neumann replay`: by which paths light has come to a pixel.

use neumann_core::radiometry::Rgb;
use neumann_core::render::{Renderer, Replayed};
use neumann_core::scene::Scene;
use neumann_picture::inspection;
use serde_json::{Value, json};

use crate::cli::ReplayArguments;
use crate::console;
use crate::failure::Outcome;
use crate::interrupt;
use crate::paths;
use crate::progress::while_waiting;

pub(crate) fn run(arguments: &ReplayArguments) -> Outcome {
    let (scene, settings) = arguments.settings.resolve(&arguments.scene)?;
    paths::check_pixel(arguments.pixel, &settings)?;
    let pool = arguments.settings.pool()?;
    let renderer = Renderer::new(scene.clone(), settings, pool, 0);
    let cancel = interrupt::token();
    let replayed = while_waiting("walking the paths once more", || {
        renderer.replay(arguments.iteration, &[arguments.pixel], &cancel)
    })?;
    let paths: Vec<Replayed> = replayed.into_iter().flatten().collect();
    if arguments.json {
        return console::json(&as_json(arguments, &scene, &paths));
    }
    console::result(&as_text(&paths))
}

/// A line for each contribution, then the sums.
fn as_text(paths: &[Replayed]) -> String {
    let mut lines =
        vec!["bounce  technique  value (R G B)                   weight  path".to_owned()];
    for path in paths {
        let contribution = &path.contribution;
        lines.push(format!(
            "{:>6}  {:<9}  {}  {:>6.4}  {}",
            contribution.bounce,
            paths::technique(contribution.strategy),
            paths::color(path.value()),
            contribution.mis_weight,
            inspection::path(path)
        ));
    }
    let n_bounces = paths.iter().map(|path| path.contribution.bounce + 1).max();
    for bounce in 0..n_bounces.unwrap_or(0) {
        let of_bounce = paths
            .iter()
            .filter(|path| path.contribution.bounce == bounce);
        let (n, sum) = sum(of_bounce);
        if n > 0 {
            lines.push(format!(
                "T{bounce:<5}  sum        {}  of {n}",
                paths::color(sum)
            ));
        }
    }
    let (n, sum) = sum(paths.iter());
    lines.push(format!("L       sum        {}  of {n}", paths::color(sum)));
    lines.join("\n")
}

fn sum<'a>(paths: impl Iterator<Item = &'a Replayed>) -> (usize, Rgb) {
    paths.fold((0, Rgb::BLACK), |(n, sum), path| {
        (n + 1, sum + path.value())
    })
}

fn as_json(arguments: &ReplayArguments, scene: &Scene, paths: &[Replayed]) -> Value {
    let contributions = paths.iter().map(|path| paths::json(scene, path));
    let contributions: Vec<Value> = contributions.collect();
    json!({
        "scene": scene.name(),
        "integrator": arguments.settings.integrator,
        "seed": arguments.settings.seed,
        "iteration": arguments.iteration,
        "pixel": arguments.pixel,
        "value": sum(paths.iter()).1.to_array(),
        "contributions": contributions,
    })
}
