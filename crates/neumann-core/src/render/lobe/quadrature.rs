//! Integrals over all directions, by Gauss's rule over cells of the two angles that are halved
//! where it is not exact.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::Vec3;

use crate::bsdf::{Scatter, TransportMode};
use crate::radiometry::Rgb;

/// Cells of a hemisphere at first: in the angle to the normal, and about it.
const N_CELLS: [usize; 2] = [8, 16];
/// A cell is halved each way until its integral changes by less than this,
const TOLERANCE: f64 = 2e-6;
/// but once at least, since a narrow lobe may lie between the points of a cell and of its quarters,
const FEWEST_HALVINGS: u32 = 1;
/// and so often at most.
const MOST_HALVINGS: u32 = 10;
/// Points of Gauss's rule in [0, 1] with their weights.
const POINTS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// What values and densities amount to over all directions, mirror-like lobes not counted.
#[derive(Clone, Copy, Debug)]
pub struct Integrals {
    /// `∫ f* cos dω`: the share of the light that is scattered.
    pub albedo: Rgb,
    /// `∫ f cos dω`, luminance.
    pub f_cos: f64,
    /// `∫ pdf_w dω`: the probability that a direction is drawn from the density.
    pub pdf_w: f64,
}

/// What is integrated: albedo in three channels, `f cos`, density.
type Values = [f64; 5];

impl Integrals {
    /// Over the sphere, for a viewing direction.
    #[must_use]
    pub fn new(bsdf: &impl Scatter, wo: Vec3) -> Self {
        let at = |theta: f64, phi: f64| -> Values {
            let ((sin_theta, cos_theta), (sin, cos)) = (theta.sin_cos(), phi.sin_cos());
            let wi = Vec3::new(
                (sin_theta * cos) as f32,
                (sin_theta * sin) as f32,
                cos_theta as f32,
            );
            let (f, pdf_w) = bsdf.eval_and_pdf_w(wo, wi, TransportMode::Radiance);
            // Importance meets another BSDF than radiance only on the other side of the surface.
            let scattered = if wi.z * wo.z < 0.0 {
                bsdf.eval(wo, wi, TransportMode::Importance)
            } else {
                f
            };
            let cos_i = cos_theta.abs();
            let [r, g, b] = scattered.to_array().map(|v| f64::from(v) * cos_i);
            let f_cos = f64::from(f.luminance()) * cos_i;
            [r, g, b, f_cos, f64::from(pdf_w)].map(|v| v * sin_theta)
        };
        let [rows, columns] = N_CELLS;
        let (height, width) = (FRAC_PI_2 / rows as f64, TAU / columns as f64);
        let mut sum = [0.0; 5];
        for row in 0..2 * rows {
            for column in 0..columns {
                let cell = Cell {
                    theta: row as f64 * height,
                    phi: column as f64 * width,
                    height,
                    width,
                };
                add(&mut sum, &cell.refined(&at, cell.gauss(&at), 0));
            }
        }
        let [r, g, b, f_cos, pdf_w] = sum;
        Self {
            albedo: Rgb::new(r as f32, g as f32, b as f32),
            f_cos,
            pdf_w,
        }
    }
}

fn add(sum: &mut Values, values: &Values) {
    for (sum, value) in sum.iter_mut().zip(values) {
        *sum += value;
    }
}

#[derive(Clone, Copy)]
struct Cell {
    theta: f64,
    phi: f64,
    height: f64,
    width: f64,
}

impl Cell {
    fn refined(self, at: &impl Fn(f64, f64) -> Values, coarse: Values, depth: u32) -> Values {
        let quarters = self.quarters().map(|cell| (cell, cell.gauss(at)));
        let mut fine = [0.0; 5];
        for (_, values) in &quarters {
            add(&mut fine, values);
        }
        let apart = fine.iter().zip(coarse).map(|(a, b)| (a - b).abs());
        // Errors of many pieces add up to less than their sum.
        let tolerance = TOLERANCE / f64::from(1u32 << depth);
        let is_settled = apart.fold(0.0, f64::max) < tolerance && depth >= FEWEST_HALVINGS;
        if is_settled || depth == MOST_HALVINGS {
            return fine;
        }
        let mut sum = [0.0; 5];
        for (cell, values) in quarters {
            add(&mut sum, &cell.refined(at, values, depth + 1));
        }
        sum
    }

    fn quarters(self) -> [Self; 4] {
        let (height, width) = (0.5 * self.height, 0.5 * self.width);
        [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)].map(|(i, j)| Self {
            theta: self.theta + i * height,
            phi: self.phi + j * width,
            height,
            width,
        })
    }

    fn gauss(self, at: &impl Fn(f64, f64) -> Values) -> Values {
        let mut sum = [0.0; 5];
        for (s, of_s) in POINTS {
            for (t, of_t) in POINTS {
                let values = at(self.theta + s * self.height, self.phi + t * self.width);
                let weight = of_s * of_t * self.height * self.width;
                add(&mut sum, &values.map(|value| value * weight));
            }
        }
        sum
    }
}
