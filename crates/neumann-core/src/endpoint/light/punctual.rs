//! Lights without extent: point, spot and directional (`KHR_lights_punctual`).

use std::f32::consts::PI;

use glam::Vec3;

use super::{Bounds, disk_pdf_a, position_before_scene};
use crate::endpoint::{Aim, Spread, Start, StartDensities};
use crate::math::Frame;
use crate::math::ray::NO_TRIANGLE;
use crate::radiometry::Rgb;
use crate::sampling::warp;

/// A point shining evenly in all directions.
#[derive(Clone, Copy, Debug)]
pub struct PointLight {
    /// World space, metres.
    pub position: Vec3,
    /// Radiant intensity, W/sr.
    pub intensity: Rgb,
}

/// A point shining into a cone.
#[derive(Clone, Copy, Debug)]
pub struct SpotLight {
    /// World space, metres.
    pub position: Vec3,
    /// Axis of the cone, unit.
    pub axis: Vec3,
    /// Radiant intensity on the axis, W/sr.
    pub intensity: Rgb,
    /// 1 less the cosine of the angle within which intensity is full. (A cosine itself tells the
    /// angles of narrow cones apart no better than single precision tells numbers near 1.)
    pub inner_height: f32,
    /// 1 less the cosine of the angle beyond which there is no light; at least the inner one.
    pub outer_height: f32,
}

/// Light from one direction.
#[derive(Clone, Copy, Debug)]
pub struct DirectionalLight {
    /// Direction that the light travels in, unit.
    pub direction: Vec3,
    /// Irradiance on a surface across the direction, W/m².
    pub irradiance: Rgb,
}

impl PointLight {
    pub(super) fn power(&self) -> Rgb {
        self.intensity * (4.0 * PI)
    }

    #[inline]
    pub(super) fn aim(&self, x: Vec3) -> Option<Aim> {
        aim_at_point(
            self.position,
            x,
            |_| self.intensity,
            warp::UNIFORM_SPHERE_PDF_W,
        )
    }

    pub(super) fn start(&self, u: [f32; 2]) -> Start {
        let direction = warp::uniform_sphere(u);
        start_at_point(
            self.position,
            direction,
            self.intensity,
            warp::UNIFORM_SPHERE_PDF_W,
        )
    }
}

impl SpotLight {
    /// Power of the cone; the soft edge, a square, sends a third of what it would at full
    /// intensity.
    pub(super) fn power(&self) -> Rgb {
        let edge = self.outer_height - self.inner_height;
        self.intensity * (2.0 * PI * (self.inner_height + edge / 3.0))
    }

    /// Share of the intensity towards a unit direction: squared, linear in cosine between the
    /// cones,
    /// as in `KHR_lights_punctual`, but without its limit for cones that are closer than 0.001.
    #[inline]
    fn falloff(&self, direction: Vec3, axis: Vec3) -> f32 {
        let height = 0.5 * (direction - axis).length_squared();
        if height <= self.inner_height {
            return 1.0;
        }
        if height >= self.outer_height {
            return 0.0;
        }
        let linear = (self.outer_height - height) / (self.outer_height - self.inner_height);
        linear * linear
    }

    #[inline]
    pub(super) fn aim(&self, x: Vec3) -> Option<Aim> {
        let intensity = |direction: Vec3| self.intensity * self.falloff(direction, self.axis);
        let pdf_w = warp::uniform_cone_pdf_w(self.outer_height);
        let aim = aim_at_point(self.position, x, intensity, pdf_w)?;
        (!aim.value.is_black()).then_some(aim)
    }

    pub(super) fn start(&self, u: [f32; 2]) -> Option<Start> {
        let local = warp::uniform_cone(u, self.outer_height);
        let direction = Frame::from_z(self.axis).world_from_local(local);
        let intensity = self.intensity * self.falloff(local, Vec3::Z);
        let pdf_w = warp::uniform_cone_pdf_w(self.outer_height);
        (!intensity.is_black()).then(|| start_at_point(self.position, direction, intensity, pdf_w))
    }
}

impl DirectionalLight {
    pub(super) fn power(&self, bounds: Bounds) -> Rgb {
        self.irradiance * (PI * bounds.radius * bounds.radius)
    }

    #[inline]
    pub(super) fn aim(&self, bounds: Bounds) -> Aim {
        Aim {
            wi: -self.direction,
            distance: f32::INFINITY,
            value: self.irradiance,
            pdf_w: 1.0,
            is_delta: true,
            cos_at_endpoint: 1.0,
            surface: None,
            start: StartDensities {
                pdf_a: disk_pdf_a(bounds),
                pdf_w: 1.0,
            },
            spread: Spread::Parallel {
                pdf_a: disk_pdf_a(bounds),
            },
            start_over_aim: 1.0,
            opacity: 1.0,
            light: u32::MAX,
        }
    }

    pub(super) fn start(&self, u: [f32; 2], bounds: Bounds) -> Start {
        Start {
            position: position_before_scene(self.direction, u, bounds),
            triangle: NO_TRIANGLE,
            ng: self.direction,
            direction: self.direction,
            value: self.irradiance,
            cos: 1.0,
            densities: StartDensities {
                pdf_a: disk_pdf_a(bounds),
                pdf_w: 1.0,
            },
            spread: Spread::Parallel {
                pdf_a: disk_pdf_a(bounds),
            },
            light: 0,
            on_triangle: None,
            opacity: 1.0,
            is_delta_position: false,
            is_delta_direction: true,
        }
    }
}

#[inline]
fn aim_at_point(
    position: Vec3,
    x: Vec3,
    intensity: impl Fn(Vec3) -> Rgb,
    pdf_w_start: f32,
) -> Option<Aim> {
    let to_light = position - x;
    let distance_squared = to_light.length_squared();
    if distance_squared <= 0.0 || !distance_squared.is_finite() {
        return None;
    }
    let distance = distance_squared.sqrt();
    let wi = to_light / distance;
    Some(Aim {
        wi,
        distance,
        value: intensity(-wi) / distance_squared,
        pdf_w: 1.0,
        is_delta: true,
        cos_at_endpoint: 1.0,
        surface: None,
        start: StartDensities {
            pdf_a: 1.0,
            pdf_w: pdf_w_start,
        },
        spread: Spread::Point { pdf_w: pdf_w_start },
        start_over_aim: 1.0,
        opacity: 1.0,
        light: u32::MAX,
    })
}

fn start_at_point(position: Vec3, direction: Vec3, intensity: Rgb, pdf_w: f32) -> Start {
    Start {
        position,
        triangle: NO_TRIANGLE,
        ng: direction,
        direction,
        value: intensity,
        cos: 1.0,
        densities: StartDensities { pdf_a: 1.0, pdf_w },
        spread: Spread::Point { pdf_w },
        light: 0,
        on_triangle: None,
        opacity: 1.0,
        is_delta_position: true,
        is_delta_direction: false,
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::SpotLight;
    use crate::math::Frame;
    use crate::radiometry::Rgb;
    use crate::sampling::Sampler;

    /// 1 less the cosine of an angle.
    fn height(degrees: f64) -> f32 {
        (2.0 * (0.5 * degrees.to_radians()).sin().powi(2)) as f32
    }

    fn spot(inner: f64, outer: f64) -> SpotLight {
        SpotLight {
            position: Vec3::ZERO,
            axis: Vec3::new(0.6, -0.64, 0.48),
            intensity: Rgb::splat(100.0),
            inner_height: height(inner),
            outer_height: height(outer),
        }
    }

    const CONES: [(f64, f64); 10] = [
        (0.0, 90.0),
        (90.0, 90.0),
        (40.0, 60.0),
        (2.0, 2.5),
        (2.0, 2.0),
        (1.999, 2.0),
        (0.2, 0.3),
        (0.0, 0.1),
        (0.01, 0.02),
        (0.02, 0.02),
    ];

    #[test]
    fn intensity_is_full_inside_and_falls_as_a_square() {
        for (inner, outer) in CONES {
            let spot = spot(inner, outer);
            let frame = Frame::from_z(spot.axis);
            let at = |degrees: f64| {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let w = frame.world_from_local(Vec3::new(sin as f32, 0.0, cos as f32));
                spot.aim(w).map_or(0.0, |aim| aim.value.g)
            };
            // Single precision tells directions apart to about 1e-5 degrees.
            let share = |degrees: f64| {
                let cos = |x: f64| 2.0 * (0.5 * x.to_radians()).sin().powi(2);
                ((cos(outer) - cos(degrees)) / (cos(outer) - cos(inner))).powi(2)
            };
            for k in 1..10 {
                let k = f64::from(k) / 10.0;
                let name = format!("{inner} {outer} at {k}");
                let inside = at(k * inner);
                assert!((inside - 100.0).abs() < 1e-3, "{name}: {inside}");
                if outer - inner > 0.05 * outer {
                    let degrees = inner + k * (outer - inner);
                    let (found, right) = (f64::from(at(degrees)), 100.0 * share(degrees));
                    let slope = (share(degrees - 1e-5) - share(degrees + 1e-5)).abs();
                    assert!(
                        (found - right).abs() < 0.01 + 100.0 * slope,
                        "{name}: {found} for {right}"
                    );
                }
            }
            assert_eq!(at(1.01 * outer), 0.0);
        }
    }

    #[test]
    fn starts_carry_the_power() {
        for (inner, outer) in CONES {
            let spot = spot(inner, outer);
            let n = 20_000;
            let sum: f64 = (0..n)
                .filter_map(|i| spot.start(Sampler::new(4, 0, i).next_2d()))
                .map(|start| f64::from(start.value.g / start.densities.pdf_w))
                .sum();
            let (mean, power) = (sum / f64::from(n), f64::from(spot.power().g));
            assert!(
                (mean / power - 1.0).abs() < 1e-3,
                "{inner} {outer}: {mean} for {power}"
            );
        }
    }
}
