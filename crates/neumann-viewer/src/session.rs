//! One render: what is asked for, the line to the renderer, and the film as of this frame.
//!
//! There may be several side by side. Nothing here knows how the film is looked at, nor what the
//! window looks like around it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use neumann_core::film::{Film, View as Part};
use neumann_picture::exr_file::{IterationRanges, Metadata};

use crate::picture::Picture;
use crate::render_link::RenderLink;
use crate::setup::Setup;
use crate::views::Needs;

/// A render, and the film that comes of it.
pub struct Session {
    /// What is rendered.
    pub setup: Setup,
    /// The line to the renderer.
    pub link: RenderLink,
    /// The film as of this frame.
    pub picture: Picture,
    room: Room,
}

/// The room for the film, which the film follows when it has come to rest.
struct Room {
    wanted: (usize, usize),
    changed: Option<Instant>,
    is_debounced: bool,
}

/// A film is made for a new size of the window when that has held this long.
const RESIZE_DELAY: Duration = Duration::from_millis(180);

impl Session {
    /// Renders `setup` on `link`. A film follows the room for it at once, unless `is_debounced`.
    #[must_use]
    pub fn new(setup: Setup, link: RenderLink, is_debounced: bool) -> Self {
        Self {
            setup,
            link,
            picture: Picture::default(),
            room: Room {
                wanted: (0, 0),
                changed: None,
                is_debounced,
            },
        }
    }

    /// True when the picture on screen is of what has been asked for.
    #[must_use]
    pub fn is_current(&self) -> bool {
        self.picture.is_there() && self.picture.generation == self.link.generation()
    }

    /// Starts rendering anew if anything of it has been changed.
    pub fn start_if_changed(&mut self) {
        if !self.setup.is_changed {
            return;
        }
        let (Some(settings), Some(open)) = (self.setup.settings(), &self.setup.open) else {
            return;
        };
        self.link
            .start(Arc::clone(&open.scene), settings, self.setup.stop);
        self.setup.is_changed = false;
    }

    /// Lets the film's size follow the room for it, physical pixels, when that has come to rest;
    /// yields how long it must rest yet.
    pub fn follow_room(&mut self, room: egui::Vec2) -> Option<Duration> {
        let wanted = self.setup.size_for(room);
        if wanted == self.setup.size || self.setup.open.is_none() {
            self.room.wanted = wanted;
            self.room.changed = None;
            return None;
        }
        if wanted != self.room.wanted {
            self.room.wanted = wanted;
            self.room.changed = Some(Instant::now());
        }
        let is_first = self.setup.size == (0, 0) || !self.room.is_debounced;
        let changed = self.room.changed;
        let rested = changed.map_or(RESIZE_DELAY, |since| since.elapsed());
        if !is_first && rested < RESIZE_DELAY {
            return Some(RESIZE_DELAY - rested);
        }
        self.setup.size = wanted;
        self.setup.is_changed = true;
        self.room.changed = None;
        None
    }

    /// Why the picture is biased, if it is: a method that merges is not while nothing is merged.
    #[must_use]
    pub fn bias(&self) -> Option<&'static str> {
        let photons = self.picture.stats.photons.filter(|_| self.is_current());
        let merges = photons.is_none_or(|photons| photons.radius > 0.0);
        self.setup.method().bias.filter(|_| merges)
    }

    /// What the present picture is, in short.
    #[must_use]
    pub fn label(&self, part: Part) -> String {
        let n = self.picture.stats.n_iterations;
        format!("{part} · {} · {n}", self.setup.method().title)
    }

    /// Puts a part of the film aside as A (0) or B (1).
    pub fn hold(&mut self, which: usize, part: Part) {
        if self.picture.is_there() {
            let label = self.label(part);
            self.picture.hold(&self.link, which, part, label);
        }
    }

    /// The film with how it was made; `None` while it is not of what has been asked for.
    #[must_use]
    pub fn film(&self) -> Option<(Film, Metadata)> {
        let metadata = self.metadata()?;
        let (film, seconds) = self
            .link
            .read(|published| (published.film.clone(), published.stats.seconds));
        // An iteration may have come in between.
        let metadata = Metadata {
            iterations: IterationRanges::of(0..film.n_iterations()),
            seconds,
            n_refused: film.n_refused(),
            ..metadata
        };
        Some((film, metadata))
    }

    /// How the film was made; `None` while it is not of what has been asked for.
    #[must_use]
    pub fn metadata(&self) -> Option<Metadata> {
        let (job, open) = (self.link.started()?, self.setup.open.as_ref()?);
        if !self.is_current() {
            return None;
        }
        let (n_iterations, n_refused, seconds) = self.link.read(|published| {
            let film = &published.film;
            (
                film.n_iterations(),
                film.n_refused(),
                published.stats.seconds,
            )
        });
        Some(Metadata {
            iterations: IterationRanges::of(0..n_iterations),
            seconds,
            n_refused,
            ..Metadata::of(&open.scene, &job.settings)
        })
    }

    /// Lets the renderer do what a view needs, and no more.
    pub fn provide(&mut self, needs: Needs) {
        if self.link.is_recording() != needs.techniques {
            self.link.record_techniques(needs.techniques);
        }
        if self.link.draws_photons() != needs.photons {
            self.link.draw_photons(needs.photons);
        }
    }
}
