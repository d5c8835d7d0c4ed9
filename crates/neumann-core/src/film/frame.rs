//! One iteration: one complete estimate of the image.
//!
//! Values are kept tile by tile, so that whoever traces a tile has its memory to itself.

use bytemuck::zeroed_vec;
use glam::Vec2;

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
    /// The tiles row by row, each with its layers, tail last, and each layer with its pixels row by
    /// row; tiles that reach beyond the image are whole.
    values: Vec<Rgb>,
    /// What of each tile is worth reading; the rest is black, whatever `values` holds.
    lit: Vec<LitLayers>,
    /// Its number.
    pub(crate) iteration: u32,
    /// Contributions that were not finite or negative, and so left out.
    pub(crate) n_refused: u64,
    /// Rays traced.
    pub(crate) n_rays: u64,
    /// Of these, rays of the paths of each tile's pixels.
    pub(crate) n_rays_of_tiles: Vec<u32>,
    /// Paths that it is the mean of, of all pixels.
    pub(crate) n_samples: u64,
    /// Paths from the camera that were traced for each pixel of a tile.
    pub(crate) n_samples_of_tiles: Vec<u8>,
    /// What its photons were like, if it had any.
    pub(crate) photons: Option<PhotonReport>,
}

/// The layers of a tile that anything was added to. Many tiles have few, and the memory of the
/// others is never touched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LitLayers(u64);

impl LitLayers {
    /// Every layer.
    pub(crate) const ALL: Self = Self(u64::MAX);

    #[inline]
    pub(crate) fn contains(self, layer: usize) -> bool {
        self.0 & Self::bit(layer) != 0
    }

    /// True if there is none.
    #[inline]
    pub(crate) fn is_black(self) -> bool {
        self.0 == 0
    }

    #[inline]
    pub(crate) fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Layers from the 64th on are told apart no longer.
    #[inline]
    fn bit(layer: usize) -> u64 {
        1 << layer.min(63)
    }
}

/// A layer of a tile to which nothing was added.
pub(super) static BLACK_LAYER: [Rgb; TILE_PIXELS] = [Rgb::BLACK; TILE_PIXELS];

/// Adds to a value of a tile; a layer to which nothing was added yet is black.
#[inline]
pub(crate) fn add_to_tile(tile: &mut [Rgb], lit: &mut LitLayers, in_tile: usize, value: Rgb) {
    let layer = in_tile / TILE_PIXELS;
    if !lit.contains(layer) {
        light_up(tile, lit, layer);
    }
    tile[in_tile] += value;
}

/// Begins a layer, black.
#[cold]
fn light_up(tile: &mut [Rgb], lit: &mut LitLayers, layer: usize) {
    lit.0 |= LitLayers::bit(layer);
    for (other, values) in tile.chunks_exact_mut(TILE_PIXELS).enumerate() {
        if LitLayers::bit(other) == LitLayers::bit(layer) {
            values.fill(Rgb::BLACK);
        }
    }
}

/// Where a pixel's value of a layer is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slot {
    /// Number of the tile.
    pub(crate) tile: u32,
    /// Index within the tile.
    pub(crate) in_tile: u32,
}

/// The pixels of a tile that lie in the image: x and y of its corner on top left, and those of the
/// pixel beyond its corner on bottom right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TileBounds {
    pub(crate) start: [usize; 2],
    pub(crate) end: [usize; 2],
}

impl TileBounds {
    /// Their number.
    pub(crate) fn n_pixels(self) -> usize {
        (self.end[0] - self.start[0]) * (self.end[1] - self.start[1])
    }
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

    /// The tiles that a rectangle of the raster reaches into.
    pub(crate) fn tiles_within(&self, low: Vec2, high: Vec2) -> impl Iterator<Item = usize> {
        let n_columns = self.n_columns;
        let range = |low: f32, high: f32, n_pixels: usize| {
            let tile = |position: f32| position.max(0.0) as usize / TILE;
            let n_tiles = n_pixels.div_ceil(TILE);
            if high < 0.0 {
                0..0
            } else {
                tile(low)..n_tiles.min(tile(high) + 1)
            }
        };
        let columns = range(low.x, high.x, self.width);
        range(low.y, high.y, self.height)
            .flat_map(move |row| columns.clone().map(move |column| row * n_columns + column))
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
            values: zeroed_vec(n_tiles * (n_layers + 1) * TILE_PIXELS),
            lit: vec![LitLayers::default(); n_tiles],
            iteration: 0,
            n_refused: 0,
            n_rays: 0,
            n_rays_of_tiles: vec![0; n_tiles],
            n_samples: 0,
            n_samples_of_tiles: vec![0; n_tiles],
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

    /// Paths that it is the mean of, of all pixels: as many as there are pixels, unless the method
    /// says otherwise.
    #[must_use]
    pub fn n_samples(&self) -> u64 {
        self.n_samples
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

    /// The layers of a tile that are not all black.
    pub(crate) fn lit(&self, tile: usize) -> LitLayers {
        self.lit[tile]
    }

    /// Values of one tile, layer by layer; those of a layer that is not lit mean nothing.
    pub(super) fn tile(&self, tile: usize) -> &[Rgb] {
        let n = self.values_per_tile();
        &self.values[tile * n..(tile + 1) * n]
    }

    /// The same, black where nothing is lit.
    pub(crate) fn layers_of_tile(&self, tile: usize) -> impl Iterator<Item = &[Rgb]> {
        let layers = self.tile(tile).chunks_exact(TILE_PIXELS);
        layers.enumerate().map(move |(layer, values)| {
            if self.lit[tile].contains(layer) {
                values
            } else {
                &BLACK_LAYER
            }
        })
    }

    /// All values, tile by tile, and what is lit of each, for [`add_to_tile`].
    pub(crate) fn tiles(&mut self) -> (&mut [Rgb], &mut [LitLayers]) {
        (&mut self.values, &mut self.lit)
    }

    /// All values, black, ready to be set to anything.
    #[cfg(test)]
    pub(crate) fn values(&mut self) -> &mut [Rgb] {
        self.values.fill(Rgb::BLACK);
        self.lit.fill(LitLayers::ALL);
        &mut self.values
    }

    /// Forgets everything, for the next iteration.
    pub(crate) fn clear(&mut self) {
        self.lit.fill(LitLayers::default());
        self.n_refused = 0;
        self.n_rays = 0;
        self.n_samples = (self.width * self.height) as u64;
        self.n_samples_of_tiles.fill(0);
        self.photons = None;
    }
}

#[cfg(test)]
mod tests {
    use super::{Frame, TILE_PIXELS, add_to_tile};
    use crate::radiometry::Rgb;

    #[test]
    fn what_was_forgotten_is_black_in_layers_of_any_number() {
        let mut frame = Frame::new(40, 20, 70);
        let (tile, pixel) = (2, 17);
        let n = frame.values_per_tile();
        let add = |frame: &mut Frame, layer: usize| {
            let (values, lit) = frame.tiles();
            let values = &mut values[tile * n..(tile + 1) * n];
            let in_tile = layer * TILE_PIXELS + pixel;
            add_to_tile(values, &mut lit[tile], in_tile, Rgb::WHITE);
        };
        for layers in [&[0, 5, 64, 66][..], &[1, 5, 70], &[66], &[]] {
            frame.clear();
            for &layer in layers {
                add(&mut frame, layer);
                add(&mut frame, layer);
            }
            for other in 0..frame.grid().n_tiles() {
                for (layer, values) in frame.layers_of_tile(other).enumerate() {
                    let is_there = other == tile && layers.contains(&layer);
                    for (i, value) in values.iter().enumerate() {
                        let expected = f32::from(u8::from(is_there && i == pixel)) * 2.0;
                        assert_eq!(*value, Rgb::splat(expected), "layer {layer}");
                    }
                }
            }
        }
    }
}
