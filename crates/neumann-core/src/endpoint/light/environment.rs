//! Light from infinitely far away, in lat-long form, sampled by its radiance.
//!
//! Radiance is bilinear between texel centres. The density is constant over a
//! texel in (u, v), proportional to the integral of the bilinear radiance over that
//! texel times sin θ, so that nothing bright is ever drawn with density zero. A map of one
//! colour is a uniform sky, whose directions need no map. A sun is a disk of even radiance on top
//! of
//! the map; a direction is drawn from either in proportion to what they send.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use glam::Vec3;

use super::{Bounds, disk_pdf_a, position_before_scene};
use crate::endpoint::{Aim, Spread, Start, StartDensities};
use crate::math::Frame;
use crate::math::ray::NO_TRIANGLE;
use crate::radiometry::Rgb;
use crate::sampling::discrete::{Grid2, one_of_two};
use crate::sampling::warp;
use crate::scene::description::{EnvironmentDescription, SunDescription};

/// Light from every direction.
#[derive(Clone, Debug)]
pub struct EnvironmentLight {
    map: Arc<EnvironmentDescription>,
    /// Multiplies the texels.
    intensity: Rgb,
    sin_rotation: f32,
    cos_rotation: f32,
    distribution: Distribution,
    sun: Option<Sun>,
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

/// A disk in front of the map, as it stands in the world.
#[derive(Clone, Copy, Debug)]
struct Sun {
    frame: Frame,
    /// Sine of a quarter of the angle it fills: its solid angle is 4π times the square.
    sin_half_radius: f32,
    radiance: Rgb,
    pdf_w: f32,
    /// How often a direction is drawn from it.
    share: f32,
}

/// A map of one row still needs rows, so that its density can follow sin θ.
const MIN_ROWS: usize = 64;

impl EnvironmentLight {
    /// A light from a map; `None` if it is black. `brightness` multiplies its intensity.
    #[must_use]
    pub fn new(map: &Arc<EnvironmentDescription>, brightness: f32) -> Option<Self> {
        Self::tinted(map, brightness, Rgb::WHITE)
    }

    /// The same, its radiance multiplied by a colour.
    #[must_use]
    pub fn tinted(map: &Arc<EnvironmentDescription>, brightness: f32, tint: Rgb) -> Option<Self> {
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
        let mut fluence = [0f64; 3];
        let mut add = |mean: Rgb, w: f64| {
            let mean = mean * tint;
            for (sum, c) in fluence.iter_mut().zip(mean.to_array()) {
                *sum += f64::from(c) * w;
            }
            f64::from(mean.mean()) * w
        };
        let first = map.texels.get(0);
        let distribution = if map.texels.iter().all(|texel| texel == first) {
            for y in 0..rows {
                add(first, solid_angle(y));
            }
            fluence = fluence.map(|c| c * columns as f64);
            Distribution::Uniform(first * (tint * intensity))
        } else {
            let mut means = Means::new(map, rows);
            Distribution::Texels(Grid2::from_rows(columns, rows, |y, weights| {
                let w = solid_angle(y);
                for (weight, mean) in weights.iter_mut().zip(means.next_row()) {
                    *weight = add(mean, w);
                }
            })?)
        };
        let sin_cos = map.rotation.sin_cos();
        let map_power = fluence.iter().sum::<f64>() as f32 / 3.0;
        let tinted = |sun: SunDescription| SunDescription {
            radiance: sun.radiance * tint,
            ..sun
        };
        let sun = map.sun.map(tinted);
        let sun = sun.and_then(|sun| Sun::new(&sun, sin_cos, map_power));
        let fluence = sun.map_or(Rgb::BLACK, |sun| sun.radiance / sun.pdf_w)
            + Rgb::from(fluence.map(|c| c as f32));
        (intensity > 0.0 && !fluence.is_black()).then(|| Self {
            map: Arc::clone(map),
            intensity: tint * intensity,
            sin_rotation: sin_cos.0,
            cos_rotation: sin_cos.1,
            distribution,
            sun: sun.map(|sun| Sun {
                radiance: sun.radiance * intensity,
                ..sun
            }),
            fluence: fluence * intensity,
        })
    }

    pub(super) fn power(&self, bounds: Bounds) -> Rgb {
        self.fluence * (PI * bounds.radius * bounds.radius)
    }

    /// Radiance from `direction`, which points away from the scene.
    #[must_use]
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Rgb {
        let of_map = match &self.distribution {
            Distribution::Uniform(radiance) => *radiance,
            Distribution::Texels(_) => self.interpolated(direction),
        };
        match &self.sun {
            Some(sun) if sun.holds(direction) => of_map + sun.radiance,
            _ => of_map,
        }
    }

    /// True if `direction` is in the sun's disk.
    #[must_use]
    pub fn is_in_sun(&self, direction: Vec3) -> bool {
        self.sun.is_some_and(|sun| sun.holds(direction))
    }

    /// Radiance, if it is the same from everywhere.
    #[must_use]
    pub fn uniform_radiance(&self) -> Option<Rgb> {
        match &self.distribution {
            Distribution::Uniform(radiance) if self.sun.is_none() => Some(*radiance),
            _ => None,
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
        let of_map = match &self.distribution {
            Distribution::Uniform(_) => warp::UNIFORM_SPHERE_PDF_W,
            Distribution::Texels(grid) => {
                let uv = self.uv(direction);
                pdf_w_from_density(grid.density(uv), uv[1])
            }
        };
        self.mixed(direction, of_map)
    }

    /// Density of a direction that the map alone would yield with density `of_map`.
    fn mixed(&self, direction: Vec3, of_map: f32) -> f32 {
        match &self.sun {
            None => of_map,
            Some(sun) => {
                let of_sun = if sun.holds(direction) { sun.pdf_w } else { 0.0 };
                sun.share * of_sun + (1.0 - sun.share) * of_map
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
            opacity: 1.0,
            light: u32::MAX,
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
            opacity: 1.0,
            is_delta_position: false,
            is_delta_direction: false,
        })
    }

    fn sample(&self, mut u: [f32; 2]) -> Option<(Vec3, f32)> {
        if let Some(sun) = &self.sun {
            let (is_of_sun, rest) = one_of_two(u[0], sun.share);
            u[0] = rest;
            if is_of_sun {
                let direction = sun.direction(u);
                let pdf_w = self.pdf_w(direction);
                return (pdf_w > 0.0).then_some((direction, pdf_w));
            }
        }
        let (direction, of_map) = match &self.distribution {
            Distribution::Uniform(_) => (warp::uniform_sphere(u), warp::UNIFORM_SPHERE_PDF_W),
            Distribution::Texels(grid) => {
                let (uv, density) = grid.sample(u);
                (self.direction(uv), pdf_w_from_density(density, uv[1]))
            }
        };
        let pdf_w = self.mixed(direction, of_map);
        (pdf_w > 0.0).then_some((direction, pdf_w))
    }

    /// `u = 1/2 + atan2(x, -z) / 2π`, `v = acos(y) / π` of the direction turned back by the
    /// rotation.
    fn uv(&self, direction: Vec3) -> [f32; 2] {
        let d = turned(direction, (-self.sin_rotation, self.cos_rotation));
        let u = 0.5 + d.x.atan2(-d.z) / TAU;
        // The arc cosine of y would lose half of all digits near the poles.
        let v = (d.x * d.x + d.z * d.z).sqrt().atan2(d.y) / PI;
        [u.rem_euclid(1.0), v]
    }

    fn direction(&self, [u, v]: [f32; 2]) -> Vec3 {
        let (sin_theta, cos_theta) = (PI * v).sin_cos();
        let (sin_phi, cos_phi) = (TAU * (u - 0.5)).sin_cos();
        let d = Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi);
        turned(d, (self.sin_rotation, self.cos_rotation))
    }
}

impl Sun {
    /// Before `intensity`; `None` if it sends nothing. `map_power` is what the map sends beside it.
    fn new(sun: &SunDescription, sin_cos: (f32, f32), map_power: f32) -> Option<Self> {
        let sin_half_radius = (0.5 * sun.angular_radius).sin();
        let solid_angle = 4.0 * PI * sin_half_radius * sin_half_radius;
        let power = sun.radiance.mean() * solid_angle;
        (power > 0.0).then(|| Self {
            frame: Frame::from_z(turned(sun.direction, sin_cos)),
            sin_half_radius,
            radiance: sun.radiance,
            pdf_w: 1.0 / solid_angle,
            share: power / (power + map_power),
        })
    }

    /// The chord is exact where the cosine of so small an angle would have lost its digits.
    fn holds(&self, direction: Vec3) -> bool {
        let chord = 2.0 * self.sin_half_radius;
        (direction - self.frame.z).length_squared() <= chord * chord
    }

    /// Uniform in the disk: the square of the chord is.
    fn direction(&self, u: [f32; 2]) -> Vec3 {
        let p = warp::disk(u) * self.sin_half_radius;
        let half_chord_squared = p.length_squared();
        let stretch = 2.0 * (1.0 - half_chord_squared).sqrt();
        let local = Vec3::new(p.x * stretch, p.y * stretch, 1.0 - 2.0 * half_chord_squared);
        self.frame.world_from_local(local)
    }
}

/// Turns about +Y, counter-clockwise seen from above for a positive sine.
fn turned(d: Vec3, (sin, cos): (f32, f32)) -> Vec3 {
    Vec3::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x)
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
    use crate::scene::description::{EnvironmentDescription, SunDescription};

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

    /// Directions of the sun are in its disk, evenly, and come with the density that is stated for
    /// them.
    #[test]
    fn a_sun_is_drawn_in_proportion_to_what_it_sends() {
        for angular_radius in [0.00465f32, 0.2, 1.5] {
            let mut map = EnvironmentDescription::uniform(Rgb::WHITE);
            let solid_angle = 4.0 * std::f32::consts::PI * (0.5 * angular_radius).sin().powi(2);
            map.rotation = 0.9;
            map.sun = Some(SunDescription {
                direction: Vec3::new(0.5, 0.6, -0.4).normalize(),
                angular_radius,
                radiance: Rgb::splat(12.0 * std::f32::consts::PI / solid_angle),
            });
            let light = EnvironmentLight::new(&Arc::new(map), 1.0).unwrap();
            assert!(light.uniform_radiance().is_none());
            assert!((light.fluence.g / (16.0 * std::f32::consts::PI) - 1.0).abs() < 1e-5);
            let n = 64;
            let (mut n_in_sun, mut mean, mut n_inner) = (0, 0.0, 0);
            for i in 0..n * n {
                let u = [i % n, i / n].map(|k| (k as f32 + 0.5) / n as f32);
                let (direction, pdf_w) = light.sample(u).unwrap();
                assert!((light.pdf_w(direction) / pdf_w - 1.0).abs() < 1e-3);
                mean += light.radiance(direction).g / pdf_w / (n * n) as f32;
                if light.is_in_sun(direction) {
                    n_in_sun += 1;
                    let chord = (direction - light.sun.unwrap().frame.z).length();
                    n_inner +=
                        i32::from(chord < std::f32::consts::SQRT_2 * (0.5 * angular_radius).sin());
                }
            }
            assert!((mean / light.fluence.g - 1.0).abs() < 1e-3, "{mean}");
            let share = n_in_sun as f32 / (n * n) as f32;
            let of_map = 0.25 * solid_angle / (4.0 * std::f32::consts::PI);
            assert!((share - 0.75 - of_map).abs() < 0.02, "{share}");
            let inner = n_inner as f32 / n_in_sun as f32;
            assert!(
                (inner - 0.5).abs() < 0.02,
                "half of the disk by area: {inner}"
            );
        }
    }

    /// A colour multiplies map and sun alike, and what is drawn follows it.
    #[test]
    fn a_tint_multiplies_radiance_and_white_changes_no_bit() {
        let texels = vec![Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 0.3, 0.7)];
        let map = Arc::new(EnvironmentDescription {
            width: 2,
            height: 1,
            texels: texels.into(),
            sun: Some(SunDescription {
                direction: Vec3::Y,
                angular_radius: 0.2,
                radiance: Rgb::new(3.0, 2.0, 1.0),
            }),
            ..EnvironmentDescription::uniform(Rgb::BLACK)
        });
        let plain = EnvironmentLight::new(&map, 0.7).unwrap();
        let tint = Rgb::new(1.0, 0.25, 0.5);
        let tinted = EnvironmentLight::tinted(&map, 0.7, tint).unwrap();
        for u in [[0.1, 0.3], [0.6, 0.9], [0.95, 0.2], [0.4, 0.01]] {
            let (wi, pdf_w) = tinted.sample(u).unwrap();
            assert_eq!(pdf_w, tinted.pdf_w(wi));
            let expected = plain.radiance(wi) * tint;
            let found = tinted.radiance(wi).to_array();
            let apart = expected.to_array().into_iter().zip(found);
            for (a, b) in apart {
                assert!((a - b).abs() < 1e-6, "{a} {b}");
            }
        }
        let least = |light: &EnvironmentLight| light.fluence.to_array().map(f32::to_bits);
        let white = EnvironmentLight::tinted(&map, 0.7, Rgb::WHITE).unwrap();
        assert_eq!(least(&white), least(&plain));
        assert!(EnvironmentLight::tinted(&map, 0.7, Rgb::BLACK).is_none());
    }

    #[test]
    fn a_uniform_sky_sends_4_pi() {
        let map = EnvironmentDescription::uniform(Rgb::splat(2.0));
        let light = EnvironmentLight::new(&Arc::new(map), 0.5).unwrap();
        assert!((light.fluence.g / (4.0 * std::f32::consts::PI) - 1.0).abs() < 1e-5);
    }
}
