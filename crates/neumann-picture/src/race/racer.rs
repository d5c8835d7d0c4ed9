//! A method in the race: what it has rendered, and the time that this took.

use std::collections::BTreeMap;
use std::sync::Arc;

use cpu_time::ThreadTime;
use neumann_core::film::Film;
use neumann_core::pass::{CancelToken, Cancelled};
use neumann_core::render::{RenderSettings, Renderer, WorkerPool};
use neumann_core::scene::Scene;

use super::Point;
use crate::compare::compare;
use crate::tone::Display;
use crate::{Image, PictureError};

/// A method in the race.
pub struct Racer {
    /// What it is called.
    pub name: String,
    /// How far it had come when it was looked at.
    pub curve: Vec<Point>,
    renderer: Renderer,
    pool: WorkerPool,
    film: Film,
    seconds: f64,
}

impl Racer {
    /// Gets ready to render.
    #[must_use]
    pub fn new(
        name: &str,
        scene: &Arc<Scene>,
        settings: RenderSettings,
        pool: &WorkerPool,
    ) -> Self {
        let film = Film::new(settings.width, settings.height, settings.n_layers);
        Self::going_on(name, scene, settings, pool, (film, 0.0))
    }

    /// Gets ready to go on with a film, which took so many seconds.
    #[must_use]
    pub fn going_on(
        name: &str,
        scene: &Arc<Scene>,
        settings: RenderSettings,
        pool: &WorkerPool,
        (film, seconds): (Film, f64),
    ) -> Self {
        let first = film.n_iterations();
        Self {
            name: name.to_owned(),
            curve: Vec::new(),
            renderer: Renderer::new(Arc::clone(scene), settings, pool.clone(), first),
            pool: pool.clone(),
            film,
            seconds,
        }
    }

    /// What it renders.
    #[must_use]
    pub fn settings(&self) -> &RenderSettings {
        self.renderer.settings()
    }

    /// What it has rendered.
    #[must_use]
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// Processor time that this took.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Iterations so far.
    #[must_use]
    pub fn n_iterations(&self) -> u32 {
        self.film.n_iterations()
    }

    /// Whether one more iteration brings it nearer to a time than it is.
    #[must_use]
    pub fn has_time_for_another(&self, seconds: f64) -> bool {
        let n = self.film.n_iterations();
        n == 0 || self.seconds + 0.5 * self.seconds / f64::from(n) < seconds
    }

    /// Renders another iteration with all threads.
    ///
    /// # Errors
    /// [`Cancelled`] if the token was; neither the iteration nor its time is counted.
    pub fn iterate(&mut self, cancel: &CancelToken) -> Result<(), Cancelled> {
        let before = processor_time(&self.pool);
        let (renderer, film) = (&mut self.renderer, &mut self.film);
        self.pool.run(|| {
            let iteration = renderer.iterate_after(film, cancel)?;
            iteration.add_to(film);
            Ok(())
        })?;
        self.seconds += processor_time(&self.pool) - before;
        Ok(())
    }

    /// What it has rendered, as a picture.
    #[must_use]
    pub fn image(&self) -> Image {
        Image {
            width: self.film.width(),
            height: self.film.height(),
            pixels: self.film.total(),
            layers: BTreeMap::new(),
        }
    }

    /// How far it has come; `display` says how the pictures would be shown, for FLIP.
    ///
    /// # Errors
    /// If the reference has another size.
    pub fn judge(&self, reference: &Image, display: &Display) -> Result<Point, PictureError> {
        let image = self.image();
        let comparison = self.pool.run(|| compare(&image, reference, display))?;
        Ok(Point {
            seconds: self.seconds,
            n_iterations: self.film.n_iterations(),
            comparison,
        })
    }
}

/// Who is next: of those that have time left, the one that has had the least.
#[must_use]
pub fn next_in_turn(racers: &[Racer], time: f64) -> Option<usize> {
    let waiting = racers.iter().enumerate();
    waiting
        .filter(|(_, racer)| racer.has_time_for_another(time))
        .min_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds))
        .map(|(i, _)| i)
}

/// Processor time of the threads of a pool, seconds. What else the process does, such as drawing
/// a window, is no part of it.
#[must_use]
pub fn processor_time(pool: &WorkerPool) -> f64 {
    let times = pool.on_each(|| ThreadTime::now().as_duration());
    times.iter().map(std::time::Duration::as_secs_f64).sum()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use neumann_core::pass::CancelToken;
    use neumann_core::render::{RenderSettings, WorkerPool};
    use neumann_core::scene::Scene;
    use neumann_core::scene::builtin::builtin;

    use super::{Racer, next_in_turn};
    use crate::race::Entrant;

    fn racers(names: &[&str]) -> Vec<Racer> {
        let description = builtin("cornell").unwrap().load().unwrap();
        let scene = Arc::new(Scene::build(&description));
        let common = RenderSettings::new(scene.cameras()[0].clone(), 48, 48);
        let pool = WorkerPool::new(Some(2), || {}).unwrap();
        let racer = |name: &&str| {
            let entrant = Entrant::parse(name).unwrap();
            Racer::new(name, &scene, entrant.settings(&common), &pool)
        };
        names.iter().map(racer).collect()
    }

    /// More than any iteration of it took.
    fn longest(racer: &Racer) -> f64 {
        let mean = racer.seconds() / f64::from(racer.n_iterations());
        4.0 * mean + 0.02
    }

    #[test]
    fn racers_have_the_same_time_but_for_an_iteration() {
        // The second one's iterations take many times as long.
        let mut racers = racers(&["pt-bsdf", "vcm", "pt-mis"]);
        let nobody = CancelToken::default();
        let time = 0.3;
        while let Some(next) = next_in_turn(&racers, time) {
            racers[next].iterate(&nobody).unwrap();
            // At no time is one ahead of another by more than it did last.
            let seconds = || racers.iter().map(Racer::seconds);
            let least = seconds().fold(f64::INFINITY, f64::min);
            let before = racers[next].seconds() - longest(&racers[next]);
            assert!(before <= least, "{:?}", seconds().collect::<Vec<_>>());
        }
        for racer in &racers {
            assert!(racer.n_iterations() > 0);
            let of_one = racer.seconds() / f64::from(racer.n_iterations());
            let off = (racer.seconds() - time).abs();
            let (name, n) = (&racer.name, racer.n_iterations());
            // Iterations are not all of one length.
            assert!(off <= 1.5 * of_one + 0.03 * time, "{name}: {off} s, {n}");
        }
        assert!(racers[0].n_iterations() > racers[1].n_iterations());
    }

    #[test]
    fn an_iteration_that_is_cut_short_counts_nothing() {
        let mut racers = racers(&["pt-mis"]);
        let cancel = CancelToken::default();
        racers[0].iterate(&cancel).unwrap();
        let before = (racers[0].seconds(), racers[0].image());
        cancel.cancel();
        assert!(racers[0].iterate(&cancel).is_err());
        assert_eq!((racers[0].seconds(), racers[0].image()), before);
    }
}
