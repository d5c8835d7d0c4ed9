//! A scene ready to trace.

use super::description::{CameraDescription, SceneDescription};

/// A scene ready to trace: immutable while it renders.
#[derive(Debug)]
pub struct Scene {}

impl Scene {
    /// Builds the scene; whatever cannot be rendered is left out with a warning.
    #[must_use]
    pub fn build(_description: &SceneDescription) -> Self {
        Self {}
    }
    /// The cameras of the file, and never none: one that frames the bounds if the file has none.
    #[must_use]
    pub fn cameras(&self) -> &[CameraDescription] {
        &[]
    }
}
