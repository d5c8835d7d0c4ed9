//! The thread on which a method renders at two radii, and is measured after each render.

use std::sync::{Arc, PoisonError, RwLock};
use std::time::Instant;

use neumann_core::film::View as Part;
use neumann_core::render::{RenderSettings, WorkerPool};
use neumann_core::scene::Scene;
use neumann_core::scene::description::Crop;
use neumann_picture::agreement::seed;
use neumann_picture::race::Entrant;
use neumann_picture::radius_bias::{Radii, RadiusBias, Report, Row, pair};

use crate::views::held::Shared;

/// Measuring may take this share of the time of rendering.
const MEASURING: f64 = 0.25;

/// What is measured.
#[derive(Clone)]
pub(super) struct Wanted {
    pub(super) scene: Arc<Scene>,
    pub(super) settings: RenderSettings,
    /// Of a render.
    pub(super) n_iterations: u32,
}

impl PartialEq for Wanted {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene)
            && self.settings == other.settings
            && self.n_iterations == other.n_iterations
    }
}

/// What was found after a render; why there is nothing, otherwise.
pub type Finding = Result<Found, String>;

/// What was found after a render.
pub struct Found {
    /// How it was measured.
    pub heading: String,
    /// What is said of each part that has light: in the table, and in a line.
    pub parts: Vec<(Part, Row, [String; 2])>,
    /// What is to be known of it.
    pub notes: Vec<String>,
    /// Renders at each radius.
    pub n_renders: usize,
    /// Iterations of each render.
    pub n_iterations: u32,
    /// The region that all is of, if it is not the whole picture.
    pub region: Option<Crop>,
    /// What was rendered, which goes on.
    pub(super) held: Arc<RwLock<RadiusBias>>,
}

/// Renders and measures until it is ended.
pub(super) fn hold(shared: &Shared<Option<Arc<Finding>>>, wanted: &Wanted, pool: &WorkerPool) {
    let (scene, settings) = (&wanted.scene, &wanted.settings);
    let radii = match Radii::of(scene, settings, wanted.n_iterations) {
        Ok(radii) => radii,
        Err(error) => {
            shared.publish(|report| *report = Some(Arc::new(Err(error))));
            return;
        }
    };
    let (width, height) = (settings.width, settings.height);
    let held = RadiusBias::new(width, height, settings.n_layers, radii.q);
    let held = Arc::new(RwLock::new(held));
    let (mut rendering, mut measuring) = (0.0, 0.0);
    for number in 0.. {
        if !shared.goes_on() {
            return;
        }
        let start = Instant::now();
        let length = (wanted.n_iterations, seed(settings.seed, number));
        let Ok([wide, narrow]) = pair(scene, &radii, length, pool, &shared.cancel) else {
            return;
        };
        let mut found = held.write().unwrap_or_else(PoisonError::into_inner);
        found.take(&wide, &narrow);
        drop(found);
        rendering += start.elapsed().as_secs_f64();
        // Of one render nothing is known.
        if number == 0 || measuring > MEASURING * rendering {
            continue;
        }
        let start = Instant::now();
        let found = Arc::new(Ok(measure(&held, wanted, &radii, pool)));
        shared.publish(|report| *report = Some(found));
        measuring += start.elapsed().as_secs_f64();
    }
}

fn measure(
    held: &Arc<RwLock<RadiusBias>>,
    wanted: &Wanted,
    radii: &Radii,
    pool: &WorkerPool,
) -> Found {
    let found = held.read().unwrap_or_else(PoisonError::into_inner);
    let parts = pool.run(|| found.parts());
    let settings = &wanted.settings;
    let report = Report {
        name: &Entrant::new(settings.method, &settings.values).name,
        radii,
        n_iterations: wanted.n_iterations,
        n_renders: found.n(),
        parts: &parts,
    };
    let of = |part: &_| {
        let row = Row::of(part);
        (part.view, row, report.sentences(part.view))
    };
    Found {
        heading: report.heading(),
        notes: report.notes(),
        n_renders: found.n(),
        n_iterations: wanted.n_iterations,
        region: settings.camera.crop,
        held: Arc::clone(held),
        parts: parts.iter().map(of).collect(),
    }
}
