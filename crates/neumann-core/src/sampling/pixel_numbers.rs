//! The random numbers of an image: every pixel has the same points, moved by a shift of its own.
//!
//! Points of a scrambled Sobol' sequence stay one when the digits of all of them are shifted alike (added modulo 2):
//! for each pixel the iterations are spread as evenly as if it had a scrambling to itself, but the points are made once
//! for all pixels.
//!
//! The shifts of the camera's numbers and of those of the first two bounces are themselves points of such sequences, in
//! the order in which a Z-curve meets the pixels (the order of Ahmed and Wonka 2020, "Screen-Space Blue-Noise Diffusion of
//! Monte Carlo Sampling Error via Hierarchical Ordering of Pixels"): in each square of 2×2, 4×4 … 16×16 pixels, each
//! dimension has one shift in each of as many equal parts of [0, 1). What neighbours get wrong, they get wrong
//! in different directions, and the eye, which averages over neighbours, sees less of it in the first iterations.
//! Each tile of 16×16 is shifted by random digits besides, and so is each pixel where bounces come later.
//!
//! What a set of few points gets wrong is a sum of Walsh functions, and a shift multiplies each of them by its value
//! there. Shifts from the same sequence would give all pixels of a square the same factor, and so the same error: each
//! dimension has a sequence to itself, shuffled apart from the others.

use std::sync::LazyLock;

use super::Sampler;
use super::rng::{BLOCKS_PER_BOUNCE, N_PAIRS, Pixel, path_key, scrambled_point};
use super::sobol::{N_JOINT_BLOCKS, Point};

/// Edge of a square of pixels whose shifts are spread over each other.
const EDGE: usize = 16;
/// Blocks of which the points are made in advance: two for each of sixteen bounces.
const N_KEPT: usize = 34;
/// Numbers of paths from here on are those of tiles, see [`path_key`].
const TILES: u64 = 1 << 62;
/// The path whose numbers the pixels have in common.
const COMMON: u64 = 3 << 61;

/// What the pixels of one iteration have in common.
#[derive(Debug)]
pub struct PixelNumbers {
    seed: u64,
    iteration: u32,
    common_key: u64,
    /// `common[bounce * 2 + i]`, where the camera counts as a bounce.
    common: [Point; N_KEPT],
    shifts: &'static [Shifts; N_JOINT_BLOCKS],
}

/// Shifts of the pixels of a tile, in the order of a Z-curve.
type Shifts = [Point; EDGE * EDGE];

static SHIFTS: LazyLock<Box<[Shifts; N_JOINT_BLOCKS]>> = LazyLock::new(|| {
    let mut shifts = Box::new([[Point::default(); EDGE * EDGE]; N_JOINT_BLOCKS]);
    let key = path_key(0, COMMON);
    for (i, of_block) in shifts.iter_mut().enumerate() {
        for (along_curve, shift) in of_block.iter_mut().enumerate() {
            for (half, of_half) in shift.chunks_exact_mut(N_PAIRS).enumerate() {
                let block = i as u32 * BLOCKS_PER_BOUNCE + 1 + half as u32;
                let padded = scrambled_point(key, block, along_curve as u32);
                of_half.copy_from_slice(&padded[..N_PAIRS]);
            }
        }
    }
    shifts
});

impl PixelNumbers {
    /// The numbers of one iteration.
    #[must_use]
    pub fn new(seed: u64, iteration: u32) -> Self {
        let common_key = path_key(seed, COMMON);
        Self {
            seed,
            iteration,
            common_key,
            common: std::array::from_fn(|i| {
                let block = i as u32 / 2 * BLOCKS_PER_BOUNCE + i as u32 % 2;
                scrambled_point(common_key, block, iteration)
            }),
            shifts: &SHIFTS,
        }
    }

    /// The numbers of pixel (x, y), which has the given index in the image.
    #[inline]
    #[must_use]
    pub fn of_pixel(&self, x: usize, y: usize, index: usize) -> Sampler<'_> {
        let tile = ((y / EDGE) as u64) << 31 | (x / EDGE) as u64;
        let pixel = Pixel {
            numbers: self,
            tile_key: path_key(self.seed, TILES | tile),
            in_tile: along_z_curve(x % EDGE, y % EDGE),
        };
        Sampler::of_pixel(path_key(self.seed, index as u64), self.iteration, pixel)
    }

    /// The point that all pixels have in a block.
    #[inline]
    fn common(&self, block: u32) -> Point {
        let (bounce, i) = (block / BLOCKS_PER_BOUNCE, block % BLOCKS_PER_BOUNCE);
        match self.common.get((2 * bounce + i) as usize) {
            Some(point) if i < 2 => *point,
            _ => scrambled_point(self.common_key, block, self.iteration),
        }
    }
}

impl Pixel<'_> {
    /// The pixel's point in a block, with the pixel's key.
    #[inline]
    pub(super) fn point(&self, key: u64, block: u32) -> Point {
        let mut point = self.numbers.common(block);
        let is_joint = block.is_multiple_of(BLOCKS_PER_BOUNCE);
        let arranged = self
            .numbers
            .shifts
            .get((block / BLOCKS_PER_BOUNCE) as usize);
        let key = match arranged {
            Some(shifts) if is_joint => {
                for (digits, shift) in point.iter_mut().zip(&shifts[self.in_tile as usize]) {
                    *digits ^= shift;
                }
                self.tile_key
            }
            _ => key,
        };
        for (i, digits) in point.chunks_exact_mut(2).enumerate() {
            let random = random_bits(key, u64::from(block) * N_PAIRS as u64 + i as u64);
            digits[0] ^= random as u32;
            digits[1] ^= (random >> 32) as u32;
        }
        point
    }
}

/// Element number `index` of the generator `wyrand` (Wang Yi 2019) that starts from a key.
#[inline]
fn random_bits(key: u64, index: u64) -> u64 {
    let state = key.wrapping_add((index + 1).wrapping_mul(0xa076_1d64_78bd_642f));
    let product = u128::from(state) * u128::from(state ^ 0xe703_7ed1_a0b4_28db);
    product as u64 ^ (product >> 64) as u64
}

/// Where a Z-curve meets the pixel (x, y) of a tile: the bits of both, in turn.
#[inline]
fn along_z_curve(x: usize, y: usize) -> u32 {
    let spread = |v: usize| {
        let v = v as u32;
        v & 1 | (v & 2) << 1 | (v & 4) << 2 | (v & 8) << 3
    };
    spread(x) | spread(y) << 1
}

#[cfg(test)]
mod tests {
    use super::{EDGE, PixelNumbers};

    /// Draws the first numbers of the camera and of the first two bounces.
    fn numbers(numbers: &PixelNumbers, x: usize, y: usize) -> Vec<f32> {
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
        let iteration = PixelNumbers::new(5, 3);
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
    fn the_iterations_of_every_pixel_are_stratified() {
        for pixel in 0..20 {
            for (nx, ny) in [(64, 1), (8, 8), (1, 64)] {
                let mut seen = [false; 64];
                for i in 0..64 {
                    let iteration = PixelNumbers::new(9, i);
                    let [x, y] = iteration.of_pixel(pixel, 7, pixel).next_2d();
                    let cell = (y * ny as f32) as usize * nx + (x * nx as f32) as usize;
                    assert!(!std::mem::replace(&mut seen[cell], true));
                }
            }
        }
    }

    #[test]
    fn pixels_of_different_tiles_and_late_bounces_are_uncorrelated() {
        let iteration = PixelNumbers::new(1, 0);
        let n = 20_000;
        for bounce in [None, Some(5)] {
            let draw = |i: usize| {
                let mut sampler = iteration.of_pixel(EDGE * i, 0, EDGE * i);
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
