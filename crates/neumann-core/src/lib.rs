//! Light transport, bounce by bounce.

pub mod accel;
pub mod bsdf;
pub mod endpoint;
pub mod film;
pub mod integrator;
pub mod material;
pub mod math;
pub mod radiometry;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod transport;
