//! What the camera sees first: albedo, normal and depth at pixel centres.
//!
//! They carry no noise and take no part in the series; files keep them for
//! denoisers and for compositing.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::endpoint::Camera;
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::scene::description::CameraDescription;
use crate::transport::Tracer;

/// First-hit features, row 0 on top.
#[derive(Clone, Debug, Default)]
pub struct Features {
    /// Pixels per row.
    pub width: usize,
    /// Share of light reflected or transmitted at the first surface, 0 where the ray leaves the
    /// scene.
    pub albedo: Vec<Rgb>,
    /// Shading normal in world space, unit, 0 where the ray leaves the scene.
    pub normal: Vec<Vec3>,
    /// Distance along the view axis, metres; infinite where the ray leaves the scene.
    pub depth: Vec<f32>,
}

impl Features {
    /// Traces one ray through the middle of each pixel and of the lens.
    #[must_use]
    pub fn trace(scene: &Scene, camera: &CameraDescription, width: usize, height: usize) -> Self {
        let camera = Camera::new(camera, width, height);
        let pixels: Vec<(Rgb, Vec3, f32)> = (0..width * height)
            .into_par_iter()
            .with_min_len(256)
            .map(|i| {
                let raster = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
                let ray = camera.ray(raster, [0.5, 0.5]).ray;
                match Tracer::new(scene).vertex(&ray) {
                    None => (Rgb::BLACK, Vec3::ZERO, f32::INFINITY),
                    Some(vertex) => {
                        let cos = vertex.frame.z.dot(vertex.wo).abs();
                        let depth = vertex.distance * ray.direction().dot(camera.forward());
                        (vertex.bsdf.albedo(cos), vertex.frame.z, depth)
                    }
                }
            })
            .collect();
        Self {
            width,
            albedo: pixels.iter().map(|p| p.0).collect(),
            normal: pixels.iter().map(|p| p.1).collect(),
            depth: pixels.iter().map(|p| p.2).collect(),
        }
    }
}
