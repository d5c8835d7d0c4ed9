//! Points of scrambled sequences, as pure functions of a key.

use super::sobol::{self, N_PAIRS, Point};

/// Blocks of pairs kept for each bounce, so that what one bounce draws does not shift the next.
pub(super) const BLOCKS_PER_BOUNCE: u32 = 8;

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
pub(super) fn mix(mut x: u64) -> u64 {
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

/// The Laine-Karras permutation with the constants of [Burley 2020]: every bit is flipped depending
/// on the bits below it. On reversed bits that is a nested uniform (Owen) scrambling: of a binary
/// fraction, or, as a shuffle, of an index.
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
pub(super) fn pascal(mut x: u32) -> u32 {
    x ^= (x & 0xaaaa_aaaa) >> 1;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^= (x & 0xffff_0000) >> 16;
    x
}
