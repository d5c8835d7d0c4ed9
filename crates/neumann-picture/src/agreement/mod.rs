//! Do two methods make the same picture, bounce by bounce?
//!
//! Each method renders independent [`Batches`]. In every cell of the picture, for every term and
//! channel, Welch's test says how far the two means are apart, in standard deviations: the score.
//! Of many scores some are large by chance. So a score counts only beyond a limit that any of all
//! `n` passes by chance with the probability `level` at most (Bonferroni):
//! `P(|z| > limit) = level / n`.
//!
//! The test wants means of batches that are nearly normal, and light that comes seldom makes them
//! skew: most often they are too low, and so is their spread. Three things hold against that. No
//! cell is smaller than 8×8 pixels. Cells are judged only where both methods find light in every
//! batch, or one of them never does ([`Term::n_rare`] counts the others). And the relative error of
//! each mean is taken at the larger of the two.
//!
//! The scores of single pixels have a limit of their own. They are shown, and no verdict is by
//! them: a pixel has too few samples for means that are nearly normal.
//!
//! Who looks after each batch looks often, and every look may be deceived. So
//! [`Agreement::while_watched`] gives the look after `n` batches the share `(m - 1) / (n (n - 1))`
//! of the level, from `m` = [`FEWEST`] batches on; all looks together have all of it.
//!
//! On `cornell` at 32×32 pixels, with 64 samples a pixel, that brought false alarms between
//! `pt-mis` and `bdpt` from 27 of 100 runs to none at a level of 1 %; where there are many samples
//! it changes nothing.

mod batches;
mod cells;
mod estimate;
mod map;
mod report;
mod side;
#[cfg(test)]
mod tests;

use neumann_core::film::View;
use rayon::prelude::*;

pub use batches::Batches;
pub use cells::{Cell, Cells};
pub use estimate::{Estimate, MOST_DEVIATIONS, deviations, two_sided};
pub use map::{FULL_COLOUR, Grain, colour, map, scale};
pub use report::{CHANNELS, Report, Row, count, ratio, score_text};
pub use side::{Length, Side, batch, seed};

/// Batches from which on a verdict is given. Of fewer the spread may be none by chance.
pub const FEWEST: usize = 8;
/// What single precision may do to a mean, relative.
const ROUNDING: f64 = 1e-5;

/// What two methods have in common, and what not.
#[derive(Clone, Debug)]
pub struct Agreement {
    /// Probability of a false alarm, of all scores together.
    pub level: f64,
    /// Number of scores.
    pub n_scores: usize,
    /// Scores beyond it are no chance.
    pub limit: f64,
    /// The same of single pixels.
    pub pixel_limit: f64,
    /// Where they were compared.
    pub cells: Cells,
    /// The terms, the tail and L; what is black by both methods is left out.
    pub terms: Vec<Term>,
}

/// A term by two methods.
#[derive(Clone, Debug)]
pub struct Term {
    /// Which.
    pub view: View,
    /// Mean luminance by each method.
    pub means: [f64; 2],
    /// A difference of the means, over the mean of both, that would be just beyond the limit.
    pub seen_from: f64,
    /// Of each cell, the largest one of its channels; `None` where it is not judged.
    pub scores: Vec<Option<Score>>,
    /// Cells that are not judged, for some batches found no light there.
    pub n_rare: usize,
    /// Cells beyond the limit.
    pub n_beyond: usize,
    /// Those of them in which one of the methods found no light at all.
    pub n_beyond_black: [usize; 2],
    /// Scores of the luminance of each pixel.
    pub pixels: Vec<f32>,
    /// Pixels in which all batches of each method found light, or none did.
    pub is_sure: Vec<bool>,
}

/// How far two means are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Standard deviations; above zero where the first method is brighter.
    pub deviations: f64,
    /// Red, green or blue: 0, 1 or 2.
    pub channel: usize,
}

impl Agreement {
    /// Compares the batches of two methods, at least two of each.
    ///
    /// # Panics
    /// If their films differ in shape.
    #[must_use]
    pub fn of(batches: [&Batches; 2], level: f64) -> Self {
        Self::at_a_look(batches, level, 1.0)
    }

    /// The same where each batch is followed by a look: the level is that of all looks together.
    ///
    /// # Panics
    /// If their films differ in shape.
    #[must_use]
    pub fn while_watched(batches: [&Batches; 2], level: f64) -> Self {
        let n = batches[0].n().min(batches[1].n());
        let share = (FEWEST - 1) as f64 / (n * (n.max(2) - 1)).max(1) as f64;
        Self::at_a_look(batches, level, if n < FEWEST { 0.0 } else { share })
    }

    /// True where there are enough batches for a verdict.
    #[must_use]
    pub fn is_judged(&self) -> bool {
        self.limit < MOST_DEVIATIONS
    }

    fn at_a_look(batches: [&Batches; 2], level: f64, share: f64) -> Self {
        let [a, b] = batches;
        let (cells, views) = (a.cells(), a.views());
        assert_eq!((cells, &views), (b.cells(), &b.views()), "of one shape");
        let numbers = (0..views.len()).filter(|view| batches.iter().any(|b| b.n_lit(*view, 0) > 0));
        let pairs: Vec<Pair<'_>> = numbers.map(|view| Pair { batches, view }).collect();
        let scores: Vec<Vec<[Option<Score>; 3]>> = pairs
            .iter()
            .map(|pair| (0..cells.len()).map(|cell| pair.scores(cell)).collect())
            .collect();
        let n_scores = scores.iter().flatten().flatten().flatten().count();
        let limit_of = |n: usize| deviations(level * share / n.max(1) as f64);
        let limit = limit_of(n_scores);
        let terms = pairs.iter().zip(&scores).map(|(pair, scores)| {
            let largest = |scores: &[Option<Score>; 3]| {
                let scores = scores.iter().flatten().copied();
                scores.max_by(|a, b| a.deviations.abs().total_cmp(&b.deviations.abs()))
            };
            pair.term(
                views[pair.view],
                scores.iter().map(largest).collect(),
                limit,
            )
        });
        let terms: Vec<Term> = terms.collect();
        let sure = terms.iter().flat_map(|term| &term.is_sure);
        Self {
            level,
            n_scores,
            limit,
            pixel_limit: limit_of(sure.filter(|is_sure| **is_sure).count()),
            cells,
            terms,
        }
    }

    /// True if no score is beyond the limit.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.terms.iter().all(|term| term.n_beyond == 0)
    }
}

impl Score {
    /// How far two estimates of a channel are apart.
    #[must_use]
    pub fn of(a: Estimate, b: Estimate, channel: usize) -> Self {
        let larger = a.mean.max(b.mean);
        let p_value = a
            .error_at(larger)
            .p_value_against(&b.error_at(larger), ROUNDING);
        Self {
            deviations: deviations(p_value).copysign(a.mean - b.mean),
            channel,
        }
    }

    /// True if chance does not explain it.
    #[must_use]
    pub fn is_beyond(&self, limit: f64) -> bool {
        self.deviations.abs() > limit
    }
}

impl Term {
    /// The score of the whole picture.
    #[must_use]
    pub fn whole(&self) -> Option<Score> {
        self.scores.first().copied().flatten()
    }

    /// The largest score, and the cell that has it.
    #[must_use]
    pub fn largest(&self) -> Option<(usize, Score)> {
        let scores = self.scores.iter().enumerate();
        scores
            .filter_map(|(cell, score)| Some((cell, (*score)?)))
            .max_by(|a, b| a.1.deviations.abs().total_cmp(&b.1.deviations.abs()))
    }

    /// True if chance does not explain the score of a pixel.
    #[must_use]
    pub fn is_beyond(&self, pixel: usize, limit: f64) -> bool {
        self.is_sure[pixel] && f64::from(self.pixels[pixel].abs()) > limit
    }

    /// Cells that are judged.
    #[must_use]
    pub fn n_judged(&self) -> usize {
        self.scores.iter().flatten().count()
    }
}

/// A view by both methods, by its number.
struct Pair<'a> {
    batches: [&'a Batches; 2],
    view: usize,
}

impl Pair<'_> {
    /// Scores of the channels of a cell that can be judged.
    fn scores(&self, cell: usize) -> [Option<Score>; 3] {
        [0, 1, 2].map(|channel| {
            let [a, b] = self.batches.map(|b| b.estimate(self.view, cell, channel));
            let is_lit = a.mean > 0.0 || b.mean > 0.0;
            (is_lit && !self.is_rare(cell)).then(|| Score::of(a, b, channel))
        })
    }

    /// Of how many batches of each method a cell has light.
    fn n_lit(&self, cell: usize) -> [usize; 2] {
        self.batches.map(|batches| batches.n_lit(self.view, cell))
    }

    /// True if light comes too seldom for the spread of the batches to say how certain the mean is.
    /// That a method finds none at all says something, but not in a part of a cell where it finds
    /// some at times.
    fn is_rare(&self, cell: usize) -> bool {
        let is_partly_lit = |cell: usize| {
            let lit = self.n_lit(cell);
            [0, 1].map(|i| lit[i] > 0 && lit[i] < self.batches[i].n())
        };
        let is_black = self.n_lit(cell).map(|n_lit| n_lit == 0);
        let parent = self.batches[0].cells().parent(cell);
        let around = parent.map_or([false; 2], is_partly_lit);
        let here = is_partly_lit(cell);
        (0..2).any(|i| here[i] || is_black[i] && around[i])
    }

    fn term(&self, view: View, scores: Vec<Option<Score>>, limit: f64) -> Term {
        let is_beyond = |score: &Option<Score>| score.is_some_and(|s| s.is_beyond(limit));
        let beyond = (0..scores.len()).filter(|cell| is_beyond(&scores[*cell]));
        let beyond: Vec<[usize; 2]> = beyond.map(|cell| self.n_lit(cell)).collect();
        let (width, height) = self.batches[0].cells().size();
        let pixels = (0..width * height).into_par_iter().map(|pixel| {
            let [a, b] = self.batches.map(|batches| batches.pixel(self.view, pixel));
            Score::of(a, b, 0).deviations as f32
        });
        let is_sure = |pixel| {
            let lit = self.batches.map(|batches| batches.is_lit(self.view, pixel));
            lit.iter().all(Option::is_some)
        };
        let (means, seen_from) = self.whole(limit);
        Term {
            view,
            means,
            seen_from,
            n_rare: (0..scores.len()).filter(|cell| self.is_rare(*cell)).count(),
            n_beyond: beyond.len(),
            n_beyond_black: [0, 1].map(|i| beyond.iter().filter(|lit| lit[i] == 0).count()),
            scores,
            pixels: pixels.collect(),
            is_sure: (0..width * height).map(is_sure).collect(),
        }
    }

    /// Mean luminance by each method, and the relative difference that would be at the limit.
    fn whole(&self, limit: f64) -> ([f64; 2], f64) {
        let estimates = self.batches.map(|b| b.luminance(self.view, 0));
        let means = estimates.map(|estimate| estimate.mean);
        let middle = 0.5 * (means[0] + means[1]);
        let [a, b] = estimates.map(|estimate| Estimate {
            mean: middle,
            ..estimate
        });
        let is_seen = |difference: f64| {
            let mean = middle * (1.0 + difference);
            Score::of(Estimate { mean, ..a }, b, 0).is_beyond(limit)
        };
        // Between nothing and what is seen in any case, by bisection.
        let (mut below, mut above) = (0.0, 1e3);
        for _ in 0..50 {
            let between = 0.5 * (below + above);
            if is_seen(between) {
                above = between;
            } else {
                below = between;
            }
        }
        (means, above)
    }
}
