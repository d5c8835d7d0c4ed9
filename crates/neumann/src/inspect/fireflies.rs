//! The pixels that stand out most, and the paths that have made them.

use std::sync::Arc;

use neumann_core::film::{Film, Firefly};
use neumann_core::render::{Inspection, RenderSettings, Renderer};
use neumann_core::scene::Scene;
use neumann_picture::figures::significant;
use neumann_picture::inspection::{self, percent};
use serde_json::{Value, json};

use super::inspect;
use crate::cli::InspectArguments;
use crate::console;
use crate::failure::Outcome;
use crate::interrupt;
use crate::paths;
use crate::progress::while_waiting;

pub(super) fn run(
    arguments: &InspectArguments,
    scene: &Arc<Scene>,
    settings: RenderSettings,
) -> Outcome {
    let pool = arguments.settings.pool()?;
    let cancel = interrupt::token();
    let n = arguments.fireflies.unwrap_or_default() as usize;
    let (found, inspected) = while_waiting("looking for fireflies", || {
        let mut film = Film::new(settings.width, settings.height, settings.n_layers);
        let mut renderer = Renderer::new(Arc::clone(scene), settings, pool, 0);
        for _ in 0..arguments.iterations {
            renderer.iterate_after(&film, &cancel)?.add_to(&mut film);
        }
        let found = film.fireflies(n);
        let pixels = found
            .iter()
            .map(|firefly| firefly.pixel.map(|at| at as u32));
        let pixels: Vec<[u32; 2]> = pixels.collect();
        let inspected = inspect(&renderer, arguments.iterations, &pixels, &cancel)?;
        Ok::<_, anyhow::Error>((found, inspected))
    })?;
    let pairs = || found.iter().zip(&inspected);
    if arguments.json {
        let all: Vec<Value> = pairs().map(|(f, of)| as_json(f, of, scene)).collect();
        return console::json(&json!({
            "scene": scene.name(),
            "integrator": arguments.settings.integrator,
            "iterations": arguments.iterations,
            "fireflies": all,
        }));
    }
    if found.is_empty() {
        return console::result("No pixel stands out.");
    }
    let lines: Vec<String> = pairs().map(|(f, of)| as_text(f, of, scene)).collect();
    console::result(&lines.join("\n\n"))
}

/// The share of the pixel that its largest contribution has.
fn largest(of: &Inspection) -> f64 {
    let sum = f64::from(of.total().mean.luminance()) * f64::from(of.n_iterations());
    let largest = of
        .paths()
        .first()
        .map_or(0.0, |(_, path)| path.value().luminance());
    f64::from(largest) / sum.max(f64::MIN_POSITIVE)
}

fn as_text(firefly: &Firefly, of: &Inspection, scene: &Scene) -> String {
    let [x, y] = firefly.pixel;
    let number = |v: f32| significant(f64::from(v), 3);
    let (luminance, around) = (number(firefly.luminance), number(firefly.around));
    let mut lines = vec![format!(
        "pixel {x},{y}: luminance {luminance}, around it {around}"
    )];
    if let Some((iteration, path)) = of.paths().first() {
        lines.push(format!(
            "  {} of it by one path of {}, in iteration {iteration}: {}  {}",
            percent(largest(of)),
            of.n_paths(),
            paths::technique(path.contribution.strategy),
            inspection::path(path)
        ));
        lines.push(format!("  {}", inspection::rarity(path, scene)));
    }
    lines.join("\n")
}

fn as_json(firefly: &Firefly, of: &Inspection, scene: &Scene) -> Value {
    let path = of.paths().first().map(|(iteration, path)| {
        let mut json = paths::json(scene, path);
        json["iteration"] = json!(iteration);
        json["share"] = json!(largest(of));
        json["rarity"] = json!(inspection::rarity(path, scene));
        json
    });
    json!({
        "pixel": firefly.pixel,
        "luminance": firefly.luminance,
        "around": firefly.around,
        "value": of.total().mean.to_array(),
        "path": path,
    })
}
