//! Any bytes given as a scene end in a description or in an error.
//!
//! `cargo +nightly fuzz run scene`, from this folder's parent; seeds are any
//! small `.gltf` and `.glb` files. Every relative URI yields the same few bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use neumann_core::scene::load::load_bytes;

fuzz_target!(|bytes: &[u8]| {
    let resolve = |_: &str| Some((0..=255).cycle().take(4096).collect());
    if let Ok(scene) = load_bytes("fuzz.glb", bytes, &resolve) {
        for mesh in &scene.meshes {
            let n_vertices = mesh.positions.len() as u32;
            assert!(mesh.triangles.iter().flatten().all(|&v| v < n_vertices));
            assert!(
                mesh.uv_sets
                    .iter()
                    .all(|set| set.len() == mesh.positions.len())
            );
            assert!(mesh.material.is_none_or(|m| m < scene.materials.len()));
        }
        assert!(scene.instances.iter().all(|i| i.mesh < scene.meshes.len()));
    }
});
