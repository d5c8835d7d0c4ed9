//! The race while it is held: methods and reference take turns, and what they have made is judged
//! in between.

use std::sync::{Arc, Mutex};
use std::time::Instant;

use neumann_core::film::Film;
use neumann_core::render::{RenderSettings, WorkerPool};
use neumann_core::scene::Scene;
use neumann_picture::Image;
use neumann_picture::race::{Entrant, Point, Racer, next_in_turn};
use neumann_picture::tone::Display;

use super::judged::Judged;
use super::reference::Reference;
use crate::views::held::{Shared, lock};

/// What a race is held between.
#[derive(Clone)]
pub(super) struct Entries {
    pub(super) scene: Arc<Scene>,
    /// Everything but the method.
    pub(super) common: RenderSettings,
    pub(super) entrants: Vec<Entrant>,
    /// The window's own reference, if it fits, and what is said of it.
    pub(super) given: Option<Given>,
}

/// A picture to judge by that is there already.
#[derive(Clone)]
pub(super) struct Given {
    pub(super) pixels: Arc<Vec<neumann_core::radiometry::Rgb>>,
    pub(super) words: String,
}

impl PartialEq for Entries {
    fn eq(&self, other: &Self) -> bool {
        let of_given = |e: &Self| e.given.as_ref().map(|given| Arc::as_ptr(&given.pixels));
        Arc::ptr_eq(&self.scene, &other.scene)
            && self.common == other.common
            && self.entrants == other.entrants
            && of_given(self) == of_given(other)
    }
}

/// How the race stands.
#[derive(Clone, Default)]
pub struct Report {
    /// The methods, in the order of their entry.
    pub standings: Vec<Standing>,
    /// What they are judged by, once it is there.
    pub reference: Option<Arc<Image>>,
    /// What is said of the reference.
    pub reference_words: String,
}

/// How a method stands.
#[derive(Clone)]
pub struct Standing {
    /// What it is called.
    pub name: String,
    /// Processor time that it has had.
    pub seconds: f64,
    /// Its errors over time. The last one is that of `image`.
    pub curve: Arc<Vec<Point>>,
    /// Its picture when it was judged last.
    pub image: Option<Arc<Image>>,
}

/// Judging may take this share of the time of rendering.
const JUDGING: f64 = 0.2;

/// Renders and judges until the race is ended.
pub(super) fn hold(
    shared: &Shared<Report>,
    entries: &Entries,
    pool: &WorkerPool,
    display: &Mutex<Display>,
    cache: Option<std::path::PathBuf>,
) {
    let racer = |entrant: &Entrant| {
        let settings = entrant.settings(&entries.common);
        Racer::new(&entrant.name, &entries.scene, settings, pool)
    };
    let mut racers: Vec<Racer> = entries.entrants.iter().map(racer).collect();
    let mut judged: Vec<Judged> = racers.iter().map(|_| Judged::default()).collect();
    let mut reference = Reference::new(entries, pool, cache);
    let standings = racers.iter().map(|racer| Standing {
        name: racer.name.clone(),
        seconds: 0.0,
        curve: Arc::default(),
        image: None,
    });
    let standings = standings.collect();
    shared.publish(|report| report.standings = standings);
    let (mut rendering, mut judging) = (0.0, 0.0);
    while shared.goes_on() {
        let start = Instant::now();
        let Some(next) = next_in_turn(&racers, f64::INFINITY) else {
            return;
        };
        if reference.is_next(racers[next].seconds()) {
            if reference.iterate(&shared.cancel).is_err() {
                return;
            }
            publish_reference(shared, &reference);
            rendering += start.elapsed().as_secs_f64();
            continue;
        }
        let racer = &mut racers[next];
        if racer.iterate(&shared.cancel).is_err() {
            return;
        }
        let seconds = racer.seconds();
        rendering += start.elapsed().as_secs_f64();
        shared.publish(|report| report.standings[next].seconds = seconds);
        let start = Instant::now();
        let is_new = judged[next].is_new();
        if !is_new && judging >= JUDGING * rendering {
            continue;
        }
        // All at once, so that all errors are by the same reference.
        let by = (reference.image(), *lock(display));
        let n = reference.n_iterations();
        for (racer, judged) in racers.iter().zip(&mut judged) {
            if racer.n_iterations() > 0 && !shared.cancel.is_cancelled() {
                judged.judge(racer, &by, n);
                judged.judge_again(pool, &by, n);
            }
        }
        publish_judged(shared, &judged, by.0, reference.words());
        judging += start.elapsed().as_secs_f64();
    }
}

fn publish_reference(shared: &Shared<Report>, reference: &Reference) {
    let words = reference.words();
    shared.publish(|report| report.reference_words = words);
}

fn publish_judged(shared: &Shared<Report>, judged: &[Judged], by: Arc<Image>, words: String) {
    shared.publish(|report| {
        for (standing, judged) in report.standings.iter_mut().zip(judged) {
            standing.curve = Arc::new(judged.curve());
            standing.image = judged.image();
        }
        report.reference = Some(by);
        report.reference_words = words;
    });
}

/// A film as a picture.
pub(super) fn image_of(film: &Film) -> Image {
    Image {
        width: film.width(),
        height: film.height(),
        pixels: film.total(),
        ..Image::default()
    }
}
