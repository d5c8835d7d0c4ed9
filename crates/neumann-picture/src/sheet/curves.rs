//! Errors over time, drawn on a page or in a figure.

use super::board::Board;
use super::canvas::Rect;
use super::text::{Align, Face, Style};
use super::{FRAME, NOTE, QUIET, UNIT, WORDS};
use crate::race::{Chart, Measure, Point, colours};

/// Room for numbers on the left and below.
const LEFT: usize = 8 * UNIT;
const BELOW: usize = 6 * UNIT;
/// Room for what stands above.
const ABOVE: usize = 4 * UNIT;

/// How a chart looks.
pub(crate) struct Look {
    /// Its heading, numbers of its axes, and what is less to be read.
    pub(crate) words: Style,
    pub(crate) number: Style,
    pub(crate) note: Style,
    pub(crate) grid: [u8; 3],
    pub(crate) frame: [u8; 3],
    /// The ground is dark.
    pub(crate) is_dark: bool,
}

/// On a sheet.
pub(super) const ON_SHEETS: Look = Look {
    words: WORDS,
    number: Style {
        face: Face::Regular,
        size: 13.0,
        colour: QUIET,
    },
    note: NOTE,
    grid: [0x2a; 3],
    frame: FRAME,
    is_dark: true,
};

/// Draws curves by one measure into a part of the page, in the colours of [`colours`]. Nothing is
/// drawn while there is no error that has a logarithm.
pub(crate) fn draw(
    board: &mut dyn Board,
    page: Rect,
    curves: &[&[Point]],
    measure: Measure,
    look: &Look,
) {
    let Some(chart) = Chart::new(curves, measure) else {
        return;
    };
    let plot = Rect {
        x: page.x + LEFT,
        y: page.y + ABOVE,
        width: page.width.saturating_sub(LEFT),
        height: page.height.saturating_sub(ABOVE + BELOW),
    };
    let at = |[x, y]: [f64; 2]| {
        let (x, y) = (x as f32, y as f32);
        (
            plot.x as f32 + x * plot.width as f32,
            plot.y as f32 + (1.0 - y) * plot.height as f32,
        )
    };
    let title = (
        page.x as f32 + LEFT as f32,
        page.y as f32 + 2.0 * UNIT as f32,
    );
    let heading = format!("{} over processor time, s", measure.name());
    board.write(&heading, title, Align::Left, &look.words);
    for tick in &chart.seconds.ticks {
        let ends = [at([tick.at, 0.0]), at([tick.at, 1.0])];
        board.way(&ends, 1.0, look.grid);
        let place = (ends[0].0, ends[0].1 + 2.5 * UNIT as f32);
        board.write(&tick.label, place, Align::Centre, &look.number);
    }
    for tick in &chart.error.ticks {
        let ends = [at([0.0, tick.at]), at([1.0, tick.at])];
        board.way(&ends, 1.0, look.grid);
        let place = (ends[0].0 - UNIT as f32, ends[0].1 + 4.5);
        board.write(&tick.label, place, Align::Right, &look.number);
    }
    for sides in [[[0.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]]] {
        board.way(&sides.map(at), 1.0, look.frame);
    }
    board.dashes(chart.guide.map(at), 1.0, look.note.colour);
    let beside = (plot.x as f32 + plot.width as f32, title.1);
    let words = format!("- - {}", measure.slope_text());
    board.write(&words, beside, Align::Right, &look.note);
    for (curve, colour) in curves.iter().zip(colours(look.is_dark)) {
        let places: Vec<_> = curve
            .iter()
            .filter_map(|p| chart.place(p))
            .map(at)
            .collect();
        board.way(&places, 2.0, colour);
        for place in places {
            board.dot(place, 6.0, colour);
        }
    }
}
