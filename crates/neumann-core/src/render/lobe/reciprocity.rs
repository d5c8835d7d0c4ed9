//! Does light meet the same BSDF either way? Helmholtz: `f(wo, wi) = f*(wi, wo)`, where `f*` is
//! what importance meets; on one side of the surface the two are the same, across it they differ by
//! the squared ratio of the indices of refraction ([Veach 1997] 5.2).

use glam::Vec3;

use crate::bsdf::{Scatter, TransportMode};
use crate::sampling::{Sampler, warp};

/// Pairs of directions that are tried.
const N_PAIRS: u32 = 1 << 13;
const SEED: u64 = 0x5eed;
/// Directions whose cosine is smaller are left out: rounding is all that is found along a surface.
const GRAZING: f32 = 1e-3;
/// Values below this, 1/sr, are as good as none; single precision leaves little of them.
const NEGLIGIBLE: f32 = 1e-4;

/// How far a BSDF is from being reciprocal.
#[derive(Clone, Copy, Debug)]
pub struct Reciprocity {
    /// Pairs of directions between which light is scattered.
    pub n_pairs: u32,
    /// The largest difference between both ways, as a share of the larger value.
    pub largest: f32,
    /// Where that is.
    pub pair: [Vec3; 2],
}

impl Reciprocity {
    /// Single precision makes differences up to this, near total reflection in rough glass.
    pub const ROUNDING: f32 = 0.02;

    /// True if nothing but rounding tells both ways apart.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.largest < Self::ROUNDING
    }

    /// Tries random pairs, half of them anywhere and half of them drawn from the BSDF; `None` if it
    /// scatters between none of them.
    #[must_use]
    pub fn of(bsdf: &impl Scatter) -> Option<Self> {
        let mut found: Option<Self> = None;
        for i in 0..N_PAIRS {
            let Some([wo, wi]) = pair(bsdf, i) else {
                continue;
            };
            let there = bsdf.eval(wo, wi, TransportMode::Radiance);
            let back = bsdf.eval(wi, wo, TransportMode::Importance);
            let larger = there.max_channel().max(back.max_channel());
            if larger < NEGLIGIBLE {
                continue;
            }
            let apart = (there - back).map(f32::abs).max_channel() / larger;
            let known = found.get_or_insert(Self {
                n_pairs: 0,
                largest: apart,
                pair: [wo, wi],
            });
            known.n_pairs += 1;
            if apart > known.largest {
                (known.largest, known.pair) = (apart, [wo, wi]);
            }
        }
        found
    }
}

fn pair(bsdf: &impl Scatter, index: u32) -> Option<[Vec3; 2]> {
    let mut sampler = Sampler::new(SEED, u64::from(index), 0);
    let wo = warp::uniform_sphere(sampler.next_2d());
    let is_along = |w: Vec3| w.z.abs() < GRAZING;
    if is_along(wo) {
        return None;
    }
    let [a, b] = sampler.next_2d();
    let wi = if index.is_multiple_of(2) {
        warp::uniform_sphere([a, b])
    } else {
        let numbers = [sampler.next_1d(), a, b];
        let sample = bsdf.sample(wo, numbers, TransportMode::Radiance)?;
        sample.wi
    };
    (!is_along(wi)).then_some([wo, wi])
}
