//! Light transport, bounce by bounce.

pub mod radiometry;
pub mod scene;
