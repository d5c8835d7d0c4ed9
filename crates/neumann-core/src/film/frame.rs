//! One iteration: one complete estimate of the image.
//!
//! Values are kept tile by tile, so that whoever traces a tile has its memory to itself.

use rayon::prelude::*;

use crate::radiometry::Rgb;
use crate::sampling::TileNumbers;

/// Edge of a square tile, pixels: of those that share their random numbers.
pub(crate) const TILE: usize = TileNumbers::EDGE;
/// Pixels of a tile.
pub(crate) const TILE_PIXELS: usize = TILE * TILE;

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
    n_layers: usize,
    /// The tiles row by row, each with its layers, tail last, and each layer with its pixels row by row; tiles that
    /// reach beyond the image are whole.
    values: Vec<Rgb>,
    /// True while what `values` holds is left over from another iteration.
    is_stale: bool,
    /// Contributions that were not finite or negative, and so left out.
    pub(crate) n_refused: u64,
    /// Rays traced.
    pub(crate) n_rays: u64,
    /// What its photons were like, if it had any.
    pub(crate) photons: Option<PhotonReport>,
}

/// Where a pixel's value of a layer is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slot {
    /// Number of the tile.
    pub(crate) tile: u32,
    /// Index within the tile.
    pub(crate) in_tile: u32,
}

/// The pixels of a tile that lie in the image: x and y of its corner on top left, and those of the pixel
/// beyond its corner on bottom right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TileBounds {
    pub(crate) start: [usize; 2],
    pub(crate) end: [usize; 2],
}

/// How an image is cut into tiles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileGrid {
    width: usize,
    height: usize,
    n_columns: usize,
}

impl TileGrid {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            n_columns: width.div_ceil(TILE),
        }
    }

    /// Tiles from left to right.
    pub(crate) fn n_columns(&self) -> usize {
        self.n_columns
    }

    /// Number of tiles.
    pub(crate) fn n_tiles(&self) -> usize {
        self.n_columns * self.height.div_ceil(TILE)
    }

    /// The pixels of a tile.
    pub(crate) fn bounds(&self, tile: usize) -> TileBounds {
        let start = [tile % self.n_columns, tile / self.n_columns].map(|i| i * TILE);
        TileBounds {
            start,
            end: [
                (start[0] + TILE).min(self.width),
                (start[1] + TILE).min(self.height),
            ],
        }
    }

    /// Where the value of a layer at a pixel is.
    #[inline]
    pub(crate) fn slot(&self, layer: usize, x: usize, y: usize) -> Slot {
        Slot {
            tile: (y / TILE * self.n_columns + x / TILE) as u32,
            in_tile: (layer * TILE_PIXELS + y % TILE * TILE + x % TILE) as u32,
        }
    }
}

impl Frame {
    /// A black frame with `n_layers` bounce layers and a tail.
    #[must_use]
    pub fn new(width: usize, height: usize, n_layers: usize) -> Self {
        let n_tiles = TileGrid::new(width, height).n_tiles();
        Self {
            width,
            height,
            n_layers,
            values: vec![Rgb::BLACK; n_tiles * (n_layers + 1) * TILE_PIXELS],
            is_stale: false,
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

    /// Number of bounce layers, the tail not counted.
    #[must_use]
    pub fn n_layers(&self) -> usize {
        self.n_layers
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

    /// How it is cut into tiles.
    pub(crate) fn grid(&self) -> TileGrid {
        TileGrid::new(self.width, self.height)
    }

    /// Number of values of a tile, all layers together.
    pub(crate) fn values_per_tile(&self) -> usize {
        (self.n_layers + 1) * TILE_PIXELS
    }

    /// Values of one tile, layer by layer.
    pub(crate) fn tile(&self, tile: usize) -> &[Rgb] {
        let n = self.values_per_tile();
        &self.values[tile * n..(tile + 1) * n]
    }

    /// All values, and whether they are left over from another iteration; whoever asks takes care that they are not
    /// afterwards.
    pub(crate) fn values_to_renew(&mut self) -> (&mut [Rgb], bool) {
        (&mut self.values, std::mem::take(&mut self.is_stale))
    }

    /// All values, ready to be added to.
    pub(crate) fn values(&mut self) -> &mut [Rgb] {
        if std::mem::take(&mut self.is_stale) {
            self.values
                .par_chunks_mut(1 << 16)
                .for_each(|chunk| chunk.fill(Rgb::BLACK));
        }
        &mut self.values
    }

    /// Forgets everything, for the next iteration.
    pub(crate) fn forget(&mut self) {
        self.is_stale = true;
        self.n_refused = 0;
        self.n_rays = 0;
        self.photons = None;
    }
}
