//! The random numbers of a tile of pixels: all have the same points, each moved by a shift of its
//! own.
//!
//! Points of a scrambled Sobol' sequence stay one when the digits of all of them are shifted alike
//! (added modulo 2): for each pixel the iterations are spread as evenly as if it had a scrambling
//! to itself, but the points are made once for a tile.
//!
//! The shifts of the camera's numbers and of those of the first two bounces are spread over squares
//! of 2×2, 4×4 … 16×16 pixels: each dimension has one shift in each of as many equal parts of
//! [0, 1), and each pair of dimensions one in each of as many equal cells of [0, 1)². What
//! neighbours get wrong, they get wrong in different directions, and the eye, which averages over
//! neighbours, sees less of it in the first iterations. (The hierarchical ordering of pixels of
//! Ahmed and Wonka 2020, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error".) Where
//! bounces come later, the shift is random for each pixel.
//!
//! What a set of few points gets wrong is a sum of Walsh functions, and a shift multiplies each of
//! them by its value there. So every pair orders the pixels by itself, at random in every square.
//! Pairs in one order, such as that of a Z-curve, flip their first digits together from row to row:
//! their common Walsh functions stay as they are, and show as rows.

use std::sync::LazyLock;

use super::points::{BLOCKS_PER_BOUNCE, path_key, scrambled_pair, scrambled_point};
use super::sobol::{N_JOINT_BLOCKS, N_PAIRS, Point};

pub(super) const EDGE: usize = TileNumbers::EDGE;
/// Blocks of which the points are made in advance, at most: two for each of sixteen bounces.
const N_KEPT: usize = 34;
/// Numbers of paths from here on are those of tiles, see [`path_key`].
const TILES: u64 = 1 << 62;
/// Arrangements of shifts that tiles choose among.
const N_ARRANGEMENTS: usize = 4;
/// The key of the shifts.
const SHIFT_KEY: u64 = 0x7e_554a;

/// What the pixels of a tile have in common in one iteration.
#[derive(Debug)]
pub struct TileNumbers {
    pub(super) seed: u64,
    /// Index in the sequence of the camera's numbers,
    camera: u32,
    /// and of the others.
    pub(super) iteration: u32,
    tile_key: u64,
    /// `kept[bounce * 2 + i]`, where the camera counts as a bounce.
    kept: [Point; N_KEPT],
    n_kept: usize,
    shifts: &'static Shifts,
}

/// Shifts of the pixels of a tile, row by row, for each block that is spread over them.
type Shifts = [[Point; EDGE * EDGE]; N_JOINT_BLOCKS];

/// A tile has one of these, so that none is met everywhere.
static SHIFTS: LazyLock<Box<[Shifts; N_ARRANGEMENTS]>> = LazyLock::new(|| {
    let mut all = Box::new([[[Point::default(); EDGE * EDGE]; N_JOINT_BLOCKS]; N_ARRANGEMENTS]);
    let mut key = SHIFT_KEY;
    for of_block in all.iter_mut().flatten() {
        for pair in 0..N_PAIRS {
            key = path_key(key, 0);
            for (pixel, shift) in of_block.iter_mut().enumerate() {
                let index = order(key, pixel % EDGE, pixel / EDGE);
                [shift[pair], shift[pair + N_PAIRS]] = scrambled_pair(key, index);
            }
        }
    }
    all
});

/// The number of pixel (x, y) of a tile in an order in which the pixels of each square of
/// 2ᵏ×2ᵏ follow each other, and which is otherwise random: in each square, a permutation of
/// the quadrants.
fn order(key: u64, x: usize, y: usize) -> u32 {
    (0..EDGE.ilog2()).fold(0, |below, level| {
        let quadrant = x >> level & 1 | (y >> level & 1) << 1;
        let square = (y >> (level + 1)) * EDGE + (x >> (level + 1));
        let place = u64::from(level) << 32 | square as u64;
        below | permutation_of_4(path_key(key, place))[quadrant] << (2 * level)
    })
}

/// One of the 24 permutations of 0 to 3 (Fisher and Yates).
fn permutation_of_4(random: u64) -> [u32; 4] {
    let mut permutation = [0, 1, 2, 3];
    let mut choice = (random % 24) as usize;
    for last in [3, 2, 1] {
        permutation.swap(last, choice % (last + 1));
        choice /= last + 1;
    }
    permutation
}

/// A pixel's place among those that share their points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pixel<'a> {
    pub(super) numbers: &'a TileNumbers,
    /// Its number in the tile.
    pub(super) in_tile: u32,
}

impl TileNumbers {
    /// Pixels along an edge of a tile, a power of two.
    pub const EDGE: usize = 16;

    /// The numbers of one iteration for the tile with pixel (x, y), of paths of some length.
    #[must_use]
    pub fn new(seed: u64, iteration: u32, x: usize, y: usize, max_bounces: u32) -> Self {
        Self::split(seed, iteration, (0, 1), x, y, max_bounces)
    }

    /// As [`Self::new`], for path number `i` of `(i, n)` that have one camera ray in common: from
    /// there on, their numbers and those of the next iterations follow each other in the sequence.
    #[must_use]
    pub fn split(
        seed: u64,
        iteration: u32,
        (i, n): (u32, u32),
        x: usize,
        y: usize,
        max_bounces: u32,
    ) -> Self {
        let (camera, iteration) = (iteration, iteration.wrapping_mul(n).wrapping_add(i));
        let tile = ((y / EDGE) as u64) << 31 | (x / EDGE) as u64;
        let tile_key = path_key(seed, TILES | tile);
        let n_kept = N_KEPT.min(2 * (max_bounces as usize + 1));
        let mut kept = [Point::default(); N_KEPT];
        for (i, point) in kept[..n_kept].iter_mut().enumerate() {
            let block = i as u32 / 2 * BLOCKS_PER_BOUNCE + i as u32 % 2;
            let index = if i < 2 { camera } else { iteration };
            *point = scrambled_point(tile_key, block, index);
        }
        Self {
            seed,
            camera,
            iteration,
            tile_key,
            kept,
            n_kept,
            shifts: &SHIFTS[tile_key as usize % N_ARRANGEMENTS],
        }
    }

    /// The point that all pixels have in a block.
    #[inline]
    fn common(&self, block: u32) -> Point {
        match self.kept(block) {
            Some(point) => *point,
            None => {
                let is_camera = block < BLOCKS_PER_BOUNCE;
                let index = if is_camera {
                    self.camera
                } else {
                    self.iteration
                };
                scrambled_point(self.tile_key, block, index)
            }
        }
    }

    /// The same, if it was made in advance.
    #[inline(always)]
    fn kept(&self, block: u32) -> Option<&Point> {
        let (bounce, i) = (block / BLOCKS_PER_BOUNCE, block % BLOCKS_PER_BOUNCE);
        let point = self.kept[..self.n_kept].get((2 * bounce + i) as usize);
        point.filter(|_| i < 2)
    }
}

impl Pixel<'_> {
    /// The pixel's point in a block, with the pixel's key.
    #[inline]
    pub(super) fn point(&self, key: u64, block: u32) -> Point {
        let mut point = self.numbers.common(block);
        if block.is_multiple_of(BLOCKS_PER_BOUNCE)
            && let Some(shifts) = self
                .numbers
                .shifts
                .get((block / BLOCKS_PER_BOUNCE) as usize)
        {
            for (digits, shift) in point.iter_mut().zip(&shifts[self.in_tile as usize]) {
                *digits ^= shift;
            }
            return point;
        }
        for (i, digits) in point.chunks_exact_mut(2).enumerate() {
            let random = random_shift(key, block, i);
            digits[0] ^= random as u32;
            digits[1] ^= (random >> 32) as u32;
        }
        point
    }

    /// The same for the first block of a bounce (the camera's counts as number 0), for whoever goes
    /// from paths at one bounce to paths at another: which of the two shifts it is, no processor
    /// can predict then, so both are found.
    #[inline(always)]
    pub(super) fn first_point(&self, key: u64, bounce: u32) -> Point {
        let block = bounce * BLOCKS_PER_BOUNCE;
        let made;
        let common = match self.numbers.kept(block) {
            Some(point) => point,
            None => {
                made = self.numbers.common(block);
                &made
            }
        };
        let spread_over = (bounce as usize).min(N_JOINT_BLOCKS - 1);
        let spread = &self.numbers.shifts[spread_over][self.in_tile as usize];
        let is_spread = u32::from(bounce as usize == spread_over).wrapping_neg();
        let random: [u64; N_PAIRS] = std::array::from_fn(|i| random_shift(key, block, i));
        std::array::from_fn(|i| {
            let random = (random[i / 2] >> (32 * (i % 2))) as u32;
            common[i] ^ (spread[i] & is_spread | random & !is_spread)
        })
    }
}

/// The random shift of numbers 2 i and 2 i + 1 of a block.
#[inline(always)]
fn random_shift(key: u64, block: u32, i: usize) -> u64 {
    random_bits(key, u64::from(block) * N_PAIRS as u64 + i as u64)
}

/// Element number `index` of the generator `wyrand` (Wang Yi 2019) that starts from a key.
#[inline]
fn random_bits(key: u64, index: u64) -> u64 {
    let state = key.wrapping_add((index + 1).wrapping_mul(0xa076_1d64_78bd_642f));
    let product = u128::from(state) * u128::from(state ^ 0xe703_7ed1_a0b4_28db);
    product as u64 ^ (product >> 64) as u64
}

#[cfg(test)]
mod tests {
    use super::{EDGE, TileNumbers};

    /// Draws the first numbers of the camera and of the first two bounces.
    fn numbers(numbers: &TileNumbers, x: usize, y: usize) -> Vec<f32> {
        let mut sampler = numbers.of_pixel(x, y, 1000 * y + x);
        let mut drawn: Vec<f32> = (0..4).flat_map(|_| sampler.next_2d()).collect();
        for bounce in 0..2 {
            sampler.start_bounce(bounce);
            drawn.extend((0..4).flat_map(|_| sampler.next_2d()));
        }
        drawn
    }

    #[test]
    fn every_square_of_pixels_has_one_number_in_each_part() {
        let iteration = TileNumbers::new(5, 3, EDGE, 3 * EDGE, 4);
        for edge in [2, 4, 8, EDGE] {
            let (x0, y0) = (EDGE + EDGE - edge, 3 * EDGE);
            let mut counts = vec![[0u32; 24]; edge * edge];
            for i in 0..edge * edge {
                let drawn = numbers(&iteration, x0 + i % edge, y0 + i / edge);
                for (dimension, u) in drawn.iter().enumerate() {
                    counts[(u * (edge * edge) as f32) as usize][dimension] += 1;
                }
            }
            assert!(
                counts.iter().flatten().all(|n| *n == 1),
                "{edge}: {counts:?}"
            );
        }
    }

    #[test]
    fn every_square_of_pixels_has_one_pair_in_each_cell() {
        let iteration = TileNumbers::new(5, 3, EDGE, 3 * EDGE, 4);
        for edge in [2, 4, 8, EDGE] {
            let (x0, y0) = (EDGE, 4 * EDGE - edge);
            let mut counts = vec![[0u32; 12]; edge * edge];
            for i in 0..edge * edge {
                let drawn = numbers(&iteration, x0 + i % edge, y0 + i / edge);
                for (pair, u) in drawn.chunks_exact(2).enumerate() {
                    let [column, row] = [0, 1].map(|k| (u[k] * edge as f32) as usize);
                    counts[row * edge + column][pair] += 1;
                }
            }
            assert!(
                counts.iter().flatten().all(|n| *n == 1),
                "{edge}: {counts:?}"
            );
        }
    }

    #[test]
    fn the_iterations_of_every_pixel_are_stratified() {
        for pixel in 0..20 {
            for (nx, ny) in [(64, 1), (8, 8), (1, 64)] {
                let mut seen = [false; 64];
                for i in 0..64 {
                    let iteration = TileNumbers::new(9, i, pixel, 7, 1);
                    let [x, y] = iteration.of_pixel(pixel, 7, pixel).next_2d();
                    let cell = (y * ny as f32) as usize * nx + (x * nx as f32) as usize;
                    assert!(!std::mem::replace(&mut seen[cell], true));
                }
            }
        }
    }

    #[test]
    fn what_splits_has_one_camera_ray_and_even_directions() {
        let n = 4;
        for pixel in 0..20 {
            for (nx, ny) in [(64, 1), (8, 8), (1, 64)] {
                let mut seen = [false; 64];
                for i in 0..64 {
                    let of = |i| {
                        let tile = TileNumbers::split(9, i / n, (i % n, n), pixel, 7, 1);
                        let mut sampler = tile.of_pixel(pixel, 7, pixel);
                        let camera: Vec<_> = (0..5).map(|_| sampler.next_2d()).collect();
                        sampler.start_bounce(0);
                        (camera, sampler.next_2d())
                    };
                    let (camera, [x, y]) = of(i);
                    assert_eq!(camera, of(i / n * n).0);
                    let cell = (y * ny as f32) as usize * nx + (x * nx as f32) as usize;
                    assert!(!std::mem::replace(&mut seen[cell], true));
                }
            }
        }
    }

    #[test]
    fn pixels_of_different_tiles_and_late_bounces_are_uncorrelated() {
        let n = 20_000;
        for bounce in [None, Some(5)] {
            let draw = |i: usize| {
                let tile = TileNumbers::new(1, 0, EDGE * i, 0, 3);
                let mut sampler = tile.of_pixel(EDGE * i, 0, EDGE * i);
                if let Some(bounce) = bounce {
                    sampler.start_bounce(bounce);
                }
                f64::from(sampler.next_1d()) - 0.5
            };
            let sum: f64 = (0..n).map(|i| draw(i) * draw(i + 1)).sum();
            // The standard deviation of one product is 1/12.
            assert!((sum / n as f64).abs() < 5.0 / 12.0 / (n as f64).sqrt());
        }
    }
}
