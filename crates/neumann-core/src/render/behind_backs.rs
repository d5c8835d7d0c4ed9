//! Do the backs of single-sided surfaces hide what the camera is to see?
//!
//! Other programs leave such backs out: a room is seen from outside through its walls, a model
//! through the hull that draws its outline. Here they are solid, unless one says otherwise
//! ([`Backs`](crate::scene::Backs)), so somebody has to be told. A pilot of a few hundred rays
//! counts those that meet a back first, and something other than a back behind it.

use glam::Vec2;

use crate::accel::Hit;
use crate::endpoint::Camera;
use crate::math::Ray;
use crate::scene::Scene;
use crate::scene::description::CameraDescription;
use crate::transport::Tracer;

/// Rows of the pilot, and its most columns.
const ROWS: usize = 24;
const MOST_COLUMNS: usize = 48;

/// Of the rays that meet anything, the share that must be kept from what is behind a back.
const MUCH: f32 = 0.2;
/// The same of all rays, so that a few pixels do not make a picture.
const FEW: f32 = 0.01;

/// Of what a camera sees, the share that is hidden by backs of single-sided surfaces; `None` where
/// that is not worth a word, or the camera looks through them.
#[must_use]
pub fn hidden_by_backs(scene: &Scene, camera: &CameraDescription) -> Option<f32> {
    if !scene.has_backs() || scene.sees_through_backs() {
        return None;
    }
    let aspect = camera.aspect_ratio.filter(|a| a.is_finite());
    let columns = (ROWS as f32 * aspect.unwrap_or(1.0)) as usize;
    let columns = columns.clamp(ROWS / 2, MOST_COLUMNS);
    let camera = Camera::new(camera, columns, ROWS);
    let mut tracer = Tracer::new(scene);
    let (mut n_met, mut n_hidden) = (0u32, 0u32);
    for i in 0..columns * ROWS {
        let raster = Vec2::new((i % columns) as f32 + 0.5, (i / columns) as f32 + 0.5);
        let ray = camera.ray(raster, [0.5, 0.5]).ray;
        if let Some(hit) = tracer.hit(&ray) {
            n_met += 1;
            n_hidden += u32::from(hides(&mut tracer, &ray, &hit));
        }
    }
    let share = n_hidden as f32 / n_met.max(1) as f32;
    let is_much = share >= MUCH && n_hidden as f32 >= FEW * (columns * ROWS) as f32;
    is_much.then_some(share)
}

/// True if a ray meets a back first, and behind it anything but backs.
fn hides(tracer: &mut Tracer<'_>, ray: &Ray, first: &Hit) -> bool {
    if !tracer.is_back(ray, first) {
        return false;
    }
    let behind = tracer.crossings(ray);
    let is_seen = |hit: &Hit| tracer.opacity(ray, hit) >= 0.5 && !tracer.is_back(ray, hit);
    behind.iter().any(is_seen)
}
