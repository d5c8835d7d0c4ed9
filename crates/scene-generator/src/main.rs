//! Writes the built-in scenes.
fn main() {}
