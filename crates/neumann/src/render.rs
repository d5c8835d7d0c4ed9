//! `neumann render`: a scene to EXR and PNG files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::anyhow;
use neumann_core::film::{Features, Film, TechniqueFilm, View};
use neumann_core::integrator::{method, methods_with_photons};
use neumann_core::photons::PhotonPicture;
use neumann_core::render::RenderSettings;
use neumann_core::scene::description::Crop;
use neumann_picture::exr_file::{Beside, Metadata, Precision, write_techniques_exr};
use neumann_picture::photons::{PhotonLook, PowerScale};
use neumann_picture::png_file::write_png;
use neumann_picture::sheet::{SheetInfo, photon_sheet, technique_sheet};
use neumann_picture::tev::{Tev, image_name};
use neumann_picture::tone::Display;
use serde_json::{Value, json};

use crate::cli::RenderArguments;
use crate::console;
use crate::failure::{OrBadInput, Outcome, bad_input};
use crate::interrupt;
use crate::options::Exposure;
use crate::outputs::{self, Kind, Picture};
use crate::progress::duration;
use crate::series::make_folder;
use crate::session::{Goal, Live, Rendered, Saver, Session, peak_bytes};

pub(crate) fn run(arguments: &RenderArguments) -> Outcome {
    let goal = goal(arguments)?;
    outputs::check(&arguments.outputs)?;
    let mut outputs = arguments.outputs.clone();
    if let Some(path) = &arguments.photons {
        check_photons(path, &arguments.settings.integrator)?;
        outputs.push(path.clone());
        outputs::check(&outputs)?;
    }
    if let Some(folder) = &arguments.techniques {
        make_folder(folder)?;
        outputs.extend([TECHNIQUES_EXR, TECHNIQUES_PNG].map(|name| folder.join(name)));
        outputs::check(&outputs)?;
    }
    // Who is to look on is sought before any work is done.
    let tev = arguments.tev.as_deref().map(Tev::connect);
    let tev = tev.transpose().or_bad_input()?;
    let (scene, mut settings) = arguments.settings.resolve(&arguments.scene)?;
    if let Some(region) = arguments.region {
        crop(&mut settings, region)?;
    }
    let inputs = arguments.settings.inputs(&arguments.scene, &scene);
    outputs::refuse_inputs(&outputs, &inputs)?;
    outputs::check_space(&arguments.outputs, &settings)?;
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
        technique_divisor: arguments
            .techniques
            .is_some()
            .then_some(arguments.techniques_divisor as usize),
        draws_photons: arguments.photons.is_some(),
    };
    session.check()?;
    let before = if arguments.resume {
        session.checkpoint(outputs::checkpoint("--resume", &arguments.outputs)?)?
    } else {
        None
    };
    // Asked for, a checkpoint needs an .exr; by itself it goes where there is one.
    let checkpoint = outputs::checkpoint("--checkpoint", &arguments.outputs);
    let checkpoint = match arguments.goal.checkpoint {
        Some(seconds) if seconds > 0.0 => Some(checkpoint?),
        _ => checkpoint.ok(),
    };
    let write = |film: &Film, features: &Features, metadata: &Metadata| match checkpoint {
        Some(path) => {
            // An .exr holds radiance, however it is shown.
            let display = Display::default();
            let beside = Some(features).into();
            picture(arguments, film, beside, metadata, display).write(path)
        }
        None => Ok(()),
    };
    let saver = checkpoint.map(|_| Saver::new(arguments.goal.checkpoint, &write));
    let mut live = tev.map(|tev| {
        let name = image_name(session.scene.name(), session.settings.method.id);
        Live::new(tev, name)
    });
    let rendered = session.render(before, saver, live.as_mut(), &interrupt::token());
    refuse_empty(&rendered)?;
    if let Some(live) = &mut live {
        live.show(&rendered.film);
    }
    let beside = Beside {
        features: Some(&rendered.features),
        classes: rendered.classes.as_ref(),
        mix: &mix,
    };
    let (film, metadata) = (&rendered.film, &rendered.metadata);
    let shown = || picture(arguments, film, beside, metadata, Display::default()).shown();
    let display = arguments.display.display(shown);
    let picture = picture(arguments, film, beside, metadata, display);
    picture.write_all(&arguments.outputs)?;
    if let (Some(folder), Some(film)) = (&arguments.techniques, &rendered.techniques) {
        write_techniques(folder, film, &rendered, display)?;
    }
    let mut written = arguments.outputs.clone();
    if let (Some(path), Some(photons)) = (&arguments.photons, &rendered.photon_picture) {
        write_photons(path, photons, arguments, &rendered)?;
        written.push(path.clone());
    }
    console::note(&summary(&rendered));
    if arguments.json {
        console::json(&report(&rendered, &written))?;
    }
    completeness(&rendered)
}

/// Has a part of the picture rendered instead of all of it.
fn crop(settings: &mut RenderSettings, [x, y, width, height]: [usize; 4]) -> Outcome {
    let of = [settings.width, settings.height];
    if x + width > of[0] || y + height > of[1] {
        return Err(bad_input(format!(
            "--region {x},{y},{width},{height}: reaches beyond the picture of {}x{}; choose a part \
             of it, or a larger --size",
            of[0], of[1]
        )));
    }
    settings.camera.crop = Some(Crop {
        of,
        at: [x, y],
        size: [width, height],
    });
    [settings.width, settings.height] = [width, height];
    Ok(())
}

/// When rendering is done: after one iteration, where photons are all that is asked for.
fn goal(arguments: &RenderArguments) -> Outcome<Goal> {
    let mut options = arguments.goal.clone();
    let is_open =
        options.iterations.is_none() && options.time.is_none() && options.until_error.is_none();
    let is_watched = arguments.tev.is_some();
    if arguments.outputs.is_empty() && !is_watched && is_open {
        options.iterations = Some(1);
    }
    Goal::of(&options)
}

/// Refuses photons of a method that has none, and a file that they cannot be drawn to.
fn check_photons(path: &Path, integrator: &str) -> Outcome {
    if !method(integrator).is_some_and(|method| method.has_photons) {
        return Err(bad_input(format!(
            "--photons: '{integrator}' has no photons; use --integrator {}",
            methods_with_photons()
        )));
    }
    if outputs::kind(path)? != Kind::Png {
        return Err(bad_input(format!(
            "--photons: {}: photons are drawn as .png; name such a file",
            path.display()
        )));
    }
    Ok(())
}

/// Files in the folder of techniques.
const TECHNIQUES_EXR: &str = "techniques.exr";
const TECHNIQUES_PNG: &str = "techniques.png";

/// A film as it is to be written.
fn picture<'a>(
    arguments: &RenderArguments,
    film: &'a Film,
    beside: Beside<'a>,
    metadata: &'a Metadata,
    display: Display,
) -> Picture<'a> {
    Picture {
        film,
        beside,
        metadata,
        display,
        precision: if arguments.half {
            Precision::Half
        } else {
            Precision::Full
        },
    }
}

/// Writes the pyramid of techniques.
fn write_techniques(
    folder: &Path,
    film: &TechniqueFilm,
    rendered: &Rendered,
    display: Display,
) -> Outcome {
    let metadata = &rendered.metadata;
    let n_iterations = film.n_iterations().to_string();
    let notes = [
        ("scene", metadata.scene.as_str()),
        ("integrator", metadata.integrator.as_str()),
        ("iterations", n_iterations.as_str()),
    ];
    write_techniques_exr(&folder.join(TECHNIQUES_EXR), film, &notes)?;
    let info = SheetInfo::of(&rendered.film, metadata, display);
    write_png(&folder.join(TECHNIQUES_PNG), &technique_sheet(film, &info))?;
    Ok(())
}

/// Draws the photons with their legend.
fn write_photons(
    path: &Path,
    photons: &PhotonPicture,
    arguments: &RenderArguments,
    rendered: &Rendered,
) -> Outcome {
    let look = PhotonLook {
        colours: arguments.photons_by,
        part: View::Total,
        n_layers: rendered.film.n_layers(),
        display: Display {
            // Powers have a scale of their own: an exposure that suits radiance says nothing here.
            exposure_ev: match arguments.display.exposure {
                Some(Exposure::Stops(stops)) => stops,
                _ => 0.0,
            },
            tone: arguments.display.tone,
        },
    };
    let metadata = &rendered.metadata;
    let line = format!("{} · {}", look.caption(), metadata.integrator);
    let heading = [metadata.scene.as_str(), line.as_str()];
    let sheet = photon_sheet(photons, PowerScale::of(photons), &look, heading);
    write_png(path, &sheet)?;
    Ok(())
}

/// Nothing is written if not a single iteration was finished.
pub(crate) fn refuse_empty(rendered: &Rendered) -> Outcome {
    if rendered.film.n_iterations() == 0 {
        return Err(anyhow!(
            "interrupted before the first iteration was finished; nothing was written"
        ));
    }
    Ok(())
}

/// An interrupted render is written but is not done.
pub(crate) fn completeness(rendered: &Rendered) -> Outcome {
    if rendered.is_complete {
        return Ok(());
    }
    Err(anyhow!(
        "interrupted after {} iterations; they were written, go on with --resume",
        rendered.film.n_iterations()
    ))
}

/// One line for people.
pub(crate) fn summary(rendered: &Rendered) -> String {
    let n = rendered.film.n_iterations();
    let seconds = rendered.metadata.seconds;
    let mut text = format!(
        "{n} iteration{} in {}, {:.1} ms each",
        if n == 1 { "" } else { "s" },
        duration(seconds),
        seconds * 1e3 / f64::from(n.max(1))
    );
    if let Some(error) = rendered.estimated_error {
        text += &format!(", estimated error {:.2} %", error * 100.0);
    }
    let n_refused = rendered.film.n_refused();
    if n_refused > 0 {
        text += &format!(", {n_refused} contributions refused");
    }
    text
}

/// The object that `--json` ends with; `null` for what is not known.
pub(crate) fn report(rendered: &Rendered, outputs: &[PathBuf]) -> Value {
    let film = &rendered.film;
    let n = f64::from(film.n_iterations());
    let seconds = rendered.metadata.seconds;
    let outputs: Vec<_> = outputs.iter().map(|p| p.display().to_string()).collect();
    let mut report = json!({
        "integrator": rendered.metadata.integrator,
        "iterations": film.n_iterations(),
        "first_iteration": rendered.metadata.iterations.first(),
        "seconds": seconds,
        "ms_per_iteration": seconds * 1e3 / n,
        "samples_per_second": rendered.samples_per_second,
        "rays_per_second": rendered.rays_per_second,
        "refused": film.n_refused(),
        "estimated_error": rendered.estimated_error,
        "peak_memory_bytes": peak_bytes(),
        "outputs": outputs,
    });
    let n_layers = film.n_layers();
    let errors = rendered.layer_errors.iter().enumerate();
    let errors = errors.map(|(layer, error)| {
        let view = if layer < n_layers {
            View::Term(layer)
        } else {
            View::Tail
        };
        (view.to_string(), json!(error))
    });
    report["term_errors"] = Value::Object(errors.collect());
    if let Some(photons) = rendered.photons {
        report["photons"] = json!({
            "radius": photons.radius,
            "light_paths": photons.n_paths,
            "light_vertices": photons.n_vertices,
            "bytes": photons.bytes,
        });
    }
    report
}
