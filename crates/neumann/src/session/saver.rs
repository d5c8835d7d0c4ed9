//! Saves the film while it renders, so that a kill loses little.

use std::time::Instant;

use neumann_core::film::{Features, Film};
use neumann_picture::exr_file::Metadata;

use crate::console;
use crate::failure::Outcome;

/// Seconds between two saves where nothing is asked for,
const DEFAULT_PERIOD: f64 = 60.0;
/// or so many times what a save takes, if that is longer.
const SAVE_TIMES: f64 = 20.0;

/// Writes a film and what belongs to it.
pub(crate) type Write<'a> = dyn Fn(&Film, &Features, &Metadata) -> Outcome + 'a;

/// Saves a film now and then.
pub(crate) struct Saver<'a> {
    write: &'a Write<'a>,
    /// Seconds between two saves; `None` leaves it to the saver.
    period: Option<f64>,
    /// When the film was last saved, or begun.
    since: Instant,
    /// How long the last save took, seconds.
    took: f64,
}

impl<'a> Saver<'a> {
    /// Saves by `write`, every so many seconds if it is said how many; 0 is never.
    pub(crate) fn new(period: Option<f64>, write: &'a Write<'a>) -> Self {
        Self {
            write,
            period,
            since: Instant::now(),
            took: 0.0,
        }
    }

    /// Whether the film must be saved now, if the next iteration takes so many seconds.
    pub(super) fn is_due(&self, next: f64) -> bool {
        let default = DEFAULT_PERIOD.max(SAVE_TIMES * self.took);
        let period = self.period.unwrap_or(default);
        period > 0.0 && self.since.elapsed().as_secs_f64() + next >= period
    }

    /// Saves. What cannot be saved now may be later, so rendering goes on.
    pub(super) fn save(&mut self, film: &Film, features: &Features, metadata: &Metadata) {
        let start = Instant::now();
        if let Err(error) = (self.write)(film, features, metadata) {
            console::note(&format!("warning: not saved yet: {error:#}"));
        }
        self.took = start.elapsed().as_secs_f64();
        self.since = Instant::now();
    }
}

#[cfg(test)]
mod tests {
    use super::Saver;

    #[test]
    fn a_film_is_saved_before_more_than_the_period_would_be_lost() {
        let write = |_: &_, _: &_, _: &_| Ok(());
        let mut saver = Saver::new(Some(30.0), &write);
        assert!(!saver.is_due(29.0) && saver.is_due(30.0));
        saver.period = None;
        assert!(!saver.is_due(59.0) && saver.is_due(60.0));
        saver.took = 10.0;
        assert!(
            !saver.is_due(199.0),
            "saving takes no more than a twentieth"
        );
        saver.period = Some(0.0);
        assert!(!saver.is_due(1e9), "0 is never");
    }
}
