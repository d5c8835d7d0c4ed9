//! Where a texture shines: what points of emissive triangles are drawn by.
//!
//! A texture is read from the same texels all over a cell ([`Texture::place`]). A cell's weight is
//! the sum of what those
//! texels are worth: 0 where nothing can shine, and in proportion to the mean of the cell anywhere
//! else. Weights are whole
//! numbers, so that their sums are exact whatever lies beside them, and any run of cells in a row
//! is summed at once.

use glam::Vec4;
use rayon::prelude::*;

use crate::material::Texture;
use crate::memory::{self, Share};
use crate::scene::description::{Filter, Wrap};

/// The weights of all cells of a texture.
#[derive(Debug)]
pub struct TexelMap {
    columns: Axis,
    rows: Axis,
    /// `sums[row * (n_columns + 1) + column]`: the weights before that column, in one row.
    sums: Vec<u32>,
    /// Weight of a cell whose texels are all worth 1.
    weight_of_one: f64,
    is_dark: bool,
    /// `before[row]`: the weights of all rows before, in one period, and one more at the end; empty
    /// where the texture is not
    /// periodic.
    before: Vec<f64>,
    /// What the sums take of the process's allowance.
    _memory: Share,
}

/// Cells along one side of a texture.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// Texels.
    n: i64,
    wrap: Wrap,
    filter: Filter,
}

/// A row of cells.
#[derive(Clone, Copy)]
pub(super) struct Row<'a> {
    columns: Axis,
    sums: &'a [u32],
}

/// The most that one texel weighs.
const MAX_WEIGHT: u32 = 1 << 22;

impl TexelMap {
    /// The map of a texture whose texels are worth `value`, from 0 to 1; `None` if there is no
    /// memory for it.
    #[must_use]
    pub fn new(texture: &Texture, value: impl Fn(Vec4) -> f32 + Sync) -> Option<Self> {
        let [n_columns, n_rows] = texture.size();
        let [wrap_u, wrap_v] = texture.wraps();
        let filter = texture.filter();
        let axis = |n: usize, wrap| Axis {
            n: n as i64,
            wrap,
            filter,
        };
        let (columns, rows) = (axis(n_columns, wrap_u), axis(n_rows, wrap_v));
        let n_corners: u32 = match filter {
            Filter::Nearest => 1,
            Filter::Linear => 4,
        };
        let n_kept = columns.n_columns_kept();
        let levels = u32::MAX / (n_corners * u32::try_from(n_kept).ok()?);
        let levels = levels.clamp(1, MAX_WEIGHT) as f32;
        let stride = n_kept + 1;
        let n_sums = stride.checked_mul(rows.n_rows_kept())?;
        let memory = Share::of_process(memory::bytes_of::<u32>(n_sums)).ok()?;
        let mut sums = memory::filled(0u32, n_sums).ok()?;
        let texel = |x, y| {
            let value = value(texture.texel_at(x, y));
            (value.clamp(0.0, 1.0) * levels).ceil() as u32
        };
        sums.par_chunks_mut(stride)
            .enumerate()
            .for_each(|(i, row)| {
                let (x, y) = (columns.first_column(), rows.kept_row(i));
                let mut sum = 0;
                match filter {
                    Filter::Nearest => {
                        for (x, sum_after) in (x..).zip(&mut row[1..]) {
                            sum += texel(x, y);
                            *sum_after = sum;
                        }
                    }
                    Filter::Linear => {
                        let both = |x| texel(x, y) + texel(x, y + 1);
                        let mut left = both(x);
                        for (x, sum_after) in (x..).zip(&mut row[1..]) {
                            let right = both(x + 1);
                            sum += left + right;
                            left = right;
                            *sum_after = sum;
                        }
                    }
                }
            });
        let mut map = Self {
            columns,
            rows,
            sums,
            weight_of_one: f64::from(levels) * f64::from(n_corners),
            is_dark: false,
            before: Vec::new(),
            _memory: memory,
        };
        map.is_dark = map.sums.chunks(stride).all(|row| row.last() == Some(&0));
        if let (Some(_), Some(period)) = (columns.period(), rows.period()) {
            let mut sum = 0.0;
            map.before.push(sum);
            for y in 0..period {
                sum += f64::from(map.row(y).total());
                map.before.push(sum);
            }
        }
        Some(map)
    }

    /// True if nothing shines.
    #[must_use]
    pub fn is_dark(&self) -> bool {
        self.is_dark
    }

    /// Weight of a cell whose texels are all worth 1.
    pub(super) fn weight_of_one(&self) -> f64 {
        self.weight_of_one
    }

    /// A row of cells, which may be beyond the image.
    #[inline]
    pub(super) fn row(&self, y: i64) -> Row<'_> {
        let stride = self.columns.n_columns_kept() + 1;
        let start = self.rows.row_kept(y) * stride;
        Row {
            columns: self.columns,
            sums: &self.sums[start..start + stride],
        }
    }

    /// Weight of a cell.
    #[inline]
    pub(super) fn weight(&self, [x, y]: [i64; 2]) -> f64 {
        self.row(y).between(x, x + 1) as f64
    }

    /// Columns and rows after which everything comes again; `None` where an edge goes on for ever.
    pub(super) fn period(&self) -> Option<[i64; 2]> {
        Some([self.columns.period()?, self.rows.period()?])
    }

    /// Weight of one period.
    pub(super) fn of_period(&self) -> f64 {
        self.before.last().copied().unwrap_or(0.0)
    }

    /// The row of a period that `u` in [0, 1) falls on, in proportion to its weight, and where in
    /// it, in [0, 1).
    pub(super) fn row_of_period(&self, u: f32) -> (i64, f64) {
        let target = f64::from(u) * self.of_period();
        let y = self.before.partition_point(|before| *before <= target);
        let y = y.clamp(1, self.before.len() - 1) - 1;
        let (low, high) = (self.before[y], self.before[y + 1]);
        (y as i64, (target - low) / (high - low))
    }
}

impl Row<'_> {
    #[inline]
    fn total(&self) -> u32 {
        self.sums[self.sums.len() - 1]
    }

    /// Weights of the cells from `start` to before `end`, each of which may be beyond the image.
    #[inline]
    pub(super) fn between(&self, start: i64, end: i64) -> i64 {
        self.before(end) - self.before(start)
    }

    /// The first cell from `start` on, before `end`, with which the weights add to more than
    /// `target`.
    pub(super) fn find(&self, start: i64, end: i64, target: f64) -> i64 {
        let base = self.before(start);
        let (mut low, mut high) = (start, end - 1);
        while low < high {
            let middle = low + (high - low) / 2;
            if (self.before(middle + 1) - base) as f64 > target {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        low
    }

    /// Weights before a column, counted from some column.
    #[inline]
    fn before(&self, x: i64) -> i64 {
        let n = self.sums.len() - 1;
        let x = x - self.columns.first_column();
        if (0..=n as i64).contains(&x) {
            return i64::from(self.sums[x as usize]);
        }
        let total = i64::from(self.total());
        if self.columns.period().is_some() {
            let (turns, rest) = (x.div_euclid(n as i64), x.rem_euclid(n as i64));
            return turns * total + i64::from(self.sums[rest as usize]);
        }
        if x < 0 {
            x * i64::from(self.sums[1])
        } else {
            total + (x - n as i64) * i64::from(self.sums[n] - self.sums[n - 1])
        }
    }
}

impl Axis {
    /// Cells after which all comes again.
    fn period(&self) -> Option<i64> {
        match self.wrap {
            Wrap::Repeat => Some(self.n),
            Wrap::MirroredRepeat => Some(2 * self.n),
            Wrap::ClampToEdge => None,
        }
    }

    /// Columns are kept one after the other, a period of them or all that differ.
    fn n_columns_kept(&self) -> usize {
        self.period().unwrap_or(self.n - self.first_column()) as usize
    }

    /// The first column that is kept.
    #[inline]
    fn first_column(&self) -> i64 {
        match (self.wrap, self.filter) {
            // Half a texel at the edge, and whatever is beyond.
            (Wrap::ClampToEdge, Filter::Linear) => -1,
            _ => 0,
        }
    }

    /// Rows are kept once, however often they come again.
    fn n_rows_kept(&self) -> usize {
        match (self.wrap, self.filter) {
            (Wrap::Repeat, _) | (_, Filter::Nearest) => self.n as usize,
            (Wrap::MirroredRepeat | Wrap::ClampToEdge, Filter::Linear) => self.n as usize + 1,
        }
    }

    /// Number of the row that is kept as number `i`.
    fn kept_row(&self, i: usize) -> i64 {
        match (self.wrap, self.filter) {
            (Wrap::ClampToEdge, Filter::Linear) => i as i64 - 1,
            (Wrap::MirroredRepeat, Filter::Linear) if i as i64 == self.n => -1,
            _ => i as i64,
        }
    }

    /// As which number a row is kept.
    #[inline]
    fn row_kept(&self, y: i64) -> usize {
        let n = self.n;
        let kept = match (self.wrap, self.filter) {
            (Wrap::Repeat, _) => y.rem_euclid(n),
            (Wrap::ClampToEdge, Filter::Nearest) => y.clamp(0, n - 1),
            (Wrap::ClampToEdge, Filter::Linear) => (y + 1).clamp(0, n),
            (Wrap::MirroredRepeat, filter) => {
                let y = y.rem_euclid(2 * n);
                match filter {
                    _ if y < n => y,
                    Filter::Nearest => 2 * n - 1 - y,
                    Filter::Linear if y == 2 * n - 1 => n,
                    Filter::Linear => 2 * n - 2 - y,
                }
            }
        };
        kept as usize
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Mat3, Vec2, Vec4};

    use super::TexelMap;
    use crate::material::{ColorSpace, Texture};
    use crate::scene::description::{Filter, ImageDescription, TextureDescription, Wrap};

    const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];

    /// The weight of a cell follows the mean of the texture over it, wherever it is.
    #[test]
    fn weights_are_the_means_of_cells() {
        let texels = [0, 9, 90, 200, 0, 255].map(|c: u8| [c, c, c, 255]);
        let image = Arc::new(ImageDescription {
            width: 3,
            height: 2,
            texels: texels.into_iter().collect(),
            ..Default::default()
        });
        for filter in [Filter::Nearest, Filter::Linear] {
            for (wrap_u, wrap_v) in WRAPS.into_iter().flat_map(|u| WRAPS.map(|v| (u, v))) {
                let description = TextureDescription {
                    image: 0,
                    uv_set: 0,
                    image_from_mesh_uv: Mat3::IDENTITY,
                    wrap_u,
                    wrap_v,
                    filter,
                };
                let images = [Arc::clone(&image)];
                let texture = Texture::new(&description, &images, ColorSpace::Linear).unwrap();
                let map = TexelMap::new(&texture, |t: Vec4| t.x).unwrap();
                for y in -7..9 {
                    let mut before = 0.0;
                    for x in -7..9 {
                        // Halfway between texels the mean of four is read.
                        let place = Vec2::new(x as f32, y as f32) + 0.5;
                        let shift = if filter == Filter::Linear { 0.5 } else { 0.0 };
                        let uv = (place + shift) / Vec2::new(3.0, 2.0);
                        let expected = f64::from(texture.at(uv).x);
                        assert_eq!(Texture::cell(texture.place(uv)), [x, y]);
                        let found = map.weight([x, y]) / map.weight_of_one();
                        let what = format!("{filter:?} {wrap_u:?} {wrap_v:?} {x} {y}");
                        assert!(
                            (found - expected).abs() < 1e-5,
                            "{what}: {found} {expected}"
                        );
                        before += map.weight([x, y]);
                        assert_eq!(map.row(y).between(-7, x + 1) as f64, before, "{what}");
                    }
                }
                let row = map.row(1);
                let whole = row.between(-5, 6) as f64;
                for i in 0..100 {
                    let target = whole * f64::from(i) / 100.0;
                    let x = row.find(-5, 6, target);
                    assert!(row.between(-5, x) as f64 <= target);
                    assert!(row.between(-5, x + 1) as f64 > target);
                }
            }
        }
    }
}
