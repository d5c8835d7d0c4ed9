//! The worker threads.

use std::sync::Arc;

/// A pool of worker threads; cheap to clone, all clones are one pool.
#[derive(Clone, Debug)]
pub struct WorkerPool(Arc<rayon::ThreadPool>);

impl WorkerPool {
    /// A pool of `n_threads` (all the machine has, if `None`); each calls `on_start` first,
    /// for instance to lower its priority below that of an interface.
    ///
    /// # Errors
    /// If the operating system gives no threads.
    pub fn new(
        n_threads: Option<usize>,
        on_start: impl Fn() + Send + Sync + 'static,
    ) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n_threads.unwrap_or(0))
            .thread_name(|i| format!("neumann-worker-{i}"))
            .start_handler(move |_| on_start())
            .build()?;
        Ok(Self(Arc::new(pool)))
    }

    /// Number of threads.
    #[must_use]
    pub fn n_threads(&self) -> usize {
        self.0.current_num_threads()
    }

    /// Runs something on the pool, so that its parallel loops use these threads.
    pub fn run<R: Send>(&self, f: impl FnOnce() -> R + Send) -> R {
        self.0.install(f)
    }

    /// Runs something once on each of the threads; yields what each has yielded.
    pub fn on_each<R: Send>(&self, f: impl Fn() -> R + Sync) -> Vec<R> {
        self.0.broadcast(|_| f())
    }
}
