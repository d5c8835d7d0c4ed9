//! A method that is held against another one: the batches that it renders.

use std::sync::Arc;

use neumann_core::film::Film;
use neumann_core::pass::{CancelToken, Cancelled};
use neumann_core::render::{RenderSettings, Renderer, WorkerPool};
use neumann_core::scene::Scene;

use super::Batches;
use crate::race::{Entrant, processor_time};

/// One of two methods, with what it has rendered.
#[derive(Clone, Debug)]
pub struct Side {
    /// What it is called.
    pub name: String,
    /// What its batches have in common; each has a seed of its own.
    pub settings: RenderSettings,
    /// What it has rendered.
    pub batches: Batches,
    /// Iterations of each batch, once that is known.
    pub n_iterations: u32,
    /// Processor time of all of them.
    pub seconds: f64,
}

/// How long a batch is.
#[derive(Clone, Copy, Debug)]
pub enum Length {
    /// So many iterations.
    Iterations(u32),
    /// As many as take so much processor time, seconds.
    Seconds(f64),
}

/// The seed of a batch; batches of different seeds of the whole are different, too.
#[must_use]
pub fn seed(whole: u64, stream: u64) -> u64 {
    whole
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(stream)
}

/// Renders one batch. Yields it with the processor time that it took.
///
/// # Errors
/// [`Cancelled`] if the token was.
pub fn batch(
    scene: &Arc<Scene>,
    settings: RenderSettings,
    length: Length,
    pool: &WorkerPool,
    cancel: &CancelToken,
) -> Result<(Film, f64), Cancelled> {
    let start = processor_time(pool);
    let mut film = Film::new(settings.width, settings.height, settings.n_layers);
    let mut renderer = Renderer::new(Arc::clone(scene), settings, pool.clone(), 0);
    loop {
        let iteration = renderer.iterate_after(&film, cancel)?;
        pool.run(|| iteration.add_to(&mut film));
        let n = film.n_iterations();
        let is_over = match length {
            Length::Iterations(wanted) => n >= wanted,
            // One more would end further from it.
            Length::Seconds(wanted) => {
                let seconds = processor_time(pool) - start;
                seconds * (1.0 + 0.5 / f64::from(n)) >= wanted
            }
        };
        if is_over {
            return Ok((film, processor_time(pool) - start));
        }
    }
}

impl Side {
    /// A method that has rendered nothing yet; everything but the method is as in `common`.
    #[must_use]
    pub fn new(entrant: Entrant, common: &RenderSettings) -> Self {
        Self {
            batches: Batches::new(common.width, common.height, common.n_layers),
            settings: entrant.settings(common),
            name: entrant.name,
            n_iterations: 0,
            seconds: 0.0,
        }
    }

    /// What renders its batch with a seed.
    #[must_use]
    pub fn with_seed(&self, seed: u64) -> RenderSettings {
        RenderSettings {
            seed,
            ..self.settings.clone()
        }
    }

    /// Takes in a batch.
    pub fn take(&mut self, (film, seconds): &(Film, f64)) {
        self.seconds += seconds;
        self.n_iterations = film.n_iterations();
        self.batches.take(film);
    }
}
