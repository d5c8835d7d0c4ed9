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
        let reflected = self.ggx.reflected(wo, wi);
        schlick(self.f0, self.f90, reflected.cos_m) * reflected.value
    }

    #[inline]
    fn pdf_w(&self, wo: Vec3, wi: Vec3, _mode: TransportMode) -> f32 {
        if self.is_delta() || !is_reflection(wo, wi) {
            return 0.0;
        }
        let (wo, wi) = upper(wo, wi);
        self.ggx.reflected(wo, wi).pdf_w
    }

    #[inline]
    fn eval_and_pdf_w(&self, wo: Vec3, wi: Vec3, _mode: TransportMode) -> (Rgb, f32) {
        if self.is_delta() || !is_reflection(wo, wi) {
            return (Rgb::BLACK, 0.0);
        }
        let (wo, wi) = upper(wo, wi);
        let reflected = self.ggx.reflected(wo, wi);
        let fresnel = schlick(self.f0, self.f90, reflected.cos_m);
        (fresnel * reflected.value, reflected.pdf_w)
    }

    #[inline(never)]
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
        let (f, pdf_w) = self.eval_and_pdf_w(wo, wi, mode);
        Some(BsdfSample {
            wi,
            f,
            pdf_w,
            is_delta: false,
        })
    }
}

/// Both directions, turned to the upper side if they are on the lower.
#[inline]
pub(super) fn upper(wo: Vec3, wi: Vec3) -> (Vec3, Vec3) {
    if wo.z < 0.0 { (-wo, -wi) } else { (wo, wi) }
}

/// A reflection at a visible facet, of density [`Ggx::reflected`]; `None` if it goes below the
/// surface.
#[inline]
pub(super) fn sample_reflected(ggx: Ggx, wo: Vec3, u: [f32; 2]) -> Option<Vec3> {
    let side = 1f32.copysign(wo.z);
    let wo = wo * side;
    let m = ggx.sample_visible(wo, u);
    let wi = 2.0 * wo.dot(m) * m - wo;
    (wi.z > 0.0).then_some(wi * side)
}
