//! `neumann inspect`: why a pixel is as bright as it is, and which pixels to ask about.

mod fireflies;

use neumann_core::expression::Expression;
use neumann_core::render::{
    CancelToken, Inspection, Measured, Renderer, Replayed, SampleCount, WayShare,
};
use neumann_core::scene::Scene;
use neumann_picture::figures::significant;
use neumann_picture::inspection::{self, percent};
use serde_json::{Value, json};

use crate::cli::InspectArguments;
use crate::console;
use crate::failure::{Outcome, bad_input};
use crate::interrupt;
use crate::paths;
use crate::progress::while_waiting;

/// Characters of the longest bar.
const BAR: u32 = 40;

pub(crate) fn run(arguments: &InspectArguments) -> Outcome {
    let (scene, settings) = arguments.settings.resolve(&arguments.scene)?;
    let Some(pixel) = arguments.pixel else {
        return fireflies::run(arguments, &scene, settings);
    };
    paths::check_pixel(pixel, &settings)?;
    let only = arguments.only.as_deref();
    let only = only.map(|text| Expression::new(text, &scene)).transpose();
    let only = only.map_err(|error| {
        console::note(&error.marked());
        bad_input(format!("--only: {error}"))
    })?;
    let pool = arguments.settings.pool()?;
    let renderer = Renderer::new(scene.clone(), settings, pool, 0);
    let cancel = interrupt::token();
    let inspected = while_waiting("walking the paths once more", || {
        inspect(&renderer, arguments.iterations, &[pixel], &cancel)
    })?;
    let inspected = inspected.into_iter().next().unwrap_or_default();
    let shown = Shown {
        arguments,
        scene: &scene,
        inspected: &inspected,
        only,
    };
    if arguments.json {
        console::json(&shown.as_json())
    } else {
        console::result(&shown.as_text())
    }
}

/// The first iterations of some pixels.
fn inspect(
    renderer: &Renderer,
    n_iterations: u32,
    pixels: &[[u32; 2]],
    cancel: &CancelToken,
) -> Outcome<Vec<Inspection>> {
    let mut inspected = vec![Inspection::default(); pixels.len()];
    for iteration in 0..n_iterations {
        let replayed = renderer.replay(iteration, pixels, cancel)?;
        for (inspected, replayed) in inspected.iter_mut().zip(replayed) {
            inspected.add(iteration, replayed);
        }
    }
    Ok(inspected)
}

/// What was found, and what of it is wanted.
struct Shown<'a> {
    arguments: &'a InspectArguments,
    scene: &'a Scene,
    inspected: &'a Inspection,
    only: Option<Expression>,
}

impl Shown<'_> {
    fn wants_way(&self, way: &WayShare<'_>) -> bool {
        let of_bounce = self
            .arguments
            .bounce
            .is_none_or(|k| way.bounces.len() == k as usize);
        let only = self.only.as_ref();
        of_bounce && only.is_none_or(|only| only.matches(way.bounces, way.source))
    }

    fn wants_path(&self, path: &Replayed) -> bool {
        let strategy = path.contribution.strategy;
        let of_technique = self
            .arguments
            .technique
            .is_none_or(|st| st == [strategy.s, strategy.t]);
        let of_bounce = self
            .arguments
            .bounce
            .is_none_or(|k| path.contribution.bounce == k);
        let only = self.only.as_ref();
        of_technique
            && of_bounce
            && only.is_none_or(|only| !only.share(&path.scattered(), path.source()).is_black())
    }

    fn ways(&self) -> Vec<WayShare<'_>> {
        let mut ways = self.inspected.ways();
        ways.retain(|way| self.wants_way(way));
        ways
    }

    /// The share of the pixel that has come by all ways that are wanted.
    fn share(&self) -> f64 {
        let sum: f64 = self.ways().iter().map(|way| way.luminance).sum();
        self.share_of(sum)
    }

    fn share_of(&self, luminance: f64) -> f64 {
        let total = f64::from(self.inspected.total().mean.luminance());
        if total > 0.0 { luminance / total } else { 0.0 }
    }

    fn paths(&self) -> impl Iterator<Item = &(u32, Replayed)> {
        let wanted = self.inspected.paths().iter();
        let wanted = wanted.filter(|(_, path)| self.wants_path(path));
        wanted.take(self.arguments.list as usize)
    }

    fn as_text(&self) -> String {
        let inspected = self.inspected;
        let mut lines = vec![inspection::sentence(inspected, self.scene), String::new()];
        lines.push(
            "bounce     value (R G B)                   ± 95 %     share    paths".to_owned(),
        );
        for (k, measured) in inspected.bounces().enumerate() {
            if measured.n_paths > 0 {
                lines.push(self.line(&format!("T{k}"), &measured));
            }
        }
        lines.push(self.line("L", &inspected.total()));
        lines.push(String::new());
        lines.push(
            "technique  value with its weight           ± 95 %     share    paths".to_owned(),
        );
        for (strategy, measured) in inspected.techniques() {
            lines.push(self.line(&paths::technique(strategy), &measured));
        }
        lines.push(String::new());
        lines.push("luminance of single iterations".to_owned());
        lines.extend(self.distribution());
        lines.push(String::new());
        lines.push("   share    paths  way from the eye to the light".to_owned());
        for way in self.ways().iter().take(self.arguments.list as usize) {
            let (share, n) = (percent(self.share_of(way.luminance)), way.n_paths);
            lines.push(format!(
                "{share:>8}  {n:>7}  {}",
                inspection::way(way.bounces)
            ));
        }
        if let Some(only) = &self.only {
            lines.push(format!(
                "{:>8}  all of {}",
                percent(self.share()),
                only.text()
            ));
        }
        lines.push(String::new());
        lines.push("   share  iteration  technique  weight  path".to_owned());
        for (iteration, path) in self.paths() {
            let contribution = &path.contribution;
            let of_one = self.share_of(f64::from(path.value().luminance()));
            lines.push(format!(
                "{:>8}  {iteration:>9}  {:<9}  {:>6.4}  {}",
                percent(of_one / f64::from(inspected.n_iterations())),
                paths::technique(contribution.strategy),
                contribution.mis_weight,
                inspection::path(path)
            ));
        }
        lines.join("\n")
    }

    fn line(&self, name: &str, measured: &Measured) -> String {
        let share = percent(self.share_of(f64::from(measured.mean.luminance())));
        let interval = measured
            .interval
            .map_or_else(|| "?".to_owned(), |i| significant(i, 2));
        let n = measured.n_paths;
        let value = paths::color(measured.mean);
        format!("{name:<9}  {value}  {interval:<9}  {share:<7}  {n}")
    }

    /// A bar for each bin.
    fn distribution(&self) -> Vec<String> {
        let n_zeros = self.inspected.n_zeros();
        let largest = self
            .inspected
            .samples()
            .map(|bin| bin.n)
            .fold(n_zeros, u32::max);
        let line = |name: String, n: u32| {
            let bar = "#".repeat((BAR * n).div_ceil(largest.max(1)) as usize);
            format!("{name:>22}  {n:>7}  {bar}").trim_end().to_owned()
        };
        let of_bin = |bin: SampleCount| {
            let [least, most] = bin.range.map(|edge| significant(edge, 2));
            line(format!("{least} to {most}"), bin.n)
        };
        let zeros = line("0".to_owned(), n_zeros);
        std::iter::once(zeros)
            .chain(self.inspected.samples().map(of_bin))
            .collect()
    }

    fn as_json(&self) -> Value {
        let (arguments, inspected) = (self.arguments, self.inspected);
        let bounces: Vec<Value> = inspected.bounces().map(|of| measured(&of)).collect();
        let techniques = inspected.techniques().map(|(strategy, of)| {
            let mut of = measured(&of);
            of["technique"] = paths::technique_json(strategy);
            of["bounce"] = json!(strategy.bounce());
            of
        });
        let samples = inspected
            .samples()
            .map(|bin| json!({"from": bin.range[0], "to": bin.range[1], "n": bin.n}));
        let ways = self.ways();
        let name = |index| inspection::material(self.scene, index);
        let ways = ways.iter().take(arguments.list as usize).map(|way| {
            let materials = way.bounces.iter().map(|bounce| name(bounce.material));
            json!({
                "way": inspection::way(way.bounces),
                "materials": materials.collect::<Vec<_>>(),
                "source": way.source.and_then(|source| inspection::source_name(self.scene, source)),
                "share": self.share_of(way.luminance),
                "paths": way.n_paths,
            })
        });
        let paths = self.paths().map(|(iteration, path)| {
            let mut of = paths::json(self.scene, path);
            of["iteration"] = json!(iteration);
            of
        });
        json!({
            "scene": self.scene.name(),
            "integrator": arguments.settings.integrator,
            "seed": arguments.settings.seed,
            "iterations": inspected.n_iterations(),
            "pixel": arguments.pixel,
            "sentence": inspection::sentence(inspected, self.scene),
            "total": measured(&inspected.total()),
            "bounces": bounces,
            "techniques": techniques.collect::<Vec<_>>(),
            "samples": {"zeros": inspected.n_zeros(), "bins": samples.collect::<Vec<_>>()},
            "only": self.only.as_ref().map(Expression::text),
            "share": self.share(),
            "ways": ways.collect::<Vec<_>>(),
            "paths": paths.collect::<Vec<_>>(),
        })
    }
}

fn measured(of: &Measured) -> Value {
    json!({
        "value": of.mean.to_array(),
        "interval": of.interval,
        "paths": of.n_paths,
    })
}
