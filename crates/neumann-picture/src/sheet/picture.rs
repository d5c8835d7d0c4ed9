//! A picture as the screen shows it, with what explains its colours: the scale of false colours or
//! of differences, and the names of what stands on either side of a wipe.
//!
//! The picture stands there pixel for pixel; the scale stands beside it, words stand below it.

use super::canvas::{Canvas, Rect};
use super::text::{Align, Face, Style, Typesetter};
use super::{BRIGHT, FRAME, GROUND, GUTTER, HEADING, MARGIN, NOTE, SUBTITLE, TITLE, UNIT, WORDS};
use crate::png_file::Pixels8;

/// What numbers the colours of a picture stand for.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// The unit of the numbers.
    pub unit: String,
    /// Colours from the lower end to the upper one, sRGB codes.
    pub colours: Vec<[u8; 3]>,
    /// Numbers, each with its place on the scale, 0 to 1.
    pub marks: Vec<(f32, String)>,
}

/// The line between two pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct Wipe {
    /// Its place across the picture, 0 to 1.
    pub place: f32,
    /// What stands left of it, and what right.
    pub names: [String; 2],
}

/// A line that is drawn on a picture, with round ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Columns and rows of the picture, from its upper left corner.
    pub ends: [[f32; 2]; 2],
    /// Pixels.
    pub width: f32,
    /// sRGB code.
    pub colour: [u8; 3],
    /// How much it covers, 0 to 1.
    pub opacity: f32,
}

/// A picture and what is said of it.
#[derive(Clone, Debug)]
pub struct PictureSheet {
    /// A name, such as that of the scene, and a line on what is shown.
    pub heading: [String; 2],
    /// The picture.
    pub picture: Pixels8,
    /// The line of a wipe over it.
    pub wipe: Option<Wipe>,
    /// Lines on it.
    pub strokes: Vec<Stroke>,
    /// What its colours mean.
    pub scale: Option<Scale>,
    /// Lines below it.
    pub lines: Vec<String>,
}

/// Width of the scale with its numbers, pixels.
const SCALE: usize = 16 * UNIT;
const BAR: usize = 2 * UNIT;
/// The scale is no longer than this, and no shorter than its numbers need.
const LONGEST: usize = 40 * UNIT;
const SHORTEST: usize = 15 * UNIT;
/// What is under the picture has so much room, however narrow that is.
const NARROWEST: usize = 48 * UNIT;
const LINE: usize = 3 * UNIT;
const WIPE: [u8; 3] = [0xff, 0xb0, 0x00];

const SIDE: Style = Style {
    face: Face::SemiBold,
    size: 15.0,
    colour: BRIGHT,
};

/// Lays out a picture with what explains it.
#[must_use]
pub fn picture_sheet(sheet: &PictureSheet) -> Pixels8 {
    let (width, height) = (sheet.picture.width, sheet.picture.height);
    let beside = sheet.scale.as_ref().map_or(0, |_| GUTTER + SCALE);
    let content = (width + beside).max(NARROWEST);
    let top = MARGIN + HEADING;
    let below = top + height.max(sheet.scale.as_ref().map_or(0, |_| LINE + SHORTEST + UNIT));
    let n_lines = sheet.lines.len() + usize::from(sheet.wipe.is_some());
    let page = (2 * MARGIN + content, below + n_lines * LINE + MARGIN);
    let mut canvas = Canvas::new(page.0, page.1, GROUND);
    let typesetter = Typesetter::new();
    let write = |canvas: &mut Canvas, text: &str, room: f32, place: Place<'_>| {
        let text = typesetter.shortened(text, place.style, room);
        typesetter.write(canvas, &text, place.at, place.align, place.style);
    };
    let (left, room) = (MARGIN as f32, content as f32);
    for (text, style, down) in [
        (&sheet.heading[0], &TITLE, 3 * UNIT),
        (&sheet.heading[1], &SUBTITLE, 7 * UNIT),
    ] {
        let at = (left, (MARGIN + down) as f32);
        write(&mut canvas, text, room, Place::left(at, style));
    }
    let frame = Rect {
        x: MARGIN - 1,
        y: top - 1,
        width: width + 2,
        height: height + 2,
    };
    canvas.fill(frame, FRAME);
    canvas.paste(MARGIN, top, &sheet.picture);
    for stroke in &sheet.strokes {
        let ends = stroke
            .ends
            .map(|[x, y]| (x + MARGIN as f32, y + top as f32));
        canvas.faint_line(ends, stroke.width, stroke.colour, stroke.opacity);
    }
    let mut baseline = below as f32 + LINE as f32;
    if let Some(wipe) = &sheet.wipe {
        canvas.fill(line_of(wipe, width, height, (MARGIN, top)), WIPE);
        let [a, b] = &wipe.names;
        let wide = width.max(NARROWEST) as f32;
        let half = (wide - GUTTER as f32) / 2.0;
        write(&mut canvas, a, half, Place::left((left, baseline), &SIDE));
        let place = Place {
            at: (left + wide, baseline),
            align: Align::Right,
            style: &SIDE,
        };
        write(&mut canvas, b, half, place);
        baseline += LINE as f32;
    }
    for line in &sheet.lines {
        write(
            &mut canvas,
            line,
            room,
            Place::left((left, baseline), &WORDS),
        );
        baseline += LINE as f32;
    }
    if let Some(scale) = &sheet.scale {
        let corner = (MARGIN + width + GUTTER, top);
        let at = (corner.0 as f32, corner.1 as f32 + (2 * UNIT) as f32);
        write(
            &mut canvas,
            &scale.unit,
            SCALE as f32,
            Place::left(at, &NOTE),
        );
        let bar = Rect {
            x: corner.0,
            y: top + LINE + UNIT,
            width: BAR,
            height: height
                .saturating_sub(LINE + 2 * UNIT)
                .clamp(SHORTEST, LONGEST),
        };
        fill_bar(&mut canvas, bar, &scale.colours);
        for (t, text) in &scale.marks {
            let y = bar.y as f32 + (1.0 - t) * bar.height as f32;
            let at = ((bar.x + BAR + UNIT) as f32, y + 5.0);
            let room = (SCALE - BAR - UNIT) as f32;
            write(&mut canvas, text, room, Place::left(at, &WORDS));
        }
    }
    canvas.into_pixels()
}

/// Where a line of text stands, and how it looks.
struct Place<'a> {
    at: (f32, f32),
    align: Align,
    style: &'a Style,
}

impl<'a> Place<'a> {
    fn left(at: (f32, f32), style: &'a Style) -> Self {
        Self {
            at,
            align: Align::Left,
            style,
        }
    }
}

/// One column of the picture, at the place of the wipe.
fn line_of(wipe: &Wipe, width: usize, height: usize, corner: (usize, usize)) -> Rect {
    let column = (wipe.place.clamp(0.0, 1.0) * width as f32) as usize;
    Rect {
        x: corner.0 + column.min(width.saturating_sub(1)),
        y: corner.1,
        width: 1,
        height,
    }
}

/// Fills a bar with colours, the last one on top.
fn fill_bar(canvas: &mut Canvas, bar: Rect, colours: &[[u8; 3]]) {
    let last = colours.len().saturating_sub(1);
    for row in 0..bar.height {
        let up = bar.height - 1 - row;
        let Some(colour) = colours.get(up * last / (bar.height - 1).max(1)) else {
            return;
        };
        let line = Rect {
            y: bar.y + row,
            height: 1,
            ..bar
        };
        canvas.fill(line, *colour);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{GROUND, GUTTER, HEADING, MARGIN};
    use super::{PictureSheet, Scale, WIPE, Wipe, picture_sheet};
    use crate::png_file::Pixels8;

    fn sheet(width: usize, height: usize) -> PictureSheet {
        PictureSheet {
            heading: ["scene".to_owned(), "luminance".to_owned()],
            picture: Pixels8 {
                width,
                height,
                pixels: (0..width * height).map(|i| [i as u8, 1, 2]).collect(),
            },
            wipe: None,
            strokes: Vec::new(),
            scale: None,
            lines: Vec::new(),
        }
    }

    fn scale() -> Scale {
        Scale {
            unit: "W".to_owned(),
            colours: vec![[1, 2, 3], [200, 100, 50]],
            marks: vec![(0.0, "0".to_owned()), (1.0, "8".to_owned())],
        }
    }

    #[test]
    fn the_picture_stands_there_pixel_for_pixel() {
        let sheet = PictureSheet {
            scale: Some(scale()),
            ..sheet(16, 12)
        };
        let page = picture_sheet(&sheet);
        let (left, top) = (MARGIN, MARGIN + HEADING);
        for y in 0..12 {
            let start = (top + y) * page.width + left;
            let row = &sheet.picture.pixels[y * 16..(y + 1) * 16];
            assert_eq!(&page.pixels[start..start + 16], row);
        }
        let bar = MARGIN + 16 + GUTTER;
        let column: Vec<_> = page.pixels[bar..].iter().step_by(page.width).collect();
        assert!(column.contains(&&[1, 2, 3]) && column.contains(&&[200, 100, 50]));
    }

    #[test]
    fn a_wipe_has_its_line_and_both_names() {
        let plain = picture_sheet(&sheet(64, 48));
        let wipe = Wipe {
            place: 0.25,
            names: ["A  L".to_owned(), "B  T2".to_owned()],
        };
        let page = picture_sheet(&PictureSheet {
            wipe: Some(wipe),
            strokes: Vec::new(),

            ..sheet(64, 48)
        });
        let middle = MARGIN + HEADING + 24;
        assert_eq!(page.pixels[middle * page.width + MARGIN + 16], WIPE);
        let is_written = |columns: std::ops::Range<usize>| {
            let rows = page.pixels.chunks_exact(page.width);
            rows.skip(plain.height - MARGIN)
                .any(|row| row[columns.clone()].iter().any(|p| *p != GROUND))
        };
        assert!(is_written(0..page.width / 2), "the name on the left");
        assert!(is_written(page.width / 2..page.width), "that on the right");
    }

    #[test]
    fn odd_shapes_are_laid_out() {
        for (width, height) in [(1, 1), (2, 500), (500, 2)] {
            let page = picture_sheet(&PictureSheet {
                scale: Some(scale()),
                ..sheet(width, height)
            });
            assert_eq!(page.pixels.len(), page.width * page.height);
        }
    }
}
