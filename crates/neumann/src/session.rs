//! Renders until a goal is met, or Ctrl-C.

mod live;
mod memory;
mod resume;
mod saver;
mod shard;

use std::sync::Arc;
use std::time::Instant;

use neumann_core::film::{ClassFilm, Features, Film, PathClasses, PhotonReport, TechniqueFilm};
use neumann_core::photons::PhotonPicture;
use neumann_core::render::{CancelToken, IterationTimes, RenderSettings, Renderer, WorkerPool};
use neumann_core::scene::Scene;
use neumann_picture::exr_file::{Checkpoint, IterationRanges, Metadata};
use neumann_picture::state::State;

use crate::failure::{Outcome, bad_input};
use crate::options::GoalOptions;
use crate::progress::{Progress, Standing};

pub(crate) use live::Live;
#[cfg(feature = "window")]
pub(crate) use memory::check_film;
pub(crate) use memory::peak_bytes;
pub(crate) use saver::Saver;
pub(crate) use shard::Shard;

/// Where rendering begins, and when it is done: at the first of these that is met.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Number of the first iteration.
    pub(crate) first_iteration: u32,
    /// Iterations of the film.
    pub(crate) iterations: Option<u32>,
    /// Time spent on the film, seconds; an iteration that would end later is not begun.
    pub(crate) seconds: Option<f64>,
    /// Estimated relative error of the film.
    pub(crate) error: Option<f64>,
}

/// Iterations where nothing is asked for.
const DEFAULT_ITERATIONS: u32 = 64;
/// Fewer iterations say too little about their error.
const FEWEST_FOR_ERROR: u32 = 8;

impl Goal {
    /// What was asked for.
    ///
    /// # Errors
    /// If iterations have numbers that are too large, or cannot be shared out.
    pub(crate) fn of(options: &GoalOptions) -> Outcome<Self> {
        let is_open =
            options.iterations.is_none() && options.time.is_none() && options.until_error.is_none();
        let whole = Self {
            first_iteration: options.first_iteration,
            iterations: options.iterations.or(is_open.then_some(DEFAULT_ITERATIONS)),
            seconds: options.time,
            error: options.until_error,
        };
        let n = whole.iterations.unwrap_or(1);
        let Some(end) = whole.first_iteration.checked_add(n) else {
            return Err(bad_input(
                "--first-iteration: too large for that many iterations; numbers go up to \
                 4294967295",
            ));
        };
        let Some(shard) = options.shard else {
            return Ok(whole);
        };
        if whole.iterations.is_none() || whole.error.is_some() {
            return Err(bad_input(format!(
                "--shard {shard}: only a known number of iterations can be shared out; \
                 give --iterations, and leave --until-error away"
            )));
        }
        let part = shard.part_of(whole.first_iteration..end);
        if part.is_empty() {
            return Err(bad_input(format!(
                "--shard {shard}: no iteration is left for this part of {n}; use at most {n} parts"
            )));
        }
        Ok(Self {
            first_iteration: part.start,
            iterations: Some(part.end - part.start),
            ..whole
        })
    }

    /// Whether no other iteration is to be begun, if it is expected to take so many seconds.
    fn is_met(&self, standing: Standing, next: f64) -> bool {
        let is_late = |s: f64| standing.n_iterations > 0 && standing.seconds + next > s;
        self.iterations.is_some_and(|n| standing.n_iterations >= n)
            || self.seconds.is_some_and(is_late)
            || self.error.is_some_and(|wanted| {
                standing.n_iterations >= FEWEST_FOR_ERROR
                    && standing.error.is_some_and(|error| error <= wanted)
            })
    }

    /// Which part of the way is done, in [0, 1]; errors fall with the square root of iterations.
    pub(crate) fn part_done(&self, standing: Standing) -> f64 {
        let by_count = self
            .iterations
            .map(|n| f64::from(standing.n_iterations) / f64::from(n));
        let by_time = self.seconds.map(|s| standing.seconds / s);
        let by_error = self
            .error
            .zip(standing.error)
            .map(|(wanted, error)| (wanted / error).powi(2));
        [by_count, by_time, by_error]
            .into_iter()
            .flatten()
            .filter(|part| part.is_finite())
            .fold(0.0, f64::max)
            .min(1.0)
    }
}

/// Everything that is needed to begin.
pub(crate) struct Session {
    /// What the header of an .exr tells the window.
    pub(crate) state: Box<State>,
    pub(crate) scene: Arc<Scene>,
    pub(crate) settings: RenderSettings,
    pub(crate) pool: WorkerPool,
    pub(crate) goal: Goal,
    /// How many times smaller techniques are kept apart, if they are.
    pub(crate) technique_divisor: Option<usize>,
    /// Which classes of paths are kept apart, if some are.
    pub(crate) classes: Option<Arc<PathClasses>>,
    /// Whether the photons of the last iteration are drawn.
    pub(crate) draws_photons: bool,
}

/// What came of it.
pub(crate) struct Rendered {
    pub(crate) film: Film,
    pub(crate) features: Features,
    pub(crate) metadata: Metadata,
    /// Estimated relative error; `None` while it is unknown.
    pub(crate) estimated_error: Option<f64>,
    /// Of each layer by itself, tail last.
    pub(crate) layer_errors: Vec<Option<f64>>,
    /// Samples (paths of pixels) and rays per second, of this run; `None` if it rendered nothing.
    pub(crate) samples_per_second: Option<f64>,
    pub(crate) rays_per_second: Option<f64>,
    /// The techniques of this run, if they were kept apart.
    pub(crate) techniques: Option<TechniqueFilm>,
    /// The classes of paths of this run, if they were kept apart.
    pub(crate) classes: Option<ClassFilm>,
    /// The photons of the last iteration, if they were to be drawn.
    pub(crate) photon_picture: Option<PhotonPicture>,
    /// What the photons of the last iteration were like, if there were any.
    pub(crate) photons: Option<PhotonReport>,
    /// False if it was interrupted before the goal was met.
    pub(crate) is_complete: bool,
}

impl Session {
    /// Checks that there is memory enough.
    pub(crate) fn check(&self) -> Outcome {
        let settings = &self.settings;
        let shows_its_error = (settings.method.build)(&settings.values).shows_its_error();
        if self.goal.error.is_some() && !shows_its_error {
            return Err(bad_input(format!(
                "--until-error: the error of '{}' with one map for all iterations cannot be \
                 estimated; give --iterations or --time, or --set map=renewed",
                settings.method.id
            )));
        }
        memory::check(settings)
    }

    /// Renders from the checkpoint, if there is one, until the goal is met or the token cancelled;
    /// saves and shows it meanwhile, if it is said how.
    pub(crate) fn render(
        &self,
        before: Option<Checkpoint>,
        mut saver: Option<Saver<'_>>,
        mut live: Option<&mut Live>,
        cancel: &CancelToken,
    ) -> Rendered {
        let s = &self.settings;
        let (mut film, mut metadata, mut next) = match before {
            Some(checkpoint) => {
                let next = checkpoint.metadata.iterations.end();
                (checkpoint.film, checkpoint.metadata, next)
            }
            None => (
                Film::new(s.width, s.height, s.n_layers),
                Metadata::of(&self.scene, s),
                self.goal.first_iteration,
            ),
        };
        metadata.state = Some(self.state.clone());
        let mut renderer =
            Renderer::new(Arc::clone(&self.scene), s.clone(), self.pool.clone(), next);
        renderer.record_techniques(self.technique_divisor);
        renderer.keep_classes(self.classes.clone());
        let mut features = None;
        let trace_features = || {
            let trace = || Features::trace(&self.scene, &s.camera, s.width, s.height);
            self.pool.run(trace)
        };
        let mut photons = None;
        let mut times = IterationTimes::default();
        if film.n_iterations() > 0 {
            times.take(metadata.seconds / f64::from(film.n_iterations()));
        }
        let mut progress = Progress::new(self.goal);
        let (mut n_samples, mut n_rays, mut seconds_here) = (0u64, 0u64, 0.0);
        let is_complete = loop {
            let standing = Standing {
                n_iterations: film.n_iterations(),
                seconds: metadata.seconds,
                error: self
                    .goal
                    .error
                    .and_then(|_| renderer.estimated_error(&film)),
            };
            progress.update(standing);
            if self.goal.is_met(standing, times.expected()) {
                break true;
            }
            let Some(after) = next.checked_add(1) else {
                break true;
            };
            if let Some(saver) = &mut saver
                && film.n_iterations() > 0
                && saver.is_due(times.expected())
            {
                metadata.n_refused = film.n_refused();
                let features = features.get_or_insert_with(trace_features);
                saver.save(&film, features, &metadata);
            }
            if let Some(live) = &mut live
                && film.n_iterations() > 0
            {
                live.show_if_due(&film);
            }
            let start = Instant::now();
            let Ok(iteration) = renderer.iterate_after(&film, cancel) else {
                break false;
            };
            n_samples += iteration.n_samples();
            n_rays += iteration.n_rays();
            photons = iteration.photons();
            self.pool.run(|| iteration.add_to(&mut film));
            let seconds = start.elapsed().as_secs_f64();
            seconds_here += seconds;
            times.take(seconds);
            metadata.seconds += seconds;
            let done = IterationRanges::of(next..after);
            metadata.iterations = metadata.iterations.union(&done);
            next = after;
        };
        progress.finish();
        metadata.n_refused = film.n_refused();
        let estimated_error = renderer.estimated_error(&film);
        let layer_errors = renderer.layer_errors(&film);
        let techniques = renderer.techniques().cloned();
        let classes = renderer.classes().cloned();
        let draws_photons = self.draws_photons && film.n_iterations() > 0;
        let photon_picture = draws_photons.then(|| draw_photons(&mut renderer)).flatten();
        // Its memory goes before more is wanted.
        drop(renderer);
        let features = features.unwrap_or_else(trace_features);
        let per_second = |n: u64| (seconds_here > 0.0).then(|| n as f64 / seconds_here);
        Rendered {
            film,
            features,
            metadata,
            estimated_error,
            layer_errors,
            samples_per_second: per_second(n_samples),
            rays_per_second: per_second(n_rays),
            techniques,
            classes,
            photon_picture,
            photons,
            is_complete,
        }
    }
}

/// The photons of the latest iteration; also after Ctrl-C, as whole iterations are written then.
fn draw_photons(renderer: &mut Renderer) -> Option<PhotonPicture> {
    let nobody = CancelToken::default();
    let map = renderer.photons(&nobody).ok()??;
    renderer.draw_photons(&map, &nobody).ok()
}

#[cfg(test)]
mod tests {
    use super::Goal;
    use crate::options::GoalOptions;
    use crate::progress::Standing;

    fn standing(n_iterations: u32, seconds: f64, error: Option<f64>) -> Standing {
        Standing {
            n_iterations,
            seconds,
            error,
        }
    }

    #[test]
    fn the_first_goal_that_is_met_counts() {
        let open = Goal::of(&GoalOptions::default()).unwrap();
        assert!(!open.is_met(standing(63, 1e9, None), 0.0));
        assert!(open.is_met(standing(64, 0.0, None), 0.0));
        let goal = Goal::of(&GoalOptions {
            time: Some(2.0),
            until_error: Some(0.01),
            ..GoalOptions::default()
        })
        .unwrap();
        assert!(!goal.is_met(standing(1000, 1.9, Some(0.02)), 0.1));
        assert!(goal.is_met(standing(1, 2.1, None), 0.1));
        assert!(goal.is_met(standing(100, 0.1, Some(0.009)), 0.1));
        assert!(
            !goal.is_met(standing(2, 0.1, Some(0.009)), 0.1),
            "two say too little"
        );
    }

    #[test]
    fn an_iteration_that_would_end_too_late_is_not_begun() {
        let goal = Goal {
            first_iteration: 0,
            iterations: None,
            seconds: Some(20.0),
            error: None,
        };
        assert!(
            !goal.is_met(standing(0, 0.0, None), 60.0),
            "the first one is"
        );
        assert!(!goal.is_met(standing(2, 12.0, None), 6.0));
        assert!(goal.is_met(standing(3, 18.0, None), 6.0));
    }

    #[test]
    fn shards_share_out_a_known_number_of_iterations() {
        let options = |iterations, time, until_error| GoalOptions {
            iterations,
            time,
            until_error,
            first_iteration: 100,
            shard: Some("2/3".parse().unwrap()),
            ..GoalOptions::default()
        };
        let goal = Goal::of(&options(Some(30), Some(5.0), None)).unwrap();
        assert_eq!((goal.first_iteration, goal.iterations), (110, Some(10)));
        let by_default = Goal::of(&options(None, None, None)).unwrap();
        assert_eq!(by_default.first_iteration, 121);
        assert_eq!(by_default.iterations, Some(21));
        for (iterations, time, error, expected) in [
            (None, Some(5.0), None, "--iterations"),
            (Some(30), None, Some(0.1), "--until-error"),
            (Some(1), None, None, "at most 1 parts"),
        ] {
            let error = Goal::of(&options(iterations, time, error)).unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
        }
    }

    #[test]
    fn parts_follow_the_nearest_goal() {
        let goal = Goal {
            first_iteration: 0,
            iterations: Some(100),
            seconds: Some(10.0),
            error: Some(0.01),
        };
        assert!((goal.part_done(standing(50, 1.0, None)) - 0.5).abs() < 1e-9);
        assert!((goal.part_done(standing(1, 9.0, Some(0.02))) - 0.9).abs() < 1e-9);
        assert!((goal.part_done(standing(1, 0.0, Some(0.02))) - 0.25).abs() < 1e-9);
        assert_eq!(goal.part_done(standing(500, 1.0, Some(f64::INFINITY))), 1.0);
    }
}
