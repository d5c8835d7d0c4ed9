//! Errors over time, drawn on a page.

use super::canvas::{Canvas, Rect};
use super::text::{Align, Face, Style, Typesetter};
use super::{FRAME, NOTE, QUIET, UNIT, WORDS};
use crate::race::{Chart, Measure, Point, colours};

/// Room for numbers on the left and below.
const LEFT: usize = 8 * UNIT;
const BELOW: usize = 6 * UNIT;
/// Room for what stands above.
const ABOVE: usize = 4 * UNIT;

const NUMBER: Style = Style {
    face: Face::Regular,
    size: 13.0,
    colour: QUIET,
};
const GRID: [u8; 3] = [0x2a; 3];

/// Draws curves by one measure into a part of the page, in the colours of [`colours`]. Nothing is
/// drawn while there is no error that has a logarithm.
pub(super) fn draw(
    canvas: &mut Canvas,
    typesetter: &Typesetter,
    page: Rect,
    curves: &[&[Point]],
    measure: Measure,
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
    let write = |canvas: &mut Canvas, text: &str, place, align, style: &Style| {
        typesetter.write(canvas, text, place, align, style);
    };
    let title = (
        page.x as f32 + LEFT as f32,
        page.y as f32 + 2.0 * UNIT as f32,
    );
    let heading = format!("{} over processor time, s", measure.name());
    write(canvas, &heading, title, Align::Left, &WORDS);
    for tick in &chart.seconds.ticks {
        let ends = [at([tick.at, 0.0]), at([tick.at, 1.0])];
        canvas.line(ends, 1.0, GRID);
        let place = (ends[0].0, ends[0].1 + 2.5 * UNIT as f32);
        write(canvas, &tick.label, place, Align::Centre, &NUMBER);
    }
    for tick in &chart.error.ticks {
        let ends = [at([0.0, tick.at]), at([1.0, tick.at])];
        canvas.line(ends, 1.0, GRID);
        let place = (ends[0].0 - UNIT as f32, ends[0].1 + 4.5);
        write(canvas, &tick.label, place, Align::Right, &NUMBER);
    }
    for sides in [[[0.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]]] {
        canvas.line(sides.map(at), 1.0, FRAME);
    }
    let guide = chart.guide.map(at);
    dashes(canvas, guide);
    let beside = (plot.x as f32 + plot.width as f32, title.1);
    let words = format!("- - {}", measure.slope_text());
    write(canvas, &words, beside, Align::Right, &NOTE);
    for (curve, colour) in curves.iter().zip(colours(true)) {
        let places: Vec<_> = curve
            .iter()
            .filter_map(|p| chart.place(p))
            .map(at)
            .collect();
        for ends in places.windows(2) {
            canvas.line([ends[0], ends[1]], 2.0, colour);
        }
        for place in places {
            canvas.line([place, place], 6.0, colour);
        }
    }
}

fn dashes(canvas: &mut Canvas, [from, to]: [(f32, f32); 2]) {
    let length = (to.0 - from.0).hypot(to.1 - from.1).max(1.0);
    let along = |s: f32| {
        let share = (s / length).min(1.0);
        (
            from.0 + share * (to.0 - from.0),
            from.1 + share * (to.1 - from.1),
        )
    };
    let n = (length / 12.0) as usize;
    for i in 0..=n {
        let start = 12.0 * i as f32;
        canvas.line([along(start), along(start + 6.0)], 1.0, QUIET);
    }
}
