//! Random numbers by what they are for.
//!
//! Every start of a path and every scattering event has one block of four pairs
//! ([`Sampler::start`], [`Sampler::bounce`]), and a pair means the same in every method. So no
//! method depends on the order in which another one draws, and paths that several methods have in
//! common are the same paths.

use super::Sampler;
use super::sobol::N_PAIRS;

/// What a path from the camera or from a light starts with: points of [0, 1)².
#[derive(Clone, Copy, Debug)]
pub struct StartNumbers {
    /// From the camera: where in the pixel.
    pub film: [f32; 2],
    /// From a light: where on it. The same pair as `film`.
    pub position: [f32; 2],
    /// Which light, and which part of it.
    pub light: [f32; 2],
    /// The direction in which a light starts the path.
    pub direction: [f32; 2],
    /// Where on the lens.
    pub lens: [f32; 2],
}

/// What a path needs at one scattering event: numbers in [0, 1).
#[derive(Clone, Copy, Debug, Default)]
pub struct BounceNumbers {
    /// The direction in which the path goes on,
    pub direction: [f32; 2],
    /// and the lobe that it is drawn from.
    pub lobe: f32,
    /// Whether it goes on at all.
    pub roulette: f32,
    /// Which light is aimed at, and which part of it.
    pub light: [f32; 2],
    /// Where on that light.
    pub point_on_light: [f32; 2],
    /// A path from a light aims at the lens instead: where on it. The same pair as
    /// `point_on_light`.
    pub lens: [f32; 2],
}

impl BounceNumbers {
    /// As [`Scatter::sample`](crate::bsdf::Scatter::sample) takes them.
    #[inline(always)]
    #[must_use]
    pub fn bsdf(&self) -> [f32; 3] {
        [self.lobe, self.direction[0], self.direction[1]]
    }
}

impl Sampler<'_> {
    /// The numbers that a path starts with.
    #[inline(always)]
    #[must_use]
    pub fn start(&self) -> StartNumbers {
        let [place, light, direction, lens] = self.first_pairs(0);
        StartNumbers {
            film: place,
            position: place,
            light,
            direction,
            lens,
        }
    }

    /// The numbers of the scattering event after `bounce` others.
    #[inline(always)]
    #[must_use]
    pub fn bounce(&self, bounce: u32) -> BounceNumbers {
        let pairs: [[f32; 2]; N_PAIRS] = self.first_pairs(bounce + 1);
        let [direction, [lobe, roulette], light, point] = pairs;
        BounceNumbers {
            direction,
            lobe,
            roulette,
            light,
            point_on_light: point,
            lens: point,
        }
    }
}
