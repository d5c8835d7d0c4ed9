//! Whose lobes are looked at: a material of the scene, or what a pixel shows.

use crate::bsdf::Bsdf;
use crate::material::SurfaceInputs;
use crate::render::RenderSettings;
use crate::render::hemisphere::{NoSurface, Seen, ray_of_pixel};
use crate::scene::Scene;
use crate::transport::Tracer;

/// A surface that scatters.
#[derive(Clone, Debug)]
pub struct Surface {
    /// How it scatters.
    pub bsdf: Bsdf,
    /// Number of its material.
    pub material: usize,
    /// True if it is seen from behind.
    pub is_behind: bool,
    /// Angle under which it is seen, degrees, where a pixel shows it.
    pub angle: Option<f32>,
}

impl Surface {
    /// Of a material by its number, without a place: its textures are read at (0, 0).
    ///
    /// # Errors
    /// If there is no such material, or it scatters no light.
    pub fn of_material(scene: &Scene, material: usize) -> Result<Self, NoSurface> {
        let found = scene.materials().get(material).ok_or(NoSurface::Nothing)?;
        let bsdf = found.bsdf(&SurfaceInputs::NONE);
        if matches!(bsdf, Bsdf::Black) {
            return Err(NoSurface::ScattersNothing);
        }
        Ok(Self {
            bsdf,
            material,
            is_behind: false,
            angle: None,
        })
    }

    /// Of the first surface that the ray through the middle of a pixel (column and row) meets, with
    /// its textures there.
    ///
    /// # Errors
    /// If there is no surface that scatters light.
    pub fn of_pixel(
        scene: &Scene,
        settings: &RenderSettings,
        pixel: [u32; 2],
    ) -> Result<Self, NoSurface> {
        let ray = ray_of_pixel(settings, pixel);
        let mut tracer = Tracer::new(scene);
        let seen = Seen::along(&ray, &mut tracer).ok_or(NoSurface::Nothing)?;
        let vertex = &seen.vertex;
        if matches!(vertex.bsdf, Bsdf::Black) {
            return Err(NoSurface::ScattersNothing);
        }
        let geometry = scene.geometry();
        let mesh = geometry.facet(vertex.triangle).mesh as usize;
        let material = geometry.meshes().get(mesh).map(|mesh| mesh.material);
        let cos = vertex.wo_local.z;
        Ok(Self {
            bsdf: vertex.bsdf,
            material: material.unwrap_or_default() as usize,
            is_behind: cos < 0.0,
            angle: Some(cos.abs().min(1.0).acos().to_degrees()),
        })
    }
}
