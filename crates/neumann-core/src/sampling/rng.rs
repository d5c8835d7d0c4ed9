//! Counter-based random numbers: any path can be replayed alone.
//!
//! A number is a pure function of (seed, path, iteration, dimension). For a fixed path, the
//! iterations run through Sobol's sequence, scrambled by nested uniform (Owen) scrambling with a
//! hash ([Burley 2020]). What the camera (or the light) and the first two bounces draw are
//! dimensions of one such sequence, so that the iterations cover their whole space evenly; the
//! dimensions of later bounces are padded: each pair is a shuffled copy of its own of the first
//! two, a (0,2)-sequence. The pixels of a tile share their points, each moved by a shift of its own
//! ([`TileNumbers`]).
//!
//! Four pairs, about what one bounce needs, are made at once, in vectors where the processor has
//! them.

use super::points::{BLOCKS_PER_BOUNCE, mix, path_key, scrambled_point};
use super::sobol::N_PAIRS;
use super::tile_numbers::{Pixel, TileNumbers};

/// Numbers of paths from here on are those of shared sequences.
const SHARED: u64 = 1 << 63;

/// The random numbers of one path in one iteration.
#[derive(Clone, Debug)]
pub struct Sampler<'a> {
    key: u64,
    iteration: u32,
    /// Number of the block to be made next.
    block: u32,
    /// First and second dimension of each pair.
    pairs: [[f32; N_PAIRS]; 2],
    /// The pair to be drawn next, [`N_PAIRS`] where a new block is needed.
    next: u32,
    /// The second number of a pair of which only the first was drawn.
    spare: Option<f32>,
    /// What it has in common with the other pixels of its tile; nothing for a path by itself.
    pixel: Option<Pixel<'a>>,
}

impl TileNumbers {
    /// The numbers of pixel (x, y) of the tile, which has the given index in the image.
    #[inline]
    #[must_use]
    pub fn of_pixel(&self, x: usize, y: usize, index: usize) -> Sampler<'_> {
        let pixel = Pixel {
            numbers: self,
            in_tile: (y % Self::EDGE * Self::EDGE + x % Self::EDGE) as u32,
        };
        Sampler::of_pixel(path_key(self.seed, index as u64), self.iteration, pixel)
    }
}

impl<'a> Sampler<'a> {
    /// The numbers of path number `path` in iteration number `iteration`.
    #[inline]
    #[must_use]
    pub fn new(seed: u64, path: u64, iteration: u32) -> Self {
        Self::of_key(path_key(seed, path), iteration)
    }

    /// Element number `index` of one sequence that many paths share: what one path draws stratifies
    /// what the others draw, over as many of them as there are.
    #[inline]
    #[must_use]
    pub fn of_sequence(seed: u64, index: u64) -> Self {
        Self::new(seed, SHARED ^ (index >> 32), index as u32)
    }

    /// The numbers of a pixel with a key of its own.
    #[inline]
    pub(super) fn of_pixel(key: u64, iteration: u32, pixel: Pixel<'a>) -> Self {
        Self {
            pixel: Some(pixel),
            ..Self::of_key(key, iteration)
        }
    }

    /// Numbers of the same iteration for branch `number` of a path that forks at a bounce, apart
    /// from the path's own and from those of other branches.
    #[inline]
    #[must_use]
    pub fn branch(&self, bounce: u32, number: u32) -> Self {
        let key = mix(self.key ^ (u64::from(number) + 1) << 40 ^ u64::from(bounce));
        Self::of_key(key, self.iteration)
    }

    #[inline]
    fn of_key(key: u64, iteration: u32) -> Self {
        Self {
            key,
            iteration,
            block: 0,
            pairs: [[0.0; N_PAIRS]; 2],
            next: N_PAIRS as u32,
            spare: None,
            pixel: None,
        }
    }

    /// Goes to the dimensions of bounce `k`; those before are the camera's or the light's own.
    #[inline]
    pub fn start_bounce(&mut self, k: u32) {
        self.block = (k + 1) * BLOCKS_PER_BOUNCE;
        self.next = N_PAIRS as u32;
        self.spare = None;
    }

    /// A number in [0, 1).
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let [number, spare] = self.next_2d();
        self.spare = Some(spare);
        number
    }

    /// A point in [0, 1)².
    #[inline]
    pub fn next_2d(&mut self) -> [f32; 2] {
        if self.next as usize >= N_PAIRS {
            self.make_block();
        }
        let i = self.next as usize % N_PAIRS;
        self.next += 1;
        [self.pairs[0][i], self.pairs[1][i]]
    }

    /// The first pairs of numbers of a bounce, as [`Self::next_2d`] would draw them; the start of a
    /// path counts as number 0.
    #[inline(always)]
    pub(super) fn first_pairs(&self, bounce: u32) -> [[f32; 2]; N_PAIRS] {
        let point = match &self.pixel {
            Some(pixel) => pixel.first_point(self.key, bounce),
            None => scrambled_point(self.key, bounce * BLOCKS_PER_BOUNCE, self.iteration),
        };
        let unit = point.map(unit_from_bits);
        std::array::from_fn(|i| [unit[i], unit[i + N_PAIRS]])
    }

    #[inline(never)]
    fn make_block(&mut self) {
        let point = match &self.pixel {
            Some(pixel) => pixel.point(self.key, self.block),
            None => scrambled_point(self.key, self.block, self.iteration),
        };
        let unit = point.map(unit_from_bits);
        self.pairs = [0, 1].map(|half| std::array::from_fn(|i| unit[half * N_PAIRS + i]));
        self.block += 1;
        self.next = 0;
    }
}

/// 24 bits of a fraction, so that 1 is never reached.
#[inline]
fn unit_from_bits(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::Sampler;
    use crate::sampling::points::pascal;

    #[test]
    fn second_dimension_is_sobol() {
        // The first eight points of Sobol's second dimension, times 8.
        let points: Vec<u32> = (0..8).map(|i| pascal(i).reverse_bits() >> 29).collect();
        assert_eq!(points, [0, 4, 6, 2, 5, 1, 3, 7]);
    }

    #[test]
    fn dimensions_of_different_bounces_are_stratified_together() {
        // Of 256 points, the first dimensions of the camera's block and of the next two bounces'
        // have one or two in each of 4×4×4 cells of three times four on average, where padded
        // ones would leave some out.
        for key in 0..20 {
            let mut counts = [0u32; 64];
            for i in 0..256 {
                let mut sampler = Sampler::new(7, key, i);
                let x = sampler.next_1d();
                sampler.start_bounce(0);
                let y = sampler.next_1d();
                sampler.start_bounce(1);
                let z = sampler.next_1d();
                counts[[x, y, z].iter().fold(0, |c, u| 4 * c + (u * 4.0) as usize)] += 1;
            }
            assert!(counts.iter().all(|n| *n == 4), "{counts:?}");
        }
    }

    #[test]
    fn powers_of_two_are_stratified() {
        // A (0,2)-sequence: 64 points have one in each elementary interval of area 1/64.
        for key in 0..20 {
            for (nx, ny) in [(64, 1), (32, 2), (8, 8), (4, 16), (1, 64)] {
                let mut seen = [false; 64];
                for i in 0..64 {
                    let [x, y] = Sampler::new(7, key, i).next_2d();
                    let cell = (y * ny as f32) as usize * nx + (x * nx as f32) as usize;
                    assert!(!std::mem::replace(&mut seen[cell], true));
                }
            }
        }
    }

    #[test]
    fn numbers_of_different_paths_are_uncorrelated() {
        let n = 20_000u32;
        let mean_product: f64 = (0..n)
            .map(|path| {
                let a = Sampler::new(1, u64::from(path), 0).next_1d();
                let b = Sampler::new(1, u64::from(path) + 1, 0).next_1d();
                f64::from((a - 0.5) * (b - 0.5))
            })
            .sum::<f64>()
            / f64::from(n);
        // The standard deviation of one product is 1/12.
        assert!(mean_product.abs() < 5.0 / 12.0 / f64::from(n).sqrt());
    }
}
