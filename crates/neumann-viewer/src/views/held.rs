//! Work that a view holds on a thread of its own, for as long as it is shown and wanted. The window
//! reads what was published last; neither waits for the other.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use neumann_core::render::{CancelToken, RenderSettings, WorkerPool};

use crate::session::Session;

/// How often paused work looks whether it goes on.
const NAP: Duration = Duration::from_millis(20);
/// Work begins when nothing has been changed for so long.
const REST: Duration = Duration::from_millis(150);
/// While work is held, a frame is drawn so often.
pub(super) const PERIOD: Duration = Duration::from_millis(300);

/// A larger film is measured in a smaller size, of so many pixels at most.
const MOST_PIXELS: usize = 1 << 18;

/// The settings of a film that is as large, or by a whole number smaller.
pub(super) fn within_memory(settings: &RenderSettings) -> RenderSettings {
    let size = |by: usize| [settings.width, settings.height].map(|n| n.div_ceil(by));
    let is_small = |by: &usize| size(*by).iter().product::<usize>() <= MOST_PIXELS;
    let [width, height] = (1..).find(is_small).map_or([1, 1], size);
    RenderSettings {
        width,
        height,
        ..settings.clone()
    }
}

/// Work under way, which publishes reports; dropping it ends it.
pub(super) struct Held<R> {
    shared: Arc<Shared<R>>,
    /// Version of the report that was taken last.
    taken: u64,
}

/// What the work and its window have in common.
pub(super) struct Shared<R> {
    pub(super) cancel: CancelToken,
    is_paused: AtomicBool,
    /// Grows with everything that is published.
    version: AtomicU64,
    report: Mutex<R>,
}

impl<R: Clone + Default + Send + 'static> Held<R> {
    /// Begins work. `None` if the operating system gives no thread.
    pub(super) fn begin(
        name: &str,
        work: impl FnOnce(&Shared<R>) + Send + 'static,
    ) -> Option<Self> {
        let shared = Arc::new(Shared {
            cancel: CancelToken::default(),
            is_paused: AtomicBool::new(false),
            version: AtomicU64::new(0),
            report: Mutex::default(),
        });
        let for_thread = Arc::clone(&shared);
        std::thread::Builder::new()
            .name(format!("neumann-{name}"))
            .spawn(move || work(&for_thread))
            .ok()?;
        Some(Self { shared, taken: 0 })
    }

    /// Pauses after the step under way, or goes on.
    pub(super) fn pause(&self, is_paused: bool) {
        self.shared.is_paused.store(is_paused, Ordering::Relaxed);
    }

    /// What was published since it was asked last.
    pub(super) fn take_news(&mut self) -> Option<R> {
        let version = self.shared.version.load(Ordering::Acquire);
        (version != self.taken).then(|| {
            self.taken = version;
            lock(&self.shared.report).clone()
        })
    }
}

impl<R> Drop for Held<R> {
    fn drop(&mut self) {
        self.shared.cancel.cancel();
    }
}

impl<R> Shared<R> {
    /// Waits while the work is paused. False once it is ended.
    pub(super) fn goes_on(&self) -> bool {
        while self.is_paused.load(Ordering::Relaxed) && !self.cancel.is_cancelled() {
            std::thread::sleep(NAP);
        }
        !self.cancel.is_cancelled()
    }

    /// Changes the report.
    pub(super) fn publish(&self, change: impl FnOnce(&mut R)) {
        change(&mut lock(&self.report));
        self.version.fetch_add(1, Ordering::Release);
    }
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Sees that what is worked on is what is wanted.
pub(super) struct Follower<W, R> {
    held: Option<(Held<R>, W)>,
    /// What is to be begun next, since when.
    next: Option<(W, Instant)>,
}

impl<W, R> Default for Follower<W, R> {
    fn default() -> Self {
        Self {
            held: None,
            next: None,
        }
    }
}

impl<W, R> Follower<W, R>
where
    W: PartialEq + Clone + Send + 'static,
    R: Clone + Default + Send + 'static,
{
    /// Once a frame: sees that `work` is done on what is wanted, with the threads of the window and
    /// paused as the film is. Yields what is new; nothing yet, where it has just begun.
    pub(super) fn attend(
        &mut self,
        name: &str,
        wanted: Option<W>,
        session: &Session,
        is_first: bool,
        work: fn(&Shared<R>, &W, &WorkerPool),
    ) -> Option<R> {
        let mut has_begun = false;
        if let (Some(wanted), Some(pool)) = (wanted, session.link.pool()) {
            has_begun = self.follow(&wanted, is_first, |wanted| {
                let pool = pool.clone();
                Held::begin(name, move |shared| work(shared, &wanted, &pool))
            });
        }
        let held = self.held()?;
        held.pause(session.link.is_paused());
        let news = held.take_news();
        news.or_else(|| has_begun.then(R::default))
    }
}

impl<W: PartialEq + Clone, R> Follower<W, R> {
    /// The work under way.
    pub(super) fn held(&mut self) -> Option<&mut Held<R>> {
        self.held.as_mut().map(|(held, _)| held)
    }

    /// True while work is held.
    pub(super) fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// True while there will be news.
    pub(super) fn is_busy(&self) -> bool {
        self.held.is_some() || self.next.is_some()
    }

    /// Ends what is not wanted, and begins what is once that has come to rest; at once, if
    /// `is_first`. True if it has begun.
    pub(super) fn follow(
        &mut self,
        wanted: &W,
        is_first: bool,
        begin: impl FnOnce(W) -> Option<Held<R>>,
    ) -> bool {
        if self.held.as_ref().is_some_and(|(_, held)| held == wanted) {
            self.next = None;
            return false;
        }
        self.held = None;
        let since = match &self.next {
            Some((next, since)) if next == wanted => *since,
            _ => Instant::now(),
        };
        if !is_first && since.elapsed() < REST {
            self.next = Some((wanted.clone(), since));
            return false;
        }
        self.next = None;
        self.held = begin(wanted.clone()).map(|held| (held, wanted.clone()));
        true
    }
}

#[cfg(test)]
mod tests {
    use neumann_core::render::RenderSettings;
    use neumann_core::scene::builtin::builtin;

    use super::{MOST_PIXELS, within_memory};

    #[test]
    fn a_large_film_is_measured_in_a_smaller_size() {
        let camera = builtin("cornell").unwrap().load().unwrap().cameras[0].clone();
        for (size, expected) in [
            ((512, 512), (512, 512)),
            ((513, 512), (257, 256)),
            ((1280, 720), (640, 360)),
            ((7680, 4320), (640, 360)),
            ((1, 300_000), (1, 150_000)),
        ] {
            let settings = within_memory(&RenderSettings::new(camera.clone(), size.0, size.1));
            assert_eq!((settings.width, settings.height), expected);
            assert!(settings.width * settings.height <= MOST_PIXELS);
        }
    }
}
