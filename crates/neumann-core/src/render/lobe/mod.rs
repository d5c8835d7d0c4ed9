//! What a surface does with light, direction by direction: its BSDF, looked at.
//!
//! A [`Lobes`] holds what there is to see of one BSDF: from some viewing directions the values
//! `f(wo, wi)` of all others ([`Viewed`]), the albedo over the angle of the viewer, and how far the
//! BSDF is from being reciprocal. All of it is asked of [`Scatter`], the same functions that paths
//! ask, so that what is shown is what is rendered.
//!
//! Directions are local: z is the normal, and the viewer is in the plane y = 0 on the side of
//! negative x, so that light is mirrored towards positive x.
//!
//! Values `f` are those that radiance meets on its way to the viewer. An albedo is the share of the
//! light arriving from a direction that is scattered, `∫ f* cos dω` with the BSDF of importance
//! ([`TransportMode`]): they differ where light is refracted, since radiance is squeezed there. A
//! mirror-like lobe has no values; it has a direction and a share of the light ([`DeltaLobe`]).

mod albedo;
mod drawn;
mod polar;
mod quadrature;
mod reciprocity;
mod solid;
mod surface;

use glam::Vec3;

pub use albedo::{AlbedoAt, albedo_curve};
pub use drawn::{DeltaLobe, Drawn};
pub use polar::{PolarPoint, direction_at};
pub use quadrature::Integrals;
pub use reciprocity::Reciprocity;
pub use solid::Solid;
pub use surface::Surface;

use super::hemisphere::DirectionMap;
use crate::bsdf::{Scatter, TransportMode};
use crate::pass::{CancelToken, Cancelled};

/// The angles of the viewer where nothing else is asked for, degrees.
pub const ANGLES: [f32; 4] = [0.0, 30.0, 60.0, 80.0];
/// Nobody looks along the surface: the largest angle of a viewer, degrees.
pub const LARGEST_ANGLE: f32 = 89.0;
/// Directions that are drawn for a viewing direction.
pub const N_DRAWN: u32 = 1 << 15;
/// Pixels of the diameter of a disk, and samples of a pixel in either direction.
const EDGE: usize = 64;
const PER_PIXEL: usize = 3;

/// All that there is to see of a BSDF.
#[derive(Clone, Debug)]
pub struct Lobes {
    /// From some viewing directions.
    pub views: Vec<Viewed>,
    /// The albedo over the angle of the viewer, from upright to grazing.
    pub albedo: Vec<AlbedoAt>,
    /// How far it is from being reciprocal; `None` if it has mirror-like lobes alone.
    pub reciprocity: Option<Reciprocity>,
}

impl Lobes {
    /// Looks at a BSDF under some angles (degrees), from behind the surface if `is_behind`.
    ///
    /// # Errors
    /// [`Cancelled`] if the token was.
    pub fn new(
        bsdf: &impl Scatter,
        angles: &[f32],
        is_behind: bool,
        cancel: &CancelToken,
    ) -> Result<Self, Cancelled> {
        let mut views = Vec::new();
        for angle in angles {
            if cancel.is_cancelled() {
                return Err(Cancelled);
            }
            views.push(Viewed::new(bsdf, *angle, is_behind));
        }
        Ok(Self {
            views,
            albedo: albedo_curve(bsdf, is_behind, cancel)?,
            reciprocity: Reciprocity::of(bsdf),
        })
    }
}

/// A BSDF from one viewing direction.
#[derive(Clone, Debug)]
pub struct Viewed {
    /// Angle between normal and viewer, degrees.
    pub angle: f32,
    /// The direction to the viewer.
    pub wo: Vec3,
    /// All directions in the plane of normal and viewer.
    pub polar: Vec<PolarPoint>,
    /// All directions there are, as a surface around the point.
    pub solid: Solid,
    /// How directions lie on [`Self::density`].
    pub map: DirectionMap,
    /// The density of directions over the disks of the map, 1/sr, means over pixels; 0 outside.
    pub density: Vec<f32>,
    /// Directions that were drawn.
    pub drawn: Drawn,
    /// What values and densities amount to over all directions.
    pub integrals: Integrals,
}

impl Viewed {
    /// Looks under an angle to the normal, degrees.
    #[must_use]
    pub fn new(bsdf: &impl Scatter, angle: f32, is_behind: bool) -> Self {
        let wo = viewer(angle, is_behind);
        let drawn = Drawn::new(bsdf, wo, N_DRAWN);
        let peaks = drawn.peaks();
        let polar = polar::curve(bsdf, wo, &peaks);
        let solid = Solid::new(bsdf, wo, &peaks);
        let normal = Vec3::Z * 1f32.copysign(wo.z);
        let map = DirectionMap::new(normal, wo, EDGE, drawn.is_transmissive);
        Self {
            angle,
            wo,
            density: density(bsdf, wo, &map),
            integrals: Integrals::new(bsdf, wo),
            polar,
            solid,
            map,
            drawn,
        }
    }

    /// The albedo from there.
    #[must_use]
    pub fn albedo(&self) -> AlbedoAt {
        AlbedoAt::new(self.angle, &self.integrals, &self.drawn)
    }

    /// What all probabilities of drawing a direction add up to: those that have a density, those of
    /// mirror-like lobes, and that no direction is drawn. It is 1 if the density is the one that
    /// directions are drawn with.
    #[must_use]
    pub fn total_probability(&self) -> f64 {
        self.integrals.pdf_w + self.drawn.p_delta() + self.drawn.refused
    }
}

/// The direction to the viewer under an angle, degrees.
#[must_use]
pub fn viewer(angle: f32, is_behind: bool) -> Vec3 {
    let (sin, cos) = angle.clamp(0.0, LARGEST_ANGLE).to_radians().sin_cos();
    Vec3::new(-sin, 0.0, if is_behind { -cos } else { cos })
}

/// The density over the pixels of a map, each the mean of a few directions.
fn density(bsdf: &impl Scatter, wo: Vec3, map: &DirectionMap) -> Vec<f32> {
    let (width, height) = map.size();
    let of_pixel = |i: usize| {
        let (mut sum, mut n) = (0.0, 0);
        for j in 0..PER_PIXEL * PER_PIXEL {
            let [dx, dy] = [j % PER_PIXEL, j / PER_PIXEL].map(|k| k as f32 + 0.5);
            let share = 1.0 / PER_PIXEL as f32;
            let place = [
                (i % width) as f32 + dx * share,
                (i / width) as f32 + dy * share,
            ];
            if let Some(wi) = map.direction(place) {
                sum += bsdf.pdf_w(wo, wi, TransportMode::Radiance);
                n += 1;
            }
        }
        sum / n.max(1) as f32
    };
    (0..width * height).map(of_pixel).collect()
}
