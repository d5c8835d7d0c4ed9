//! What the terms are worth, as bars.

use super::{BLACK, Figure, LINE, LOOK, MARGIN, NOTE, WORDS};
use crate::energy::{Chart, Energy, Ink};
use crate::sheet::board::Board;
use crate::sheet::formula;
use crate::sheet::text::Align;

const WIDTH: f32 = 760.0;
const PLOT: f32 = 300.0;
/// Room for numbers on the left, and for names below.
const LEFT: f32 = 72.0;
const BELOW: f32 = 64.0;

const BLUE: [u8; 3] = [0, 114, 178];
const PALE_BLUE: [u8; 3] = [86, 180, 233];
const VERMILION: [u8; 3] = [213, 94, 0];

/// Draws the terms on a logarithmic axis with intervals and fit, below a heading of two lines.
#[must_use]
pub fn energy_figure(heading: [&str; 2], energy: &Energy) -> String {
    let (mut figure, mut y) = Figure::new(WIDTH, heading);
    y += 0.5 * LINE;
    for sentence in energy.sentence().split_inclusive(". ") {
        y += LINE;
        figure.write(sentence.trim_end(), (MARGIN, y), Align::Left, &WORDS);
    }
    y += 2.5 * LINE;
    let size = [WIDTH - 2.0 * MARGIN - LEFT, PLOT];
    let Some(chart) = Chart::new(energy, size) else {
        return figure.finish(WIDTH, y);
    };
    let left = MARGIN + LEFT;
    let at = |[x, from_top]: [f32; 2]| (left + x, y + from_top);
    for line in chart.grid().chain(chart.lines()) {
        let ends = line.ends.map(at);
        match line.ink {
            Ink::Grid => figure.way(&ends, line.width, LOOK.grid),
            Ink::Bar => figure.bar(ends, line.width, BLUE),
            Ink::Tail => figure.bar(ends, line.width, PALE_BLUE),
            Ink::Interval => figure.way(&ends, line.width, BLACK),
            Ink::Fit => figure.dashes(ends, line.width, VERMILION),
        }
    }
    for (height, label) in chart.labels() {
        let place = (left - 8.0, y + height + 4.5);
        figure.write(&label, place, Align::Right, &NOTE);
    }
    let corner = [0.0, PLOT];
    for end in [[0.0, 0.0], [size[0], PLOT]] {
        figure.way(&[corner, end].map(at), 1.0, LOOK.frame);
    }
    let n_layers = energy.terms.len().saturating_sub(1);
    for (i, term) in energy.terms.iter().enumerate() {
        let place = (left + chart.x(i as f32), y + PLOT + 1.2 * LINE);
        figure.write(&formula(term.part, n_layers), place, Align::Centre, &WORDS);
    }
    let title = (MARGIN, y - 0.8 * LINE);
    figure.write("share of L", title, Align::Left, &NOTE);
    let below = y + PLOT + 2.6 * LINE;
    let mut x = left;
    let mut legend = |figure: &mut Figure, words: &str, room: f32| {
        figure.write(words, (x + 28.0, below), Align::Left, &NOTE);
        let ends = [(x, below - 4.5), (x + 20.0, below - 4.5)];
        x += room;
        ends
    };
    let ends = legend(&mut figure, "holds the truth 95 times of 100", 240.0);
    figure.way(&ends, 1.5, BLACK);
    for (x, y) in ends {
        figure.way(&[(x, y - 4.0), (x, y + 4.0)], 1.5, BLACK);
    }
    if energy.decay.is_some() {
        let ends = legend(&mut figure, "geometric series, fitted", 0.0);
        figure.dashes(ends, 2.0, VERMILION);
    }
    figure.finish(WIDTH, y + PLOT + BELOW)
}
