//! The ladder of resolutions that a job climbs, so that something is on screen at once.

use std::sync::Arc;

use super::job::{Job, StopRule};
use super::summary::{Looks, technique_divisor};
use super::{CancelToken, Cancelled, IterationTimes, Renderer, WorkerPool};
use crate::film::{ClassFilm, PathClasses, TechniqueFilm};
use crate::integrator::Method;

/// A frame on the ladder should be there within this time.
const COARSE_SECONDS: f64 = 0.020;

/// What is to be drawn for whoever looks.
#[derive(Clone, Copy, Default)]
pub(super) struct Wanted {
    pub(super) photons: bool,
    pub(super) features: bool,
}

/// What iterations keep apart beside the bounces.
#[derive(Clone, Default)]
pub(super) struct Recording {
    pub(super) techniques: bool,
    pub(super) classes: Option<Arc<PathClasses>>,
}

impl Recording {
    /// True if the other keeps the same classes.
    fn has_classes_of(&self, renderer: &Renderer) -> bool {
        match (&self.classes, renderer.classes()) {
            (Some(wanted), Some(kept)) => Arc::ptr_eq(wanted, kept.classes()),
            (wanted, kept) => wanted.is_none() && kept.is_none(),
        }
    }

    /// Lets a renderer keep this and no more.
    pub(super) fn start(&self, renderer: &mut Renderer) {
        if self.techniques != renderer.techniques().is_some() {
            let divisor = technique_divisor(renderer.settings());
            renderer.record_techniques(self.techniques.then_some(divisor));
        }
        if !self.has_classes_of(renderer) {
            renderer.keep_classes(self.classes.clone());
        }
    }

    /// Iterations of which a renderer has kept all of this.
    fn n_known(&self, renderer: &Renderer) -> u32 {
        let techniques = renderer.techniques().map_or(0, TechniqueFilm::n_iterations);
        let classes = renderer.classes().map_or(0, ClassFilm::n_iterations);
        let of_classes = if self.has_classes_of(renderer) {
            classes
        } else {
            0
        };
        let techniques = if self.techniques {
            techniques
        } else {
            u32::MAX
        };
        let of_classes = if self.classes.is_some() {
            of_classes
        } else {
            u32::MAX
        };
        techniques.min(of_classes)
    }
}

/// How long the latest iteration took.
#[derive(Clone, Copy)]
pub(super) struct Pace {
    pub(super) method: &'static Method,
    pub(super) seconds_per_pixel: f64,
}

/// Seconds for a pixel of a method that has not been seen at work: the ladder is climbed from far
/// down.
const SLOWEST_PACE: f64 = 1e-5;

/// One job on its way up the ladder and on.
pub(super) struct Climb {
    pub(super) generation: u64,
    rungs: Vec<usize>,
    pub(super) renderer: Option<Renderer>,
    pub(super) divisor: usize,
    pub(super) n_iterations: u32,
    pub(super) seconds: f64,
    /// Of iterations of this rung.
    pub(super) times: IterationTimes,
    /// Runs iterations once more for what is kept apart, which was not asked for at the time.
    recorder: Option<Renderer>,
    /// Whether photons are drawn.
    draws_photons: bool,
    /// What was drawn last for whoever looks, of this rung.
    pub(super) looks: Looks,
    /// Whether it has been said that the job is done.
    pub(super) has_said_done: bool,
}

impl Climb {
    /// No job yet.
    pub(super) fn idle() -> Self {
        Self {
            generation: 0,
            rungs: Vec::new(),
            renderer: None,
            divisor: 1,
            n_iterations: 0,
            seconds: 0.0,
            times: IterationTimes::default(),
            recorder: None,
            draws_photons: false,
            looks: Looks::default(),
            has_said_done: false,
        }
    }

    /// Begins a job on the coarsest rung that is needed for a first frame in time.
    pub(super) fn new(job: &Job, generation: u64, pace: Option<Pace>) -> Self {
        let settings = &job.settings;
        let n_pixels = (settings.width * settings.height) as f64;
        // What another method took says nothing about this one.
        let pace = pace.filter(|pace| pace.method == settings.method);
        let seconds = n_pixels * pace.map_or(SLOWEST_PACE, |pace| pace.seconds_per_pixel);
        let is_in_time = |divisor: &usize| seconds / ((divisor * divisor) as f64) <= COARSE_SECONDS;
        let first = [1, 2, 4, 8].into_iter().find(is_in_time).unwrap_or(8);
        let rungs = [1, 2, 4, 8]
            .into_iter()
            .filter(|d| *d <= first)
            .collect::<Vec<_>>();
        Self {
            generation,
            divisor: first,
            rungs: rungs[..rungs.len() - 1].to_vec(),
            renderer: None,
            n_iterations: 0,
            seconds: 0.0,
            times: IterationTimes::default(),
            recorder: None,
            draws_photons: false,
            looks: Looks::default(),
            has_said_done: false,
        }
    }

    /// The renderer of the rung.
    pub(super) fn renderer(&mut self, job: &Job, pool: &WorkerPool) -> &mut Renderer {
        let divisor = self.divisor;
        self.recorder = None;
        let renderer = self
            .renderer
            .get_or_insert_with(|| renderer(job, divisor, pool));
        renderer.take_scene(&job.scene);
        renderer
    }

    /// The renderer that runs iterations of a job that is done once more, from the first one on,
    /// for what is to be kept apart.
    pub(super) fn recorder(
        &mut self,
        job: &Job,
        pool: &WorkerPool,
        recording: &Recording,
    ) -> &mut Renderer {
        // What was kept of other iterations is of no use for these.
        self.recorder
            .take_if(|recorder| recording.n_known(recorder) == 0);
        let recorder = self.recorder.get_or_insert_with(|| {
            let mut recorder = renderer(job, 1, pool);
            recording.start(&mut recorder);
            recorder
        });
        recorder.take_scene(&job.scene);
        recorder
    }

    /// True if iterations are in the film of which nothing was kept that is wanted. Where some was
    /// kept while the film was rendered, that has to do.
    pub(super) fn lacks(&self, recording: &Recording) -> bool {
        match (&self.recorder, &self.renderer) {
            (Some(recorder), _) => recording.n_known(recorder) < self.n_iterations,
            (None, Some(renderer)) => recording.n_known(renderer) == 0,
            (None, None) => false,
        }
    }

    /// Goes up.
    pub(super) fn next_rung(&mut self) {
        self.divisor = self.rungs.pop().unwrap_or(1);
        self.renderer = None;
        self.n_iterations = 0;
        self.times = IterationTimes::default();
        self.looks = Looks::default();
    }

    /// Draws what is wanted of the latest iteration, and no more.
    pub(super) fn draw(&mut self, wanted: Wanted, cancel: &CancelToken) {
        self.draw_photons(wanted.photons, cancel);
        if !wanted.features {
            self.looks.features = None;
        } else if self.looks.features.is_none()
            && let Some(renderer) = &self.renderer
        {
            self.looks.features = Some(Arc::new(renderer.features()));
        }
    }

    /// Draws the photons of the latest iteration, or does so no longer. Where the token is
    /// cancelled, those that were drawn last stay, and the new ones are still owed.
    fn draw_photons(&mut self, is_on: bool, cancel: &CancelToken) {
        self.draws_photons = is_on;
        if !is_on {
            self.looks.photons = None;
            return;
        }
        let Some(renderer) = &mut self.renderer else {
            return;
        };
        let Some(map) = renderer.photons(cancel).unwrap_or_default() else {
            self.draws_photons = !cancel.is_cancelled();
            return;
        };
        // A map that is kept for all iterations need not be drawn anew.
        let drawn = self
            .looks
            .photons
            .as_ref()
            .map(|photons| photons.iteration());
        if drawn == Some(map.iteration) {
            return;
        }
        match renderer.draw_photons(&map, cancel) {
            Ok(picture) => self.looks.photons = Some(Arc::new(picture)),
            Err(Cancelled) => self.draws_photons = false,
        }
    }

    /// True if something is to be drawn that is not, or no longer, though no iteration may be
    /// under way.
    pub(super) fn owes(&self, wanted: Wanted) -> bool {
        let has_features = self.looks.features.is_some();
        let is_owed = self.draws_photons != wanted.photons || has_features != wanted.features;
        self.n_iterations > 0 && is_owed
    }

    /// True if the stop rule was changed since it was said last whether the job is done, and the
    /// answer is another one now.
    pub(super) fn owes_word(&self, stop: StopRule) -> bool {
        self.n_iterations > 0 && self.is_done(stop) != self.has_said_done
    }

    /// True if the stop rule has been met.
    pub(super) fn is_done(&self, stop: StopRule) -> bool {
        if self.divisor != 1 {
            return false;
        }
        match stop {
            StopRule::Never => false,
            StopRule::Iterations(n) => self.n_iterations >= n,
            StopRule::Seconds(s) => {
                self.n_iterations > 0 && self.seconds + self.times.expected() > s
            }
        }
    }
}

/// A renderer of a job, `divisor` times smaller.
fn renderer(job: &Job, divisor: usize, pool: &WorkerPool) -> Renderer {
    let mut settings = job.settings.clone();
    settings.width = settings.width.div_ceil(divisor).max(1);
    settings.height = settings.height.div_ceil(divisor).max(1);
    Renderer::new(Arc::clone(&job.scene), settings, pool.clone(), 0)
}

#[cfg(test)]
mod tests {
    use super::{Climb, StopRule};

    #[test]
    fn an_iteration_that_would_end_too_late_is_not_begun() {
        let mut climb = Climb {
            seconds: 30.0,
            ..Climb::idle()
        };
        assert!(!climb.is_done(StopRule::Seconds(20.0)), "the first one is");
        climb.n_iterations = 2;
        climb.seconds = 12.0;
        climb.times.take(6.0);
        assert!(!climb.is_done(StopRule::Seconds(20.0)));
        assert!(climb.is_done(StopRule::Seconds(17.0)));
    }
}
