//! Renders whose error is known.
//!
//! Iterations of one seed share a low-discrepancy sequence, so they are not independent. A
//! [`Batches`] is a handful of renders that differ in their seed alone; the spread of their
//! means is the honest standard error.

use std::sync::{Arc, LazyLock};

use neumann_core::film::Film;
use neumann_core::integrator::{Method, ParameterValues, Value};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{CancelToken, RenderSettings, Renderer, WorkerPool};
use neumann_core::scene::Scene;
use neumann_core::scene::description::CameraDescription;

use crate::statistics::Estimate;

static POOL: LazyLock<Option<WorkerPool>> = LazyLock::new(|| WorkerPool::new(None, || ()).ok());

/// The pool that all tests share.
///
/// # Panics
/// If the operating system gives no threads.
#[must_use]
pub fn pool() -> WorkerPool {
    let Some(pool) = &*POOL else {
        panic!("the operating system gives no threads");
    };
    pool.clone()
}

/// A pool of so many threads.
///
/// # Panics
/// If the operating system gives no threads.
#[must_use]
pub fn pool_of(n_threads: usize) -> WorkerPool {
    match WorkerPool::new(Some(n_threads), || ()) {
        Ok(pool) => pool,
        Err(error) => panic!("no {n_threads} threads: {error}"),
    }
}

/// A scene and how to render it.
#[derive(Clone)]
pub struct Setup {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The settings.
    pub settings: RenderSettings,
}

impl Setup {
    /// The first camera of a scene, by the default method.
    #[must_use]
    pub fn new(scene: &Arc<Scene>, width: usize, height: usize) -> Self {
        Self::seen_by(scene, scene.cameras()[0].clone(), width, height)
    }

    /// Another camera.
    #[must_use]
    pub fn seen_by(
        scene: &Arc<Scene>,
        camera: CameraDescription,
        width: usize,
        height: usize,
    ) -> Self {
        Self {
            scene: Arc::clone(scene),
            settings: RenderSettings::new(camera, width, height),
        }
    }

    /// The same by another method, with its default parameters.
    #[must_use]
    pub fn by(mut self, method: &'static Method) -> Self {
        self.settings.method = method;
        self.settings.values = ParameterValues::defaults(method.parameters);
        self
    }

    /// The same with photon maps of many paths, a new one for each iteration, where the method has
    /// one.
    #[must_use]
    pub fn with_many_photons(mut self) -> Self {
        for (name, value) in [("paths", Value::Real(16.0)), ("map", Value::Choice(1))] {
            if self.settings.values.value(name).is_some() {
                self.settings.values.put(name, value);
            }
        }
        self
    }

    /// The same up to another bounce.
    #[must_use]
    pub fn up_to(mut self, max_bounces: u32) -> Self {
        self.settings.max_bounces = max_bounces;
        self
    }

    /// The same with another seed.
    #[must_use]
    pub fn seeded(mut self, seed: u64) -> Self {
        self.settings.seed = seed;
        self
    }

    /// Iterations `first .. first + n` on the shared pool.
    #[must_use]
    pub fn film(&self, first: u32, n: u32) -> Film {
        self.film_on(pool(), first, n)
    }

    /// Iterations `first .. first + n` on a pool.
    ///
    /// # Panics
    /// Never: nobody cancels.
    #[must_use]
    pub fn film_on(&self, pool: WorkerPool, first: u32, n: u32) -> Film {
        let s = &self.settings;
        let mut film = Film::new(s.width, s.height, s.n_layers);
        let mut renderer = Renderer::new(Arc::clone(&self.scene), s.clone(), pool, first);
        let nobody = CancelToken::default();
        for _ in 0..n {
            match renderer.iterate_after(&film, &nobody) {
                Ok(iteration) => iteration.add_to(&mut film),
                Err(error) => panic!("nobody cancelled: {error}"),
            }
        }
        film
    }

    /// Independent films of `n_iterations` each; `stream` keeps their seeds apart from others'.
    #[must_use]
    pub fn batches(&self, n_batches: u32, n_iterations: u32, stream: u64) -> Batches {
        let films = (0..n_batches)
            .map(|batch| {
                let seed = stream << 32 | u64::from(batch);
                self.clone().seeded(seed).film(0, n_iterations)
            })
            .collect();
        Batches { films }
    }
}

/// Films that differ in their seed alone.
pub struct Batches {
    /// The films.
    pub films: Vec<Film>,
}

/// Part of a film: columns and rows.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Columns from, to.
    pub x: [usize; 2],
    /// Rows from, to.
    pub y: [usize; 2],
}

impl Block {
    /// The film cut into `n × m` blocks.
    #[must_use]
    pub fn grid(film: &Film, n: usize, m: usize) -> Vec<Self> {
        let (w, h) = (film.width(), film.height());
        (0..n * m)
            .map(|i| {
                let (column, row) = (i % n, i / n);
                Self {
                    x: [column * w / n, (column + 1) * w / n],
                    y: [row * h / m, (row + 1) * h / m],
                }
            })
            .collect()
    }

    /// Mean of a layer over the block, by channel.
    #[must_use]
    pub fn mean(&self, film: &Film, layer: usize) -> [f64; 3] {
        let w = film.width();
        let mut sum = [0f64; 3];
        for y in self.y[0]..self.y[1] {
            for x in self.x[0]..self.x[1] {
                for (s, c) in sum
                    .iter_mut()
                    .zip(film.layer_at(layer, y * w + x).to_array())
                {
                    *s += f64::from(c);
                }
            }
        }
        let n = (self.x[1] - self.x[0]) * (self.y[1] - self.y[0]);
        sum.map(|s| s / n as f64)
    }
}

impl Batches {
    /// Mean of a layer over the image, by channel.
    #[must_use]
    pub fn layer(&self, layer: usize) -> [Estimate; 3] {
        self.estimates(|film| film.layer_means()[layer])
    }

    /// Mean of a layer over a block, by channel.
    #[must_use]
    pub fn block(&self, block: Block, layer: usize) -> [Estimate; 3] {
        self.estimates(|film| block.mean(film, layer))
    }

    /// Contributions refused, over all films.
    #[must_use]
    pub fn n_refused(&self) -> u64 {
        self.films.iter().map(Film::n_refused).sum()
    }

    fn estimates(&self, value: impl Fn(&Film) -> [f64; 3]) -> [Estimate; 3] {
        let values: Vec<[f64; 3]> = self.films.iter().map(value).collect();
        [0, 1, 2].map(|channel| {
            let channel: Vec<f64> = values.iter().map(|v| v[channel]).collect();
            Estimate::of(&channel)
        })
    }
}

/// True if every pixel of a layer is exactly black.
#[must_use]
pub fn is_black(layer: &[Rgb]) -> bool {
    layer.iter().all(|value| *value == Rgb::BLACK)
}
