//! Paths in numbers, as text and as JSON.

use glam::Vec3;
use neumann_core::film::{Joint, Strategy};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{PathId, RenderSettings, Replayed};
use neumann_core::scene::Scene;
use neumann_core::transport::{Event, Lobe, PathVertex, VertexKind};
use neumann_picture::inspection;
use serde_json::{Value, json};

use crate::failure::{Outcome, bad_input};

/// Refuses a pixel beside the picture.
pub(crate) fn check_pixel([x, y]: [u32; 2], settings: &RenderSettings) -> Outcome {
    let (width, height) = (settings.width, settings.height);
    if x as usize >= width || y as usize >= height {
        return Err(bad_input(format!(
            "--pixel {x},{y}: the picture has {width} columns and {height} rows, counted from 0"
        )));
    }
    Ok(())
}

/// Red, green and blue.
pub(crate) fn color(value: Rgb) -> String {
    format!("{:<9.4e} {:<9.4e} {:<9.4e}", value.r, value.g, value.b)
}

/// `s1 t2`, with how they were joined unless by a segment.
pub(crate) fn technique(strategy: Strategy) -> String {
    let Strategy { s, t, joint } = strategy;
    let joint = match joint {
        Joint::Hit => " hit",
        Joint::Connect => "",
        Joint::Merge => " =",
    };
    format!("s{s} t{t}{joint}")
}

/// The same for programs.
pub(crate) fn technique_json(strategy: Strategy) -> Value {
    json!({"s": strategy.s, "t": strategy.t, "joint": joint(strategy.joint)})
}

/// Everything that is known of a contribution.
pub(crate) fn json(scene: &Scene, path: &Replayed) -> Value {
    let contribution = &path.contribution;
    json!({
        "bounce": contribution.bounce,
        "technique": technique_json(contribution.strategy),
        "value": path.value().to_array(),
        "mis_weight": contribution.mis_weight,
        "share": path.share,
        "path": inspection::path(path),
        "camera_path": path.camera_path.map(id),
        "light_path": path.light_path.map(id),
        "camera": vertices(scene, &path.camera),
        "light": vertices(scene, &path.light),
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
        "lobe": vertex.lobe().map(lobe),
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
        "glossy": event.glossy.to_array(),
        "transmission": event.is_transmission,
        "f_cos": event.f_cos.to_array(),
        "pdf_w": event.pdf_w,
        "pdf_w_reverse": event.pdf_w_reverse,
        "survival": event.survival,
    })
}
