//! The texels of a picture in radiance, as its file keeps them: half floats take two bytes each.

use std::sync::Arc;

use half::f16;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

use crate::memory::{self, Share, Shortage};
use crate::radiometry::Rgb;

/// Radiance by texel, in the format of its file; copies share it.
#[derive(Clone, Debug)]
pub struct Radiances {
    kept: Arc<Kept>,
}

#[derive(Debug)]
struct Kept {
    stored: StoredRadiances,
    /// What they take of the process's allowance.
    _memory: Share,
}

/// `texels[y * width + x]`, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub enum StoredRadiances {
    /// Single precision.
    Float(Vec<Rgb>),
    /// Half precision; red, green, blue.
    Half(Vec<[f16; 3]>),
    /// Three mantissas and an exponent e: `factor · mantissa · 2^(e − 136)`.
    Rgbe {
        /// Mantissas of red, green and blue, and the exponent.
        texels: Vec<[u8; 4]>,
        /// Multiplies all of them.
        factor: Rgb,
    },
}

impl From<Vec<Rgb>> for Radiances {
    fn from(texels: Vec<Rgb>) -> Self {
        Self::new(StoredRadiances::Float(texels), Share::default())
    }
}

impl FromIterator<Rgb> for Radiances {
    fn from_iter<I: IntoIterator<Item = Rgb>>(texels: I) -> Self {
        texels.into_iter().collect::<Vec<_>>().into()
    }
}

impl Radiances {
    /// Texels, and the memory that they were decoded into.
    #[must_use]
    pub fn new(stored: StoredRadiances, memory: Share) -> Self {
        Self {
            kept: Arc::new(Kept {
                stored,
                _memory: memory,
            }),
        }
    }

    /// Number of texels.
    #[must_use]
    pub fn len(&self) -> usize {
        self.kept.stored.len()
    }

    /// True if there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One texel.
    #[inline]
    #[must_use]
    pub fn get(&self, index: usize) -> Rgb {
        self.kept.stored.get(index)
    }

    /// All texels, row by row.
    pub fn iter(&self) -> impl Iterator<Item = Rgb> {
        self.kept.stored.iter()
    }
}

impl StoredRadiances {
    /// Number of texels.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Float(texels) => texels.len(),
            Self::Half(texels) => texels.len(),
            Self::Rgbe { texels, .. } => texels.len(),
        }
    }

    /// True if there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One texel.
    #[inline]
    #[must_use]
    pub fn get(&self, index: usize) -> Rgb {
        match self {
            Self::Float(texels) => texels[index],
            Self::Half(texels) => Rgb::from(texels[index].map(float_from_half)),
            Self::Rgbe { texels, factor } => rgb_from_rgbe(texels[index]) * *factor,
        }
    }

    /// All texels, row by row.
    pub fn iter(&self) -> impl Iterator<Item = Rgb> {
        (0..self.len()).map(|i| self.get(i))
    }

    /// The texels as floats, paid for by `memory` where they have to be copied.
    ///
    /// # Errors
    /// If there is no memory for the copy.
    pub fn into_floats(self, memory: &mut Share) -> Result<Vec<Rgb>, Shortage> {
        if let Self::Float(texels) = self {
            return Ok(texels);
        }
        memory.grow(memory::bytes_of::<Rgb>(self.len()))?;
        let mut texels = memory::empty(self.len())?;
        texels.extend(self.iter());
        Ok(texels)
    }

    /// Makes every texel finite and not negative; tells how many were not.
    ///
    /// A sun beyond the range of half floats is stored as infinity: it becomes the brightest
    /// finite value of the picture. Negative numbers and what is none become 0.
    pub fn mend(&mut self) -> usize {
        let n_odd = (0..self.len())
            .into_par_iter()
            .with_min_len(1 << 14)
            .filter(|i| !self.get(*i).is_radiance())
            .count();
        if n_odd == 0 {
            return 0;
        }
        let brightest = self
            .iter()
            .flat_map(Rgb::to_array)
            .filter(|value| value.is_finite())
            .fold(0.0, f32::max);
        // `max` also takes 0 for what is not a number.
        let mended = |value: f32| value.max(0.0).min(brightest);
        match self {
            Self::Float(texels) => {
                for texel in texels {
                    *texel = texel.map(mended);
                }
            }
            Self::Half(texels) => {
                for value in texels.iter_mut().flatten() {
                    *value = f16::from_f32(mended(value.to_f32()));
                }
            }
            Self::Rgbe { texels, factor } => {
                // The factor takes them beyond single precision; it is what has to give.
                let largest = texels.iter().map(|&t| rgb_from_rgbe(t).max_channel());
                let largest = largest.fold(0.0, f32::max);
                *factor = factor.map(|f| f.max(0.0).min(f32::MAX / (2.0 * largest.max(1.0))));
            }
        }
        n_odd
    }
}

/// A half float that is finite: its exponent is moved to where single precision has its own.
#[inline]
fn float_from_half(h: f16) -> f32 {
    let bits = u32::from(h.to_bits());
    let magnitude = f32::from_bits((bits & 0x7fff) << 13) * f32::from_bits(0x7780_0000);
    let is_special = bits & 0x7c00 == 0x7c00;
    let value = if is_special { h.to_f32() } else { magnitude };
    if bits & 0x8000 != 0 && !is_special {
        -value
    } else {
        value
    }
}

#[inline]
fn rgb_from_rgbe([r, g, b, e]: [u8; 4]) -> Rgb {
    // 2^(e − 128), below which 1/256 comes in two steps: 2^(e − 136) is no normal number for
    // small e.
    let scale = if e > 1 {
        f32::from_bits(u32::from(e - 1) << 23)
    } else {
        f32::from_bits(u32::from(e) << 22)
    };
    Rgb::from([r, g, b].map(f32::from)) * (scale * (1.0 / 256.0))
}

#[cfg(test)]
mod tests {
    use half::f16;

    use super::{StoredRadiances, float_from_half, rgb_from_rgbe};
    use crate::radiometry::Rgb;

    #[test]
    fn all_half_floats_are_what_they_are() {
        for bits in 0..=u16::MAX {
            let half = f16::from_bits(bits);
            let (got, want) = (float_from_half(half), half.to_f32());
            assert!(
                got == want || (got.is_nan() && want.is_nan()),
                "{bits:x}: {got} {want}"
            );
        }
    }

    #[test]
    fn mantissas_have_a_common_exponent() {
        assert_eq!(rgb_from_rgbe([128, 0, 64, 129]), Rgb::new(1.0, 0.0, 0.5));
        assert_eq!(rgb_from_rgbe([255, 255, 255, 0]), Rgb::BLACK);
        let smallest = rgb_from_rgbe([128, 0, 0, 1]).r;
        assert!(
            (smallest / 2f32.powi(-128) - 1.0).abs() < 1e-6,
            "{smallest}"
        );
        assert!(rgb_from_rgbe([255; 4]).is_radiance());
    }

    #[test]
    fn odd_texels_are_mended_in_every_format() {
        let odd = [f32::INFINITY, -1.0, f32::NAN];
        let mut float = StoredRadiances::Float(vec![Rgb::from(odd), Rgb::splat(3.0)]);
        let mut half = StoredRadiances::Half(vec![odd.map(f16::from_f32), [f16::from_f32(3.0); 3]]);
        for stored in [&mut float, &mut half] {
            assert_eq!(stored.mend(), 1);
            assert_eq!(stored.get(0), Rgb::new(3.0, 0.0, 0.0));
            assert_eq!((stored.get(1), stored.mend()), (Rgb::splat(3.0), 0));
        }
        let mut rgbe = StoredRadiances::Rgbe {
            texels: vec![[255; 4], [1, 1, 1, 136]],
            factor: Rgb::splat(1e6),
        };
        assert_eq!(rgbe.mend(), 1);
        assert!(rgbe.iter().all(Rgb::is_radiance));
    }
}
