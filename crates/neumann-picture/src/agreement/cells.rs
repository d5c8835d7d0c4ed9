//! A picture cut into cells: all of it, its quarters, their quarters, and so on.

/// The finest cells are so many each way.
const MOST: usize = 16;
/// Pixels along the edge of a cell, at least.
const SMALLEST: usize = 8;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Columns from, to.
    pub x: [usize; 2],
    /// Rows from, to.
    pub y: [usize; 2],
}

impl Cell {
    /// Number of pixels.
    #[must_use]
    pub fn n_pixels(&self) -> usize {
        (self.x[1] - self.x[0]) * (self.y[1] - self.y[0])
    }
}

/// The cells of a picture, the whole first, level by level, each row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells {
    width: usize,
    height: usize,
    n_levels: u32,
}

impl Cells {
    /// Those of a picture of this size.
    #[must_use]
    pub fn new(width: usize, height: usize) -> Self {
        let is_fine = |level: &u32| {
            let n = 1 << level;
            n <= MOST && (*level == 0 || width.min(height) / n >= SMALLEST)
        };
        let n_levels = (0..).take_while(is_fine).count() as u32;
        Self {
            width,
            height,
            n_levels,
        }
    }

    /// Size of the picture.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Number of cells, of all levels.
    #[must_use]
    pub fn len(&self) -> usize {
        first(self.n_levels)
    }

    /// Never: the whole picture is a cell.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// A cell by its number.
    #[must_use]
    pub fn cell(&self, number: usize) -> Cell {
        let level = (0..self.n_levels)
            .rev()
            .find(|level| first(*level) <= number)
            .unwrap_or(0);
        let (n, place) = (1 << level, number - first(level));
        let (column, row) = (place % n, place / n);
        let edges = |i: usize, length: usize| [i * length / n, (i + 1) * length / n];
        Cell {
            x: edges(column, self.width),
            y: edges(row, self.height),
        }
    }

    /// The numbers of all cells around a pixel, the smallest first.
    pub fn around(&self, x: usize, y: usize) -> impl Iterator<Item = usize> {
        let this = *self;
        (0..this.n_levels).rev().map(move |level| {
            let n = 1 << level;
            first(level) + this.place(y, this.height, n) * n + this.place(x, this.width, n)
        })
    }

    /// The number of the cell that a cell is a quarter of; `None` for the whole picture.
    pub(super) fn parent(&self, number: usize) -> Option<usize> {
        let cell = self.cell(number);
        let mut around = self.around(cell.x[0], cell.y[0]);
        around.find(|cell| *cell == number)?;
        around.next()
    }

    /// Which of `n` parts of a length a pixel is in.
    fn place(&self, i: usize, length: usize, n: usize) -> usize {
        // The last part that begins no later.
        ((i + 1) * n - 1) / length
    }

    /// Sums over all cells of what each pixel has; pixels row by row.
    pub(super) fn sums(&self, values: impl Fn(usize) -> [f32; 3]) -> Vec<[f64; 3]> {
        let mut sums = vec![[0.0; 3]; self.len()];
        let finest = self.n_levels - 1;
        let n = 1 << finest;
        let columns: Vec<usize> = (0..self.width)
            .map(|x| self.place(x, self.width, n))
            .collect();
        for y in 0..self.height {
            let row = first(finest) + self.place(y, self.height, n) * n;
            for (x, column) in columns.iter().enumerate() {
                add(
                    &mut sums[row + column],
                    values(y * self.width + x).map(f64::from),
                );
            }
        }
        for level in (1..self.n_levels).rev() {
            let n = 1 << level;
            for place in 0..n * n {
                let parent = first(level - 1) + place / n / 2 * (n / 2) + place % n / 2;
                let value = sums[first(level) + place];
                add(&mut sums[parent], value);
            }
        }
        sums
    }
}

/// Number of the first cell of a level.
fn first(level: u32) -> usize {
    (4usize.pow(level) - 1) / 3
}

fn add(sum: &mut [f64; 3], value: [f64; 3]) {
    for (sum, value) in sum.iter_mut().zip(value) {
        *sum += value;
    }
}

#[cfg(test)]
mod tests {
    use super::Cells;

    #[test]
    fn cells_cover_every_pixel_once_at_each_level() {
        for (width, height, n_levels) in [(128, 200, 5), (50, 37, 3), (1, 1, 1), (1280, 17, 2)] {
            let cells = Cells::new(width, height);
            assert_eq!(
                cells.len(),
                (4usize.pow(n_levels) - 1) / 3,
                "{width}x{height}"
            );
            let mut n_pixels = vec![0; cells.len()];
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                for number in cells.around(x, y) {
                    let cell = cells.cell(number);
                    assert!((cell.x[0]..cell.x[1]).contains(&x), "{x},{y}: {cell:?}");
                    assert!((cell.y[0]..cell.y[1]).contains(&y), "{x},{y}: {cell:?}");
                    n_pixels[number] += 1;
                }
            }
            assert_eq!(cells.parent(0), None);
            for number in 1..cells.len() {
                let [inner, outer] = [number, cells.parent(number).unwrap()].map(|n| cells.cell(n));
                assert!(inner.x[0] >= outer.x[0] && inner.x[1] <= outer.x[1]);
                assert!(inner.y[0] >= outer.y[0] && inner.y[1] <= outer.y[1]);
                assert!(inner.n_pixels() < outer.n_pixels());
            }
            let sums = cells.sums(|pixel| [1.0, pixel as f32, 0.0]);
            for (number, n) in n_pixels.into_iter().enumerate() {
                let cell = cells.cell(number);
                assert_eq!(cell.n_pixels(), n);
                let pixels = (cell.y[0]..cell.y[1])
                    .flat_map(|y| (cell.x[0]..cell.x[1]).map(move |x| y * width + x));
                assert_eq!(sums[number], [n as f64, pixels.sum::<usize>() as f64, 0.0]);
            }
        }
    }
}
