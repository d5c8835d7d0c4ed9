//! Photons: vertices of light paths, kept where they landed, and found again by place.
//!
//! The radiance that a surface scatters is estimated from the photons around a point,
//! `L(x, wo) ≈ Σ f(wo, w_j) Φ_j K(|x - x_j|)` (Jensen 2001, ch. 7), with a kernel K that
//! integrates to one over a disk.

mod hash_grid;
mod kernel;
mod map;
mod picture;

pub use hash_grid::{HashGrid, Near, Placed, Search};
pub use kernel::Kernel;
pub use map::PhotonMap;
pub(crate) use picture::Dot;
pub use picture::{PhotonPicture, PhotonStack};

use glam::Vec3;

use crate::bsdf::TransportMode;
use crate::endpoint::SurfacePoint;
use crate::radiometry::Rgb;
use crate::transport::{Scattering, SurfaceVertex};

/// A vertex of a light path, small enough to be kept by the million.
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// Where it landed, world space.
    pub position: Vec3,
    /// Index of the triangle that it landed on.
    pub triangle: u32,
    /// Geometric normal there, unit.
    pub ng: Vec3,
    /// Direction to where it came from, unit.
    pub wo: Vec3,
    /// Power, W, as if the whole scene had been lit by its path alone.
    pub power: Rgb,
    /// Vertices of its path, this one and the light included.
    pub n_vertices: u16,
    /// Where it landed on a wall between media, the numbers of their indices of refraction
    /// ([`SurfaceVertex::indices`]).
    pub(crate) indices: [u8; 2],
}

impl Placed for Photon {
    #[inline]
    fn position(&self) -> Vec3 {
        self.position
    }
}

/// What a surface makes of a photon.
#[derive(Clone, Copy, Debug)]
pub struct Scattered {
    /// `f Φ`, W/sr: times a kernel, radiance.
    pub f_power: Rgb,
    /// The BSDF with its densities.
    pub scattering: Scattering,
}

/// Photons whose surface is turned by more than this against the surface asked are on another one:
/// cosine.
const SAME_SURFACE: f32 = 0.7;

impl Photon {
    /// Where it landed, as a point of a surface.
    #[inline]
    #[must_use]
    pub fn point(&self) -> SurfacePoint {
        SurfacePoint {
            position: self.position,
            triangle: self.triangle,
            ng: self.ng,
        }
    }

    /// `f(wo, w_j) Φ_j` at a point that the photon is taken to have hit, to be multiplied by a
    /// kernel; `None` if it belongs to another surface or nothing is scattered. Power per area is
    /// irradiance under the geometric normal, so that the BSDF's cosine with the shading normal is
    /// divided by that ([Veach 1997] 5.3). A surface with alpha has stopped only that share of the
    /// photons, as it does of the camera's rays; it counts once.
    #[inline]
    #[must_use]
    pub fn scattered(&self, at: &SurfaceVertex<'_>) -> Option<Scattered> {
        if self.ng.dot(at.point.ng).abs() < SAME_SURFACE {
            return None;
        }
        let scattering = at.scattering(self.wo, TransportMode::Radiance)?;
        Some(Scattered {
            f_power: scattering.f_cos * self.power / (at.cos_g(self.wo) * at.opacity),
            scattering,
        })
    }
}
