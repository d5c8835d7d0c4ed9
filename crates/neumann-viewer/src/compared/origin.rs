//! Where a picture comes from.

use neumann_core::scene::Scene;
use neumann_picture::exr_file::Metadata;

/// Where a picture comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// Title of the method.
    pub method: String,
    /// Iterations that it is the mean of.
    pub n_iterations: u32,
    /// Time that they took, seconds.
    pub seconds: f64,
    /// What it is a picture of.
    pub scene: SceneName,
    /// The camera that saw it, as files write it down.
    pub camera: String,
}

/// A scene as its pictures name it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneName {
    /// Its name.
    pub name: String,
    /// Hash over the bytes it was loaded from.
    pub content_hash: u64,
}

impl Origin {
    /// What the header of a file says.
    #[must_use]
    pub fn of_file(metadata: &Metadata) -> Self {
        Self {
            method: metadata.integrator.clone(),
            n_iterations: metadata.iterations.count(),
            seconds: metadata.seconds,
            scene: SceneName {
                name: metadata.scene.clone(),
                content_hash: metadata.content_hash,
            },
            camera: metadata.camera.clone(),
        }
    }

    /// Method, iterations and seconds.
    #[must_use]
    pub fn words(&self) -> String {
        let n = self.n_iterations;
        let iterations = if n == 1 { "iteration" } else { "iterations" };
        format!("{} · {n} {iterations} · {:.1} s", self.method, self.seconds)
    }
}

impl SceneName {
    /// The name of a scene that is there.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        Self {
            name: scene.name().to_owned(),
            content_hash: scene.content_hash(),
        }
    }
}
