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
