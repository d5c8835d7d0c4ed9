//! What a race is judged by: a picture that the window has, or one that is rendered meanwhile, in
//! turns with the methods and kept on disk for the next race.

use std::path::PathBuf;
use std::sync::Arc;

use neumann_core::film::View as Part;
use neumann_core::pass::Cancelled;
use neumann_core::render::{CancelToken, RenderSettings, WorkerPool};
use neumann_picture::Image;
use neumann_picture::exr_file::{IterationRanges, Metadata, camera_text};
use neumann_picture::race::{Entrant, REFERENCE_METHOD, Racer};

use super::cache;
use super::held::{Entries, Given, image_of};
use crate::compared::SceneName;
use crate::session::Session;

/// The reference has so many times the processor time that each method has had,
const LEAD: f64 = 2.0;
/// and this much before any of them begins, seconds.
const START: f64 = 0.3;
/// It is kept on disk whenever it has so many times the iterations that are there,
const GROWTH: f64 = 1.5;
/// and at least so many seconds.
const WORTH: f64 = 1.0;

/// What a race is judged by.
pub(super) enum Reference {
    Given { image: Arc<Image>, words: String },
    Rendered(Box<Rendered>),
}

/// A reference that is rendered meanwhile.
pub(super) struct Rendered {
    racer: Racer,
    image: Option<Arc<Image>>,
    metadata: Metadata,
    /// Where it is kept.
    file: Option<PathBuf>,
    n_from_cache: u32,
    n_kept: u32,
}

impl Reference {
    pub(super) fn new(entries: &Entries, pool: &WorkerPool, cache: Option<PathBuf>) -> Self {
        if let Some(Given { pixels, words }) = &entries.given {
            let common = &entries.common;
            return Self::Given {
                image: Arc::new(Image {
                    width: common.width,
                    height: common.height,
                    pixels: pixels.to_vec(),
                    ..Image::default()
                }),
                words: words.clone(),
            };
        }
        Self::Rendered(Box::new(Rendered::new(entries, pool, cache)))
    }

    /// True if the reference is to be rendered before a method that has had so many seconds.
    pub(super) fn is_next(&self, seconds: f64) -> bool {
        match self {
            Self::Given { .. } => false,
            Self::Rendered(rendered) => {
                let racer = &rendered.racer;
                racer.n_iterations() == 0 || racer.seconds() < LEAD * seconds.max(START / LEAD)
            }
        }
    }

    /// Renders another iteration of it.
    pub(super) fn iterate(&mut self, cancel: &CancelToken) -> Result<(), Cancelled> {
        match self {
            Self::Given { .. } => Ok(()),
            Self::Rendered(rendered) => rendered.iterate(cancel),
        }
    }

    /// Its picture as of now.
    pub(super) fn image(&mut self) -> Arc<Image> {
        match self {
            Self::Given { image, .. } => Arc::clone(image),
            Self::Rendered(rendered) => {
                let film = rendered.racer.film();
                let image = &mut rendered.image;
                Arc::clone(image.get_or_insert_with(|| Arc::new(image_of(film))))
            }
        }
    }

    /// Iterations that it is the mean of; one where that is not known.
    pub(super) fn n_iterations(&self) -> u32 {
        match self {
            Self::Given { .. } => 1,
            Self::Rendered(rendered) => rendered.racer.n_iterations(),
        }
    }

    /// Which it is, and how good.
    pub(super) fn words(&self) -> String {
        match self {
            Self::Given { words, .. } => words.clone(),
            Self::Rendered(rendered) => rendered.words(),
        }
    }
}

impl Rendered {
    fn new(entries: &Entries, pool: &WorkerPool, cache: Option<PathBuf>) -> Self {
        let mut settings = entries.common.clone();
        if let Ok(entrant) = Entrant::parse(REFERENCE_METHOD) {
            settings = entrant.settings(&settings);
        }
        settings.seed = settings.seed.wrapping_add(1);
        let metadata = Metadata::of(&entries.scene, &settings);
        let file = cache.map(|folder| folder.join(cache::name(&metadata, &settings)));
        let kept = file
            .as_ref()
            .and_then(|file| cache::read(file, &metadata, &settings));
        let name = settings.method.id;
        let scene = &entries.scene;
        let racer = match kept {
            Some(kept) => Racer::going_on(name, scene, settings, pool, kept),
            None => Racer::new(name, scene, settings, pool),
        };
        let n_from_cache = racer.n_iterations();
        Self {
            racer,
            image: None,
            metadata,
            file,
            n_from_cache,
            n_kept: n_from_cache,
        }
    }

    fn iterate(&mut self, cancel: &CancelToken) -> Result<(), Cancelled> {
        self.racer.iterate(cancel)?;
        self.image = None;
        let n = self.racer.n_iterations();
        let has_grown = f64::from(n) >= GROWTH * f64::from(self.n_kept);
        if has_grown && self.racer.seconds() >= WORTH {
            self.keep();
        }
        Ok(())
    }

    /// Keeps it for the next race.
    fn keep(&mut self) {
        let film = self.racer.film();
        self.n_kept = film.n_iterations();
        if let Some(file) = &self.file {
            let metadata = Metadata {
                iterations: IterationRanges::of(0..film.n_iterations()),
                seconds: self.racer.seconds(),
                n_refused: film.n_refused(),
                ..self.metadata.clone()
            };
            cache::write(file, film, &metadata);
        }
    }

    fn words(&self) -> String {
        let (n, seconds) = (self.racer.n_iterations(), self.racer.seconds());
        let iterations = if n == 1 { "iteration" } else { "iterations" };
        let kept = match self.n_from_cache {
            0 => String::new(),
            n => format!(", {n} of them from the cache"),
        };
        let name = &self.racer.name;
        format!("{name}, {n} {iterations}, {seconds:.0} s{kept}")
    }
}

/// The window's own reference, if it is a picture of what is raced: of the same scene, seen by the
/// same camera in the same size.
pub(super) fn given(session: &Session, settings: &RenderSettings) -> Option<Given> {
    let reference = session.picture.reference.as_ref()?;
    let job = session.link.started()?;
    let fits = reference.size == (settings.width, settings.height)
        && reference.origin.as_ref().is_none_or(|origin| {
            origin.scene == SceneName::of(&job.scene)
                && origin.camera == camera_text(&settings.camera)
        });
    if !fits {
        return None;
    }
    let pixels = reference.pixels(Part::Total, job.settings.n_layers).ok()?;
    let words = match &reference.origin {
        Some(origin) => format!("{}, {}", reference.name, origin.words()),
        None => reference.name.clone(),
    };
    Some(Given { pixels, words })
}
