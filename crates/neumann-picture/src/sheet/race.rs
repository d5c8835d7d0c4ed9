//! Pictures of several methods side by side, with what is to be said of each.

use super::canvas::{Canvas, Rect, Thumbnail};
use super::text::{Align, Face, Style, Typesetter};
use super::{BRIGHT, EDGE, FRAME, GROUND, GUTTER, HEADING, MARGIN, SHARE, SUBTITLE, TITLE, UNIT};
use crate::Image;
use crate::png_file::Pixels8;
use crate::tone::Display;

/// A picture of the sheet.
pub struct RacePicture<'a> {
    /// What the method rendered.
    pub image: &'a Image,
    /// What it is called.
    pub name: String,
    /// Facts about it, a line each.
    pub lines: Vec<String>,
}

const NAME: Style = Style {
    face: Face::SemiBold,
    size: 18.0,
    colour: BRIGHT,
};
const LINE: usize = 3 * UNIT;

/// Lays out pictures of one size in a row, all shown alike. The heading is a name, such as that of
/// the scene, and a line on how they were made.
#[must_use]
pub fn race_sheet(pictures: &[RacePicture<'_>], heading: [&str; 2], display: &Display) -> Pixels8 {
    let (width, height) = size(pictures);
    let most = pictures.iter().map(|p| p.lines.len()).max().unwrap_or(0);
    let n = pictures.len();
    let top = MARGIN + HEADING;
    let page = (
        2 * MARGIN + n * width + n.saturating_sub(1) * GUTTER,
        top + height + (most + 1) * LINE + UNIT + MARGIN,
    );
    let mut canvas = Canvas::new(page.0, page.1, GROUND);
    let typesetter = Typesetter::new();
    let write = |canvas: &mut Canvas, text: &str, room: usize, at: (usize, usize), style| {
        let text = typesetter.shortened(text, style, room as f32);
        typesetter.write(
            canvas,
            &text,
            (at.0 as f32, at.1 as f32),
            Align::Left,
            style,
        );
    };
    let room = page.0 - 2 * MARGIN;
    write(
        &mut canvas,
        heading[0],
        room,
        (MARGIN, MARGIN + 3 * UNIT),
        &TITLE,
    );
    write(
        &mut canvas,
        heading[1],
        room,
        (MARGIN, MARGIN + 7 * UNIT),
        &SUBTITLE,
    );
    for (i, picture) in pictures.iter().enumerate() {
        let x = MARGIN + i * (width + GUTTER);
        let rect = Rect {
            x,
            y: top,
            width,
            height,
        };
        let frame = Rect {
            x: x - 1,
            y: top - 1,
            width: width + 2,
            height: height + 2,
        };
        canvas.fill(frame, FRAME);
        let source = Thumbnail {
            pixels: &picture.image.pixels,
            size: (picture.image.width, picture.image.height),
        };
        canvas.picture(rect, &source, display);
        let mut y = top + height + LINE;
        write(&mut canvas, &picture.name, width, (x, y), &NAME);
        for line in &picture.lines {
            y += LINE;
            write(&mut canvas, line, width, (x, y), &SHARE);
        }
    }
    canvas.into_pixels()
}

/// How large each picture is shown: as it is, or smaller.
fn size(pictures: &[RacePicture<'_>]) -> (usize, usize) {
    let Some(image) = pictures.first().map(|picture| picture.image) else {
        return (1, 1);
    };
    let edge = (2 * EDGE) as f32;
    let scale = (edge / image.width.max(image.height) as f32).min(1.0);
    let scaled = |n: usize| ((n as f32 * scale).round() as usize).max(1);
    (scaled(image.width), scaled(image.height))
}
