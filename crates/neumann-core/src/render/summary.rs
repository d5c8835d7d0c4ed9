//! What is published of a film: how rendering is going, and small pictures of its layers.

use std::sync::Arc;
use std::time::Duration;

use super::{RenderSettings, Renderer};
use crate::film::{ClassFilm, Features, Film, PhotonReport, SampleMap, TechniqueFilm};
use crate::photons::PhotonPicture;
use crate::radiometry::Rgb;

/// Thumbnails, shares and error are renewed this often.
pub(super) const SUMMARY_PERIOD: Duration = Duration::from_millis(250);
/// The longer edge of a thumbnail, pixels.
const THUMBNAIL_EDGE: usize = 128;

/// How rendering is going.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stats {
    /// Iterations in the film.
    pub n_iterations: u32,
    /// Time spent rendering since the job began, seconds; pauses do not count.
    pub seconds: f64,
    /// Camera samples per second over the latest iteration.
    pub samples_per_second: f64,
    /// Rays per second over the latest iteration.
    pub rays_per_second: f64,
    /// [`Film::estimated_error`], renewed a few times a second.
    pub estimated_error: Option<f64>,
    /// Contributions refused because they were not finite or negative.
    pub n_refused: u64,
    /// What the photons of the latest iteration were like, if it had any.
    pub photons: Option<PhotonReport>,
    /// True once the stop rule has been met.
    pub is_done: bool,
}

/// The latest state of the picture.
pub struct Published {
    /// The number [`RenderLoop::start`](super::RenderLoop::start) gave to the job that made it; 0
    /// before the first frame.
    pub generation: u64,
    /// Grows with every change of this structure.
    pub version: u64,
    /// The film; smaller than asked for by `divisor` while the ladder is climbed.
    pub film: Film,
    /// 8, 4, 2 on the ladder, 1 at full resolution.
    pub divisor: usize,
    /// How rendering is going.
    pub stats: Stats,
    /// Small images of the layers, tail last; sums of them are thumbnails of partial sums.
    pub thumbnails: Vec<Thumbnail>,
    /// [`Film::energy_shares`], renewed with the thumbnails.
    pub energy_shares: Vec<f64>,
    /// Estimated relative error of each layer, tail last, renewed with the thumbnails; `None` where
    /// it is not known.
    pub layer_errors: Vec<Option<f64>>,
    /// Grows when the thumbnails change.
    pub thumbnails_version: u64,
    /// The techniques apart, renewed with the thumbnails while
    /// [`record_techniques`](super::RenderLoop::record_techniques) is on.
    pub techniques: Option<Arc<TechniqueFilm>>,
    /// Classes of paths apart, renewed with the thumbnails while
    /// [`keep_classes`](super::RenderLoop::keep_classes) is on.
    pub classes: Option<Arc<ClassFilm>>,
    /// The photons of the latest iteration as the camera sees them, renewed with the thumbnails
    /// while [`draw_photons`](super::RenderLoop::draw_photons) is on; smaller as the film is.
    pub photons: Option<Arc<PhotonPicture>>,
    /// What the camera sees first, while
    /// [`trace_features`](super::RenderLoop::trace_features) is on; smaller as the film is.
    pub features: Option<Arc<Features>>,
    /// Paths from the camera of each pixel, renewed with the thumbnails.
    pub samples: Option<Arc<SampleMap>>,
}

/// A small linear image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Thumbnail {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `pixels[y * width + x]`, row 0 on top.
    pub pixels: Vec<Rgb>,
}

/// So that the longer edge of a technique's image has at most [`THUMBNAIL_EDGE`] pixels: then all
/// of them take 46 MB at 16:9 and 8 layers.
pub(super) fn technique_divisor(settings: &RenderSettings) -> usize {
    settings.width.max(settings.height).div_ceil(THUMBNAIL_EDGE)
}

/// What is drawn from the whole film, a few times a second.
pub(super) struct Summary {
    thumbnails: Vec<Thumbnail>,
    energy_shares: Vec<f64>,
    errors: Errors,
    apart: Apart,
    looks: Looks,
    samples: Option<Arc<SampleMap>>,
}

/// What is kept apart beside the bounces.
#[derive(Clone, Default)]
pub(super) struct Apart {
    techniques: Option<Arc<TechniqueFilm>>,
    classes: Option<Arc<ClassFilm>>,
}

impl Apart {
    /// By a renderer.
    pub(super) fn of(renderer: Option<&Renderer>) -> Self {
        let techniques = renderer.and_then(Renderer::techniques);
        let classes = renderer.and_then(Renderer::classes);
        Self {
            techniques: techniques.map(|techniques| Arc::new(techniques.clone())),
            classes: classes.map(|classes| Arc::new(classes.clone())),
        }
    }
}

/// How uncertain a film is.
#[derive(Clone, Default)]
pub(super) struct Errors {
    pub(super) of_film: Option<f64>,
    pub(super) of_layers: Vec<Option<f64>>,
}

impl Errors {
    /// Of a film, by the renderer that made it.
    pub(super) fn of(renderer: &Renderer, film: &Film) -> Self {
        Self {
            of_film: renderer.estimated_error(film),
            of_layers: renderer.layer_errors(film),
        }
    }
}

/// What is drawn for whoever looks.
#[derive(Clone, Default)]
pub(super) struct Looks {
    pub(super) photons: Option<Arc<PhotonPicture>>,
    pub(super) features: Option<Arc<Features>>,
}

impl Summary {
    /// Of a film.
    pub(super) fn of(
        film: &Film,
        errors: Errors,
        apart: Apart,
        looks: Looks,
        samples: Option<Arc<SampleMap>>,
    ) -> Self {
        Self {
            thumbnails: (0..=film.n_layers())
                .map(|layer| Thumbnail::of(film, layer))
                .collect(),
            energy_shares: film.energy_shares(),
            errors,
            apart,
            looks,
            samples,
        }
    }
}

impl Published {
    /// What is published for whoever looks.
    pub(super) fn looks(&self) -> Looks {
        Looks {
            photons: self.photons.clone(),
            features: self.features.clone(),
        }
    }

    /// Takes over what is drawn for whoever looks.
    pub(super) fn look(&mut self, looks: Looks) {
        self.photons = looks.photons;
        self.features = looks.features;
    }

    /// Takes over what is new of the film.
    pub(super) fn take(&mut self, stats: Stats, summary: Option<Summary>) {
        let estimated_error = self.stats.estimated_error;
        self.stats = Stats {
            estimated_error,
            n_refused: self.film.n_refused(),
            ..stats
        };
        if let Some(summary) = summary {
            self.stats.estimated_error = summary.errors.of_film;
            self.layer_errors = summary.errors.of_layers;
            self.thumbnails = summary.thumbnails;
            self.energy_shares = summary.energy_shares;
            self.techniques = summary.apart.techniques;
            self.classes = summary.apart.classes;
            self.look(summary.looks);
            self.samples = summary.samples;
            self.thumbnails_version += 1;
        }
    }
}

impl Thumbnail {
    /// Averages boxes of pixels of a layer down to at most [`THUMBNAIL_EDGE`] on the longer edge.
    fn of(film: &Film, layer: usize) -> Self {
        let (width, height) = (film.width(), film.height());
        let longer = width.max(height).max(1);
        let edge = longer.min(THUMBNAIL_EDGE);
        let scaled = |n: usize| (n * edge / longer).max(1);
        let (w, h) = (scaled(width), scaled(height));
        let range = |i: usize, n: usize, n_scaled: usize| {
            i * n / n_scaled..((i + 1) * n / n_scaled).max(i * n / n_scaled + 1)
        };
        let mut pixels = Vec::with_capacity(w * h);
        let mut sum = vec![Rgb::BLACK; width];
        for y in 0..h {
            let rows = range(y, height, h);
            sum.fill(Rgb::BLACK);
            for row in rows.clone() {
                film.add_row(layer, row, &mut sum);
            }
            for x in 0..w {
                let columns = range(x, width, w);
                let n = (rows.len() * columns.len()) as f32;
                let sum = sum[columns]
                    .iter()
                    .fold(Rgb::BLACK, |sum, value| sum + *value);
                pixels.push(sum / n);
            }
        }
        Self {
            width: w,
            height: h,
            pixels,
        }
    }
}
