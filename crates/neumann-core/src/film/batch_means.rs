//! How far the mean of the iterations is from the truth, by batch means.
//!
//! Iterations are not independent: their points fill the gaps that earlier ones left, so that the
//! variance of a mean falls faster than that of one iteration over their number. How fast is
//! measured, on some pixels of every tile. A batch is the mean of the `2^l` iterations whose
//! numbers agree but for the last `l` binary digits; Owen's scrambling makes the two halves of a
//! batch exchangeable. So with `V_l` the variance of such a mean and `A`, `B` those of the halves,
//!
//! `E[(A − B)²] / 4 = V_{l−1} − V_l = D_l`, and `V_l = Σ_{j>l} D_j`.
//!
//! What lies beyond the largest batch is taken to go on as a geometric series, whose ratio is that
//! of the measured `D_l`: 1/2 for independent iterations, 1/8 for a smooth integrand of one
//! dimension (Owen 1997, Scrambled net variance for integrals of smooth functions).

use std::sync::{Arc, OnceLock};

use super::frame::TILE_PIXELS;
use crate::radiometry::Rgb;

/// Pixels of a film that are watched: so many, if it has them, and one of each tile at least.
const PIXELS: usize = 2048;
/// Fewest levels whose differences say how fast variance falls.
const FEWEST_LEVELS: usize = 2;
/// The ratio of two levels is not very certain: this power of the result is nearer to the truth
/// than the result, by 32 renders of six scenes by five methods.
const CAUTION: f64 = 0.65;
/// How much less each earlier level counts for the ratio.
const FADING: f64 = 0.7;
/// Between what one can hope for and independence.
const RATIOS: (f64, f64) = (0.1, 0.5);

/// The means of batches of iterations, at some pixels.
#[derive(Clone, Debug)]
pub(super) struct BatchMeans {
    /// Pixels of each tile.
    per_tile: usize,
    n_tiles: usize,
    /// The largest batches that are whole, by their first iteration.
    batches: Vec<Batch>,
    /// Of the halves of the batches of `2^(l+1)` iterations.
    differences: Vec<Differences>,
    /// [`Self::variance_ratio`], once it has been asked for.
    ratio: OnceLock<Option<f64>>,
}

/// The mean of the iterations `start .. start + 2^level`.
#[derive(Clone, Debug)]
struct Batch {
    start: u32,
    level: u32,
    mean: Arc<[Rgb]>,
}

/// Quarters of squared differences between halves, averaged over pixels and channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Differences {
    sum: f64,
    n: u32,
}

impl Batch {
    fn n_iterations(&self) -> f64 {
        f64::from(self.level).exp2()
    }

    /// Number of the first iteration after it.
    fn end(&self) -> u64 {
        u64::from(self.start) + (1u64 << self.level)
    }

    /// Whether the other one is the half that follows this one.
    fn is_followed_by(&self, other: &Self) -> bool {
        let is_first_half = u64::from(self.start).trailing_zeros() > self.level;
        self.level == other.level && is_first_half && self.end() == u64::from(other.start)
    }
}

impl BatchMeans {
    pub(super) fn new(n_tiles: usize) -> Self {
        Self {
            per_tile: (PIXELS / n_tiles.max(1)).clamp(1, TILE_PIXELS),
            n_tiles,
            batches: Vec::new(),
            differences: Vec::new(),
            ratio: OnceLock::new(),
        }
    }

    /// Pixels of each tile.
    pub(super) fn per_tile(&self) -> usize {
        self.per_tile
    }

    fn n_values(&self) -> usize {
        self.n_tiles * self.per_tile
    }

    /// Takes in an iteration.
    pub(super) fn push(&mut self, iteration: u32, values: Vec<Rgb>) {
        self.insert(Batch {
            start: iteration,
            level: 0,
            mean: values.into(),
        });
    }

    /// Takes in the batches of other iterations.
    pub(super) fn absorb(&mut self, other: &Self) {
        for (level, differences) in other.differences.iter().enumerate() {
            self.note(level, *differences);
        }
        for batch in &other.batches {
            self.insert(batch.clone());
        }
    }

    /// Number of iterations that it knows of.
    pub(super) fn n_iterations(&self) -> u64 {
        self.batches.iter().map(|batch| 1u64 << batch.level).sum()
    }

    /// Puts a batch in its place, and joins it with the half that it fits to. Iterations that are
    /// there already are not independent of themselves: then nothing is known any longer.
    fn insert(&mut self, batch: Batch) {
        self.ratio = OnceLock::new();
        let place = self.batches.partition_point(|b| b.start < batch.start);
        let overlaps_before = place > 0 && self.batches[place - 1].end() > u64::from(batch.start);
        let after = self.batches.get(place);
        if overlaps_before || after.is_some_and(|after| batch.end() > u64::from(after.start)) {
            self.batches.clear();
            self.differences.clear();
            return;
        }
        self.batches.insert(place, batch);
        let mut place = place;
        loop {
            let joins = |i: usize| {
                let pair = self.batches.get(i..i + 2);
                pair.is_some_and(|pair| pair[0].is_followed_by(&pair[1]))
            };
            if joins(place) {
                self.join(place);
            } else if place > 0 && joins(place - 1) {
                place -= 1;
                self.join(place);
            } else {
                break;
            }
        }
    }

    /// Makes one batch of two halves, and notes how far they were apart.
    fn join(&mut self, place: usize) {
        let second = self.batches.remove(place + 1);
        let first = &mut self.batches[place];
        let mut sum = 0.0;
        let halves = first.mean.iter().zip(second.mean.iter());
        let mean = halves.map(|(a, b)| {
            let apart = (*a - *b).to_array().map(f64::from);
            sum += apart.map(|x| x * x).iter().sum::<f64>();
            (*a + *b) * 0.5
        });
        let mean = mean.collect();
        let level = first.level as usize;
        *first = Batch {
            start: first.start,
            level: first.level + 1,
            mean,
        };
        let sum = sum / (4 * 3 * self.n_values()) as f64;
        self.note(level, Differences { sum, n: 1 });
    }

    fn note(&mut self, level: usize, differences: Differences) {
        if self.differences.len() <= level {
            self.differences
                .resize_with(level + 1, Differences::default);
        }
        self.differences[level].sum += differences.sum;
        self.differences[level].n += differences.n;
    }

    /// The variance of the mean of these iterations, over what their spread would make of
    /// independent ones; at most 1. `None` before two levels of batches are whole.
    pub(super) fn variance_ratio(&self) -> Option<f64> {
        *self.ratio.get_or_init(|| self.find_variance_ratio())
    }

    fn find_variance_ratio(&self) -> Option<f64> {
        let levels = Levels::of(&self.differences)?;
        let n = self.n_iterations() as f64;
        let mut variance = 0.0;
        for (i, a) in self.batches.iter().enumerate() {
            variance += a.n_iterations().powi(2) * levels.variance(a.level);
            for b in &self.batches[..i] {
                let covariance = levels.covariance(a, b);
                variance += 2.0 * a.n_iterations() * b.n_iterations() * covariance;
            }
        }
        // Noise must not make it less than that of a batch as large.
        variance = (variance / (n * n)).max(levels.variance(n.log2().ceil() as u32));
        let of_independent = (levels.variance(0) - variance) / (n - 1.0);
        if of_independent <= 0.0 {
            // Iterations do not differ.
            return Some(1.0);
        }
        let ratio = (variance / of_independent).clamp(0.0, 1.0);
        let is_certain = levels.measured.len() > FEWEST_LEVELS;
        Some(if is_certain {
            ratio
        } else {
            ratio.powf(CAUTION)
        })
    }
}

/// The variances of batches of all sizes.
struct Levels {
    /// `D_{l+1}`.
    measured: Vec<f64>,
    /// Of each to the one before, beyond.
    ratio: f64,
}

impl Levels {
    /// `None` if too few levels are known.
    fn of(differences: &[Differences]) -> Option<Self> {
        let known = differences.iter().take_while(|d| d.n > 0);
        let measured: Vec<f64> = known.map(|d| d.sum / f64::from(d.n)).collect();
        if measured.len() < FEWEST_LEVELS {
            return None;
        }
        let ratio = slope(&measured).exp().clamp(RATIOS.0, RATIOS.1);
        Some(Self { measured, ratio })
    }

    /// `D_l`.
    fn difference(&self, level: u32) -> f64 {
        let (n, level) = (self.measured.len(), level as usize);
        match level.checked_sub(1) {
            None => 0.0,
            Some(i) if i < n => self.measured[i],
            Some(i) => self.measured[n - 1] * self.ratio.powi((i + 1 - n) as i32),
        }
    }

    /// `V_l`.
    fn variance(&self, level: u32) -> f64 {
        let n = self.measured.len() as u32;
        let measured = self.measured.iter().skip(level as usize).sum::<f64>();
        measured + self.difference(level.max(n)) * self.ratio / (1.0 - self.ratio)
    }
}

impl Levels {
    /// Of the means of two batches. Points whose numbers differ first in digit `c`, from the last
    /// one on, share as many elementary intervals whatever their other digits are; so their
    /// covariance is `C_c = V_0 − 2^{c+1} D_{c+1}`, by what it adds up to within a batch.
    fn covariance(&self, a: &Batch, b: &Batch) -> f64 {
        let level = a.level.max(b.level);
        let [a, b] = [a.start, b.start].map(|start| u64::from(start) >> level);
        let digits = (a ^ b).trailing_zeros() + 1;
        let apart = f64::from(digits).exp2() * self.difference(level + digits);
        self.variance(level) - apart
    }
}

/// The slope of the logarithms, by weighted least squares; that of independence if all are zero.
fn slope(values: &[f64]) -> f64 {
    let points = values.iter().enumerate().filter(|(_, value)| **value > 0.0);
    let points = points.map(|(i, value)| {
        let weight = FADING.powi((values.len() - 1 - i) as i32);
        (weight, i as f64, value.ln())
    });
    let points: Vec<_> = points.collect();
    let sum = |f: &dyn Fn(&(f64, f64, f64)) -> f64| points.iter().map(f).sum::<f64>();
    let weight = sum(&|p| p.0);
    let (x, y) = (sum(&|p| p.0 * p.1) / weight, sum(&|p| p.0 * p.2) / weight);
    let spread = sum(&|p| p.0 * (p.1 - x).powi(2));
    if spread > 0.0 {
        sum(&|p| p.0 * (p.1 - x) * (p.2 - y)) / spread
    } else {
        RATIOS.1.ln()
    }
}

/// As bytes, for files: all numbers with their lowest byte first.
///
/// The number of levels, and for each the sum of its differences (8 bytes) and their number; the
/// number of batches, and for each its first iteration, its level, and the values of its pixels.
impl BatchMeans {
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut put = |word: &[u8]| bytes.extend_from_slice(word);
        put(&(self.differences.len() as u32).to_le_bytes());
        for Differences { sum, n } in &self.differences {
            put(&sum.to_le_bytes());
            put(&n.to_le_bytes());
        }
        put(&(self.batches.len() as u32).to_le_bytes());
        for batch in &self.batches {
            put(&batch.start.to_le_bytes());
            put(&batch.level.to_le_bytes());
            for channel in batch.mean.iter().flat_map(|value| value.to_array()) {
                put(&channel.to_le_bytes());
            }
        }
        bytes
    }

    /// What [`Self::to_bytes`] made of one for as many tiles; `None` if it cannot have made this.
    pub(super) fn from_bytes(n_tiles: usize, bytes: &[u8]) -> Option<Self> {
        let mut read = Reader(bytes);
        let mut result = Self::new(n_tiles);
        for level in 0..read.count(32)? {
            let (sum, n) = (f64::from_le_bytes(read.take()?), read.number()?);
            let is_possible = sum.is_finite() && sum >= 0.0;
            is_possible.then(|| result.note(level as usize, Differences { sum, n }))?;
        }
        for _ in 0..read.number()? {
            let (start, level) = (read.number()?, read.count(31)?);
            let values = (0..result.n_values()).map(|_| {
                let value = Rgb::new(read.float()?, read.float()?, read.float()?);
                value.is_radiance().then_some(value)
            });
            let mean = values.collect::<Option<Arc<[Rgb]>>>()?;
            let batch = Batch { start, level, mean };
            let last = result.batches.last();
            let fits = start.trailing_zeros() >= level
                && batch.end() <= 1 << 32
                && last.is_none_or(|last| {
                    last.end() <= u64::from(start) && !last.is_followed_by(&batch)
                });
            fits.then(|| result.batches.push(batch))?;
        }
        read.0.is_empty().then_some(result)
    }
}

/// Takes numbers off the front of bytes.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*bytes)
    }

    fn number(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn count(&mut self, most: u32) -> Option<u32> {
        self.number().filter(|n| *n <= most)
    }

    fn float(&mut self) -> Option<f32> {
        self.take().map(f32::from_le_bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::BatchMeans;
    use crate::radiometry::Rgb;

    const N_TILES: usize = 64;

    fn hash(a: u64, b: u64) -> u64 {
        let mut x = (a ^ b.rotate_left(32)).wrapping_add(0x9e37_79b9_7f4a_7c15);
        for factor in [0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb_u64] {
            x = (x ^ (x >> 30)).wrapping_mul(factor);
        }
        x ^ (x >> 31)
    }

    fn unit(x: u64) -> f32 {
        (x >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Van der Corput's points, with digits flipped as Owen does it.
    fn stratified(pixel: u64, iteration: u32) -> f32 {
        let mut x = 0u64;
        for digit in 0..24 {
            let before = x | 1 << digit;
            let flip = hash(hash(pixel, 77), before) >> 63;
            x |= (u64::from(iteration >> digit) & 1) << digit ^ flip << digit;
        }
        (0..24)
            .map(|digit| ((x >> digit) & 1) as f32 * 0.5f32.powi(digit + 1))
            .sum()
    }

    /// What batch means say of the mean of the iterations, and how it is.
    struct Found {
        estimated: f64,
        true_error: f64,
        means: BatchMeans,
    }

    fn find(numbers: std::ops::Range<u32>, f: impl Fn(u64, u32) -> f32, expected: f64) -> Found {
        let mut means = BatchMeans::new(N_TILES);
        let n_pixels = means.n_values();
        let n = f64::from(numbers.end - numbers.start);
        let mut sums = vec![[0f64; 2]; n_pixels];
        for iteration in numbers {
            let mut values = vec![Rgb::BLACK; means.n_values()];
            for (pixel, value) in values.iter_mut().enumerate() {
                *value = Rgb::splat(f(pixel as u64, iteration));
                let x = f64::from(value.r);
                sums[pixel][0] += x;
                sums[pixel][1] += x * x;
            }
            means.push(iteration, values);
        }
        let average =
            |f: &dyn Fn(&[f64; 2]) -> f64| sums.iter().map(f).sum::<f64>() / n_pixels as f64;
        let spread = average(&|[a, b]| (b - a * a / n) / (n - 1.0)) / n;
        Found {
            estimated: spread * means.variance_ratio().unwrap(),
            true_error: average(&|[a, _]| (a / n - expected).powi(2)),
            means,
        }
    }

    #[test]
    fn the_variance_of_the_mean_is_found_whatever_the_points() {
        // Cut somewhere else in each pixel.
        let cut = |pixel: u64, x: f32| {
            let at = unit(hash(pixel, 0));
            f32::from(u8::from(x < at)) - at
        };
        for numbers in [0..8, 0..16, 0..23, 0..64, 0..100, 24..88, 5..40] {
            let random = |pixel, i| unit(hash(pixel, u64::from(i)));
            for (what, found) in [
                ("random", find(numbers.clone(), random, 0.5)),
                ("smooth", find(numbers.clone(), stratified, 0.5)),
                (
                    "step",
                    find(numbers.clone(), |p, i| cut(p, stratified(p, i)), 0.0),
                ),
            ] {
                let ratio = (found.estimated / found.true_error).sqrt();
                assert!((0.8..1.25).contains(&ratio), "{what}, {numbers:?}: {ratio}");
            }
        }
    }

    #[test]
    fn ranges_apart_are_the_whole() {
        let whole = find(0..40, stratified, 0.5).means;
        let mut parts = find(24..40, stratified, 0.5).means;
        parts.absorb(&find(0..7, stratified, 0.5).means);
        parts.absorb(&find(7..24, stratified, 0.5).means);
        let (a, b) = (
            whole.variance_ratio().unwrap(),
            parts.variance_ratio().unwrap(),
        );
        assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
        assert_eq!(parts.n_iterations(), 40);
        // The same iterations twice say nothing.
        parts.absorb(&find(8..12, stratified, 0.5).means);
        assert_eq!(parts.variance_ratio(), None);
    }

    #[test]
    fn bytes_come_back_and_odd_ones_are_refused() {
        let means = find(3..40, stratified, 0.5).means;
        let bytes = means.to_bytes();
        let back = BatchMeans::from_bytes(N_TILES, &bytes).unwrap();
        assert_eq!(back.to_bytes(), bytes);
        assert_eq!(back.variance_ratio(), means.variance_ratio());
        assert!(BatchMeans::from_bytes(N_TILES, &bytes[..bytes.len() - 1]).is_none());
        assert!(BatchMeans::from_bytes(N_TILES - 7, &bytes).is_none());
        let n_levels = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        let first = 8 + 12 * n_levels;
        for (at, word) in [
            (0, 33u32.to_le_bytes()),
            (8, 0x7ff8_0000u32.to_le_bytes()),
            (first, 9u32.to_le_bytes()),
            (first + 4, 32u32.to_le_bytes()),
            (first + 8, (-1f32).to_le_bytes()),
        ] {
            let mut odd = bytes.clone();
            odd[at..at + 4].copy_from_slice(&word);
            assert!(BatchMeans::from_bytes(N_TILES, &odd).is_none(), "{at}");
        }
    }
}
