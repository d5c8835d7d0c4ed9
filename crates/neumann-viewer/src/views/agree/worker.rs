//! The thread on which two methods render in turn, and are held against each other after each
//! batch.

use std::sync::{Arc, PoisonError, RwLock};
use std::time::Instant;

use neumann_core::film::View as Part;
use neumann_core::render::{RenderSettings, WorkerPool};
use neumann_core::scene::Scene;
use neumann_core::scene::description::Crop;
use neumann_picture::agreement::{Agreement, Length, Report, Side, batch, seed};
use neumann_picture::race::Entrant;

use crate::views::held::Shared;

/// Probability that noise is ever taken for a bias while one looks.
const LEVEL: f64 = 0.01;
/// Comparing may take this share of the time of rendering.
const COMPARING: f64 = 0.25;

/// What is held against each other.
#[derive(Clone)]
pub(super) struct Wanted {
    pub(super) scene: Arc<Scene>,
    /// Everything but the method.
    pub(super) common: RenderSettings,
    pub(super) entrants: [Entrant; 2],
    /// Of a batch.
    pub(super) n_iterations: u32,
}

impl PartialEq for Wanted {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene)
            && self.common == other.common
            && self.entrants == other.entrants
            && self.n_iterations == other.n_iterations
    }
}

/// What was found after a batch.
pub struct Found {
    /// The scores.
    pub agreement: Agreement,
    /// What the methods are called.
    pub names: [String; 2],
    /// How the scores were made.
    pub heading: String,
    /// What follows from them, a line each.
    pub verdict: Vec<String>,
    /// Batches of each method.
    pub n_batches: usize,
    /// Iterations of each batch.
    pub n_iterations: u32,
    /// The region that all is of, if it is not the whole picture.
    pub region: Option<Crop>,
    /// What was rendered, which goes on.
    pub(super) sides: Arc<RwLock<[Side; 2]>>,
}

impl Found {
    /// The part that is compared where a part is chosen: partial sums are not.
    pub(super) fn part(chosen: Part) -> Part {
        match chosen {
            Part::Upto(_) => Part::Total,
            part => part,
        }
    }
}

/// Renders and compares until it is ended.
pub(super) fn hold(shared: &Shared<Option<Arc<Found>>>, wanted: &Wanted, pool: &WorkerPool) {
    let Wanted { scene, common, .. } = wanted;
    let sides = wanted.entrants.clone().map(|e| Side::new(e, common));
    let sides = Arc::new(RwLock::new(sides));
    let length = Length::Iterations(wanted.n_iterations);
    let (mut rendering, mut comparing) = (0.0, 0.0);
    for number in 0.. {
        let start = Instant::now();
        for side in 0..2 {
            if !shared.goes_on() {
                return;
            }
            let stream = 2 * number + side as u64;
            let settings = {
                let sides = sides.read().unwrap_or_else(PoisonError::into_inner);
                sides[side].with_seed(seed(common.seed, stream))
            };
            let Ok(rendered) = batch(scene, settings, length, pool, &shared.cancel) else {
                return;
            };
            let mut sides = sides.write().unwrap_or_else(PoisonError::into_inner);
            sides[side].take(&rendered);
        }
        rendering += start.elapsed().as_secs_f64();
        // Of one batch nothing is known.
        if number == 0 || comparing > COMPARING * rendering {
            continue;
        }
        let start = Instant::now();
        let found = Arc::new(compare(&sides, common.camera.crop, pool));
        shared.publish(|report| *report = Some(found));
        comparing += start.elapsed().as_secs_f64();
    }
}

fn compare(held: &Arc<RwLock<[Side; 2]>>, region: Option<Crop>, pool: &WorkerPool) -> Found {
    let sides = held.read().unwrap_or_else(PoisonError::into_inner);
    let batches = [&sides[0].batches, &sides[1].batches];
    let agreement = pool.run(|| Agreement::while_watched(batches, LEVEL));
    let report = Report {
        sides: &sides,
        agreement: &agreement,
    };
    Found {
        names: report.names(),
        heading: report.heading(),
        verdict: report.verdict(),
        n_batches: sides[0].batches.n(),
        n_iterations: sides[0].n_iterations,
        region,
        sides: Arc::clone(held),
        agreement,
    }
}
