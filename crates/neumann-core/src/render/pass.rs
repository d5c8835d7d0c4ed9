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
use crate::film::techniques::{Record, RecordShape, TechniqueFilm};
use crate::film::{Contribution, Frame, PhotonReport};
use crate::radiometry::Rgb;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::transport::Tracer;

/// Edge of a square tile, pixels.
const TILE: usize = 16;
/// Paths that one task traces, where paths belong to no pixel.
const CHUNK: usize = 256;
/// Tasks after which splats are added up, so that they never take much memory: as many paths as a
/// film of 1024×1024 has pixels,
const ROUND: usize = 4096;
/// and fewer while techniques are recorded.
const RECORDING_ROUND: usize = 256;

/// What an integrator works with during one iteration.
pub struct Pass<'a> {
    frame: &'a mut Frame,
    camera: &'a Camera,
    max_bounces: u32,
    seed: u64,
    iteration: u32,
    cancel: &'a CancelToken,
    techniques: Option<&'a mut TechniqueFilm>,
}

/// One path's place on the film.
#[derive(Clone, Copy, Debug)]
pub struct PixelSample {
    /// Its position on the raster, drawn uniformly from the pixel.
    pub raster: Vec2,
    /// `y * width + x` of the pixel.
    pub index: usize,
}

/// The random numbers of light paths: one low-discrepancy sequence runs through all of an iteration's
/// paths and on through the next iteration's, so that together they cover the lights evenly.
#[derive(Clone, Copy, Debug)]
pub struct LightNumbers {
    seed: u64,
    first: u64,
}

impl LightNumbers {
    /// The numbers of a light path.
    #[inline]
    #[must_use]
    pub fn path(&self, index: usize) -> Sampler {
        Sampler::of_sequence(self.seed, self.first + index as u64)
    }
}

/// What light paths left behind, path by path.
#[derive(Clone, Debug)]
pub struct Collected<T> {
    /// Everything, in the order of the paths.
    pub items: Vec<T>,
    /// `ends[path]`: index after the path's last item.
    ends: Vec<u32>,
}

impl<T> Default for Collected<T> {
    fn default() -> Self {
        Self {
            items: Vec::new(),
            ends: Vec::new(),
        }
    }
}

impl<T> Collected<T> {
    /// What one path left.
    #[inline]
    #[must_use]
    pub fn of_path(&self, path: usize) -> &[T] {
        let start = if path == 0 { 0 } else { self.ends[path - 1] };
        &self.items[start as usize..self.ends[path] as usize]
    }

    /// Number of paths.
    #[must_use]
    pub fn n_paths(&self) -> usize {
        self.ends.len()
    }
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
    /// The pixel of the film that the path belongs to.
    pixel: (u32, u32),
    recording: Option<RecordShape>,
    records: Vec<Record>,
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
    records: Vec<Record>,
    n_refused: u64,
    n_rays: u64,
}

impl<'a> Sink<'a> {
    fn new(
        tile: &'a mut [Rgb],
        n_layers: usize,
        (width, height): (usize, usize),
        recording: Option<RecordShape>,
    ) -> Self {
        Self {
            tile,
            pixel_in_tile: 0,
            n_layers,
            width,
            height,
            splats: Vec::new(),
            n_refused: 0,
            pixel: (0, 0),
            recording,
            records: Vec::new(),
        }
    }

    fn into_yield(self, n_rays: u64) -> Yield {
        Yield {
            splats: self.splats,
            records: self.records,
            n_refused: self.n_refused,
            n_rays,
        }
    }

    /// Keeps a contribution apart by its technique, if that is asked for.
    #[inline]
    fn record(&mut self, pixel: (u32, u32), contribution: &Contribution) {
        if let Some(shape) = self.recording {
            self.records.push(shape.record(pixel, contribution));
        }
    }

    /// Adds to the path's own pixel.
    #[inline]
    pub fn add(&mut self, contribution: Contribution) {
        let value = contribution.value * contribution.mis_weight;
        if !value.is_radiance() {
            self.n_refused += 1;
            return;
        }
        self.record(self.pixel, &contribution);
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
        self.record((x as u32, y as u32), &contribution);
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
        techniques: Option<&'a mut TechniqueFilm>,
    ) -> Self {
        Self {
            frame,
            camera,
            max_bounces: settings.max_bounces,
            seed: settings.seed,
            iteration,
            cancel,
            techniques,
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

    /// Number of pixels.
    #[must_use]
    pub fn n_pixels(&self) -> usize {
        self.frame.width() * self.frame.height()
    }

    /// The random numbers of this iteration's light paths, `n_paths` of them.
    #[must_use]
    pub fn light_numbers(&self, n_paths: usize) -> LightNumbers {
        LightNumbers {
            seed: self.seed,
            first: u64::from(self.iteration) * n_paths as u64,
        }
    }

    /// Random numbers of light paths that are the same in every iteration.
    #[must_use]
    pub fn fixed_light_numbers(&self) -> LightNumbers {
        LightNumbers {
            seed: self.seed,
            first: 0,
        }
    }

    /// Tells what the iteration's photons were like, for whoever looks at the frame.
    pub fn report(&mut self, photons: PhotonReport) {
        self.frame.photons = Some(photons);
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
        self.trace_pixels_with(
            scene,
            || (),
            |(), sample, tracer, sampler, sink| path(sample.raster, tracer, sampler, sink),
        )
    }

    /// As [`Self::trace_pixels`], with room that each task makes once and every path of it may use.
    ///
    /// # Errors
    /// [`Cancelled`] when the token was; the frame is then worth nothing.
    pub fn trace_pixels_with<'s, R, M, F>(
        &mut self,
        scene: &'s Scene,
        room: M,
        path: F,
    ) -> Result<(), Cancelled>
    where
        M: Fn() -> R + Sync + Send,
        F: Fn(&mut R, PixelSample, &mut Tracer<'s>, &mut Sampler, &mut Sink<'_>) + Sync,
    {
        let (width, height) = self.size();
        let n_layers = self.frame.layers.len() - 1;
        let (n_columns, n_rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let (seed, iteration, cancel) = (self.seed, self.iteration, self.cancel);
        let recording = self.recording();
        for round in rounds(n_columns * n_rows, recording) {
            let planes = Mutex::new(&mut self.frame.layers);
            let yields: Vec<Yield> = round
                .into_par_iter()
                .with_max_len(1)
                .map_init(
                    || (vec![Rgb::BLACK; TILE * TILE * (n_layers + 1)], room()),
                    |(tile, room), index| {
                        if cancel.is_cancelled() {
                            return Yield::default();
                        }
                        let (x0, y0) = (index % n_columns * TILE, index / n_columns * TILE);
                        let (x1, y1) = ((x0 + TILE).min(width), (y0 + TILE).min(height));
                        tile.fill(Rgb::BLACK);
                        let mut tracer = Tracer::new(scene);
                        let mut sink = Sink::new(tile, n_layers, (width, height), recording);
                        for y in y0..y1 {
                            if cancel.is_cancelled() {
                                return Yield::default();
                            }
                            for x in x0..x1 {
                                sink.pixel_in_tile = (y - y0) * TILE + (x - x0);
                                sink.pixel = (x as u32, y as u32);
                                let index = y * width + x;
                                let mut sampler = Sampler::new(seed, index as u64, iteration);
                                let u = sampler.next_2d();
                                let raster = Vec2::new(x as f32 + u[0], y as f32 + u[1]);
                                let sample = PixelSample { raster, index };
                                path(room, sample, &mut tracer, &mut sampler, &mut sink);
                            }
                        }
                        let part = Yield {
                            splats: std::mem::take(&mut sink.splats),
                            records: std::mem::take(&mut sink.records),
                            n_refused: sink.n_refused,
                            n_rays: tracer.n_rays(),
                        };
                        let mut planes = planes.lock().unwrap_or_else(PoisonError::into_inner);
                        for (k, plane) in planes.iter_mut().enumerate() {
                            for y in y0..y1 {
                                let from = k * TILE * TILE + (y - y0) * TILE;
                                let row = &tile[from..from + (x1 - x0)];
                                let target = &mut plane[y * width + x0..y * width + x1];
                                // Splats of rounds before are there already.
                                for (sum, value) in target.iter_mut().zip(row) {
                                    *sum += *value;
                                }
                            }
                        }
                        part
                    },
                )
                .collect();
            self.take(&yields)?;
        }
        Ok(())
    }

    /// Runs `path` once for each of `n_paths` light paths, which belong to no pixel: its number, a tracer, its random
    /// numbers, and the sink; collects what each pushes to the vector it is given.
    ///
    /// # Errors
    /// [`Cancelled`] when the token was; the frame is then worth nothing.
    pub fn trace_light_paths<'s, T, F>(
        &mut self,
        scene: &'s Scene,
        n_paths: usize,
        numbers: LightNumbers,
        path: F,
    ) -> Result<Collected<T>, Cancelled>
    where
        T: Copy + Send + Sync,
        F: Fn(usize, &mut Tracer<'s>, &mut Sampler, &mut Sink<'_>, &mut Vec<T>) + Sync,
    {
        let size = self.size();
        let n_layers = self.frame.layers.len() - 1;
        let cancel = self.cancel;
        let recording = self.recording();
        let mut collected = Collected::default();
        for round in rounds(n_paths.div_ceil(CHUNK), recording) {
            let (yields, parts): (Vec<Yield>, Vec<Collected<T>>) = round
                .into_par_iter()
                .with_max_len(1)
                .map(|chunk| {
                    let mut part = Collected::default();
                    if cancel.is_cancelled() {
                        return (Yield::default(), part);
                    }
                    let mut tracer = Tracer::new(scene);
                    let mut sink = Sink::new(&mut [], n_layers, size, recording);
                    for index in chunk * CHUNK..((chunk + 1) * CHUNK).min(n_paths) {
                        let mut sampler = numbers.path(index);
                        path(index, &mut tracer, &mut sampler, &mut sink, &mut part.items);
                        part.ends.push(part.items.len() as u32);
                    }
                    (sink.into_yield(tracer.n_rays()), part)
                })
                .unzip();
            self.take(&yields)?;
            for part in parts {
                let offset = collected.items.len() as u32;
                collected.items.extend_from_slice(&part.items);
                collected
                    .ends
                    .extend(part.ends.iter().map(|end| end + offset));
            }
        }
        Ok(collected)
    }

    fn recording(&self) -> Option<RecordShape> {
        self.techniques.as_ref().map(|t| t.shape())
    }

    /// Adds up what the tasks handed back, in their order.
    fn take(&mut self, yields: &[Yield]) -> Result<(), Cancelled> {
        if self.cancel.is_cancelled() {
            return Err(Cancelled);
        }
        for part in yields {
            for splat in &part.splats {
                self.frame.layers[splat.layer as usize][splat.pixel as usize] += splat.value;
            }
            if let Some(techniques) = &mut self.techniques {
                techniques.take(&part.records);
            }
            self.frame.n_refused += part.n_refused;
            self.frame.n_rays += part.n_rays;
        }
        Ok(())
    }
}

/// Cuts tasks into rounds.
fn rounds(
    n_tasks: usize,
    recording: Option<RecordShape>,
) -> impl Iterator<Item = std::ops::Range<usize>> {
    let length = if recording.is_some() {
        RECORDING_ROUND
    } else {
        ROUND
    };
    (0..n_tasks.div_ceil(length)).map(move |i| i * length..((i + 1) * length).min(n_tasks))
}
