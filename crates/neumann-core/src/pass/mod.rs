//! One iteration, run in parallel and deterministically.
//!
//! The image is cut into tiles; each is traced by one worker, which has that part of the frame to
//! itself. Contributions to other pixels (splats) are kept in the order of their paths and added in
//! that order at the end. Random numbers are keyed by (seed, iteration, path), so the result does
//! not depend on which worker traced what.

mod cancel;
mod coverage;
mod light_paths;
mod observer;
mod pixels;
mod sample_counts;
mod sink;
mod tiles;
mod whole_path;

pub use cancel::{CancelToken, Cancelled};
pub(crate) use coverage::Coverage;
pub use light_paths::{Collected, LightNumbers, LightPaths};
pub(crate) use observer::{ClassPlan, LightPathsSeen, Plan, ReplayPlan, Seen};
pub use observer::{PathId, Replayed};
pub use pixels::{PixelPath, PixelSample, Pixels, Splits};
pub use sample_counts::SampleCounts;
pub use sink::{Gather, PixelPlace, PixelSink, Sink};

use std::ops::Range;

use rayon::prelude::*;

use self::sink::{SinkShape, Yield, add_splats};
use crate::endpoint::Camera;
use crate::film::techniques::TechniqueFilm;
use crate::film::{ClassFilm, Frame, LitLayers, NextFilm, PhotonReport};
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::transport::Tracer;

/// Paths that one task traces, where paths belong to no pixel.
const CHUNK: usize = 256;
/// Tasks after which splats are added up, so that they never take much memory: as many paths as a
/// film of 1024×1024 has pixels,
const ROUND: usize = 4096;
/// and fewer while techniques or classes are recorded.
const RECORDING_ROUND: usize = 256;

/// What the paths of a pass depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassNumbers {
    /// Terms with `k` up to and including this one are wanted.
    pub(crate) max_bounces: u32,
    /// Seed of all random numbers.
    pub(crate) seed: u64,
    /// Number of the iteration, from 0.
    pub(crate) iteration: u32,
}

/// What an integrator works with during one iteration.
pub struct Pass<'a> {
    frame: &'a mut Frame,
    /// Takes in each tile as soon as it has been traced; the frame stays black then.
    film: Option<NextFilm<'a>>,
    camera: &'a Camera,
    coverage: &'a Coverage,
    max_bounces: u32,
    seed: u64,
    iteration: u32,
    cancel: &'a CancelToken,
    techniques: Option<&'a mut TechniqueFilm>,
    samples: SampleCounts,
    n_splits: u8,
    is_alone: bool,
    /// What is looked at, where somebody looks at paths,
    plan: Option<Plan>,
    /// what was seen so far,
    seen: Seen,
    /// and where classes of paths are kept.
    classes: Option<&'a mut ClassFilm>,
}

impl<'a> Pass<'a> {
    pub(crate) fn new(
        (frame, film): (&'a mut Frame, Option<NextFilm<'a>>),
        camera: &'a Camera,
        coverage: &'a Coverage,
        numbers: PassNumbers,
        cancel: &'a CancelToken,
        techniques: Option<&'a mut TechniqueFilm>,
    ) -> Self {
        Self {
            frame,
            film,
            camera,
            coverage,
            max_bounces: numbers.max_bounces,
            seed: numbers.seed,
            iteration: numbers.iteration,
            cancel,
            techniques,
            samples: SampleCounts::Even(1),
            n_splits: 1,
            is_alone: false,
            plan: None,
            seen: Seen::default(),
            classes: None,
        }
    }

    /// Lets paths walk one by one, not side by side.
    pub(crate) fn trace_alone(&mut self, is_alone: bool) {
        self.is_alone = is_alone;
    }

    /// Looks at how light comes to some pixels, by paths that walk alone.
    pub(crate) fn observe(&mut self, plan: &Plan) {
        self.is_alone = true;
        self.plan = Some(plan.clone());
    }

    /// Keeps classes apart, by paths that walk alone.
    pub(crate) fn classify(&mut self, plan: ClassPlan, film: &'a mut ClassFilm) {
        self.is_alone = true;
        self.plan = Some(Plan::Classify(plan));
        self.classes = Some(film);
    }

    /// What was seen.
    pub(crate) fn into_seen(self) -> Seen {
        self.seen
    }

    /// What classes were told by.
    pub(crate) fn into_class_plan(self) -> Option<ClassPlan> {
        match self.plan? {
            Plan::Classify(plan) => Some(plan),
            Plan::Replay(_) => None,
        }
    }

    /// True if no tile of the film is missing.
    pub(crate) fn is_whole(&self) -> bool {
        self.film.as_ref().is_none_or(NextFilm::is_whole)
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

    /// How far the light path that a pixel's path is joined to is from the pixel's own number, of
    /// `n_paths` around. It changes from one iteration to the next: the low digits of a light
    /// path's number, and with them where it begins, may be the same in all.
    #[must_use]
    pub fn light_path_shift(&self, n_paths: usize) -> usize {
        let u = Sampler::new(self.seed, u64::MAX, self.iteration).next_1d();
        (f64::from(u) * n_paths as f64) as usize
    }

    /// Random numbers of light paths that are the same in every iteration.
    #[must_use]
    pub fn fixed_light_numbers(&self) -> LightNumbers {
        LightNumbers {
            seed: self.seed,
            first: 0,
        }
    }

    /// What the iteration has come to so far.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        self.frame
    }

    /// Runs so many paths for each pixel from now on, and leaves their mean.
    pub fn sample(&mut self, samples: SampleCounts) {
        self.samples = samples;
    }

    /// Lets each path split into so many at most; see
    /// [`PixelPath::splits`].
    pub fn split(&mut self, n_splits: u8) {
        self.n_splits = n_splits;
    }

    /// Runs another iteration, to see what it is like; [`Self::clear`] it afterwards.
    ///
    /// # Errors
    /// Those of `run`.
    pub fn measure(
        &mut self,
        iteration: u32,
        run: impl FnOnce(&mut Self) -> Result<(), Cancelled>,
    ) -> Result<(), Cancelled> {
        let present = std::mem::replace(&mut self.iteration, iteration);
        let techniques = self.techniques.take();
        let plan = self.plan.take();
        let outcome = run(self);
        self.iteration = present;
        self.plan = plan;
        self.techniques = techniques;
        outcome
    }

    /// Makes the frame black again.
    pub fn clear(&mut self) {
        self.frame.clear();
    }

    /// Tells what the iteration's photons were like, for whoever looks at the frame.
    pub fn report(&mut self, photons: PhotonReport) {
        self.frame.photons = Some(photons);
    }

    /// Runs `paths` for each tile, to trace the paths of its pixels, once unless [`Self::sample`]
    /// says otherwise, in whatever order; they add to their own pixels alone.
    ///
    /// A camera ray that meets nothing must bring the radiance from there, with weight 1: where
    /// that is the same from everywhere, and nothing stands before it, no path is run.
    ///
    /// # Errors
    /// [`Cancelled`] when the token was; the frame is then worth nothing.
    pub fn trace_own_pixels<F>(&mut self, scene: &Scene, paths: F) -> Result<(), Cancelled>
    where
        F: for<'t> Fn(Pixels<'t>, &mut Tracer<'_>, &mut PixelSink<'_>) + Sync,
    {
        self.trace_tiles(
            scene,
            || (),
            |(), pixels, tracer, sink| paths(pixels, tracer, sink),
            scene.lights().uniform_environment(),
        )
    }

    /// Runs `path` for each pixel: its place on the raster, a tracer, the path's random numbers,
    /// and the sink; with scratch memory that each task makes once and every path of it may use.
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
        R: Send,
        F: Fn(&mut R, PixelSample, &mut Tracer<'s>, &Sampler<'_>, &mut PixelSink<'_>) + Sync,
    {
        self.trace_tiles(
            scene,
            room,
            |room, pixels, tracer, sink| {
                pixels.one_by_one(sink, |sample, sampler, sink| {
                    path(room, sample, tracer, sampler, sink);
                });
            },
            None,
        )
    }

    /// Runs `paths` for each tile, to trace the paths of all of its pixels, in whatever order, with
    /// scratch memory that each task makes once and every tile of it may use.
    ///
    /// # Errors
    /// [`Cancelled`] when the token was; the frame is then worth nothing.
    pub fn trace_pixels_together_with<'s, R, M, F>(
        &mut self,
        scene: &'s Scene,
        room: M,
        paths: F,
    ) -> Result<(), Cancelled>
    where
        R: Send,
        M: Fn() -> R + Sync + Send,
        F: for<'t> Fn(&mut R, Pixels<'t>, &mut Tracer<'s>, &mut Sink<'_>) + Sync,
    {
        self.trace_tiles(scene, room, paths, None)
    }

    /// Runs `path` once for each of `n_paths` light paths, which belong to no pixel: its number, a
    /// tracer, its random numbers, and the sink; collects what each pushes to the vector it is
    /// given.
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
        F: Fn(usize, &mut Tracer<'s>, &Sampler<'_>, &mut Sink<'_>, &mut Vec<T>) + Sync,
    {
        let mut collected = Collected::default();
        self.trace_kept_chunks(
            scene,
            n_paths,
            |range, tracer, sink| {
                let mut part = Collected::default();
                for index in range {
                    let sampler = numbers.path(index);
                    path(index, tracer, &sampler, sink, &mut part.items);
                    part.ends.push(part.items.len() as u32);
                }
                part
            },
            |parts| collected.write(&parts),
        )?;
        Ok(collected)
    }

    /// As [`Self::trace_light_paths_together`]; collects what is kept, each with the number of its
    /// path among those handed over, in place of what earlier paths left: taking so much memory
    /// from the system anew in every iteration would cost more than to fill it.
    ///
    /// # Errors
    /// [`Cancelled`]; what was collected is of no use then.
    pub fn collect_light_paths_together<'s, T, F>(
        &mut self,
        collected: &mut Collected<T>,
        scene: &'s Scene,
        n_paths: usize,
        numbers: LightNumbers,
        paths: F,
    ) -> Result<(), Cancelled>
    where
        T: Copy + Send + Sync,
        F: Fn(LightPaths, &mut Tracer<'s>, &mut Sink<'_>, &mut Vec<(u32, T)>) + Sync,
    {
        collected.ends.clear();
        self.trace_kept_chunks(
            scene,
            n_paths,
            |range, tracer, sink| {
                let (mut kept, n) = (Vec::new(), range.len());
                paths(LightPaths { numbers, range }, tracer, sink, &mut kept);
                let mut part = Collected::default();
                part.sort(&kept, n);
                part
            },
            |parts| collected.write(&parts),
        )?;
        collected.items.truncate(collected.n_written());
        Ok(())
    }

    /// Runs `paths` for every so many of `n_paths` light paths, to trace them in whatever order it
    /// likes: with their random numbers, a tracer and the sink.
    ///
    /// # Errors
    /// [`Cancelled`] when the token was; the frame is then worth nothing.
    pub fn trace_light_paths_together<F>(
        &mut self,
        scene: &Scene,
        n_paths: usize,
        numbers: LightNumbers,
        paths: F,
    ) -> Result<(), Cancelled>
    where
        F: Fn(LightPaths, &mut Tracer<'_>, &mut Sink<'_>) + Sync,
    {
        self.trace_chunks(
            scene,
            n_paths,
            |range, tracer, sink| paths(LightPaths { numbers, range }, tracer, sink),
            |_| (),
            false,
        )
    }

    /// As [`Self::trace_chunks`], of paths that later ones may be joined to.
    fn trace_kept_chunks<'s, T, F>(
        &mut self,
        scene: &'s Scene,
        n_paths: usize,
        paths: F,
        take: impl FnMut(Vec<T>),
    ) -> Result<(), Cancelled>
    where
        T: Default + Send,
        F: Fn(Range<usize>, &mut Tracer<'s>, &mut Sink<'_>) -> T + Sync,
    {
        let join = |of: &mut Self| {
            if let Some(plan) = &mut of.plan {
                plan.joins(&mut of.seen.light_paths);
            }
        };
        // Nothing is joined to earlier ones any more.
        join(self);
        self.trace_chunks(scene, n_paths, paths, take, true)?;
        join(self);
        Ok(())
    }

    /// Runs `paths` for every so many of `n_paths` light paths, and hands what it makes to `take`,
    /// in the order of the paths.
    fn trace_chunks<'s, T, F>(
        &mut self,
        scene: &'s Scene,
        n_paths: usize,
        paths: F,
        mut take: impl FnMut(Vec<T>),
        hands_on: bool,
    ) -> Result<(), Cancelled>
    where
        T: Default + Send,
        F: Fn(Range<usize>, &mut Tracer<'s>, &mut Sink<'_>) -> T + Sync,
    {
        let cancel = self.cancel;
        let shape = self.sink_shape();
        let plan = self.plan.clone();
        for round in self.rounds(n_paths.div_ceil(CHUNK)) {
            let (yields, parts): (Vec<Yield>, Vec<T>) = round
                .into_par_iter()
                .with_max_len(1)
                .map(|chunk| {
                    if cancel.is_cancelled() {
                        return (Yield::default(), T::default());
                    }
                    let observer = plan.as_ref().map(|plan| plan.observer(hands_on));
                    let (trail, observer) = observer.unzip();
                    let mut tracer = Tracer::new(scene).observed(trail);
                    let mut lit = LitLayers::default();
                    let mut sink =
                        Sink::new(PixelSink::new(&mut [], &mut lit, shape).observed(observer));
                    let range = chunk * CHUNK..((chunk + 1) * CHUNK).min(n_paths);
                    let part = paths(range, &mut tracer, &mut sink);
                    (sink.into_yield(tracer.n_rays()), part)
                })
                .unzip();
            self.take(yields)?;
            take(parts);
        }
        Ok(())
    }

    fn sink_shape(&self) -> SinkShape {
        let recording = self.techniques.as_ref().map(|t| t.shape());
        SinkShape::new(self.frame, recording, self.is_alone)
    }

    /// Cuts tasks into rounds.
    fn rounds(&self, n_tasks: usize) -> Vec<Range<usize>> {
        let is_recording = self.techniques.is_some() || self.classes.is_some();
        let length = if is_recording { RECORDING_ROUND } else { ROUND };
        (0..n_tasks.div_ceil(length))
            .map(|i| i * length..((i + 1) * length).min(n_tasks))
            .collect()
    }

    /// Adds up what the tasks handed back, in their order.
    fn take(&mut self, yields: Vec<Yield>) -> Result<(), Cancelled> {
        if self.cancel.is_cancelled() {
            return Err(Cancelled);
        }
        add_splats(self.frame, &yields);
        for part in yields {
            if let Some(techniques) = &mut self.techniques {
                techniques.take(&part.records);
            }
            self.frame.n_refused += part.n_refused;
            self.frame.n_rays += part.n_rays;
            if let Some(seen) = part.seen {
                if let Some(classes) = &mut self.classes {
                    classes.take(&seen.records);
                }
                self.seen.extend(seen);
            }
        }
        Ok(())
    }
}
