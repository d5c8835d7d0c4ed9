//! What charts are drawn on: a page of pixels, or a vector figure.

use super::canvas::Canvas;
use super::text::{Align, Style, Typesetter};

/// Places are in pixels from the upper left corner.
pub(crate) trait Board {
    /// Straight lines from each point to the next.
    fn way(&mut self, points: &[(f32, f32)], width: f32, colour: [u8; 3]);

    /// A line of dashes, [`DASH`] long each, with gaps as long.
    fn dashes(&mut self, ends: [(f32, f32); 2], width: f32, colour: [u8; 3]);

    /// A disk.
    fn dot(&mut self, at: (f32, f32), diameter: f32, colour: [u8; 3]);

    /// A line of text with its baseline there; scripts are marked as a [`Typesetter`] knows them.
    fn write(&mut self, line: &str, at: (f32, f32), align: Align, style: &Style);
}

/// Length of a dash.
pub(crate) const DASH: f32 = 6.0;

/// A page of pixels.
pub(super) struct Page<'a> {
    pub(super) canvas: &'a mut Canvas,
    pub(super) typesetter: &'a Typesetter,
}

impl Board for Page<'_> {
    fn way(&mut self, points: &[(f32, f32)], width: f32, colour: [u8; 3]) {
        for ends in points.windows(2) {
            self.canvas.line([ends[0], ends[1]], width, colour);
        }
    }

    fn dashes(&mut self, [from, to]: [(f32, f32); 2], width: f32, colour: [u8; 3]) {
        let length = (to.0 - from.0).hypot(to.1 - from.1).max(1.0);
        let along = |s: f32| {
            let share = (s / length).min(1.0);
            (
                from.0 + share * (to.0 - from.0),
                from.1 + share * (to.1 - from.1),
            )
        };
        let n = (length / (2.0 * DASH)) as usize;
        for i in 0..=n {
            let start = 2.0 * DASH * i as f32;
            let ends = [along(start), along(start + DASH)];
            self.canvas.line(ends, width, colour);
        }
    }

    fn dot(&mut self, at: (f32, f32), diameter: f32, colour: [u8; 3]) {
        self.canvas.line([at, at], diameter, colour);
    }

    fn write(&mut self, line: &str, at: (f32, f32), align: Align, style: &Style) {
        self.typesetter.write(self.canvas, line, at, align, style);
    }
}
