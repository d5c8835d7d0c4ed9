//! The paths of the pixels, tile by tile.
//!
//! A tile's values go where they belong in the frame, or, if the pass was given a film, into the
//! film as soon as they are known.

use std::cell::Cell;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::sink::{PixelPlace, PixelSink, Sink, Yield};
use super::{Cancelled, Pass, Pixels, Plan};
use crate::film::{Contribution, FilmTile, LitLayers, Strategy, TileBounds};
use crate::radiometry::Rgb;
use crate::sampling::TileNumbers;
use crate::scene::Scene;
use crate::transport::Tracer;

thread_local! {
    /// Room for the tile that the thread is tracing.
    static VALUES_OF_TILE: Cell<Vec<Rgb>> = const { Cell::new(Vec::new()) };
}

/// Where the values of a tile go.
enum Target<'t> {
    Frame(&'t mut [Rgb], &'t mut LitLayers),
    Film(FilmTile<'t>),
}

impl Pass<'_> {
    /// Runs `paths` for each tile; where nothing stands before `background`, that is all there is.
    pub(super) fn trace_tiles<'s, R, M, F>(
        &mut self,
        scene: &'s Scene,
        room: M,
        paths: F,
        background: Option<Rgb>,
    ) -> Result<(), Cancelled>
    where
        R: Send,
        M: Fn() -> R + Sync + Send,
        F: for<'t> Fn(&mut R, Pixels<'t>, &mut Tracer<'s>, &mut Sink<'_>) + Sync,
    {
        let width = self.frame.width();
        let (grid, per_tile) = (self.frame.grid(), self.frame.values_per_tile());
        let keys = (self.seed, self.iteration, self.max_bounces);
        let (samples, n_splits) = (self.samples.clone(), self.n_splits);
        self.frame.n_samples = samples.total(grid);
        let (cancel, coverage) = (self.cancel, self.coverage);
        let shape = self.sink_shape();
        let plan = self.plan.clone();
        let background = background.filter(|_| plan.is_none());
        let trace = |room: &mut R, number: usize, own: PixelSink<'_>| {
            let (trail, observer) = plan.as_ref().map(|plan| plan.observer(false)).unzip();
            let mut tracer = Tracer::new(scene).observed(trail);
            let mut sink = Sink::new(own.observed(observer));
            let bounds = grid.bounds(number);
            if let Some(radiance) = background
                && !coverage.is_covered(number)
            {
                fill(bounds, radiance, &mut sink);
                return sink.into_yield(0);
            }
            let n_samples = samples.of_tile(number);
            sink.share_among(n_samples);
            let numbers: Vec<TileNumbers> = (0..n_samples)
                .flat_map(|sample| samples.numbers((number, bounds), keys, sample, n_splits))
                .collect();
            let numbers = (numbers.as_slice(), usize::from(n_splits));
            let only = plan.as_ref().and_then(Plan::only);
            let pixels = Pixels::new(numbers, bounds, width, cancel).only(only);
            paths(room, pixels, &mut tracer, &mut sink);
            sink.into_yield(tracer.n_rays())
        };
        let rounds = self.rounds(grid.n_tiles());
        // As many as there are threads: each tile takes one that another has left.
        let rooms = Mutex::new(Vec::new());
        let rooms = || rooms.lock().unwrap_or_else(PoisonError::into_inner);
        for round in &rounds {
            let (values, lit) = self.frame.tiles();
            let tiles = values[round.start * per_tile..round.end * per_tile]
                .chunks_exact_mut(per_tile)
                .zip(&mut lit[round.clone()]);
            let targets: Vec<Target<'_>> = match &mut self.film {
                Some(film) => film.tiles(round.clone()).map(Target::Film).collect(),
                None => tiles.map(|(tile, lit)| Target::Frame(tile, lit)).collect(),
            };
            let yields: Vec<Yield> = targets
                .into_par_iter()
                .enumerate()
                .with_max_len(1)
                .map(|(i, target)| {
                    if cancel.is_cancelled() {
                        return Yield::default();
                    }
                    let number = round.start + i;
                    let taken = rooms().pop();
                    let mut room = taken.unwrap_or_else(&room);
                    let part = match target {
                        Target::Frame(tile, lit) => {
                            trace(&mut room, number, PixelSink::new(tile, lit, shape))
                        }
                        Target::Film(tile) => {
                            // In memory that stays in the cache.
                            let mut values = VALUES_OF_TILE.take();
                            values.resize(per_tile, Rgb::BLACK);
                            let mut lit = LitLayers::default();
                            let sink = PixelSink::new(&mut values, &mut lit, shape);
                            let part = trace(&mut room, number, sink);
                            tile.take(&values, lit);
                            VALUES_OF_TILE.set(values);
                            part
                        }
                    };
                    rooms().push(room);
                    part
                })
                .collect();
            for (tile, part) in round.clone().zip(&yields) {
                self.frame.n_rays_of_tiles[tile] = part.n_rays as u32;
                let is_traced = background.is_none() || coverage.is_covered(tile);
                let n_samples = if is_traced { samples.of_tile(tile) } else { 0 };
                self.frame.n_samples_of_tiles[tile] = n_samples;
            }
            self.take(yields)?;
        }
        Ok(())
    }
}

/// Gives every pixel of a tile what comes from infinitely far away.
fn fill(TileBounds { start, end }: TileBounds, radiance: Rgb, sink: &mut PixelSink<'_>) {
    if radiance.is_black() {
        return;
    }
    for y in start[1]..end[1] {
        for x in start[0]..end[0] {
            sink.start_pixel(PixelPlace::new(x, y));
            sink.add(Contribution {
                value: radiance,
                mis_weight: 1.0,
                bounce: 0,
                strategy: Strategy::hit(2),
            });
        }
    }
}
