//! What an emissive triangle emits, and where on it points are drawn.
//!
//! A surface that is there in part emits through that part: a camera meets it with its opacity and
//! then sees all of its
//! radiance, so whoever aims at it or starts from it, and meets it always, takes radiance times
//! opacity.
//!
//! Where a texture makes a difference, points are drawn by its texels ([`TexelMap`]): the emission
//! texture, or, without
//! one, that of the base colour, of which alpha counts. The density is the weight of the cell over
//! the sum of weights over the triangle.

use std::sync::Arc;

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::cells::CellTriangle;
use super::texels::TexelMap;
use crate::material::{Coverage, Texture};
use crate::radiometry::Rgb;
use crate::sampling::warp;

/// Radiance over a triangle.
#[derive(Clone, Debug)]
pub enum Emission {
    /// The same everywhere, of a surface that is all there.
    Uniform(Rgb),
    /// One of the triangles of a surface over which it varies.
    Varying(Arc<VaryingEmission>, u32),
}

/// What a material emits that is not the same all over, or not all there.
#[derive(Clone, Debug)]
pub struct EmissiveMaterial {
    /// Radiance, W m⁻² sr⁻¹.
    pub radiance: Rgb,
    /// Multiplies it.
    pub texture: Option<Texture>,
    /// How much of the surface is there; `None` for all.
    pub coverage: Option<Coverage>,
    /// What points are drawn by: the map of the emission texture, or, without one, of the alpha
    /// texture.
    pub map: Option<Arc<TexelMap>>,
}

/// What the corners of an emissive triangle carry.
#[derive(Clone, Copy, Debug)]
pub struct EmissiveCorners {
    /// Coordinates for the emission texture.
    pub uvs: [Vec2; 3],
    /// Coordinates for the alpha texture.
    pub alpha_uvs: [Vec2; 3],
    /// Alpha of the vertices.
    pub alphas: [f32; 3],
}

/// Emission that varies over triangles.
#[derive(Clone, Debug)]
pub struct VaryingEmission {
    material: EmissiveMaterial,
    patches: Vec<Patch>,
    /// Of the triangles that are drawn row by row, one after the other: shares of the rows up to
    /// each.
    row_shares: Vec<f32>,
}

/// One of its triangles.
#[derive(Clone, Copy, Debug)]
struct Patch {
    corners: EmissiveCorners,
    /// Mean of the channels' radiance over it: an estimate, but for a triangle of whole cells.
    mean: f32,
    draw: Draw,
}

/// How points are drawn.
#[derive(Clone, Copy, Debug)]
enum Draw {
    /// All alike.
    Uniform,
    /// By weight, row by row.
    Rows {
        /// The first row of cells.
        first: i32,
        /// Where its shares begin.
        start: u32,
        n: u32,
        /// Weight of the triangle.
        weight: f32,
    },
    /// By weight within a period of the texture, which is chosen by how much the triangle has of
    /// it. What falls beside the triangle is lost.
    Periods,
}

/// Cells that a triangle may be long and high, together, to be drawn row by row.
pub const MAX_EXTENT: f64 = (1u32 << 17) as f64;
/// Cells that all triangles of a scene may be long and high, together: so many for each, and so
/// many more for all.
const EXTENT_OF_EACH: f64 = 16.0;
const EXTENT_OF_ALL: f64 = (1u32 << 23) as f64;
/// Beyond so many cells from the origin, single precision knows no cells any more.
const FARTHEST: f64 = (1u32 << 21) as f64;
/// The share of a surface that is taken to be there at least, where only some points are looked at.
const LEAST_SHARE: f32 = 0.02;

impl EmissiveMaterial {
    /// The texture that points are drawn by.
    fn drawn_by(&self) -> Option<&Texture> {
        let alpha = || self.coverage.as_ref()?.texture.as_ref();
        self.texture.as_ref().or_else(alpha)
    }

    /// How long and high a triangle is, in cells of that texture.
    #[must_use]
    pub fn extent(&self, corners: &EmissiveCorners) -> f64 {
        self.cells(corners).map_or(0.0, |cells| {
            let (min, max) = cells.bounds();
            let size = max - min;
            size.x + size.y + 2.0
        })
    }

    /// The triangle among the cells of that texture; `None` where they do not matter, or cannot be
    /// told apart.
    fn cells(&self, corners: &EmissiveCorners) -> Option<CellTriangle> {
        self.map.as_ref()?;
        let uvs = match self.texture {
            Some(_) => corners.uvs,
            None => corners.alpha_uvs,
        };
        let texture = self.drawn_by()?;
        let places: [DVec2; 3] = uvs.map(|uv| texture.place(uv).as_dvec2());
        let is_known = |p: &DVec2| p.is_finite() && p.abs().max_element() < FARTHEST;
        places
            .iter()
            .all(is_known)
            .then(|| CellTriangle::new(places))
    }

    fn radiance(&self, corners: &EmissiveCorners, b: [f32; 2]) -> Rgb {
        match &self.texture {
            None => self.radiance,
            Some(texture) => {
                let t = texture.at(interpolate(corners.uvs, b));
                Rgb::new(t.x, t.y, t.z) * self.radiance
            }
        }
    }

    fn opacity(&self, corners: &EmissiveCorners, b: [f32; 2]) -> f32 {
        self.coverage.as_ref().map_or(1.0, |coverage| {
            let texture = coverage.texture.as_ref();
            let alpha = texture.map_or(1.0, |t| t.at(interpolate(corners.alpha_uvs, b)).w);
            coverage.opacity(alpha, interpolate(corners.alphas, b))
        })
    }

    /// A triangle, with the shares of its rows added to `row_shares`; `None` if it is dark.
    fn patch(
        &self,
        corners: &EmissiveCorners,
        max_extent: f64,
        row_shares: &mut Vec<f32>,
    ) -> Option<Patch> {
        if let Some(coverage) = &self.coverage {
            let most = corners.alphas.into_iter().fold(0.0, f32::max);
            if coverage.opacity(1.0, most) <= 0.0 {
                return None;
            }
        }
        let radiance = self.radiance.mean();
        let opacity = || mean_of_points(|b| self.opacity(corners, b)).max(LEAST_SHARE);
        let patch = |draw, mean| {
            Some(Patch {
                corners: *corners,
                mean,
                draw,
            })
        };
        let seen = |b| self.radiance(corners, b).mean() * self.opacity(corners, b);
        let by_points = || mean_of_points(seen).max(LEAST_SHARE * LEAST_SHARE * radiance);
        let Some(map) = &self.map else {
            return patch(Draw::Uniform, by_points());
        };
        if map.is_dark() {
            return None;
        }
        let Some(cells) = self.cells(corners) else {
            return patch(Draw::Uniform, by_points());
        };
        // What a weight says of the mean; alpha of the texture is in it, where it is that which
        // counts.
        let mean_of = |weight_of_cell: f64| {
            let value = (weight_of_cell / map.weight_of_one()) as f32 * radiance;
            match self.texture {
                Some(_) => value * opacity(),
                None => {
                    value
                        * mean_of_points(|b| interpolate(corners.alphas, b)).clamp(LEAST_SHARE, 1.0)
                }
            }
        };
        let (min, max) = cells.bounds();
        let size = max - min;
        let extent = size.x + size.y + 2.0;
        if extent > max_extent.min(MAX_EXTENT) {
            let Some([columns, rows]) = map.period() else {
                return patch(Draw::Uniform, by_points());
            };
            return patch(
                Draw::Periods,
                mean_of(map.of_period() / (columns * rows) as f64),
            );
        }
        // So flat a triangle is not known well enough to be cut into pieces.
        let rounding =
            8.0 * f64::from(f32::EPSILON) * min.abs().max(max.abs()).max_element().max(1.0);
        if cells.area() <= rounding * extent {
            let (low, high) = (min - rounding, max + rounding);
            let [x, end] = [low.x.floor() as i64, high.x.floor() as i64 + 1];
            let mut rows = low.y.floor() as i64..high.y.floor() as i64 + 1;
            let is_lit = rows.any(|y| map.row(y).between(x, end) > 0);
            return if is_lit {
                patch(Draw::Uniform, by_points())
            } else {
                None
            };
        }
        let [first, end] = cells.rows();
        let start = row_shares.len();
        let mut weight = 0.0;
        row_shares.extend((first..end).map(|y| {
            weight += cells.weight_of_row(map, y);
            weight as f32
        }));
        if weight <= 0.0 {
            row_shares.truncate(start);
            return None;
        }
        for share in &mut row_shares[start..] {
            *share /= weight as f32;
        }
        let draw = Draw::Rows {
            first: first as i32,
            start: start as u32,
            n: (end - first) as u32,
            weight: weight as f32,
        };
        patch(draw, mean_of(weight / cells.area()))
    }
}

/// How long and high triangles may be to be drawn row by row, where all of a scene are so many, and
/// so long and high together.
#[must_use]
pub fn max_extent(n_triangles: usize, of_all: f64) -> f64 {
    let n = n_triangles as f64;
    let limit = EXTENT_OF_EACH * n + EXTENT_OF_ALL;
    if of_all <= limit {
        MAX_EXTENT
    } else {
        limit / n
    }
}

impl VaryingEmission {
    /// The emission of triangles, with the number of each for [`Emission::Varying`], or `None` for
    /// one that is dark.
    #[must_use]
    pub fn new(
        material: EmissiveMaterial,
        triangles: &[EmissiveCorners],
        max_extent: f64,
    ) -> (Self, Vec<Option<u32>>) {
        let parts: Vec<_> = triangles
            .par_chunks(1024)
            .map(|triangles| {
                let mut row_shares = Vec::new();
                let patches: Vec<Option<Patch>> = triangles
                    .iter()
                    .map(|corners| material.patch(corners, max_extent, &mut row_shares))
                    .collect();
                (patches, row_shares)
            })
            .collect();
        let mut emission = Self {
            material,
            patches: Vec::new(),
            row_shares: Vec::with_capacity(parts.iter().map(|(_, shares)| shares.len()).sum()),
        };
        let mut numbers = Vec::with_capacity(triangles.len());
        for (patches, shares) in parts {
            let before = emission.row_shares.len() as u32;
            emission.row_shares.extend(shares);
            for patch in patches {
                numbers.push(patch.map(|mut patch| {
                    if let Draw::Rows { start, .. } = &mut patch.draw {
                        *start += before;
                    }
                    emission.patches.push(patch);
                    emission.patches.len() as u32 - 1
                }));
            }
        }
        (emission, numbers)
    }

    /// An estimate of the mean radiance of a triangle, mean of the channels, as it is seen through
    /// its coverage.
    pub(super) fn mean(&self, patch: u32) -> f32 {
        self.patches[patch as usize].mean
    }

    /// Radiance at barycentric coordinates of a triangle, to whoever meets it.
    pub(super) fn radiance(&self, patch: u32, b: [f32; 2]) -> Rgb {
        self.material
            .radiance(&self.patches[patch as usize].corners, b)
    }

    /// How much of the surface is there.
    pub(super) fn opacity(&self, patch: u32, b: [f32; 2]) -> f32 {
        self.material
            .opacity(&self.patches[patch as usize].corners, b)
    }

    /// Density of barycentric coordinates, times the area of the triangle.
    pub(super) fn density(&self, patch: u32, b: [f32; 2]) -> f32 {
        let Patch { corners, draw, .. } = &self.patches[patch as usize];
        if let Draw::Uniform = draw {
            return 1.0;
        }
        let (Some(map), Some(cells), Some(texture)) = (
            &self.material.map,
            self.material.cells(corners),
            self.material.drawn_by(),
        ) else {
            return 1.0;
        };
        let uvs = match self.material.texture {
            Some(_) => corners.uvs,
            None => corners.alpha_uvs,
        };
        let cell = Texture::cell(texture.place(interpolate(uvs, b)));
        let over_mean = match draw {
            Draw::Rows { weight, .. } => cells.area() / f64::from(*weight),
            _ => area_in_period(map, &cells, cell) / map.of_period(),
        };
        (map.weight(cell) * over_mean) as f32
    }

    /// Barycentric coordinates drawn by three numbers in [0, 1); `None` where they miss.
    pub(super) fn sample(&self, patch: u32, part: f32, u: [f32; 2]) -> Option<[f32; 2]> {
        let Patch { corners, draw, .. } = &self.patches[patch as usize];
        let (map, cells) = match draw {
            Draw::Uniform => return Some(warp::triangle(u)),
            _ => (self.material.map.as_ref()?, self.material.cells(corners)?),
        };
        let wide = u.map(f64::from);
        let Draw::Rows {
            first, start, n, ..
        } = *draw
        else {
            return self.sample_period(map, &cells, part, u);
        };
        let shares = &self.row_shares[start as usize..][..n as usize];
        let row = shares
            .partition_point(|share| *share <= part)
            .min(n as usize - 1);
        let point = cells.point_in_row(map, i64::from(first) + row as i64, wide)?;
        cells.barycentrics(point)
    }

    /// A point of the texture, in the period that a point of the triangle is in.
    fn sample_period(
        &self,
        map: &TexelMap,
        cells: &CellTriangle,
        part: f32,
        u: [f32; 2],
    ) -> Option<[f32; 2]> {
        let size = map.period()?;
        let chosen = cells.at(warp::triangle(u));
        let period = [
            (chosen.x.floor() as i64).div_euclid(size[0]),
            (chosen.y.floor() as i64).div_euclid(size[1]),
        ];
        let (y, rest) = map.row_of_period(part);
        let row = map.row(y);
        let target = rest * row.between(0, size[0]) as f64;
        let x = row.find(0, size[0], target);
        // The first digits have chosen the period, and are of no more use within a cell.
        let within = u.map(|u| f64::from((u * 4096.0).fract()));
        let point = DVec2::new(
            (period[0] * size[0] + x) as f64 + within[0],
            (period[1] * size[1] + y) as f64 + within[1],
        );
        cells.barycentrics(point)
    }
}

/// How much of a triangle is in the period of a cell, in cells.
fn area_in_period(map: &TexelMap, cells: &CellTriangle, cell: [i64; 2]) -> f64 {
    let Some(size) = map.period() else { return 0.0 };
    let start = [0, 1].map(|i| (cell[i].div_euclid(size[i]) * size[i]) as f64);
    let min = DVec2::from_array(start);
    let max = min + DVec2::new(size[0] as f64, size[1] as f64);
    cells.area_within(min, max)
}

fn interpolate<T>(corners: [T; 3], b: [f32; 2]) -> T
where
    T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    let [v0, v1, v2] = corners;
    v0 * (1.0 - b[0] - b[1]) + v1 * b[0] + v2 * b[1]
}

/// The mean of something over a triangle, from six of its points.
fn mean_of_points(of: impl Fn([f32; 2]) -> f32) -> f32 {
    GAUSS.iter().map(|b| of(*b)).sum::<f32>() / GAUSS.len() as f32
}

/// Where a triangle is looked at: a symmetric rule of six points.
const GAUSS: [[f32; 2]; 6] = [
    [0.445_948_5, 0.445_948_5],
    [0.108_103, 0.445_948_5],
    [0.445_948_5, 0.108_103],
    [0.091_576_2, 0.091_576_2],
    [0.816_847_6, 0.091_576_2],
    [0.091_576_2, 0.816_847_6],
];
