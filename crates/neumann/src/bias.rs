//! `neumann bias`: how much of the error is noise, and how much the bias of a radius?

use neumann_picture::agreement::seed;
use neumann_picture::false_colour::ColourMap;
use neumann_picture::png_file::write_png;
use neumann_picture::race::Entrant;
use neumann_picture::radius_bias::{PartError, Radii, RadiusBias, Report, Split, pair, planes};
use neumann_picture::sheet::{RadiusBiasSheet, radius_bias_sheet};
use serde_json::{Value, json};

use crate::cli::BiasArguments;
use crate::console;
use crate::failure::{Outcome, bad_input, interrupted};
use crate::interrupt;
use crate::outputs;

pub(crate) fn run(arguments: &BiasArguments) -> Outcome {
    let options = &arguments.settings;
    if !options.set.is_empty() {
        let text = "--set: the method has its parameters behind a colon; write ppm:radius=0.01";
        return Err(bad_input(text));
    }
    outputs::check_map(arguments.output.as_ref())?;
    let (scene, common) = options.resolve(&arguments.scene)?;
    if let Some(map) = &arguments.output {
        let inputs = options.inputs(&arguments.scene, &scene);
        outputs::refuse_inputs(std::slice::from_ref(map), &inputs)?;
    }
    let entrant = Entrant::parse(&arguments.method).map_err(bad_input)?;
    let n_iterations = arguments.iterations;
    let settings = entrant.settings(&common);
    let radii = Radii::of(&scene, &settings, n_iterations).map_err(bad_input)?;
    let mut found = RadiusBias::new(common.width, common.height, common.n_layers, radii.q);
    let views = found.views();
    let view = views.iter().position(|view| *view == arguments.view);
    let view = view.ok_or_else(|| {
        let text = "is not measured; name L, tail, or a term that is kept apart";
        bad_input(format!("--view: {} {text}", arguments.view))
    })?;
    let pool = options.pool()?;
    let cancel = interrupt::token();
    for render in 0..arguments.renders {
        let length = (n_iterations, seed(common.seed, render.into()));
        let films = pair(&scene, &radii, length, &pool, &cancel);
        let [wide, narrow] = films.map_err(|_| interrupted())?;
        found.take(&wide, &narrow);
    }
    let parts = pool.run(|| found.parts());
    let report = Report {
        name: &entrant.name,
        radii: &radii,
        n_iterations,
        n_renders: found.n(),
        parts: &parts,
    };
    if let Some(map) = &arguments.output {
        let mut lines = report.sentences(arguments.view).to_vec();
        lines.extend(report.notes());
        let sheet = RadiusBiasSheet {
            heading: [scene.name().to_owned(), report.heading()],
            planes: &pool.run(|| planes(&found, view)),
            map: ColourMap::default(),
            lines,
        };
        write_png(map, &radius_bias_sheet(&sheet))?;
    }
    if arguments.json {
        console::json(&as_json(scene.name(), &report))
    } else {
        console::result(&report.text())
    }
}

fn as_json(scene: &str, report: &Report<'_>) -> Value {
    let split = |split: Split| {
        json!({
            "error": split.error(),
            "noise": split.noise,
            "bias": split.bias,
        })
    };
    let term = |part: &PartError| {
        json!({
            "term": part.view.to_string(),
            "mean": part.mean,
            "at_radius": split(part.here),
            "at_half": split(part.at_half),
            "bias_range": part.bias_range,
            "bias_is_seen": part.has_bias(),
        })
    };
    json!({
        "scene": scene,
        "method": report.name,
        "iterations": report.n_iterations,
        "renders": report.n_renders,
        "radius_metres": report.radii.radius,
        "terms": report.parts.iter().map(term).collect::<Value>(),
    })
}
