//! Rays, and how a new one leaves a surface without meeting it again.

use glam::Vec3;

/// A half-line or segment in world space.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts, metres.
    pub origin: Vec3,
    /// Where it goes, unit.
    pub direction: Vec3,
    /// Hits at this distance or beyond do not count, metres.
    pub t_max: f32,
}

impl Ray {
    /// A ray without an end.
    #[inline]
    #[must_use]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self {
            origin,
            direction,
            t_max: f32::INFINITY,
        }
    }

    /// The point at distance `t`.
    #[inline]
    #[must_use]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// Moves a surface point off its surface, to the side of `towards`.
///
/// `error` bounds the rounding error of `p` along any axis, in metres; the
/// point is moved along the geometric normal by what that error amounts to, so
/// the offset grows and shrinks with the scene (\[PBR4\] 6.8.6 does the same with
/// an error bound per axis).
#[inline]
#[must_use]
pub fn offset_point(p: Vec3, error: f32, ng: Vec3, towards: Vec3) -> Vec3 {
    p + ng * error.copysign(ng.dot(towards))
}
