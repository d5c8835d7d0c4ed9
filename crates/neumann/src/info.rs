//! `neumann info`: what a scene consists of.

use neumann_core::film::LightGroup;
use neumann_core::scene::description::{CameraDescription, Projection};
use neumann_core::scene::{Backs, Scene};
use serde_json::{Value, json};

use crate::cli::InfoArguments;
use crate::console;
use crate::failure::Outcome;
use crate::options::{EnvironmentArguments, open_scene};

pub(crate) fn run(arguments: &InfoArguments) -> Outcome {
    let scene = open_scene(
        &arguments.scene,
        &arguments.load,
        &EnvironmentArguments::default(),
        Backs::default(),
    )?;
    if arguments.json {
        console::json(&as_json(&scene))
    } else {
        console::result(&as_text(&scene))
    }
}

fn as_text(scene: &Scene) -> String {
    let (n, report) = (scene.statistics(), scene.report());
    let (min, max) = scene.bounds();
    let mut lines = vec![format!("scene         {}", scene.name())];
    if let Some(about) = scene.about() {
        lines.push(format!("about         {about}"));
    }
    let list = |texts: &[String]| {
        if texts.is_empty() {
            "none".to_owned()
        } else {
            texts.join(", ")
        }
    };
    lines.extend([
        format!("content       {:016x}", scene.content_hash()),
        format!("triangles     {} in {} meshes", n.n_triangles, n.n_meshes),
        format!("bounds        {min} to {max}"),
        format!("materials     {}, images {}", n.n_materials, n.n_images),
        format!(
            "lights        {} emissive triangles, {} punctual",
            n.n_area_lights, n.n_punctual_lights
        ),
        format!("light names   {}", list(&light_names(scene))),
        format!("environment   {}", environment(scene)),
        format!("extensions    {}", list(&report.extensions_used)),
        format!("ignored       {}", list(&report.extensions_ignored)),
    ]);
    if report.n_points_skipped + report.n_lines_skipped > 0 {
        lines.push(format!(
            "not rendered  {} points, {} lines",
            report.n_points_skipped, report.n_lines_skipped
        ));
    }
    for (i, camera) in scene.cameras().iter().enumerate() {
        lines.push(format!("camera {i:<6} {}", camera_text(camera)));
    }
    lines.join("\n")
}

/// What its lights are called, for `--lights` and in light path expressions.
fn light_names(scene: &Scene) -> Vec<String> {
    let groups = LightGroup::all(scene).into_iter();
    groups.map(|group| group.name).collect()
}

fn as_json(scene: &Scene) -> Value {
    let (n, report) = (scene.statistics(), scene.report());
    let (min, max) = scene.bounds();
    let cameras: Vec<_> = scene.cameras().iter().map(camera_json).collect();
    json!({
        "name": scene.name(),
        "about": scene.about(),
        "content_hash": format!("{:016x}", scene.content_hash()),
        "triangles": n.n_triangles,
        "meshes": n.n_meshes,
        "materials": n.n_materials,
        "images": n.n_images,
        "lights": {
            "area": n.n_area_lights,
            "punctual": n.n_punctual_lights,
            "names": light_names(scene),
            "environment": scene.appearance().environment.is_some(),
        },
        "bounds": { "min": min.to_array(), "max": max.to_array() },
        "cameras": cameras,
        "extensions": {
            "used": report.extensions_used,
            "ignored": report.extensions_ignored,
        },
        "points_skipped": report.n_points_skipped,
        "lines_skipped": report.n_lines_skipped,
        "warnings": scene.warnings(),
    })
}

fn environment(scene: &Scene) -> String {
    match &scene.appearance().environment {
        None => "none".to_owned(),
        Some(e) => format!("{} {}x{}", e.name, e.width, e.height),
    }
}

fn camera_text(camera: &CameraDescription) -> String {
    let eye = camera.world_from_camera.w_axis.truncate();
    let projection = match camera.projection {
        Projection::Perspective { yfov } => format!("{:.1}°", yfov.to_degrees()),
        Projection::Orthographic { ymag } => format!("orthographic, {} m high", 2.0 * ymag),
    };
    format!("{} at {eye}, {projection}", camera.name)
}

fn camera_json(camera: &CameraDescription) -> Value {
    let eye = camera.world_from_camera.w_axis.truncate();
    let (kind, fov, height) = match camera.projection {
        Projection::Perspective { yfov } => ("perspective", Some(yfov.to_degrees()), None),
        Projection::Orthographic { ymag } => ("orthographic", None, Some(2.0 * ymag)),
    };
    json!({
        "name": camera.name,
        "projection": kind,
        "fov_degrees": fov,
        "height": height,
        "aspect_ratio": camera.aspect_ratio,
        "eye": eye.to_array(),
    })
}
