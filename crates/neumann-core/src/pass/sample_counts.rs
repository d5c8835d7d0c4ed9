//! How many camera paths an iteration runs for each pixel, and which random numbers they have.

use std::sync::Arc;

use crate::film::{TileBounds, TileGrid};
use crate::sampling::TileNumbers;

/// Separates the numbers of [`SampleCounts::Apart`] from the others of a seed.
const APART: u64 = 0x6ada_9717_e5a3_b1e5;

/// Camera paths for each pixel of an iteration; the iteration is their mean.
#[derive(Clone, Debug)]
pub enum SampleCounts {
    /// As many everywhere.
    Even(u8),
    /// Tile by tile, with random numbers independent of those of all other iterations, so that the
    /// counts may depend on what these found.
    Apart {
        /// `counts[tile]`, tiles row by row.
        counts: Arc<[u8]>,
        /// The first iteration that has them.
        first_iteration: u32,
    },
}

impl SampleCounts {
    /// Paths for each pixel of a tile.
    pub(super) fn of_tile(&self, tile: usize) -> u8 {
        match self {
            Self::Even(count) => *count,
            Self::Apart { counts, .. } => counts[tile],
        }
    }

    /// The numbers of path `index` of each pixel of a tile: paths of an iteration, and those of the
    /// next one, follow each other in one sequence. So do the paths, `n_splits` of them, that it
    /// may split into.
    pub(super) fn numbers(
        &self,
        (tile, bounds): (usize, TileBounds),
        (seed, iteration, max_bounces): (u64, u32, u32),
        index: u8,
        n_splits: u8,
    ) -> impl Iterator<Item = TileNumbers> {
        let (seed, first_iteration) = match self {
            Self::Even(_) => (seed, 0),
            Self::Apart {
                first_iteration, ..
            } => (seed ^ APART, *first_iteration),
        };
        let first = iteration
            .wrapping_sub(first_iteration)
            .wrapping_mul(u32::from(self.of_tile(tile)));
        let [x, y] = bounds.start;
        let camera = first.wrapping_add(u32::from(index));
        (0..n_splits).map(move |i| {
            let split = (u32::from(i), u32::from(n_splits));
            TileNumbers::split(seed, camera, split, x, y, max_bounces)
        })
    }

    /// Paths of all pixels.
    pub(super) fn total(&self, grid: TileGrid) -> u64 {
        let in_tile = |tile| grid.bounds(tile).n_pixels() as u64 * u64::from(self.of_tile(tile));
        (0..grid.n_tiles()).map(in_tile).sum()
    }
}
