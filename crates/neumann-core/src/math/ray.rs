//! Rays: lines that know where they start and end.
//!
//! A ray that starts on a triangle starts at the very point, and is told which triangle that is: it
//! is not met again, and
//! nothing is moved to get away from it. So is a ray that ends on one.

use glam::{Vec3, Vec4};

/// In the place of a triangle's index: none.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// In the place of a triangle's index: the lens of the camera.
pub const LENS: u32 = u32::MAX - 1;

/// The index itself, if there is a triangle in its place.
#[inline(always)]
#[must_use]
pub fn triangle_of(index: u32) -> Option<u32> {
    (index < LENS).then_some(index)
}

/// A half-line or segment in world space.
///
/// Place and direction are kept as two whole vectors, as the traversal reads them: written to
/// memory in pieces of other
/// sizes, they could not be read until they are in the cache.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts, and the distance where it ends.
    origin_and_end: Vec4,
    /// Where it goes, and 1. Unit, unless it was made to measure in another length.
    pub(crate) direction_and_one: Vec4,
    /// The triangle that it starts on,
    leaves: u32,
    /// and the one that it ends on.
    aims_at: u32,
}

impl Ray {
    /// A ray without an end, from a point (metres) in a direction (unit).
    #[inline(always)]
    #[must_use]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self::with_end(origin, direction, f32::INFINITY)
    }

    /// A ray on which hits at the distance `t_max` or beyond do not count: metres, or, if the
    /// direction is not unit, as many times its length.
    #[inline(always)]
    #[must_use]
    pub fn with_end(origin: Vec3, direction: Vec3, t_max: f32) -> Self {
        Self {
            origin_and_end: origin.extend(t_max),
            direction_and_one: direction.extend(1.0),
            leaves: NO_TRIANGLE,
            aims_at: NO_TRIANGLE,
        }
    }

    /// The same ray, which starts on a triangle and does not meet it.
    #[inline(always)]
    #[must_use]
    pub fn leaving(self, triangle: u32) -> Self {
        Self {
            leaves: triangle,
            ..self
        }
    }

    /// The same ray with another end.
    #[inline(always)]
    #[must_use]
    pub fn ending(self, t_max: f32) -> Self {
        Self {
            origin_and_end: self.origin().extend(t_max),
            ..self
        }
    }

    /// The same ray, which ends on a triangle and does not meet it.
    #[inline(always)]
    #[must_use]
    pub fn aimed_at(self, triangle: u32) -> Self {
        Self {
            aims_at: triangle,
            ..self
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

    /// The triangle that it starts on, or [`LENS`] or [`NO_TRIANGLE`].
    #[inline(always)]
    #[must_use]
    pub fn leaves(&self) -> u32 {
        self.leaves
    }

    /// The triangle that it ends on, or [`LENS`] or [`NO_TRIANGLE`].
    #[inline(always)]
    #[must_use]
    pub fn aims_at(&self) -> u32 {
        self.aims_at
    }

    /// True if the lens is at one of its ends.
    #[inline(always)]
    #[must_use]
    pub fn meets_lens(&self) -> bool {
        self.leaves == LENS || self.aims_at == LENS
    }

    /// True if the lens at one of its ends sees a surface with this normal from behind.
    #[inline]
    #[must_use]
    pub fn shows_back_of(&self, ng: Vec3) -> bool {
        let along = ng.dot(self.direction());
        (self.leaves == LENS && along > 0.0) || (self.aims_at == LENS && along < 0.0)
    }

    /// The point at distance `t`.
    #[inline]
    #[must_use]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin() + self.direction() * t
    }
}
