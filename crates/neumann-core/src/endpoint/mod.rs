//! Both ends of a path under one contract: lights and cameras.
//!
//! An endpoint can start a ray ([`Start`]) and can be aimed at from a point
//! ([`Aim`]); both carry the densities of both, so that a walk from either end
//! can be weighed against one from the other. What it sends out is radiance for a
//! light and importance for a camera; light tracing is path tracing read backwards.
//!
//! Densities contain the probability with which the endpoint was chosen. Where an
//! endpoint has no extent in position or direction, the density there stands for a
//! Dirac delta's coefficient and the flags say so.

mod camera;
pub mod light;

pub use camera::{Camera, CameraRay, LensHit};
pub(crate) use light::ReceiverLanes;
pub use light::{Light, LightChoice, Lights, Receiver};

use glam::Vec3;

use crate::math::Ray;
use crate::math::ray::{LENS, NO_TRIANGLE};
use crate::radiometry::Rgb;

/// A point of a surface, right to the rounding of its coordinates.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// World space, metres.
    pub position: Vec3,
    /// Index of the triangle that it is on, or [`NO_TRIANGLE`].
    pub triangle: u32,
    /// Geometric normal, unit, towards the front side.
    pub ng: Vec3,
}

impl SurfacePoint {
    /// No point at all.
    pub(crate) const NOWHERE: Self = Self {
        position: Vec3::ZERO,
        triangle: NO_TRIANGLE,
        ng: Vec3::ZERO,
    };

    /// The ray that leaves it along `direction`, unit.
    #[inline(always)]
    #[must_use]
    pub fn ray(&self, direction: Vec3) -> Ray {
        Ray::new(self.position, direction).leaving(self.triangle)
    }

    /// The ray from here to another point of a surface. It measures in their distance, so that it
    /// waits for no root and no
    /// division.
    #[inline(always)]
    #[must_use]
    pub fn segment_to(&self, to: &Self) -> Ray {
        self.segment(to.position).aimed_at(to.triangle)
    }

    /// The ray from here to a point of the lens.
    #[inline(always)]
    #[must_use]
    pub fn segment_to_lens(&self, to: Vec3) -> Ray {
        self.segment(to).aimed_at(LENS)
    }

    /// The ray from here to a point that is on no surface.
    #[inline(always)]
    #[must_use]
    pub fn segment(&self, to: Vec3) -> Ray {
        Ray::with_end(self.position, to - self.position, 1.0).leaving(self.triangle)
    }
}

/// Densities with which an endpoint would have started a given ray.
#[derive(Clone, Copy, Debug, Default)]
pub struct StartDensities {
    /// Of the position: 1/m² on the endpoint, or on a plane across the ray for one at infinity;
    /// 1 times the probability of choice for a single position.
    pub pdf_a: f32,
    /// Of the direction: 1/sr; 1 for a single direction.
    pub pdf_w: f32,
}

/// How the rays of one endpoint fan out over the scene: from one of its points, or, for an endpoint
/// at infinity, in one of its directions.
#[derive(Clone, Copy, Debug)]
pub enum Spread {
    /// All from one point: density of the direction, 1/sr.
    Point {
        /// 1/sr.
        pdf_w: f32,
    },
    /// All in one direction: density of the position on a plane across it, 1/m².
    Parallel {
        /// 1/m².
        pdf_a: f32,
    },
}

impl Spread {
    /// Density with which a ray gets to a point `distance` metres away, 1/m² across the ray.
    #[inline]
    #[must_use]
    pub fn pdf_a_across(self, distance: f32) -> f32 {
        match self {
            Self::Point { pdf_w } => pdf_w / (distance * distance),
            Self::Parallel { pdf_a } => pdf_a,
        }
    }
}

/// A ray started by an endpoint.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Where it starts, world space.
    pub position: Vec3,
    /// Index of the triangle that it is on, or [`NO_TRIANGLE`].
    pub triangle: u32,
    /// Normal of the endpoint there (the direction itself where there is no surface).
    pub ng: Vec3,
    /// Direction of the ray, unit.
    pub direction: Vec3,
    /// Radiance or importance sent along it.
    pub value: Rgb,
    /// Cosine between direction and normal; 1 where there is no surface.
    pub cos: f32,
    /// Densities of position and direction.
    pub densities: StartDensities,
    /// How the rays fan out from here; the choice of the endpoint is not in it.
    pub spread: Spread,
    /// Which of the lights it is.
    pub light: usize,
    /// Triangle and barycentric coordinates of the position, if it is on a surface.
    pub on_triangle: Option<(u32, [f32; 2])>,
    /// How much of the surface is there: the probability that a ray that comes to the position
    /// meets it. It is in `value`.
    pub opacity: f32,
    /// True where all rays start at one position.
    pub is_delta_position: bool,
    /// True where all rays have one direction.
    pub is_delta_direction: bool,
}

impl Start {
    /// What the ray carries, over the density with which it was started: power for a light.
    #[inline(always)]
    #[must_use]
    pub fn throughput(&self) -> Rgb {
        self.value * (self.cos / (self.densities.pdf_a * self.densities.pdf_w))
    }

    /// True if its endpoint is infinitely far away.
    #[inline]
    #[must_use]
    pub fn is_at_infinity(&self) -> bool {
        matches!(self.spread, Spread::Parallel { .. })
    }

    /// Where it starts, as a point of a surface.
    #[inline(always)]
    #[must_use]
    pub fn point(&self) -> SurfacePoint {
        SurfacePoint {
            position: self.position,
            triangle: self.triangle,
            ng: self.ng,
        }
    }

    /// The ray.
    #[inline(always)]
    #[must_use]
    pub fn ray(&self) -> Ray {
        self.point().ray(self.direction)
    }
}

/// An endpoint aimed at from a point x.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    /// Direction from x, unit.
    pub wi: Vec3,
    /// Distance from x, metres; infinite for an endpoint at infinity.
    pub distance: f32,
    /// Radiance or importance arriving at x; for a single direction (`is_delta`), the
    /// irradiance (or its like) on a surface across it.
    pub value: Rgb,
    /// Density of `wi`, 1/sr; for a single direction, the probability of the endpoint.
    pub pdf_w: f32,
    /// True if no direction drawn at x could ever find the endpoint.
    pub is_delta: bool,
    /// Cosine at the endpoint; 1 where there is no surface.
    pub cos_at_endpoint: f32,
    /// The point aimed at, if it is on a surface.
    pub surface: Option<SurfacePoint>,
    /// Densities with which the endpoint would have started the ray to x.
    pub start: StartDensities,
    /// How the rays of the place aimed at fan out; the choice of the endpoint is not in it.
    pub spread: Spread,
    /// Probability of choosing this endpoint to start a ray, over that of choosing it to aim at
    /// from x.
    pub start_over_aim: f32,
    /// How much of the surface that is aimed at is there: the probability that a ray that comes to
    /// the point meets it. It is in `value`.
    pub opacity: f32,
    /// Which of the lights it is, if it is one.
    pub light: u32,
}
