//! Light from infinitely far away, in lat-long form, sampled by its radiance.
//!
//! Radiance is bilinear between texel centres. The density is constant over a
//! texel in (u, v), proportional to the integral of the bilinear radiance over that
//! texel times sin θ, so that nothing bright is ever drawn with density zero. A map of one
//! colour is a uniform sky, whose directions need no map.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use glam::Vec3;

use super::{Bounds, disk_pdf_a, position_before_scene};
use crate::endpoint::{Aim, Spread, Start, StartDensities};
use crate::math::ray::NO_TRIANGLE;
use crate::radiometry::Rgb;
use crate::sampling::discrete::Grid2;
use crate::sampling::warp;
use crate::scene::description::EnvironmentDescription;

/// Light from every direction.
#[derive(Clone, Debug)]
pub struct EnvironmentLight {
    map: Arc<EnvironmentDescription>,
    intensity: f32,
    sin_rotation: f32,
    cos_rotation: f32,
    distribution: Distribution,
    /// `∫ L dω`, W/m².
    fluence: Rgb,
}

/// How directions are drawn.
#[derive(Clone, Debug)]
enum Distribution {
    /// Uniformly: radiance is the same from everywhere.
    Uniform(Rgb),
    /// By the texels.
    Texels(Grid2),
}

/// A map of one row still needs rows, so that its density can follow sin θ.
const MIN_ROWS: usize = 64;

impl EnvironmentLight {
    /// A light from a map; `None` if it is black. `brightness` multiplies its intensity.
    #[must_use]
    pub fn new(map: &Arc<EnvironmentDescription>, brightness: f32) -> Option<Self> {
        let rows = if map.height == 1 {
            MIN_ROWS
        } else {
            map.height
        };
        let columns = map.width;
        let solid_angle = |y: usize| {
            let (top, bottom) = (y as f64, (y + 1) as f64);
            let h = std::f64::consts::PI / rows as f64;
            ((top * h).cos() - (bottom * h).cos()) * std::f64::consts::TAU / columns as f64
        };
        let intensity = map.intensity * brightness;
        let (sin_rotation, cos_rotation) = map.rotation.sin_cos();
        let mut fluence = [0f64; 3];
        let mut add = |mean: Rgb, w: f64| {
            for (sum, c) in fluence.iter_mut().zip(mean.to_array()) {
                *sum += f64::from(c) * w;
            }
            f64::from(mean.mean()) * w
        };
        let first = map.texels.get(0);
        let distribution = if map.texels.iter().all(|texel| texel == first) {
            let sum: f64 = (0..rows).map(|y| add(first, solid_angle(y))).sum();
            fluence = fluence.map(|c| c * columns as f64);
            if sum <= 0.0 {
                return None;
            }
            Distribution::Uniform(first * intensity)
        } else {
            let mut means = Means::new(map, rows);
            Distribution::Texels(Grid2::from_rows(columns, rows, |y, weights| {
                let w = solid_angle(y);
                for (weight, mean) in weights.iter_mut().zip(means.next_row()) {
                    *weight = add(mean, w);
                }
            })?)
        };
        (intensity > 0.0).then(|| Self {
            map: Arc::clone(map),
            intensity,
            sin_rotation,
            cos_rotation,
            distribution,
            fluence: Rgb::from(fluence.map(|c| c as f32)) * intensity,
        })
    }

    pub(super) fn power(&self, bounds: Bounds) -> Rgb {
        self.fluence * (PI * bounds.radius * bounds.radius)
    }

    /// Radiance from `direction`, which points away from the scene.
    #[must_use]
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Rgb {
        match &self.distribution {
            Distribution::Uniform(radiance) => *radiance,
            Distribution::Texels(_) => self.interpolated(direction),
        }
    }

    /// Radiance, if it is the same from everywhere.
    #[must_use]
    pub fn uniform_radiance(&self) -> Option<Rgb> {
        match &self.distribution {
            Distribution::Uniform(radiance) => Some(*radiance),
            Distribution::Texels(_) => None,
        }
    }

    fn interpolated(&self, direction: Vec3) -> Rgb {
        let [u, v] = self.uv(direction);
        let (w, h) = (self.map.width, self.map.height);
        let (x, y) = (u * w as f32 - 0.5, v * h as f32 - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (s, t) = (x - x0, y - y0);
        let column = |i: f32| (i as i64).rem_euclid(w as i64) as usize;
        let row = |i: f32| (i as i64).clamp(0, h as i64 - 1) as usize;
        let at = |x: f32, y: f32| self.map.texels.get(row(y) * w + column(x));
        let top = at(x0, y0).lerp(at(x0 + 1.0, y0), s);
        let bottom = at(x0, y0 + 1.0).lerp(at(x0 + 1.0, y0 + 1.0), s);
        top.lerp(bottom, t) * self.intensity
    }

    /// Density of `direction` in `aim`, 1/sr.
    #[must_use]
    pub fn pdf_w(&self, direction: Vec3) -> f32 {
        match &self.distribution {
            Distribution::Uniform(_) => warp::UNIFORM_SPHERE_PDF_W,
            Distribution::Texels(grid) => {
                let uv = self.uv(direction);
                pdf_w_from_density(grid.density(uv), uv[1])
            }
        }
    }

    pub(super) fn aim(&self, u: [f32; 2], bounds: Bounds) -> Option<Aim> {
        let (wi, pdf_w) = self.sample(u)?;
        Some(Aim {
            wi,
            distance: f32::INFINITY,
            value: self.radiance(wi),
            pdf_w,
            is_delta: false,
            cos_at_endpoint: 1.0,
            surface: None,
            start: StartDensities {
                pdf_a: disk_pdf_a(bounds),
                pdf_w,
            },
            spread: Spread::Parallel {
                pdf_a: disk_pdf_a(bounds),
            },
            start_over_aim: 1.0,
        })
    }

    pub(super) fn start(
        &self,
        u_direction: [f32; 2],
        u_position: [f32; 2],
        bounds: Bounds,
    ) -> Option<Start> {
        let (towards, pdf_w) = self.sample(u_direction)?;
        let direction = -towards;
        Some(Start {
            position: position_before_scene(direction, u_position, bounds),
            triangle: NO_TRIANGLE,
            ng: direction,
            direction,
            value: self.radiance(towards),
            cos: 1.0,
            densities: StartDensities {
                pdf_a: disk_pdf_a(bounds),
                pdf_w,
            },
            spread: Spread::Parallel {
                pdf_a: disk_pdf_a(bounds),
            },
            light: 0,
            on_triangle: None,
            is_delta_position: false,
            is_delta_direction: false,
        })
    }

    fn sample(&self, u: [f32; 2]) -> Option<(Vec3, f32)> {
        let (direction, pdf_w) = match &self.distribution {
            Distribution::Uniform(_) => (warp::uniform_sphere(u), warp::UNIFORM_SPHERE_PDF_W),
            Distribution::Texels(grid) => {
                let (uv, density) = grid.sample(u);
                (self.direction(uv), pdf_w_from_density(density, uv[1]))
            }
        };
        (pdf_w > 0.0).then_some((direction, pdf_w))
    }

    /// `u = 1/2 + atan2(x, -z) / 2π`, `v = acos(y) / π` of the direction turned back by the rotation.
    fn uv(&self, direction: Vec3) -> [f32; 2] {
        let d = self.turned(direction, -self.sin_rotation);
        let u = 0.5 + d.x.atan2(-d.z) / TAU;
        // The arc cosine of y would lose half of all digits near the poles.
        let v = (d.x * d.x + d.z * d.z).sqrt().atan2(d.y) / PI;
        [u.rem_euclid(1.0), v]
    }

    fn direction(&self, [u, v]: [f32; 2]) -> Vec3 {
        let (sin_theta, cos_theta) = (PI * v).sin_cos();
        let (sin_phi, cos_phi) = (TAU * (u - 0.5)).sin_cos();
        let d = Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi);
        self.turned(d, self.sin_rotation)
    }

    /// Turns about +Y, counter-clockwise seen from above for a positive sine.
    fn turned(&self, d: Vec3, sin: f32) -> Vec3 {
        let cos = self.cos_rotation;
        Vec3::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x)
    }
}

/// Density over directions of one over (u, v).
fn pdf_w_from_density(density: f32, v: f32) -> f32 {
    // dω = sin θ dθ dφ = 2π² sin θ du dv.
    let sin = (PI * v).sin();
    if sin > 0.0 {
        density / (TAU * PI * sin)
    } else {
        0.0
    }
}

/// Means over texels of the bilinear interpolation between texel centres, row by row: weights
/// 1/8, 6/8, 1/8 each way. Each texel is read once.
struct Means<'a> {
    map: &'a EnvironmentDescription,
    n_rows: usize,
    next: usize,
    /// The row above the next one, that row and the one below, averaged along themselves.
    rows: [Vec<Rgb>; 3],
}

impl<'a> Means<'a> {
    fn new(map: &'a EnvironmentDescription, n_rows: usize) -> Self {
        let first = averaged_row(map, 0);
        Self {
            map,
            n_rows,
            next: 0,
            rows: [Vec::new(), first.clone(), first],
        }
    }

    fn next_row(&mut self) -> impl Iterator<Item = Rgb> {
        // Above the first row and below the last one is the row itself.
        self.rows.rotate_left(1);
        let is_new = self.next + 1 < self.n_rows.min(self.map.height);
        self.rows[2] = if is_new {
            averaged_row(self.map, self.next + 1)
        } else {
            self.rows[1].clone()
        };
        self.next += 1;
        let [above, row, below] = &self.rows;
        let neighbours = above.iter().zip(below);
        row.iter()
            .zip(neighbours)
            .map(|(here, (above, below))| *here * 0.75 + (*above + *below) * 0.125)
    }
}

fn averaged_row(map: &EnvironmentDescription, y: usize) -> Vec<Rgb> {
    let n = map.width;
    let row: Vec<Rgb> = (0..n).map(|x| map.texels.get(y * n + x)).collect();
    (0..n)
        .map(|x| {
            let left = row[if x == 0 { n - 1 } else { x - 1 }];
            let right = row[if x + 1 == n { 0 } else { x + 1 }];
            row[x] * 0.75 + (left + right) * 0.125
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Vec3;

    use super::EnvironmentLight;
    use crate::radiometry::Rgb;
    use crate::scene::description::EnvironmentDescription;

    #[test]
    fn directions_and_coordinates_invert() {
        let mut map = EnvironmentDescription::uniform(Rgb::WHITE);
        map.rotation = 0.7;
        let light = EnvironmentLight::new(&Arc::new(map), 1.0).unwrap();
        for d in [
            Vec3::new(0.3, 0.2, -0.9),
            Vec3::new(-0.3, -0.8, 0.1),
            Vec3::new(0.9, 0.1, 0.4),
        ] {
            let d = d.normalize();
            assert!((light.direction(light.uv(d)) - d).length() < 1e-5);
        }
    }

    #[test]
    fn the_centre_of_the_map_is_minus_z_and_u_grows_towards_plus_x() {
        let map = EnvironmentDescription::uniform(Rgb::WHITE);
        let light = EnvironmentLight::new(&Arc::new(map), 1.0).unwrap();
        assert!((light.uv(Vec3::NEG_Z)[0] - 0.5).abs() < 1e-6);
        assert!((light.uv(Vec3::X)[0] - 0.75).abs() < 1e-6);
        assert!(light.uv(Vec3::Y)[1].abs() < 1e-6);
    }

    #[test]
    fn a_uniform_sky_sends_4_pi() {
        let map = EnvironmentDescription::uniform(Rgb::splat(2.0));
        let light = EnvironmentLight::new(&Arc::new(map), 0.5).unwrap();
        assert!((light.fluence.g / (4.0 * std::f32::consts::PI) - 1.0).abs() < 1e-5);
    }
}
