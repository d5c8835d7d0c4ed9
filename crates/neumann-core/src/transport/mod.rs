//! Steps of paths: meeting a surface, asking who sees whom, one integral of reflection.

pub mod casters;
pub(crate) mod diffuse;
mod medium;
pub mod reflection;
mod tracer;
mod vertex;

pub use tracer::Tracer;
pub(crate) use tracer::are_apart;
pub use vertex::{Densities, Scattering, SurfaceVertex, VertexSample};
