//! `neumann race`: methods at equal processor time, against one reference.
//!
//! The method that has had the least time is next, with all threads. What is measured is the
//! processor time of the whole process while a method renders; comparisons are not counted.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use cpu_time::ProcessTime;
use neumann_core::film::{Features, Film};
use neumann_core::integrator::{ParameterValues, method};
use neumann_core::memory::Share;
use neumann_core::render::{CancelToken, RenderSettings, Renderer, WorkerPool};
use neumann_core::scene::Scene;
use neumann_picture::Image;
use neumann_picture::compare::{Comparison, compare};
use neumann_picture::exr_file::{IterationRanges, Metadata, Precision};
use neumann_picture::figures::significant;
use neumann_picture::files::write_atomically;
use neumann_picture::image_file::read_layer;
use neumann_picture::png_file::write_png;
use neumann_picture::sheet::{RacePicture, race_sheet};
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
/// What renders the reference: unbiased, and as good at caustics as at direct light.
const REFERENCE_METHOD: &str = "bdpt";

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
    let (scene, common) = settings.resolve(&arguments.scene)?;
    let inputs = settings.inputs(&arguments.scene, &scene);
    outputs::refuse_inputs(std::slice::from_ref(sheet), &inputs)?;
    let mut racers = racers(&arguments.methods, &common)?;
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
            let mut racer = Racer::new(REFERENCE_METHOD, &common)?;
            let file = sheet.with_extension("reference.exr");
            outputs::check(std::slice::from_ref(&file))?;
            console::note(&format!(
                "rendering the reference by {REFERENCE_METHOD}; --reference {} uses it again",
                file.display()
            ));
            let seconds = REFERENCE_TIME * arguments.time;
            let mut renderer = racer.renderer(&scene, &pool);
            while racer.has_time_for_another(seconds) {
                racer.iterate(&mut renderer, &pool, &cancel)?;
            }
            drop(renderer);
            racer.write(&file, &scene, &pool, state(&racer.settings))?;
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
    hold(&mut racers, &scene, &pool, &judge, &cancel)?;
    write_results(arguments, &racers, &scene, &pool, &judge, state)
}

/// A method in the race, with what it has rendered.
struct Racer {
    name: String,
    settings: RenderSettings,
    film: Film,
    seconds: f64,
    curve: Vec<Point>,
}

/// How far a method had come.
struct Point {
    seconds: f64,
    n_iterations: u32,
    comparison: Comparison,
}

/// The methods that were named.
fn racers(names: &[String], common: &RenderSettings) -> Outcome<Vec<Racer>> {
    let mut racers: Vec<Racer> = Vec::with_capacity(names.len());
    for name in names {
        if racers.iter().any(|racer| racer.name == *name) {
            return Err(bad_input(format!("{name}: is named twice")));
        }
        racers.push(Racer::new(name, common)?);
    }
    Ok(racers)
}

impl Racer {
    /// A method by its id, with parameters behind a colon: `pt-mis:roulette=off,casters=off`.
    fn new(name: &str, common: &RenderSettings) -> Outcome<Self> {
        let (id, set) = name.split_once(':').unwrap_or((name, ""));
        let method = method(id).ok_or_else(|| {
            bad_input(format!(
                "no integrator '{id}'; 'neumann list integrators' names them"
            ))
        })?;
        let mut values = ParameterValues::defaults(method.parameters);
        for assignment in set.split(',').filter(|text| !text.is_empty()) {
            let (parameter, value) = assignment
                .split_once('=')
                .ok_or_else(|| bad_input(format!("{name}: '{assignment}' is no NAME=VALUE")))?;
            values
                .set(method.parameters, parameter, value)
                .map_err(|e| bad_input(format!("{name}: {e}")))?;
        }
        let settings = RenderSettings {
            method,
            values,
            ..common.clone()
        };
        Ok(Self {
            name: name.to_owned(),
            film: Film::new(settings.width, settings.height, settings.n_layers),
            settings,
            seconds: 0.0,
            curve: Vec::new(),
        })
    }

    fn renderer(&self, scene: &Arc<Scene>, pool: &WorkerPool) -> Renderer {
        Renderer::new(Arc::clone(scene), self.settings.clone(), pool.clone(), 0)
    }

    /// Whether one more iteration brings it nearer to a time than it is.
    fn has_time_for_another(&self, seconds: f64) -> bool {
        let n = self.film.n_iterations();
        n == 0 || self.seconds + 0.5 * self.seconds / f64::from(n) < seconds
    }

    fn iterate(
        &mut self,
        renderer: &mut Renderer,
        pool: &WorkerPool,
        cancel: &CancelToken,
    ) -> Outcome {
        let start = ProcessTime::now();
        let iteration = renderer
            .iterate_after(&self.film, cancel)
            .map_err(|_| anyhow::anyhow!("interrupted; nothing was written"))?;
        pool.run(|| iteration.add_to(&mut self.film));
        self.seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    fn image(&self) -> Image {
        Image {
            width: self.settings.width,
            height: self.settings.height,
            pixels: self.film.total(),
            layers: BTreeMap::new(),
        }
    }

    /// Writes all layers.
    fn write(&self, file: &Path, scene: &Scene, pool: &WorkerPool, state: Box<State>) -> Outcome {
        let s = &self.settings;
        let mut metadata = Metadata::of(scene, s);
        metadata.state = Some(state);
        metadata.seconds = self.seconds;
        metadata.iterations = IterationRanges::of(0..self.film.n_iterations());
        metadata.n_refused = self.film.n_refused();
        let features = pool.run(|| Features::trace(scene, &s.camera, s.width, s.height));
        let picture = Picture {
            film: &self.film,
            features: Some(&features),
            metadata: &metadata,
            display: Display::default(),
            precision: Precision::Full,
        };
        picture.write(file)
    }
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
        if racer.seconds < due && !is_over {
            return Ok(());
        }
        let comparison = compare(&racer.image(), self.reference, &self.display).or_bad_input()?;
        racer.curve.push(Point {
            seconds: racer.seconds,
            n_iterations: racer.film.n_iterations(),
            comparison,
        });
        Ok(())
    }
}

/// Lets all methods render until their time is over.
fn hold(
    racers: &mut [Racer],
    scene: &Arc<Scene>,
    pool: &WorkerPool,
    judge: &Judge<'_>,
    cancel: &CancelToken,
) -> Outcome {
    let mut renderers: Vec<_> = racers.iter().map(|r| r.renderer(scene, pool)).collect();
    loop {
        let waiting = racers
            .iter_mut()
            .zip(&mut renderers)
            .filter(|(racer, _)| racer.has_time_for_another(judge.time));
        let next = waiting.min_by(|a, b| a.0.seconds.total_cmp(&b.0.seconds));
        let Some((racer, renderer)) = next else {
            return Ok(());
        };
        racer.iterate(renderer, pool, cancel)?;
        judge.look(racer)?;
    }
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
            racer.write(&file, scene, pool, state(&racer.settings))?;
        }
    }
    if let Some(file) = &arguments.csv {
        let text = csv(racers);
        write_atomically(file, |out| Ok(out.write_all(text.as_bytes())?))?;
    }
    let images: Vec<Image> = racers.iter().map(Racer::image).collect();
    let mut pictures: Vec<RacePicture<'_>> = racers
        .iter()
        .zip(&images)
        .filter_map(|(racer, image)| {
            let point = racer.curve.last()?;
            Some(RacePicture {
                image,
                name: racer.name.clone(),
                lines: vec![
                    format!("{} iterations, {:.1} s", point.n_iterations, point.seconds),
                    format!(
                        "relMSE {}, FLIP {}",
                        significant(point.comparison.rel_mse, 3),
                        significant(point.comparison.flip, 3)
                    ),
                ],
            })
        })
        .collect();
    pictures.push(RacePicture {
        image: judge.reference,
        name: "reference".to_owned(),
        lines: Vec::new(),
    });
    let subtitle = format!(
        "{:.1} s of processor time each · {}×{}",
        arguments.time, judge.reference.width, judge.reference.height
    );
    let heading = [scene.name(), subtitle.as_str()];
    write_png(
        &arguments.output,
        &race_sheet(&pictures, heading, &judge.display),
    )?;
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
