//! `neumann replay`: by which paths light has come to a pixel.

use glam::Vec3;
use neumann_core::film::{Joint, Strategy};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{PathId, Renderer, Replayed};
use neumann_core::scene::Scene;
use neumann_core::transport::{Event, Lobe, PathVertex, VertexKind};
use serde_json::{Value, json};

use crate::cli::ReplayArguments;
use crate::console;
use crate::failure::{Outcome, bad_input};
use crate::interrupt;
use crate::progress::while_waiting;

pub(crate) fn run(arguments: &ReplayArguments) -> Outcome {
    let (scene, settings) = arguments.settings.resolve(&arguments.scene)?;
    let [x, y] = arguments.pixel;
    let (width, height) = (settings.width, settings.height);
    if x as usize >= width || y as usize >= height {
        return Err(bad_input(format!(
            "--pixel {x},{y}: the picture has {width} columns and {height} rows, counted from 0"
        )));
    }
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
            technique(contribution.strategy),
            color(path.value()),
            contribution.mis_weight,
            expression(path)
        ));
    }
    let n_bounces = paths.iter().map(|path| path.contribution.bounce + 1).max();
    for bounce in 0..n_bounces.unwrap_or(0) {
        let of_bounce = paths
            .iter()
            .filter(|path| path.contribution.bounce == bounce);
        let (n, sum) = sum(of_bounce);
        if n > 0 {
            lines.push(format!("T{bounce:<5}  sum        {}  of {n}", color(sum)));
        }
    }
    let (n, sum) = sum(paths.iter());
    lines.push(format!("L       sum        {}  of {n}", color(sum)));
    lines.join("\n")
}

fn sum<'a>(paths: impl Iterator<Item = &'a Replayed>) -> (usize, Rgb) {
    paths.fold((0, Rgb::BLACK), |(n, sum), path| {
        (n + 1, sum + path.value())
    })
}

fn color(value: Rgb) -> String {
    format!("{:<9.4e} {:<9.4e} {:<9.4e}", value.r, value.g, value.b)
}

/// `s1 t2`, with how they were joined unless by a segment.
fn technique(strategy: Strategy) -> String {
    let Strategy { s, t, joint } = strategy;
    let joint = match joint {
        Joint::Hit => " hit",
        Joint::Connect => "",
        Joint::Merge => " =",
    };
    format!("s{s} t{t}{joint}")
}

/// The path from the eye to the light, a letter for each vertex.
fn expression(path: &Replayed) -> String {
    let camera = path.camera.iter().map(letter);
    let mut light: Vec<String> = path.light.iter().map(letter).collect();
    light.reverse();
    let mut letters: Vec<String> = camera.collect();
    match path.contribution.strategy {
        // The camera's part has met the light itself.
        Strategy { s: 0, .. } => {
            if let Some(last) = letters.last_mut() {
                "L".clone_into(last);
            }
        }
        Strategy { t: 0, .. } => {}
        Strategy { joint, .. } => letters.push(
            match joint {
                Joint::Merge => "=",
                _ => "-",
            }
            .to_owned(),
        ),
    }
    letters.extend(light);
    letters.join(" ")
}

fn letter(vertex: &PathVertex) -> String {
    let lobe = match vertex.kind {
        VertexKind::Lens => return "E".to_owned(),
        VertexKind::Light | VertexKind::FarLight => return "L".to_owned(),
        VertexKind::Surface => vertex.event.map(|event| event.lobe).or(vertex.lobe),
    };
    let letter = match lobe {
        Some(Lobe::Specular) => "S",
        Some(Lobe::Glossy) => "G",
        Some(Lobe::Diffuse) | None => "D",
    };
    let is_transmission = vertex.event.is_some_and(|event| event.is_transmission);
    format!("{letter}{}", if is_transmission { "t" } else { "" })
}

fn as_json(arguments: &ReplayArguments, scene: &Scene, paths: &[Replayed]) -> Value {
    let contributions: Vec<Value> = paths
        .iter()
        .map(|path| {
            let contribution = &path.contribution;
            let strategy = contribution.strategy;
            json!({
                "bounce": contribution.bounce,
                "technique": {"s": strategy.s, "t": strategy.t, "joint": joint(strategy.joint)},
                "value": path.value().to_array(),
                "mis_weight": contribution.mis_weight,
                "share": path.share,
                "path": expression(path),
                "camera_path": path.camera_path.map(id),
                "light_path": path.light_path.map(id),
                "camera": vertices(scene, &path.camera),
                "light": vertices(scene, &path.light),
            })
        })
        .collect();
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

fn joint(joint: Joint) -> &'static str {
    match joint {
        Joint::Hit => "hit",
        Joint::Connect => "connect",
        Joint::Merge => "merge",
    }
}

fn id(path: PathId) -> Value {
    match path {
        PathId::Camera {
            pixel,
            sample,
            branch,
        } => json!({"pixel": pixel, "sample": sample, "branch": branch}),
        PathId::Light(number) => json!(number),
    }
}

fn vertices(scene: &Scene, vertices: &[PathVertex]) -> Vec<Value> {
    vertices.iter().map(|v| vertex(scene, v)).collect()
}

fn vertex(scene: &Scene, vertex: &PathVertex) -> Value {
    let material = vertex
        .material
        .and_then(|m| scene.materials().get(m as usize));
    json!({
        "kind": match vertex.kind {
            VertexKind::Lens => "lens",
            VertexKind::Light => "light",
            VertexKind::FarLight => "far light",
            VertexKind::Surface => "surface",
        },
        // Of a far light, the direction to it.
        "position": vertex.position.to_array(),
        "normal": some(vertex.ng),
        "shading_normal": some(vertex.ns),
        "triangle": vertex.triangle,
        "material": material.map(|material| &material.parameters().name),
        "lobe": vertex.lobe.map(lobe),
        "throughput": vertex.throughput.to_array(),
        "paths": vertex.n_paths,
        "event": vertex.event.as_ref().map(event),
    })
}

/// A normal, where there is one.
fn some(normal: Vec3) -> Option<[f32; 3]> {
    (normal != Vec3::ZERO).then(|| normal.to_array())
}

fn lobe(lobe: Lobe) -> &'static str {
    match lobe {
        Lobe::Diffuse => "diffuse",
        Lobe::Glossy => "glossy",
        Lobe::Specular => "specular",
    }
}

fn event(event: &Event) -> Value {
    json!({
        "direction": event.wi.to_array(),
        "lobe": lobe(event.lobe),
        "transmission": event.is_transmission,
        "f_cos": event.f_cos.to_array(),
        "pdf_w": event.pdf_w,
        "pdf_w_reverse": event.pdf_w_reverse,
        "survival": event.survival,
    })
}
