//! What may have been meant by a name that does not exist.

use std::ffi::OsString;
use std::path::Path;

use clap::CommandFactory;
use neumann_core::scene::builtin::{BUILTINS, builtin};
use strsim::damerau_levenshtein;

use crate::cli::Cli;
use crate::failure::{Outcome, bad_input};

/// Refuses what is neither a built-in scene nor a file.
pub(crate) fn check_scene(scene: &str) -> Outcome {
    if is_scene(scene) {
        return Ok(());
    }
    let remedy = match nearest(scene, scenes()) {
        Some(meant) => format!("did you mean '{meant}'? "),
        None => String::new(),
    };
    Err(bad_input(format!(
        "{scene}: neither a built-in scene nor a file; {remedy}'neumann list scenes' shows what \
         there is"
    )))
}

/// Refuses the scene of `neumann SCENE`, where a subcommand may have been meant as well.
pub(crate) fn check_scene_or_subcommand(scene: &str) -> Outcome {
    match misspelt_subcommand(scene) {
        Some(error) => Err(error),
        None => check_scene(scene),
    }
}

/// What to say about a command line that cannot be read because its first word is no subcommand.
pub(crate) fn about_line(arguments: impl Iterator<Item = OsString>) -> Option<anyhow::Error> {
    let first = arguments.into_iter().nth(1)?;
    misspelt_subcommand(&first.to_string_lossy())
}

fn misspelt_subcommand(word: &str) -> Option<anyhow::Error> {
    let command = Cli::command();
    let names: Vec<_> = command
        .get_subcommands()
        .map(clap::Command::get_name)
        .collect();
    if names.contains(&word) || word.starts_with('-') || is_scene(word) {
        return None;
    }
    let meant = nearest(word, names.into_iter().chain(scenes()))?;
    if builtin(meant).is_some() {
        return None;
    }
    Some(bad_input(format!(
        "{word}: no such subcommand; did you mean '{meant}'? 'neumann --help' lists them"
    )))
}

/// True for the name of a built-in scene, and for whatever the file system knows or will not tell.
fn is_scene(name: &str) -> bool {
    builtin(name).is_some() || Path::new(name).try_exists().unwrap_or(true)
}

fn scenes<'a>() -> impl Iterator<Item = &'a str> {
    BUILTINS.iter().map(|scene| scene.name)
}

/// The candidate that a name is a misspelling or the beginning of.
pub(crate) fn nearest<'a>(
    name: &str,
    candidates: impl Iterator<Item = &'a str>,
) -> Option<&'a str> {
    let name = name.to_lowercase();
    let n_mistakes = (name.chars().count() / 3).clamp(1, 3);
    candidates
        .map(|candidate| {
            let is_begun = name.len() >= 3 && candidate.starts_with(&name);
            let distance = damerau_levenshtein(&name, candidate);
            (if is_begun { 1 } else { distance }, candidate)
        })
        .filter(|(distance, _)| *distance <= n_mistakes)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::{about_line, check_scene, check_scene_or_subcommand, nearest, scenes};

    #[test]
    fn misspelt_names_find_what_was_meant() {
        let meant = |name| nearest(name, scenes());
        assert_eq!(meant("cornel"), Some("cornell"));
        assert_eq!(meant("Cornell"), Some("cornell"));
        assert_eq!(meant("cornlel"), Some("cornell"));
        assert_eq!(meant("cornell_glas"), Some("cornell-glass"));
        assert_eq!(meant("furn"), Some("furnace"));
        assert_eq!(meant("room.gltf"), None);
        assert_eq!(meant(""), None);
    }

    #[test]
    fn scenes_and_subcommands_are_told_apart() {
        let error = check_scene("cornel").unwrap_err().to_string();
        assert!(error.contains("did you mean 'cornell'?"), "{error}");
        check_scene("cornell").unwrap();
        let error = check_scene_or_subcommand("rendr").unwrap_err().to_string();
        assert!(error.contains("did you mean 'render'?"), "{error}");
        let error = check_scene_or_subcommand("cornel").unwrap_err().to_string();
        assert!(error.contains("did you mean 'cornell'?"), "{error}");
        let about = |line: &str| about_line(line.split(' ').map(Into::into));
        let error = about("neumann compair a.exr b.exr").unwrap().to_string();
        assert!(error.contains("did you mean 'compare'?"), "{error}");
        assert!(about("neumann render cornell --nonsense").is_none());
        assert!(about("neumann --nonsense").is_none());
        assert!(about("neumann cornell --nonsense").is_none());
    }
}
