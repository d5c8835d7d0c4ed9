//! Does a scene's own light show what its camera sees?
//!
//! A glowing detail (the visor of a helmet, a flame in a lantern) is a light, yet leaves nearly all
//! that is seen black. A pilot render of a few hundred pixels by the default method tells such a
//! scene from a room lit by its lamp: the median of what a white surface would show, over the
//! pixels that do not glow themselves. Where somebody has set up lamps (punctual lights), one pixel
//! that they light is enough: the rest is dark because it is meant to be. It is the same on every
//! machine, since it is a render like any other.

use std::sync::Arc;

use super::{CancelToken, RenderSettings, Renderer, WorkerPool};
use crate::film::{Features, Film};
use crate::scene::Scene;

/// Rows of the pilot, and its most columns.
const ROWS: usize = 24;
const MOST_COLUMNS: usize = 48;
const N_ITERATIONS: u32 = 8;
/// Terms of the pilot: what is lit by way of two walls counts.
const MAX_BOUNCES: u32 = 4;

/// A pixel shows an emitter, or something unlit, from this radiance on.
const GLOW: f32 = 0.02;
/// A share of pixels that show no emitter too small to matter.
const FEW: f32 = 0.02;
/// Albedos below this count as this: black paint in a lit room is no sign of darkness.
const LEAST_ALBEDO: f32 = 0.1;
/// A white surface below this radiance is dim on a screen at exposure 0 …
const DIM: f32 = 0.03;
/// … unless it has this part of the brightest emitter seen: the room is dim because its lamp is.
const DIM_BESIDE_EMITTER: f32 = 0.003;
/// The same where no emitter is seen.
const DARK: f32 = 0.002;

/// The scene under the built-in sky `studio`, if its own light hardly shows what its first camera
/// sees; otherwise as it is.
#[must_use]
pub fn lit(scene: Scene) -> Scene {
    if !scene.may_have_default_sky() || scene.geometry().n_triangles() == 0 {
        return scene;
    }
    let scene = Arc::new(scene);
    let is_dim = is_dim(&scene);
    let scene = Arc::unwrap_or_clone(scene);
    if is_dim {
        scene.with_default_sky("the scene's own light hardly shows what the camera sees")
    } else {
        scene
    }
}

/// What a pixel of the pilot tells.
#[derive(Clone, Copy, Debug)]
struct PilotPixel {
    /// Radiance that the surface emits itself.
    glow: f32,
    /// Radiance that a white surface would show there.
    lit: f32,
}

fn is_dim(scene: &Arc<Scene>) -> bool {
    let deciding = if scene.appearance().lights.is_empty() {
        Deciding::Median
    } else {
        Deciding::Brightest
    };
    // Without threads there will be no picture either.
    WorkerPool::new(Some(1), || ()).is_ok_and(|pool| judge(&pilot(scene, &pool), deciding))
}

/// The pixels of the pilot that show a surface.
fn pilot(scene: &Arc<Scene>, pool: &WorkerPool) -> Vec<PilotPixel> {
    let camera = scene.cameras()[0].clone();
    let aspect = camera.aspect_ratio.filter(|a| a.is_finite());
    let columns = (ROWS as f32 * aspect.unwrap_or(1.0)) as usize;
    let columns = columns.clamp(ROWS / 2, MOST_COLUMNS);
    let mut settings = RenderSettings::new(camera, columns, ROWS);
    settings.max_bounces = MAX_BOUNCES;
    settings.n_layers = 1;
    let features = pool.run(|| Features::trace(scene, &settings.camera, columns, ROWS));
    let mut film = Film::new(columns, ROWS, 1);
    let mut renderer = Renderer::new(Arc::clone(scene), settings, pool.clone(), 0);
    for _ in 0..N_ITERATIONS {
        // Nobody cancels.
        if let Ok(frame) = renderer.iterate(&CancelToken::default()) {
            film.add(frame);
        }
    }
    let [emitted, scattered] = [&film.layers()[0], &film.layers()[1]];
    let seen = features.depth.iter().enumerate();
    seen.filter(|(_, depth)| depth.is_finite())
        .map(|(i, _)| {
            let albedo = features.albedo[i].luminance().max(LEAST_ALBEDO);
            let glow = emitted[i].luminance();
            let lit = (glow + scattered[i].luminance()) / albedo;
            PilotPixel { glow, lit }
        })
        .collect()
}

/// Which pixel says whether a scene is dim.
#[derive(Clone, Copy, Debug)]
enum Deciding {
    Median,
    Brightest,
}

/// True if what does not glow itself is dim.
fn judge(pixels: &[PilotPixel], deciding: Deciding) -> bool {
    let is_unlike_emitter = |pixel: &&PilotPixel| pixel.glow < GLOW;
    let mut lit: Vec<f32> = pixels
        .iter()
        .filter(is_unlike_emitter)
        .map(|pixel| pixel.lit)
        .collect();
    if !pixels.is_empty() && (lit.len() as f32) < FEW * pixels.len() as f32 {
        return false;
    }
    lit.sort_unstable_by(f32::total_cmp);
    let deciding = match deciding {
        Deciding::Median => lit.get(lit.len() / 2),
        Deciding::Brightest => lit.last(),
    };
    let deciding = deciding.copied().unwrap_or(0.0);
    let brightest = pixels.iter().map(|pixel| pixel.glow).fold(0.0, f32::max);
    let floor = if brightest >= GLOW {
        DIM_BESIDE_EMITTER * brightest
    } else {
        DARK
    };
    deciding < floor.min(DIM)
}
