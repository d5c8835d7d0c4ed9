//! What the window knows about the film: taken over once a frame, under a short lock.

use neumann_core::film::View;
use neumann_core::radiometry::Rgb;
use neumann_core::render::{Published, Stats, Thumbnail};
use neumann_picture::tone::auto_exposure;

use crate::display::{SharedPlanes, Slot, ViewSettings, mean_of};
use crate::render_link::RenderLink;

/// A view of the film that was put aside.
#[derive(Clone, Debug)]
pub struct Held {
    /// What it showed.
    pub view: View,
    /// By what method, and how far.
    pub label: String,
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
    /// Small images of the layers, tail last.
    pub thumbnails: Vec<Thumbnail>,
    thumbnails_version: u64,
    composed: Option<(u64, View)>,
    /// What is held as A and as B.
    pub held: [Option<Held>; 2],
    /// Name of the reference, if one has been loaded.
    pub reference: Option<String>,
    /// Microseconds that the last composition took.
    pub compose_micros: u32,
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
        link.read(|published| self.take(published));
        if viewing.is_auto {
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
        let version = link.read(|published| {
            self.planes
                .lock()
                .put_view(Slot::Live, &published.film, view, mean);
            published.version
        });
        self.composed = Some((version.min(self.version), view));
        self.compose_micros = start.elapsed().as_micros() as u32;
    }

    /// A small image of a view.
    #[must_use]
    pub fn thumbnail(&self, view: View) -> Vec<Rgb> {
        let n_layers = self.thumbnails.len().saturating_sub(1);
        let mut sum: Vec<Rgb> = Vec::new();
        for thumbnail in view
            .layers(n_layers)
            .and_then(|range| self.thumbnails.get(range))
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

    /// Exposure that suits a view.
    #[must_use]
    pub fn auto_exposure(&self, view: View) -> f32 {
        let ev = auto_exposure(&self.thumbnail(view));
        // In sixths of a stop, so that noise does not make it flicker.
        (ev * 6.0).round() / 6.0
    }

    /// Puts the present view aside as A (0) or B (1).
    pub fn hold(&mut self, link: &RenderLink, which: usize, view: View, label: String) {
        let slot = if which == 0 { Slot::HeldA } else { Slot::HeldB };
        let mean = mean_of(&self.thumbnail(view));
        link.read(|published| {
            self.planes
                .lock()
                .put_view(slot, &published.film, view, mean);
        });
        if let Some(held) = self.held.get_mut(which) {
            *held = Some(Held { view, label });
        }
    }

    /// Takes over a reference to hold the picture against.
    pub fn set_reference(&mut self, name: String, size: (usize, usize), pixels: &[Rgb]) {
        self.planes
            .lock()
            .put(Slot::Reference, size.0, size.1, pixels);
        self.reference = Some(name);
    }

    /// Energy share of a view, 0 to 1; `None` before there is one.
    #[must_use]
    pub fn share(&self, view: View) -> Option<f64> {
        let n_layers = self.shares.len().checked_sub(1)?;
        let shares = self.shares.get(view.layers(n_layers)?)?;
        Some(shares.iter().sum())
    }
}
