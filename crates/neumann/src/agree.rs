//! `neumann agree`: do two methods make the same picture, bounce by bounce?
//!
//! The methods render batches in turn, with all threads, and each batch has a seed of its own. What
//! follows from the batches is [`Agreement`]'s to say.

mod report;

use std::sync::Arc;

use neumann_core::film::Film;
use neumann_core::render::{CancelToken, RenderSettings, Renderer, WorkerPool};
use neumann_core::scene::Scene;
use neumann_picture::agreement::{Agreement, Batches};
use neumann_picture::png_file::write_png;
use neumann_picture::race::{Entrant, processor_time};
use neumann_picture::sheet::{AgreementSheet, agreement_sheet};

use crate::cli::AgreeArguments;
use crate::console;
use crate::failure::{Outcome, answers_no, bad_input};
use crate::interrupt;
use crate::outputs::{self, Kind};
use report::Report;

pub(crate) fn run(arguments: &AgreeArguments) -> Outcome {
    let options = &arguments.settings;
    if !options.set.is_empty() {
        return Err(bad_input(
            "--set: each of the two methods has parameters of its own; write pt-mis:roulette=off",
        ));
    }
    if let Some(map) = &arguments.output {
        if outputs::kind(map)? != Kind::Png {
            return Err(bad_input(format!("{}: the map is a .png", map.display())));
        }
        outputs::check(std::slice::from_ref(map))?;
    }
    let (scene, common) = options.resolve(&arguments.scene)?;
    if let Some(map) = &arguments.output {
        let inputs = options.inputs(&arguments.scene, &scene);
        outputs::refuse_inputs(std::slice::from_ref(map), &inputs)?;
    }
    let [a, b] = &arguments.methods[..] else {
        return Err(bad_input("name two methods"));
    };
    let mut sides = [Side::new(a, &common)?, Side::new(b, &common)?];
    let pool = options.pool()?;
    let cancel = interrupt::token();
    for batch in 0..arguments.batches {
        for (number, side) in sides.iter_mut().enumerate() {
            // The batches of both methods are independent of each other too.
            let stream = u64::from(2 * batch) + number as u64;
            let length = match (side.n_iterations, arguments.iterations) {
                (0, Some(n)) => Length::Iterations(n),
                (0, None) => Length::Seconds(arguments.time / f64::from(arguments.batches)),
                (n, _) => Length::Iterations(n),
            };
            side.render(&scene, &pool, seed(common.seed, stream), length, &cancel)?;
        }
    }
    let batches = [&sides[0].batches, &sides[1].batches];
    let agreement = pool.run(|| Agreement::of(batches, arguments.level));
    let report = Report {
        scene: scene.name(),
        sides: &sides,
        agreement: &agreement,
    };
    if let Some(map) = &arguments.output {
        let (names, heading, lines) = (report.names(), report.heading(), report.verdict());
        let sheet = AgreementSheet {
            heading: [scene.name(), &heading],
            names: names.each_ref().map(String::as_str),
            n_layers: common.n_layers,
            agreement: &agreement,
            lines: &lines,
        };
        write_png(map, &agreement_sheet(&sheet))?;
    }
    if arguments.json {
        console::json(&report.json())?;
    } else {
        console::result(&report.text())?;
    }
    if agreement.holds() {
        Ok(())
    } else {
        Err(answers_no())
    }
}

/// One of the two methods, with what it has rendered.
struct Side {
    name: String,
    settings: RenderSettings,
    batches: Batches,
    /// Iterations of each batch, once that is known.
    n_iterations: u32,
    /// Processor time of all of them.
    seconds: f64,
}

/// How long a batch is.
#[derive(Clone, Copy)]
enum Length {
    Iterations(u32),
    Seconds(f64),
}

/// Of a batch; batches of different seeds of the whole are different, too.
fn seed(whole: u64, stream: u64) -> u64 {
    whole
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(stream)
}

impl Side {
    /// A method by its id, with parameters behind a colon: `pt-mis:roulette=off,casters=off`.
    fn new(name: &str, common: &RenderSettings) -> Outcome<Self> {
        let entrant = Entrant::parse(name).map_err(bad_input)?;
        Ok(Self {
            batches: Batches::new(common.width, common.height, common.n_layers),
            settings: entrant.settings(common),
            name: entrant.name,
            n_iterations: 0,
            seconds: 0.0,
        })
    }

    /// Renders one batch. The first one says how many iterations the others have.
    fn render(
        &mut self,
        scene: &Arc<Scene>,
        pool: &WorkerPool,
        seed: u64,
        length: Length,
        cancel: &CancelToken,
    ) -> Outcome {
        let settings = RenderSettings {
            seed,
            ..self.settings.clone()
        };
        let start = processor_time(pool);
        let mut film = Film::new(settings.width, settings.height, settings.n_layers);
        let mut renderer = Renderer::new(Arc::clone(scene), settings, pool.clone(), 0);
        loop {
            let iteration = renderer
                .iterate_after(&film, cancel)
                .map_err(|_| anyhow::anyhow!("interrupted; nothing was written"))?;
            pool.run(|| iteration.add_to(&mut film));
            let n = film.n_iterations();
            let is_over = match length {
                Length::Iterations(wanted) => n >= wanted,
                // One more would end further from it.
                Length::Seconds(wanted) => {
                    let seconds = processor_time(pool) - start;
                    seconds * (1.0 + 0.5 / f64::from(n)) >= wanted
                }
            };
            if is_over {
                break;
            }
        }
        self.seconds += processor_time(pool) - start;
        self.n_iterations = film.n_iterations();
        self.batches.take(&film);
        Ok(())
    }
}
