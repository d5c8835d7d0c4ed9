//! Directions drawn from a BSDF, and what they say of it.

use glam::Vec3;

use crate::bsdf::{BsdfSample, Scatter, TransportMode};
use crate::radiometry::Rgb;
use crate::sampling::Sampler;

/// The seed of all of them.
const SEED: u64 = 0x10be;
/// Directions that are kept.
const MAX_DOTS: usize = 400;
/// Directions whose cosine is larger are those of one mirror-like lobe, if their probability is the
/// same but for rounding.
const SAME_DIRECTION: f32 = 0.999_999;
const SAME_PROBABILITY: f32 = 1e-4;

/// A mirror-like lobe.
#[derive(Clone, Copy, Debug)]
pub struct DeltaLobe {
    /// Its direction.
    pub wi: Vec3,
    /// The share of the light that it scatters: reflectance or transmittance.
    pub share: Rgb,
    /// The probability with which it is drawn.
    pub probability: f32,
}

/// Directions drawn for one viewing direction.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The first ones that have a density.
    pub dots: Vec<Vec3>,
    /// Mirror-like lobes, most likely first.
    pub deltas: Vec<DeltaLobe>,
    /// Share of draws that yielded no direction.
    pub refused: f64,
    /// The albedo as the mean of `f* cos / pdf_w`, luminance,
    pub albedo: f64,
    /// and its standard error.
    pub standard_error: f64,
    /// How many were drawn.
    pub n: u32,
    /// True if some were on the other side of the surface.
    pub is_transmissive: bool,
    /// The most densely drawn direction before and behind the surface.
    peaks: [Option<(Vec3, f32)>; 2],
}

impl Drawn {
    /// Draws `n` directions.
    #[must_use]
    pub fn new(bsdf: &impl Scatter, wo: Vec3, n: u32) -> Self {
        let mut drawn = Self {
            dots: Vec::new(),
            deltas: Vec::new(),
            refused: 0.0,
            albedo: 0.0,
            standard_error: 0.0,
            n,
            is_transmissive: false,
            peaks: [None; 2],
        };
        let (mut n_refused, mut sum, mut squares) = (0u32, 0.0, 0.0);
        for i in 0..n {
            // What importance meets is what light meets that arrives from there.
            let Some(sample) = bsdf.sample(wo, numbers(i), TransportMode::Importance) else {
                n_refused += 1;
                continue;
            };
            let f_cos = sample.f.luminance() * sample.wi.z.abs();
            let value = f64::from(f_cos / sample.pdf_w);
            sum += value;
            squares += value * value;
            drawn.take(wo, &sample);
        }
        let count = f64::from(n.max(1));
        drawn.refused = f64::from(n_refused) / count;
        drawn.albedo = sum / count;
        let variance = (squares / count - drawn.albedo * drawn.albedo).max(0.0);
        drawn.standard_error = (variance / (count - 1.0).max(1.0)).sqrt();
        let likelier = |a: &DeltaLobe, b: &DeltaLobe| b.probability.total_cmp(&a.probability);
        drawn.deltas.sort_by(likelier);
        drawn
    }

    fn take(&mut self, wo: Vec3, sample: &BsdfSample) {
        let is_behind = sample.wi.z * wo.z < 0.0;
        self.is_transmissive |= is_behind;
        if sample.is_delta {
            let found = DeltaLobe {
                wi: sample.wi,
                share: sample.f * sample.wi.z.abs(),
                probability: sample.pdf_w,
            };
            let is_known = |known: &DeltaLobe| {
                let apart = (known.probability - found.probability).abs();
                known.wi.dot(found.wi) > SAME_DIRECTION
                    && apart <= SAME_PROBABILITY * found.probability
            };
            if !self.deltas.iter().any(is_known) {
                self.deltas.push(found);
            }
            return;
        }
        if self.dots.len() < MAX_DOTS {
            self.dots.push(sample.wi);
        }
        let peak = &mut self.peaks[usize::from(is_behind)];
        if peak.is_none_or(|(_, pdf_w)| sample.pdf_w > pdf_w) {
            *peak = Some((sample.wi, sample.pdf_w));
        }
    }

    /// The probability with which some mirror-like lobe is drawn.
    #[must_use]
    pub fn p_delta(&self) -> f64 {
        let all = self.deltas.iter();
        all.map(|lobe| f64::from(lobe.probability)).sum()
    }

    /// About where lobes are narrowest, before and behind the surface: that is where plots have to
    /// be fine.
    pub(super) fn peaks(&self) -> Vec<Vec3> {
        let peaks = self.peaks.iter().flatten();
        peaks.map(|(direction, _)| *direction).collect()
    }
}

/// The numbers of a draw.
fn numbers(index: u32) -> [f32; 3] {
    let mut sampler = Sampler::new(SEED, u64::from(index), 0);
    let [a, b] = sampler.next_2d();
    [sampler.next_1d(), a, b]
}
