//! Steps of paths: meeting a surface, asking who sees whom, one integral of reflection.

mod bent;
mod bounce;
mod crossings;
pub(crate) mod diffuse;
mod lobes;
mod medium;
mod path_vertex;
pub mod reflection;
pub mod specular_casters;
mod tracer;
mod trail;
mod vertex;

pub use bounce::{Bounce, Scattered};
pub use lobes::Lobe;
pub(crate) use lobes::Lobes;
pub use path_vertex::{Event, PathVertex, Source, VertexKind};
pub use tracer::Tracer;
pub(crate) use tracer::is_segment;
pub(crate) use trail::{SharedTrail, Trail, WantedPaths};
pub use vertex::{Densities, Scattering, SurfaceVertex, VertexSample};
