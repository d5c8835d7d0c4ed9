//! Steps of paths.
use crate::scene::Scene;
/// Traces rays and counts them.
pub struct Tracer<'a> {
    /// The scene.
    pub scene: &'a Scene,
    n_rays: u64,
}
impl<'a> Tracer<'a> {
    /// A tracer.
    #[must_use]
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene, n_rays: 0 }
    }
    /// Rays so far.
    #[must_use]
    pub fn n_rays(&self) -> u64 {
        self.n_rays
    }
}
