//! Opaque material and glass in given shares: partial `KHR_materials_transmission`.

use glam::Vec3;

use super::{BsdfSample, Dielectric, MetallicRoughness, Scatter, TransportMode};
use crate::radiometry::Rgb;
use crate::sampling::discrete::one_of_two;

/// A linear mix of an opaque material and glass.
#[derive(Clone, Copy, Debug)]
pub struct Mix {
    /// The opaque part.
    pub opaque: MetallicRoughness,
    /// The glass part.
    pub glass: Dielectric,
    /// Share of the glass, in [0, 1].
    pub glass_share: f32,
}

impl Mix {
    /// True unless both parts are mirror-like.
    #[must_use]
    pub fn has_density(&self) -> bool {
        self.opaque.has_density() || !self.glass.is_delta()
    }
}

impl Scatter for Mix {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> Rgb {
        let opaque = self.opaque.eval(wo, wi, mode);
        opaque.lerp(self.glass.eval(wo, wi, mode), self.glass_share)
    }

    fn pdf_w(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> f32 {
        let opaque = self.opaque.pdf_w(wo, wi, mode);
        opaque + (self.glass.pdf_w(wo, wi, mode) - opaque) * self.glass_share
    }

    #[inline(never)]
    fn sample(&self, wo: Vec3, u: [f32; 3], mode: TransportMode) -> Option<BsdfSample> {
        let share = self.glass_share;
        let (is_glass, rest) = one_of_two(u[2], share);
        let u = [u[0], u[1], rest];
        let (mut sample, p) = if is_glass {
            (self.glass.sample(wo, u, mode)?, share)
        } else {
            (self.opaque.sample(wo, u, mode)?, 1.0 - share)
        };
        if sample.is_delta {
            sample.f *= p;
            sample.pdf_w *= p;
        } else {
            (sample.f, sample.pdf_w) = self.eval_and_pdf_w(wo, sample.wi, mode);
        }
        Some(sample)
    }
}
