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
    /// Of each view and each cell, the means of its channels.
    means: Vec<Vec<CellSpread>>,
    /// Of each view and each pixel, luminance.
    pixels: Vec<Vec<Spread>>,
    /// Of each view, pixels that some batch found no light in.
    was_dark: Vec<Vec<bool>>,
}

/// A mean and the sum of squared deviations from it, by Welford's recurrence.
#[derive(Clone, Copy, Debug, Default)]
struct Spread {
    mean: f32,
    deviations: f32,
}

/// The same of the channels of a cell. However many batches there are, it takes no more room.
#[derive(Clone, Copy, Debug, Default)]
struct CellSpread {
    means: [f64; 3],
    deviations: [f64; 3],
    /// Batches that found any light.
    n_lit: usize,
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
            means: vec![vec![CellSpread::default(); cells.len()]; n_views],
            pixels: vec![vec![Spread::default(); width * height]; n_views],
            was_dark: vec![vec![false; width * height]; n_views],
        }
    }

    /// Takes in a render.
    ///
    /// # Panics
    /// If the film has another shape.
    pub fn take(&mut self, film: &Film) {
        let shape = (film.width(), film.height());
        assert_eq!((shape, film.n_layers()), (self.cells.size(), self.n_layers));
        self.take_values(|view, values| film.compose(view, values));
    }

    /// Takes in a picture of each view.
    pub fn take_values(&mut self, mut compose: impl FnMut(View, &mut [Rgb])) {
        self.n += 1;
        let (width, height) = self.cells.size();
        let mut values = vec![Rgb::BLACK; width * height];
        for (number, view) in self.views().into_iter().enumerate() {
            compose(view, &mut values);
            let sums = self.cells.sums(|pixel| values[pixel].to_array());
            for (cell, sum) in sums.into_iter().enumerate() {
                let n = self.cells.cell(cell).n_pixels() as f64;
                self.means[number][cell].take(sum.map(|s| s / n), self.n);
            }
            let pixels = self.pixels[number].iter_mut();
            let pixels = pixels.zip(&mut self.was_dark[number]).zip(&values);
            for ((spread, was_dark), value) in pixels {
                let luminance = value.luminance();
                spread.take(luminance, self.n);
                *was_dark |= luminance == 0.0;
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
        let CellSpread {
            means, deviations, ..
        } = &self.means[view][cell];
        Estimate::of_spread(means[channel], deviations[channel], self.n)
    }

    /// The luminance of a cell, by number of the view. The errors of the channels are taken to move
    /// together, which is the safe side.
    #[must_use]
    pub fn luminance(&self, view: usize, cell: usize) -> Estimate {
        let estimates = [0, 1, 2].map(|channel| self.estimate(view, cell, channel));
        let luminance = |values: [f64; 3]| {
            let [r, g, b] = values.map(|v| v as f32);
            f64::from(Rgb::new(r, g, b).luminance())
        };
        Estimate {
            mean: luminance(estimates.map(|e| e.mean)),
            standard_error: luminance(estimates.map(|e| e.standard_error)),
            n: self.n,
        }
    }

    /// Renders that found any light in a cell.
    pub(super) fn n_lit(&self, view: usize, cell: usize) -> usize {
        self.means[view][cell].n_lit
    }

    /// The luminance of a pixel, by number of the view.
    #[must_use]
    pub fn pixel(&self, view: usize, pixel: usize) -> Estimate {
        let Spread { mean, deviations } = self.pixels[view][pixel];
        Estimate::of_spread(f64::from(mean), f64::from(deviations), self.n)
    }

    /// True if every batch found light in a pixel, and false if none did; `None` in between.
    pub(super) fn is_lit(&self, view: usize, pixel: usize) -> Option<bool> {
        match (
            self.was_dark[view][pixel],
            self.pixels[view][pixel].mean > 0.0,
        ) {
            (true, true) => None,
            (was_dark, _) => Some(!was_dark),
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

impl CellSpread {
    fn take(&mut self, values: [f64; 3], n: usize) {
        for (channel, value) in values.into_iter().enumerate() {
            let apart = value - self.means[channel];
            self.means[channel] += apart / n as f64;
            self.deviations[channel] += apart * (value - self.means[channel]);
        }
        self.n_lit += usize::from(values.iter().any(|value| *value > 0.0));
    }
}
