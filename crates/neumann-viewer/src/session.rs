//! One render: what is asked for, the line to the renderer, and the film as of this frame.
//!
//! There may be several side by side. Nothing here knows how the film is looked at, nor what the
//! window looks like around it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use neumann_core::film::{Film, View as Part};
use neumann_core::integrator::Method;
use neumann_core::render::{Job, RenderSettings};
use neumann_core::scene::Scene;
use neumann_core::scene::description::Crop;
use neumann_picture::exr_file::{IterationRanges, Metadata, camera_text};

use crate::compared::{Measuring, Origin, SceneName};
use crate::display::ViewSettings;
use crate::history::History;
use crate::picture::Picture;
use crate::render_link::RenderLink;
use crate::setup::{FilmSize, Setup};
use crate::views::Needs;

/// A render, and the film that comes of it.
pub struct Session {
    /// What is rendered.
    pub setup: Setup,
    /// What of it has been edited, to be undone.
    pub history: History,
    /// The line to the renderer.
    pub link: RenderLink,
    /// The film as of this frame.
    pub picture: Picture,
    /// How far it is from what it is compared with.
    pub measuring: Measuring,
    made: Option<Made>,
    /// Part of the series that was shown last.
    part: Part,
    room: Room,
    kept: Option<Kept>,
}

/// What the picture on screen was made by and of, and the camera as files write it down.
struct Made {
    method: &'static Method,
    scene: Arc<Scene>,
    camera: String,
}

impl Made {
    fn of(job: &Job) -> Self {
        Self {
            method: job.settings.method,
            scene: Arc::clone(&job.scene),
            camera: camera_text(&job.settings.camera),
        }
    }
}

/// The room for the film.
struct Room {
    /// Size of a film that fits it.
    fitting: (usize, usize),
    /// When it changed last, and whether the film was young when it began to.
    changed: Option<(Instant, bool)>,
    is_debounced: bool,
}

/// A picture that stays until the film of another size, or the one after a region, has caught up
/// with it.
#[derive(Clone, Copy, Debug)]
struct Kept {
    n_iterations: u32,
    part: Part,
    /// A region was rendered, not a film of another size.
    is_after_region: bool,
}

/// A film is made for a new size of the window when that has held this long.
const RESIZE_DELAY: Duration = Duration::from_millis(180);
/// A film that took less time than this is not worth keeping, seconds.
const YOUNG: f64 = 1.0;

impl Session {
    /// Renders `setup` on `link`. The film follows the room for it always and at once, unless
    /// `is_debounced`.
    #[must_use]
    pub fn new(setup: Setup, link: RenderLink, is_debounced: bool) -> Self {
        Self {
            setup,
            history: History::default(),
            link,
            picture: Picture::default(),
            measuring: Measuring::default(),
            made: None,
            part: Part::Total,
            room: Room {
                fitting: (0, 0),
                changed: None,
                is_debounced,
            },
            kept: None,
        }
    }

    /// True when the picture on screen is of what has been asked for.
    #[must_use]
    pub fn is_current(&self) -> bool {
        self.picture.is_there() && self.picture.generation == self.link.generation()
    }

    /// True when, besides, nothing else has been asked for since: a state brings a size with it.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.is_current() && !self.setup.is_changed
    }

    /// Starts rendering anew if anything of it has been changed.
    pub fn start_if_changed(&mut self) {
        if !self.setup.is_changed {
            return;
        }
        let (Some(settings), Some(open)) = (self.setup.settings(), &self.setup.open) else {
            return;
        };
        let scene = Arc::clone(&open.scene);
        let is_only_resized = self.link.started().is_some_and(|job| {
            let size = (job.settings.width, job.settings.height);
            let is_resized = size != (settings.width, settings.height);
            let resized = RenderSettings {
                width: settings.width,
                height: settings.height,
                ..job.settings.clone()
            };
            is_resized && resized == settings && Arc::ptr_eq(&job.scene, &scene)
        });
        let is_kept = is_only_resized && self.room.is_debounced;
        let is_whole = settings.camera.crop.is_none();
        if !is_whole {
            self.keep_around(&scene);
        }
        if is_whole && self.takes_up_around(&scene, &settings) {
            self.made = self
                .picture
                .around
                .as_ref()
                .map(|around| Made::of(&around.job));
            self.kept = self.picture.put_back(self.part).map(|n_iterations| Kept {
                n_iterations,
                part: self.part,
                is_after_region: true,
            });
        } else if !is_kept {
            self.kept = None;
        } else if self.is_current() && self.picture.divisor == 1 {
            self.kept = Some(Kept {
                n_iterations: self.picture.stats.n_iterations,
                part: self.part,
                is_after_region: false,
            });
        }
        self.link.start(scene, settings, self.setup.stop);
        self.setup.is_changed = false;
    }

    /// Keeps the whole picture, if it is there, as a region of it is rendered next; nothing of
    /// another scene.
    fn keep_around(&mut self, scene: &Scene) {
        let is_of_region = |job: &Job| job.settings.camera.crop.is_some();
        let is_of_scene = |job: &Job| std::ptr::eq(job.scene.geometry(), scene.geometry());
        let is_there = self.kept.is_some_and(|kept| kept.is_after_region)
            || self.link.started().is_some_and(is_of_region);
        if !is_there {
            let job = self.link.started().filter(|job| {
                let published = self.link.read(|published| published.generation);
                let is_there = self.picture.is_there() && published == self.link.generation();
                is_there && is_of_scene(job)
            });
            match job.cloned() {
                Some(job) => self.picture.keep_around(&self.link, job),
                None => self.picture.around = None,
            }
        } else if !self
            .picture
            .around
            .as_ref()
            .is_some_and(|around| is_of_scene(&around.job))
        {
            self.picture.around = None;
        }
    }

    /// True if the picture around a region is what is rendered next.
    fn takes_up_around(&self, scene: &Arc<Scene>, settings: &RenderSettings) -> bool {
        let is_of_region = |job: &Job| job.settings.camera.crop.is_some();
        let ends = self.link.started().is_some_and(is_of_region);
        let around = self.picture.around.as_ref();
        let around = around.filter(|around| around.divisor == 1 && self.room.is_debounced);
        let job = around.map(|around| &around.job);
        ends && job.is_some_and(|job| Arc::ptr_eq(&job.scene, scene) && job.settings == *settings)
    }

    /// True if a region has just been ended, and the picture around it is gone back to.
    fn goes_back(&self) -> bool {
        let setup = &self.setup;
        let (Some(open), Some(settings)) = (&setup.open, setup.settings()) else {
            return false;
        };
        setup.is_changed
            && setup.region.is_none()
            && setup.film_size == FilmSize::Window
            && self.takes_up_around(&open.scene, &settings)
    }

    /// True once the picture is whole again after a region.
    fn has_left_region(&self) -> bool {
        let is_of_region = |job: &Job| job.settings.camera.crop.is_some();
        let published = self.link.read(|published| published.generation);
        self.kept.is_none()
            && !self.link.started().is_some_and(is_of_region)
            && self.link.region_of(published).is_none()
    }

    /// The region that is rendered, or that is shown yet.
    #[must_use]
    pub fn region(&self) -> Option<Crop> {
        self.setup.region.or(self.picture.region)
    }

    /// Takes over what is new of the film, unless the picture is kept until more has come.
    pub fn refresh(&mut self, settings: &mut ViewSettings) {
        self.part = settings.part;
        if self.kept.is_some_and(|kept| kept.part != settings.part) {
            self.kept = None;
        }
        if self.catching_up().is_none() {
            self.kept = None;
            self.picture.refresh(&self.link, settings);
        }
        if self.picture.around.is_some() && self.has_left_region() {
            self.picture.around = None;
        }
        if self.is_current()
            && let Some(job) = self.link.started()
        {
            self.made = Some(Made::of(job));
        }
    }

    /// True if the picture is kept since a region of it was rendered.
    #[must_use]
    pub fn is_after_region(&self) -> bool {
        self.kept.is_some_and(|kept| kept.is_after_region)
    }

    /// While the picture of another size is kept: iterations that are in the film, and those that
    /// the picture has.
    #[must_use]
    pub fn catching_up(&self) -> Option<(u32, u32)> {
        let kept = self.kept?;
        let generation = self.link.generation();
        self.link.read(|published| {
            if published.generation != generation || published.divisor != 1 {
                return Some((0, kept.n_iterations));
            }
            let n = published.stats.n_iterations;
            let is_behind = n < kept.n_iterations && !published.stats.is_done;
            is_behind.then_some((n, kept.n_iterations))
        })
    }

    /// Lets the size of a film that is begun anew follow the room for it, physical pixels; that of
    /// one which has hardly been begun, too, when the room has come to rest. Any other film keeps
    /// its size and is shown scaled, and so does one that is compared with another picture.
    /// Yields how long the room must rest yet.
    pub fn follow_room(&mut self, room: egui::Vec2) -> Option<Duration> {
        let fitting = self.setup.size_for(room);
        let is_new = fitting != self.room.fitting;
        self.room.fitting = fitting;
        let is_region_kept =
            self.setup.region.is_some() && self.setup.film_size == FilmSize::Window;
        if !self.can_fit() || is_region_kept || self.goes_back() {
            self.room.changed = None;
            return None;
        }
        let begins_anew = self.setup.is_changed && !self.is_compared();
        if self.setup.size == (0, 0) || begins_anew || !self.room.is_debounced {
            self.fit();
            return None;
        }
        if is_new {
            let is_young = !self.is_current() || self.picture.stats.seconds < YOUNG;
            let is_young = is_young && self.kept.is_none() && !self.is_compared();
            let was_young = self.room.changed.is_some_and(|(_, was_young)| was_young);
            self.room.changed = Some((Instant::now(), is_young || was_young));
        }
        let (since, is_young) = self.room.changed?;
        let rested = since.elapsed();
        if rested < RESIZE_DELAY {
            return Some(RESIZE_DELAY - rested);
        }
        if is_young {
            self.fit();
        }
        self.room.changed = None;
        None
    }

    /// True if there are pictures to compare with, which have the size of the film.
    fn is_compared(&self) -> bool {
        let picture = &self.picture;
        picture.reference.is_some() || picture.held.iter().any(Option::is_some)
    }

    /// The room has changed because texts did, which is no reason to begin even a young film anew.
    pub fn keep_size_in(&mut self, room: egui::Vec2) {
        self.room.fitting = self.setup.size_for(room);
        self.room.changed = None;
    }

    /// True if another size of the film would fit the room for it better.
    #[must_use]
    pub fn can_fit(&self) -> bool {
        self.setup.open.is_some() && self.room.fitting != self.setup.size
    }

    /// Begins a film of the size that fits. The old picture stays until that has caught up.
    pub fn fit(&mut self) {
        if self.can_fit() {
            self.setup.size = self.room.fitting;
            self.setup.region = None;
            self.setup.is_changed = true;
            self.room.changed = None;
        }
    }

    /// Why the picture is biased, if it is: a method that merges is not while nothing is merged.
    #[must_use]
    pub fn bias(&self) -> Option<&'static str> {
        let photons = self.picture.stats.photons.filter(|_| self.is_current());
        let merges = photons.is_none_or(|photons| photons.radius > 0.0);
        self.setup.method().bias.filter(|_| merges)
    }

    /// Where the picture on screen comes from; `None` before there is one.
    #[must_use]
    pub fn origin(&self) -> Option<Origin> {
        let made = self.made.as_ref()?;
        Some(Origin {
            method: made.method.id.to_owned(),
            n_iterations: self.picture.stats.n_iterations,
            seconds: self.picture.stats.seconds,
            scene: SceneName::of(&made.scene),
            camera: made.camera.clone(),
        })
    }

    /// Size at which the film stands on the screen: what was asked for, or, while the picture is of
    /// something older, its own.
    #[must_use]
    pub fn shown_size(&self) -> (usize, usize) {
        if self.is_current()
            && self.setup.size != (0, 0)
            && let Some(job) = self.link.started()
        {
            let whole = job.settings.camera.crop.map(|region| region.of.into());
            return whole.unwrap_or((job.settings.width, job.settings.height));
        }
        if let Some(region) = self.picture.region {
            return region.of.into();
        }
        let (w, h) = self.picture.size;
        (w * self.picture.divisor, h * self.picture.divisor)
    }

    /// Puts a part of the film aside as A (0) or B (1).
    pub fn hold(&mut self, which: usize, part: Part) {
        self.kept = None;
        if self.picture.is_there() {
            let origin = self.origin();
            self.picture.hold(&self.link, which, part, origin);
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
        let generation = self.link.generation();
        let (n_iterations, n_refused, seconds) = self.link.read(|published| {
            let film = &published.film;
            (published.generation == generation).then(|| {
                (
                    film.n_iterations(),
                    film.n_refused(),
                    published.stats.seconds,
                )
            })
        })?;
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
        if self.link.traces_features() != needs.features {
            self.link.trace_features(needs.features);
        }
        if self.link.kept_classes().is_some() && !needs.classes {
            self.link.keep_classes(None);
        }
        if self.link.is_held() != needs.rest {
            self.link.hold(needs.rest);
        }
    }
}
