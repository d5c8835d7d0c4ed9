//! Counter-based random numbers: any path can be replayed alone.
//!
//! A number is a pure function of (seed, path, iteration, dimension). For a
//! fixed path and dimension, the iterations run through a (0,2)-sequence (the
//! first two dimensions of Sobol), shuffled and scrambled by nested uniform
//! (Owen) scrambling with a hash ([Burley 2020]). Pairs of dimensions are padded:
//! each pair is a shuffled copy of its own.

/// The random numbers of one path in one iteration.
#[derive(Clone, Debug)]
pub struct Sampler {
    key: u64,
    iteration: u32,
    dimension: u32,
}

/// Numbers of paths from here on are those of shared sequences.
const SHARED: u64 = 1 << 63;

/// Dimensions kept for each bounce, so that what one bounce draws does not shift the next.
const DIMENSIONS_PER_BOUNCE: u32 = 32;

impl Sampler {
    /// The numbers of path number `path` in iteration number `iteration`.
    #[inline]
    #[must_use]
    pub fn new(seed: u64, path: u64, iteration: u32) -> Self {
        Self {
            key: mix(mix(seed) ^ path),
            iteration,
            dimension: 0,
        }
    }

    /// Element number `index` of one sequence that many paths share: what one path draws stratifies what the
    /// others draw, over as many of them as there are.
    #[inline]
    #[must_use]
    pub fn of_sequence(seed: u64, index: u64) -> Self {
        Self::new(seed, SHARED ^ (index >> 32), index as u32)
    }

    /// Numbers of the same iteration, apart from these and from those of other branches.
    #[inline]
    #[must_use]
    pub fn branch(&self, number: u32) -> Self {
        Self {
            key: mix(self.key ^ (u64::from(number) + 1) << 40 ^ u64::from(self.dimension)),
            iteration: self.iteration,
            dimension: 0,
        }
    }

    /// Goes to the dimensions of bounce `k`; those before are the camera's or the light's own.
    #[inline]
    pub fn start_bounce(&mut self, k: u32) {
        self.dimension = (k + 1) * DIMENSIONS_PER_BOUNCE;
    }

    /// A number in [0, 1).
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        let hash = self.next_hash();
        let index = owen_scramble(self.iteration, hash as u32);
        unit_from_bits(owen_scramble_reversed(index, (hash >> 32) as u32))
    }

    /// A point in [0, 1)².
    #[inline]
    pub fn next_2d(&mut self) -> [f32; 2] {
        let hash = self.next_hash();
        let index = owen_scramble(self.iteration, hash as u32);
        let scramble = (hash >> 32) as u32;
        [
            unit_from_bits(owen_scramble_reversed(index, scramble)),
            unit_from_bits(owen_scramble_reversed(
                pascal(index),
                scramble.wrapping_mul(0x9e37_79b9) ^ 0x5bd1_e995,
            )),
        ]
    }

    #[inline]
    fn next_hash(&mut self) -> u64 {
        let hash = mix(self.key ^ (u64::from(self.dimension) << 32 | 0x9e37));
        self.dimension += 1;
        hash
    }
}

/// A bijective hash of 64 bits (the finaliser of `SplitMix64`, Steele et al. 2014).
#[inline]
fn mix(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// The Laine-Karras permutation with the constants of [Burley 2020]: every bit is
/// flipped depending on the bits below it, which on reversed bits is an Owen scrambling.
#[inline]
fn laine_karras(mut x: u32, seed: u32) -> u32 {
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x
}

/// Owen scrambling of the binary fraction `x / 2³²`; on an index, a nested uniform shuffle.
#[inline]
fn owen_scramble(x: u32, seed: u32) -> u32 {
    laine_karras(x.reverse_bits(), seed).reverse_bits()
}

/// The Owen-scrambled radical inverse of `x`.
#[inline]
fn owen_scramble_reversed(x: u32, seed: u32) -> u32 {
    laine_karras(x, seed).reverse_bits()
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
