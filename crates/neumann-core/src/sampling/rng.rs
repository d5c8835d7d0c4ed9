//! Counter-based random numbers: any path can be replayed alone.
//!
//! A number is a pure function of (seed, path, iteration, dimension). For a
//! fixed path, the iterations run through Sobol's sequence, scrambled by nested uniform
//! (Owen) scrambling with a hash ([Burley 2020]). What the camera (or the light) and the first two bounces
//! draw are dimensions of one such sequence, so that the iterations cover their whole space evenly; the dimensions
//! of later bounces are padded: each pair is a shuffled copy of its own of the first two, a (0,2)-sequence.
//! The pixels of a tile share their points, each moved by a shift of its own ([`TileNumbers`]).
//!
//! Four pairs, about what one bounce needs, are made at once, in vectors where the processor has them.

use super::sobol::{self, Point};
use super::tile_numbers::TileNumbers;

/// Pairs of numbers that are made at once.
pub(super) const N_PAIRS: usize = 4;
/// Blocks of pairs kept for each bounce, so that what one bounce draws does not shift the next.
pub(super) const BLOCKS_PER_BOUNCE: u32 = 8;
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

/// A pixel's place among those that share their points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pixel<'a> {
    pub(super) numbers: &'a TileNumbers,
    /// Its number in the tile.
    pub(super) in_tile: u32,
}

impl<'a> Sampler<'a> {
    /// The numbers of path number `path` in iteration number `iteration`.
    #[inline]
    #[must_use]
    pub fn new(seed: u64, path: u64, iteration: u32) -> Self {
        Self::of_key(path_key(seed, path), iteration)
    }

    /// Element number `index` of one sequence that many paths share: what one path draws stratifies what the
    /// others draw, over as many of them as there are.
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

/// The key of a path's numbers.
#[inline]
pub(super) fn path_key(seed: u64, path: u64) -> u64 {
    mix(mix(seed) ^ path)
}

/// The hash of a key for a block.
#[inline]
fn block_hash(key: u64, block: u32) -> u64 {
    mix(key ^ (u64::from(block) << 32 | 0x9e37))
}

/// How the pairs of a block hang together.
#[derive(Clone, Copy)]
enum Pairs {
    /// Dimensions of one sequence: the index in it, and their matrices.
    Joint(u32, &'static sobol::Digits),
    /// A sequence of two dimensions for each pair: the iteration, its bits reversed.
    Padded(u32),
}

/// A block of points of element number `index`, scrambled by a key: binary fractions of 32 digits.
#[inline(always)]
pub(super) fn scrambled_point(key: u64, block: u32, index: u32) -> Point {
    let hash = block_hash(key, block);
    let pairs = match sobol::digits(block, BLOCKS_PER_BOUNCE) {
        Some(digits) => Pairs::Joint(index, digits),
        None => Pairs::Padded(index.reverse_bits()),
    };
    #[cfg(target_arch = "x86_64")]
    if std::is_x86_feature_detected!("avx2") {
        #[allow(unsafe_code, reason = "the processor was just found to have AVX2")]
        // SAFETY: as said.
        return unsafe { pairs_avx2(pairs, hash) };
    }
    pairs_in_lanes(pairs, hash)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn pairs_avx2(pairs: Pairs, hash: u64) -> Point {
    pairs_in_lanes(pairs, hash)
}

#[inline(always)]
fn pairs_in_lanes(pairs: Pairs, hash: u64) -> Point {
    // Bits reversed: the first dimension of every pair, then the second.
    let mut points = [0u32; 2 * N_PAIRS];
    match pairs {
        Pairs::Joint(index, digits) => points = sobol::point(digits, index),
        Pairs::Padded(iteration_reversed) => {
            let seeds: [u32; N_PAIRS] = lane_seeds(hash as u32);
            for i in 0..N_PAIRS {
                let index = laine_karras(iteration_reversed, seeds[i]).reverse_bits();
                points[i] = index;
                points[i + N_PAIRS] = pascal(index);
            }
        }
    }
    let seeds: [u32; 2 * N_PAIRS] = lane_seeds((hash >> 32) as u32);
    for (point, seed) in points.iter_mut().zip(&seeds) {
        *point = laine_karras(*point, *seed).reverse_bits();
    }
    points
}

/// Element number `index` of the (0,2)-sequence, scrambled by a key: binary fractions of 32 digits.
pub(super) fn scrambled_pair(key: u64, index: u32) -> [u32; 2] {
    let seeds: [u32; 2] = lane_seeds(mix(key) as u32);
    [0, 1].map(|i| laine_karras([index, pascal(index)][i], seeds[i]).reverse_bits())
}

/// A hash for each lane.
#[inline(always)]
fn lane_seeds<const N: usize>(hash: u32) -> [u32; N] {
    std::array::from_fn(|i| mix_32(hash.wrapping_add((i as u32 + 1).wrapping_mul(0x9e37_79b9))))
}

/// A bijective hash of 64 bits (the finaliser of `SplitMix64`, Steele et al. 2014).
#[inline]
fn mix(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A bijective hash of 32 bits (the finaliser of `MurmurHash3`, Appleby 2011).
#[inline]
fn mix_32(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
    x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

/// The Laine-Karras permutation with the constants of [Burley 2020]: every bit is flipped depending on the
/// bits below it. On reversed bits that is a nested uniform (Owen) scrambling: of a binary fraction, or, as
/// a shuffle, of an index.
#[inline]
fn laine_karras(mut x: u32, seed: u32) -> u32 {
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x
}

/// Multiplies the bits of `x` by Pascal's matrix modulo 2, which takes van der
/// Corput's sequence to the second dimension of Sobol's, both before bit reversal.
///
/// Entry (i, j) is C(j, i) mod 2, that is 1 where the bits of i are among those of j
/// (Lucas), so the product is a sum over supersets and factors by the bits of j.
#[inline]
fn pascal(mut x: u32) -> u32 {
    x ^= (x & 0xaaaa_aaaa) >> 1;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^= (x & 0xffff_0000) >> 16;
    x
}

/// 24 bits of a fraction, so that 1 is never reached.
#[inline]
fn unit_from_bits(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::{Sampler, pascal};

    #[test]
    fn second_dimension_is_sobol() {
        // The first eight points of Sobol's second dimension, times 8.
        let points: Vec<u32> = (0..8).map(|i| pascal(i).reverse_bits() >> 29).collect();
        assert_eq!(points, [0, 4, 6, 2, 5, 1, 3, 7]);
    }

    #[test]
    fn dimensions_of_different_bounces_are_stratified_together() {
        // Of 256 points, the first dimensions of the camera's block and of the next two bounces' have one or two
        // in each of 4×4×4 cells of three times four on average, where padded ones would leave some out.
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
