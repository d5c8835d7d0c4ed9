//! Points of triangles, and triangles in one plane.

use glam::{DVec2, DVec3, Vec3};

/// A point touches a surface if that is no farther away than this share of its largest coordinate:
/// four times what it is rounded by.
const TOUCH: f64 = 1.0 / 2_097_152.0;

/// A triangle in double precision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExactTriangle {
    pub(crate) corners: [DVec3; 3],
    /// Unit, towards the front.
    pub(crate) normal: DVec3,
}

/// The point of a triangle with the given barycentric coordinates of the second and third corner:
/// right to the rounding of its own coordinates, however far away the corners are.
#[inline(always)]
#[must_use]
pub fn point_between(corners: &[Vec3; 3], b: [f32; 2]) -> Vec3 {
    let [u, v] = b.map(f64::from);
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (a * (1.0 - u - v) + b * u + c * v).as_vec3()
}

impl ExactTriangle {
    pub(crate) fn new(corners: &[Vec3; 3]) -> Self {
        let corners = corners.map(Vec3::as_dvec3);
        let [a, b, c] = corners;
        Self {
            corners,
            normal: (b - a).cross(c - a).normalize_or_zero(),
        }
    }

    /// How far a point is above its plane.
    pub(crate) fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.corners[0])
    }

    /// True if a point, which is rounded as another one is or as its own coordinates are, may lie
    /// in its plane.
    pub(crate) fn touches(&self, point: DVec3, rounded_as: DVec3) -> bool {
        let rounding = rounding_of(point).max(rounding_of(rounded_as));
        self.height(point).abs() <= rounding
    }

    /// True if it lies in the plane of another one.
    pub(crate) fn lies_in(&self, other: &Self) -> bool {
        self.corners.iter().all(|c| other.touches(*c, *c))
    }

    /// True if it overlaps another triangle of the same plane, by more than rounding: no edge of
    /// either keeps them apart.
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        let axis = self.normal.abs();
        let flat = |p: DVec3| {
            if axis.x >= axis.y && axis.x >= axis.z {
                DVec2::new(p.y, p.z)
            } else if axis.y >= axis.z {
                DVec2::new(p.z, p.x)
            } else {
                DVec2::new(p.x, p.y)
            }
        };
        let rounding = |t: &Self| t.corners.iter().fold(0.0, |r, c| rounding_of(*c).max(r));
        let rounding = rounding(self).min(rounding(other));
        let [a, b] = [self, other].map(|t| t.corners.map(flat));
        !is_kept_apart(&a, &b, rounding) && !is_kept_apart(&b, &a, rounding)
    }
}

/// True if an edge of one triangle has another triangle on its far side.
fn is_kept_apart(one: &[DVec2; 3], other: &[DVec2; 3], rounding: f64) -> bool {
    (0..3).any(|i| {
        let (from, to, inside) = (one[i], one[(i + 1) % 3], one[(i + 2) % 3]);
        let along = (to - from).normalize_or_zero();
        let side = along.perp_dot(inside - from).signum();
        let within = |p: &DVec2| side * along.perp_dot(*p - from) > rounding;
        !other.iter().any(within)
    })
}

/// By how much a point with such coordinates may be off a surface that it was meant to lie on.
pub(crate) fn rounding_of(point: DVec3) -> f64 {
    TOUCH * point.abs().max_element()
}
