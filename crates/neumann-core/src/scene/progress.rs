//! How far a scene is on its way from a file to what can be rendered.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpeningStep {
    /// The file is read.
    File,
    /// Its meshes and pictures are taken out of it.
    Meshes,
    /// They are put where they stand in the world.
    Placing,
    /// The tree over all triangles is built.
    Tree,
}

/// Told by whoever opens a scene, read by whoever waits for it; copies share what they know.
#[derive(Clone, Debug, Default)]
pub struct OpeningProgress(Arc<AtomicU32>);

/// Parts that the way is divided into.
const WHOLE: f32 = 10_000.0;

impl OpeningStep {
    const ALL: [Self; 4] = [Self::File, Self::Meshes, Self::Placing, Self::Tree];

    /// Which share of the way is behind when the step begins: what it takes for five million
    /// triangles.
    fn start(self) -> f32 {
        match self {
            Self::File => 0.0,
            Self::Meshes => 0.1,
            Self::Placing => 0.35,
            Self::Tree => 0.6,
        }
    }

    /// In words, as in "opening: …".
    #[must_use]
    pub fn what(self) -> &'static str {
        match self {
            Self::File => "reading the file",
            Self::Meshes => "reading meshes",
            Self::Placing => "placing meshes",
            Self::Tree => "building the tree",
        }
    }
}

impl OpeningProgress {
    /// Tells that `done` of `all` that the step has to do is done.
    pub(super) fn reach(&self, step: OpeningStep, done: usize, all: usize) {
        let start = step.start();
        let next = OpeningStep::ALL.into_iter().map(OpeningStep::start);
        let end = next.filter(|s| *s > start).fold(1.0, f32::min);
        let part = done as f32 / all.max(1) as f32;
        let share = start + (end - start) * part.clamp(0.0, 1.0);
        self.0.fetch_max((share * WHOLE) as u32, Ordering::Relaxed);
    }

    /// The share of the way that is behind, in [0, 1].
    #[must_use]
    pub fn share(&self) -> f32 {
        self.0.load(Ordering::Relaxed) as f32 / WHOLE
    }

    /// What is being done.
    #[must_use]
    pub fn step(&self) -> OpeningStep {
        let share = self.share();
        let begun = |step: &OpeningStep| step.start() <= share + 0.5 / WHOLE;
        let last = OpeningStep::ALL.into_iter().rev().find(begun);
        last.unwrap_or(OpeningStep::File)
    }
}

#[cfg(test)]
mod tests {
    use super::{OpeningProgress, OpeningStep};

    #[test]
    fn the_way_is_walked_step_by_step_and_never_back() {
        let progress = OpeningProgress::default();
        assert_eq!(
            (progress.step(), progress.share()),
            (OpeningStep::File, 0.0)
        );
        let mut before = 0.0;
        for step in OpeningStep::ALL {
            progress.reach(step, 0, 4);
            assert_eq!(progress.step(), step);
            progress.reach(step, 3, 4);
            assert_eq!(progress.step(), step);
            assert!(progress.share() > before);
            before = progress.share();
        }
        progress.reach(OpeningStep::Meshes, 0, 0);
        assert!(progress.share() >= before);
        progress.reach(OpeningStep::Tree, 1, 1);
        assert!((progress.share() - 1.0).abs() < 1e-6);
    }
}
