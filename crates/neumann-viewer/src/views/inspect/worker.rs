//! The thread that replays what the film has of a pixel.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use neumann_core::render::{CancelToken, Inspection, Job, Renderer, WorkerPool};

use crate::render_link::yield_to_interface;

/// How often there are news, while there are any.
pub(super) const NEWS_PERIOD: Duration = Duration::from_millis(150);
/// How long it rests when it has caught up with the film.
const REST: Duration = Duration::from_millis(40);
/// Iterations that are replayed, at most.
const MAX_ITERATIONS: u32 = 1 << 16;

/// Replays the iterations of a pixel, one after the other, up to those that the film has. Ends with
/// this handle.
pub(super) struct Worker {
    /// The generation of pictures that the pixel is of.
    pub(super) generation: u64,
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    cancel: CancelToken,
    n_wanted: AtomicU32,
    is_busy: AtomicBool,
    found: Mutex<Arc<Inspection>>,
}

impl Worker {
    /// `None` if the operating system gives no threads.
    pub(super) fn start(job: &Job, generation: u64, pixel: [u32; 2]) -> Option<Self> {
        let shared = Arc::<Shared>::default();
        let pool = WorkerPool::new(None, yield_to_interface).ok()?;
        let (scene, settings) = (Arc::clone(&job.scene), job.settings.clone());
        let of_thread = Arc::clone(&shared);
        let replay = move || {
            let renderer = Renderer::new(Arc::clone(&scene), settings, pool, 0);
            let mut found = Inspection::default();
            let mut published = Instant::now();
            while !of_thread.cancel.is_cancelled() {
                let n = found.n_iterations();
                if n >= of_thread
                    .n_wanted
                    .load(Ordering::Relaxed)
                    .min(MAX_ITERATIONS)
                {
                    of_thread.publish(&found);
                    of_thread.is_busy.store(false, Ordering::Relaxed);
                    thread::sleep(REST);
                    continue;
                }
                of_thread.is_busy.store(true, Ordering::Relaxed);
                let Ok(mut replayed) = renderer.replay(n, &[pixel], &of_thread.cancel) else {
                    return;
                };
                found.add(n, replayed.pop().unwrap_or_default());
                if published.elapsed() >= NEWS_PERIOD {
                    of_thread.publish(&found);
                    published = Instant::now();
                }
            }
        };
        let thread = thread::Builder::new().name("inspector".to_owned());
        thread.spawn(replay).ok()?;
        Some(Self { generation, shared })
    }

    /// The film has so many iterations.
    pub(super) fn go_up_to(&self, n_iterations: u32) {
        self.shared.n_wanted.store(n_iterations, Ordering::Relaxed);
    }

    /// True while there are iterations of the film that it has not replayed.
    pub(super) fn is_busy(&self) -> bool {
        let n = self.shared.found().n_iterations();
        let wanted = self.shared.n_wanted.load(Ordering::Relaxed);
        self.shared.is_busy.load(Ordering::Relaxed) || n < wanted.min(MAX_ITERATIONS)
    }

    /// What has been found, if that is more than `known`.
    pub(super) fn take_news(&self, known: &Inspection) -> Option<Arc<Inspection>> {
        let found = self.shared.found();
        (found.n_iterations() != known.n_iterations()).then_some(found)
    }
}

impl Shared {
    fn publish(&self, found: &Inspection) {
        let mut published = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        if published.n_iterations() != found.n_iterations() {
            *published = Arc::new(found.clone());
        }
    }

    fn found(&self) -> Arc<Inspection> {
        Arc::clone(&self.found.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.cancel.cancel();
    }
}
