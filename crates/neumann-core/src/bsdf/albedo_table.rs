//! How much a rough Fresnel interface reflects in all, tabulated.
//!
//! With Schlick's Fresnel the directional albedo of a GGX lobe is linear in f0
//! and f90: `E(cos) = f0 A(cos, alpha) + f90 B(cos, alpha)` (the split of Karis
//! 2013). Its cosine-weighted mean is `2 ∫ E cos dcos`. The coat over a diffuse
//! base needs both to conserve energy and to be reciprocal
//! ([`super::MetallicRoughness`]).
//!
//! Integrating it all takes as long as many a first frame, so the table of directions is a file, which a test makes anew
//! and compares.

use std::sync::LazyLock;

use super::fresnel::schlick_weight;
use crate::radiometry::Rgb;

/// Entries along each axis.
const N: usize = 32;
/// `[alpha][cos]`: A and B, as little-endian `f32`.
static DIRECTIONAL: &[u8; N * N * 8] = include_bytes!("albedo_table.bin");

struct Table {
    /// `directional[alpha][cos]`: A and B.
    directional: Vec<[f32; 2]>,
    /// `mean[alpha]`: A and B.
    mean: Vec<[f32; 2]>,
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
    if alpha < super::microfacet::SMOOTH_ALPHA {
        let w = schlick_weight(cos);
        [1.0 - w, w]
    } else {
        TABLE.at(cos, alpha)
    }
}

/// Mean albedo: the share of uniform light that the interface reflects.
#[inline]
#[must_use]
pub fn mean(f0: Rgb, f90: Rgb, alpha: f32) -> Rgb {
    let [a, b] = if alpha < super::microfacet::SMOOTH_ALPHA {
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
        let mean = directional.chunks_exact(N).map(mean_of).collect();
        Self { directional, mean }
    }

    fn at(&self, cos: f32, alpha: f32) -> [f32; 2] {
        let (c, s) = position(cos);
        let (r, t) = position(alpha.sqrt());
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
        let (r, t) = position(alpha.sqrt());
        lerp(self.mean[r], self.mean[r + 1], t)
    }
}

/// Where an entry is: they are even in cosine and in roughness, the square root of alpha.
fn position(x: f32) -> (usize, f32) {
    let scaled = x.clamp(0.0, 1.0) * (N - 1) as f32;
    let i = (scaled as usize).min(N - 2);
    (i, scaled - i as f32)
}

fn lerp(a: [f32; 2], b: [f32; 2], t: f32) -> [f32; 2] {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]
}

/// `2 ∫ E(c) c dc` over the piecewise linear E, exact for each piece.
fn mean_of(entries: &[[f32; 2]]) -> [f32; 2] {
    let h = 1.0 / (N - 1) as f32;
    let mut sum = [0f32; 2];
    for i in 0..N - 1 {
        let c = i as f32 * h;
        for k in 0..2 {
            let (e0, e1) = (entries[i][k], entries[i + 1][k]);
            sum[k] += h * (c * (e0 + e1) + h * (e0 + 2.0 * e1) / 3.0);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::{N, TABLE};
    use crate::bsdf::fresnel::schlick_weight;
    use crate::bsdf::microfacet::{Ggx, SMOOTH_ALPHA};

    /// Directions per entry and axis.
    const N_SAMPLES: usize = 16;

    fn cos_at(i: usize) -> f32 {
        (i as f32 / (N - 1) as f32).max(1e-3)
    }

    fn alpha_at(row: usize) -> f32 {
        let roughness = row as f32 / (N - 1) as f32;
        roughness * roughness
    }

    /// A and B for one direction, by visible normals on a regular grid: each weighs G2 / G1.
    fn split_albedo(ggx: Ggx, cos: f32) -> [f32; 2] {
        let wo = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
        let mut sum = [0f32; 2];
        for i in 0..N_SAMPLES * N_SAMPLES {
            let u = [
                ((i % N_SAMPLES) as f32 + 0.5) / N_SAMPLES as f32,
                ((i / N_SAMPLES) as f32 + 0.5) / N_SAMPLES as f32,
            ];
            let m = ggx.sample_visible(wo, u);
            let wi = 2.0 * wo.dot(m) * m - wo;
            if wi.z <= 0.0 {
                continue;
            }
            let weight = ggx.g2(wo, wi) / ggx.g1(wo);
            let f = schlick_weight(wo.dot(m));
            sum[0] += weight * (1.0 - f);
            sum[1] += weight * f;
        }
        let n = (N_SAMPLES * N_SAMPLES) as f32;
        [sum[0] / n, sum[1] / n]
    }

    #[test]
    fn the_file_holds_the_integrals() {
        let integrals: Vec<[f32; 2]> = (0..N * N)
            .map(|i| {
                let alpha = alpha_at(i / N).max(SMOOTH_ALPHA);
                split_albedo(Ggx { alpha }, cos_at(i % N))
            })
            .collect();
        if std::env::var_os("UPDATE_ALBEDO_TABLE").is_some() {
            let bytes: Vec<u8> = integrals
                .iter()
                .flatten()
                .flat_map(|x| x.to_le_bytes())
                .collect();
            std::fs::write("src/bsdf/albedo_table.bin", bytes).unwrap();
        }
        for (i, (kept, integral)) in TABLE.directional.iter().zip(&integrals).enumerate() {
            for k in 0..2 {
                assert!(
                    (kept[k] - integral[k]).abs() < 1e-5,
                    "entry {i}: {kept:?} and {integral:?}; UPDATE_ALBEDO_TABLE=1 writes the file anew"
                );
            }
        }
    }
}
