//! Renders in the background, for a window.
//!
//! A job climbs a ladder of resolutions (1/8, 1/4, 1/2, 1), each rung a whole
//! iteration of a smaller film, so that something is on screen at once; at
//! full resolution iterations add up. After each iteration the film is
//! published: whoever draws reads it under a lock that the loop holds for itself only while
//! it puts a film in place of another, or takes in a frame, never while it traces.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard};
use std::thread::JoinHandle;
use std::time::Instant;

use super::job::{Job, StopRule};
use super::ladder::{Climb, Pace, Recording, Wanted};
use super::summary::{Apart, Errors, Published, SUMMARY_PERIOD, Stats, Summary};
use super::{CancelToken, WorkerPool};
use crate::film::{Film, PathClasses};
use crate::scene::Scene;

/// The background renderer; dropping it stops it.
pub struct RenderLoop {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    control: Mutex<Control>,
    wake: Condvar,
    published: RwLock<Published>,
    version: AtomicU64,
    on_publish: Box<dyn Fn() + Send + Sync>,
}

struct Control {
    job: Option<Job>,
    generation: u64,
    is_paused: bool,
    recording: Recording,
    wanted: Wanted,
    has_quit: bool,
    cancel: CancelToken,
}

impl RenderLoop {
    /// Starts the thread; `on_publish` is called, on that thread, after every change of the
    /// picture.
    ///
    /// # Errors
    /// If the operating system gives no thread.
    pub fn new(
        pool: WorkerPool,
        on_publish: impl Fn() + Send + Sync + 'static,
    ) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            control: Mutex::new(Control {
                job: None,
                generation: 0,
                is_paused: false,
                recording: Recording::default(),
                wanted: Wanted::default(),
                has_quit: false,
                cancel: CancelToken::default(),
            }),
            wake: Condvar::new(),
            published: RwLock::new(Published {
                generation: 0,
                version: 0,
                film: Film::new(1, 1, 1),
                divisor: 1,
                stats: Stats::default(),
                thumbnails: Vec::new(),
                energy_shares: Vec::new(),
                layer_errors: Vec::new(),
                thumbnails_version: 0,
                techniques: None,
                classes: None,
                photons: None,
                features: None,
                samples: None,
            }),
            version: AtomicU64::new(0),
            on_publish: Box::new(on_publish),
        });
        let for_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("neumann-render".to_owned())
            .spawn(move || run(&for_thread, &pool))?;
        Ok(Self {
            shared,
            thread: Some(thread),
        })
    }

    /// Drops what is being rendered and starts a job; yields its generation.
    /// The old picture stays published until the first frame of the new one is ready.
    pub fn start(&self, job: Job) -> u64 {
        let mut control = self.shared.control();
        control.job = Some(job);
        control.generation += 1;
        control.cancel.cancel();
        control.cancel = CancelToken::default();
        self.shared.wake.notify_all();
        control.generation
    }

    /// Pauses, dropping the iteration under way, or goes on.
    pub fn pause(&self, is_paused: bool) {
        let mut control = self.shared.control();
        if control.is_paused != is_paused {
            control.is_paused = is_paused;
            control.cancel.cancel();
            control.cancel = CancelToken::default();
            self.shared.wake.notify_all();
        }
    }

    /// Begins or ends keeping techniques apart, at full resolution of the ladder; what was kept
    /// before is dropped. Where the job is done already, its iterations are run once more for their
    /// techniques alone. It costs time and memory ([`bytes`](crate::film::TechniqueFilm::bytes)),
    /// so it is for as long as somebody looks.
    pub fn record_techniques(&self, is_on: bool) {
        self.shared.control().recording.techniques = is_on;
        self.shared.wake.notify_all();
    }

    /// Begins to keep classes of paths apart, at full resolution of the ladder, or others than
    /// before, or ends it. Where the job is done already, its iterations are run once more for
    /// their classes alone. It costs time and memory
    /// ([`Renderer::keep_classes`](super::Renderer::keep_classes),
    /// [`bytes`](crate::film::ClassFilm::bytes)).
    pub fn keep_classes(&self, classes: Option<Arc<PathClasses>>) {
        self.shared.control().recording.classes = classes;
        self.shared.wake.notify_all();
    }

    /// Begins or ends drawing the photons of a method that has some, also those of an iteration
    /// that is done already. It costs a ray for each photon, so it is for as long as somebody
    /// looks.
    pub fn draw_photons(&self, is_on: bool) {
        self.shared.control().wanted.photons = is_on;
        self.shared.wake.notify_all();
    }

    /// Begins or ends keeping what the camera sees first. It costs a ray for each pixel of every
    /// job, so it is for as long as somebody looks.
    pub fn trace_features(&self, is_on: bool) {
        self.shared.control().wanted.features = is_on;
        self.shared.wake.notify_all();
    }

    /// True while paused.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.shared.control().is_paused
    }

    /// Changes when the present job is done, without restarting it.
    pub fn stop_after(&self, stop: StopRule) {
        let mut control = self.shared.control();
        if let Some(job) = &mut control.job {
            job.stop = stop;
        }
        self.shared.wake.notify_all();
    }

    /// Goes on with the same scene over a better tree, from the next iteration on; nothing is begun
    /// anew, since no bit of the picture depends on it. Does nothing while something else is
    /// rendered than `scene`.
    pub fn improve_scene(&self, scene: &Arc<Scene>, better: &Arc<Scene>) {
        let mut control = self.shared.control();
        if let Some(job) = &mut control.job
            && Arc::ptr_eq(&job.scene, scene)
        {
            job.scene = Arc::clone(better);
        }
    }

    /// [`Published::version`], without a lock.
    #[must_use]
    pub fn version(&self) -> u64 {
        self.shared.version.load(Ordering::Acquire)
    }

    /// The latest state of the picture; hold the guard briefly.
    pub fn published(&self) -> RwLockReadGuard<'_, Published> {
        self.shared.published()
    }
}

impl Drop for RenderLoop {
    fn drop(&mut self) {
        {
            let mut control = self.shared.control();
            control.has_quit = true;
            control.cancel.cancel();
            self.shared.wake.notify_all();
        }
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been reported by the panic hook already.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn control(&self) -> MutexGuard<'_, Control> {
        self.control.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn published(&self) -> RwLockReadGuard<'_, Published> {
        self.published
            .read()
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn publish(&self, change: impl FnOnce(&mut Published)) {
        {
            let mut published = self
                .published
                .write()
                .unwrap_or_else(PoisonError::into_inner);
            change(&mut published);
            published.version += 1;
            self.version.store(published.version, Ordering::Release);
        }
        (self.on_publish)();
    }

    /// When the job of a generation is done, if it is the latest.
    fn stop_of(&self, generation: u64) -> Option<StopRule> {
        let control = self.control();
        let job = control.job.as_ref();
        job.filter(|_| control.generation == generation)
            .map(|job| job.stop)
    }

    /// Waits for something to do: yields the job, its generation and the token to heed.
    fn next_task(&self, climb: &Climb) -> Option<Task> {
        let mut control = self.control();
        loop {
            if control.has_quit {
                return None;
            }
            if let Some(job) = &control.job {
                let is_new = control.generation != climb.generation;
                let is_wanted = !climb.is_done(job.stop) || climb.lacks(&control.recording);
                let iterates = (is_new || is_wanted) && !control.is_paused;
                let owes_word = !is_new && climb.owes_word(job.stop);
                if iterates || owes_word || (!is_new && climb.owes(control.wanted)) {
                    return Some(Task {
                        iterates,
                        owes_word,
                        job: job.clone(),
                        generation: control.generation,
                        cancel: control.cancel.clone(),
                        recording: control.recording.clone(),
                        wanted: control.wanted,
                    });
                }
            }
            control = self
                .wake
                .wait(control)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }
}

struct Task {
    job: Job,
    generation: u64,
    cancel: CancelToken,
    recording: Recording,
    wanted: Wanted,
    /// False where something is to be drawn for whoever looks, and no more.
    iterates: bool,
    /// True if the rule was changed, and so whether the job is done, which is to be said.
    owes_word: bool,
}

fn run(shared: &Shared, pool: &WorkerPool) {
    let mut climb = Climb::idle();
    let mut pace: Option<Pace> = None;
    let mut summarised: Option<Instant> = None;
    loop {
        let Some(task) = shared.next_task(&climb) else {
            return;
        };
        if task.owes_word {
            climb.has_said_done = climb.is_done(task.job.stop);
            let is_done = climb.has_said_done;
            shared.publish(|published| published.stats.is_done = is_done);
            continue;
        }
        if !task.iterates {
            climb.draw(task.wanted, &task.cancel);
            shared.publish(|published| published.look(climb.looks.clone()));
            continue;
        }
        if task.generation != climb.generation {
            climb = Climb::new(&task.job, task.generation, pace);
            summarised = None;
        }
        if climb.is_done(task.job.stop) {
            record_once_more(shared, pool, &mut climb, &task, &mut summarised);
            continue;
        }
        let start = Instant::now();
        let (generation, divisor) = (climb.generation, climb.divisor);
        let is_first = climb.n_iterations == 0;
        let renderer = climb.renderer(&task.job, pool);
        let (width, height) = (renderer.settings().width, renderer.settings().height);
        let n_pixels = width * height;
        if divisor == 1 {
            task.recording.start(renderer);
        }
        let fresh = is_first.then(|| Film::new(width, height, renderer.settings().n_layers));
        let iteration = {
            let published = shared.published();
            let film = fresh.as_ref().unwrap_or(&published.film);
            renderer.iterate_after(film, &task.cancel)
        };
        let Ok(iteration) = iteration else {
            climb.seconds += start.elapsed().as_secs_f64();
            continue;
        };
        let seconds = start.elapsed().as_secs_f64();
        pace = Some(Pace {
            method: task.job.settings.method,
            seconds_per_pixel: seconds / n_pixels as f64,
        });
        let (n_rays, photons) = (iteration.n_rays(), iteration.photons());
        let samples_per_second = iteration.n_samples() as f64 / seconds;
        pool.run(|| {
            shared.publish(|published| {
                if let Some(film) = fresh {
                    published.film = film;
                    // What was done was the job or the rung before.
                    published.stats.is_done = false;
                    published.stats.n_iterations = 1;
                }
                iteration.add_to(&mut published.film);
                published.generation = generation;
                published.divisor = divisor;
            });
        });
        climb.n_iterations += 1;
        let seconds_with_film = start.elapsed().as_secs_f64();
        climb.seconds += seconds_with_film;
        climb.times.take(seconds_with_film);
        // The rule may have been changed since.
        let stop = shared.stop_of(generation).unwrap_or(task.job.stop);
        let is_done = divisor == 1 && climb.is_done(stop);
        climb.has_said_done = is_done;
        let is_due = summarised.is_none_or(|t| t.elapsed() >= SUMMARY_PERIOD) || is_done;
        if is_due {
            climb.draw(task.wanted, &task.cancel);
        }
        let summary = is_due.then(|| {
            let published = shared.published();
            let renderer = climb.renderer.as_ref();
            let errors = renderer.map(|renderer| Errors::of(renderer, &published.film));
            let errors = errors.unwrap_or_default();
            let apart = Apart::of(renderer);
            let samples = renderer.map(|renderer| Arc::new(renderer.samples().clone()));
            let looks = climb.looks.clone();
            pool.run(|| Summary::of(&published.film, errors, apart, looks, samples))
        });
        if summary.is_some() {
            // Rungs of the ladder do not delay the next summary.
            summarised = (divisor == 1).then(Instant::now);
        }
        let stats = Stats {
            n_iterations: climb.n_iterations,
            seconds: climb.seconds,
            samples_per_second,
            rays_per_second: n_rays as f64 / seconds,
            estimated_error: None,
            n_refused: 0,
            photons,
            is_done,
        };
        shared.publish(|published| published.take(stats, summary));
        if divisor != 1 {
            climb.next_rung();
        }
    }
}

/// Runs an iteration of a film that is done once more, for what is kept apart.
fn record_once_more(
    shared: &Shared,
    pool: &WorkerPool,
    climb: &mut Climb,
    task: &Task,
    summarised: &mut Option<Instant>,
) {
    let recorder = climb.recorder(&task.job, pool, &task.recording);
    if recorder.iterate(&task.cancel).is_err() {
        return;
    }
    let is_last = !climb.lacks(&task.recording);
    if !is_last && summarised.is_some_and(|t| t.elapsed() < SUMMARY_PERIOD) {
        return;
    }
    let apart = Apart::of(Some(climb.recorder(&task.job, pool, &task.recording)));
    *summarised = Some(Instant::now());
    let (stats, summary) = {
        let published = shared.published();
        let errors = Errors {
            of_film: published.stats.estimated_error,
            of_layers: published.layer_errors.clone(),
        };
        let (looks, samples) = (published.looks(), published.samples.clone());
        let summary = pool.run(|| Summary::of(&published.film, errors, apart, looks, samples));
        (published.stats, summary)
    };
    shared.publish(|published| published.take(stats, Some(summary)));
}
