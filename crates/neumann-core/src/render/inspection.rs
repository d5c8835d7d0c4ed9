//! What some iterations have brought to a pixel, taken apart.
//!
//! [`Renderer::replay`](super::Renderer::replay) yields the contributions of one iteration;
//! [`Inspection`] adds those of one iteration after the other: to a value for each bounce and
//! technique with its interval, to the distribution of what single iterations bring, to a share for
//! each way that light takes, and to a list of the largest contributions with their paths.

use std::collections::BTreeMap;

use super::Replayed;
use crate::film::{Joint, Strategy};
use crate::radiometry::Rgb;
use crate::transport::{Bounce, Source};

/// A normal variable is within so many deviations of its mean, 95 times of 100.
const DEVIATIONS: f64 = 1.96;
/// Ways that a single path is taken apart into, at most.
const MAX_WAYS_OF_PATH: usize = 64;
/// Bins of the distribution for each factor of ten.
const BINS: f64 = 4.0;

/// What some iterations have brought to a pixel.
#[derive(Clone, Debug, Default)]
pub struct Inspection {
    n_iterations: u32,
    n_paths: u64,
    total: Sum,
    bounces: Vec<Sum>,
    techniques: BTreeMap<(u32, u8, u16), (Strategy, Sum)>,
    n_zeros: u32,
    bins: BTreeMap<i32, u32>,
    ways: BTreeMap<(Vec<Bounce>, Option<Source>), Way>,
    paths: Vec<(u32, Replayed)>,
}

/// The mean of the iterations.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// W m⁻² sr⁻¹.
    pub mean: Rgb,
    /// Half the width of the interval about the mean luminance that holds the truth 95 times of
    /// 100, if iterations were independent of each other. They fill each other's gaps, so it is
    /// rather too wide. `None` before the second iteration.
    pub interval: Option<f64>,
    /// Contributions.
    pub n_paths: u64,
}

/// Iterations that bring a luminance within a bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleCount {
    /// The least and the largest luminance of the bin.
    pub range: [f64; 2],
    /// How many iterations.
    pub n: u32,
}

/// What has come along a way: what happened, from the eye to the light.
#[derive(Clone, Copy, Debug)]
pub struct WayShare<'a> {
    /// What happened.
    pub bounces: &'a [Bounce],
    /// What the light comes from.
    pub source: Option<Source>,
    /// Its part of the mean luminance of the pixel.
    pub luminance: f64,
    /// Contributions.
    pub n_paths: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Way {
    luminance: f64,
    n_paths: u64,
}

/// The sum of the iterations, and of their squared luminances.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    value: [f64; 3],
    squares: f64,
    n_paths: u64,
    /// What the iteration under way has brought.
    latest: Rgb,
}

impl Sum {
    pub(super) fn add(&mut self, value: Rgb) {
        self.latest += value;
        self.n_paths += 1;
    }

    pub(super) fn end_iteration(&mut self) {
        let latest = std::mem::take(&mut self.latest);
        for (sum, value) in self.value.iter_mut().zip(latest.to_array()) {
            *sum += f64::from(value);
        }
        self.squares += f64::from(latest.luminance()).powi(2);
    }

    pub(super) fn measured(&self, n_iterations: u32) -> Measured {
        let n = f64::from(n_iterations.max(1));
        let [r, g, b] = self.value.map(|sum| (sum / n) as f32);
        let mean = Rgb::new(r, g, b);
        let luminance = f64::from(mean.luminance());
        let variance = (self.squares / n - luminance * luminance).max(0.0);
        Measured {
            mean,
            interval: (n > 1.0).then(|| DEVIATIONS * (variance / (n - 1.0)).sqrt()),
            n_paths: self.n_paths,
        }
    }
}

impl Inspection {
    /// Paths that are kept, at most: those that contribute most.
    pub const MAX_PATHS: usize = 1024;
    /// Ways that are told apart, at most.
    pub const MAX_WAYS: usize = 4096;

    /// Adds what an iteration brings to the pixel.
    pub fn add(&mut self, iteration: u32, replayed: Vec<Replayed>) {
        self.n_iterations += 1;
        self.n_paths += replayed.len() as u64;
        for path in &replayed {
            let value = path.value();
            let bounce = path.contribution.bounce as usize;
            if self.bounces.len() <= bounce {
                self.bounces.resize(bounce + 1, Sum::default());
            }
            self.bounces[bounce].add(value);
            self.total.add(value);
            let strategy = path.contribution.strategy;
            let of_technique = self.techniques.entry(order(strategy));
            of_technique
                .or_insert((strategy, Sum::default()))
                .1
                .add(value);
            for (bounces, share) in ways_of(path) {
                self.add_way((bounces, path.source()), value * share);
            }
        }
        let luminance = f64::from(self.total.latest.luminance());
        if luminance > 0.0 {
            *self.bins.entry(bin(luminance)).or_default() += 1;
        } else {
            self.n_zeros += 1;
        }
        let techniques = self.techniques.values_mut().map(|(_, sum)| sum);
        for sum in self.bounces.iter_mut().chain(techniques) {
            sum.end_iteration();
        }
        self.total.end_iteration();
        self.keep(iteration, replayed);
    }

    fn add_way(&mut self, key: (Vec<Bounce>, Option<Source>), value: Rgb) {
        if self.ways.len() >= Self::MAX_WAYS && !self.ways.contains_key(&key) {
            return;
        }
        let way = self.ways.entry(key).or_default();
        way.luminance += f64::from(value.luminance());
        way.n_paths += 1;
    }

    fn keep(&mut self, iteration: u32, replayed: Vec<Replayed>) {
        let luminance = |path: &Replayed| path.value().luminance();
        let lit = replayed.into_iter().filter(|path| luminance(path) > 0.0);
        self.paths.extend(lit.map(|path| (iteration, path)));
        let paths = &mut self.paths;
        paths.sort_by(|(_, a), (_, b)| luminance(b).total_cmp(&luminance(a)));
        paths.truncate(Self::MAX_PATHS);
    }

    /// Iterations that were added.
    #[must_use]
    pub fn n_iterations(&self) -> u32 {
        self.n_iterations
    }

    /// The pixel.
    #[must_use]
    pub fn total(&self) -> Measured {
        self.total.measured(self.n_iterations)
    }

    /// Its bounces, from 0 on.
    pub fn bounces(&self) -> impl ExactSizeIterator<Item = Measured> {
        let n = self.n_iterations;
        self.bounces.iter().map(move |sum| sum.measured(n))
    }

    /// Its techniques with their MIS weights, bounce by bounce.
    pub fn techniques(&self) -> impl ExactSizeIterator<Item = (Strategy, Measured)> {
        let (techniques, n) = (self.techniques.values(), self.n_iterations);
        techniques.map(move |(strategy, sum)| (*strategy, sum.measured(n)))
    }

    /// Iterations that bring nothing.
    #[must_use]
    pub fn n_zeros(&self) -> u32 {
        self.n_zeros
    }

    /// The distribution of the luminance that single iterations bring, darkest bin first. Bins are
    /// as wide as each other on a logarithmic axis; there are none beyond the first and the last
    /// that hold one.
    pub fn samples(&self) -> impl Iterator<Item = SampleCount> {
        let first = self.bins.keys().next().copied().unwrap_or(0);
        let end = self.bins.keys().last().map_or(first, |last| last + 1);
        (first..end).map(|bin| SampleCount {
            range: [bin, bin + 1].map(|edge| 10f64.powf(f64::from(edge) / BINS)),
            n: self.bins.get(&bin).copied().unwrap_or(0),
        })
    }

    /// The ways that light has come, the brightest first; no more than [`Self::MAX_WAYS`].
    #[must_use]
    pub fn ways(&self) -> Vec<WayShare<'_>> {
        let n = f64::from(self.n_iterations.max(1));
        let mut ways: Vec<_> = self
            .ways
            .iter()
            .map(|((bounces, source), way)| WayShare {
                bounces,
                source: *source,
                luminance: way.luminance / n,
                n_paths: way.n_paths,
            })
            .collect();
        ways.sort_by(|a, b| b.luminance.total_cmp(&a.luminance));
        ways
    }

    /// The contributions that bring most, with the iterations that they are of, the largest first;
    /// no more than [`Self::MAX_PATHS`].
    #[must_use]
    pub fn paths(&self) -> &[(u32, Replayed)] {
        &self.paths
    }

    /// All contributions, those that bring nothing among them.
    #[must_use]
    pub fn n_paths(&self) -> u64 {
        self.n_paths
    }
}

/// The ways that a path has taken, with the share of each: where two lobes scatter the same way,
/// there is one for either, up to [`MAX_WAYS_OF_PATH`].
fn ways_of(path: &Replayed) -> Vec<(Vec<Bounce>, Rgb)> {
    let mut ways = vec![(Vec::new(), Rgb::WHITE)];
    for scattered in path.scattered() {
        if 2 * ways.len() > MAX_WAYS_OF_PATH {
            ways.iter_mut()
                .for_each(|(way, _)| way.push(scattered.bounce));
            continue;
        }
        let before = std::mem::take(&mut ways);
        for (lobe, share) in scattered.lobes() {
            let bounce = Bounce {
                lobe,
                ..scattered.bounce
            };
            ways.extend(before.iter().map(|(way, so_far)| {
                let way = way.iter().copied().chain([bounce]).collect();
                (way, *so_far * share)
            }));
        }
    }
    ways
}

/// Bounce by bounce, merges last, then by the vertices of the light's part.
fn order(strategy: Strategy) -> (u32, u8, u16) {
    let is_merge = u8::from(strategy.joint == Joint::Merge);
    (strategy.bounce(), is_merge, strategy.s)
}

fn bin(luminance: f64) -> i32 {
    (BINS * luminance.log10()).floor() as i32
}
