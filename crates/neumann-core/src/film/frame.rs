//! One iteration: one complete estimate of the image.

use crate::radiometry::Rgb;

/// What the photons of an iteration were like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhotonReport {
    /// Radius within which they count, metres; 0 where nothing is merged.
    pub radius: f32,
    /// Light paths traced.
    pub n_paths: usize,
    /// Vertices stored.
    pub n_vertices: usize,
    /// Memory that they and their index take, bytes.
    pub bytes: usize,
}

/// One iteration, layer by layer.
#[derive(Clone, Debug)]
pub struct Frame {
    width: usize,
    height: usize,
    /// `layers[k][y * width + x]`, row 0 on top; the last one is the tail.
    pub(crate) layers: Vec<Vec<Rgb>>,
    /// Contributions that were not finite or negative, and so left out.
    pub(crate) n_refused: u64,
    /// Rays traced.
    pub(crate) n_rays: u64,
    /// What its photons were like, if it had any.
    pub(crate) photons: Option<PhotonReport>,
}

impl Frame {
    /// A black frame with `n_layers` bounce layers and a tail.
    #[must_use]
    pub fn new(width: usize, height: usize, n_layers: usize) -> Self {
        Self {
            width,
            height,
            layers: vec![vec![Rgb::BLACK; width * height]; n_layers + 1],
            n_refused: 0,
            n_rays: 0,
            photons: None,
        }
    }

    /// Pixels per row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// `layers()[k][y * width + x]`, row 0 on top; the last one is the tail.
    #[must_use]
    pub fn layers(&self) -> &[Vec<Rgb>] {
        &self.layers
    }

    /// Contributions refused because they were not finite or negative.
    #[must_use]
    pub fn n_refused(&self) -> u64 {
        self.n_refused
    }

    /// Rays traced for this frame.
    #[must_use]
    pub fn n_rays(&self) -> u64 {
        self.n_rays
    }

    /// What its photons were like, if it had any.
    #[must_use]
    pub fn photons(&self) -> Option<PhotonReport> {
        self.photons
    }

    /// Makes it black again and forgets its counts.
    pub(crate) fn clear(&mut self) {
        for layer in &mut self.layers {
            layer.fill(Rgb::BLACK);
        }
        self.n_refused = 0;
        self.n_rays = 0;
        self.photons = None;
    }
}
