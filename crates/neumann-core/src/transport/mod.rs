//! Steps of paths: meeting a surface, asking who sees whom, one integral of reflection.

mod medium;
pub mod reflection;
mod tracer;
mod vertex;

pub use medium::Medium;
pub use tracer::Tracer;
pub use vertex::{Densities, Scattering, SurfaceVertex, VertexSample};
