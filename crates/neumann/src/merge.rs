//! `neumann merge`: renders of one scene with different iterations, joined.

use std::path::{Path, PathBuf};

use neumann_picture::exr_file::{Checkpoint, Precision, read_exr};

use crate::cli::MergeArguments;
use crate::console;
use crate::failure::{OrBadInput, Outcome, bad_input};
use crate::outputs::{self, Picture};

pub(crate) fn run(arguments: &MergeArguments) -> Outcome {
    outputs::check(&arguments.outputs)?;
    outputs::refuse_inputs(&arguments.outputs, &arguments.inputs)?;
    let mut parts = Vec::new();
    for path in &arguments.inputs {
        let part = read_exr(path).or_bad_input()?;
        if part.has_classes {
            console::note(&format!(
                "warning: {}: its layers of expressions and lights are left out",
                path.display()
            ));
        }
        parts.push((path, part));
    }
    check(&parts)?;
    // In the order of their iterations, so that the order of the arguments does not matter.
    parts.sort_by_key(|(_, part)| part.metadata.iterations.first());
    let mut whole: Option<Checkpoint> = None;
    for (_, part) in parts {
        match &mut whole {
            None => whole = Some(part),
            Some(whole) => join(whole, part)?,
        }
    }
    let Some(whole) = whole else {
        return Err(bad_input("nothing to merge; name at least two files"));
    };
    let picture = Picture {
        film: &whole.film,
        beside: whole.features.as_ref().into(),
        metadata: &whole.metadata,
        display: arguments.display.display(|| whole.film.total()),
        precision: Precision::Full,
    };
    picture.write_all(&arguments.outputs)?;
    console::note(&format!(
        "{} iterations: {}",
        whole.film.n_iterations(),
        whole.metadata.iterations
    ));
    Ok(())
}

/// Every pair must be of the same render and have no iteration in common.
fn check(parts: &[(&PathBuf, Checkpoint)]) -> Outcome {
    for (i, (b_path, b)) in parts.iter().enumerate() {
        for (a_path, a) in &parts[..i] {
            check_pair(a_path, a, b_path, b)?;
        }
    }
    Ok(())
}

fn check_pair(a_path: &Path, a: &Checkpoint, b_path: &Path, b: &Checkpoint) -> Outcome {
    let names = format!("{} and {}", a_path.display(), b_path.display());
    let shape = |c: &Checkpoint| {
        let f = &c.film;
        format!("{}x{} with {} layers", f.width(), f.height(), f.n_layers())
    };
    let mut differences: Vec<String> = a
        .metadata
        .differences(&b.metadata)
        .iter()
        .map(ToString::to_string)
        .collect();
    if shape(a) != shape(b) {
        differences.push(format!("size ({} and {})", shape(a), shape(b)));
    }
    if !differences.is_empty() {
        return Err(bad_input(format!(
            "{names}: cannot be merged, they differ in {}; render both with the same options",
            differences.join(", ")
        )));
    }
    let common = a.metadata.iterations.intersection(&b.metadata.iterations);
    if common.count() > 0 {
        return Err(bad_input(format!(
            "{names}: cannot be merged, both have iterations {common}; render one of them with \
             another --first-iteration"
        )));
    }
    if a.metadata.program_version != b.metadata.program_version {
        console::note(&format!(
            "warning: {names} were rendered by different versions ({} and {})",
            a.metadata.program_version, b.metadata.program_version
        ));
    }
    Ok(())
}

fn join(whole: &mut Checkpoint, part: Checkpoint) -> Outcome {
    whole.film.merge(&part.film).or_bad_input()?;
    let metadata = &mut whole.metadata;
    metadata.iterations = metadata.iterations.union(&part.metadata.iterations);
    metadata.seconds += part.metadata.seconds;
    metadata.n_refused = whole.film.n_refused();
    if whole.features.is_none() {
        whole.features = part.features;
    }
    Ok(())
}
