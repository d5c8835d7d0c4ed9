//! `neumann lobe`: the BSDF of a material, direction by direction.

use std::io::Write;
use std::path::Path;

use neumann_core::render::RenderSettings;
use neumann_core::render::lobe::{DeltaLobe, Lobes, Surface, Viewed};
use neumann_core::scene::Scene;
use neumann_picture::figures::significant;
use neumann_picture::files::{check_destination, write_atomically};
use neumann_picture::lobe::{Plot, Plotted, Radius, Turn, csv, largest, percent, reciprocity};
use neumann_picture::png_file::write_png;
use neumann_picture::sheet::{LobeSheet, lobe_sheet};
use serde_json::{Value, json};

use crate::cli::LobeArguments;
use crate::console;
use crate::failure::{OrBadInput, Outcome, bad_input};
use crate::interrupt;
use crate::options::SettingsOptions;
use crate::outputs::{self, Kind};
use crate::paths;
use crate::progress::while_waiting;
use crate::suggest;

/// More columns than this do not fit a page.
const MOST_ANGLES: usize = 4;

pub(crate) fn run(arguments: &LobeArguments) -> Outcome {
    if arguments.angles.len() > MOST_ANGLES {
        return Err(bad_input(format!(
            "--angles: {} are given; at most {MOST_ANGLES} stand side by side",
            arguments.angles.len()
        )));
    }
    if let Some(sheet) = &arguments.output {
        if outputs::kind(sheet)? != Kind::Png {
            let name = sheet.display();
            return Err(bad_input(format!("{name}: the sheet is a .png")));
        }
        outputs::check(std::slice::from_ref(sheet))?;
    }
    if let Some(table) = &arguments.csv {
        check_destination(table).or_bad_input()?;
    }
    let settings = SettingsOptions {
        size: arguments.size,
        backs: arguments.backs,
        camera: arguments.camera.clone(),
        load: arguments.load.clone(),
        ..SettingsOptions::defaults()
    };
    let (scene, wanted) = settings.resolve(&arguments.scene)?;
    let written = arguments.output.iter().chain(&arguments.csv);
    let written: Vec<_> = written.cloned().collect();
    outputs::refuse_inputs(&written, &settings.inputs(&arguments.scene, &scene))?;
    let surface = find(arguments, &scene, &wanted)?;
    let cancel = interrupt::token();
    let lobes = while_waiting("looking at lobes", || {
        Lobes::new(&surface.bsdf, &arguments.angles, surface.is_behind, &cancel)
    })?;
    let what = describe(&scene, &surface, arguments.pixel);
    if let Some(file) = &arguments.output {
        let sheet = LobeSheet {
            heading: [scene.name(), &what],
            lobes: &lobes,
            plot: plot(arguments),
            turn: Turn::default(),
        };
        write_png(file, &lobe_sheet(&sheet))?;
    }
    if let Some(file) = &arguments.csv {
        write_text(file, &csv(&lobes))?;
    }
    if arguments.json {
        return console::json(&as_json(arguments, &scene, &surface, &lobes));
    }
    console::result(&as_text(&what, &lobes))
}

/// The surface that was asked for.
fn find(arguments: &LobeArguments, scene: &Scene, wanted: &RenderSettings) -> Outcome<Surface> {
    if let Some([x, y]) = arguments.pixel {
        paths::check_pixel([x, y], wanted)?;
        return Surface::of_pixel(scene, wanted, [x, y])
            .map_err(|error| bad_input(format!("--pixel {x},{y}: {error}")));
    }
    let Some(name) = &arguments.material else {
        return Err(bad_input(format!(
            "name a surface: --pixel X,Y, or --material with one of {}",
            names(scene).collect::<Vec<_>>().join(", ")
        )));
    };
    let surface = Surface::of_material(scene, material(scene, name)?)
        .map_err(|error| bad_input(format!("--material {name}: {error}")))?;
    Ok(Surface {
        is_behind: arguments.behind,
        ..surface
    })
}

fn names(scene: &Scene) -> impl Iterator<Item = &str> {
    let all = scene.materials().iter();
    all.map(|material| material.parameters().name.as_str())
}

/// The number of a material, by its name, else as it is written.
fn material(scene: &Scene, wanted: &str) -> Outcome<usize> {
    let n = scene.materials().len();
    let by_name = names(scene).position(|name| name == wanted);
    let by_number = || wanted.parse().ok().filter(|number| *number < n);
    by_name.or_else(by_number).ok_or_else(|| {
        let meant = suggest::nearest(wanted, names(scene));
        let remedy = match meant {
            Some(meant) => format!("did you mean '{meant}'? "),
            None => String::new(),
        };
        let all: Vec<&str> = names(scene).collect();
        bad_input(format!(
            "--material {wanted}: the scene has no such material; {remedy}it has {}",
            all.join(", ")
        ))
    })
}

/// Which surface it is, in a line.
fn describe(scene: &Scene, surface: &Surface, pixel: Option<[u32; 2]>) -> String {
    let name = names(scene).nth(surface.material).unwrap_or_default();
    let mut text = format!("material {name}");
    if let Some([x, y]) = pixel {
        text += &format!(" at pixel {x}, {y}");
    }
    if let Some(angle) = surface.angle {
        let angle = significant(f64::from(angle), 3);
        text += &format!(", seen under {angle}°");
    }
    if surface.is_behind {
        text += ", from behind";
    }
    text
}

fn plot(arguments: &LobeArguments) -> Plot {
    Plot {
        plotted: if arguments.cosine {
            Plotted::Product
        } else {
            Plotted::Value
        },
        radius: if arguments.log {
            Radius::Logarithmic
        } else {
            Radius::Linear
        },
    }
}

fn write_text(file: &Path, text: &str) -> Outcome {
    Ok(write_atomically(file, |out| {
        Ok(out.write_all(text.as_bytes())?)
    })?)
}

fn as_text(what: &str, lobes: &Lobes) -> String {
    let mut lines = vec![
        what.to_owned(),
        "angle   albedo   by samples          specular  max f cos  Σ p".to_owned(),
    ];
    for view in &lobes.views {
        let at = view.albedo();
        let sampled = format!("{:.4} ± {:.4}", at.sampled, 1.96 * at.standard_error);
        lines.push(format!(
            "{:<6}  {:<7.4}  {:<18}  {:<8}  {:<9}  {:.4}",
            format!("{}°", significant(f64::from(view.angle), 3)),
            at.albedo.luminance(),
            sampled,
            percent(at.specular_share()),
            significant(f64::from(largest(view, Plotted::Product)), 4),
            view.total_probability()
        ));
    }
    lines.push(reciprocity(lobes));
    lines.join("\n")
}

fn as_json(arguments: &LobeArguments, scene: &Scene, surface: &Surface, lobes: &Lobes) -> Value {
    let albedo = lobes.albedo.iter().map(|at| {
        json!({
            "angle": at.angle,
            "albedo": at.albedo.to_array(),
            "specular": at.specular.to_array(),
            "sampled": {"luminance": at.sampled, "interval": 1.96 * at.standard_error},
        })
    });
    let reciprocity = lobes.reciprocity.map(|found| {
        json!({
            "holds": found.holds(),
            "largest_difference": found.largest,
            "pair": found.pair.map(|w| w.to_array()),
            "pairs": found.n_pairs,
        })
    });
    json!({
        "scene": scene.name(),
        "material": names(scene).nth(surface.material),
        "pixel": arguments.pixel,
        "from_behind": surface.is_behind,
        "seen_under": surface.angle,
        "views": lobes.views.iter().map(of_view).collect::<Vec<_>>(),
        "albedo": albedo.collect::<Vec<_>>(),
        "reciprocity": reciprocity,
    })
}

fn of_view(view: &Viewed) -> Value {
    let at = view.albedo();
    let lobe = |lobe: &DeltaLobe| {
        json!({
            "direction": lobe.wi.to_array(),
            "share": lobe.share.to_array(),
            "probability": lobe.probability,
        })
    };
    json!({
        "angle": view.angle,
        "albedo": at.albedo.to_array(),
        "specular_share": at.specular_share(),
        "largest_f": largest(view, Plotted::Value),
        "largest_f_cos": largest(view, Plotted::Product),
        "density": view.integrals.pdf_w,
        "refused": view.drawn.refused,
        "total_probability": view.total_probability(),
        "mirror_like": view.drawn.deltas.iter().map(lobe).collect::<Vec<_>>(),
    })
}
