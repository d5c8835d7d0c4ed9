//! Adaptive sampling: more paths where the picture is noisy.
//!
//! An iteration has [`MEAN_COUNT`] paths a pixel on average. The first ones spread them evenly and
//! measure the error of each tile and the rays that a path takes there. From then on a tile has
//! paths in proportion to its error over the root of their rays: of all that trace as many rays,
//! this has the least sum of squared errors (Cochran, Sampling Techniques, 1977, 5.5). All tiles
//! have a share alike, since what was measured is uncertain.
//!
//! Error is what a tone curve shows of it: the deviation of `x / (x + m)`, `m` the mean of the
//! picture, so that a few very bright samples do not draw all others to them.
//!
//! Stopping where the error seems small enough would be biased: tiles that happen to miss something
//! bright seem done. Here counts depend on the iterations that measure alone, and those after them
//! have random numbers of their own: every iteration is an unbiased estimate, and so is their mean.
//! Nor do the counts depend on where a render begins: one that goes on, or is a part to be merged,
//! measures again.

use rayon::prelude::*;

use crate::film::{Frame, TILE_PIXELS};
use crate::pass::{Cancelled, Pass, SampleCounts};

/// Iterations that measure.
const N_MEASURING: u32 = 4;
/// Paths for each pixel in an iteration, on average,
const MEAN_COUNT: u8 = 4;
/// and at most.
const MAX_COUNT: u8 = 16;
/// Share of the paths that all tiles have alike.
const EVEN_SHARE: f64 = 0.25;

/// Where the samples of a method go.
pub(super) enum Adaptive {
    /// How noisy the picture is where.
    Measuring(Measurement),
    Settled(SampleCounts),
}

/// What the first iterations found, pixel by pixel.
#[derive(Default)]
pub(super) struct Measurement {
    n_iterations: u32,
    /// Mean of the picture.
    scale: f32,
    /// `moments[tile * TILE_PIXELS + pixel]`
    moments: Vec<Moments>,
    /// Of each tile.
    n_rays: Vec<u64>,
}

/// What was found of a tile.
#[derive(Clone, Copy)]
struct Finding {
    /// The root of the mean of its pixels' variances, up to a factor.
    error: f64,
    /// Rays of one path for each pixel, up to a factor.
    n_rays: f64,
}

/// Of one pixel as the tone curve shows it.
#[derive(Clone, Copy, Default)]
struct Moments {
    mean: f32,
    squared_deviations: f32,
}

impl Adaptive {
    pub(super) fn new() -> Self {
        Self::Measuring(Measurement::default())
    }

    /// True if no other iteration has to be looked at any more.
    pub(super) fn is_settled(&self) -> bool {
        matches!(self, Self::Settled(_))
    }

    /// Runs an iteration of a method with as many samples as it should have.
    pub(super) fn iterate(
        &mut self,
        pass: &mut Pass<'_>,
        iterate: impl Fn(&mut Pass<'_>) -> Result<(), Cancelled>,
    ) -> Result<(), Cancelled> {
        if let Self::Measuring(measurement) = self {
            pass.sample(SampleCounts::Even(MEAN_COUNT));
            // What an earlier run or another machine rendered.
            let n_before = N_MEASURING.min(pass.iteration());
            for iteration in measurement.n_iterations..n_before {
                pass.measure(iteration, &iterate)?;
                measurement.take(pass.frame());
                pass.clear();
            }
            if measurement.n_iterations < N_MEASURING {
                iterate(pass)?;
                measurement.take(pass.frame());
                return Ok(());
            }
            *self = Self::Settled(SampleCounts::Apart {
                counts: allot(&measurement.findings(pass.frame())).into(),
                first_iteration: N_MEASURING,
            });
        }
        if let Self::Settled(counts) = self {
            pass.sample(counts.clone());
        }
        iterate(pass)
    }
}

impl Measurement {
    /// Takes in an iteration.
    fn take(&mut self, frame: &Frame) {
        if self.n_iterations == 0 {
            let n_tiles = frame.grid().n_tiles();
            let sum: f64 = (0..n_tiles)
                .map(|tile| f64::from(values(frame, tile).iter().sum::<f32>()))
                .sum();
            self.scale = (sum / (frame.width() * frame.height()) as f64) as f32;
            self.moments = vec![Moments::default(); n_tiles * TILE_PIXELS];
            self.n_rays = vec![0; n_tiles];
        }
        for (sum, n_rays) in self.n_rays.iter_mut().zip(&frame.n_rays_of_tiles) {
            *sum += u64::from(*n_rays);
        }
        self.n_iterations += 1;
        let (n, scale) = (self.n_iterations as f32, self.scale.max(f32::MIN_POSITIVE));
        self.moments
            .par_chunks_exact_mut(TILE_PIXELS)
            .enumerate()
            .for_each(|(tile, moments)| {
                for (moments, value) in moments.iter_mut().zip(values(frame, tile)) {
                    moments.take(value / (value + scale), n);
                }
            });
    }

    /// Tile by tile.
    fn findings(&self, frame: &Frame) -> Vec<Finding> {
        let grid = frame.grid();
        let tiles = self.moments.chunks_exact(TILE_PIXELS).zip(&self.n_rays);
        tiles
            .enumerate()
            .map(|(tile, (moments, n_rays))| {
                let sum: f32 = moments.iter().map(|m| m.squared_deviations).sum();
                Finding {
                    error: (f64::from(sum) / grid.bounds(tile).n_pixels() as f64).sqrt(),
                    n_rays: *n_rays as f64,
                }
            })
            .collect()
    }
}

impl Moments {
    /// Takes in value number `n` (Welford's recurrence).
    fn take(&mut self, value: f32, n: f32) {
        let before = value - self.mean;
        self.mean += before / n;
        self.squared_deviations += before * (value - self.mean);
    }
}

/// L at the pixels of a tile, mean of its channels; black beyond the edge of the image.
fn values(frame: &Frame, tile: usize) -> [f32; TILE_PIXELS] {
    let mut sums = [0.0; TILE_PIXELS];
    for layer in frame.layers_of_tile(tile) {
        for (sum, value) in sums.iter_mut().zip(layer) {
            *sum += value.mean();
        }
    }
    sums
}

/// Paths for each pixel of tiles: for all together about as many rays as [`MEAN_COUNT`] everywhere
/// takes.
fn allot(findings: &[Finding]) -> Vec<u8> {
    let share = |f: &Finding| {
        if f.error > 0.0 && f.n_rays > 0.0 {
            f.error / f.n_rays.sqrt()
        } else {
            0.0
        }
    };
    let budget: f64 = findings.iter().map(|f| f.n_rays).sum();
    let wanted: f64 = findings.iter().map(|f| share(f) * f.n_rays).sum();
    let scale = if wanted > 0.0 { budget / wanted } else { 1.0 };
    let count = |f: &Finding| {
        let relative = EVEN_SHARE + (1.0 - EVEN_SHARE) * share(f) * scale;
        let count = (f64::from(MEAN_COUNT) * relative).round();
        count.clamp(1.0, f64::from(MAX_COUNT)) as u8
    };
    findings.iter().map(count).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{Finding, MAX_COUNT, MEAN_COUNT, Moments, allot};
    use crate::film::SampleMap;
    use crate::integrator::{ParameterValues, method};
    use crate::render::{CancelToken, RenderSettings, Renderer, WorkerPool};
    use crate::scene::Scene;
    use crate::scene::builtin::builtin;

    fn counts(findings: &[(f64, f64)]) -> Vec<u8> {
        let finding = |&(error, n_rays): &(f64, f64)| Finding { error, n_rays };
        allot(&findings.iter().map(finding).collect::<Vec<_>>())
    }

    #[test]
    fn paths_go_where_the_error_is() {
        assert_eq!(counts(&[(0.5, 8.0); 3]), [MEAN_COUNT; 3]);
        // Twice the error, but for the even share: 1 + 3 · 2/3 and 1 + 3 · 4/3.
        assert_eq!(counts(&[(1.0, 9.0), (2.0, 9.0)]), [3, 5]);
        // As much error by sixteen times the rays, a quarter of the paths: 1 + 3 · 0.85 and
        // 1 + 3 · 3.4.
        assert_eq!(counts(&[(1.0, 16.0), (1.0, 1.0)]), [4, 11]);
        // Neither the one to which a firefly came nor the others get out of hand.
        let mut findings = [(0.1, 5.0); 100];
        findings[7].0 = 1e3;
        let counts_there = counts(&findings);
        assert_eq!((counts_there[7], counts_there[8]), (MAX_COUNT, 1));
    }

    #[test]
    fn a_picture_without_noise_or_paths_has_few() {
        assert_eq!(counts(&[(0.0, 3.0), (0.0, 0.0)]), [1; 2]);
        assert_eq!(counts(&[(0.0, 0.0), (1.0, 3.0)]), [1, MEAN_COUNT]);
        assert!(counts(&[]).is_empty());
    }

    #[test]
    fn moments_are_those_of_the_values() {
        let mut moments = Moments::default();
        for (i, value) in [0.25f32, 0.5, 0.0, 0.25].into_iter().enumerate() {
            moments.take(value, i as f32 + 1.0);
        }
        assert!((moments.mean - 0.25).abs() < 1e-7);
        assert!((moments.squared_deviations - 0.125).abs() < 1e-7);
    }

    const SIZE: (usize, usize) = (40, 24);

    /// What so many iterations count, and how many paths they say that they had.
    fn counted(scene: &str, id: &str, set: &[(&str, &str)], n: u32) -> (SampleMap, u64) {
        let description = builtin(scene).unwrap().load().unwrap();
        let scene = Arc::new(Scene::build(&description));
        let method = method(id).unwrap();
        let mut values = ParameterValues::defaults(method.parameters);
        for (name, text) in set {
            values.set(method.parameters, name, text).unwrap();
        }
        let settings = RenderSettings {
            method,
            values,
            max_bounces: 3,
            ..RenderSettings::new(scene.cameras()[0].clone(), SIZE.0, SIZE.1)
        };
        let pool = WorkerPool::new(Some(1), || {}).unwrap();
        let mut renderer = Renderer::new(scene, settings, pool, 0);
        let mut n_samples = 0;
        for _ in 0..n {
            n_samples += renderer
                .iterate(&CancelToken::default())
                .unwrap()
                .n_samples();
        }
        (renderer.samples().clone(), n_samples)
    }

    #[test]
    fn paths_are_counted_where_they_went() {
        let (even, _) = counted("cornell", "pt-mis", &[], 3);
        assert_eq!(even.range(), (3, 3));
        let (none, _) = counted("cornell", "lt", &[], 3);
        assert_eq!(none.range(), (0, 0), "no path begins at the camera");
        let (uneven, n_samples) = counted("lamps", "pt-mis", &[("adaptive", "on")], 8);
        let (least, most) = uneven.range();
        assert!(least < most, "{least} to {most}");
        let pixels = (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y)));
        let sum: u64 = pixels.map(|(x, y)| u64::from(uneven.at(x, y))).sum();
        assert_eq!(sum, n_samples);
    }
}
