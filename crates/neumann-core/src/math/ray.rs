//! Rays, and how a new one leaves a surface without meeting it again.

use glam::{Vec3, Vec4};

/// A half-line or segment in world space.
///
/// It is kept as two whole vectors, as the traversal reads it: written to memory in pieces of other sizes, it could
/// not be read until it is in the cache.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts, and the distance where it ends.
    origin_and_end: Vec4,
    /// Where it goes, and 1. Unit, unless it was made to measure in another length.
    pub(crate) direction_and_one: Vec4,
}

impl Ray {
    /// A ray without an end, from a point (metres) in a direction (unit).
    #[inline(always)]
    #[must_use]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self::with_end(origin, direction, f32::INFINITY)
    }

    /// A ray on which hits at the distance `t_max` or beyond do not count: metres, or, if the direction is not unit, as many
    /// times its length.
    #[inline(always)]
    #[must_use]
    pub fn with_end(origin: Vec3, direction: Vec3, t_max: f32) -> Self {
        Self {
            origin_and_end: origin.extend(t_max),
            direction_and_one: direction.extend(1.0),
        }
    }

    /// Where it starts, metres.
    #[inline(always)]
    #[must_use]
    pub fn origin(&self) -> Vec3 {
        self.origin_and_end.truncate()
    }

    /// Where it goes; unit for rays without an end.
    #[inline(always)]
    #[must_use]
    pub fn direction(&self) -> Vec3 {
        self.direction_and_one.truncate()
    }

    /// Hits at this distance or beyond do not count, in lengths of the direction.
    #[inline(always)]
    #[must_use]
    pub fn t_max(&self) -> f32 {
        self.origin_and_end.w
    }

    /// The point at distance `t`.
    #[inline]
    #[must_use]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin() + self.direction() * t
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
