//! References on disk: films under the user's cache folder, named by all that determines them.
//!
//! Together they take [`LIMIT`] at most; those that were used longest ago go first. What cannot be
//! read, or is of something else, is rendered anew.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use neumann_core::film::Film;
use neumann_core::render::RenderSettings;
use neumann_picture::exr_file::{IterationRanges, Metadata, read_exr, write_exr};

use crate::memory;
use crate::writing::Writing;

/// Bytes of all references.
const LIMIT: u64 = 256 << 20;

/// Where references are kept; `None` where there is no such folder.
#[must_use]
pub fn folder() -> Option<PathBuf> {
    memory::cache("references")
}

/// Name of the file of a render.
pub(super) fn name(metadata: &Metadata, settings: &RenderSettings) -> String {
    let text = format!(
        "{:?} {}x{} {}",
        Metadata {
            n_refused: 0,
            ..metadata.clone()
        },
        settings.width,
        settings.height,
        settings.n_layers
    );
    // FNV-1a.
    let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    format!("{hash:016x}.exr")
}

/// Reads the film of a render, and how many seconds it took, if it is there and whole.
pub(super) fn read(
    path: &Path,
    metadata: &Metadata,
    settings: &RenderSettings,
) -> Option<(Film, f64)> {
    let kept = read_exr(path).ok()?;
    let (film, of) = (kept.film, kept.metadata);
    let fits = of.differences(metadata).is_empty()
        && of.program_version == metadata.program_version
        && (film.width(), film.height()) == (settings.width, settings.height)
        && film.n_layers() == settings.n_layers
        && of.iterations == IterationRanges::of(0..film.n_iterations());
    if !fits {
        return None;
    }
    // It has been used.
    if let Ok(file) = File::options().append(true).open(path) {
        let _ = file.set_modified(SystemTime::now());
    }
    Some((film, of.seconds))
}

/// Keeps a film. What cannot be kept is no reason to trouble anybody.
pub(super) fn write(path: &Path, film: &Film, metadata: &Metadata) {
    let Some(folder) = path.parent() else {
        return;
    };
    let _writing = Writing::begin();
    if std::fs::create_dir_all(folder).is_ok() && write_exr(path, film, None, metadata).is_ok() {
        make_room(folder, LIMIT);
    }
}

/// Removes references, the oldest first, until all together take no more than `limit` bytes.
fn make_room(folder: &Path, limit: u64) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    let files = entries.filter_map(|entry| {
        let entry = entry.ok()?;
        let path = entry.path();
        let data = entry.metadata().ok().filter(std::fs::Metadata::is_file)?;
        is_ours(&path).then_some((data.modified().ok()?, data.len(), path))
    });
    let mut files: Vec<(SystemTime, u64, PathBuf)> = files.collect();
    files.sort();
    let mut total: u64 = files.iter().map(|(_, bytes, _)| bytes).sum();
    for (_, bytes, path) in files {
        if total <= limit {
            return;
        }
        if std::fs::remove_file(path).is_ok() {
            total -= bytes;
        }
    }
}

/// True of files that are named as [`name`] does.
fn is_ours(path: &Path) -> bool {
    let stem = path.file_stem().and_then(|stem| stem.to_str());
    let is_hash = stem.is_some_and(|s| s.len() == 16 && s.bytes().all(|b| b.is_ascii_hexdigit()));
    is_hash && path.extension().is_some_and(|e| e == "exr")
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, SystemTime};

    use neumann_core::film::Film;
    use neumann_core::integrator::method;
    use neumann_core::render::RenderSettings;
    use neumann_core::scene::builtin::builtin;
    use neumann_core::scene::{Appearance, Scene};
    use neumann_picture::exr_file::Metadata;

    use super::{make_room, name};

    #[test]
    fn all_that_determines_a_reference_is_in_its_name() {
        let description = builtin("cornell").expect("a built-in scene");
        let description = description.load().expect("a scene as it comes");
        let scene = Scene::build(&description);
        let usual = RenderSettings::new(scene.cameras()[0].clone(), 16, 16);
        let name_of = |scene: &Scene, settings: &RenderSettings| {
            name(&Metadata::of(scene, settings), settings)
        };
        let mut edited: Appearance = scene.appearance().clone();
        edited.materials[0].roughness = 0.123;
        let edited = scene.with_appearance(edited);
        let mut names = vec![name_of(&scene, &usual), name_of(&edited, &usual)];
        let changes: [fn(&mut RenderSettings); 6] = [
            |s| s.width = 17,
            |s| s.height = 17,
            |s| s.max_bounces = 3,
            |s| s.seed = 1,
            |s| s.method = method("vcm").expect("a method"),
            |s| s.camera.world_from_camera.w_axis.x += 0.1,
        ];
        for change in changes {
            let mut settings = usual.clone();
            change(&mut settings);
            names.push(name_of(&scene, &settings));
        }
        for (i, name) in names.iter().enumerate() {
            assert!(!names[i + 1..].contains(name), "{i}");
        }
        assert_eq!(name_of(&scene, &usual), names[0]);
    }

    #[test]
    fn what_is_of_another_size_or_depth_is_not_read() {
        let description = builtin("cornell").expect("a built-in scene");
        let description = description.load().expect("a scene as it comes");
        let scene = Scene::build(&description);
        let settings = RenderSettings {
            n_layers: 1,
            ..RenderSettings::new(scene.cameras()[0].clone(), 4, 4)
        };
        let black = vec![neumann_core::radiometry::Rgb::BLACK; 16];
        let layers = vec![black.clone(); 2];
        let film = Film::from_parts((4, 4), 2, layers, black.clone(), &black, 0);
        let film = film.expect("planes of one size");
        let metadata = Metadata {
            iterations: super::IterationRanges::of(0..2),
            seconds: 3.0,
            ..Metadata::of(&scene, &settings)
        };
        let folder = std::env::temp_dir().join(format!("neumann-kept-{}", std::process::id()));
        let path = folder.join(name(&metadata, &settings));
        super::write(&path, &film, &metadata);
        let read = |settings: &RenderSettings| {
            let metadata = Metadata::of(&scene, settings);
            super::read(&path, &metadata, settings).map(|(film, s)| (film.n_iterations(), s))
        };
        assert_eq!(read(&settings), Some((2, 3.0)));
        let other = |change: fn(&mut RenderSettings)| {
            let mut settings = settings.clone();
            change(&mut settings);
            read(&settings)
        };
        assert_eq!(other(|s| s.width = 5), None);
        assert_eq!(other(|s| s.n_layers = 2), None);
        assert_eq!(other(|s| s.max_bounces = 1), None);
        let _ = std::fs::remove_dir_all(&folder);
    }

    #[test]
    fn the_oldest_references_go_first_and_files_of_others_stay() {
        let folder = std::env::temp_dir().join(format!("neumann-cache-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let names = ["3", "1", "2"].map(|n| format!("{n:0>16}.exr"));
        for (age, name) in [1, 3, 2].into_iter().zip(&names) {
            let path = folder.join(name);
            std::fs::write(&path, [0; 100]).expect("a file");
            let file = std::fs::File::options().append(true).open(&path);
            let time = SystemTime::now() - Duration::from_secs(60 * age);
            file.and_then(|f| f.set_modified(time)).expect("its time");
        }
        std::fs::write(folder.join("mine.exr"), [0; 1000]).expect("a file");
        make_room(&folder, 250);
        let is_there = |name: &str| folder.join(name).exists();
        let are_there = names.each_ref().map(|name| is_there(name));
        assert_eq!(are_there, [true, false, true]);
        make_room(&folder, 0);
        assert!(!is_there(&names[0]) && is_there("mine.exr"));
        std::fs::remove_dir_all(&folder).expect("it is ours");
    }
}
