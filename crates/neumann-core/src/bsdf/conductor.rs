//! Metal: reflection by a GGX interface with Schlick's Fresnel, or a perfect mirror.

use glam::Vec3;

use super::fresnel::schlick;
use super::microfacet::Ggx;
use super::{BsdfSample, Scatter, TransportMode, albedo_table, is_reflection};
use crate::radiometry::Rgb;

/// Reflection by a metal, on both sides.
#[derive(Clone, Copy, Debug)]
pub struct Conductor {
    /// Reflectance at normal incidence.
    pub f0: Rgb,
    /// Reflectance at grazing incidence.
    pub f90: Rgb,
    /// Its facets.
    pub ggx: Ggx,
}

impl Conductor {
    /// True for a perfect mirror.
    #[inline]
    #[must_use]
    pub fn is_delta(&self) -> bool {
        self.ggx.is_smooth()
    }

    /// Share of light from one direction that is reflected.
    #[must_use]
    pub fn albedo(&self, cos_o: f32) -> Rgb {
        albedo_table::directional(self.f0, self.f90, cos_o, self.ggx.alpha)
    }
}

impl Scatter for Conductor {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, _mode: TransportMode) -> Rgb {
        if self.is_delta() || !is_reflection(wo, wi) {
            return Rgb::BLACK;
        }
        let (wo, wi) = upper(wo, wi);
        let m = (wo + wi).normalize();
        let fresnel = schlick(self.f0, self.f90, wo.dot(m));
        fresnel * (self.ggx.d(m) * self.ggx.g2(wo, wi) / (4.0 * wo.z * wi.z))
    }

    #[inline]
    fn pdf_w(&self, wo: Vec3, wi: Vec3, _mode: TransportMode) -> f32 {
        if self.is_delta() || !is_reflection(wo, wi) {
            return 0.0;
        }
        let (wo, wi) = upper(wo, wi);
        pdf_w_reflected(self.ggx, wo, wi)
    }

    #[inline]
    fn sample(&self, wo: Vec3, u: [f32; 3], mode: TransportMode) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        if self.is_delta() {
            let wi = Vec3::new(-wo.x, -wo.y, wo.z);
            let cos = wo.z.abs();
            return Some(BsdfSample {
                wi,
                f: schlick(self.f0, self.f90, cos) / cos,
                pdf_w: 1.0,
                is_delta: true,
            });
        }
        let wi = sample_reflected(self.ggx, wo, [u[1], u[2]])?;
        Some(BsdfSample {
            wi,
            f: self.eval(wo, wi, mode),
            pdf_w: self.pdf_w(wo, wi, mode),
            is_delta: false,
        })
    }
}

/// Both directions, turned to the upper side if they are on the lower.
#[inline]
pub(super) fn upper(wo: Vec3, wi: Vec3) -> (Vec3, Vec3) {
    if wo.z < 0.0 { (-wo, -wi) } else { (wo, wi) }
}

/// Density of [`sample_reflected`], 1/sr; both directions on the upper side.
#[inline]
pub(super) fn pdf_w_reflected(ggx: Ggx, wo: Vec3, wi: Vec3) -> f32 {
    let m = (wo + wi).normalize();
    // D(m) G1(wo) (wo·m) / wo.z, times the Jacobian 1 / (4 wo·m) of reflection.
    ggx.g1(wo) * ggx.d(m) / (4.0 * wo.z)
}

/// A reflection at a visible facet; `None` if it goes below the surface.
#[inline]
pub(super) fn sample_reflected(ggx: Ggx, wo: Vec3, u: [f32; 2]) -> Option<Vec3> {
    let side = 1f32.copysign(wo.z);
    let wo = wo * side;
    let m = ggx.sample_visible(wo, u);
    let wi = 2.0 * wo.dot(m) * m - wo;
    (wi.z > 0.0).then_some(wi * side)
}
