//! The thread that looks around at a surface point.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use neumann_core::render::hemisphere::NoSurface;
use neumann_core::render::{CancelToken, Hemisphere, Job, WorkerPool};

use crate::render_link::yield_to_interface;

/// How often there are news, while there are any.
pub(super) const NEWS_PERIOD: Duration = Duration::from_millis(150);
/// Directions that each pixel of the pictures gets, at most.
pub(super) const MAX_PASSES: u32 = 1 << 11;
/// Pixels of the diameter of a disk.
const EDGE: usize = 64;

/// What has been found so far.
pub(super) type Found = Result<Arc<Hemisphere>, NoSurface>;

/// Looks around at one point. Ends with this handle.
pub(super) struct Worker {
    /// The generation of pictures that the pixel is of.
    pub(super) generation: u64,
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    cancel: CancelToken,
    is_done: AtomicBool,
    found: Mutex<Option<Found>>,
}

impl Worker {
    /// `None` if the operating system gives no threads.
    pub(super) fn start(job: &Job, generation: u64, pixel: [u32; 2]) -> Option<Self> {
        let shared = Arc::<Shared>::default();
        let pool = WorkerPool::new(None, yield_to_interface).ok()?;
        let (scene, settings) = (Arc::clone(&job.scene), job.settings.clone());
        let of_thread = Arc::clone(&shared);
        let look = move || {
            match Hemisphere::new(scene, &settings, pixel, EDGE) {
                Ok(hemisphere) => of_thread.look(hemisphere, &pool),
                Err(error) => of_thread.publish(Err(error)),
            }
            of_thread.is_done.store(true, Ordering::Relaxed);
        };
        let thread = thread::Builder::new().name("hemisphere".to_owned());
        thread.spawn(look).ok()?;
        Some(Self { generation, shared })
    }

    /// True until all has been found.
    pub(super) fn is_busy(&self) -> bool {
        !self.shared.is_done.load(Ordering::Relaxed)
    }

    /// What has been found since it was asked last.
    pub(super) fn take_news(&self) -> Option<Found> {
        let mut found = self.shared.found.lock();
        found
            .as_mut()
            .map_or_else(|poisoned| poisoned.get_mut().take(), |found| found.take())
    }
}

impl Shared {
    fn look(&self, mut hemisphere: Hemisphere, pool: &WorkerPool) {
        let mut published: Option<Instant> = None;
        while hemisphere.n_passes() < MAX_PASSES {
            if hemisphere.add_pass(pool, &self.cancel).is_err() {
                return;
            }
            if published.is_none_or(|at| at.elapsed() >= NEWS_PERIOD) {
                self.publish(Ok(Arc::new(hemisphere.clone())));
                published = Some(Instant::now());
            }
        }
        self.publish(Ok(Arc::new(hemisphere)));
    }

    fn publish(&self, found: Found) {
        *self.found.lock().unwrap_or_else(PoisonError::into_inner) = Some(found);
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.cancel.cancel();
    }
}
