//! What is kept of independent renders: the means of every cell, and how each pixel spreads.

use neumann_core::film::{Film, View};
use neumann_core::radiometry::Rgb;

use super::Cells;
use super::estimate::Estimate;

/// Renders of one picture by one method that differ in their seed alone.
///
/// Iterations of one seed are not independent, since their points fill each other's gaps. So the
/// spread of such renders, and not that of iterations, says how certain their mean is.
#[derive(Clone, Debug)]
pub struct Batches {
    cells: Cells,
    n_layers: usize,
    n: usize,
    /// Of each view and each cell, a mean for each batch.
    means: Vec<Vec<Vec<[f64; 3]>>>,
    /// Of each view and each pixel, luminance.
    pixels: Vec<Vec<Spread>>,
}

/// A mean and the sum of squared deviations from it, by Welford's recurrence.
#[derive(Clone, Copy, Debug, Default)]
struct Spread {
    mean: f32,
    deviations: f32,
}

impl Batches {
    /// None yet, of films of this shape.
    #[must_use]
    pub fn new(width: usize, height: usize, n_layers: usize) -> Self {
        let cells = Cells::new(width, height);
        let n_views = n_layers + 2;
        Self {
            cells,
            n_layers,
            n: 0,
            means: vec![vec![Vec::new(); cells.len()]; n_views],
            pixels: vec![vec![Spread::default(); width * height]; n_views],
        }
    }

    /// Takes in a render.
    ///
    /// # Panics
    /// If the film has another shape.
    pub fn take(&mut self, film: &Film) {
        let shape = (film.width(), film.height());
        assert_eq!((shape, film.n_layers()), (self.cells.size(), self.n_layers));
        self.n += 1;
        let mut values = vec![Rgb::BLACK; film.n_pixels()];
        for (number, view) in self.views().into_iter().enumerate() {
            film.compose(view, &mut values);
            let sums = self.cells.sums(|pixel| values[pixel].to_array());
            for (cell, sum) in sums.into_iter().enumerate() {
                let n = self.cells.cell(cell).n_pixels() as f64;
                self.means[number][cell].push(sum.map(|s| s / n));
            }
            for (spread, value) in self.pixels[number].iter_mut().zip(&values) {
                spread.take(value.luminance(), self.n);
            }
        }
    }

    /// Number of renders.
    #[must_use]
    pub fn n(&self) -> usize {
        self.n
    }

    /// The cells.
    #[must_use]
    pub fn cells(&self) -> Cells {
        self.cells
    }

    /// What is kept apart: the terms, the tail, and L.
    #[must_use]
    pub fn views(&self) -> Vec<View> {
        let terms = (0..self.n_layers).map(View::Term);
        terms.chain([View::Tail, View::Total]).collect()
    }

    /// The mean of a cell in one channel, by number of the view.
    #[must_use]
    pub fn estimate(&self, view: usize, cell: usize, channel: usize) -> Estimate {
        let means = &self.means[view][cell];
        let values: Vec<f64> = means.iter().map(|mean| mean[channel]).collect();
        Estimate::of(&values)
    }

    /// Renders that found any light in a cell.
    pub(super) fn n_lit(&self, view: usize, cell: usize) -> usize {
        let is_lit = |mean: &&[f64; 3]| mean.iter().any(|channel| *channel > 0.0);
        self.means[view][cell].iter().filter(is_lit).count()
    }

    /// The luminance of a pixel.
    pub(super) fn pixel(&self, view: usize, pixel: usize) -> Estimate {
        let Spread { mean, deviations } = self.pixels[view][pixel];
        let n = self.n as f64;
        Estimate {
            mean: f64::from(mean),
            standard_error: (f64::from(deviations) / (n - 1.0) / n).sqrt(),
            n: self.n,
        }
    }
}

impl Spread {
    fn take(&mut self, value: f32, n: usize) {
        let apart = value - self.mean;
        self.mean += apart / n as f32;
        self.deviations += apart * (value - self.mean);
    }
}
