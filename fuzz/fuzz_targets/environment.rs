//! Any bytes given as an environment map end in a map or in an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use neumann_core::scene::load::environment_from_bytes;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(map) = environment_from_bytes("fuzz.hdr", bytes) {
        assert_eq!(map.texels.len(), map.width * map.height);
        assert!(map.texels.iter().all(|texel| texel.is_radiance()));
    }
});
