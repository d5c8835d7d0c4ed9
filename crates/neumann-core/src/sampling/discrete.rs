//! Discrete choices: one of two, an alias table, and piecewise-constant densities on a grid.

/// The largest number below 1.
const BELOW_ONE: f32 = 1.0 - 0.5 * f32::EPSILON;

/// One of two, true with probability `p`, by a number in [0, 1); and what is left of that number:
/// uniform in [0, 1) again, whichever of the two it is.
///
/// What both go on to draw by it is spread as evenly, both together, as the number was. A number of
/// its own for the choice would take points out of an even pattern at random.
#[inline]
#[must_use]
pub fn one_of_two(u: f32, p: f32) -> (bool, f32) {
    let other = 1.0 - p;
    let is_first = u >= other;
    let rest = if is_first { (1.0 - u) / p } else { u / other };
    (is_first, rest.min(BELOW_ONE))
}

/// Draws an index in constant time with probability proportional to its weight
/// (Walker 1974, built after Vose 1991).
#[derive(Clone, Debug, Default)]
pub struct AliasTable {
    bins: Vec<Bin>,
    pmf: Vec<f32>,
}

#[derive(Clone, Copy, Debug)]
struct Bin {
    /// Below this, the bin's own index; above, the alias.
    threshold: f32,
    alias: u32,
}

impl AliasTable {
    /// A table for weights that are finite and not negative; `None` if they add up to nothing.
    #[must_use]
    pub fn new(weights: &[f64]) -> Option<Self> {
        let sum: f64 = weights.iter().sum();
        if !sum.is_finite() || sum <= 0.0 {
            return None;
        }
        let n = weights.len();
        let mut scaled: Vec<f64> = weights.iter().map(|w| w / sum * n as f64).collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) =
            (0..n).partition(|i| scaled[*i] < 1.0);
        let mut bins = vec![
            Bin {
                threshold: 1.0,
                alias: 0
            };
            n
        ];
        while let (Some(s), Some(l)) = (small.pop(), large.last().copied()) {
            bins[s] = Bin {
                threshold: scaled[s] as f32,
                alias: l as u32,
            };
            scaled[l] -= 1.0 - scaled[s];
            if scaled[l] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        Some(Self {
            bins,
            pmf: weights.iter().map(|w| (w / sum) as f32).collect(),
        })
    }

    /// The index that `u` in [0, 1) falls on, and its probability.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: f32) -> (usize, f32) {
        let scaled = u * self.bins.len() as f32;
        let i = (scaled as u32 as usize).min(self.bins.len() - 1);
        let bin = self.bins[i];
        let index = if scaled - (i as f32) < bin.threshold {
            i
        } else {
            bin.alias as usize
        };
        (index, self.pmf[index])
    }

    /// The index that `u` in [0, 1) falls on, and what is left of `u`: a number in [0, 1) again.
    #[inline]
    #[must_use]
    pub fn sample_and_rest(&self, u: f32) -> (usize, f32) {
        let scaled = u * self.bins.len() as f32;
        let i = (scaled as u32 as usize).min(self.bins.len() - 1);
        let Bin { threshold, alias } = self.bins[i];
        let within = scaled - i as f32;
        let (index, rest) = if within < threshold {
            (i, within / threshold)
        } else {
            (alias as usize, (within - threshold) / (1.0 - threshold))
        };
        (index, rest.min(BELOW_ONE))
    }

    /// Probability of an index.
    #[inline]
    #[must_use]
    pub fn pmf(&self, index: usize) -> f32 {
        self.pmf[index]
    }
}

/// A piecewise-constant density on [0, 1)², one constant for each cell of a grid.
///
/// Inverts the marginal distribution of rows, then that of the columns of a
/// row, so that well-distributed points stay so (\[PBR4\] A.4.2 and A.5.4).
#[derive(Clone, Debug)]
pub struct Grid2 {
    n_columns: usize,
    n_rows: usize,
    /// `row_cdf[row]`: probability of the rows before; one more at the end.
    row_cdf: Vec<f32>,
    /// `column_cdf[row * (n_columns + 1) + column]`, the same within a row.
    column_cdf: Vec<f32>,
    /// `density[row * n_columns + column]`, of mean 1.
    density: Vec<f32>,
}

impl Grid2 {
    /// A density proportional to `weights[row * n_columns + column]`, which are finite and not
    /// negative; `None` if they add up to nothing.
    #[must_use]
    pub fn new(n_columns: usize, n_rows: usize, weights: &[f64]) -> Option<Self> {
        Self::from_rows(n_columns, n_rows, |row, of_row| {
            of_row.copy_from_slice(&weights[row * n_columns..(row + 1) * n_columns]);
        })
    }

    /// The same from `fill`, which writes the weights of one row after the other, so that they
    /// need not all be kept.
    #[must_use]
    pub fn from_rows(
        n_columns: usize,
        n_rows: usize,
        mut fill: impl FnMut(usize, &mut [f64]),
    ) -> Option<Self> {
        let mut weights = vec![0f64; n_columns];
        let mut row_sums = Vec::with_capacity(n_rows);
        let mut column_cdf = Vec::with_capacity(n_rows * (n_columns + 1));
        let mut density = Vec::with_capacity(n_rows * n_columns);
        for row in 0..n_rows {
            fill(row, &mut weights);
            let row_sum: f64 = weights.iter().sum();
            let mut left = 0f64;
            column_cdf.push(0.0);
            for w in &weights {
                left += w;
                column_cdf.push(if row_sum > 0.0 { left / row_sum } else { 1.0 } as f32);
                density.push(if row_sum > 0.0 { w / row_sum } else { 0.0 } as f32);
            }
            row_sums.push(row_sum);
        }
        let sum: f64 = row_sums.iter().sum();
        if !sum.is_finite() || sum <= 0.0 {
            return None;
        }
        let mut row_cdf = Vec::with_capacity(n_rows + 1);
        row_cdf.push(0.0);
        let mut below = 0f64;
        let mean = sum / (n_columns * n_rows) as f64;
        for (row_sum, of_row) in row_sums.iter().zip(density.chunks_mut(n_columns)) {
            below += row_sum;
            row_cdf.push((below / sum) as f32);
            for d in of_row {
                *d = (f64::from(*d) * (row_sum / mean)) as f32;
            }
        }
        Some(Self {
            n_columns,
            n_rows,
            row_cdf,
            column_cdf,
            density,
        })
    }

    /// A point (column direction, row direction) in [0, 1)² and its density.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: [f32; 2]) -> ([f32; 2], f32) {
        let (row, v) = invert(&self.row_cdf, u[1]);
        let columns =
            &self.column_cdf[row * (self.n_columns + 1)..(row + 1) * (self.n_columns + 1)];
        let (column, s) = invert(columns, u[0]);
        let point = [
            (column as f32 + s) / self.n_columns as f32,
            (row as f32 + v) / self.n_rows as f32,
        ];
        (point, self.density[row * self.n_columns + column])
    }

    /// Density at a point.
    #[inline]
    #[must_use]
    pub fn density(&self, point: [f32; 2]) -> f32 {
        let column = ((point[0] * self.n_columns as f32) as usize).min(self.n_columns - 1);
        let row = ((point[1] * self.n_rows as f32) as usize).min(self.n_rows - 1);
        self.density[row * self.n_columns + column]
    }
}

/// The step of a cumulative distribution that `u` falls in, and where in it, in [0, 1).
fn invert(cdf: &[f32], u: f32) -> (usize, f32) {
    let step = cdf.partition_point(|c| *c <= u).clamp(1, cdf.len() - 1) - 1;
    let (low, high) = (cdf[step], cdf[step + 1]);
    let inside = if high > low {
        (u - low) / (high - low)
    } else {
        0.5
    };
    (step, inside.clamp(0.0, 1.0 - f32::EPSILON))
}

#[cfg(test)]
mod tests {
    use super::{AliasTable, Grid2, one_of_two};

    #[test]
    fn one_of_two_is_exact_and_leaves_even_numbers() {
        for p in [0.0, 0.05, 0.3, 0.5, 0.999, 1.0] {
            let n = 100_000;
            let mut rests = [const { Vec::new() }; 2];
            for i in 0..n {
                let (is_first, rest) = one_of_two((i as f32 + 0.5) / n as f32, p);
                assert!((0.0..1.0).contains(&rest), "{p}: {rest}");
                rests[usize::from(is_first)].push(rest);
            }
            let expected = n as f32 * p;
            assert!((rests[1].len() as f32 - expected).abs() <= 1.0, "{p}");
            for rests in &mut rests {
                rests.sort_by(f32::total_cmp);
                let m = rests.len() as f32;
                for (i, rest) in rests.iter().enumerate() {
                    assert!((rest - (i as f32 + 0.5) / m).abs() < 1.5 / m + 1e-5, "{p}");
                }
            }
        }
    }

    #[test]
    fn alias_table_draws_its_weights() {
        let weights = [1.0, 0.0, 3.0, 0.5, 5.5];
        let table = AliasTable::new(&weights).unwrap();
        let n = 1_000_000;
        let mut counts = [0u32; 5];
        for i in 0..n {
            counts[table.sample((i as f32 + 0.5) / n as f32).0] += 1;
        }
        for (count, weight) in counts.iter().zip(weights) {
            assert!((f64::from(*count) / f64::from(n) - weight / 10.0).abs() < 1e-5);
        }
        assert!(AliasTable::new(&[0.0, 0.0]).is_none());
    }

    #[test]
    fn grid_draws_where_its_density_says() {
        let weights = [0.0, 2.0, 1.0, 4.0, 0.0, 5.0];
        let grid = Grid2::new(3, 2, &weights).unwrap();
        let n = 300;
        let mut counts = [0f64; 6];
        for i in 0..n * n {
            let u = [(i % n) as f32 + 0.5, (i / n) as f32 + 0.5].map(|x| x / n as f32);
            let (p, density) = grid.sample(u);
            let cell = (p[1] * 2.0) as usize * 3 + (p[0] * 3.0) as usize;
            counts[cell] += 1.0;
            assert!((density - weights[cell] as f32 / 2.0).abs() < 1e-5);
            assert!((grid.density(p) - density).abs() < 1e-5);
        }
        for (count, weight) in counts.iter().zip(weights) {
            assert!((count / f64::from(n * n) - weight / 12.0).abs() < 5e-3);
        }
    }
}
