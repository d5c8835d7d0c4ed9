//! The opaque material of glTF: metal, or a diffuse base under a dielectric coat.
//!
//! The specular lobes of metal and coat share one distribution, so that their
//! Fresnel terms mix. The diffuse base gets what the coat lets through on the way
//! in and out, `f_d = base/π · (1 - E(o)) (1 - E(i)) / (1 - E_mean)` (Kelemen and
//! Szirmay-Kalos 2001, eq. 5), with E the coat's albedo: reciprocal, and a white base
//! loses nothing. The mix by Fresnel alone of the glTF appendix would reflect up to
//! twice the light at grazing angles.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::conductor::{sample_reflected, upper};
use super::fresnel::{schlick, schlick_weight};
use super::microfacet::Ggx;
use super::{BsdfSample, Conductor, Scatter, TransportMode, albedo_table, is_reflection};
use crate::radiometry::Rgb;
use crate::sampling::discrete::one_of_two;
use crate::sampling::warp;

/// Metal and coated diffuse base, mixed by `metallic`.
#[derive(Clone, Copy, Debug)]
pub struct MetallicRoughness {
    /// Albedo of the diffuse base, already multiplied by `1 - metallic`.
    diffuse: Rgb,
    /// Coat at normal and grazing incidence.
    coat: [Rgb; 2],
    /// Metal and coat mixed, at normal and grazing incidence.
    specular: [Rgb; 2],
    ggx: Ggx,
    /// `diffuse / (π (1 - E_mean))`.
    diffuse_scale: Rgb,
}

impl MetallicRoughness {
    /// A material from glTF's parameters; `coat` holds the dielectric's reflectance at normal and
    /// at grazing incidence.
    #[must_use]
    pub fn new(base: Rgb, metallic: f32, coat: [Rgb; 2], ggx: Ggx) -> Self {
        let diffuse = base * (1.0 - metallic);
        let mean = albedo_table::mean(coat[0], coat[1], ggx.alpha);
        let through = mean.map(|e| FRAC_1_PI / (1.0 - e).max(1e-3));
        Self {
            diffuse,
            coat,
            specular: [
                coat[0].lerp(base, metallic),
                coat[1].lerp(Rgb::WHITE, metallic),
            ],
            ggx,
            diffuse_scale: diffuse * through,
        }
    }

    /// True unless it is nothing but a mirror.
    #[inline]
    #[must_use]
    pub fn has_density(&self) -> bool {
        !self.ggx.is_smooth() || self.has_diffuse_part()
    }

    /// True unless the base is all metal, or black.
    pub(super) fn has_diffuse_part(&self) -> bool {
        !self.diffuse.is_black()
    }

    /// Roughness, 1 where there is a diffuse base.
    pub(super) fn roughness(&self) -> f32 {
        if self.has_diffuse_part() {
            1.0
        } else {
            self.ggx.alpha.sqrt()
        }
    }

    /// Share of light from one direction that is reflected.
    #[must_use]
    pub fn albedo(&self, cos_o: f32) -> Rgb {
        let [f0, f90] = self.specular;
        let specular = albedo_table::directional(f0, f90, cos_o, self.ggx.alpha);
        specular + self.diffuse * (Rgb::WHITE - self.coat_albedo(self.split(cos_o)))
    }

    /// Metal and coat alone, as a conductor.
    #[must_use]
    pub fn specular_part(&self) -> Conductor {
        let [f0, f90] = self.specular;
        Conductor {
            f0,
            f90,
            ggx: self.ggx,
        }
    }

    /// The same without its diffuse base.
    #[must_use]
    pub fn without_diffuse(&self) -> Self {
        Self {
            diffuse: Rgb::BLACK,
            diffuse_scale: Rgb::BLACK,
            ..*self
        }
    }

    /// The albedo table at a cosine, for all that has to be known there.
    #[inline]
    fn split(&self, cos: f32) -> [f32; 2] {
        albedo_table::split(cos, self.ggx.alpha)
    }

    #[inline]
    fn coat_albedo(&self, [a, b]: [f32; 2]) -> Rgb {
        self.coat[0] * a + self.coat[1] * b
    }

    /// Probability to sample the specular lobe, its share of the reflected light, from the table at
    /// `cos_o`.
    #[inline]
    fn p_specular(&self, [a, b]: [f32; 2]) -> f32 {
        let [f0, f90] = self.specular;
        let specular = (f0 * a + f90 * b).mean();
        let diffuse = (self.diffuse * (Rgb::WHITE - self.coat_albedo([a, b]))).mean();
        if diffuse <= 0.0 {
            return 1.0;
        }
        if specular <= 0.0 {
            return 0.0;
        }
        (specular / (specular + diffuse)).clamp(0.05, 0.95)
    }

    /// The diffuse base, seen through the coat twice, from the table at `cos_o`.
    #[inline]
    fn diffuse_f(&self, split_o: [f32; 2], cos_i: f32) -> Rgb {
        if self.diffuse.is_black() {
            return Rgb::BLACK;
        }
        let in_and_out = [split_o, self.split(cos_i)].map(|s| Rgb::WHITE - self.coat_albedo(s));
        self.diffuse_scale * in_and_out[0] * in_and_out[1]
    }

    /// Value and density of a pair of directions on one side, from the table at `cos_o`.
    #[inline]
    fn reflection(&self, wo: Vec3, wi: Vec3, split_o: [f32; 2]) -> (Rgb, f32) {
        let (wo, wi) = upper(wo, wi);
        let p_specular = self.p_specular(split_o);
        let diffuse = self.diffuse_f(split_o, wi.z);
        let diffuse_pdf_w = (1.0 - p_specular) * warp::cosine_hemisphere_pdf_w(wi.z);
        if self.ggx.is_smooth() {
            return (diffuse, diffuse_pdf_w);
        }
        let reflected = self.ggx.reflected(wo, wi);
        let [f0, f90] = self.specular;
        let fresnel = f0.lerp(f90, schlick_weight(reflected.cos_m));
        (
            diffuse + fresnel * reflected.value,
            diffuse_pdf_w + p_specular * reflected.pdf_w,
        )
    }
}

impl Scatter for MetallicRoughness {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> Rgb {
        self.eval_and_pdf_w(wo, wi, mode).0
    }

    fn pdf_w(&self, wo: Vec3, wi: Vec3, _mode: TransportMode) -> f32 {
        if !is_reflection(wo, wi) {
            return 0.0;
        }
        let (wo, wi) = upper(wo, wi);
        let p_specular = self.p_specular(self.split(wo.z));
        let diffuse = (1.0 - p_specular) * warp::cosine_hemisphere_pdf_w(wi.z);
        if self.ggx.is_smooth() {
            return diffuse;
        }
        diffuse + p_specular * self.ggx.reflected(wo, wi).pdf_w
    }

    fn eval_and_pdf_w(&self, wo: Vec3, wi: Vec3, _mode: TransportMode) -> (Rgb, f32) {
        if !is_reflection(wo, wi) {
            return (Rgb::BLACK, 0.0);
        }
        self.reflection(wo, wi, self.split(wo.z.abs()))
    }

    #[inline(never)]
    fn sample(&self, wo: Vec3, u: [f32; 3], _mode: TransportMode) -> Option<BsdfSample> {
        let cos_o = wo.z.abs();
        if cos_o == 0.0 {
            return None;
        }
        let split_o = self.split(cos_o);
        let p_specular = self.p_specular(split_o);
        let (is_specular, rest) = one_of_two(u[2], p_specular);
        let u = [u[1], rest];
        let wi = if is_specular {
            if self.ggx.is_smooth() {
                let [f0, f90] = self.specular;
                return Some(BsdfSample {
                    wi: Vec3::new(-wo.x, -wo.y, wo.z),
                    f: schlick(f0, f90, cos_o) / cos_o,
                    pdf_w: p_specular,
                    is_delta: true,
                });
            }
            sample_reflected(self.ggx, wo, u)?
        } else {
            let wi = warp::cosine_hemisphere(u);
            Vec3::new(wi.x, wi.y, wi.z.copysign(wo.z))
        };
        if !is_reflection(wo, wi) {
            return None;
        }
        let (f, pdf_w) = self.reflection(wo, wi, split_o);
        (pdf_w > 0.0).then_some(BsdfSample {
            wi,
            f,
            pdf_w,
            is_delta: false,
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::MetallicRoughness;
    use crate::bsdf::microfacet::Ggx;
    use crate::bsdf::{Scatter, TransportMode};
    use crate::radiometry::Rgb;
    use crate::sampling::Sampler;

    /// A white sky seen through half of all directions, by few samples of an even sequence: which
    /// lobe draws a direction is no source of error of its own.
    #[test]
    fn lobes_share_an_even_sequence() {
        const N_SAMPLES: u32 = 16;
        const N_RUNS: u64 = 4000;
        let coat = [Rgb::splat(0.2), Rgb::WHITE];
        let coated = MetallicRoughness::new(Rgb::splat(0.3), 0.0, coat, Ggx { alpha: 0.3 });
        let wo = Vec3::new(0.5, 0.0, 0.75f32.sqrt());
        let exact = 0.5 * coated.albedo(wo.z).r;
        let draw = |sampler: &mut Sampler<'_>| {
            let [a, b] = sampler.next_2d();
            let sample = coated.sample(wo, [sampler.next_1d(), a, b], TransportMode::Radiance)?;
            (sample.wi.y > 0.0).then(|| sample.f.r * sample.wi.z / sample.pdf_w)
        };
        let estimate = |seed: u64| {
            let found = (0..N_SAMPLES).filter_map(|i| draw(&mut Sampler::new(seed, 0, i)));
            found.sum::<f32>() / N_SAMPLES as f32
        };
        let errors = (0..N_RUNS).map(|seed| estimate(seed) - exact);
        let squared_error = errors.map(|e| e * e).sum::<f32>() / N_RUNS as f32;
        // That of tossing a coin for each sample; 0.14 of it are left, and 0.27 with a number of
        // its own for the lobe.
        let of_chance = exact * exact / N_SAMPLES as f32;
        let ratio = squared_error / of_chance;
        assert!(ratio < 0.18, "{ratio}");
    }
}
