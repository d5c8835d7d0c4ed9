//! Goes on from a file that an earlier run wrote.

use std::path::Path;

use neumann_picture::exr_file::{Checkpoint, Difference, Metadata, read_exr};

use super::Session;
use crate::console;
use crate::failure::{OrBadInput, Outcome, bad_input};

impl Session {
    /// What the file holds, if it is there and belongs to this render.
    pub(crate) fn checkpoint(&self, path: &Path) -> Outcome<Option<Checkpoint>> {
        if !path.exists() {
            return Ok(None);
        }
        if self.classes.is_some() {
            return Err(bad_input(
                "--resume: layers of --expression and --lights cannot be gone on with; leave them \
                 out, or render to another file",
            ));
        }
        let checkpoint = read_exr(path).or_bad_input()?;
        if checkpoint.has_classes {
            return Err(bad_input(format!(
                "{}: has layers of expressions and lights, which cannot be gone on with and would \
                 be lost; render to another file",
                path.display()
            )));
        }
        let ours = Metadata::of(&self.scene, &self.settings);
        let mut differences = ours.differences(&checkpoint.metadata);
        let mut add = |field: &str, ours: String, theirs: String| {
            if ours != theirs {
                differences.push(Difference::new(field, ours, theirs));
            }
        };
        let (s, film) = (&self.settings, &checkpoint.film);
        add(
            "size",
            format!("{}x{}", s.width, s.height),
            format!("{}x{}", film.width(), film.height()),
        );
        add(
            "layers",
            s.n_layers.to_string(),
            film.n_layers().to_string(),
        );
        let iterations = &checkpoint.metadata.iterations;
        if iterations.count() > 0 {
            add(
                "first-iteration",
                self.goal.first_iteration.to_string(),
                iterations.first().to_string(),
            );
        }
        if !differences.is_empty() {
            let told: Vec<_> = differences
                .iter()
                .map(|d| d.told("asked for", "in the file"))
                .collect();
            return Err(bad_input(format!(
                "{}: cannot be resumed, it differs in {}; use the same options, or render to \
                 another file",
                path.display(),
                told.join(", ")
            )));
        }
        if checkpoint.metadata.program_version != ours.program_version {
            console::note(&format!(
                "warning: {} was rendered by version {}; its iterations may differ from those of \
                 {}",
                path.display(),
                checkpoint.metadata.program_version,
                ours.program_version
            ));
        }
        console::note(&format!(
            "going on from {} with {} iterations",
            path.display(),
            checkpoint.film.n_iterations()
        ));
        Ok(Some(checkpoint))
    }
}
