//! The energy of the terms as it is drawn: bars on a logarithmic axis, with their intervals and the
//! fit. Whoever draws puts the plot where it likes.

use neumann_core::film::View;

use super::Energy;
use crate::axis::Axis;
use crate::figures::significant;

/// Deviations of the interval that is drawn: it holds the truth 95 times of 100.
pub const DEVIATIONS: f64 = 1.96;

/// The terms as bars in a plot; places are from its upper left corner.
#[derive(Debug)]
pub struct Chart<'a> {
    /// What is drawn.
    pub energy: &'a Energy,
    /// The shares.
    pub axis: Axis,
    /// Width and height of the plot.
    pub size: [f32; 2],
}

/// What a line is drawn in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// A share that is a round number.
    Grid,
    /// A term.
    Bar,
    /// The tail, which is a sum of terms.
    Tail,
    /// The interval of a term.
    Interval,
    /// The geometric series, in dashes.
    Fit,
}

/// A line of the chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// From where to where.
    pub ends: [[f32; 2]; 2],
    /// How wide.
    pub width: f32,
    /// In what.
    pub ink: Ink,
}

impl<'a> Chart<'a> {
    /// A plot of that size; `None` while there is no light.
    #[must_use]
    pub fn new(energy: &'a Energy, size: [f32; 2]) -> Option<Self> {
        let shares = energy.terms.iter().map(|term| term.share);
        Some(Self {
            energy,
            axis: Axis::around(shares)?,
            size,
        })
    }

    /// Room for each term.
    #[must_use]
    pub fn pitch(&self) -> f32 {
        self.size[0] / self.energy.terms.len().max(1) as f32
    }

    /// The middle of a term's place.
    #[must_use]
    pub fn x(&self, term: f32) -> f32 {
        (term + 0.5) * self.pitch()
    }

    /// The height of a share, within the plot.
    fn y(&self, share: f64) -> f32 {
        let place = self.axis.place(share).unwrap_or(0.0).clamp(0.0, 1.0);
        (1.0 - place as f32) * self.size[1]
    }

    /// Numbers at the axis with their heights, lowest first and some way apart.
    #[must_use]
    pub fn labels(&self) -> Vec<(f32, String)> {
        let mut free = f32::INFINITY;
        let mut labels = Vec::new();
        for tick in &self.axis.ticks {
            let y = (1.0 - tick.at as f32) * self.size[1];
            if y + 6.0 < free && !tick.label.is_empty() {
                free = y - 8.0;
                let share = self.axis.value(tick.at);
                labels.push((y, format!("{} %", significant(100.0 * share, 1))));
            }
        }
        labels
    }

    /// Lines of the axis.
    pub fn grid(&self) -> impl Iterator<Item = Line> {
        let [width, height] = self.size;
        self.axis.ticks.iter().map(move |tick| {
            let y = (1.0 - tick.at as f32) * height;
            Line {
                ends: [[0.0, y], [width, y]],
                width: 1.0,
                ink: Ink::Grid,
            }
        })
    }

    /// Bars with their intervals, and the fit.
    #[must_use]
    pub fn lines(&self) -> Vec<Line> {
        let mut lines = Vec::new();
        let mut line = |ends, width, ink| lines.push(Line { ends, width, ink });
        let base = self.size[1];
        let half = (0.3 * self.pitch()).min(14.0);
        for (i, term) in self.energy.terms.iter().enumerate() {
            if term.share <= 0.0 {
                continue;
            }
            let (x, y) = (self.x(i as f32), self.y(term.share));
            let ink = if term.part == View::Tail {
                Ink::Tail
            } else {
                Ink::Bar
            };
            line([[x, base], [x, y]], 2.0 * half, ink);
            if let Some(error) = term.error {
                let [low, high] = [-1.0, 1.0].map(|s| self.y(term.share + s * DEVIATIONS * error));
                line([[x, low], [x, high]], 1.5, Ink::Interval);
                for y in [low, high] {
                    line([[x - 4.0, y], [x + 4.0, y]], 1.5, Ink::Interval);
                }
            }
        }
        if let Some(decay) = self.energy.decay {
            let at = |k: usize| [self.x(k as f32), self.y(decay.share(k as f64))];
            line([at(decay.first), at(decay.last)], 2.0, Ink::Fit);
        }
        lines
    }
}
