//! Pictures of several methods side by side, with what is to be said of each, and their errors over
//! time below.

use super::board::Page;
use super::canvas::{Canvas, Rect, Thumbnail};
use super::text::{Align, Face, Style, Typesetter};
use super::{
    BRIGHT, EDGE, FRAME, GROUND, GUTTER, HEADING, MARGIN, NARROWEST, SHARE, SUBTITLE, TITLE, UNIT,
    curves,
};
use crate::Image;
use crate::png_file::Pixels8;
use crate::race::{Measure, Point, colours};
use crate::tone::Display;

/// What is laid out.
pub struct RaceSheet<'a> {
    /// A name, such as that of the scene, and a line on how the pictures were made.
    pub heading: [&'a str; 2],
    /// What the methods have made.
    pub pictures: &'a [RacePicture<'a>],
    /// What they are judged by, and a fact about it.
    pub reference: (&'a Image, &'a str),
    /// How all are shown.
    pub display: Display,
}

/// What a method has made.
pub struct RacePicture<'a> {
    /// Its picture, of the size of the others.
    pub image: &'a Image,
    /// What it is called.
    pub name: &'a str,
    /// Its errors over time; the last one is that of the picture.
    pub curve: &'a [Point],
}

const NAME: Style = Style {
    face: Face::SemiBold,
    size: 18.0,
    colour: BRIGHT,
};
const LINE: usize = 3 * UNIT;
/// Lines below each picture: its name, and two of facts.
const LINES: usize = 3;
/// Height of the curves with the gap above them.
const CURVES: usize = 48 * UNIT;

/// Lays out pictures in a row, all shown alike, with the curves of both errors below.
#[must_use]
pub fn race_sheet(sheet: &RaceSheet<'_>) -> Pixels8 {
    let (width, height) = size(sheet.reference.0);
    let pitch = width.max(NARROWEST) + GUTTER;
    let n = sheet.pictures.len() + 1;
    let top = MARGIN + HEADING;
    let below = top + height + LINES * LINE + 2 * UNIT;
    let curves: Vec<_> = sheet.pictures.iter().map(|p| p.curve).collect();
    let room = n * pitch - GUTTER;
    let has_curves = curves.iter().any(|curve| curve.len() > 1);
    let page = (
        2 * MARGIN + room,
        below + if has_curves { CURVES } else { 0 } + MARGIN,
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
    let [title, subtitle] = sheet.heading;
    write(
        &mut canvas,
        title,
        room,
        (MARGIN, MARGIN + 3 * UNIT),
        &TITLE,
    );
    write(
        &mut canvas,
        subtitle,
        room,
        (MARGIN, MARGIN + 7 * UNIT),
        &SUBTITLE,
    );
    let methods = sheet.pictures.iter().map(|picture| {
        let facts = picture.curve.last().map(Point::facts);
        let facts = facts.map_or_else(Vec::new, Vec::from);
        (picture.image, picture.name, facts)
    });
    let (image, fact) = sheet.reference;
    let reference = (image, "reference", vec![fact.to_owned()]);
    for (i, (image, name, facts)) in methods.chain([reference]).enumerate() {
        let x = MARGIN + i * pitch;
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
            pixels: &image.pixels,
            size: (image.width, image.height),
        };
        canvas.picture(rect, &source, &sheet.display);
        let mut y = top + height + LINE;
        let room = pitch - GUTTER;
        let is_method = i + 1 < n;
        let indent = if has_curves && is_method { 2 * UNIT } else { 0 };
        if let Some(colour) = colours(true).get(i).filter(|_| indent > 0) {
            let dot = (x as f32 + 6.0, y as f32 - 6.0);
            canvas.line([dot, dot], 10.0, *colour);
        }
        write(&mut canvas, name, room - indent, (x + indent, y), &NAME);
        for fact in facts {
            y += LINE;
            write(&mut canvas, &fact, room, (x, y), &SHARE);
        }
    }
    if has_curves {
        let width = (room - GUTTER) / 2;
        for (i, measure) in Measure::ALL.into_iter().enumerate() {
            let part = Rect {
                x: MARGIN + i * (width + GUTTER),
                y: below + 2 * UNIT,
                width,
                height: CURVES - 2 * UNIT,
            };
            let mut page = Page {
                canvas: &mut canvas,
                typesetter: &typesetter,
            };
            curves::draw(&mut page, part, &curves, measure, &curves::ON_SHEETS);
        }
    }
    canvas.into_pixels()
}

/// How large each picture is shown: as it is, or smaller.
fn size(image: &Image) -> (usize, usize) {
    let edge = (2 * EDGE) as f32;
    let scale = (edge / image.width.max(image.height).max(1) as f32).min(1.0);
    let scaled = |n: usize| ((n as f32 * scale).round() as usize).max(1);
    (scaled(image.width), scaled(image.height))
}
