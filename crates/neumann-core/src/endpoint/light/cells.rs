//! A triangle over the cells of a texture: how much each row of cells weighs within it, and points
//! drawn by weight.
//!
//! The weights of a row are summed cell by cell where an edge of the triangle cuts cells, and at
//! once where it covers them
//! whole. Points are then drawn row by row and cell by cell, uniformly within what the triangle has
//! of a cell. Their
//! density is the weight of the cell over the sum, whichever way they were drawn.

use glam::DVec2;

use super::texels::{Row, TexelMap};

/// A triangle, in columns and rows of cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellTriangle {
    corners: [DVec2; 3],
    /// Twice its area, with the sign of its winding.
    twice_area: f64,
}

/// What a triangle has of a row of cells.
struct Span {
    polygon: Polygon,
    /// Columns that it touches, from the first to before the second.
    outer: [i64; 2],
    /// Columns that it covers whole, likewise.
    inner: [i64; 2],
}

/// A convex polygon; a triangle cut along four sides has seven corners at most.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [DVec2; 8],
    n: usize,
}

impl CellTriangle {
    pub(super) fn new(corners: [DVec2; 3]) -> Self {
        let [a, b, c] = corners;
        Self {
            corners,
            twice_area: (b - a).perp_dot(c - a),
        }
    }

    /// Area, in cells.
    pub(super) fn area(&self) -> f64 {
        0.5 * self.twice_area.abs()
    }

    /// Corners of its box.
    pub(super) fn bounds(&self) -> (DVec2, DVec2) {
        let [a, b, c] = self.corners;
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// Rows that it touches, from the first to before the second.
    pub(super) fn rows(&self) -> [i64; 2] {
        let (min, max) = self.bounds();
        [min.y.floor() as i64, max.y.ceil() as i64]
    }

    /// Weight of what it has of a row.
    pub(super) fn weight_of_row(&self, map: &TexelMap, y: i64) -> f64 {
        self.span(y).map_or(0.0, |span| span.weight(&map.row(y)))
    }

    /// A point of a row, drawn by weight, by two numbers in [0, 1); `None` where nothing has
    /// weight.
    pub(super) fn point_in_row(&self, map: &TexelMap, y: i64, u: [f64; 2]) -> Option<DVec2> {
        let span = self.span(y)?;
        let row = map.row(y);
        let mut target = u[0] * span.weight(&row);
        let [start, end] = span.inner;
        let whole = row.between(start, end) as f64;
        let mut last = None;
        // Cells that are cut on the left, those that are whole, and cells that are cut on the
        // right.
        for x in span.outer[0]..start {
            let part = span.part(&row, x);
            if part > 0.0 {
                if target < part {
                    return span.point_in_cell(x, [target / part, u[1]]);
                }
                target -= part;
                last = Some(x);
            }
        }
        if target < whole {
            let x = row.find(start, end, target);
            let (before, weight) = (row.between(start, x), row.between(x, x + 1));
            let s = (target - before as f64) / weight as f64;
            return Some(DVec2::new(x as f64 + s, y as f64 + u[1]));
        }
        target -= whole;
        for x in end..span.outer[1] {
            let part = span.part(&row, x);
            if part > 0.0 {
                if target < part {
                    return span.point_in_cell(x, [target / part, u[1]]);
                }
                target -= part;
                last = Some(x);
            }
        }
        // Rounding may lead past the end.
        span.point_in_cell(last?, u)
    }

    /// Area of what it has of a rectangle.
    pub(super) fn area_within(&self, min: DVec2, max: DVec2) -> f64 {
        let polygon = Polygon::triangle(self.corners);
        polygon
            .within(0, min.x, max.x)
            .within(1, min.y, max.y)
            .area()
    }

    /// The point with the given barycentric coordinates of the second and third corner.
    pub(super) fn at(&self, b: [f32; 2]) -> DVec2 {
        let [first, second, third] = self.corners;
        let [s, t] = b.map(f64::from);
        first + (second - first) * s + (third - first) * t
    }

    /// Barycentric coordinates of the second and third corner at a point; `None` outside.
    pub(super) fn barycentrics(&self, p: DVec2) -> Option<[f32; 2]> {
        let [a, b, c] = self.corners;
        let found = [(p - a).perp_dot(c - a), (b - a).perp_dot(p - a)].map(|x| x / self.twice_area);
        let [s, t] = found;
        (s >= -TOLERANCE && t >= -TOLERANCE && s + t <= 1.0 + TOLERANCE).then(|| {
            let s = s.clamp(0.0, 1.0);
            [s as f32, t.clamp(0.0, 1.0 - s) as f32]
        })
    }

    fn span(&self, y: i64) -> Option<Span> {
        let polygon = Polygon::triangle(self.corners).within(1, y as f64, (y + 1) as f64);
        let corners = polygon.corners();
        let (min, max) = corners.iter().fold((f64::MAX, f64::MIN), |(min, max), p| {
            (min.min(p.x), max.max(p.x))
        });
        if min > max {
            return None;
        }
        let outer = [min.floor() as i64, max.ceil() as i64];
        // A cell is whole where its four corners are inside of each edge:
        // `across · corner + offset >= 0`.
        let (mut low, mut high) = (outer[0] as f64, outer[1] as f64);
        for i in 0..3 {
            let (from, to) = (self.corners[i], self.corners[(i + 1) % 3]);
            let across = (to - from).perp() * self.twice_area.signum();
            let offset = -across.dot(from);
            let rest = across.y * y as f64 + across.y.min(0.0) + across.x.min(0.0) + offset;
            if across.x > 0.0 {
                low = low.max((-rest / across.x).ceil());
            } else if across.x < 0.0 {
                high = high.min((rest / -across.x).floor() + 1.0);
            } else if rest < 0.0 {
                high = low;
            }
        }
        let inner = if low < high {
            [low as i64, high as i64]
        } else {
            [outer[1]; 2]
        };
        Some(Span {
            polygon,
            outer,
            inner,
        })
    }
}

/// How far outside of a triangle rounding may put a point of it.
const TOLERANCE: f64 = 1e-9;

impl Span {
    fn weight(&self, row: &Row<'_>) -> f64 {
        if row.between(self.outer[0], self.outer[1]) == 0 {
            return 0.0;
        }
        let [start, end] = self.inner;
        let cut = (self.outer[0]..start).chain(end..self.outer[1]);
        cut.map(|x| self.part(row, x)).sum::<f64>() + row.between(start, end) as f64
    }

    /// Weight of what there is of a cell.
    fn part(&self, row: &Row<'_>, x: i64) -> f64 {
        match row.between(x, x + 1) {
            0 => 0.0,
            weight => weight as f64 * self.cell(x).area(),
        }
    }

    fn cell(&self, x: i64) -> Polygon {
        self.polygon.within(0, x as f64, (x + 1) as f64)
    }

    fn point_in_cell(&self, x: i64, u: [f64; 2]) -> Option<DVec2> {
        self.cell(x).point(u)
    }
}

impl Polygon {
    fn triangle([a, b, c]: [DVec2; 3]) -> Self {
        let mut corners = [DVec2::ZERO; 8];
        corners[..3].copy_from_slice(&[a, b, c]);
        Self { corners, n: 3 }
    }

    fn corners(&self) -> &[DVec2] {
        &self.corners[..self.n]
    }

    /// The part whose coordinate number `axis` is between two bounds.
    fn within(self, axis: usize, low: f64, high: f64) -> Self {
        self.cut(axis, low, 1.0).cut(axis, high, -1.0)
    }

    /// The part where `(coordinate - bound) * side` is not negative.
    fn cut(self, axis: usize, bound: f64, side: f64) -> Self {
        let height = |p: DVec2| (p[axis] - bound) * side;
        let mut part = Self {
            corners: [DVec2::ZERO; 8],
            n: 0,
        };
        let Some(mut from) = self.corners().last().copied() else {
            return part;
        };
        for &to in self.corners() {
            let (h, k) = (height(from), height(to));
            if (h < 0.0) != (k < 0.0) {
                let mut crossing = from.lerp(to, h / (h - k));
                crossing[axis] = bound;
                part.push(crossing);
            }
            if k >= 0.0 {
                part.push(to);
            }
            from = to;
        }
        part
    }

    fn push(&mut self, corner: DVec2) {
        // Rounding cannot make an eighth of a triangle's seven, but shall not be trusted with that.
        if let Some(free) = self.corners.get_mut(self.n) {
            *free = corner;
            self.n += 1;
        }
    }

    /// Twice the areas of the triangles between its first corner and each of its other sides.
    fn fan(&self) -> impl Iterator<Item = ([DVec2; 3], f64)> + '_ {
        let corners = self.corners();
        corners.windows(2).skip(1).map(move |side| {
            let [a, b, c] = [corners[0], side[0], side[1]];
            ([a, b, c], (b - a).perp_dot(c - a).abs())
        })
    }

    fn area(&self) -> f64 {
        0.5 * self.fan().map(|(_, twice_area)| twice_area).sum::<f64>()
    }

    /// A point of it, uniform, by two numbers in [0, 1).
    fn point(&self, u: [f64; 2]) -> Option<DVec2> {
        let mut target = u[0] * 2.0 * self.area();
        let mut found = None;
        for (corners, twice_area) in self.fan() {
            if twice_area > 0.0 {
                found = Some((corners, target / twice_area));
                if target < twice_area {
                    break;
                }
                target -= twice_area;
            }
        }
        let ([a, b, c], s) = found?;
        // Along the fan's side, then from the first corner on.
        let r = u[1].sqrt();
        Some(a + (b + (c - b) * s.min(1.0) - a) * r)
    }
}
