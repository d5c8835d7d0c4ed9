//! The pixel as a ray, for whoever renders it for comparison.

use glam::Vec2;

use crate::endpoint::Camera;
use crate::math::Ray;
use crate::render::RenderSettings;
use crate::scene::description::Crop;

/// A picture of the ray through the middle of a pixel is so many times enlarged, and has so many
/// pixels in either direction.
const ENLARGED: usize = 1024;
const SPOT: usize = 8;

/// The ray through the middle of the lens and of a pixel (column and row).
pub(in crate::render) fn ray_of_pixel(settings: &RenderSettings, pixel: [u32; 2]) -> Ray {
    let camera = Camera::new(&settings.camera, settings.width, settings.height);
    let raster = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5);
    camera.ray(raster, [0.5, 0.5]).ray
}

/// Settings by which a picture of hardly more than the ray through the middle of a pixel is
/// rendered: a few pixels, as small parts of that one, seen through the middle of the lens.
#[must_use]
pub fn settings_of_ray(settings: &RenderSettings, pixel: [u32; 2]) -> RenderSettings {
    let mut settings = settings.clone();
    let whole = Crop {
        of: [settings.width, settings.height],
        at: [0; 2],
        size: [settings.width, settings.height],
    };
    let crop = settings.camera.crop.unwrap_or(whole);
    let at = [0, 1].map(|i| (crop.at[i] + pixel[i] as usize) * ENLARGED + (ENLARGED - SPOT) / 2);
    settings.camera.crop = Some(Crop {
        of: crop.of.map(|n| n * ENLARGED),
        at,
        size: [SPOT; 2],
    });
    settings.camera.lens = None;
    (settings.width, settings.height) = (SPOT, SPOT);
    settings
}
