//! How far the two pictures on the screen are apart, measured in the background.
//!
//! The window never waits for it: while one measurement is under way no other one is begun, and
//! afterwards there is a rest three times as long.

use std::time::{Duration, Instant};

use neumann_core::film::View as Part;
use neumann_core::memory::Share;
use neumann_picture::Image;
use neumann_picture::compare::{compare, working_bytes};
use neumann_picture::tone::Display;

use super::{Compared, Pixels};
use crate::display::{Slot, ViewSettings};
use crate::session::Session;
use crate::widgets::significant;

/// How far two pictures are apart, as `neumann compare` defines it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Mean relative square error.
    pub rel_mse: f64,
    /// Mean FLIP error, as both are shown.
    pub flip: f64,
}

/// Which two pictures were measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    slots: [Slot; 2],
    part: Part,
    generation: u64,
    /// [`crate::picture::Picture::n_taken`].
    n_taken: u64,
}

/// What is measured, and what came of it.
#[derive(Debug, Default)]
pub struct Measuring {
    is_running: bool,
    rest_until: Option<Instant>,
    last: Option<(Pair, u64, Display)>,
    result: Option<(Pair, Measured)>,
}

/// A measurement to be made.
pub struct Measurement {
    pair: Pair,
    pixels: [Pixels; 2],
    display: Display,
}

/// A measurement that was made.
pub struct Outcome {
    pair: Pair,
    measured: Option<Measured>,
    took: Duration,
}

/// Shortest rest between two measurements.
const REST: Duration = Duration::from_millis(400);

impl Measured {
    /// Both errors in one line.
    #[must_use]
    pub fn words(&self) -> String {
        let (rel_mse, flip) = (significant(self.rel_mse, 3), significant(self.flip, 3));
        format!("relMSE {rel_mse} · FLIP {flip}")
    }
}

impl Measuring {
    /// What was measured of these pictures, if that is done.
    #[must_use]
    pub fn of(&self, session: &Session, compared: &Compared) -> Option<Measured> {
        let pair = Pair::of(session, compared)?;
        let (of, measured) = self.result.as_ref()?;
        (*of == pair).then_some(*measured)
    }

    /// How long the next measurement must wait yet.
    #[must_use]
    pub fn rest(&self) -> Option<Duration> {
        let rest = self.rest_until?.checked_duration_since(Instant::now());
        rest.filter(|rest| !self.is_running && !rest.is_zero())
    }

    /// Takes over what came of a measurement.
    pub fn take(&mut self, outcome: Outcome) {
        self.is_running = false;
        self.rest_until = Some(Instant::now() + REST.max(3 * outcome.took));
        self.result = outcome.measured.map(|measured| (outcome.pair, measured));
    }
}

impl Session {
    /// The next measurement, if there is anything new to measure and the time for it has come.
    pub fn next_measurement(
        &mut self,
        compared: &Compared,
        settings: &ViewSettings,
    ) -> Option<Measurement> {
        let pair = Pair::of(self, compared)?;
        let is_live = pair.slots.contains(&Slot::Live);
        let version = if is_live { self.picture.version } else { 0 };
        let display = settings.display();
        let next = (pair, version, display);
        let measuring = &mut self.measuring;
        if measuring.is_running || measuring.last == Some(next) || measuring.rest().is_some() {
            return None;
        }
        let [a, b] = compared.sides()?;
        let pixels = [a.pixels(self), b.pixels(self)];
        if pixels[0].size != pixels[1].size {
            return None;
        }
        self.measuring.last = Some(next);
        self.measuring.is_running = true;
        Some(Measurement {
            pair,
            pixels,
            display,
        })
    }
}

impl Pair {
    /// Two pictures that can be measured: of the same part, and at full resolution.
    fn of(session: &Session, compared: &Compared) -> Option<Self> {
        let [a, b] = compared.sides()?;
        let picture = &session.picture;
        (a.part == b.part && picture.divisor == 1).then_some(Self {
            slots: [a.slot, b.slot],
            part: a.part,
            generation: picture.generation,
            n_taken: picture.n_taken,
        })
    }
}

impl Measurement {
    /// Measures; takes a while.
    #[must_use]
    pub fn make(self) -> Outcome {
        let start = Instant::now();
        let n_pixels = self.pixels[0].pixels.len();
        let [a, b] = self.pixels.map(|pixels| Image {
            width: pixels.size.0,
            height: pixels.size.1,
            pixels: std::sync::Arc::unwrap_or_clone(pixels.pixels),
            ..Image::default()
        });
        let paid = Share::of_process(working_bytes(n_pixels)).ok();
        let comparison = paid.and_then(|_paid| compare(&a, &b, &self.display).ok());
        Outcome {
            pair: self.pair,
            measured: comparison.map(|comparison| Measured {
                rel_mse: comparison.rel_mse,
                flip: comparison.flip,
            }),
            took: start.elapsed(),
        }
    }
}
