//! Points of triangles.

use glam::Vec3;

/// The point of a triangle with the given barycentric coordinates of the second and third corner:
/// right to the rounding of its
/// own coordinates, however far away the corners are.
#[inline(always)]
#[must_use]
pub fn point_between(corners: &[Vec3; 3], b: [f32; 2]) -> Vec3 {
    let [u, v] = b.map(f64::from);
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (a * (1.0 - u - v) + b * u + c * v).as_vec3()
}
