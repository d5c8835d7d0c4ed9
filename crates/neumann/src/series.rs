//! `neumann series`: every term and every partial sum, and all of them on one sheet.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use neumann_core::film::{ClassFilm, Features, Film, View};
use neumann_core::radiometry::Rgb;
use neumann_picture::Image;
use neumann_picture::energy::Energy;
use neumann_picture::exr_file::{Beside, Metadata, Precision, write_image_exr};
use neumann_picture::figure::energy_figure;
use neumann_picture::files::{check_destination, write_atomically};
use neumann_picture::png_file::{Pixels8, write_png};
use neumann_picture::sheet::{SheetInfo, sheet};
use neumann_picture::tone::Display;
use serde_json::{Value, json};

use crate::cli::SeriesArguments;
use crate::console;
use crate::failure::{OrBadInput, Outcome, bad_input};
use crate::interrupt;
use crate::outputs::{self, Picture, note_clipping};
use crate::render::{completeness, refuse_empty, report, summary};
use crate::session::{Goal, Rendered, Saver, Session};

pub(crate) fn run(arguments: &SeriesArguments) -> Outcome {
    let goal = Goal::of(&arguments.goal)?;
    make_folder(&arguments.folder)?;
    let (scene, settings) = arguments.settings.resolve(&arguments.scene)?;
    let outputs = names(settings.n_layers, settings.max_bounces)
        .into_iter()
        .map(|name| arguments.folder.join(name))
        .collect::<Vec<_>>();
    outputs::check(&outputs)?;
    let energy_files = ENERGY.map(|name| arguments.folder.join(name));
    for file in &energy_files {
        check_destination(file).or_bad_input()?;
    }
    let inputs = arguments.settings.inputs(&arguments.scene, &scene);
    outputs::refuse_inputs(&outputs, &inputs)?;
    outputs::refuse_inputs(&energy_files, &inputs)?;
    outputs::check_space(&outputs[..1], &settings)?;
    let state = arguments
        .settings
        .state(&arguments.scene, &scene, &settings);
    let classes = arguments.classes.resolve(&scene)?;
    let mix = match &classes {
        Some(classes) => arguments.classes.factors(classes)?,
        None => Vec::new(),
    };
    let session = Session {
        state: Box::new(state),
        classes: classes.map(Arc::new),
        scene,
        settings,
        pool: arguments.settings.pool()?,
        goal,
        technique_divisor: None,
        draws_photons: false,
    };
    session.check()?;
    let checkpoint = arguments.folder.join(CHECKPOINT);
    let before = if arguments.resume {
        session.checkpoint(&checkpoint)?
    } else {
        None
    };
    let write_checkpoint = |film: &Film, features: &Features, metadata: &Metadata| {
        let picture = Picture {
            film,
            beside: Some(features).into(),
            metadata,
            display: Display::default(),
            precision: Precision::Full,
        };
        picture.write(&checkpoint)
    };
    let saver = Saver::new(arguments.goal.checkpoint, &write_checkpoint);
    let rendered = session.render(before, Some(saver), None, &interrupt::token());
    refuse_empty(&rendered)?;
    let display = arguments.display.display(|| rendered.film.total());
    let mut outputs = write(&arguments.folder, &rendered, &mix, display)?;
    if let Some(classes) = &rendered.classes {
        outputs.extend(write_classes(
            &arguments.folder,
            classes,
            &rendered,
            display,
        )?);
    }
    console::note(&summary(&rendered));
    console::note(&energy(&rendered).sentence());
    if arguments.json {
        let mut value = report(&rendered, &outputs);
        let energy = energy(&rendered);
        value["energy_shares"] = rendered.film.energy_shares().into();
        let errors = energy.terms.iter().map(|term| term.error);
        value["energy_errors"] = errors.collect::<Vec<_>>().into();
        value["decay"] = energy.decay.map_or(Value::Null, |decay| {
            json!({
                "ratio": decay.ratio[0],
                "error": decay.ratio[1],
                "terms": [decay.first, decay.last],
                "beyond": decay.beyond.map(|beyond| beyond[0]),
                "beyond_error": decay.beyond.map(|beyond| beyond[1]),
            })
        });
        console::json(&value)?;
    }
    completeness(&rendered)
}

/// The file that holds all layers.
const CHECKPOINT: &str = "L.exr";
/// What the terms are worth: a table and a chart.
const ENERGY: [&str; 2] = ["energy.csv", "energy.svg"];
/// The file that shows all of them.
const SHEET: &str = "sheet.png";

/// Makes the folder if it is not there, and finds out whether it can be written to.
pub(crate) fn make_folder(folder: &Path) -> Outcome {
    if let Err(error) = fs::create_dir_all(folder) {
        return Err(bad_input(format!(
            "{}: cannot make this folder: {error}; choose another one",
            folder.display()
        )));
    }
    check_destination(&folder.join(CHECKPOINT)).or_bad_input()
}

/// Writes all pictures of the series; yields what it wrote.
pub(crate) fn write(
    folder: &Path,
    rendered: &Rendered,
    mix: &[Rgb],
    display: Display,
) -> Outcome<Vec<PathBuf>> {
    let film = &rendered.film;
    let checkpoint = folder.join(CHECKPOINT);
    let picture = Picture {
        film,
        beside: Beside {
            features: Some(&rendered.features),
            classes: rendered.classes.as_ref(),
            mix,
        },
        metadata: &rendered.metadata,
        display,
        precision: Precision::Full,
    };
    picture.write(&checkpoint)?;
    let mut outputs = vec![checkpoint];
    for view in views(film.n_layers(), rendered.metadata.max_bounces) {
        let image = image_of(film, view);
        let png = folder.join(name_of(view, "png"));
        write_png(&png, &Pixels8::of(&image, &display))?;
        if view == View::Total {
            note_clipping(&png, &image.pixels, &display);
        }
        outputs.push(png);
        if view != View::Total {
            let exr = folder.join(name_of(view, "exr"));
            let notes = [
                ("scene", rendered.metadata.scene.as_str()),
                ("view", &view.to_string()),
            ];
            write_image_exr(&exr, (image.width, image.height), &image.pixels, &notes)?;
            outputs.push(exr);
        }
    }
    let path = folder.join(SHEET);
    let info = SheetInfo::of(film, &rendered.metadata, display);
    write_png(&path, &sheet(film, &info))?;
    outputs.push(path);
    let energy = energy(rendered);
    let metadata = &rendered.metadata;
    let heading = [&*metadata.scene, &metadata.summary()];
    let texts = [energy.csv(), energy_figure(heading, &energy)];
    for (name, text) in ENERGY.into_iter().zip(texts) {
        let path = folder.join(name);
        write_atomically(&path, |writer| Ok(writer.write_all(text.as_bytes())?))?;
        outputs.push(path);
    }
    Ok(outputs)
}

/// Writes a picture of each class of paths, and of the light of each source.
fn write_classes(
    folder: &Path,
    classes: &ClassFilm,
    rendered: &Rendered,
    display: Display,
) -> Outcome<Vec<PathBuf>> {
    let expressions = classes.classes().expressions.iter().enumerate();
    let expressions = expressions.map(|(number, expression)| {
        let name = format!("expression-{}", file_name(expression.name()));
        (name, expression.to_string(), classes.expression(number))
    });
    let lit = classes
        .group_names()
        .enumerate()
        .filter(|(g, _)| classes.is_lit(*g));
    let lights = lit.filter_map(|(group, name)| {
        let pixels = classes.group(group, View::Total)?;
        let file = format!("light-{}", file_name(name));
        Some((file, format!("light of {name}"), pixels))
    });
    let mut outputs: Vec<PathBuf> = Vec::new();
    for (name, view, pixels) in expressions.chain(lights) {
        let mut stem = name.clone();
        // Names may differ in what no file's name has.
        for n in 2.. {
            let png = folder.join(format!("{stem}.png"));
            if !outputs.contains(&png) {
                break;
            }
            stem = format!("{name}-{n}");
        }
        let image = Image {
            width: classes.width(),
            height: classes.height(),
            pixels,
            ..Image::default()
        };
        let png = folder.join(format!("{stem}.png"));
        write_png(&png, &Pixels8::of(&image, &display))?;
        let exr = folder.join(format!("{stem}.exr"));
        let notes = [
            ("scene", rendered.metadata.scene.as_str()),
            ("view", view.as_str()),
        ];
        write_image_exr(&exr, (image.width, image.height), &image.pixels, &notes)?;
        outputs.extend([png, exr]);
    }
    Ok(outputs)
}

/// A name with letters and digits alone, and `-` for the rest.
fn file_name(name: &str) -> String {
    let words = name.split(|c: char| !c.is_alphanumeric());
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    words.join("-")
}

/// What the terms are worth.
fn energy(rendered: &Rendered) -> Energy {
    let film = &rendered.film;
    let max_bounces = rendered.metadata.max_bounces;
    let (shares, errors) = (film.energy_shares(), film.layer_errors());
    Energy::of(&shares, &errors, film.n_pixels(), max_bounces)
}

fn name_of(view: View, extension: &str) -> String {
    format!("{}.{extension}", view.to_string().replace(':', ""))
}

/// All pictures of a series, the one that holds all layers first.
fn names(n_layers: usize, max_bounces: u32) -> Vec<String> {
    let views = views(n_layers, max_bounces);
    let others = views.iter().filter(|view| **view != View::Total);
    [CHECKPOINT, SHEET]
        .map(str::to_owned)
        .into_iter()
        .chain(views.iter().map(|view| name_of(*view, "png")))
        .chain(others.map(|view| name_of(*view, "exr")))
        .collect()
}

/// Terms, partial sums and L, as far as they were computed.
fn views(n_layers: usize, max_bounces: u32) -> Vec<View> {
    let n_terms = n_layers.min(max_bounces as usize + 1);
    let has_tail = max_bounces as usize >= n_layers;
    (0..n_terms)
        .map(View::Term)
        .chain(has_tail.then_some(View::Tail))
        .chain((0..n_terms).map(View::Upto))
        .chain([View::Total])
        .collect()
}

fn image_of(film: &Film, view: View) -> Image {
    let mut pixels = vec![Rgb::BLACK; film.width() * film.height()];
    film.compose(view, &mut pixels);
    Image {
        width: film.width(),
        height: film.height(),
        pixels,
        ..Image::default()
    }
}

#[cfg(test)]
mod tests {
    use neumann_core::film::View;

    use super::{names, views};

    #[test]
    fn views_are_those_that_were_computed() {
        let listed = |max_bounces| {
            let views = views(3, max_bounces);
            views
                .iter()
                .map(View::to_string)
                .collect::<Vec<_>>()
                .join(" ")
        };
        assert_eq!(listed(16), "T0 T1 T2 tail upto:0 upto:1 upto:2 L");
        assert_eq!(listed(3), "T0 T1 T2 tail upto:0 upto:1 upto:2 L");
        assert_eq!(listed(1), "T0 T1 upto:0 upto:1 L");
        assert_eq!(
            names(3, 0),
            [
                "L.exr",
                "sheet.png",
                "T0.png",
                "upto0.png",
                "L.png",
                "T0.exr",
                "upto0.exr"
            ]
        );
    }
}
