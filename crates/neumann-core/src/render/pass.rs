//! One iteration, run in parallel and deterministically.
//!
//! The image is cut into tiles; each is traced by one worker into layers of its
//! own and written to the frame when it is done. Contributions to other pixels
//! (splats) are kept in the order of their paths and added in that order at
//! the end. Random numbers are keyed by (seed, iteration, path), so the result
//! does not depend on which worker traced what.

use std::sync::Mutex;
use std::sync::PoisonError;

use glam::Vec2;
use rayon::prelude::*;

use super::{CancelToken, Cancelled, RenderSettings};
use crate::endpoint::Camera;
use crate::film::{Contribution, Frame};
use crate::radiometry::Rgb;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::transport::Tracer;

/// Edge of a square tile, pixels.
const TILE: usize = 16;
/// Paths that one task traces, where paths belong to no pixel.
const CHUNK: usize = 256;

/// What an integrator works with during one iteration.
pub struct Pass<'a> {
    frame: &'a mut Frame,
    camera: &'a Camera,
    max_bounces: u32,
    seed: u64,
    iteration: u32,
    cancel: &'a CancelToken,
}

/// Where a path leaves its contributions.
pub struct Sink<'a> {
    /// `tile[layer * TILE² + y * TILE + x]`; empty where paths belong to no pixel.
    tile: &'a mut [Rgb],
    pixel_in_tile: usize,
    n_layers: usize,
    width: usize,
    height: usize,
    splats: Vec<Splat>,
    n_refused: u64,
}

/// A contribution to a pixel that is not the path's own.
#[derive(Clone, Copy)]
struct Splat {
    pixel: u32,
    layer: u32,
    value: Rgb,
}

/// What a task hands back.
#[derive(Default)]
struct Yield {
    splats: Vec<Splat>,
    n_refused: u64,
    n_rays: u64,
}

impl Sink<'_> {
    /// Adds to the path's own pixel.
    #[inline]
    pub fn add(&mut self, contribution: Contribution) {
        let value = contribution.value * contribution.mis_weight;
        if !value.is_radiance() {
            self.n_refused += 1;
            return;
        }
        let layer = (contribution.bounce as usize).min(self.n_layers);
        self.tile[layer * TILE * TILE + self.pixel_in_tile] += value;
    }

    /// Adds to the pixel that `raster` falls in, if any; raster (0, 0) is the top left corner of pixel (0, 0).
    #[inline]
    pub fn splat(&mut self, raster: Vec2, contribution: Contribution) {
        let value = contribution.value * contribution.mis_weight;
        if !value.is_radiance() {
            self.n_refused += 1;
            return;
        }
        let (x, y) = (raster.x.floor(), raster.y.floor());
        if x < 0.0 || y < 0.0 || x >= self.width as f32 || y >= self.height as f32 {
            return;
        }
        self.splats.push(Splat {
            pixel: (y as usize * self.width + x as usize) as u32,
            layer: (contribution.bounce as usize).min(self.n_layers) as u32,
            value,
        });
    }
}

impl<'a> Pass<'a> {
    pub(super) fn new(
        frame: &'a mut Frame,
        camera: &'a Camera,
        settings: &RenderSettings,
        iteration: u32,
        cancel: &'a CancelToken,
    ) -> Self {
        Self {
            frame,
            camera,
            max_bounces: settings.max_bounces,
            seed: settings.seed,
            iteration,
            cancel,
        }
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> &'a Camera {
        self.camera
    }

    /// Terms with `k` up to and including this one are wanted.
    #[must_use]
    pub fn max_bounces(&self) -> u32 {
        self.max_bounces
    }

    /// Number of this iteration, from 0.
    #[must_use]
    pub fn iteration(&self) -> u32 {
        self.iteration
    }

    /// Pixels per row and rows.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.frame.width(), self.frame.height())
    }

    /// Runs `path` once for each pixel: its position on the raster (drawn uniformly from the
    /// pixel), a tracer, the path's random numbers, and the sink for its contributions.
    ///
    /// # Errors
    /// [`Cancelled`] when the token was; the frame is then worth nothing.
    pub fn trace_pixels<F>(&mut self, scene: &Scene, path: F) -> Result<(), Cancelled>
    where
        F: Fn(Vec2, &mut Tracer<'_>, &mut Sampler, &mut Sink<'_>) + Sync,
    {
        let (width, height) = self.size();
        let n_layers = self.frame.layers.len() - 1;
        let (n_columns, n_rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let (seed, iteration, cancel) = (self.seed, self.iteration, self.cancel);
        let planes = Mutex::new(&mut self.frame.layers);
        let yields: Vec<Yield> = (0..n_columns * n_rows)
            .into_par_iter()
            .with_max_len(1)
            .map_init(
                || vec![Rgb::BLACK; TILE * TILE * (n_layers + 1)],
                |tile, index| {
                    if cancel.is_cancelled() {
                        return Yield::default();
                    }
                    let (x0, y0) = (index % n_columns * TILE, index / n_columns * TILE);
                    let (x1, y1) = ((x0 + TILE).min(width), (y0 + TILE).min(height));
                    tile.fill(Rgb::BLACK);
                    let mut tracer = Tracer::new(scene);
                    let mut sink = Sink {
                        tile,
                        pixel_in_tile: 0,
                        n_layers,
                        width,
                        height,
                        splats: Vec::new(),
                        n_refused: 0,
                    };
                    for y in y0..y1 {
                        if cancel.is_cancelled() {
                            return Yield::default();
                        }
                        for x in x0..x1 {
                            sink.pixel_in_tile = (y - y0) * TILE + (x - x0);
                            let mut sampler = Sampler::new(seed, (y * width + x) as u64, iteration);
                            let u = sampler.next_2d();
                            let raster = Vec2::new(x as f32 + u[0], y as f32 + u[1]);
                            path(raster, &mut tracer, &mut sampler, &mut sink);
                        }
                    }
                    let (splats, n_refused) = (sink.splats, sink.n_refused);
                    let mut planes = planes.lock().unwrap_or_else(PoisonError::into_inner);
                    for (k, plane) in planes.iter_mut().enumerate() {
                        for y in y0..y1 {
                            let from = k * TILE * TILE + (y - y0) * TILE;
                            plane[y * width + x0..y * width + x1]
                                .copy_from_slice(&tile[from..from + (x1 - x0)]);
                        }
                    }
                    Yield {
                        splats,
                        n_refused,
                        n_rays: tracer.n_rays(),
                    }
                },
            )
            .collect();
        self.take(yields)
    }

    /// Runs `path` once for each of `n_paths` paths that belong to no pixel; `stream` tells
    /// their random numbers apart from those of other uses.
    ///
    /// # Errors
    /// [`Cancelled`] when the token was; the frame is then worth nothing.
    pub fn trace_paths<F>(
        &mut self,
        scene: &Scene,
        n_paths: usize,
        stream: u32,
        path: F,
    ) -> Result<(), Cancelled>
    where
        F: Fn(&mut Tracer<'_>, &mut Sampler, &mut Sink<'_>) + Sync,
    {
        let (width, height) = self.size();
        let n_layers = self.frame.layers.len() - 1;
        let (seed, iteration, cancel) = (self.seed, self.iteration, self.cancel);
        let yields: Vec<Yield> = (0..n_paths.div_ceil(CHUNK))
            .into_par_iter()
            .with_max_len(1)
            .map(|chunk| {
                if cancel.is_cancelled() {
                    return Yield::default();
                }
                let mut tracer = Tracer::new(scene);
                let mut sink = Sink {
                    tile: &mut [],
                    pixel_in_tile: 0,
                    n_layers,
                    width,
                    height,
                    splats: Vec::new(),
                    n_refused: 0,
                };
                for index in chunk * CHUNK..((chunk + 1) * CHUNK).min(n_paths) {
                    let key = (u64::from(stream) + 1) << 40 | index as u64;
                    let mut sampler = Sampler::new(seed, key, iteration);
                    path(&mut tracer, &mut sampler, &mut sink);
                }
                Yield {
                    splats: sink.splats,
                    n_refused: sink.n_refused,
                    n_rays: tracer.n_rays(),
                }
            })
            .collect();
        self.take(yields)
    }

    /// Adds up what the tasks handed back, in their order.
    fn take(&mut self, yields: Vec<Yield>) -> Result<(), Cancelled> {
        if self.cancel.is_cancelled() {
            return Err(Cancelled);
        }
        for part in yields {
            for splat in part.splats {
                self.frame.layers[splat.layer as usize][splat.pixel as usize] += splat.value;
            }
            self.frame.n_refused += part.n_refused;
            self.frame.n_rays += part.n_rays;
        }
        Ok(())
    }
}
