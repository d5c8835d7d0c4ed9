//! What lies at a place of the picture: a surface with its material, or the sky.

use glam::Vec2;
use neumann_core::endpoint::Camera;
use neumann_core::math::Ray;
use neumann_core::transport::Tracer;

use crate::display::image_area::Placement;
use crate::setup::Setup;

/// What was picked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Picked {
    /// A surface.
    Surface {
        /// Number of its material.
        material: usize,
        /// Which node's mesh it is, and which of its triangles, in words.
        place: String,
    },
    /// No surface: what stands around the scene.
    Sky,
}

/// The camera, and the ray from the middle of its lens to a share of the picture's width and
/// height.
#[must_use]
pub fn sight(setup: &Setup, placement: &Placement, fraction: [f32; 2]) -> Option<(Camera, Ray)> {
    let (w, h) = placement.size;
    let camera = Camera::new(setup.camera.as_ref()?.camera(), w, h);
    let raster = Vec2::new(fraction[0] * w as f32, fraction[1] * h as f32);
    let ray = camera.ray(raster, [0.5, 0.5]).ray;
    Some((camera, ray))
}

/// What the camera sees at a share of the picture's width and height; `None` without a scene.
#[must_use]
pub fn at(setup: &Setup, placement: &Placement, fraction: [f32; 2]) -> Option<Picked> {
    let scene = &setup.open.as_ref()?.scene;
    let (_, ray) = sight(setup, placement, fraction)?;
    let Some(vertex) = Tracer::new(scene).vertex(&ray) else {
        return Some(Picked::Sky);
    };
    let geometry = scene.geometry();
    let mesh = geometry.facet(vertex.triangle).mesh as usize;
    let mesh = geometry.meshes().get(mesh)?;
    let name = if mesh.name.is_empty() {
        "Node without a name".to_owned()
    } else {
        format!("Node or mesh '{}'", mesh.name)
    };
    let number = 1 + vertex.triangle.saturating_sub(mesh.first_triangle);
    let n = mesh.arrays.triangles.len();
    Some(Picked::Surface {
        material: mesh.material as usize,
        place: format!("{name}, triangle {number} of {n}"),
    })
}
