//! Where paths leave their contributions.
//!
//! What belongs to a path's own pixel goes to its tile at once. The rest, splats, wait until all
//! tasks are done, and are then added by bands of tiles, side by side, in the order of the paths: a
//! sum depends on no thread.

use std::ops::{Deref, DerefMut};

use glam::Vec2;
use rayon::prelude::*;

use super::observer::{Observer, Seen};
use crate::film::techniques::{Record, RecordShape};
use crate::film::{Contribution, Frame, LitLayers, Slot, TILE, TILE_PIXELS, TileGrid, add_to_tile};
use crate::radiometry::Rgb;

/// Bands that splats are sorted into, at most.
const MAX_BANDS: usize = 64;

/// Where a path leaves its contributions: to its own pixel, as a [`PixelSink`] takes them, and to
/// any other.
pub struct Sink<'a> {
    own: PixelSink<'a>,
    splats: Vec<Splat>,
}

/// Where a path leaves its contributions to its own pixel.
pub struct PixelSink<'a> {
    /// `tile[layer * TILE_PIXELS + pixel_in_tile]`; empty where paths belong to no pixel.
    tile: &'a mut [Rgb],
    lit: &'a mut LitLayers,
    shape: SinkShape,
    /// What each path counts: one over their number.
    share: f32,
    n_refused: u64,
    /// The pixel of the film that the path belongs to.
    pixel: PixelPlace,
    records: Vec<Record>,
    /// Who writes down what arrives, if anybody does.
    observer: Option<Observer>,
}

/// Takes the contributions of a path.
pub trait Gather {
    /// Takes one.
    fn gather(&mut self, contribution: Contribution);
}

impl Gather for PixelSink<'_> {
    #[inline(always)]
    fn gather(&mut self, contribution: Contribution) {
        self.add(contribution);
    }
}

/// Where the contributions of a path to its own pixel go.
#[derive(Clone, Copy, Debug, Default)]
pub struct PixelPlace {
    x: u32,
    y: u32,
    /// Its number in the tile.
    in_tile: u32,
}

/// What the sinks of an iteration have in common.
#[derive(Clone, Copy)]
pub(super) struct SinkShape {
    width: usize,
    height: usize,
    n_layers: usize,
    grid: TileGrid,
    recording: Option<RecordShape>,
    is_alone: bool,
}

/// A contribution to a pixel that is not the path's own.
#[derive(Clone, Copy)]
struct Splat {
    slot: Slot,
    value: Rgb,
}

/// The splats of a task, in the order of its paths within each band of tiles.
#[derive(Default)]
struct SortedSplats {
    splats: Vec<Splat>,
    /// `ends[band]`: index after the band's last splat; empty without splats.
    ends: Vec<u32>,
}

/// What a task hands back.
#[derive(Default)]
pub(super) struct Yield {
    splats: SortedSplats,
    pub(super) records: Vec<Record>,
    pub(super) n_refused: u64,
    pub(super) n_rays: u64,
    /// What an observer has seen.
    pub(super) seen: Option<Seen>,
}

impl PixelPlace {
    #[inline]
    pub(super) fn new(x: usize, y: usize) -> Self {
        Self {
            x: x as u32,
            y: y as u32,
            in_tile: (y % TILE * TILE + x % TILE) as u32,
        }
    }

    #[inline]
    pub(super) fn x(self) -> usize {
        self.x as usize
    }

    #[inline]
    pub(super) fn y(self) -> usize {
        self.y as usize
    }

    /// Its number in the tile.
    #[inline]
    #[must_use]
    pub fn in_tile(self) -> usize {
        self.in_tile as usize
    }
}

impl SinkShape {
    pub(super) fn new(frame: &Frame, recording: Option<RecordShape>, is_alone: bool) -> Self {
        Self {
            is_alone,
            width: frame.width(),
            height: frame.height(),
            n_layers: frame.n_layers(),
            grid: frame.grid(),
            recording,
        }
    }
}

impl<'a> PixelSink<'a> {
    pub(super) fn new(tile: &'a mut [Rgb], lit: &'a mut LitLayers, shape: SinkShape) -> Self {
        Self {
            tile,
            lit,
            shape,
            share: 1.0,
            n_refused: 0,
            pixel: PixelPlace::default(),
            records: Vec::new(),
            observer: None,
        }
    }

    /// Lets somebody write down what arrives.
    pub(super) fn observed(mut self, observer: Option<Observer>) -> Self {
        self.observer = observer;
        self
    }

    /// True if somebody writes down what arrives.
    #[inline]
    pub(crate) fn is_observed(&self) -> bool {
        self.observer.is_some()
    }

    /// Tells the light path that camera vertices are connected to from now on.
    #[inline]
    pub(crate) fn joins(&mut self, light_path: u32) {
        if let Some(observer) = &mut self.observer {
            observer.joins(light_path);
        }
    }

    /// Tells the light path that a camera vertex is merged with next.
    #[inline]
    pub(crate) fn merges(&mut self, light_path: u32) {
        if let Some(observer) = &mut self.observer {
            observer.merges(light_path);
        }
    }

    /// From now on each pixel is the mean of so many paths.
    pub(super) fn share_among(&mut self, n_paths: u8) {
        self.share = 1.0 / f32::from(n_paths);
    }

    /// True if paths are to walk one by one, not side by side. That changes no path.
    #[inline]
    #[must_use]
    pub fn is_alone(&self) -> bool {
        self.shape.is_alone
    }

    /// Goes on to the path of a pixel.
    #[inline]
    pub fn start_pixel(&mut self, place: PixelPlace) {
        self.pixel = place;
    }

    /// The pixel whose path it is.
    #[inline]
    #[must_use]
    pub fn pixel(&self) -> PixelPlace {
        self.pixel
    }

    /// Keeps a contribution apart by its technique, if that is asked for.
    #[inline]
    fn record(&mut self, pixel: (u32, u32), contribution: &Contribution) {
        if let Some(shape) = self.shape.recording {
            let contribution = Contribution {
                value: contribution.value * self.share,
                ..*contribution
            };
            self.records.push(shape.record(pixel, &contribution));
        }
    }

    /// Adds to the path's own pixel.
    #[inline]
    pub fn add(&mut self, contribution: Contribution) {
        let value = contribution.value * (contribution.mis_weight * self.share);
        if !value.is_radiance() {
            self.n_refused += 1;
            return;
        }
        self.record((self.pixel.x, self.pixel.y), &contribution);
        if let Some(observer) = &mut self.observer {
            observer.add([self.pixel.x, self.pixel.y], contribution, self.share);
        }
        let layer = (contribution.bounce as usize).min(self.shape.n_layers);
        if !value.is_black() {
            let in_tile = layer * TILE_PIXELS + self.pixel.in_tile as usize;
            add_to_tile(self.tile, self.lit, in_tile, value);
        }
    }

    /// Goes on to the path of a pixel, and adds to it.
    #[inline]
    pub fn add_at(&mut self, place: PixelPlace, contribution: Contribution) {
        self.start_pixel(place);
        self.add(contribution);
    }
}

impl<'a> Deref for Sink<'a> {
    type Target = PixelSink<'a>;

    #[inline]
    fn deref(&self) -> &PixelSink<'a> {
        &self.own
    }
}

impl<'a> DerefMut for Sink<'a> {
    #[inline]
    fn deref_mut(&mut self) -> &mut PixelSink<'a> {
        &mut self.own
    }
}

impl<'a> Sink<'a> {
    pub(super) fn new(own: PixelSink<'a>) -> Self {
        Self {
            own,
            splats: Vec::new(),
        }
    }

    pub(super) fn into_yield(self, n_rays: u64) -> Yield {
        let own = self.own;
        Yield {
            splats: SortedSplats::new(&self.splats, own.shape.grid),
            records: own.records,
            n_refused: own.n_refused,
            n_rays,
            seen: own.observer.map(Observer::into_seen),
        }
    }

    /// Adds to the pixel that `raster` falls in, if any; raster (0, 0) is the top left corner of
    /// pixel (0, 0).
    #[inline]
    pub fn splat(&mut self, raster: Vec2, contribution: Contribution) {
        let value = contribution.value * (contribution.mis_weight * self.share);
        if !value.is_radiance() {
            self.n_refused += 1;
            return;
        }
        let shape = self.shape;
        let is_inside = raster.x >= 0.0
            && raster.y >= 0.0
            && raster.x < shape.width as f32
            && raster.y < shape.height as f32;
        if !is_inside {
            return;
        }
        let (x, y) = (raster.x as u32, raster.y as u32);
        let layer = (contribution.bounce as usize).min(shape.n_layers);
        let slot = shape.grid.slot(layer, x as usize, y as usize);
        self.record((x, y), &contribution);
        if let Some(observer) = &mut self.own.observer {
            observer.splat([x, y], contribution, self.own.share);
        }
        self.splats.push(Splat { slot, value });
    }
}

/// So many times may the number of a tile be halved to be that of its band.
fn band_shift(grid: TileGrid) -> u32 {
    let n_tiles_per_band = grid.n_tiles().div_ceil(MAX_BANDS).next_power_of_two();
    n_tiles_per_band.trailing_zeros()
}

impl SortedSplats {
    /// Sorts by counting.
    fn new(splats: &[Splat], grid: TileGrid) -> Self {
        if splats.is_empty() {
            return Self::default();
        }
        let shift = band_shift(grid);
        let band = |splat: &Splat| (splat.slot.tile >> shift) as usize;
        // First how many each band has, then where each band goes on; at the end, where it ends.
        let mut ends = vec![0u32; MAX_BANDS];
        for splat in splats {
            ends[band(splat)] += 1;
        }
        let mut start = 0;
        for end in &mut ends {
            start += std::mem::replace(end, start);
        }
        let mut sorted = vec![splats[0]; splats.len()];
        for splat in splats {
            let next = &mut ends[band(splat)];
            sorted[*next as usize] = *splat;
            *next += 1;
        }
        Self {
            splats: sorted,
            ends,
        }
    }

    fn of_band(&self, band: usize) -> &[Splat] {
        if self.splats.is_empty() {
            return &[];
        }
        let start = if band == 0 { 0 } else { self.ends[band - 1] };
        &self.splats[start as usize..self.ends[band] as usize]
    }
}

impl Yield {
    /// True if all was added to pixels of its own paths.
    pub(super) fn has_no_splats(&self) -> bool {
        self.splats.splats.is_empty()
    }
}

/// Adds the splats of tasks to a frame.
pub(super) fn add_splats(frame: &mut Frame, yields: &[Yield]) {
    if yields.iter().all(Yield::has_no_splats) {
        return;
    }
    let (shift, per_tile) = (band_shift(frame.grid()), frame.values_per_tile());
    let add = |(band, (values, lit)): (usize, (&mut [Rgb], &mut [LitLayers]))| {
        let first_tile = (band as u32) << shift;
        for part in yields {
            for Splat { slot, value } in part.splats.of_band(band) {
                let tile = (slot.tile - first_tile) as usize;
                let values = &mut values[tile * per_tile..(tile + 1) * per_tile];
                add_to_tile(values, &mut lit[tile], slot.in_tile as usize, *value);
            }
        }
    };
    let (values, lit) = frame.tiles();
    values
        .par_chunks_mut(per_tile << shift)
        .zip(lit.par_chunks_mut(1 << shift))
        .enumerate()
        .for_each(add);
}
