//! `neumann hemisphere`: the reflection equation at the surface point that a pixel shows.

use std::sync::Arc;

use neumann_core::film::{Film, View};
use neumann_core::radiometry::Rgb;
use neumann_core::render::hemisphere::{Estimator, Integrand, Moment, settings_of_ray};
use neumann_core::render::{
    CancelToken, Hemisphere, Measured, RenderSettings, Renderer, WorkerPool,
};
use neumann_core::scene::Scene;
use neumann_picture::figures::significant;
use neumann_picture::hemisphere::{figures, points};
use neumann_picture::png_file::write_png;
use neumann_picture::sheet::{HemisphereSheet, hemisphere_sheet};
use serde_json::{Value, json};

use crate::cli::HemisphereArguments;
use crate::console;
use crate::failure::{Outcome, bad_input};
use crate::interrupt;
use crate::outputs::{self, Kind};
use crate::paths;
use crate::progress::while_waiting;

/// Pixels of the diameter of a disk.
const EDGE: usize = 96;
/// Renders of the reference, which differ in their seed alone,
const N_RENDERS: u32 = 16;
/// and 97.5 of 100 of Student's variables for as many lie below this.
const STUDENT: f64 = 2.131;

pub(crate) fn run(arguments: &HemisphereArguments) -> Outcome {
    let settings = &arguments.settings;
    if let Some(sheet) = &arguments.output {
        if outputs::kind(sheet)? != Kind::Png {
            let name = sheet.display();
            return Err(bad_input(format!("{name}: the sheet is a .png")));
        }
        outputs::check(std::slice::from_ref(sheet))?;
    }
    let (scene, wanted) = settings.resolve(&arguments.scene)?;
    if let Some(sheet) = &arguments.output {
        let inputs = settings.inputs(&arguments.scene, &scene);
        outputs::refuse_inputs(std::slice::from_ref(sheet), &inputs)?;
    }
    let [x, y] = arguments.pixel;
    paths::check_pixel([x, y], &wanted)?;
    let method = wanted.method;
    if !(method.build)(&wanted.values).adds_to_own_pixels() {
        return Err(bad_input(format!(
            "--integrator {}: one ray is rendered for comparison, which paths from lights do not \
             find; use one that traces paths from the camera, such as pt-mis",
            method.id
        )));
    }
    let mut found = Hemisphere::new(Arc::clone(&scene), &wanted, [x, y], EDGE)
        .map_err(|error| bad_input(format!("--pixel {x},{y}: {error}")))?;
    let pool = settings.pool()?;
    let cancel = interrupt::token();
    let reference = while_waiting("looking around", || {
        for _ in 0..arguments.samples {
            found.add_pass(&pool, &cancel)?;
        }
        Reference::render(&scene, &wanted, arguments, &pool, &cancel)
    })?;
    if let Some(file) = &arguments.output {
        let point = format!(
            "the point that pixel {x}, {y} of {}×{} shows · {} directions a pixel",
            wanted.width, wanted.height, arguments.samples
        );
        let name = format!("the pixel by {}", method.id);
        let sheet = HemisphereSheet {
            heading: [scene.name(), &point],
            hemisphere: &found,
            reference: Some((&name, reference.mean, Some(reference.interval))),
            part: View::Total,
            display: arguments
                .display
                .display(|| found.picture(Integrand::Incident, View::Total)),
        };
        write_png(file, &hemisphere_sheet(&sheet))?;
    }
    if arguments.json {
        return console::json(&as_json(arguments, &scene, &found, &reference));
    }
    console::result(&as_text(arguments, &found, &reference))
}

/// The radiance along the same ray, luminance, by a method that renders pictures.
struct Reference {
    mean: f64,
    interval: f64,
}

impl Reference {
    fn render(
        scene: &Arc<Scene>,
        wanted: &RenderSettings,
        arguments: &HemisphereArguments,
        pool: &WorkerPool,
        cancel: &CancelToken,
    ) -> Outcome<Self> {
        let mut luminances = Vec::new();
        let settings = settings_of_ray(wanted, arguments.pixel);
        for render in 0..N_RENDERS {
            let mut settings = settings.clone();
            settings.seed = settings.seed.wrapping_add(u64::from(render) + 1);
            let mut renderer = Renderer::new(Arc::clone(scene), settings, pool.clone(), 0);
            let s = renderer.settings();
            let mut film = Film::new(s.width, s.height, s.n_layers);
            for _ in 0..arguments.samples.div_ceil(2) {
                renderer.iterate_after(&film, cancel)?.add_to(&mut film);
            }
            let mut pixels = vec![Rgb::BLACK; film.n_pixels()];
            film.compose(View::Total, &mut pixels);
            let sum: f64 = pixels.iter().map(|v| f64::from(v.luminance())).sum();
            luminances.push(sum / pixels.len() as f64);
        }
        let n = f64::from(N_RENDERS);
        let mean = luminances.iter().sum::<f64>() / n;
        let squares: f64 = luminances.iter().map(|v| (v - mean).powi(2)).sum();
        Ok(Self {
            mean,
            interval: STUDENT * (squares / (n - 1.0) / n).sqrt(),
        })
    }
}

fn as_text(arguments: &HemisphereArguments, found: &Hemisphere, reference: &Reference) -> String {
    let [x, y] = arguments.pixel;
    let emitted = f64::from(found.emitted().luminance());
    let mut lines = vec![
        format!("pixel {x}, {y}: L_o = L_e + ∫ L_i f cos θ dω, luminance, W m⁻² sr⁻¹"),
        format!("{:<16}  {}", "L_e", significant(emitted, 4)),
        "the integral by".to_owned(),
    ];
    let figures = figures(found);
    let line = |name: &str, text: &str| format!("  {name:<14}  {text}");
    lines.extend(figures.iter().map(|f| line(f.name, &f.text)));
    let method = arguments.settings.integrator.as_str();
    let of_pixel = format!(
        "{} ± {}  (the pixel less L_e)",
        significant(reference.mean - emitted, 4),
        significant(reference.interval, 2)
    );
    lines.push(line(method, &of_pixel));
    lines.extend(points(found));
    lines.join("\n")
}

fn as_json(
    arguments: &HemisphereArguments,
    scene: &Scene,
    found: &Hemisphere,
    reference: &Reference,
) -> Value {
    let estimators: serde_json::Map<String, Value> = Estimator::ALL
        .into_iter()
        .map(|estimator| {
            let running = found.estimate_by(estimator);
            let mut of = measured(&running.measured());
            of["paths"] = json!(running.n());
            let course = running.moments();
            of["course"] = course.iter().map(moment).collect();
            (estimator.id().to_owned(), of)
        })
        .collect();
    let points = found.points().iter().map(|point| {
        let kind = if point.is_light { "light" } else { "lobe" };
        json!({"direction": point.direction.to_array(), "kind": kind})
    });
    json!({
        "scene": scene.name(),
        "seed": arguments.settings.seed,
        "pixel": arguments.pixel,
        "samples": found.n_passes(),
        "emitted": found.emitted().to_array(),
        "estimators": estimators,
        "pictures": measured(&found.integral()),
        "points": {
            "value": found.sum_of_points().mean.to_array(),
            "directions": points.collect::<Vec<_>>(),
        },
        "reference": {
            "integrator": arguments.settings.integrator,
            "luminance": reference.mean,
            "interval": reference.interval,
        },
    })
}

fn measured(of: &Measured) -> Value {
    json!({
        "value": of.mean.to_array(),
        "luminance": of.mean.luminance(),
        "interval": of.interval,
    })
}

fn moment(of: &Moment) -> Value {
    json!({"n": of.n, "luminance": of.mean, "interval": of.interval})
}
