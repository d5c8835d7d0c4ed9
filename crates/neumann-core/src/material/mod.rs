//! What surfaces are made of: textures, and the BSDF they amount to at a point.

mod surface;
mod texture;

pub use surface::{Coverage, Material, SurfaceInputs};
pub use texture::{ColorSpace, Texture, TextureImage};
