//! An emissive triangle.
//!
//! It emits from its front, or from both sides.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;

use super::bounds::LightBounds;
use super::emission::{Emission, VaryingEmission};
use crate::endpoint::{Aim, Spread, Start, StartDensities, SurfacePoint};
use crate::math::Frame;
use crate::math::triangle::point_between;
use crate::radiometry::Rgb;
use crate::radiometry::measure::pdf_w_from_pdf_a;
use crate::sampling::warp;

/// An emissive triangle.
#[derive(Clone, Debug)]
pub struct AreaLight {
    panel: Panel,
    emission: Emission,
}

/// The triangle of an area light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Panel {
    pub(super) corners: [Vec3; 3],
    pub(super) ng: Vec3,
    pub(super) area: f32,
    /// Its index in the scene.
    pub(super) triangle: u32,
    pub(super) is_double_sided: bool,
}

/// An emissive triangle, wherever it comes from.
#[derive(Clone, Copy, Debug)]
pub struct Emitter<'a> {
    pub(super) panel: Panel,
    pub(super) emission: &'a Emission,
}

impl AreaLight {
    /// A light from a triangle of non-zero area, with its index in the scene.
    #[must_use]
    pub fn new(
        triangle: u32,
        corners: [Vec3; 3],
        emission: Emission,
        is_double_sided: bool,
    ) -> Self {
        Self {
            panel: Panel::new(corners, triangle, is_double_sided),
            emission,
        }
    }

    /// Index of the triangle in the scene.
    #[inline]
    #[must_use]
    pub fn triangle(&self) -> u32 {
        self.panel.triangle
    }

    /// The triangle and what it emits.
    #[inline]
    #[must_use]
    pub fn emitter(&self) -> Emitter<'_> {
        Emitter {
            panel: self.panel,
            emission: &self.emission,
        }
    }
}

impl<'a> Emitter<'a> {
    /// Area, m².
    #[must_use]
    pub fn area(&self) -> f32 {
        self.panel.area
    }

    /// Its corners, world space.
    #[must_use]
    pub fn corners(&self) -> [Vec3; 3] {
        self.panel.corners
    }

    /// True if it emits from both sides.
    #[must_use]
    pub fn is_double_sided(&self) -> bool {
        self.panel.is_double_sided
    }

    /// What it emits.
    #[must_use]
    pub fn emission(&self) -> &'a Emission {
        self.emission
    }

    /// Power, W per channel; where emission varies, an estimate without colour.
    pub(super) fn power(&self) -> Rgb {
        let sides = if self.panel.is_double_sided { 2.0 } else { 1.0 };
        self.mean_radiance() * (PI * self.panel.area * sides)
    }

    pub(super) fn bounds(&self) -> LightBounds {
        let [a, b, c] = self.panel.corners;
        let axis = self.panel.ng.normalize_or(Vec3::Z);
        let intensity = self.mean_radiance().mean() * self.panel.area;
        LightBounds {
            min: a.min(b).min(c),
            max: a.max(b).max(c),
            axis,
            theta_o: 0.0,
            theta_e: FRAC_PI_2,
            is_two_sided: self.panel.is_double_sided,
            intensity,
            vector: axis * intensity,
        }
    }

    fn mean_radiance(&self) -> Rgb {
        match self.emission {
            Emission::Uniform(radiance) => *radiance,
            Emission::Varying(varying, patch) => Rgb::splat(varying.mean(*patch)),
        }
    }

    /// What it sends from barycentric coordinates (of the second and third corner) towards `wo`,
    /// unit, world: its radiance, as much of
    /// it as there is.
    #[inline]
    #[must_use]
    pub fn sent(&self, barycentrics: [f32; 2], wo: Vec3) -> Rgb {
        if !self.panel.shines(wo) {
            return Rgb::BLACK;
        }
        match self.emission {
            Emission::Uniform(radiance) => *radiance,
            Emission::Varying(varying, patch) => {
                varying.radiance(*patch, barycentrics) * varying.opacity(*patch, barycentrics)
            }
        }
    }

    /// Density of a position on the triangle, 1/m², the choice of the light not included.
    #[inline]
    #[must_use]
    pub fn pdf_a(&self, barycentrics: [f32; 2]) -> f32 {
        match self.emission {
            Emission::Uniform(_) => 1.0 / self.panel.area,
            Emission::Varying(varying, patch) => {
                varying.density(*patch, barycentrics) / self.panel.area
            }
        }
    }

    /// Density with which a ray is started along `direction`, 1/sr.
    #[inline]
    #[must_use]
    pub fn pdf_w_start(&self, direction: Vec3) -> f32 {
        self.panel.pdf_w_start(direction)
    }

    /// The triangle and its radiance, where that is the same all over.
    #[inline]
    pub(super) fn as_uniform(&self) -> Option<(Panel, Rgb)> {
        match self.emission {
            Emission::Uniform(radiance) => Some((self.panel, *radiance)),
            Emission::Varying(..) => None,
        }
    }

    /// Aims from x at a point that is chosen by `part` and `u`, numbers in [0, 1).
    #[inline(always)]
    pub(super) fn aim(&self, x: Vec3, part: f32, u: [f32; 2]) -> Option<Aim> {
        match self.emission {
            Emission::Uniform(radiance) => self.panel.aim(x, u, *radiance),
            Emission::Varying(varying, patch) => self.aim_varying(x, (varying, *patch), part, u),
        }
    }

    #[inline(never)]
    fn aim_varying(
        &self,
        x: Vec3,
        (varying, patch): (&VaryingEmission, u32),
        part: f32,
        u: [f32; 2],
    ) -> Option<Aim> {
        let b = varying.sample(patch, part, u)?;
        let opacity = varying.opacity(patch, b);
        let sent = || varying.radiance(patch, b) * opacity;
        let aim = self.panel.aim_at(x, b, self.pdf_a(b), sent)?;
        Some(Aim { opacity, ..aim })
    }

    /// Starts a ray from a point that is chosen by `part` and `u`, in a direction that is by
    /// `u_direction`.
    pub(super) fn start(&self, part: f32, u: [f32; 2], u_direction: [f32; 2]) -> Option<Start> {
        let (b, opacity) = match self.emission {
            Emission::Uniform(_) => (warp::triangle(u), 1.0),
            Emission::Varying(varying, patch) => {
                let b = varying.sample(*patch, part, u)?;
                (b, varying.opacity(*patch, b))
            }
        };
        let sent = |direction| self.sent(b, direction);
        let start = self.panel.start_at(b, self.pdf_a(b), u_direction, sent)?;
        Some(Start {
            on_triangle: Some((self.panel.triangle, b)),
            opacity,
            ..start
        })
    }
}

impl Panel {
    pub(super) fn new(corners: [Vec3; 3], triangle: u32, is_double_sided: bool) -> Self {
        let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        Self {
            corners,
            ng: cross.normalize_or_zero(),
            area: 0.5 * cross.length(),
            triangle,
            is_double_sided,
        }
    }

    #[inline(always)]
    fn at(&self, b: [f32; 2]) -> Vec3 {
        point_between(&self.corners, b)
    }

    /// True if it shines towards `wo`.
    #[inline(always)]
    fn shines(&self, wo: Vec3) -> bool {
        self.is_double_sided || self.ng.dot(wo) > 0.0
    }

    #[inline(always)]
    fn pdf_w_start(&self, direction: Vec3) -> f32 {
        let cos = self.ng.dot(direction);
        if self.is_double_sided {
            0.5 * warp::cosine_hemisphere_pdf_w(cos.abs())
        } else {
            warp::cosine_hemisphere_pdf_w(cos)
        }
    }

    /// Radiance towards `wo` of a triangle that has this one where it shines.
    #[inline(always)]
    pub(super) fn radiance(&self, wo: Vec3, radiance: Rgb) -> Rgb {
        if self.shines(wo) {
            radiance
        } else {
            Rgb::BLACK
        }
    }

    /// Starts a ray from the point that `u` in [0, 1)² chooses, in the direction that
    /// `u_direction` does, the triangle being of one radiance.
    #[inline(always)]
    pub(super) fn start(&self, u: [f32; 2], u_direction: [f32; 2], radiance: Rgb) -> Option<Start> {
        let barycentrics = warp::triangle(u);
        self.start_at(barycentrics, 1.0 / self.area, u_direction, |direction| {
            self.radiance(direction, radiance)
        })
    }

    #[inline(always)]
    fn start_at(
        &self,
        barycentrics: [f32; 2],
        pdf_a: f32,
        mut u_direction: [f32; 2],
        radiance: impl FnOnce(Vec3) -> Rgb,
    ) -> Option<Start> {
        let mut side = 1.0;
        if self.is_double_sided {
            u_direction[0] *= 2.0;
            if u_direction[0] >= 1.0 {
                u_direction[0] -= 1.0;
                side = -1.0;
            }
        }
        let local = warp::cosine_hemisphere(u_direction);
        let direction = Frame::from_z(self.ng * side).world_from_local(local);
        let value = radiance(direction);
        let pdf_w = self.pdf_w_start(direction);
        (!value.is_black() && pdf_w > 0.0).then(|| Start {
            position: self.at(barycentrics),
            triangle: self.triangle,
            ng: self.ng,
            direction,
            value,
            cos: self.ng.dot(direction).abs(),
            densities: StartDensities { pdf_a, pdf_w },
            spread: Spread::Point { pdf_w },
            light: 0,
            on_triangle: None,
            opacity: 1.0,
            is_delta_position: false,
            is_delta_direction: false,
        })
    }

    /// Aims at the point that `u` in [0, 1)² chooses, the triangle being of one radiance.
    #[inline(always)]
    pub(crate) fn aim(&self, x: Vec3, u: [f32; 2], radiance: Rgb) -> Option<Aim> {
        self.aim_at(x, warp::triangle(u), 1.0 / self.area, || radiance)
    }

    /// Aims at a point of it from x; what it emits there is asked for only if it shines that way.
    #[inline(always)]
    fn aim_at(
        &self,
        x: Vec3,
        barycentrics: [f32; 2],
        pdf_a: f32,
        radiance: impl FnOnce() -> Rgb,
    ) -> Option<Aim> {
        let position = self.at(barycentrics);
        let to_light = position - x;
        let distance_squared = to_light.length_squared();
        let distance = distance_squared.sqrt();
        // The root and the division do not wait for each other.
        let wi = to_light * (distance * (1.0 / distance_squared));
        let cos = self.ng.dot(wi).abs();
        if cos < 1e-6 || !distance_squared.is_normal() || !self.shines(-wi) {
            return None;
        }
        let value = radiance();
        if value.is_black() {
            return None;
        }
        let pdf_w_start = self.pdf_w_start(-wi);
        Some(Aim {
            wi,
            distance,
            value,
            pdf_w: pdf_w_from_pdf_a(pdf_a, cos, distance_squared),
            is_delta: false,
            cos_at_endpoint: cos,
            surface: Some(SurfacePoint {
                position,
                triangle: self.triangle,
                ng: self.ng,
            }),
            start: StartDensities {
                pdf_a,
                pdf_w: pdf_w_start,
            },
            spread: Spread::Point { pdf_w: pdf_w_start },
            start_over_aim: 1.0,
            opacity: 1.0,
            light: u32::MAX,
        })
    }
}
