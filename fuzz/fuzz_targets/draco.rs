#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| neumann_fuzzing::fuzz("draco", bytes));
