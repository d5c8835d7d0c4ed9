//! What has been judged of one method. Pictures of earlier times are kept, as far as there is room,
//! and judged again when the reference has become better.

use std::sync::Arc;

use neumann_core::render::WorkerPool;
use neumann_picture::Image;
use neumann_picture::compare::compare;
use neumann_picture::race::{Point, Racer};
use neumann_picture::tone::Display;

/// The points of a curve are so far apart in time, at least.
const STEP: f64 = std::f64::consts::SQRT_2;
/// Room for pictures of earlier times, of one method.
const ROOM: usize = 64 << 20;

/// What pictures are judged by: the reference, and how both are shown.
pub(super) type By = (Arc<Image>, Display);

/// What has been judged of one method.
#[derive(Default)]
pub(super) struct Judged {
    earlier: Vec<Sample>,
    latest: Option<Sample>,
}

/// A picture with its errors.
struct Sample {
    point: Point,
    /// `None` where there was no more room for it.
    image: Option<Arc<Image>>,
    /// Iterations of the reference, and how the pictures were shown.
    by: (u32, Display),
}

impl Judged {
    /// True if nothing has been judged yet.
    pub(super) fn is_new(&self) -> bool {
        self.latest.is_none()
    }

    /// Judges what a racer has made, unless that has been done.
    pub(super) fn judge(&mut self, racer: &Racer, (by, display): &By, n: u32) {
        let is_same = |s: &&Sample| s.point.n_iterations == racer.n_iterations();
        let known = self.latest.as_ref().filter(is_same);
        if known.is_some_and(|s| s.by == (n, *display)) {
            return;
        }
        let image = known.and_then(|s| s.image.clone());
        let Ok(point) = racer.judge(by, display) else {
            return;
        };
        let sample = Sample {
            point,
            image: Some(image.unwrap_or_else(|| Arc::new(racer.image()))),
            by: (n, *display),
        };
        let Some(former) = self.latest.replace(sample) else {
            return;
        };
        let kept = self.earlier.last().map_or(0.0, |s| s.point.seconds);
        let is_further = former.point.n_iterations < racer.n_iterations();
        if is_further && former.point.seconds >= STEP * kept {
            self.earlier.push(former);
            self.make_room();
        }
    }

    /// Forgets the oldest pictures, not their errors, where they take too much room.
    fn make_room(&mut self) {
        let mut room = ROOM;
        for sample in self.earlier.iter_mut().rev() {
            let bytes = sample.image.as_ref().map_or(0, |i| 12 * i.pixels.len());
            match room.checked_sub(bytes) {
                Some(rest) => room = rest,
                None => sample.image = None,
            }
        }
    }

    /// Judges one earlier picture again, if the reference has twice the iterations that it had, or
    /// pictures are shown in another way.
    pub(super) fn judge_again(&mut self, pool: &WorkerPool, (by, display): &By, n: u32) {
        let is_stale = |s: &Sample| s.by.0.saturating_mul(2) <= n || s.by.1 != *display;
        let mut stale = self.earlier.iter_mut().rev().filter(|s| is_stale(s));
        let Some((sample, image)) = stale.find_map(|s| s.image.clone().map(|image| (s, image)))
        else {
            return;
        };
        if let Ok(comparison) = pool.run(|| compare(&image, by, display)) {
            sample.point.comparison = comparison;
            sample.by = (n, *display);
        }
    }

    /// Errors over time.
    pub(super) fn curve(&self) -> Vec<Point> {
        let samples = self.earlier.iter().chain(&self.latest);
        samples.map(|sample| sample.point.clone()).collect()
    }

    /// The picture that was judged last.
    pub(super) fn image(&self) -> Option<Arc<Image>> {
        self.latest.as_ref()?.image.clone()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use neumann_core::render::{CancelToken, RenderSettings, WorkerPool};
    use neumann_core::scene::Scene;
    use neumann_core::scene::builtin::builtin;
    use neumann_picture::Image;
    use neumann_picture::compare::compare;
    use neumann_picture::race::Racer;
    use neumann_picture::tone::Display;

    use super::{Judged, Sample};

    /// A racer that has rendered nothing, and its threads.
    fn racer() -> (Racer, WorkerPool) {
        let description = builtin("cornell").expect("a built-in scene");
        let description = description.load().expect("a scene as it comes");
        let scene = Arc::new(Scene::build(&description));
        let settings = RenderSettings::new(scene.cameras()[0].clone(), 16, 16);
        let pool = WorkerPool::new(Some(1), || {}).expect("a thread");
        (Racer::new("pt-mis", &scene, settings, &pool), pool)
    }

    fn iterate(racer: &mut Racer, n: u32) {
        let nobody = CancelToken::default();
        for _ in 0..n {
            racer.iterate(&nobody).expect("nobody cancels");
        }
    }

    fn is_by(sample: &Sample, by: &Image, display: &Display) -> bool {
        let image = sample.image.as_ref().expect("there is room");
        let wanted = compare(image, by, display).expect("pictures of one size");
        sample.point.comparison == wanted
    }

    #[test]
    fn a_better_reference_judges_again_what_was_judged_before() {
        let (mut racer, pool) = racer();
        let mut judged = Judged::default();
        let display = Display::default();
        iterate(&mut racer, 1);
        let first = Arc::new(racer.image());
        judged.judge(&racer, &(Arc::clone(&first), display), 1);
        let latest = judged.latest.as_ref().expect("it was judged");
        assert_eq!(latest.point.comparison.rel_mse, 0.0);
        let better = {
            let (mut other, _) = self::racer();
            iterate(&mut other, 8);
            Arc::new(other.image())
        };
        // Nothing has been rendered since, but the reference is another one.
        let by = (Arc::clone(&better), display);
        judged.judge(&racer, &by, 2);
        assert!(judged.earlier.is_empty(), "it is the same picture");
        let latest = judged.latest.as_ref().expect("it was judged");
        assert!(is_by(latest, &better, &display));
        iterate(&mut racer, 3);
        judged.judge(&racer, &by, 2);
        assert_eq!((judged.earlier.len(), judged.curve().len()), (1, 2));
        // Half as many iterations more are no reason to judge again, twice as many are.
        let by = (first, display);
        judged.judge_again(&pool, &by, 3);
        assert!(is_by(&judged.earlier[0], &better, &display));
        judged.judge_again(&pool, &by, 4);
        assert!(is_by(&judged.earlier[0], &by.0, &display));
        let brighter = Display {
            exposure_ev: 1.0,
            ..display
        };
        judged.judge_again(&pool, &(by.0, brighter), 4);
        assert!(is_by(&judged.earlier[0], &racer_image(&judged), &brighter));
    }

    /// The first picture that was judged.
    fn racer_image(judged: &Judged) -> Arc<Image> {
        let image = judged.earlier[0].image.as_ref();
        Arc::clone(image.expect("there is room"))
    }
}
