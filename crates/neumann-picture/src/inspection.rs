//! An inspected pixel in words: by which ways light has come, and what happened on them.

use std::collections::BTreeMap;

use neumann_core::film::{Joint, Strategy};
use neumann_core::render::{Inspection, Replayed};
use neumann_core::scene::Scene;
use neumann_core::transport::{Bounce, Lobe, Source};

use crate::figures::significant;

/// A surface that this share of a bounce has come by is worth a word.
const WORTH_NAMING: f64 = 0.5;

/// A step that multiplies a path by this is worth a word.
const WORTH_TELLING: f64 = 1.5;

/// What a bounce is written as: `D`, `G` or `S` for its lobe, `t` behind it where light passes
/// through the surface.
#[must_use]
pub fn letters(bounce: &Bounce) -> &'static str {
    match (bounce.lobe, bounce.is_transmission) {
        (Lobe::Diffuse, false) => "D",
        (Lobe::Diffuse, true) => "Dt",
        (Lobe::Glossy, false) => "G",
        (Lobe::Glossy, true) => "Gt",
        (Lobe::Specular, false) => "S",
        (Lobe::Specular, true) => "St",
    }
}

/// A way from the eye to the light: `E D St L`.
#[must_use]
pub fn way(bounces: &[Bounce]) -> String {
    let mut words = vec!["E"];
    words.extend(bounces.iter().map(letters));
    words.push("L");
    words.join(" ")
}

/// A path from the eye to the light, with how its two parts were joined: `-` is a connection, `=` a
/// merge.
#[must_use]
pub fn path(path: &Replayed) -> String {
    let Strategy { s, t, joint } = path.contribution.strategy;
    let bounces = path.bounces();
    let mut words = vec!["E"];
    words.extend(bounces.iter().map(letters));
    words.push("L");
    let t = usize::from(t);
    match joint {
        // A part by itself has run into the other end.
        Joint::Hit => {}
        Joint::Connect => words.insert(t, "-"),
        // One point, which is written on both sides.
        Joint::Merge if t > 0 && s > 0 => {
            words.insert(t, words[t - 1]);
            words.insert(t, "=");
        }
        Joint::Merge => {}
    }
    words.join(" ")
}

/// The name of what light comes from, if it has one.
#[must_use]
pub fn source_name(scene: &Scene, source: Source) -> Option<&str> {
    match source {
        Source::Material(index) => material(scene, Some(index)),
        Source::Punctual(index) => {
            let light = scene.appearance().lights.get(index as usize)?;
            Some(light.name.as_str()).filter(|name| !name.is_empty())
        }
        Source::Environment => Some("environment"),
    }
}

/// A material by its name.
#[must_use]
pub fn material(scene: &Scene, index: Option<u32>) -> Option<&str> {
    let material = scene.materials().get(index? as usize)?;
    Some(&material.parameters().name)
        .filter(|name| !name.is_empty())
        .map(String::as_str)
}

/// Where most of the light of the pixel comes from, and what the largest contribution is worth, in
/// a sentence.
#[must_use]
pub fn sentence(inspection: &Inspection, scene: &Scene) -> String {
    let n_iterations = inspection.n_iterations();
    let total = f64::from(inspection.total().mean.luminance());
    if total <= 0.0 {
        return format!("No light has come here in {}.", iterations(n_iterations));
    }
    let luminances = inspection
        .bounces()
        .map(|of| f64::from(of.mean.luminance()));
    let brightest = luminances
        .enumerate()
        .max_by(|(_, a), (_, b)| a.total_cmp(b));
    let (bounce, luminance) = brightest.unwrap_or((0, total));
    let arrives = match bounce {
        0 => format!("comes straight from {}", source(inspection, scene)),
        1 => "arrives after one bounce".to_owned(),
        n => format!("arrives after {} bounces", number(n)),
    };
    let by = by_way_of(inspection, scene, bounce, luminance)
        .map(|name| format!(" by way of '{name}'"))
        .unwrap_or_default();
    let largest = inspection.paths().first().map_or(0.0, |(_, path)| {
        f64::from(path.value().luminance()) / (total * f64::from(n_iterations))
    });
    let n = inspection.n_paths();
    let largest = match n {
        0 | 1 => String::new(),
        _ => format!("; one path of {n} carries {}", percent(largest)),
    };
    let share = luminance / total;
    let share = match share {
        share if share > 0.9995 => "All".to_owned(),
        share => percent(share),
    };
    format!("{share} of this pixel {arrives}{by}{largest}.")
}

/// What emits most of the light that is seen itself.
fn source(inspection: &Inspection, scene: &Scene) -> String {
    let ways = inspection.ways();
    let brightest = ways.iter().find(|way| way.bounces.is_empty());
    match brightest.and_then(|way| way.source) {
        Some(Source::Environment) => "the surroundings".to_owned(),
        Some(source) => source_name(scene, source)
            .map_or_else(|| "a light".to_owned(), |name| format!("'{name}'")),
        None => "a light".to_owned(),
    }
}

/// The material that most of the light of a bounce is scattered by before it comes to what is seen
/// in the pixel.
fn by_way_of<'a>(
    inspection: &Inspection,
    scene: &'a Scene,
    bounce: usize,
    luminance: f64,
) -> Option<&'a str> {
    let mut shares: BTreeMap<Option<u32>, f64> = BTreeMap::new();
    for way in inspection.ways() {
        if way.bounces.len() == bounce && bounce > 1 {
            *shares.entry(way.bounces[1].material).or_default() += way.luminance;
        }
    }
    let (index, share) = shares.into_iter().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    (share > WORTH_NAMING * luminance)
        .then(|| material(scene, index))
        .flatten()
}

/// A number in a sentence.
fn number(n: usize) -> String {
    const WORDS: [&str; 10] = [
        "no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine",
    ];
    WORDS
        .get(n)
        .map_or_else(|| n.to_string(), |word| (*word).to_owned())
}

/// Why a path is rare, in a sentence: at which of its vertices it was multiplied most, since the
/// direction that it went on in had a small density for what it carries, and whether another
/// technique would have found it more often.
#[must_use]
pub fn rarity(path: &Replayed, scene: &Scene) -> String {
    let walked = path.camera.iter().chain(&path.light);
    let gains = walked.filter_map(|vertex| {
        let event = vertex.event.filter(|event| event.lobe != Lobe::Specular)?;
        let gain = event.f_cos.max_channel() / (event.pdf_w * event.survival);
        Some((vertex, event, f64::from(gain)))
    });
    let most = gains.max_by(|(.., a), (.., b)| a.total_cmp(b));
    let step = most.filter(|(.., gain)| *gain > WORTH_TELLING);
    let step = step.map_or_else(
        || "No step of it is rare by itself.".to_owned(),
        |(vertex, event, gain)| {
            let at = material(scene, vertex.material);
            let at = at.map(|name| format!(" at '{name}'")).unwrap_or_default();
            let density = significant(f64::from(event.pdf_w), 2);
            let times = significant(gain, 2);
            format!("The step{at} had density {density} sr⁻¹ and multiplies it by {times}.")
        },
    );
    let Strategy { t, joint, .. } = path.contribution.strategy;
    let weight = f64::from(path.contribution.mis_weight);
    let others = if weight < 0.5 {
        "other techniques find such paths more often"
    } else {
        "no other technique finds such paths more often"
    };
    let chance = match joint {
        Joint::Hit if t == 0 => "it met the lens by chance, and ",
        Joint::Hit => "it met the light by chance, and ",
        Joint::Connect | Joint::Merge => "",
    };
    format!(
        "{step} Its weight is {}: {chance}{others}.",
        significant(weight, 2)
    )
}

/// A share in percent.
#[must_use]
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent > 0.0 && percent < 0.1 {
        "< 0.1 %".to_owned()
    } else {
        format!("{} %", significant(percent, 2))
    }
}

fn iterations(n: u32) -> String {
    match n {
        1 => "1 iteration".to_owned(),
        n => format!("{n} iterations"),
    }
}
