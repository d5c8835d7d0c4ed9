//! A BSDF as a solid: every direction at the distance of its value. A grid of directions, fine
//! where lobes are narrow.

use glam::Vec3;

use super::polar::offsets;
use crate::bsdf::{Scatter, TransportMode};
use crate::radiometry::Rgb;

/// Rows of a hemisphere and columns about the normal, where there are no lobes.
const N_ROWS: usize = 16;
const N_COLUMNS: usize = 36;
/// Offsets from a peak are no longer than this, degrees: of rows, and of columns.
const REACH: [f32; 2] = [30.0, 120.0];
/// Degrees from the surface of the rows beside it.
const AT_SURFACE: f32 = 0.05;

/// Directions in rows about the normal, with their values.
#[derive(Clone, Debug)]
pub struct Solid {
    /// Columns of a row; the last one is the first again.
    pub n_columns: usize,
    /// Directions, row by row, from the pole on the viewer's side on. No row lies in the surface:
    /// the last one on this side and the first one behind are beside each other.
    pub directions: Vec<Vec3>,
    /// `f(wo, wi)`, 1/sr.
    pub f: Vec<Rgb>,
}

impl Solid {
    pub(super) fn new(bsdf: &impl Scatter, wo: Vec3, peaks: &[Vec3]) -> Self {
        let side = 1f32.copysign(wo.z);
        let mut rows: Vec<f32> = Vec::new();
        for below in [0.0, 90.0] {
            let step = 90.0 / N_ROWS as f32;
            rows.extend((0..=N_ROWS).map(|i| below + i as f32 * step));
        }
        rows.retain(|row| (row - 90.0).abs() > AT_SURFACE);
        rows.extend([90.0 - AT_SURFACE, 90.0 + AT_SURFACE]);
        let step = 360.0 / N_COLUMNS as f32;
        let mut columns: Vec<f32> = (0..N_COLUMNS).map(|i| i as f32 * step).collect();
        for peak in peaks {
            let theta = (peak.z * side).clamp(-1.0, 1.0).acos();
            let here = theta.to_degrees();
            rows.extend(offsets(REACH[0]).map(|offset| here + offset));
            // Columns are closer together the nearer they are to the normal.
            let stretch = 1.0 / theta.sin().max(0.05);
            let middle = if peak.x < 0.0 { 180.0 } else { 0.0 };
            let about = offsets(REACH[1]).map(|offset| middle + offset * stretch);
            let about = about.filter(|column| (column - middle).abs() < REACH[1]);
            columns.extend(about.map(|column| column.rem_euclid(360.0)));
        }
        rows.retain(|row| (0.0..=180.0).contains(row) && (row - 90.0).abs() >= AT_SURFACE);
        let ordered = |mut angles: Vec<f32>| {
            angles.sort_by(f32::total_cmp);
            angles.dedup_by(|a, b| (*a - *b).abs() < 0.01);
            angles
        };
        let (rows, mut columns) = (ordered(rows), ordered(columns));
        columns.push(360.0);
        let mut solid = Self {
            n_columns: columns.len(),
            directions: Vec::with_capacity(rows.len() * columns.len()),
            f: Vec::new(),
        };
        for row in rows {
            let (sin_theta, cos_theta) = row.to_radians().sin_cos();
            for column in &columns {
                let (sin, cos) = column.to_radians().sin_cos();
                let wi = Vec3::new(sin_theta * cos, sin_theta * sin, side * cos_theta);
                solid.directions.push(wi.normalize());
            }
        }
        let value = |wi: &Vec3| bsdf.eval(wo, *wi, TransportMode::Radiance);
        solid.f = solid.directions.iter().map(value).collect();
        solid
    }
}
