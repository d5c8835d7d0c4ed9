//! Does every room use only those before it?
//!
//! Read from the sources: `use` lines and paths of all files, tests left out. Rooms are the modules
//! of `lib.rs`, in the order of its tour; in each room, files that are beside each other must not
//! use each other in circles. And is every line of the workspace short enough to be read?

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The rooms in their order; those of one line may use each other.
const ROOMS: [&[&str]; 15] = [
    &["math"],
    &["radiometry"],
    &["sampling"],
    &["bsdf"],
    &["accel"],
    &["memory"],
    &["decode"],
    &["material"],
    &["endpoint"],
    &["scene"],
    &["transport"],
    &["expression"],
    &["film"],
    &["photons"],
    &["pass"],
];

/// The rooms behind those.
const LAST: [&str; 2] = ["integrator", "render"];

/// Plain data that every room may name.
const DATA: &str = "scene::description";

fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Every file below a folder with its text, comments and tests left out.
fn files(folder: &Path, found: &mut Vec<(PathBuf, String)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("tests.rs") {
            let text = fs::read_to_string(&path).unwrap();
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            let lines = code
                .lines()
                .filter(|line| !line.trim_start().starts_with("//"));
            found.push((path, lines.collect::<Vec<_>>().join("\n")));
        }
    }
}

/// What follows each occurrence of `before`: names and `::`.
fn paths_after<'a>(code: &'a str, before: &'a str) -> impl Iterator<Item = &'a str> {
    code.match_indices(before).map(move |(at, _)| {
        let rest = &code[at + before.len()..];
        let is_path = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == ':';
        rest.split(|c| !is_path(c)).next().unwrap_or_default()
    })
}

/// `crate::{a, b::c}` counts as `crate::a` and `crate::b`.
fn rooms_used(code: &str) -> BTreeSet<String> {
    let mut used: BTreeSet<String> = BTreeSet::new();
    for path in paths_after(code, "crate::") {
        if !path.starts_with(DATA) {
            used.insert(path.split("::").next().unwrap_or_default().to_owned());
        }
    }
    used
}

#[test]
fn rooms_use_only_those_before_them() {
    let order: Vec<&str> = ROOMS
        .iter()
        .copied()
        .flatten()
        .copied()
        .chain(LAST)
        .collect();
    let tour = fs::read_to_string(sources().join("lib.rs")).unwrap();
    let rows: Vec<&str> = tour
        .lines()
        .filter(|line| line.starts_with("//! | [`"))
        .collect();
    let told: Vec<&str> = rows
        .iter()
        .flat_map(|row| row.split('`').skip(1).step_by(2))
        .collect();
    let told: Vec<&str> = told
        .into_iter()
        .filter(|name| order.contains(name))
        .collect();
    assert_eq!(told, order, "the tour of lib.rs has another order");

    let mut found = Vec::new();
    files(&sources(), &mut found);
    let mut faults = Vec::new();
    for (path, code) in &found {
        let inside = path.strip_prefix(sources()).unwrap();
        let name = inside.iter().next().unwrap().to_string_lossy();
        let name = name.trim_end_matches(".rs");
        let Some(place) = order.iter().position(|room| *room == name) else {
            continue;
        };
        for used in rooms_used(code) {
            if order
                .iter()
                .position(|room| *room == used)
                .is_some_and(|at| at > place)
            {
                faults.push(format!("{} uses {used}", inside.display()));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Files of the core with their place in it.
fn core_files() -> Vec<(String, String)> {
    let mut found = Vec::new();
    files(&sources(), &mut found);
    let inside = |path: &Path| path.strip_prefix(sources()).unwrap().display().to_string();
    found
        .into_iter()
        .map(|(path, code)| (inside(&path), code))
        .collect()
}

/// The words of code.
fn words(code: &str) -> impl Iterator<Item = &str> {
    code.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
}

#[test]
fn the_core_knows_no_window_and_opens_files_in_two_rooms_only() {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let manifest = fs::read_to_string(manifest).unwrap();
    for window in ["winit", "wgpu", "egui", "crossterm"] {
        assert!(!manifest.contains(window), "the core depends on {window}");
    }
    for (path, code) in core_files() {
        assert!(!code.contains("println!"), "{path} prints");
        // Files as bytes that are there already are read by `openexr::File`.
        let opens = ["std::fs", "fs::read", "std::fs::File"]
            .iter()
            .any(|name| code.contains(name));
        let may = path.starts_with("scene/load") || path.starts_with("memory");
        assert!(may || !opens, "{path} opens files");
    }
}

#[test]
fn integrators_know_neither_threads_nor_tiles() {
    for (path, code) in core_files() {
        if !path.starts_with("integrator") {
            continue;
        }
        for word in [
            "rayon",
            "thread",
            "par_iter",
            "TILE",
            "TILE_PIXELS",
            "TileGrid",
            "NextFilm",
        ] {
            assert!(
                words(&code).all(|found| found != word),
                "{path} names {word}"
            );
        }
        assert!(
            !code.contains("film::Frame") && !code.contains("film::Film"),
            "{path}"
        );
    }
}

#[test]
fn densities_say_their_measure() {
    for (path, code) in core_files() {
        assert!(
            words(&code).all(|word| word != "pdf"),
            "{path} has a bare pdf"
        );
    }
}

/// The names of modules beside each other in a folder that each of them uses.
fn siblings(folder: &Path, files: &[(PathBuf, String)]) -> BTreeMap<String, BTreeSet<String>> {
    let inside = folder.strip_prefix(sources()).unwrap();
    let here: Vec<String> = inside
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    let of_crate = format!("crate::{}::", here.join("::"));
    let name = |path: &Path| {
        let first = path.strip_prefix(folder).unwrap().iter().next().unwrap();
        first.to_string_lossy().trim_end_matches(".rs").to_owned()
    };
    let inner: Vec<&(PathBuf, String)> = files
        .iter()
        .filter(|(path, _)| path.starts_with(folder) && !path.ends_with("lib.rs"))
        .filter(|(path, _)| name(path) != "mod")
        .collect();
    let names: BTreeSet<String> = inner.iter().map(|(path, _)| name(path)).collect();
    let mut uses: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (path, code) in inner {
        let depth = path.strip_prefix(folder).unwrap().iter().count();
        let is_folder_module = path.ends_with("mod.rs");
        let n_supers = if is_folder_module { depth - 1 } else { depth };
        let of_super = format!("use {}", "super::".repeat(n_supers));
        let used = paths_after(code, &of_crate).chain(paths_after(code, &of_super));
        let used = used.filter_map(|path| path.split("::").next().map(ToOwned::to_owned));
        let me = name(path);
        let others = used.filter(|used| names.contains(used) && *used != me);
        uses.entry(me.clone()).or_default().extend(others);
    }
    uses
}

#[test]
fn files_beside_each_other_use_each_other_in_no_circle() {
    let mut found = Vec::new();
    files(&sources(), &mut found);
    let folders: BTreeSet<PathBuf> = found
        .iter()
        .filter_map(|(path, _)| Some(path.parent()?.to_owned()))
        .collect();
    let mut circles = Vec::new();
    for folder in folders.iter().filter(|folder| **folder != sources()) {
        let mut uses = siblings(folder, &found);
        // Whoever uses none that is left is in no circle.
        loop {
            let free: Vec<String> = uses
                .iter()
                .filter(|(_, used)| used.is_empty())
                .map(|(name, _)| name.clone())
                .collect();
            if free.is_empty() {
                break;
            }
            for name in &free {
                uses.remove(name);
            }
            for used in uses.values_mut() {
                used.retain(|name| !free.contains(name));
            }
        }
        if !uses.is_empty() {
            circles.push(format!("{}: {uses:?}", folder.display()));
        }
    }
    assert!(circles.is_empty(), "{circles:#?}");
}

/// Rust files below a folder of the workspace.
fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.ends_with("target") {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// `cargo fmt` breaks code, but neither strings nor comments, nor what is in macros.
#[test]
fn lines_have_at_most_100_columns() {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut found = Vec::new();
    for folder in ["crates", "tests", "fuzz"] {
        rust_files(&workspace.join(folder), &mut found);
    }
    assert!(found.len() > 200, "{} files", found.len());
    let mut long = Vec::new();
    for path in &found {
        let text = fs::read_to_string(path).unwrap();
        for (i, line) in text.lines().enumerate() {
            // An address cannot be broken.
            if line.chars().count() > 100 && !line.contains("://") {
                long.push(format!("{}:{}", path.display(), i + 1));
            }
        }
    }
    assert!(long.is_empty(), "{long:#?}");
}
