//! A lobe in space, drawn by hand: triangles with depth, seen from far away.

use glam::{Vec2, Vec3};
use neumann_core::radiometry::Rgb;
use neumann_core::render::lobe::Viewed;

use super::{Plot, largest};
use crate::png_file::Pixels8;
use crate::tone::srgb_from_linear;

/// From where a lobe is looked at, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// About the normal.
    pub yaw: f32,
    /// Over the surface.
    pub pitch: f32,
}

impl Default for Turn {
    fn default() -> Self {
        Self {
            yaw: 0.45,
            pitch: 0.35,
        }
    }
}

/// In which colours, sRGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidStyle {
    /// Behind all.
    pub ground: [u8; 3],
    /// The surface and its normal.
    pub line: [u8; 3],
    /// The direction to the viewer.
    pub viewer: [u8; 3],
    /// Mirror-like lobes.
    pub arrow: [u8; 3],
}

/// Samples of a pixel in either direction.
const FINE: usize = 2;
/// Part of the light that comes from everywhere.
const AMBIENT: f32 = 0.3;
/// Segments of the edge of the surface.
const N_SEGMENTS: usize = 64;

/// Draws the lobe of a view.
#[must_use]
pub fn draw(
    view: &Viewed,
    plot: Plot,
    turn: Turn,
    (width, height): (usize, usize),
    style: &SolidStyle,
) -> Pixels8 {
    let mut raster = Raster::new(width * FINE, height * FINE, style.ground);
    let sight = Sight::new(turn, view, raster.size());
    mesh(view, plot, &sight, &mut raster);
    let unit = 0.75 * FINE as f32;
    let corner = |i: usize| {
        let (sin, cos) = (std::f32::consts::TAU * i as f32 / N_SEGMENTS as f32).sin_cos();
        Vec3::new(cos, sin, 0.0)
    };
    for i in 0..N_SEGMENTS {
        raster.line([corner(i), corner(i + 1)], &sight, unit, style.line);
    }
    let side = 1f32.copysign(view.wo.z);
    let lowest = if view.drawn.is_transmissive {
        -1.0
    } else {
        0.0
    };
    let ends = [lowest, 1.0].map(|z| Vec3::Z * (z * side));
    raster.line(ends, &sight, unit, style.line);
    raster.line([Vec3::ZERO, view.wo], &sight, 1.4 * unit, style.viewer);
    for lobe in &view.drawn.deltas {
        let tip = lobe.wi * plot.radius.of(lobe.share.luminance());
        raster.line([Vec3::ZERO, tip], &sight, 2.0 * unit, style.arrow);
    }
    raster.shrunk(width, height)
}

/// From local space to the picture.
struct Sight {
    right: Vec3,
    above: Vec3,
    /// Towards the eye.
    back: Vec3,
    middle: Vec2,
    scale: f32,
}

impl Sight {
    fn new(turn: Turn, view: &Viewed, (width, height): (usize, usize)) -> Self {
        let (sin, cos) = turn.yaw.sin_cos();
        let (up, along) = turn.pitch.sin_cos();
        let back = Vec3::new(-sin * along, -cos * along, up);
        let right = Vec3::new(cos, -sin, 0.0);
        let above = back.cross(right);
        let (w, h) = (width as f32, height as f32);
        // On one side of the surface alone there is less to be seen.
        let (scale, down) = if view.drawn.is_transmissive {
            (0.48 * w.min(h), 0.5)
        } else {
            let (over, under) = (1.04, up.abs().max(0.04) + 0.04);
            let scale = (0.48 * w).min(0.96 * h / (over + under));
            let down = 0.5 + 0.5 * (over - under) * scale / h;
            (scale, if view.wo.z > 0.0 { down } else { 1.0 - down })
        };
        Self {
            right,
            above,
            back,
            middle: Vec2::new(0.5 * w, down * h),
            scale,
        }
    }

    /// Place in the picture, and nearness.
    fn place(&self, at: Vec3) -> Vec3 {
        let x = self.middle.x + self.scale * at.dot(self.right);
        let y = self.middle.y - self.scale * at.dot(self.above);
        Vec3::new(x, y, at.dot(self.back))
    }
}

struct Corner {
    place: Vec3,
    colour: Vec3,
}

/// The solid's triangles, shaded.
fn mesh(view: &Viewed, plot: Plot, sight: &Sight, raster: &mut Raster) {
    let solid = &view.solid;
    let most = largest(view, plot.plotted);
    if most <= 0.0 {
        return;
    }
    let n_columns = solid.n_columns;
    let n_rows = solid.directions.len() / n_columns;
    let all = solid.directions.iter().zip(&solid.f);
    let values: Vec<Rgb> = all.map(|(wi, f)| plot.plotted.of(*f, wi.z)).collect();
    let radius = |value: &Rgb| plot.radius.of(value.max_channel() / most);
    let positions: Vec<Vec3> = solid
        .directions
        .iter()
        .zip(&values)
        .map(|(wi, value)| *wi * radius(value))
        .collect();
    // The last column is the first again, and all of a pole are one.
    let same = |i: usize| {
        let (row, column) = (i / n_columns, i % n_columns);
        let is_pole = row == 0 || row + 1 == n_rows;
        let is_first = is_pole || column + 1 == n_columns;
        row * n_columns + if is_first { 0 } else { column }
    };
    let mut triangles = Vec::new();
    for row in 0..n_rows.saturating_sub(1) {
        for column in 0..n_columns - 1 {
            let a = row * n_columns + column;
            let [b, c, d] = [a + 1, a + n_columns, a + n_columns + 1];
            let is_crossing = solid.directions[a].z * solid.directions[c].z < 0.0;
            if !is_crossing {
                triangles.extend([[a, c, b], [b, c, d]]);
            }
        }
    }
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for corners in &triangles {
        let [a, b, c] = corners.map(|i| positions[i]);
        let normal = (b - a).cross(c - a);
        for i in corners {
            normals[same(*i)] += normal;
        }
    }
    let light = (sight.back + 0.5 * sight.above - 0.5 * sight.right).normalize();
    let corner = |i: usize| {
        let normal = normals[same(i)].normalize_or_zero();
        let shade = AMBIENT + (1.0 - AMBIENT) * normal.dot(light).abs();
        let value = values[i];
        let largest = value.max_channel();
        let hue = if largest > 0.0 {
            value / largest
        } else {
            Rgb::WHITE
        };
        let linear = hue.to_array().map(|c| c * shade);
        Corner {
            place: sight.place(positions[i]),
            colour: Vec3::from(linear),
        }
    };
    let corners: Vec<Corner> = (0..positions.len()).map(corner).collect();
    for triangle in triangles {
        raster.triangle(triangle.map(|i| &corners[i]));
    }
}

/// Pixels with their nearness.
struct Raster {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
    near: Vec<f32>,
}

impl Raster {
    fn new(width: usize, height: usize, ground: [u8; 3]) -> Self {
        Self {
            width,
            height,
            pixels: vec![ground; width * height],
            near: vec![f32::NEG_INFINITY; width * height],
        }
    }

    fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Columns or rows that a range covers.
    fn span(from: f32, to: f32, n: usize) -> std::ops::Range<usize> {
        let first = from.floor().max(0.0) as usize;
        first..(to.ceil().max(0.0) as usize).min(n)
    }

    fn triangle(&mut self, corners: [&Corner; 3]) {
        let [a, b, c] = corners.map(|corner| corner.place.truncate());
        let area = (b - a).perp_dot(c - a);
        if area.abs() < 1e-9 {
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        for y in Self::span(low.y, high.y, self.height) {
            for x in Self::span(low.x, high.x, self.width) {
                let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let u = (b - at).perp_dot(c - at) / area;
                let v = (c - at).perp_dot(a - at) / area;
                let weights = [u, v, 1.0 - u - v];
                if weights.iter().any(|w| *w < -1e-4) {
                    continue;
                }
                let mix = |of: &dyn Fn(&Corner) -> Vec3| {
                    let all = weights.iter().zip(corners);
                    all.fold(Vec3::ZERO, |sum, (w, corner)| sum + *w * of(corner))
                };
                let near = mix(&|corner| corner.place).z;
                let i = y * self.width + x;
                if near > self.near[i] {
                    self.near[i] = near;
                    let linear = mix(&|corner| corner.colour).to_array();
                    self.pixels[i] = linear.map(|c| {
                        let code = srgb_from_linear(c.clamp(0.0, 1.0));
                        (255.0 * code + 0.5) as u8
                    });
                }
            }
        }
    }

    /// A line that what is nearer covers.
    fn line(&mut self, ends: [Vec3; 2], sight: &Sight, half: f32, colour: [u8; 3]) {
        let [from, to] = ends.map(|end| sight.place(end));
        let (start, along) = (from.truncate(), (to - from).truncate());
        let squared = along.length_squared().max(1e-9);
        let (low, high) = (from.min(to) - half, from.max(to) + half);
        for y in Self::span(low.y, high.y, self.height) {
            for x in Self::span(low.x, high.x, self.width) {
                let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - start;
                let share = (at.dot(along) / squared).clamp(0.0, 1.0);
                let near = from.z + share * (to.z - from.z);
                let i = y * self.width + x;
                // What lies in the surface of the lobe is drawn.
                let is_free = near + 0.01 > self.near[i];
                if is_free && at.distance(share * along) <= half {
                    self.pixels[i] = colour;
                }
            }
        }
    }

    fn shrunk(&self, width: usize, height: usize) -> Pixels8 {
        let pixel = |i: usize| {
            let (x, y) = (i % width * FINE, i / width * FINE);
            let mut sum = [0usize; 3];
            for j in 0..FINE * FINE {
                let from = (y + j / FINE) * self.width + x + j % FINE;
                for (sum, code) in sum.iter_mut().zip(self.pixels[from]) {
                    *sum += usize::from(code);
                }
            }
            sum.map(|sum| (sum / (FINE * FINE)) as u8)
        };
        Pixels8 {
            width,
            height,
            pixels: (0..width * height).map(pixel).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{SolidStyle, Turn, draw};
    use crate::lobe::Plot;
    use crate::lobe::tests::grey;

    const STYLE: SolidStyle = SolidStyle {
        ground: [0; 3],
        line: [0, 0, 255],
        viewer: [255, 0, 0],
        arrow: [0, 255, 0],
    };

    /// Seen from the side a grey surface is half a disk of grey; seen from above, a whole one.
    #[test]
    fn a_half_ball_is_drawn_as_one() {
        let lobes = grey();
        let share = |pitch: f32| {
            let turn = Turn { yaw: 0.0, pitch };
            let picture = draw(&lobes.views[0], Plot::default(), turn, (120, 120), &STYLE);
            let grey = |p: &&[u8; 3]| p[0] == p[1] && p[1] == p[2] && p[0] > 40;
            let lit = picture.pixels.iter().filter(grey).count() as f32;
            let radius = 0.48 * 120.0;
            lit / (std::f32::consts::PI * radius * radius)
        };
        let (beside, above) = (share(0.0), share(1.57));
        assert!((0.44..0.53).contains(&beside), "{beside}");
        assert!((0.9..1.02).contains(&above), "{above}");
    }
}
