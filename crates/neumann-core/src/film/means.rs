//! The running mean of frames, tile by tile, and how far they spread.

use bytemuck::zeroed_vec;
use rayon::prelude::*;

use super::frame::{LitLayers, TILE_PIXELS};
use crate::radiometry::Rgb;

/// Means and squared deviations of so many iterations.
#[derive(Clone, Debug)]
pub(super) struct Means {
    /// Number of iterations.
    pub(super) n: u32,
    /// The tiles row by row, each with its layers, tail last, then the total and the deviations,
    /// and each of these with its pixels row by row; tiles that reach beyond the image are whole.
    pub(super) values: Vec<Rgb>,
    /// What of each tile is not all black.
    pub(super) lit: Vec<LitLayers>,
}

impl Means {
    /// Those of no iteration, for tiles of so many values.
    pub(super) fn new(n_tiles: usize, per_tile: usize) -> Self {
        Self {
            n: 0,
            // Memory that is never written where a layer is black.
            values: zeroed_vec(n_tiles * per_tile),
            lit: vec![LitLayers::default(); n_tiles],
        }
    }

    /// Those of the same shape of no iteration.
    pub(super) fn black(&self) -> Self {
        let n_tiles = self.lit.len();
        Self::new(n_tiles, self.values.len() / n_tiles.max(1))
    }

    /// Those of the iterations of both; deviations by Chan, Golub and `LeVeque` (1979).
    pub(super) fn join(&self, other: &Self) -> Self {
        if self.n == 0 || other.n == 0 {
            return if self.n == 0 { other } else { self }.clone();
        }
        let mut joint = self.black();
        joint.n = self.n + other.n;
        let share = f64::from(other.n) / f64::from(joint.n);
        let per_tile = self.values.len() / self.lit.len();
        let parts = self.values.par_chunks_exact(per_tile);
        joint
            .values
            .par_chunks_exact_mut(per_tile)
            .zip(parts.zip(other.values.par_chunks_exact(per_tile)))
            .for_each(|(joint, (a, b))| join_tiles(joint, a, b, share, self.n));
        for (tile, lit) in joint.lit.iter_mut().enumerate() {
            *lit = self.lit[tile].union(other.lit[tile]);
        }
        joint
    }
}

fn join_tiles(joint: &mut [Rgb], a: &[Rgb], b: &[Rgb], share: f64, n_of_a: u32) {
    let n_means = joint.len() - TILE_PIXELS;
    let (means, deviations) = joint.split_at_mut(n_means);
    for (mean, (a, b)) in means.iter_mut().zip(a.iter().zip(b)) {
        *mean = in_double(*a, *b, |a, b| a + (b - a) * share);
    }
    let total = n_means - TILE_PIXELS;
    for (i, deviations) in deviations.iter_mut().enumerate() {
        let between = in_double(a[total + i], b[total + i], |a, b| {
            (b - a).powi(2) * f64::from(n_of_a) * share
        });
        *deviations = a[n_means + i] + b[n_means + i] + between;
    }
}

fn in_double(a: Rgb, b: Rgb, f: impl Fn(f64, f64) -> f64) -> Rgb {
    let f = |a: f32, b: f32| f(a.into(), b.into()) as f32;
    Rgb::new(f(a.r, b.r), f(a.g, b.g), f(a.b, b.b))
}
