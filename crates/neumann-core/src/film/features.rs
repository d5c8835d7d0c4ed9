//! What the camera sees first: albedo, normal and depth at pixel centres.
//!
//! They carry no noise and take no part in the series; files keep them for
//! denoisers and for compositing.

use glam::Vec3;

use crate::radiometry::Rgb;

/// First-hit features, row 0 on top.
#[derive(Clone, Debug, Default)]
pub struct Features {
    /// Share of light reflected or transmitted at the first surface, 0 where the ray leaves the scene.
    pub albedo: Vec<Rgb>,
    /// Shading normal in world space, unit, 0 where the ray leaves the scene.
    pub normal: Vec<Vec3>,
    /// Distance along the view axis, metres; infinite where the ray leaves the scene.
    pub depth: Vec<f32>,
}
