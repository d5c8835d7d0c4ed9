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
use std::time::{Duration, Instant};

use super::{CancelToken, IterationTimes, RenderSettings, Renderer, WorkerPool};
use crate::film::{Film, PhotonReport, TechniqueFilm};
use crate::integrator::Method;
use crate::radiometry::Rgb;
use crate::scene::Scene;

/// What to render.
#[derive(Clone)]
pub struct Job {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The settings, at full resolution.
    pub settings: RenderSettings,
    /// When it is done.
    pub stop: StopRule,
}

/// When rendering is done by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum StopRule {
    /// Never.
    #[default]
    Never,
    /// After so many iterations at full resolution.
    Iterations(u32),
    /// Before an iteration that would end after so much time of rendering, seconds; after the
    /// first one at the earliest.
    Seconds(f64),
}

/// How rendering is going.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stats {
    /// Iterations in the film.
    pub n_iterations: u32,
    /// Time spent rendering since the job began, seconds; pauses do not count.
    pub seconds: f64,
    /// Camera samples per second over the latest iteration.
    pub samples_per_second: f64,
    /// Rays per second over the latest iteration.
    pub rays_per_second: f64,
    /// [`Film::estimated_error`], renewed a few times a second.
    pub estimated_error: Option<f64>,
    /// Contributions refused because they were not finite or negative.
    pub n_refused: u64,
    /// What the photons of the latest iteration were like, if it had any.
    pub photons: Option<PhotonReport>,
    /// True once the stop rule has been met.
    pub is_done: bool,
}

/// The latest state of the picture.
pub struct Published {
    /// The number [`RenderLoop::start`] gave to the job that made it; 0 before the first frame.
    pub generation: u64,
    /// Grows with every change of this structure.
    pub version: u64,
    /// The film; smaller than asked for by `divisor` while the ladder is climbed.
    pub film: Film,
    /// 8, 4, 2 on the ladder, 1 at full resolution.
    pub divisor: usize,
    /// How rendering is going.
    pub stats: Stats,
    /// Small images of the layers, tail last; sums of them are thumbnails of partial sums.
    pub thumbnails: Vec<Thumbnail>,
    /// [`Film::energy_shares`], renewed with the thumbnails.
    pub energy_shares: Vec<f64>,
    /// Grows when the thumbnails change.
    pub thumbnails_version: u64,
    /// The techniques apart, renewed with the thumbnails while [`RenderLoop::record_techniques`] is
    /// on.
    pub techniques: Option<Arc<TechniqueFilm>>,
}

/// A small linear image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Thumbnail {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `pixels[y * width + x]`, row 0 on top.
    pub pixels: Vec<Rgb>,
}

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
    is_recording: bool,
    has_quit: bool,
    cancel: CancelToken,
}

/// A frame on the ladder should be there within this time.
const COARSE_SECONDS: f64 = 0.020;
/// Thumbnails, shares and error are renewed this often.
const SUMMARY_PERIOD: Duration = Duration::from_millis(250);
/// The longer edge of a thumbnail, pixels.
const THUMBNAIL_EDGE: usize = 128;

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
                is_recording: false,
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
                thumbnails_version: 0,
                techniques: None,
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
    /// before is dropped. It costs time and memory ([`TechniqueFilm::bytes`]), so it is for as long
    /// as somebody looks.
    pub fn record_techniques(&self, is_on: bool) {
        self.shared.control().is_recording = is_on;
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

    /// Waits for something to do: yields the job, its generation and the token to heed.
    fn next_task(&self, generation: u64, is_done: impl Fn(StopRule) -> bool) -> Option<Task> {
        let mut control = self.control();
        loop {
            if control.has_quit {
                return None;
            }
            if let Some(job) = &control.job {
                let is_new = control.generation != generation;
                if (is_new || !is_done(job.stop)) && !control.is_paused {
                    return Some(Task {
                        job: job.clone(),
                        generation: control.generation,
                        cancel: control.cancel.clone(),
                        is_recording: control.is_recording,
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
    is_recording: bool,
}

/// How long the latest iteration took.
#[derive(Clone, Copy)]
struct Pace {
    method: &'static Method,
    seconds_per_pixel: f64,
}

/// Seconds for a pixel of a method that has not been seen at work: the ladder is climbed from far
/// down.
const SLOWEST_PACE: f64 = 1e-5;

/// One job on its way up the ladder and on.
struct Climb {
    generation: u64,
    rungs: Vec<usize>,
    renderer: Option<Renderer>,
    divisor: usize,
    n_iterations: u32,
    seconds: f64,
    /// Of iterations of this rung.
    times: IterationTimes,
}

fn run(shared: &Shared, pool: &WorkerPool) {
    let mut climb = Climb {
        generation: 0,
        rungs: Vec::new(),
        renderer: None,
        divisor: 1,
        n_iterations: 0,
        seconds: 0.0,
        times: IterationTimes::default(),
    };
    let mut pace: Option<Pace> = None;
    let mut summarised: Option<Instant> = None;
    loop {
        let is_done = |stop| climb.is_done(stop);
        let Some(task) = shared.next_task(climb.generation, is_done) else {
            return;
        };
        if task.generation != climb.generation {
            climb = Climb::new(&task, pace);
            summarised = None;
        }
        let start = Instant::now();
        let (generation, divisor) = (climb.generation, climb.divisor);
        let is_first = climb.n_iterations == 0;
        let renderer = climb.renderer(&task.job, pool);
        let (width, height) = (renderer.settings().width, renderer.settings().height);
        let n_pixels = width * height;
        let records = task.is_recording && divisor == 1;
        if records != renderer.techniques().is_some() {
            renderer.record_techniques(records.then(|| technique_divisor(renderer.settings())));
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
        let is_done = divisor == 1 && climb.is_done(task.job.stop);
        let is_due = summarised.is_none_or(|t| t.elapsed() >= SUMMARY_PERIOD) || is_done;
        let summary = is_due.then(|| {
            let published = shared.published();
            let renderer = climb.renderer.as_ref();
            let error = renderer.and_then(|renderer| renderer.estimated_error(&published.film));
            let techniques = renderer.and_then(Renderer::techniques);
            pool.run(|| Summary::of(&published.film, error, techniques))
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

impl Climb {
    /// Begins a job on the coarsest rung that is needed for a first frame in time.
    fn new(task: &Task, pace: Option<Pace>) -> Self {
        let settings = &task.job.settings;
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
            generation: task.generation,
            divisor: first,
            rungs: rungs[..rungs.len() - 1].to_vec(),
            renderer: None,
            n_iterations: 0,
            seconds: 0.0,
            times: IterationTimes::default(),
        }
    }

    fn renderer(&mut self, job: &Job, pool: &WorkerPool) -> &mut Renderer {
        let divisor = self.divisor;
        let renderer = self.renderer.get_or_insert_with(|| {
            let mut settings = job.settings.clone();
            settings.width = settings.width.div_ceil(divisor).max(1);
            settings.height = settings.height.div_ceil(divisor).max(1);
            Renderer::new(Arc::clone(&job.scene), settings, pool.clone(), 0)
        });
        renderer.take_scene(&job.scene);
        renderer
    }

    fn next_rung(&mut self) {
        self.divisor = self.rungs.pop().unwrap_or(1);
        self.renderer = None;
        self.n_iterations = 0;
        self.times = IterationTimes::default();
    }

    fn is_done(&self, stop: StopRule) -> bool {
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

/// So that the longer edge of a technique's image has at most [`THUMBNAIL_EDGE`] pixels: then all
/// of them take 46 MB at 16:9 and 8 layers.
fn technique_divisor(settings: &RenderSettings) -> usize {
    settings.width.max(settings.height).div_ceil(THUMBNAIL_EDGE)
}

/// What is drawn from the whole film, a few times a second.
struct Summary {
    thumbnails: Vec<Thumbnail>,
    energy_shares: Vec<f64>,
    estimated_error: Option<f64>,
    techniques: Option<Arc<TechniqueFilm>>,
}

impl Summary {
    fn of(film: &Film, estimated_error: Option<f64>, techniques: Option<&TechniqueFilm>) -> Self {
        Self {
            thumbnails: (0..=film.n_layers())
                .map(|layer| Thumbnail::of(film, layer))
                .collect(),
            energy_shares: film.energy_shares(),
            estimated_error,
            techniques: techniques.map(|techniques| Arc::new(techniques.clone())),
        }
    }
}

impl Published {
    fn take(&mut self, stats: Stats, summary: Option<Summary>) {
        let estimated_error = self.stats.estimated_error;
        self.stats = Stats {
            estimated_error,
            n_refused: self.film.n_refused(),
            ..stats
        };
        if let Some(summary) = summary {
            self.stats.estimated_error = summary.estimated_error;
            self.thumbnails = summary.thumbnails;
            self.energy_shares = summary.energy_shares;
            self.techniques = summary.techniques;
            self.thumbnails_version += 1;
        }
    }
}

impl Thumbnail {
    /// Averages boxes of pixels of a layer down to at most [`THUMBNAIL_EDGE`] on the longer edge.
    fn of(film: &Film, layer: usize) -> Self {
        let (width, height) = (film.width(), film.height());
        let longer = width.max(height).max(1);
        let edge = longer.min(THUMBNAIL_EDGE);
        let scaled = |n: usize| (n * edge / longer).max(1);
        let (w, h) = (scaled(width), scaled(height));
        let range = |i: usize, n: usize, n_scaled: usize| {
            i * n / n_scaled..((i + 1) * n / n_scaled).max(i * n / n_scaled + 1)
        };
        let mut pixels = Vec::with_capacity(w * h);
        let mut sum = vec![Rgb::BLACK; width];
        for y in 0..h {
            let rows = range(y, height, h);
            sum.fill(Rgb::BLACK);
            for row in rows.clone() {
                film.add_row(layer, row, &mut sum);
            }
            for x in 0..w {
                let columns = range(x, width, w);
                let n = (rows.len() * columns.len()) as f32;
                let sum = sum[columns]
                    .iter()
                    .fold(Rgb::BLACK, |sum, value| sum + *value);
                pixels.push(sum / n);
            }
        }
        Self {
            width: w,
            height: h,
            pixels,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Climb, IterationTimes, StopRule};

    #[test]
    fn an_iteration_that_would_end_too_late_is_not_begun() {
        let mut climb = Climb {
            generation: 1,
            rungs: Vec::new(),
            renderer: None,
            divisor: 1,
            n_iterations: 0,
            seconds: 30.0,
            times: IterationTimes::default(),
        };
        assert!(!climb.is_done(StopRule::Seconds(20.0)), "the first one is");
        climb.n_iterations = 2;
        climb.seconds = 12.0;
        climb.times.take(6.0);
        assert!(!climb.is_done(StopRule::Seconds(20.0)));
        assert!(climb.is_done(StopRule::Seconds(17.0)));
    }
}
