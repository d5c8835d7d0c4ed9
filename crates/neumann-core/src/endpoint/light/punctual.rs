//! Lights without extent: point, spot and directional (`KHR_lights_punctual`).

use std::f32::consts::PI;

use glam::Vec3;

use super::{Bounds, disk_pdf_a, position_before_scene};
use crate::endpoint::{Aim, Spread, Start, StartDensities};
use crate::math::Frame;
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
    /// Cosine of the angle within which intensity is full.
    pub cos_inner: f32,
    /// Cosine of the angle beyond which there is no light.
    pub cos_outer: f32,
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
    /// Power of the cone, the soft edge counted as linear in cosine, which is close enough to choose by.
    pub(super) fn power(&self) -> Rgb {
        self.intensity * (2.0 * PI * (1.0 - 0.5 * (self.cos_inner + self.cos_outer)))
    }

    /// Share of the intensity towards a direction that makes the given cosine with the axis, as in
    /// `KHR_lights_punctual`: squared, linear in cosine between the cones.
    #[inline]
    fn falloff(&self, cos: f32) -> f32 {
        let width = (self.cos_inner - self.cos_outer).max(1e-3);
        let linear = ((cos - self.cos_outer) / width).clamp(0.0, 1.0);
        linear * linear
    }

    #[inline]
    pub(super) fn aim(&self, x: Vec3) -> Option<Aim> {
        let intensity = |direction: Vec3| self.intensity * self.falloff(direction.dot(self.axis));
        let pdf_w = warp::uniform_cone_pdf_w(self.cos_outer);
        let aim = aim_at_point(self.position, x, intensity, pdf_w)?;
        (!aim.value.is_black()).then_some(aim)
    }

    pub(super) fn start(&self, u: [f32; 2]) -> Option<Start> {
        let local = warp::uniform_cone(u, self.cos_outer);
        let direction = Frame::from_z(self.axis).world_from_local(local);
        let intensity = self.intensity * self.falloff(local.z);
        let pdf_w = warp::uniform_cone_pdf_w(self.cos_outer);
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
        }
    }

    pub(super) fn start(&self, u: [f32; 2], bounds: Bounds) -> Start {
        Start {
            position: position_before_scene(self.direction, u, bounds),
            error: 0.0,
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
    })
}

fn start_at_point(position: Vec3, direction: Vec3, intensity: Rgb, pdf_w: f32) -> Start {
    Start {
        position,
        error: 0.0,
        ng: direction,
        direction,
        value: intensity,
        cos: 1.0,
        densities: StartDensities { pdf_a: 1.0, pdf_w },
        spread: Spread::Point { pdf_w },
        light: 0,
        on_triangle: None,
        is_delta_position: true,
        is_delta_direction: false,
    }
}
