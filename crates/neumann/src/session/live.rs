//! Shows the film in tev while it renders.

use std::time::Instant;

use neumann_core::film::Film;
use neumann_picture::tev::Tev;

use crate::console;

/// Seconds between two frames,
const PERIOD: f64 = 0.3;
/// or so many times what showing one takes, if that is longer.
const SHOW_TIMES: f64 = 10.0;

/// Somebody who looks on.
pub(crate) struct Live {
    /// `None` once it has gone.
    tev: Option<Tev>,
    /// What the picture is called there.
    name: String,
    /// When the film was last shown; `None` before.
    since: Option<Instant>,
    /// How long that took, seconds.
    took: f64,
}

impl Live {
    pub(crate) fn new(tev: Tev, name: String) -> Self {
        Self {
            tev: Some(tev),
            name,
            since: None,
            took: 0.0,
        }
    }

    /// Shows the film, unless that was done a moment ago.
    pub(super) fn show_if_due(&mut self, film: &Film) {
        let period = PERIOD.max(SHOW_TIMES * self.took);
        let is_early = |since: Instant| since.elapsed().as_secs_f64() < period;
        if !self.since.is_some_and(is_early) {
            self.show(film);
        }
    }

    /// Shows the film. Rendering goes on without who has gone.
    pub(crate) fn show(&mut self, film: &Film) {
        let Some(tev) = &mut self.tev else { return };
        let start = Instant::now();
        if let Err(error) = tev.show(&self.name, film) {
            console::note(&format!("warning: {error}; rendering goes on"));
            self.tev = None;
        }
        self.took = start.elapsed().as_secs_f64();
        self.since = Some(Instant::now());
    }
}
