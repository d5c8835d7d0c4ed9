//! Warps from the unit square to directions and surfaces, each beside its density.
//!
//! Formulas as in Dutré, Global Illumination Compendium (2003), by the number
//! given; local directions have z as the normal.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, PI};

use glam::{Vec2, Vec3};

use crate::math::lanes::select;

/// Uniform on the unit disk, area preserving and continuous (Shirley and Chiu 1997); density 1/π.
#[inline]
#[must_use]
pub fn disk(u: [f32; 2]) -> Vec2 {
    disk_and_radius(u).0
}

/// A point of [`disk`] and its distance from the centre, which may be negative.
#[inline(always)]
fn disk_and_radius(u: [f32; 2]) -> (Vec2, f32) {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    // The angle from the nearer axis is at most an eighth of a turn. Which axis that is no
    // processor can predict, so it is chosen without a branch.
    let is_near_x = a.abs() > b.abs();
    let (r, across) = (select(is_near_x, a, b), select(is_near_x, b, a));
    let (sin, cos) = sin_cos_of_octant(FRAC_PI_4 * (across / if r == 0.0 { 1.0 } else { r }));
    let (x, y) = (select(is_near_x, cos, sin), select(is_near_x, sin, cos));
    (r * Vec2::new(x, y), r)
}

/// Sine and cosine of an angle in [-π/4, π/4] to single precision, by Chebyshev-economised Taylor
/// polynomials (Cody and Waite 1980, ch. 8).
#[inline(always)]
fn sin_cos_of_octant(x: f32) -> (f32, f32) {
    let z = x * x;
    let sin = ((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 0.166_666_55) * z * x + x;
    let cos = ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - 0.5 * z + 1.0;
    (sin, cos)
}

/// Uniform on the hemisphere z ≥ 0 (GI Compendium 34).
#[inline]
#[must_use]
pub fn uniform_hemisphere(u: [f32; 2]) -> Vec3 {
    let z = u[0];
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
    Vec3::new(r * cos, r * sin, z)
}

/// Density of [`uniform_hemisphere`], 1/sr.
pub const UNIFORM_HEMISPHERE_PDF_W: f32 = 0.5 * FRAC_1_PI;

/// Proportional to cos θ on the hemisphere z ≥ 0 (GI Compendium 35, by Malley's method).
#[inline(always)]
#[must_use]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let (p, r) = disk_and_radius(u);
    Vec3::new(p.x, p.y, (1.0 - r * r).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`], 1/sr; zero below.
#[inline]
#[must_use]
pub fn cosine_hemisphere_pdf_w(cos: f32) -> f32 {
    cos.max(0.0) * FRAC_1_PI
}

/// Uniform on the sphere (GI Compendium 33).
#[inline]
#[must_use]
pub fn uniform_sphere(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
    Vec3::new(r * cos, r * sin, z)
}

/// Density of [`uniform_sphere`], 1/sr.
pub const UNIFORM_SPHERE_PDF_W: f32 = 0.25 * FRAC_1_PI;

/// Uniform in the cone about +z of which 1 less the cosine of the half-angle is `height` (GI
/// Compendium 38).
#[inline]
#[must_use]
pub fn uniform_cone(u: [f32; 2], height: f32) -> Vec3 {
    let depth = u[0] * height;
    let r = (depth * (2.0 - depth)).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
    Vec3::new(r * cos, r * sin, 1.0 - depth)
}

/// Density of [`uniform_cone`], 1/sr, within the cone.
#[inline]
#[must_use]
pub fn uniform_cone_pdf_w(height: f32) -> f32 {
    1.0 / (2.0 * PI * height)
}

/// Barycentric coordinates of v1 and v2, uniform on a triangle; density 1/area.
///
/// Folds the square along its diagonal with low distortion (Heitz 2019, "A
/// Low-Distortion Map Between Triangle and Square").
#[inline]
#[must_use]
pub fn triangle(u: [f32; 2]) -> [f32; 2] {
    let fold = 0.5 * u[0].min(u[1]);
    [u[0] - fold, u[1] - fold]
}

#[cfg(test)]
mod tests {
    use super::{cosine_hemisphere, disk, sin_cos_of_octant, triangle, uniform_sphere};

    #[test]
    fn sines_of_an_octant_are_right_to_the_last_places() {
        for i in -1000..=1000 {
            let x = i as f32 / 1000.0 * std::f32::consts::FRAC_PI_4;
            let (sin, cos) = sin_cos_of_octant(x);
            let (exact_sin, exact_cos) = f64::from(x).sin_cos();
            assert!((f64::from(sin) - exact_sin).abs() < 1e-7);
            assert!((f64::from(cos) - exact_cos).abs() < 1e-7);
        }
    }

    #[test]
    fn ends_of_the_square_land_where_they_should() {
        assert!(disk([0.5, 0.5]).length() < 1e-6);
        assert!((disk([1.0, 0.5]).x - 1.0).abs() < 1e-6);
        assert!((uniform_sphere([0.0, 0.3]).z - 1.0).abs() < 1e-6);
        assert!((cosine_hemisphere([0.5, 0.5]).z - 1.0).abs() < 1e-6);
        assert_eq!(triangle([0.0, 0.0]), [0.0, 0.0]);
        assert_eq!(triangle([1.0, 0.0]), [1.0, 0.0]);
        assert_eq!(triangle([0.0, 1.0]), [0.0, 1.0]);
    }
}
