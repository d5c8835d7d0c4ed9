//! The thread that looks at a surface.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use neumann_core::render::hemisphere::NoSurface;
use neumann_core::render::lobe::{AlbedoAt, Lobes, Reciprocity, Surface, Viewed, albedo_curve};
use neumann_core::render::{CancelToken, Cancelled, Job};

use crate::render_link::yield_to_interface;

/// How often there may be news, while there are any.
pub(super) const NEWS_PERIOD: Duration = Duration::from_millis(60);

/// Whose lobes are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Those of the surface that a pixel shows, column and row in the whole picture.
    Pixel([usize; 2]),
    /// Those of a material by its number.
    Material(usize),
}

/// What is to be found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wanted {
    /// The generation of pictures.
    pub(super) generation: u64,
    pub(super) choice: Choice,
    pub(super) is_other_side: bool,
    pub(super) angles: [f32; 4],
}

impl Wanted {
    /// True if both are of the same surface.
    fn is_of_surface(&self, other: &Self) -> bool {
        let of = |w: &Self| (w.generation, w.choice, w.is_other_side);
        of(self) == of(other)
    }
}

/// What has been found.
pub(super) type Found = Result<(Surface, Arc<Lobes>), NoSurface>;

/// What does not depend on the angles.
#[derive(Clone)]
pub(super) struct Known {
    albedo: Vec<AlbedoAt>,
    reciprocity: Option<Reciprocity>,
}

/// Looks at one surface. Ends with this handle.
pub(super) struct Worker {
    pub(super) wanted: Wanted,
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    cancel: CancelToken,
    is_done: AtomicBool,
    found: Mutex<Option<Found>>,
    known: Mutex<Option<Known>>,
}

impl Worker {
    /// `None` if the operating system gives no thread.
    pub(super) fn start(job: &Job, wanted: Wanted, known: Option<Known>) -> Option<Self> {
        let shared = Arc::<Shared>::default();
        let (scene, settings) = (Arc::clone(&job.scene), job.settings.clone());
        let of_thread = Arc::clone(&shared);
        let surface = match wanted.choice {
            Choice::Material(material) => Surface::of_material(&scene, material),
            Choice::Pixel(pixel) => match job.pixel_of(pixel) {
                Some(pixel) => Surface::of_pixel(&scene, &settings, pixel),
                None => Err(NoSurface::Nothing),
            },
        };
        let look = move || {
            yield_to_interface();
            // When it is cancelled nobody asks any more.
            let _ = of_thread.look(surface, &wanted, known);
            of_thread.is_done.store(true, Ordering::Relaxed);
        };
        let thread = thread::Builder::new().name("lobes".to_owned());
        thread.spawn(look).ok()?;
        Some(Self { wanted, shared })
    }

    /// True until all has been found.
    pub(super) fn is_busy(&self) -> bool {
        !self.shared.is_done.load(Ordering::Relaxed)
    }

    /// What has been found since it was asked last.
    pub(super) fn take_news(&self) -> Option<Found> {
        lock(&self.shared.found).take()
    }

    /// What it knows that holds for other angles, too.
    pub(super) fn known(&self, wanted: &Wanted) -> Option<Known> {
        let known = lock(&self.shared.known);
        known.clone().filter(|_| self.wanted.is_of_surface(wanted))
    }
}

impl Shared {
    fn look(
        &self,
        surface: Result<Surface, NoSurface>,
        wanted: &Wanted,
        known: Option<Known>,
    ) -> Result<(), Cancelled> {
        let mut surface = match surface {
            Ok(surface) => surface,
            Err(error) => {
                self.publish(Err(error));
                return Ok(());
            }
        };
        surface.is_behind ^= wanted.is_other_side;
        let (bsdf, is_behind) = (surface.bsdf, surface.is_behind);
        let mut views = Vec::new();
        for angle in wanted.angles {
            views.push(Viewed::new(&bsdf, angle, is_behind));
            if self.cancel.is_cancelled() {
                return Err(Cancelled);
            }
        }
        let lobes = |known: &Known| Lobes {
            views: views.clone(),
            albedo: known.albedo.clone(),
            reciprocity: known.reciprocity,
        };
        let known = match known {
            Some(known) => known,
            None => {
                // The curve takes longest; panels are shown before it is there.
                let mut known = Known {
                    albedo: Vec::new(),
                    reciprocity: Reciprocity::of(&bsdf),
                };
                self.publish(Ok((surface.clone(), Arc::new(lobes(&known)))));
                known.albedo = albedo_curve(&bsdf, is_behind, &self.cancel)?;
                known
            }
        };
        *lock(&self.known) = Some(known.clone());
        self.publish(Ok((surface, Arc::new(lobes(&known)))));
        Ok(())
    }

    fn publish(&self, found: Found) {
        *lock(&self.found) = Some(found);
    }
}

fn lock<T>(of: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.cancel.cancel();
    }
}
