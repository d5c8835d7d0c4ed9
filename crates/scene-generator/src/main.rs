//! Writes the built-in scenes, which are committed and embedded in the program.
//!
//! `scene-generator FOLDER` writes them; with `--check` it writes nothing and
//! fails if a file differs from what would be written. The same bytes come out
//! on every machine. With `--stress` it writes big scenes instead, for measuring.

mod environment;
mod glb;
mod material;
mod mesh;
mod revolve;
mod scene;
mod scenes;

use std::io::{Error, ErrorKind};
use std::path::Path;
use std::process::ExitCode;
use std::{env, fs};

const USAGE: &str = "usage: scene-generator [--check | --stress] FOLDER, for example assets/scenes";

fn main() -> ExitCode {
    let (options, folders): (Vec<_>, Vec<_>) =
        env::args().skip(1).partition(|a| a.starts_with('-'));
    let [folder] = folders.as_slice() else {
        say(USAGE);
        return ExitCode::from(2);
    };
    let options: Vec<&str> = options.iter().map(String::as_str).collect();
    let act = match options.as_slice() {
        [] => write,
        ["--check"] => check,
        ["--stress"] => write_stress,
        _ => {
            say(USAGE);
            return ExitCode::from(2);
        }
    };
    match act(Path::new(folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&error.to_string());
            ExitCode::FAILURE
        }
    }
}

/// Every file of the folder: name and contents.
fn files() -> Result<Vec<(String, Vec<u8>)>, image::ImageError> {
    let mut files = Vec::new();
    let mut lines = String::new();
    for (name, build) in scenes::SCENES {
        let scene = build();
        lines.push_str(&format!("- `{name}`: {}\n", scene.about()));
        files.push((format!("{name}.glb"), scene.to_glb()));
    }
    files.push(("sky.hdr".to_owned(), environment::sky_hdr()?));
    let readme = format!(
        "# Built-in scenes\n\n\
         Written by `cargo run -p scene-generator -- assets/scenes`; do not edit by hand.\n\
         `scripts/validate-scenes` holds them against the Khronos validator.\n\n\
         {lines}\n\
         `sky.hdr` is the environment of `sky`: latitude and longitude, -Z in the middle, +Y on \
         top.\n"
    );
    files.push(("README.md".to_owned(), readme.into_bytes()));
    Ok(files)
}

/// One by one, as each may be hundreds of megabytes.
fn write_stress(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder)?;
    for (name, build) in scenes::STRESS_SCENES {
        let contents = build().to_glb();
        fs::write(folder.join(format!("{name}.glb")), &contents)?;
        say(&format!("{name}.glb: {} bytes", contents.len()));
    }
    Ok(())
}

fn write(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder)?;
    for (name, contents) in files().map_err(Error::other)? {
        fs::write(folder.join(&name), &contents)?;
        say(&format!("{name}: {} bytes", contents.len()));
    }
    Ok(())
}

fn check(folder: &Path) -> Result<(), Error> {
    for (name, contents) in files().map_err(Error::other)? {
        let path = folder.join(name);
        let found = fs::read(&path)
            .map_err(|e| Error::new(e.kind(), format!("{}: {e}", path.display())))?;
        if found != contents {
            let message = format!(
                "{} is not what the generator writes; run it again",
                path.display()
            );
            return Err(Error::new(ErrorKind::InvalidData, message));
        }
    }
    Ok(())
}

#[allow(clippy::print_stderr, reason = "the only output of a command")]
fn say(line: &str) {
    eprintln!("{line}");
}

/// To six decimals: short in the file, and the same on every platform.
pub(crate) fn rounded(number: f64) -> f64 {
    // Adding zero turns -0 into 0.
    (number * 1e6).round() / 1e6 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_scenes_are_what_the_generator_writes() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/scenes");
        check(Path::new(folder)).unwrap();
    }

    #[test]
    fn the_scenes_are_small_enough_to_embed() {
        let total: usize = files()
            .unwrap()
            .iter()
            .map(|(_, contents)| contents.len())
            .sum();
        assert!(total < 3_000_000, "{total} bytes");
    }
}
