//! A BSDF in the plane of normal and viewer, as finely as its lobes ask for.

use glam::Vec3;

use crate::bsdf::{Scatter, TransportMode};
use crate::radiometry::Rgb;

/// Degrees from one direction to the next where nothing happens.
const STEP: f32 = 2.0;
/// Degrees from the surface of the last direction before it, and of the first one behind.
const AT_SURFACE: f32 = 0.02;
/// Directions are added between two whose values are so far apart, as a share of the largest one,
const JUMP: f32 = 0.02;
/// or as a factor, as far as that is drawn on a logarithmic scale,
const FACTOR: f32 = 1.3;
const SMALLEST: f32 = 1e-5;
/// but so often at most.
const HALVINGS: u32 = 7;
/// Offsets from a peak, degrees: the first, and the factor to the next.
const FIRST: f32 = 0.02;
const GROWTH: f32 = 1.6;

/// The BSDF in one direction of the plane.
#[derive(Clone, Copy, Debug)]
pub struct PolarPoint {
    /// Angle to z, degrees in [-180, 180]; the viewer's is negative.
    pub angle: f32,
    /// The direction.
    pub wi: Vec3,
    /// `f(wo, wi)`, 1/sr.
    pub f: Rgb,
    /// Density, 1/sr.
    pub pdf_w: f32,
}

/// The direction at an angle to z, degrees.
#[must_use]
pub fn direction_at(angle: f32) -> Vec3 {
    let (sin, cos) = angle.to_radians().sin_cos();
    Vec3::new(sin, 0.0, cos)
}

/// Offsets about a peak, degrees, on either side.
pub(super) fn offsets(most: f32) -> impl Iterator<Item = f32> {
    let steps = std::iter::successors(Some(FIRST), |step| Some(step * GROWTH));
    let steps = steps.take_while(move |step| *step < most);
    std::iter::once(0.0).chain(steps.flat_map(|step| [-step, step]))
}

/// All directions of the plane, from -180° to 180°.
pub(super) fn curve(bsdf: &impl Scatter, wo: Vec3, peaks: &[Vec3]) -> Vec<PolarPoint> {
    let point = |angle: f32| {
        let wi = direction_at(angle);
        let (f, pdf_w) = bsdf.eval_and_pdf_w(wo, wi, TransportMode::Radiance);
        PolarPoint {
            angle,
            wi,
            f,
            pdf_w,
        }
    };
    let n = (360.0 / STEP) as usize;
    let mut angles: Vec<f32> = (0..=n).map(|i| -180.0 + i as f32 * STEP).collect();
    for side in [-90.0, 90.0] {
        angles.retain(|angle: &f32| (angle - side).abs() > AT_SURFACE);
        angles.extend([side - AT_SURFACE, side + AT_SURFACE]);
    }
    for peak in peaks {
        // Out of the plane it is as far from z.
        let angle = peak.z.clamp(-1.0, 1.0).acos().to_degrees().copysign(peak.x);
        angles.extend(offsets(30.0).map(|offset| angle + offset));
    }
    angles.retain(|angle| angle.abs() <= 180.0 && !touches_surface(*angle));
    angles.sort_by(f32::total_cmp);
    angles.dedup();
    let coarse: Vec<PolarPoint> = angles.into_iter().map(point).collect();
    let largest = |of: &dyn Fn(&PolarPoint) -> f32| coarse.iter().map(of).fold(0.0, f32::max);
    let most = [
        largest(&|p| p.f.max_channel()),
        largest(&|p| p.f.max_channel() * p.wi.z.abs()),
        largest(&|p| p.pdf_w),
    ];
    let mut fine = Vec::with_capacity(2 * coarse.len());
    for pair in coarse.windows(2) {
        fine.push(pair[0]);
        between(pair[0], pair[1], &point, most, HALVINGS, &mut fine);
    }
    fine.extend(coarse.last());
    fine
}

fn touches_surface(angle: f32) -> bool {
    (angle.abs() - 90.0).abs() < 0.5 * AT_SURFACE
}

/// Adds what is missing between two directions.
fn between(
    a: PolarPoint,
    b: PolarPoint,
    point: &impl Fn(f32) -> PolarPoint,
    most: [f32; 3],
    n_halvings: u32,
    found: &mut Vec<PolarPoint>,
) {
    let values = |p: PolarPoint| {
        let f = p.f.max_channel();
        [f, f * p.wi.z.abs(), p.pdf_w]
    };
    let is_far = |((a, b), most): ((f32, f32), f32)| {
        let (low, high) = (a.min(b), a.max(b));
        high - low > JUMP * most || (high > SMALLEST * most && high > FACTOR * low)
    };
    let mut values = values(a).into_iter().zip(values(b)).zip(most);
    let angle = 0.5 * (a.angle + b.angle);
    // Nothing is smooth across the surface.
    let is_crossing = a.wi.z * b.wi.z < 0.0;
    if n_halvings == 0 || is_crossing || !values.any(is_far) {
        return;
    }
    let middle = point(angle);
    between(a, middle, point, most, n_halvings - 1, found);
    found.push(middle);
    between(middle, b, point, most, n_halvings - 1, found);
}
