//! The share of the light arriving from a direction that is scattered.

use super::{Drawn, Integrals, LARGEST_ANGLE, viewer};
use crate::bsdf::Scatter;
use crate::pass::{CancelToken, Cancelled};
use crate::radiometry::Rgb;

/// Degrees from one point of the curve to the next.
const STEP: f32 = 3.0;
/// Directions that are drawn for each of them.
const N_DRAWN: u32 = 1 << 12;

/// The albedo seen under one angle.
#[derive(Clone, Copy, Debug)]
pub struct AlbedoAt {
    /// Angle to the normal, degrees.
    pub angle: f32,
    /// By quadrature where there is a density, and what mirror-like lobes scatter.
    pub albedo: Rgb,
    /// Mirror-like lobes alone.
    pub specular: Rgb,
    /// The same albedo as the mean over directions that were drawn, luminance,
    pub sampled: f64,
    /// and its standard error.
    pub standard_error: f64,
}

impl AlbedoAt {
    pub(super) fn new(angle: f32, integrals: &Integrals, drawn: &Drawn) -> Self {
        let lobes = drawn.deltas.iter();
        let specular = lobes.fold(Rgb::BLACK, |sum, lobe| sum + lobe.share);
        Self {
            angle,
            albedo: integrals.albedo + specular,
            specular,
            sampled: drawn.albedo,
            standard_error: drawn.standard_error,
        }
    }

    /// Share of the scattered light that mirror-like lobes scatter, in [0, 1].
    #[must_use]
    pub fn specular_share(&self) -> f64 {
        let all = f64::from(self.albedo.luminance());
        let specular = f64::from(self.specular.luminance());
        if all > 0.0 { specular / all } else { 0.0 }
    }
}

/// The albedo from upright to grazing.
///
/// # Errors
/// [`Cancelled`] if the token was.
pub fn albedo_curve(
    bsdf: &impl Scatter,
    is_behind: bool,
    cancel: &CancelToken,
) -> Result<Vec<AlbedoAt>, Cancelled> {
    let n = (LARGEST_ANGLE / STEP) as usize;
    let angles = (0..=n).map(|i| i as f32 * STEP);
    let angles = angles.chain(std::iter::once(LARGEST_ANGLE));
    let at = |angle: f32| {
        if cancel.is_cancelled() {
            return Err(Cancelled);
        }
        let wo = viewer(angle, is_behind);
        let drawn = Drawn::new(bsdf, wo, N_DRAWN);
        Ok(AlbedoAt::new(angle, &Integrals::new(bsdf, wo), &drawn))
    };
    angles.map(at).collect()
}
