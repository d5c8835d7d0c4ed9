//! The only file that talks to the renderer.
//!
//! In the window and for screenshots the link leads to a [`RenderLoop`]; tests hang a finished
//! picture on it instead, and read what would have been started.

use std::sync::Arc;

use neumann_core::film::PathClasses;
use neumann_core::render::{Job, Published, RenderLoop, RenderSettings, StopRule, WorkerPool};
use neumann_core::scene::Scene;
use neumann_core::scene::description::{CameraDescription, Crop};

/// The line to the renderer.
pub struct RenderLink {
    end: End,
    started: Option<Job>,
    /// Generations that render a region, and their cameras.
    regions: Vec<(u64, CameraDescription)>,
    n_starts: u64,
    generation: u64,
    is_recording: bool,
    draws_photons: bool,
    traces_features: bool,
    classes: Option<Arc<PathClasses>>,
    is_paused: bool,
    is_held: bool,
}

enum End {
    Live(Box<RenderLoop>, WorkerPool),
    Fixed(Box<Published>),
}

impl RenderLink {
    /// A renderer of its own, on `n_threads` (all, if `None`) of low priority. `on_publish` is
    /// called after every change of the picture, on another thread.
    ///
    /// # Errors
    /// If the operating system gives no threads.
    pub fn live(
        n_threads: Option<usize>,
        on_publish: impl Fn() + Send + Sync + 'static,
    ) -> Result<Self, String> {
        let pool = WorkerPool::new(n_threads, yield_to_interface)
            .map_err(|e| format!("no threads to render with: {e}"))?;
        let render_loop = RenderLoop::new(pool.clone(), on_publish)
            .map_err(|e| format!("no thread to render with: {e}"))?;
        Ok(Self::new(End::Live(Box::new(render_loop), pool)))
    }

    /// A picture that never changes.
    #[must_use]
    pub fn fixed(published: Published) -> Self {
        Self::new(End::Fixed(Box::new(published)))
    }

    fn new(end: End) -> Self {
        Self {
            end,
            started: None,
            regions: Vec::new(),
            n_starts: 0,
            generation: 0,
            is_recording: false,
            draws_photons: false,
            traces_features: false,
            classes: None,
            is_paused: false,
            is_held: false,
        }
    }

    /// Starts rendering anew; the old picture stays until the new one has a first frame.
    pub fn start(&mut self, scene: Arc<Scene>, settings: RenderSettings, stop: StopRule) {
        let job = Job {
            scene,
            settings,
            stop,
        };
        self.n_starts += 1;
        self.started = Some(job.clone());
        let camera = job.settings.camera.clone();
        let oldest = self.read(|published| published.generation);
        self.generation = match &self.end {
            End::Live(render_loop, _) => render_loop.start(job),
            End::Fixed(published) => published.generation,
        };
        let latest = self.generation;
        let regions = &mut self.regions;
        regions.retain(|(of, _)| (oldest..latest).contains(of));
        if camera.crop.is_some() {
            regions.push((latest, camera));
        }
    }

    /// The region that a generation renders, and the camera with it; `None` where it renders the
    /// whole picture.
    #[must_use]
    pub fn region_of(&self, generation: u64) -> Option<(&CameraDescription, &Crop)> {
        let mut regions = self.regions.iter();
        let (_, camera) = regions.find(|(of, _)| *of == generation)?;
        Some((camera, camera.crop.as_ref()?))
    }

    /// Goes on with the same scene over a better tree.
    pub fn improve_scene(&mut self, scene: &Arc<Scene>, better: &Arc<Scene>) {
        if let Some(job) = &mut self.started
            && Arc::ptr_eq(&job.scene, scene)
        {
            job.scene = Arc::clone(better);
        }
        if let End::Live(render_loop, _) = &self.end {
            render_loop.improve_scene(scene, better);
        }
    }

    /// The generation of what was started last: pictures of an older one are of something else.
    #[must_use]
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// What was started last.
    #[must_use]
    pub fn started(&self) -> Option<&Job> {
        self.started.as_ref()
    }

    /// How often something was started.
    #[must_use]
    pub fn n_starts(&self) -> u64 {
        self.n_starts
    }

    /// Pauses or goes on.
    pub fn pause(&mut self, pause: bool) {
        self.is_paused = pause;
        self.pass_pause_on();
    }

    /// Lets the film rest, whether it is paused or not, while something else has the threads; or
    /// lets it go on.
    pub fn hold(&mut self, is_held: bool) {
        self.is_held = is_held;
        self.pass_pause_on();
    }

    /// True while the film rests for something else.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.is_held
    }

    fn pass_pause_on(&self) {
        if let End::Live(render_loop, _) = &self.end {
            render_loop.pause(self.is_paused || self.is_held);
        }
    }

    /// The threads that it renders with, where it renders.
    #[must_use]
    pub fn pool(&self) -> Option<&WorkerPool> {
        match &self.end {
            End::Live(_, pool) => Some(pool),
            End::Fixed(_) => None,
        }
    }

    /// True while paused.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.is_paused
    }

    /// Begins or ends keeping techniques apart.
    pub fn record_techniques(&mut self, is_on: bool) {
        self.is_recording = is_on;
        if let End::Live(render_loop, _) = &self.end {
            render_loop.record_techniques(is_on);
        }
    }

    /// True while techniques are kept apart.
    #[must_use]
    pub fn is_recording(&self) -> bool {
        self.is_recording
    }

    /// Begins or ends drawing photons.
    pub fn draw_photons(&mut self, is_on: bool) {
        self.draws_photons = is_on;
        if let End::Live(render_loop, _) = &self.end {
            render_loop.draw_photons(is_on);
        }
    }

    /// True while photons are drawn.
    #[must_use]
    pub fn draws_photons(&self) -> bool {
        self.draws_photons
    }

    /// Begins or ends keeping what the camera sees first.
    pub fn trace_features(&mut self, is_on: bool) {
        self.traces_features = is_on;
        if let End::Live(render_loop, _) = &self.end {
            render_loop.trace_features(is_on);
        }
    }

    /// True while what the camera sees first is kept.
    #[must_use]
    pub fn traces_features(&self) -> bool {
        self.traces_features
    }

    /// Begins to keep classes of paths apart, or others than before, or ends it.
    pub fn keep_classes(&mut self, classes: Option<Arc<PathClasses>>) {
        self.classes.clone_from(&classes);
        if let End::Live(render_loop, _) = &self.end {
            render_loop.keep_classes(classes);
        }
    }

    /// The classes of paths that are kept apart.
    #[must_use]
    pub fn kept_classes(&self) -> Option<&Arc<PathClasses>> {
        self.classes.as_ref()
    }

    /// Changes when rendering is done, without starting anew.
    pub fn stop_after(&mut self, stop: StopRule) {
        if let Some(job) = &mut self.started {
            job.stop = stop;
        }
        if let End::Live(render_loop, _) = &self.end {
            render_loop.stop_after(stop);
        }
    }

    /// Grows whenever the picture changes; asks no lock.
    #[must_use]
    pub fn version(&self) -> u64 {
        match &self.end {
            End::Live(render_loop, _) => render_loop.version(),
            End::Fixed(published) => published.version,
        }
    }

    /// Reads the picture; the renderer cannot take in a frame meanwhile, so be brief.
    pub fn read<R>(&self, reader: impl FnOnce(&Published) -> R) -> R {
        match &self.end {
            End::Live(render_loop, _) => reader(&render_loop.published()),
            End::Fixed(published) => reader(published),
        }
    }
}

/// Lets the interface go first: workers take what it leaves of the processors.
pub(crate) fn yield_to_interface() {
    lower_priority(10);
}

/// Lets interface and renderer go first.
pub(crate) fn yield_to_renderer() {
    lower_priority(15);
}

#[cfg(target_os = "linux")]
fn lower_priority(by: i32) {
    // On Linux this is the priority of the calling thread alone. Where it is refused, rendering is
    // as good and the interface a little slower.
    let _ = rustix::process::setpriority_process(None, by);
}

#[cfg(not(target_os = "linux"))]
fn lower_priority(_by: i32) {}
