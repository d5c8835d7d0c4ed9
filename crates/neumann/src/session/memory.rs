//! How much memory there is, and how much was used.
//!
//! Known on Linux, from `/proc`; elsewhere nothing is refused and nothing reported.

use std::fs;

use neumann_core::memory::free_bytes;
use neumann_core::render::RenderSettings;
use neumann_picture::files::film_bytes;

use crate::failure::{Outcome, bad_input};

/// Refuses a film that would not fit into memory.
pub(super) fn check(settings: &RenderSettings) -> Outcome {
    check_film(settings.width, settings.height, settings.n_layers)
}

/// Refuses a film of that size and so many layers if it would not fit into memory.
pub(crate) fn check_film(width: usize, height: usize, n_layers: usize) -> Outcome {
    let Some(available) = free_bytes() else {
        return Ok(());
    };
    let needed = film_bytes(width, height, n_layers);
    if needed <= available {
        return Ok(());
    }
    Err(bad_input(format!(
        "--size: a film of {width}x{height} with {n_layers} layers needs {:.1} GB, but {:.1} GB of \
         memory are free; choose a smaller --size or fewer --layers",
        needed as f64 * 1e-9,
        available as f64 * 1e-9
    )))
}

/// The largest amount of memory the program has had so far.
pub(crate) fn peak_bytes() -> Option<u64> {
    field("/proc/self/status", "VmHWM:")
}

/// A line `name   number kB` of a file of the system, in bytes.
fn field(path: &str, name: &str) -> Option<u64> {
    let text = fs::read_to_string(path).ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    let number: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    number.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use neumann_core::render::RenderSettings;
    use neumann_core::scene::load::LoadOptions;
    use neumann_core::scene::{Scene, open};

    use super::{check, peak_bytes};

    #[test]
    #[cfg(target_os = "linux")]
    fn a_film_beyond_all_memory_is_refused() {
        let scene = Scene::build(&open("cornell", &LoadOptions::default()).unwrap());
        let camera = scene.cameras()[0].clone();
        assert!(check(&RenderSettings::new(camera.clone(), 64, 64)).is_ok());
        let error = check(&RenderSettings::new(camera, 65_535, 65_535)).unwrap_err();
        assert!(error.to_string().contains("smaller --size"), "{error}");
        assert!(peak_bytes().unwrap() > 1 << 20);
    }
}
