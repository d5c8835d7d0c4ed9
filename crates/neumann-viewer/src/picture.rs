//! What the window knows about the film: taken over once a frame, under a short lock.

use std::sync::Arc;

use neumann_core::film::{Film, View};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{Job, Published, Stats, Thumbnail};
use neumann_core::scene::description::{CameraDescription, Crop};
use neumann_picture::tone::auto_exposure;

use crate::compared::{Origin, Reference};
use crate::display::{SharedPlanes, Slot, ViewSettings, mean_of};
use crate::region::{self, Around, Pieced};
use crate::render_link::RenderLink;

/// A view of the film that was put aside.
#[derive(Clone, Debug)]
pub struct Held {
    /// What it showed.
    pub view: View,
    /// Where it comes from.
    pub origin: Option<Origin>,
    /// Pixels per row, and rows.
    pub size: (usize, usize),
    /// Terms before the tail.
    pub n_layers: usize,
    /// Row 0 on top.
    pub pixels: Arc<Vec<Rgb>>,
}

/// The part of the reference that is in its plane.
#[derive(Clone, Debug)]
struct ReferencePart {
    part: View,
    n_layers: usize,
    pixels: Arc<Vec<Rgb>>,
}

/// The film as of this frame, and the pictures made from it.
#[derive(Default)]
pub struct Picture {
    /// The pictures that draw calls show.
    pub planes: SharedPlanes,
    /// [`Published::version`]; 0 before the first frame.
    pub version: u64,
    /// [`Published::generation`].
    pub generation: u64,
    /// Size of the film, smaller than asked for by `divisor`.
    pub size: (usize, usize),
    /// 8, 4, 2 on the ladder, 1 at full resolution.
    pub divisor: usize,
    /// Bounce layers, the tail not counted.
    pub n_layers: usize,
    /// How rendering is going.
    pub stats: Stats,
    /// Share of each layer in the energy, tail last.
    pub shares: Vec<f64>,
    /// Estimated relative error of each layer, tail last; `None` where it is not known.
    pub layer_errors: Vec<Option<f64>>,
    /// Small images of the layers, tail last.
    pub thumbnails: Vec<Thumbnail>,
    thumbnails_version: u64,
    composed: Option<(u64, View)>,
    /// What is held as A and as B.
    pub held: [Option<Held>; 2],
    /// What the picture is held against, if there is anything.
    pub reference: Option<Reference>,
    reference_part: Option<ReferencePart>,
    /// How often a picture was held, or a reference taken over.
    pub n_taken: u64,
    /// The whole picture as it was, while a region of it is rendered.
    pub around: Option<Around>,
    /// The region that the film is of, if it is not the whole picture.
    pub region: Option<Crop>,
    /// Microseconds that the last composition took.
    pub compose_micros: u32,
}

/// A small image of a view, from those of the layers.
pub(crate) fn sum_of(thumbnails: &[Thumbnail], view: View) -> Vec<Rgb> {
    let n_layers = thumbnails.len().saturating_sub(1);
    let mut sum: Vec<Rgb> = Vec::new();
    for thumbnail in view
        .layers(n_layers)
        .and_then(|range| thumbnails.get(range))
        .into_iter()
        .flatten()
    {
        sum.resize(thumbnail.pixels.len(), Rgb::BLACK);
        for (s, p) in sum.iter_mut().zip(&thumbnail.pixels) {
            *s += *p;
        }
    }
    sum
}

impl Picture {
    /// True once there is something to show.
    #[must_use]
    pub fn is_there(&self) -> bool {
        self.version > 0
    }

    /// Takes over what is new; true if anything was.
    pub fn refresh(&mut self, link: &RenderLink, viewing: &mut ViewSettings) -> bool {
        if link.version() == self.version {
            return false;
        }
        link.read(|published| {
            self.take(published);
            let region = link.region_of(published.generation);
            self.region = region.map(|(_, crop)| *crop);
        });
        if viewing.is_auto && self.region.is_none() {
            viewing.exposure_ev = self.auto_exposure(viewing.part);
        }
        true
    }

    fn take(&mut self, published: &Published) {
        self.version = published.version;
        self.generation = published.generation;
        self.divisor = published.divisor.max(1);
        self.size = (published.film.width(), published.film.height());
        self.n_layers = published.film.n_layers();
        self.stats = published.stats;
        let are_new = self.thumbnails_version != published.thumbnails_version;
        if are_new && !published.thumbnails.is_empty() {
            self.thumbnails_version = published.thumbnails_version;
            self.thumbnails.clone_from(&published.thumbnails);
            self.shares.clone_from(&published.energy_shares);
            self.layer_errors.clone_from(&published.layer_errors);
            self.planes.lock().put_thumbnails(&self.thumbnails);
        }
    }

    /// Makes the picture of a view, unless it is there already.
    pub fn compose(&mut self, link: &RenderLink, view: View) {
        if !self.is_there() || self.composed == Some((self.version, view)) {
            return;
        }
        let start = std::time::Instant::now();
        let mean = mean_of(&self.thumbnail(view));
        if let Some(around) = &mut self.around {
            around.compose(view);
        }
        let (around, planes) = (self.around.as_ref(), &self.planes);
        let version = link.read(|published| {
            let film = &published.film;
            if let Some((camera, region)) = link.region_of(published.generation) {
                let pieced = region::piece(around, film, camera, region, view);
                let mean = pieced.mean.unwrap_or(mean);
                let mut planes = planes.lock();
                planes.put_with(Slot::Live, pieced.size, &pieced.pixels, mean);
            } else {
                planes.lock().put_view(Slot::Live, film, view, mean);
            }
            published.version
        });
        self.composed = Some((version.min(self.version), view));
        self.compose_micros = start.elapsed().as_micros() as u32;
    }

    /// A small image of a view.
    #[must_use]
    pub fn thumbnail(&self, view: View) -> Vec<Rgb> {
        sum_of(&self.thumbnails, view)
    }

    /// Reads the film of the picture that is shown, with the divisor of the ladder, and camera and
    /// region if it is of one. `None` while that picture stays, and its film is gone.
    pub fn read_film<R>(
        &self,
        link: &RenderLink,
        reader: impl FnOnce(&Film, usize, Option<(&CameraDescription, &Crop)>) -> R,
    ) -> Option<R> {
        let is_shown = |around: &&Around| around.generation == self.generation;
        if let Some(around) = self.around.as_ref().filter(is_shown) {
            return Some(reader(&around.film, around.divisor, None));
        }
        link.read(|published| {
            let region = link.region_of(published.generation);
            let is_shown = published.generation == self.generation;
            is_shown.then(|| reader(&published.film, published.divisor.max(1), region))
        })
    }

    /// A part of the film as it is shown; while a region is rendered, with the whole picture
    /// around it.
    #[must_use]
    pub fn pixels(&self, link: &RenderLink, view: View) -> Pieced {
        let piece = |film: &Film, region: Option<(&CameraDescription, &Crop)>| {
            if let Some((camera, region)) = region {
                return region::piece(self.around.as_ref(), film, camera, region, view);
            }
            let mut pixels = vec![Rgb::BLACK; film.n_pixels()];
            film.compose(view, &mut pixels);
            Pieced {
                size: (film.width(), film.height()),
                pixels,
                mean: None,
            }
        };
        let shown = self.read_film(link, |film, _, region| piece(film, region));
        shown.unwrap_or_else(|| {
            link.read(|published| piece(&published.film, link.region_of(published.generation)))
        })
    }

    /// Keeps the whole picture, which `job` renders, while a region of it is rendered.
    pub fn keep_around(&mut self, link: &RenderLink, job: Job) {
        self.around = Some(link.read(|published| Around {
            job,
            film: published.film.clone(),
            generation: published.generation,
            divisor: published.divisor.max(1),
            stats: published.stats,
            shares: self.shares.clone(),
            layer_errors: self.layer_errors.clone(),
            thumbnails: self.thumbnails.clone(),
            composed: None,
        }));
    }

    /// Shows a part of the whole picture again as it was before the region. Yields how many
    /// iterations it has.
    pub fn put_back(&mut self, view: View) -> Option<u32> {
        let around = self.around.as_ref()?;
        let film = &around.film;
        self.generation = around.generation;
        self.divisor = around.divisor;
        self.size = (film.width(), film.height());
        self.n_layers = film.n_layers();
        self.stats = around.stats;
        self.shares.clone_from(&around.shares);
        self.layer_errors.clone_from(&around.layer_errors);
        self.thumbnails.clone_from(&around.thumbnails);
        self.thumbnails_version = 0;
        self.region = None;
        let mean = mean_of(&self.thumbnail(view));
        let mut planes = self.planes.lock();
        planes.put_thumbnails(&self.thumbnails);
        planes.put_view(Slot::Live, film, view, mean);
        self.composed = Some((self.version, view));
        Some(around.stats.n_iterations)
    }

    /// Exposure that suits a view.
    #[must_use]
    pub fn auto_exposure(&self, view: View) -> f32 {
        let ev = auto_exposure(&self.thumbnail(view));
        // In sixths of a stop, so that noise does not make it flicker.
        (ev * 6.0).round() / 6.0
    }

    /// Puts the present view aside as A (0) or B (1).
    pub fn hold(&mut self, link: &RenderLink, which: usize, view: View, origin: Option<Origin>) {
        let slot = if which == 0 { Slot::HeldA } else { Slot::HeldB };
        let Some(held) = self.held.get_mut(which) else {
            return;
        };
        let taken = link.read(|published| {
            let film = &published.film;
            let mut pixels = vec![Rgb::BLACK; film.width() * film.height()];
            film.compose(view, &mut pixels);
            Held {
                view,
                origin,
                size: (film.width(), film.height()),
                n_layers: film.n_layers(),
                pixels: Arc::new(pixels),
            }
        });
        let (width, height) = taken.size;
        self.planes.lock().put(slot, width, height, &taken.pixels);
        *held = Some(taken);
        self.n_taken += 1;
    }

    /// Takes over a reference to hold the picture against.
    pub fn set_reference(&mut self, reference: Reference) {
        self.reference = Some(reference);
        self.reference_part = None;
        self.n_taken += 1;
    }

    /// Makes the reference's picture of a part, unless it is there already or the reference has no
    /// such part.
    pub fn compose_reference(&mut self, part: View) {
        let n_layers = self.n_layers;
        let is_there = |there: &ReferencePart| there.part == part && there.n_layers == n_layers;
        if self.reference_part.as_ref().is_some_and(is_there) {
            return;
        }
        let Some(reference) = &self.reference else {
            return;
        };
        if let Ok(pixels) = reference.pixels(part, n_layers) {
            let (width, height) = reference.size;
            let mut planes = self.planes.lock();
            planes.put(Slot::Reference, width, height, &pixels);
            self.reference_part = Some(ReferencePart {
                part,
                n_layers,
                pixels,
            });
        }
    }

    /// The reference's pixels of a part, if that is composed.
    #[must_use]
    pub fn reference_pixels(&self, part: View) -> Option<Arc<Vec<Rgb>>> {
        let there = self.reference_part.as_ref()?;
        (there.part == part).then(|| Arc::clone(&there.pixels))
    }

    /// Energy share of a view, 0 to 1; `None` before there is one.
    #[must_use]
    pub fn share(&self, view: View) -> Option<f64> {
        let n_layers = self.shares.len().checked_sub(1)?;
        let shares = self.shares.get(view.layers(n_layers)?)?;
        Some(shares.iter().sum())
    }

    /// Estimated relative error of a term, of the tail or of L; `None` where it is not known.
    #[must_use]
    pub fn error(&self, view: View) -> Option<f64> {
        match view {
            View::Total => self.stats.estimated_error,
            View::Term(k) if k < self.n_layers => *self.layer_errors.get(k)?,
            View::Tail => *self.layer_errors.get(self.n_layers)?,
            View::Term(_) | View::Upto(_) => None,
        }
    }
}
