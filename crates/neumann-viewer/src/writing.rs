//! Files that are being written in the background: the program does not end before they are.

use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

static N_WRITING: Mutex<usize> = Mutex::new(0);
static IS_DONE: Condvar = Condvar::new();

/// A file that is being written, until it is dropped.
pub(crate) struct Writing(());

impl Writing {
    /// Begins before the thread that writes, so that none is overlooked.
    pub(crate) fn begin() -> Self {
        *N_WRITING.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        Self(())
    }
}

impl Drop for Writing {
    fn drop(&mut self) {
        let mut n = N_WRITING.lock().unwrap_or_else(PoisonError::into_inner);
        *n = n.saturating_sub(1);
        IS_DONE.notify_all();
    }
}

/// Waits until all files are written, but no longer than `patience`. True if they are.
pub(crate) fn finish(patience: Duration) -> bool {
    let n = N_WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    let waited = IS_DONE.wait_timeout_while(n, patience, |n| *n > 0);
    !waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::{Writing, finish};

    #[test]
    fn the_end_waits_for_what_is_being_written() {
        let writing = Writing::begin();
        assert!(!finish(Duration::from_millis(20)));
        let thread = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(50));
            drop(writing);
        });
        assert!(finish(Duration::from_secs(60)));
        thread.join().expect("it ends");
    }
}
