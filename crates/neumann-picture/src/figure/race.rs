//! Errors of methods over time, with a legend.

use super::{Figure, LINE, LOOK, MARGIN, NOTE, TITLE};
use crate::race::{Measure, Point, colours};
use crate::sheet::Rect;
use crate::sheet::board::Board;
use crate::sheet::curves;
use crate::sheet::text::{Align, Style};

const WIDTH: f32 = 960.0;
/// Height of the curves.
const CURVES: f32 = 380.0;
const GUTTER: f32 = 24.0;

const NAME: Style = Style {
    size: 15.0,
    ..TITLE
};

/// Draws the curves of both errors: methods by their names, below a heading of two lines.
#[must_use]
pub fn race_figure(heading: [&str; 2], racers: &[(&str, &[Point])]) -> String {
    let (mut figure, mut y) = Figure::new(WIDTH, heading);
    y += 2.0 * LINE;
    let pitch = (WIDTH - 2.0 * MARGIN) / racers.len().max(1) as f32;
    for (i, ((name, curve), colour)) in racers.iter().zip(colours(LOOK.is_dark)).enumerate() {
        let x = MARGIN + i as f32 * pitch;
        let middle = y - 5.0;
        figure.way(&[(x, middle), (x + 24.0, middle)], 2.0, colour);
        figure.dot((x + 12.0, middle), 6.0, colour);
        figure.write(name, (x + 32.0, y), Align::Left, &NAME);
        let facts = curve.last().map(Point::facts).into_iter().flatten();
        for (line, fact) in facts.enumerate() {
            let at = (x + 32.0, y + LINE * (line as f32 + 1.0));
            figure.write(&fact, at, Align::Left, &NOTE);
        }
    }
    y += 3.0 * LINE;
    let curves: Vec<_> = racers.iter().map(|(_, curve)| *curve).collect();
    let width = 0.5 * (WIDTH - 2.0 * MARGIN - GUTTER);
    for (i, measure) in Measure::ALL.into_iter().enumerate() {
        let part = Rect {
            x: (MARGIN + i as f32 * (width + GUTTER)) as usize,
            y: y as usize,
            width: width as usize,
            height: CURVES as usize,
        };
        curves::draw(&mut figure, part, &curves, measure, &LOOK);
    }
    figure.finish(WIDTH, y + CURVES)
}
