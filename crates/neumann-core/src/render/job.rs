//! What to render in the background, and until when.

use std::sync::Arc;

use super::RenderSettings;
use crate::scene::Scene;

/// What to render.
#[derive(Clone)]
pub struct Job {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The settings, at full resolution.
    pub settings: RenderSettings,
    /// When it is done.
    pub stop: StopRule,
}

impl Job {
    /// The pixel of what is rendered that lies at a pixel of the whole picture; `None` outside of
    /// the region.
    #[must_use]
    pub fn pixel_of(&self, [x, y]: [usize; 2]) -> Option<[u32; 2]> {
        let [left, top] = self.settings.camera.crop.map_or([0, 0], |crop| crop.at);
        let (x, y) = (x.checked_sub(left)?, y.checked_sub(top)?);
        let is_within = x < self.settings.width && y < self.settings.height;
        is_within.then_some([x as u32, y as u32])
    }
}

/// When rendering is done by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum StopRule {
    /// Never.
    #[default]
    Never,
    /// After so many iterations at full resolution.
    Iterations(u32),
    /// Before an iteration that would end after so much time of rendering, seconds; after the
    /// first one at the earliest.
    Seconds(f64),
}
