//! An emissive triangle.
//!
//! It emits from its front, or from both sides. Where a texture varies over it,
//! it is cut into a grid of smaller triangles that are drawn by their power.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::LightSample;
use super::bounds::LightBounds;
use crate::endpoint::{Aim, Spread, Start, StartDensities, SurfacePoint};
use crate::material::Texture;
use crate::math::Frame;
use crate::math::triangle::point_between;
use crate::radiometry::Rgb;
use crate::radiometry::measure::pdf_w_from_pdf_a;
use crate::sampling::discrete::AliasTable;
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

/// Radiance over the triangle.
#[derive(Clone, Debug)]
pub enum Emission {
    /// The same everywhere.
    Uniform(Rgb),
    /// Multiplied by a texture.
    Textured(Arc<TexturedEmission>),
}

/// A texture over a triangle, with the grid that it is sampled by.
#[derive(Clone, Debug)]
pub struct TexturedEmission {
    factor: Rgb,
    texture: Texture,
    uvs: [Vec2; 3],
    /// Rows of the grid; it has n² cells.
    n: usize,
    cells: AliasTable,
    mean: Rgb,
}

/// Cells along an edge at most.
const MAX_CELLS: usize = 32;

impl TexturedEmission {
    /// A texture over a triangle with the given texture coordinates; `None` if it is black there.
    #[must_use]
    pub fn new(factor: Rgb, texture: &Texture, uvs: [Vec2; 3]) -> Option<Self> {
        let extent = (uvs[1] - uvs[0])
            .length()
            .max((uvs[2] - uvs[0]).length())
            .max((uvs[2] - uvs[1]).length());
        let n_texels = extent * texture.texels_per_uv();
        let n = if n_texels.is_finite() {
            (n_texels.ceil() as usize).clamp(1, MAX_CELLS)
        } else {
            1
        };
        let mut weights = vec![0f64; 2 * n * n];
        let mut mean = Rgb::BLACK;
        let at = |b: [f32; 2]| {
            let uv = uvs[0] * (1.0 - b[0] - b[1]) + uvs[1] * b[0] + uvs[2] * b[1];
            let t = texture.at(uv);
            Rgb::new(t.x, t.y, t.z) * factor
        };
        for (cell, weight) in weights.iter_mut().enumerate() {
            let Some(corners) = cell_corners(cell, n) else {
                continue;
            };
            let sum = GAUSS
                .iter()
                .map(|b| at(inside(corners, *b)))
                .fold(Rgb::BLACK, |s, c| s + c);
            let cell_mean = sum / GAUSS.len() as f32;
            mean += cell_mean / (n * n) as f32;
            *weight = f64::from(cell_mean.mean());
        }
        // Texels between the points looked at must not have density zero.
        let floor = 0.01 * weights.iter().sum::<f64>() / (n * n) as f64;
        for (cell, weight) in weights.iter_mut().enumerate() {
            if cell_corners(cell, n).is_some() {
                *weight = weight.max(floor);
            }
        }
        Some(Self {
            factor,
            texture: texture.clone(),
            uvs,
            n,
            cells: AliasTable::new(&weights)?,
            mean,
        })
    }

    fn radiance(&self, b: [f32; 2]) -> Rgb {
        let uv = self.uvs[0] * (1.0 - b[0] - b[1]) + self.uvs[1] * b[0] + self.uvs[2] * b[1];
        let t = self.texture.at(uv);
        Rgb::new(t.x, t.y, t.z) * self.factor
    }
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
        let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        Self {
            panel: Panel {
                corners,
                ng: cross.normalize_or_zero(),
                area: 0.5 * cross.length(),
                triangle,
                is_double_sided,
            },
            emission,
        }
    }

    /// Index of the triangle in the scene.
    #[inline]
    #[must_use]
    pub fn triangle(&self) -> u32 {
        self.panel.triangle
    }

    /// Area, m².
    #[must_use]
    pub fn area(&self) -> f32 {
        self.panel.area
    }

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
        match &self.emission {
            Emission::Uniform(radiance) => *radiance,
            Emission::Textured(t) => t.mean,
        }
    }

    /// Radiance at barycentric coordinates (of the second and third corner) towards `wo`, unit, world.
    #[inline]
    #[must_use]
    pub fn radiance(&self, barycentrics: [f32; 2], wo: Vec3) -> Rgb {
        if !self.panel.shines(wo) {
            return Rgb::BLACK;
        }
        match &self.emission {
            Emission::Uniform(radiance) => *radiance,
            Emission::Textured(t) => t.radiance(barycentrics),
        }
    }

    /// Density of a position on the triangle, 1/m², the choice of the light not included.
    #[inline]
    #[must_use]
    pub fn pdf_a(&self, barycentrics: [f32; 2]) -> f32 {
        match &self.emission {
            Emission::Uniform(_) => 1.0 / self.panel.area,
            Emission::Textured(t) => {
                t.cells.pmf(cell_of(barycentrics, t.n)) * (t.n * t.n) as f32 / self.panel.area
            }
        }
    }

    /// Density with which `start` sends a ray along `direction`, 1/sr.
    #[inline]
    #[must_use]
    pub fn pdf_w_start(&self, direction: Vec3) -> f32 {
        self.panel.pdf_w_start(direction)
    }

    /// The triangle and its radiance, where that is the same all over.
    #[inline]
    pub(crate) fn as_uniform(&self) -> Option<(Panel, Rgb)> {
        match &self.emission {
            Emission::Uniform(radiance) => Some((self.panel, *radiance)),
            Emission::Textured(_) => None,
        }
    }

    #[inline(always)]
    pub(super) fn aim(&self, x: Vec3, u: &LightSample) -> Option<Aim> {
        match &self.emission {
            Emission::Uniform(radiance) => self.panel.aim(x, u.point, *radiance),
            Emission::Textured(t) => {
                let (barycentrics, pdf_a) = self.sample_position(u);
                self.panel
                    .aim_at(x, barycentrics, pdf_a, || t.radiance(barycentrics))
            }
        }
    }

    pub(super) fn start(&self, u: &LightSample) -> Option<Start> {
        let (barycentrics, pdf_a) = self.sample_position(u);
        let radiance = |direction| self.radiance(barycentrics, direction);
        let start = self
            .panel
            .start_at(barycentrics, pdf_a, u.direction, radiance)?;
        Some(Start {
            on_triangle: Some((self.panel.triangle, barycentrics)),
            ..start
        })
    }

    #[inline]
    fn sample_position(&self, u: &LightSample) -> ([f32; 2], f32) {
        match &self.emission {
            Emission::Uniform(_) => (warp::triangle(u.point), 1.0 / self.panel.area),
            Emission::Textured(t) => {
                let (cell, pmf) = t.cells.sample(u.choice[1]);
                let corners = cell_corners(cell, t.n).unwrap_or([[0.0; 2]; 3]);
                let barycentrics = inside(corners, warp::triangle(u.point));
                (barycentrics, pmf * (t.n * t.n) as f32 / self.panel.area)
            }
        }
    }
}

impl Panel {
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

    /// Starts a ray from the point that `u` in [0, 1)² chooses, in the direction that `u_direction` does, the triangle being of one
    /// radiance.
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
        })
    }
}

/// Where the emission of a cell is looked at: a symmetric rule of six points.
const GAUSS: [[f32; 2]; 6] = [
    [0.445_948_5, 0.445_948_5],
    [0.108_103, 0.445_948_5],
    [0.445_948_5, 0.108_103],
    [0.091_576_2, 0.091_576_2],
    [0.816_847_6, 0.091_576_2],
    [0.091_576_2, 0.816_847_6],
];

/// Barycentric corners of a cell: number `2 (row n + column)`, plus 1 for one that points down;
/// `None` for numbers that lie outside of the triangle.
fn cell_corners(cell: usize, n: usize) -> Option<[[f32; 2]; 3]> {
    let (is_down, column, row) = (cell % 2 == 1, cell / 2 % n, cell / 2 / n);
    let limit = if is_down { n - 1 } else { n };
    if column + row >= limit {
        return None;
    }
    let at = |c: usize, r: usize| [c as f32 / n as f32, r as f32 / n as f32];
    Some(if is_down {
        [
            at(column + 1, row + 1),
            at(column, row + 1),
            at(column + 1, row),
        ]
    } else {
        [at(column, row), at(column + 1, row), at(column, row + 1)]
    })
}

fn cell_of(b: [f32; 2], n: usize) -> usize {
    let scaled = b.map(|x| (x * n as f32).clamp(0.0, n as f32 - 1e-3));
    let mut column = (scaled[0] as usize).min(n - 1);
    let mut row = (scaled[1] as usize).min(n - 1);
    let rest = scaled[0] - column as f32 + scaled[1] - row as f32;
    // Rounding can push a point of the long edge over it.
    while column + row > n - 1 {
        if column > 0 {
            column -= 1;
        } else {
            row -= 1;
        }
    }
    let is_down = rest > 1.0 && column + row + 1 < n;
    2 * (row * n + column) + usize::from(is_down)
}

fn inside(corners: [[f32; 2]; 3], b: [f32; 2]) -> [f32; 2] {
    let w = 1.0 - b[0] - b[1];
    [0, 1].map(|i| corners[0][i] * w + corners[1][i] * b[0] + corners[2][i] * b[1])
}

#[cfg(test)]
mod tests {
    use super::{cell_corners, cell_of, inside};

    #[test]
    fn cells_tile_the_triangle() {
        for n in [1, 2, 5] {
            let cells: Vec<usize> = (0..2 * n * n)
                .filter(|c| cell_corners(*c, n).is_some())
                .collect();
            assert_eq!(cells.len(), n * n);
            for cell in cells {
                let corners = cell_corners(cell, n).unwrap();
                for b in super::GAUSS {
                    assert_eq!(cell_of(inside(corners, b), n), cell);
                }
            }
        }
    }
}
