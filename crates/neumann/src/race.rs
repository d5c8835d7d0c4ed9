//! `neumann race`: methods at equal processor time, against one reference.
//!
//! How methods take turns, and what of it is counted: [`neumann_picture::race`].

use std::io::Write;
use std::path::Path;

use neumann_core::film::Features;
use neumann_core::memory::Share;
use neumann_core::render::{CancelToken, Cancelled, RenderSettings, WorkerPool};
use neumann_core::scene::Scene;
use neumann_picture::Image;
use neumann_picture::exr_file::{IterationRanges, Metadata, Precision};
use neumann_picture::figure::race_figure;
use neumann_picture::files::write_atomically;
use neumann_picture::image_file::read_layer;
use neumann_picture::png_file::write_png;
use neumann_picture::race::{Entrant, REFERENCE_METHOD, Racer, next_in_turn};
use neumann_picture::sheet::{RacePicture, RaceSheet, race_sheet};
use neumann_picture::state::State;
use neumann_picture::tone::Display;
use serde_json::{Value, json};

use crate::cli::RaceArguments;
use crate::console;
use crate::failure::{OrBadInput, Outcome, bad_input};
use crate::interrupt;
use crate::outputs::{self, Kind, Picture};
use crate::series::make_folder;

/// Times at which errors are measured: the last one, and so many halves of it.
const N_HALVES: i32 = 7;
/// The reference is rendered so many times as long as each method.
const REFERENCE_TIME: f64 = 4.0;

pub(crate) fn run(arguments: &RaceArguments) -> Outcome {
    let settings = &arguments.settings;
    if !settings.set.is_empty() {
        return Err(bad_input(
            "--set: in a race each method has parameters of its own; write pt-mis:roulette=off",
        ));
    }
    let sheet = &arguments.output;
    if outputs::kind(sheet)? != Kind::Png {
        return Err(bad_input(format!(
            "{}: the sheet is a .png",
            sheet.display()
        )));
    }
    outputs::check(std::slice::from_ref(sheet))?;
    if let Some(figure) = &arguments.svg {
        outputs::check_figure(figure)?;
    }
    let (scene, common) = settings.resolve(&arguments.scene)?;
    let inputs = settings.inputs(&arguments.scene, &scene);
    outputs::refuse_inputs(std::slice::from_ref(sheet), &inputs)?;
    outputs::refuse_inputs(arguments.svg.as_slice(), &inputs)?;
    let entrants = entrants(&arguments.methods)?;
    let pool = settings.pool()?;
    let cancel = interrupt::token();
    let state = |settings: &RenderSettings| {
        Box::new(arguments.settings.state(&arguments.scene, &scene, settings))
    };
    if let Some(folder) = &arguments.pictures {
        make_folder(folder)?;
    }
    let reference = match &arguments.reference {
        Some(file) => read_layer(file, None, &mut Share::default()).or_bad_input()?,
        None => {
            let mut common = common.clone();
            common.seed = common.seed.wrapping_add(1);
            let entrant = Entrant::parse(REFERENCE_METHOD).map_err(bad_input)?;
            let mut racer = Racer::new(&entrant.name, &scene, entrant.settings(&common), &pool);
            let file = sheet.with_extension("reference.exr");
            outputs::check(std::slice::from_ref(&file))?;
            console::note(&format!(
                "rendering the reference by {REFERENCE_METHOD}; --reference {} uses it again",
                file.display()
            ));
            let seconds = REFERENCE_TIME * arguments.time;
            while racer.has_time_for_another(seconds) {
                racer.iterate(&cancel).map_err(interrupted)?;
            }
            write_film(&racer, &file, &scene, &pool, state(racer.settings()))?;
            racer.image()
        }
    };
    if (reference.width, reference.height) != (common.width, common.height) {
        return Err(bad_input(format!(
            "--reference: has {}x{} pixels, the race {}x{}; give --size {}x{}",
            reference.width,
            reference.height,
            common.width,
            common.height,
            reference.width,
            reference.height
        )));
    }
    let display = arguments.display.display(|| reference.pixels.clone());
    let judge = Judge {
        reference: &reference,
        display,
        time: arguments.time,
    };
    let racer =
        |entrant: &Entrant| Racer::new(&entrant.name, &scene, entrant.settings(&common), &pool);
    let mut racers: Vec<Racer> = entrants.iter().map(racer).collect();
    hold(&mut racers, &judge, &cancel)?;
    write_results(arguments, &racers, &scene, &pool, &judge, state)
}

/// The methods that were named.
fn entrants(names: &[String]) -> Outcome<Vec<Entrant>> {
    let mut entrants: Vec<Entrant> = Vec::with_capacity(names.len());
    for name in names {
        if entrants.iter().any(|entrant| entrant.name == *name) {
            return Err(bad_input(format!("{name}: is named twice")));
        }
        entrants.push(Entrant::parse(name).map_err(bad_input)?);
    }
    Ok(entrants)
}

fn interrupted(_: Cancelled) -> anyhow::Error {
    anyhow::anyhow!("interrupted; nothing was written")
}

/// Writes all layers of what a racer has rendered.
fn write_film(
    racer: &Racer,
    file: &Path,
    scene: &Scene,
    pool: &WorkerPool,
    state: Box<State>,
) -> Outcome {
    let (film, s) = (racer.film(), racer.settings());
    let mut metadata = Metadata::of(scene, s);
    metadata.state = Some(state);
    metadata.seconds = racer.seconds();
    metadata.iterations = IterationRanges::of(0..film.n_iterations());
    metadata.n_refused = film.n_refused();
    let features = pool.run(|| Features::trace(scene, &s.camera, s.width, s.height));
    let picture = Picture {
        film,
        beside: Some(&features).into(),
        metadata: &metadata,
        display: Display::default(),
        precision: Precision::Full,
    };
    picture.write(file)
}

/// What methods are judged by.
struct Judge<'a> {
    reference: &'a Image,
    display: Display,
    /// Processor time that each has, seconds.
    time: f64,
}

impl Judge<'_> {
    /// Notes how far a method has come, if it is time to.
    fn look(&self, racer: &mut Racer) -> Outcome {
        let due = self.time * 0.5f64.powi(N_HALVES - racer.curve.len() as i32);
        let is_over = !racer.has_time_for_another(self.time);
        if racer.seconds() >= due || is_over {
            let point = racer.judge(self.reference, &self.display).or_bad_input()?;
            racer.curve.push(point);
        }
        Ok(())
    }
}

/// Lets all methods render until their time is over.
fn hold(racers: &mut [Racer], judge: &Judge<'_>, cancel: &CancelToken) -> Outcome {
    while let Some(next) = next_in_turn(racers, judge.time) {
        racers[next].iterate(cancel).map_err(interrupted)?;
        judge.look(&mut racers[next])?;
    }
    Ok(())
}

fn write_results(
    arguments: &RaceArguments,
    racers: &[Racer],
    scene: &Scene,
    pool: &WorkerPool,
    judge: &Judge<'_>,
    state: impl Fn(&RenderSettings) -> Box<State>,
) -> Outcome {
    if let Some(folder) = &arguments.pictures {
        for racer in racers {
            let file = folder.join(format!("{}.exr", racer.name.replace(':', "-")));
            write_film(racer, &file, scene, pool, state(racer.settings()))?;
        }
    }
    if let Some(file) = &arguments.csv {
        let text = csv(racers);
        write_atomically(file, |out| Ok(out.write_all(text.as_bytes())?))?;
    }
    let subtitle = format!(
        "{:.1} s of processor time each · {}×{}",
        arguments.time, judge.reference.width, judge.reference.height
    );
    let heading = [scene.name(), &subtitle];
    if let Some(file) = &arguments.svg {
        let racers = racers.iter().map(|r| (r.name.as_str(), &*r.curve));
        let racers: Vec<_> = racers.collect();
        let text = race_figure(heading, &racers);
        write_atomically(file, |out| Ok(out.write_all(text.as_bytes())?))?;
    }
    let images: Vec<Image> = racers.iter().map(Racer::image).collect();
    let pictures: Vec<RacePicture<'_>> = racers
        .iter()
        .zip(&images)
        .map(|(racer, image)| RacePicture {
            image,
            name: &racer.name,
            curve: &racer.curve,
        })
        .collect();
    let sheet = RaceSheet {
        heading,
        pictures: &pictures,
        reference: (judge.reference, ""),
        display: judge.display,
    };
    write_png(&arguments.output, &race_sheet(&sheet))?;
    if arguments.json {
        return console::json(&racers.iter().map(racer_json).collect::<Value>());
    }
    console::result(&table(racers))
}

fn table(racers: &[Racer]) -> String {
    let widest = racers.iter().map(|r| r.name.len()).max().unwrap_or(0);
    let mut lines = vec![format!(
        "{:widest$}  iterations  seconds  relMSE     FLIP",
        "method"
    )];
    for racer in racers {
        if let Some(p) = racer.curve.last() {
            lines.push(format!(
                "{:widest$}  {:<10}  {:<7.2}  {:<9.6}  {:.6}",
                racer.name, p.n_iterations, p.seconds, p.comparison.rel_mse, p.comparison.flip
            ));
        }
    }
    lines.join("\n")
}

fn csv(racers: &[Racer]) -> String {
    let mut lines = vec!["method,seconds,iterations,relmse,flip".to_owned()];
    for racer in racers {
        lines.extend(racer.curve.iter().map(|p| {
            format!(
                "\"{}\",{},{},{},{}",
                racer.name, p.seconds, p.n_iterations, p.comparison.rel_mse, p.comparison.flip
            )
        }));
    }
    lines.join("\n") + "\n"
}

fn racer_json(racer: &Racer) -> Value {
    let points = racer.curve.iter().map(|p| {
        json!({
            "seconds": p.seconds,
            "iterations": p.n_iterations,
            "rel_mse": p.comparison.rel_mse,
            "flip": p.comparison.flip,
        })
    });
    json!({ "method": racer.name, "curve": points.collect::<Value>() })
}
