//! One iteration after the other, for whoever waits for them.

use std::sync::Arc;

use super::adaptive::Adaptive;
use super::{RenderSettings, WorkerPool, photons};
use crate::endpoint::Camera;
use crate::film::{
    ClassFilm, Features, Film, Frame, NextFilm, PathClasses, PhotonReport, SampleMap, TechniqueFilm,
};
use crate::integrator::{Integrator, PixelIntegrator, Shot};
use crate::pass::{
    CancelToken, Cancelled, ClassPlan, Coverage, LightPathsSeen, Pass, Plan, ReplayPlan, Seen,
};
use crate::photons::{PhotonMap, PhotonPicture};
use crate::scene::Scene;

/// Runs the iterations of one set of settings.
///
/// What it yields is a pure function of scene, settings and number of the
/// iteration: the number of threads does not enter.
pub struct Renderer {
    scene: Arc<Scene>,
    settings: RenderSettings,
    camera: Camera,
    pool: WorkerPool,
    integrator: Integrator,
    /// Where samples go, if that is asked for.
    adaptive: Option<Adaptive>,
    next_iteration: u32,
    frame: Frame,
    /// Paths of the iterations that it has run.
    samples: SampleMap,
    /// What the film before the last one was, to be written again.
    spare: Option<Film>,
    coverage: Coverage,
    techniques: Option<TechniqueFilm>,
    classes: Option<Classes>,
    is_alone: bool,
}

/// Classes of paths that are kept apart.
struct Classes {
    film: ClassFilm,
    /// Light paths of the latest iteration that traced some.
    light_paths: Arc<LightPathsSeen>,
}

impl Renderer {
    /// Gets ready to run iterations from number `first_iteration` on.
    #[must_use]
    pub fn new(
        scene: Arc<Scene>,
        settings: RenderSettings,
        pool: WorkerPool,
        first_iteration: u32,
    ) -> Self {
        let camera = Camera::new(&settings.camera, settings.width, settings.height);
        let frame = Frame::new(settings.width, settings.height, settings.n_layers);
        let integrator = (settings.method.build)(&settings.values);
        Self {
            coverage: Coverage::new(&scene, &camera, frame.grid()),
            camera,
            adaptive: adaptive_of(&integrator),
            integrator,
            frame,
            samples: SampleMap::new(settings.width, settings.height),
            spare: None,
            next_iteration: first_iteration,
            techniques: None,
            classes: None,
            is_alone: false,
            scene,
            settings,
            pool,
        }
    }

    /// The settings it runs.
    #[must_use]
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// Goes on with another tree over the same triangles.
    pub(super) fn take_scene(&mut self, scene: &Arc<Scene>) {
        if !Arc::ptr_eq(&self.scene, scene) {
            self.scene = Arc::clone(scene);
        }
    }

    /// Lets paths walk one by one, not side by side. That changes no path, only the order in which
    /// splats and connections are added up.
    pub fn trace_alone(&mut self, is_alone: bool) {
        self.is_alone = is_alone;
    }

    /// Begins to keep techniques apart, `divisor` times smaller than the film, or ends it.
    pub fn record_techniques(&mut self, divisor: Option<usize>) {
        self.techniques = divisor.map(|divisor| {
            let settings = &self.settings;
            TechniqueFilm::new(settings.width, settings.height, divisor, settings.n_layers)
        });
    }

    /// The techniques since [`Self::record_techniques`].
    #[must_use]
    pub fn techniques(&self) -> Option<&TechniqueFilm> {
        self.techniques.as_ref()
    }

    /// Begins to keep classes of paths apart, or ends it. Paths walk one by one meanwhile, as
    /// [`Self::trace_alone`] says, which takes longer; and the vertices of an iteration's light
    /// paths are kept, if others are joined to them: about 160 bytes each.
    pub fn keep_classes(&mut self, classes: Option<Arc<PathClasses>>) {
        let s = &self.settings;
        self.classes = classes.map(|classes| Classes {
            film: ClassFilm::new(s.width, s.height, s.n_layers, classes),
            light_paths: Arc::default(),
        });
        if self.classes.is_some() {
            // Photons that were traced once for all iterations are traced once more, to be seen.
            self.integrator = (s.method.build)(&s.values);
        }
    }

    /// The classes since [`Self::keep_classes`].
    #[must_use]
    pub fn classes(&self) -> Option<&ClassFilm> {
        self.classes.as_ref().map(|classes| &classes.film)
    }

    /// Paths from the camera of each pixel, in the iterations that it has run.
    #[must_use]
    pub fn samples(&self) -> &SampleMap {
        &self.samples
    }

    /// What the camera sees first.
    #[must_use]
    pub fn features(&self) -> Features {
        let (s, scene) = (&self.settings, &*self.scene);
        let trace = || Features::trace(scene, &s.camera, s.width, s.height);
        self.pool.run(trace)
    }

    /// False if no estimate of the error can be had, [`Integrator::shows_its_error`].
    #[must_use]
    pub fn shows_its_error(&self) -> bool {
        self.integrator.shows_its_error()
    }

    /// [`Film::estimated_error`] of a film that it rendered, where that says anything: of emitted
    /// light alone it says nothing, as long as there are surfaces that may scatter some.
    #[must_use]
    pub fn estimated_error(&self, film: &Film) -> Option<f64> {
        let estimate = || self.pool.run(|| film.estimated_error());
        self.has_evidence(film).then(estimate).flatten()
    }

    /// [`Film::layer_errors`] of a film that it rendered, where they say anything.
    #[must_use]
    pub fn layer_errors(&self, film: &Film) -> Vec<Option<f64>> {
        if self.has_evidence(film) {
            self.pool.run(|| film.layer_errors())
        } else {
            vec![None; film.n_layers() + 1]
        }
    }

    fn has_evidence(&self, film: &Film) -> bool {
        let may_scatter = self.settings.max_bounces > 0 && self.scene.may_scatter();
        self.shows_its_error() && (!may_scatter || film.has_bounces())
    }

    /// Runs the next iteration and yields it.
    ///
    /// # Errors
    /// [`Cancelled`] if the token was; the same iteration is run again next time.
    pub fn iterate(&mut self, cancel: &CancelToken) -> Result<&Frame, Cancelled> {
        self.run(None, cancel)?;
        Ok(&self.frame)
    }

    /// Runs the next iteration, to be added to `film`: the same bits as [`Self::iterate`] and
    /// [`Film::add`], in less time. Where a method lets it, each tile of the next film is made as
    /// soon as its paths have been traced, from that of `film`; so films are two in turn, and what
    /// is kept in `film` may be looked at meanwhile.
    ///
    /// # Errors
    /// [`Cancelled`] if the token was; the same iteration is run again next time.
    ///
    /// # Panics
    /// If the film has another shape than the settings say.
    pub fn iterate_after(
        &mut self,
        film: &Film,
        cancel: &CancelToken,
    ) -> Result<Iteration<'_>, Cancelled> {
        if !self.fills_tiles() {
            self.run(None, cancel)?;
            return Ok(Iteration {
                frame: &self.frame,
                next: None,
            });
        }
        let spare = self.spare.take();
        let mut next = spare.unwrap_or_else(|| film.black());
        let outcome = next.follow(film, self.next_iteration, |next| {
            self.run(Some(next), cancel)?;
            Ok(self.frame.n_refused())
        });
        let next = self.spare.insert(next);
        outcome?;
        Ok(Iteration {
            frame: &self.frame,
            next: Some(next),
        })
    }

    /// True if the next iteration traces each tile once, so that it can go into the film at once.
    fn fills_tiles(&self) -> bool {
        let is_settled = self.adaptive.as_ref().is_none_or(Adaptive::is_settled);
        self.integrator.adds_to_own_pixels() && is_settled
    }

    /// Runs an iteration by itself to see what arrives where.
    pub(super) fn observe(
        &self,
        iteration: u32,
        plan: &ReplayPlan,
        cancel: &CancelToken,
    ) -> Result<Seen, Cancelled> {
        let settings = &self.settings;
        let mut integrator = (settings.method.build)(&settings.values);
        let mut adaptive = adaptive_of(&integrator);
        let plan = Plan::Replay(ReplayPlan {
            only_these: integrator.adds_to_own_pixels() && adaptive.is_none(),
            ..plan.clone()
        });
        let mut frame = Frame::new(settings.width, settings.height, settings.n_layers);
        let (camera, coverage) = (&self.camera, &self.coverage);
        let into = (&mut frame, None);
        let mut pass = Pass::new(
            into,
            camera,
            coverage,
            settings.numbers(iteration),
            cancel,
            None,
        );
        pass.observe(&plan);
        let scene = &*self.scene;
        self.pool
            .run(|| iterate(&mut integrator, adaptive.as_mut(), scene, &mut pass))?;
        Ok(pass.into_seen())
    }

    /// The photons that the latest iteration reads its light from, or before there is one, the
    /// first; `None` if the method has none. What it renders does not change by it.
    ///
    /// # Errors
    /// [`Cancelled`] if the token was.
    pub fn photons(&mut self, cancel: &CancelToken) -> Result<Option<Arc<PhotonMap>>, Cancelled> {
        let (pool, integrator) = (&self.pool, &mut self.integrator);
        let Integrator::Passes(passes) = integrator else {
            return Ok(None);
        };
        let iteration = self.next_iteration.saturating_sub(1);
        // Whatever the frame holds has been taken, and is cleared before the next iteration.
        let mut pass = Pass::new(
            (&mut self.frame, None),
            &self.camera,
            &self.coverage,
            self.settings.numbers(iteration),
            cancel,
            None,
        );
        let scene = &*self.scene;
        pool.run(|| passes.photons(scene, &mut pass))
    }

    /// Draws photons as points: all that the camera sees, through glass as if it were not there.
    ///
    /// # Errors
    /// [`Cancelled`] if the token was.
    pub fn draw_photons(
        &mut self,
        map: &PhotonMap,
        cancel: &CancelToken,
    ) -> Result<PhotonPicture, Cancelled> {
        let mut pass = Pass::new(
            (&mut self.frame, None),
            &self.camera,
            &self.coverage,
            self.settings.numbers(map.iteration),
            cancel,
            None,
        );
        let scene = &*self.scene;
        self.pool.run(|| photons::draw(map, scene, &mut pass))
    }

    fn run(&mut self, film: Option<NextFilm<'_>>, cancel: &CancelToken) -> Result<(), Cancelled> {
        self.frame.clear();
        self.frame.iteration = self.next_iteration;
        let mut pass = Pass::new(
            (&mut self.frame, film),
            &self.camera,
            &self.coverage,
            self.settings.numbers(self.next_iteration),
            cancel,
            self.techniques.as_mut(),
        );
        pass.trace_alone(self.is_alone);
        let mut known = None;
        if let Some(classes) = &mut self.classes {
            let plan = ClassPlan {
                classes: Arc::clone(classes.film.classes()),
                shape: classes.film.shape(),
                light_paths: std::mem::take(&mut classes.light_paths),
            };
            pass.classify(plan, &mut classes.film);
            known = Some(&mut classes.light_paths);
        }
        let (integrator, scene) = (&mut self.integrator, &*self.scene);
        let adaptive = self.adaptive.as_mut();
        let outcome = self
            .pool
            .run(|| iterate(integrator, adaptive, scene, &mut pass));
        debug_assert!(outcome.is_err() || pass.is_whole(), "every tile is traced");
        if let (Some(known), Some(plan)) = (known, pass.into_class_plan()) {
            *known = plan.light_paths;
        }
        if let Err(cancelled) = outcome {
            // Records of an iteration that was cut short cannot be told from the others.
            if let Some(techniques) = &mut self.techniques {
                *techniques = techniques.emptied();
            }
            if let Some(classes) = &mut self.classes {
                classes.film = classes.film.emptied();
            }
            return Err(cancelled);
        }
        if let Some(classes) = &mut self.classes {
            classes.film.end_iteration();
        }
        if let Some(techniques) = &mut self.techniques {
            techniques.end_iteration();
        }
        self.samples.add(&self.frame.n_samples_of_tiles);
        self.next_iteration += 1;
        Ok(())
    }
}

/// Where the samples of a method go, if that depends on the picture.
fn adaptive_of(integrator: &Integrator) -> Option<Adaptive> {
    match integrator {
        Integrator::Pixels(pixels) if pixels.is_adaptive() => Some(Adaptive::new()),
        _ => None,
    }
}

/// Runs an iteration.
fn iterate(
    integrator: &mut Integrator,
    adaptive: Option<&mut Adaptive>,
    scene: &Scene,
    pass: &mut Pass<'_>,
) -> Result<(), Cancelled> {
    match (integrator, adaptive) {
        (Integrator::Passes(passes), _) => passes.iterate(scene, pass),
        (Integrator::Pixels(pixels), None) => trace_pixels(&**pixels, scene, pass),
        (Integrator::Pixels(pixels), Some(adaptive)) => {
            adaptive.iterate(pass, |pass| trace_pixels(&**pixels, scene, pass))
        }
    }
}

/// Traces the paths of all pixels.
fn trace_pixels(
    method: &dyn PixelIntegrator,
    scene: &Scene,
    pass: &mut Pass<'_>,
) -> Result<(), Cancelled> {
    pass.split(method.n_splits(scene));
    let shot = Shot {
        scene,
        camera: pass.camera(),
        max_bounces: pass.max_bounces(),
    };
    pass.trace_own_pixels(scene, |pixels, tracer, sink| {
        method.trace(&shot, pixels, tracer, sink);
    })
}

/// An iteration that is to be added to a film.
pub struct Iteration<'a> {
    frame: &'a Frame,
    /// The film with the iteration, if it has been made already.
    next: Option<&'a mut Film>,
}

impl Iteration<'_> {
    /// Adds it to the film that it was run for.
    pub fn add_to(self, film: &mut Film) {
        match self.next {
            Some(next) => std::mem::swap(film, next),
            None => film.add(self.frame),
        }
    }

    /// [`Frame::n_rays`].
    #[must_use]
    pub fn n_rays(&self) -> u64 {
        self.frame.n_rays()
    }

    /// [`Frame::n_samples`].
    #[must_use]
    pub fn n_samples(&self) -> u64 {
        self.frame.n_samples()
    }

    /// [`Frame::photons`].
    #[must_use]
    pub fn photons(&self) -> Option<PhotonReport> {
        self.frame.photons()
    }
}
