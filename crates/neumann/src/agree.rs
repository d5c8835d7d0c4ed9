//! `neumann agree`: do two methods make the same picture, bounce by bounce?
//!
//! The methods render batches in turn, with all threads, and each batch has a seed of its own. What
//! follows from the batches is [`Agreement`]'s to say.

mod json;

use neumann_core::render::RenderSettings;
use neumann_picture::agreement::{Agreement, Grain, Length, Report, Side, batch, seed};
use neumann_picture::png_file::write_png;
use neumann_picture::race::Entrant;
use neumann_picture::sheet::{AgreementSheet, agreement_sheet};

use crate::cli::AgreeArguments;
use crate::console;
use crate::failure::{Outcome, answers_no, bad_input, interrupted};
use crate::interrupt;
use crate::outputs;

pub(crate) fn run(arguments: &AgreeArguments) -> Outcome {
    let options = &arguments.settings;
    if !options.set.is_empty() {
        return Err(bad_input(
            "--set: each of the two methods has parameters of its own; write pt-mis:roulette=off",
        ));
    }
    outputs::check_map(arguments.output.as_ref())?;
    let (scene, common) = options.resolve(&arguments.scene)?;
    if let Some(map) = &arguments.output {
        let inputs = options.inputs(&arguments.scene, &scene);
        outputs::refuse_inputs(std::slice::from_ref(map), &inputs)?;
    }
    let [a, b] = &arguments.methods[..] else {
        return Err(bad_input("name two methods"));
    };
    let mut sides = [side(a, &common)?, side(b, &common)?];
    let pool = options.pool()?;
    let cancel = interrupt::token();
    for number_of_batch in 0..arguments.batches {
        for (number, side) in sides.iter_mut().enumerate() {
            // The batches of both methods are independent of each other too.
            let stream = u64::from(2 * number_of_batch) + number as u64;
            let length = match (side.n_iterations, arguments.iterations) {
                (0, Some(n)) => Length::Iterations(n),
                (0, None) => Length::Seconds(arguments.time / f64::from(arguments.batches)),
                (n, _) => Length::Iterations(n),
            };
            let settings = side.with_seed(seed(common.seed, stream));
            let rendered = batch(&scene, settings, length, &pool, &cancel);
            side.take(&rendered.map_err(|_| interrupted())?);
        }
    }
    let batches = [&sides[0].batches, &sides[1].batches];
    let agreement = pool.run(|| Agreement::of(batches, arguments.level));
    let report = Report {
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
            grain: Grain::Blocks,
            lines: &lines,
        };
        write_png(map, &agreement_sheet(&sheet))?;
    }
    if arguments.json {
        console::json(&json::json(scene.name(), &report))?;
    } else {
        console::result(&report.text())?;
    }
    if agreement.holds() {
        Ok(())
    } else {
        Err(answers_no())
    }
}

/// A method by its id, with parameters behind a colon: `pt-mis:roulette=off,casters=off`.
fn side(name: &str, common: &RenderSettings) -> Outcome<Side> {
    Ok(Side::new(Entrant::parse(name).map_err(bad_input)?, common))
}
