//! What is done with hostile bytes, and what must hold then.
//!
//! Each [`Target`] takes any bytes and ends in a result or in an error, never in a panic or a
//! hang. The fuzzers of `fuzz/` run them for as long as one likes (`scripts/fuzz`); the tests
//! run a short round with the same damage every time.
//!
//! | file | targets |
//! |---|---|
//! | `scenes` | `scene-json` (edits of a whole document), `glb`, `accessors` (built and traced) |
//! | `geometry` | `meshopt`, `draco` |
//! | `pictures` | `picture`, `hdr`, `exr`, `checkpoint`, `compare` |

mod damage;
mod geometry;
mod pictures;
mod scenes;

use std::sync::Once;

use neumann_core::memory::set_allowed;

pub use damage::{Dice, damaged};

/// A way into the program for bytes of others.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name, also that of its fuzzer.
    pub name: &'static str,
    /// Does with bytes what the program does; true if they were accepted.
    pub run: fn(&[u8]) -> bool,
    /// Bytes to begin with.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

/// All of them.
pub static TARGETS: &[Target] = &[
    scenes::SCENE_JSON,
    scenes::GLB,
    scenes::ACCESSORS,
    geometry::MESHOPT,
    geometry::DRACO,
    pictures::PICTURE,
    pictures::HDR,
    pictures::EXR,
    pictures::CHECKPOINT,
    pictures::COMPARE,
];

/// Memory that inputs may take, bytes: what asks for more is to be refused before it is there.
const MEMORY: u64 = 256 << 20;

/// Runs a target for a fuzzer.
///
/// # Panics
/// If there is no such target, and where the program is wrong.
pub fn fuzz(name: &str, bytes: &[u8]) {
    static QUIET: Once = Once::new();
    // The fuzzer's own hook ends the program at every panic; those of decoders are caught.
    QUIET.call_once(|| {
        std::panic::set_hook(Box::new(|_| {}));
        set_allowed(MEMORY);
    });
    let target = TARGETS.iter().find(|target| target.name == name);
    let Some(target) = target else {
        panic!("no target {name}");
    };
    (target.run)(bytes);
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::{Dice, TARGETS, Target, damaged};

    /// Inputs of a target in the short round; 25 000 in all.
    const N_INPUTS: usize = 2500;
    /// Far more than any input needs, far less than a hang.
    const LONGEST: Duration = Duration::from_secs(20);

    fn target(name: &str) -> &'static Target {
        TARGETS.iter().find(|target| target.name == name).unwrap()
    }

    /// Damages the seeds of a target, the same way every time.
    fn round(name: &str) {
        let target = target(name);
        let seeds = (target.seeds)();
        let mut dice = Dice::new(1);
        let mut n_accepted = 0;
        for i in 0..N_INPUTS {
            let mutant = damaged(&seeds[i % seeds.len()], &mut dice);
            let start = Instant::now();
            n_accepted += usize::from((target.run)(&mutant));
            assert!(
                start.elapsed() < LONGEST,
                "{name}: input {i} takes too long"
            );
        }
        // Were all refused, or none, the damage would say little.
        assert!(n_accepted > 20, "{name}: {n_accepted} accepted");
        assert!(n_accepted < N_INPUTS, "{name}: nothing was refused");
    }

    #[test]
    fn what_is_whole_is_accepted() {
        for target in TARGETS {
            // Further seeds of documents are edited already, and bytes say what accessors are like.
            let seeds = (target.seeds)();
            let n_whole = match target.name {
                "scene-json" => 1,
                "accessors" => 0,
                _ => seeds.len(),
            };
            for (i, seed) in seeds.iter().take(n_whole).enumerate() {
                assert!((target.run)(seed), "{}: seed {i}", target.name);
            }
        }
    }

    #[test]
    fn odd_documents() {
        round("scene-json");
    }

    #[test]
    fn odd_containers() {
        round("glb");
    }

    #[test]
    fn odd_accessors() {
        round("accessors");
    }

    #[test]
    fn odd_packed_geometry() {
        round("meshopt");
    }

    #[test]
    fn odd_packed_meshes() {
        round("draco");
    }

    #[test]
    fn odd_textures() {
        round("picture");
    }

    #[test]
    fn odd_radiance_maps() {
        round("hdr");
    }

    #[test]
    fn odd_layered_maps() {
        round("exr");
    }

    #[test]
    fn odd_checkpoints() {
        round("checkpoint");
    }

    #[test]
    fn odd_pictures_to_compare() {
        round("compare");
    }

    #[test]
    fn every_target_has_a_fuzzer() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
        let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        for target in TARGETS {
            let path = format!("fuzz_targets/{}.rs", target.name);
            assert!(manifest.contains(&path), "{path}");
            let text = std::fs::read_to_string(folder.join(path)).unwrap();
            assert!(text.contains(&format!("\"{}\"", target.name)), "{text}");
        }
    }
}
