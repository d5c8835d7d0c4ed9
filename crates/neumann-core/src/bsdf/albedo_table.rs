//! How much a rough Fresnel interface reflects in all, tabulated.
//!
//! With Schlick's Fresnel the directional albedo of a GGX lobe is linear in f0
//! and f90: `E(cos) = f0 A(cos, alpha) + f90 B(cos, alpha)` (the split of Karis
//! 2013). Its cosine-weighted mean is `2 ∫ E cos dcos`. The coat over a diffuse
//! base needs both to conserve energy and to be reciprocal
//! ([`super::MetallicRoughness`]).
//!
//! What the table holds is by how much A and B differ from those of a smooth interface, `1 - w` and
//! `w` with Schlick's weight w, which vary most. Near grazing, albedo changes within cosines of
//! about alpha; so columns are even in `cos (1 + 2 alpha) / (cos + 2 alpha)`, and rows in
//! roughness,
//! the square root of alpha. Linear interpolation is then right to 0.0005 of the light.
//!
//! Integrating it all takes as long as many a first frame, so the table of directions is a file,
//! which a test makes anew and compares.

use std::sync::LazyLock;

use super::fresnel::schlick_weight;
use super::microfacet::SMOOTH_ALPHA;
use crate::radiometry::Rgb;

/// Entries along each axis.
const N: usize = 64;
/// `[alpha][cos]`: A and B less those of a smooth interface, as little-endian `f32`.
static DIRECTIONAL: &[u8; N * N * 8] = include_bytes!("albedo_table.bin");

struct Table {
    /// `directional[alpha][cos]`: A and B less those of a smooth interface.
    directional: Vec<[f32; 2]>,
    /// `mean[alpha]`: A and B.
    mean: Vec<[f32; 2]>,
    /// The roughness of the first row, and by how much that of the last is more.
    roughness: [f32; 2],
}

static TABLE: LazyLock<Table> = LazyLock::new(Table::new);

/// Directional albedo: the share of light from one direction that the interface reflects.
///
/// `cos` in [0, 1]; `alpha` is GGX's.
#[inline]
#[must_use]
pub fn directional(f0: Rgb, f90: Rgb, cos: f32, alpha: f32) -> Rgb {
    let [a, b] = split(cos, alpha);
    f0 * a + f90 * b
}

/// A and B, which are the same for all interfaces of one roughness.
#[inline]
pub(super) fn split(cos: f32, alpha: f32) -> [f32; 2] {
    let w = schlick_weight(cos);
    let [a, b] = if alpha < SMOOTH_ALPHA {
        [0.0; 2]
    } else {
        TABLE.difference(cos, alpha)
    };
    [1.0 - w + a, w + b]
}

/// Mean albedo: the share of uniform light that the interface reflects.
#[inline]
#[must_use]
pub fn mean(f0: Rgb, f90: Rgb, alpha: f32) -> Rgb {
    let [a, b] = if alpha < SMOOTH_ALPHA {
        // 2 ∫ (1 - c)⁵ c dc = 1/21.
        [20.0 / 21.0, 1.0 / 21.0]
    } else {
        TABLE.mean_at(alpha)
    };
    f0 * a + f90 * b
}

impl Table {
    fn new() -> Self {
        let number = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        let directional: Vec<[f32; 2]> = DIRECTIONAL
            .chunks_exact(8)
            .map(|entry| [number(entry), number(&entry[4..])])
            .collect();
        let smoothest = SMOOTH_ALPHA.sqrt();
        let mut table = Self {
            directional,
            mean: Vec::new(),
            roughness: [smoothest, 1.0 - smoothest],
        };
        table.mean = (0..N).map(|row| table.mean_of(row)).collect();
        table
    }

    /// Alpha in a row.
    fn alpha(&self, row: usize) -> f32 {
        let [first, length] = self.roughness;
        let roughness = first + length * row as f32 / (N - 1) as f32;
        roughness * roughness
    }

    /// The row, and the share of the next one.
    #[inline]
    fn row(&self, alpha: f32) -> (usize, f32) {
        let [first, length] = self.roughness;
        position((alpha.sqrt() - first) / length)
    }

    #[inline]
    fn difference(&self, cos: f32, alpha: f32) -> [f32; 2] {
        let (c, s) = position(column(cos, alpha));
        let (r, t) = self.row(alpha);
        let row = |r: usize| {
            lerp(
                self.directional[r * N + c],
                self.directional[r * N + c + 1],
                s,
            )
        };
        lerp(row(r), row(r + 1), t)
    }

    fn mean_at(&self, alpha: f32) -> [f32; 2] {
        let (r, t) = self.row(alpha);
        lerp(self.mean[r], self.mean[r + 1], t)
    }

    /// `2 ∫ E(c) c dc` in a row: that of Schlick's weight is 1/21, and the rest is added up.
    fn mean_of(&self, row: usize) -> [f32; 2] {
        const STEPS: usize = 512;
        let alpha = self.alpha(row);
        let mut sum = [0f64; 2];
        for i in 0..STEPS {
            // More of them near grazing: c = s², dc = 2 s ds.
            let s = (i as f32 + 0.5) / STEPS as f32;
            let difference = self.difference(s * s, alpha);
            for k in 0..2 {
                sum[k] += f64::from(4.0 * s * s * s * difference[k]);
            }
        }
        let [a, b] = sum.map(|sum| (sum / STEPS as f64) as f32);
        [20.0 / 21.0 + a, 1.0 / 21.0 + b]
    }
}

/// Where a cosine is along a row, from 0 to 1.
#[inline]
fn column(cos: f32, alpha: f32) -> f32 {
    let a = 2.0 * alpha;
    cos * (1.0 + a) / (cos + a)
}

/// Between which entries a place is, and how far from the first.
#[inline]
fn position(x: f32) -> (usize, f32) {
    let scaled = x.clamp(0.0, 1.0) * (N - 1) as f32;
    let i = (scaled as usize).min(N - 2);
    (i, scaled - i as f32)
}

#[inline]
fn lerp(a: [f32; 2], b: [f32; 2], t: f32) -> [f32; 2] {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use rayon::prelude::*;

    use super::{N, TABLE, directional, mean, split};
    use crate::bsdf::microfacet::SMOOTH_ALPHA;
    use crate::radiometry::Rgb;

    /// Steps of the azimuth, over half of the circle, and of the height of the cap.
    const STEPS: [usize; 2] = [64, 256];

    /// A and B for one direction, in double precision: visible normals, each of which weighs G2 /
    /// G1, on a grid that is
    /// denser towards both ends of the cap.
    fn split_albedo(alpha: f64, cos: f64) -> [f64; 2] {
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let length = (alpha * sin).hypot(cos);
        let stretched = [alpha * sin / length, cos / length];
        let lambda =
            |sin2: f64, cos: f64| 0.5 * ((1.0 + alpha * alpha * sin2 / (cos * cos)).sqrt() - 1.0);
        let lambda_o = lambda(sin * sin, cos);
        let mut sum = [0f64; 2];
        for i in 0..STEPS[0] * STEPS[1] {
            let phi = PI * ((i % STEPS[0]) as f64 + 0.5) / STEPS[0] as f64;
            let t = ((i / STEPS[0]) as f64 + 0.5) / STEPS[1] as f64;
            let u = t * t * (3.0 - 2.0 * t);
            let z = (1.0 - u) * (1.0 + stretched[1]) - stretched[1];
            let r = (1.0 - z * z).max(0.0).sqrt();
            let m = [
                alpha * (r * phi.cos() + stretched[0]),
                alpha * r * phi.sin(),
                (z + stretched[1]).max(1e-12),
            ];
            let length = m.iter().map(|x| x * x).sum::<f64>().sqrt();
            let m = m.map(|x| x / length);
            let cos_m = sin * m[0] + cos * m[2];
            let wi_z = 2.0 * cos_m * m[2] - cos;
            if wi_z <= 0.0 {
                continue;
            }
            let lambda_i = lambda(1.0 - wi_z * wi_z, wi_z);
            let weight = 6.0 * t * (1.0 - t) * (1.0 + lambda_o) / (1.0 + lambda_o + lambda_i);
            let fresnel = (1.0 - cos_m.clamp(0.0, 1.0)).powi(5);
            sum[0] += weight * (1.0 - fresnel);
            sum[1] += weight * fresnel;
        }
        sum.map(|sum| sum / (STEPS[0] * STEPS[1]) as f64)
    }

    fn cos_at(column: usize, alpha: f64) -> f64 {
        let x = column as f64 / (N - 1) as f64;
        (2.0 * alpha * x / (1.0 + 2.0 * alpha - x)).clamp(1e-5, 1.0)
    }

    #[test]
    fn the_file_holds_the_integrals() {
        // Where the file is not made anew, a part of it is enough.
        let is_update = std::env::var_os("UPDATE_ALBEDO_TABLE").is_some();
        let step = if is_update { 1 } else { 11 };
        let integrals: Vec<[f32; 2]> = (0..(N * N).div_ceil(step))
            .into_par_iter()
            .map(|i| {
                let i = i * step;
                let alpha = f64::from(TABLE.alpha(i / N));
                let cos = cos_at(i % N, alpha);
                let [a, b] = split_albedo(alpha, cos);
                let w = (1.0 - cos).powi(5);
                [(a - (1.0 - w)) as f32, (b - w) as f32]
            })
            .collect();
        if is_update {
            let bytes: Vec<u8> = integrals
                .iter()
                .flatten()
                .flat_map(|x| x.to_le_bytes())
                .collect();
            std::fs::write("src/bsdf/albedo_table.bin", bytes).unwrap();
        }
        let kept = TABLE.directional.iter().step_by(step);
        for (i, (kept, integral)) in kept.zip(&integrals).enumerate() {
            for k in 0..2 {
                assert!(
                    (kept[k] - integral[k]).abs() < 1e-5,
                    "entry {i}: {kept:?} and {integral:?}; UPDATE_ALBEDO_TABLE=1 writes the file \
                     anew"
                );
            }
        }
    }

    #[test]
    fn what_is_between_the_entries_is_right_as_well() {
        for i in 0..400 {
            // Places that are far from those of entries, and nowhere near each other.
            let share = |factor: f64| (f64::from(i) * factor).fract();
            let smoothest = f64::from(SMOOTH_ALPHA).sqrt();
            let alpha = (smoothest + (1.0 - smoothest) * share(0.618_034)).powi(2);
            let cos = share(0.754_878).powf(1.5).max(1e-3);
            let exact = split_albedo(alpha, cos);
            let found = split(cos as f32, alpha as f32).map(f64::from);
            let off: [f64; 2] = std::array::from_fn(|k| found[k] - exact[k]);
            // Of a coat of 4 % above all: the albedo of metal is no part of what it scatters.
            let name = format!("cos {cos}, alpha {alpha}: off by {off:?}");
            assert!((0.04 * off[0] + off[1]).abs() < 5e-4, "{name}");
            assert!(off[0].abs() < 5e-3 && off[1].abs() < 5e-4, "{name}");
        }
    }

    #[test]
    fn means_are_those_of_the_directions() {
        let (f0, f90) = (Rgb::splat(0.04), Rgb::WHITE);
        for i in 0..50 {
            let roughness = 0.04 + 0.96 * (i as f32 * 0.618_034).fract();
            let alpha = roughness * roughness;
            let sum: f64 = (0..4000)
                .map(|i| {
                    let s = (i as f32 + 0.5) / 4000.0;
                    f64::from(directional(f0, f90, s * s, alpha).g * 4.0 * s * s * s)
                })
                .sum();
            let (found, right) = (f64::from(mean(f0, f90, alpha).g), sum / 4000.0);
            assert!(
                (found - right).abs() < 1e-4,
                "alpha {alpha}: {found}, {right}"
            );
        }
    }
}
