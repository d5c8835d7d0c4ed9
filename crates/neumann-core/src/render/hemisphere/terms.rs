//! What the reflection equation is taken apart into, and why it may not be there.

use glam::Vec3;

/// Why there is nothing to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoSurface {
    /// The ray leaves the scene.
    #[error("no surface is seen there: the ray through its middle leaves the scene")]
    Nothing,
    /// The surface is black.
    #[error("the surface seen there scatters no light: it is black, or has a colour of its own")]
    ScattersNothing,
}

/// How directions are drawn for an estimate of the integral.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// From the BSDF.
    Bsdf,
    /// A light is aimed at.
    Light,
    /// Both, weighed.
    Mis,
}

impl Estimator {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Bsdf, Self::Light, Self::Mis];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Bsdf => "BSDF sampling",
            Self::Light => "light sampling",
            Self::Mis => "MIS",
        }
    }

    /// The same for programs.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Self::Bsdf => "bsdf",
            Self::Light => "light",
            Self::Mis => "mis",
        }
    }
}

/// A picture over the directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integrand {
    /// `L_i`, W m⁻² sr⁻¹.
    Incident,
    /// `f`, 1/sr.
    Bsdf,
    /// `cos θ`.
    Cosine,
    /// `L_i f cos θ`, W m⁻² sr⁻².
    Product,
    /// The density of directions that an estimator draws, 1/sr; of both ways together, their mean.
    Density(Estimator),
}

/// A direction from which light comes that no picture has.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// World space, unit.
    pub direction: Vec3,
    /// True for a light without extent, false for a mirror-like lobe.
    pub is_light: bool,
}
