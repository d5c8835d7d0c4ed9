//! The sphere cut into cells, and the integral of a density over each.
//!
//! Cells are even in height along an axis (or between given heights) and in angle about it;
//! height and angle preserve area, so `∫ p dω` over a cell is an integral over a rectangle. It
//! is computed by Gauss's rule, halving the rectangle until two steps agree.

use std::f64::consts::TAU;

use glam::Vec3;

/// Cells of the sphere.
#[derive(Clone, Debug)]
pub struct SphereCells {
    /// Heights between rows, from 1 down to -1.
    heights: Vec<f64>,
    n_columns: usize,
    /// Angle of the edge before the first column.
    first_angle: f64,
}

impl SphereCells {
    /// `n_rows × n_columns` cells of equal solid angle; with an even number of rows, none
    /// crosses the horizon.
    #[must_use]
    pub fn even(n_rows: usize, n_columns: usize) -> Self {
        let heights = (0..=n_rows)
            .map(|i| 1.0 - 2.0 * i as f64 / n_rows as f64)
            .collect();
        Self::new(heights, n_columns, 0.0)
    }

    /// Cells between given heights (from 1 down to -1), columns from `first_angle` on.
    #[must_use]
    pub fn new(heights: Vec<f64>, n_columns: usize, first_angle: f64) -> Self {
        Self {
            heights,
            n_columns,
            first_angle,
        }
    }

    /// Number of cells.
    #[must_use]
    pub fn n_cells(&self) -> usize {
        (self.heights.len() - 1) * self.n_columns
    }

    /// The cell that a direction falls in; z is the axis.
    #[must_use]
    pub fn cell(&self, w: Vec3) -> usize {
        let w = w.as_dvec3().normalize();
        let below = self.heights[1..].iter().position(|h| w.z >= *h);
        let row = below.unwrap_or(self.heights.len() - 2);
        let angle = (w.y.atan2(w.x) - self.first_angle).rem_euclid(TAU);
        let column = (angle / TAU * self.n_columns as f64) as usize;
        row * self.n_columns + column.min(self.n_columns - 1)
    }

    /// `∫ pdf dω` over each cell.
    #[must_use]
    pub fn integrals(&self, pdf_w: impl Fn(Vec3) -> f64) -> Vec<f64> {
        let width = TAU / self.n_columns as f64;
        let at = |z: f64, phi: f64| {
            let r = (1.0 - z * z).max(0.0).sqrt();
            let (sin, cos) = phi.sin_cos();
            pdf_w(Vec3::new((r * cos) as f32, (r * sin) as f32, z as f32))
        };
        let mut integrals = Vec::with_capacity(self.n_cells());
        for rows in self.heights.windows(2) {
            for column in 0..self.n_columns {
                let left = self.first_angle + width * column as f64;
                let cell = Rectangle {
                    x: rows[1],
                    y: left,
                    width: rows[0] - rows[1],
                    height: width,
                };
                integrals.push(cell.integral(&at));
            }
        }
        integrals
    }
}

#[derive(Clone, Copy)]
struct Rectangle {
    x: f64,
    y: f64,
    width: f64,
    height: f64,
}

/// Absolute error allowed for a cell: far below what counting samples can tell.
const TOLERANCE: f64 = 2e-7;
/// A rectangle is halved at least so often each way, lest a peak hide between points,
const FEWEST_HALVINGS: u32 = 1;
/// and at most so often.
const MOST_HALVINGS: u32 = 9;

impl Rectangle {
    fn integral(self, f: &impl Fn(f64, f64) -> f64) -> f64 {
        self.refined(f, self.gauss(f), 0)
    }

    fn refined(self, f: &impl Fn(f64, f64) -> f64, coarse: f64, depth: u32) -> f64 {
        let quarters = self.quarters();
        let fine = quarters.map(|q| q.gauss(f));
        let sum: f64 = fine.iter().sum();
        // Depth makes the tolerance smaller by the square root of the number of pieces.
        let tolerance = TOLERANCE / f64::from(1u32 << depth);
        let is_settled = (sum - coarse).abs() < tolerance && depth >= FEWEST_HALVINGS;
        if is_settled || depth >= MOST_HALVINGS {
            return sum;
        }
        quarters
            .iter()
            .zip(fine)
            .map(|(q, value)| q.refined(f, value, depth + 1))
            .sum()
    }

    fn quarters(self) -> [Self; 4] {
        let (width, height) = (0.5 * self.width, 0.5 * self.height);
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(i, j)| Self {
            x: self.x + i * width,
            y: self.y + j * height,
            width,
            height,
        })
    }

    /// Gauss's rule of three points each way.
    fn gauss(self, f: &impl Fn(f64, f64) -> f64) -> f64 {
        let points = [
            (0.5 - 0.15f64.sqrt(), 5.0 / 18.0),
            (0.5, 4.0 / 9.0),
            (0.5 + 0.15f64.sqrt(), 5.0 / 18.0),
        ];
        let mut sum = 0.0;
        for (s, ws) in points {
            for (t, wt) in points {
                sum += ws * wt * f(self.x + s * self.width, self.y + t * self.height);
            }
        }
        sum * self.width * self.height
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::SphereCells;

    #[test]
    fn integrals_of_a_known_density_add_up() {
        let cells = SphereCells::even(8, 12);
        let integrals = cells.integrals(|w| f64::from(w.z.max(0.0)) / PI);
        assert!((integrals.iter().sum::<f64>() - 1.0).abs() < 1e-6);
        let below: f64 = integrals[4 * 12..].iter().sum();
        assert!(below.abs() < 1e-12);
        // The top row holds cosines from 3/4 to 1: 1 - 9/16.
        let top: f64 = integrals[..12].iter().sum();
        assert!((top - 7.0 / 16.0).abs() < 1e-6);
    }
}
