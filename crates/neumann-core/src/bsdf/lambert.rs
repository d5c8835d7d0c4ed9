//! Ideal diffuse reflection, on both sides: `f = albedo / π`.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::{BsdfSample, Scatter, TransportMode, is_reflection};
use crate::radiometry::Rgb;
use crate::sampling::warp;

/// Ideal diffuse reflection.
#[derive(Clone, Copy, Debug)]
pub struct Lambert {
    /// Share of light reflected, in [0, 1].
    pub albedo: Rgb,
}

impl Scatter for Lambert {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, _mode: TransportMode) -> Rgb {
        if is_reflection(wo, wi) {
            self.albedo * FRAC_1_PI
        } else {
            Rgb::BLACK
        }
    }

    #[inline]
    fn pdf_w(&self, wo: Vec3, wi: Vec3, _mode: TransportMode) -> f32 {
        if is_reflection(wo, wi) {
            warp::cosine_hemisphere_pdf_w(wi.z.abs())
        } else {
            0.0
        }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3, u: [f32; 3], mode: TransportMode) -> Option<BsdfSample> {
        let mut wi = warp::cosine_hemisphere([u[1], u[2]]);
        if wo.z < 0.0 {
            wi.z = -wi.z;
        }
        let pdf_w = self.pdf_w(wo, wi, mode);
        (pdf_w > 0.0).then(|| BsdfSample {
            wi,
            f: self.eval(wo, wi, mode),
            pdf_w,
            is_delta: false,
        })
    }
}
