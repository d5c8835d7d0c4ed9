//! A picture of photons with what explains its colours.
//!
//! The picture stands there pixel for pixel, since a photon is a point; the legend stands beside
//! it.

use neumann_core::photons::PhotonPicture;

use super::canvas::{Canvas, Rect};
use super::label::percent;
use super::text::{Align, Face, Style, Typesetter};
use super::{BRIGHT, FRAME, GROUND, GUTTER, HEADING, MARGIN, NOTE, SUBTITLE, TITLE, UNIT, WORDS};
use crate::photons::{PhotonColours, PhotonLook, PowerScale, facts};
use crate::png_file::Pixels8;

/// Width of the legend, pixels.
const LEGEND: usize = 32 * UNIT;
const ROW: usize = 3 * UNIT;
const SWATCH: usize = 2 * UNIT;

const NAME: Style = Style {
    face: Face::SemiBold,
    size: 16.0,
    colour: BRIGHT,
};

/// Lays out photons with their legend. The heading is a name, such as that of the scene, and a
/// line on how they were made.
#[must_use]
pub fn photon_sheet(
    photons: &PhotonPicture,
    scale: PowerScale,
    look: &PhotonLook,
    heading: [&str; 2],
) -> Pixels8 {
    let rows = Row::all(photons, scale, look);
    let (width, height) = (photons.width(), photons.height());
    let top = MARGIN + HEADING;
    let legend = rows.iter().map(|row| row.height()).sum::<usize>();
    let page = (
        2 * MARGIN + width + GUTTER + LEGEND,
        top + height.max(legend) + MARGIN,
    );
    let mut canvas = Canvas::new(page.0, page.1, GROUND);
    let typesetter = Typesetter::new();
    let room = (page.0 - 2 * MARGIN) as f32;
    let lines = [
        (heading[0], &TITLE, 3 * UNIT),
        (heading[1], &SUBTITLE, 7 * UNIT),
    ];
    for (text, style, below) in lines {
        let text = typesetter.shortened(text, style, room);
        let at = (MARGIN as f32, (MARGIN + below) as f32);
        typesetter.write(&mut canvas, &text, at, Align::Left, style);
    }
    let frame = Rect {
        x: MARGIN - 1,
        y: top - 1,
        width: width + 2,
        height: height + 2,
    };
    canvas.fill(frame, FRAME);
    canvas.paste(MARGIN, top, &look.pixels(photons, scale));
    let left = MARGIN + width + GUTTER;
    let mut y = top;
    for row in rows {
        row.draw(&mut canvas, &typesetter, (left, y));
        y += row.height();
    }
    canvas.into_pixels()
}

/// A line of the legend.
enum Row {
    Name(String),
    /// A colour, what it means, and a figure.
    Key([u8; 3], String, String),
    Note(String),
    Gap,
}

impl Row {
    fn all(photons: &PhotonPicture, scale: PowerScale, look: &PhotonLook) -> Vec<Self> {
        let mut rows = Vec::new();
        let note = |text: &str| Self::Note(text.to_owned());
        match look.colours {
            PhotonColours::Bounce => {
                rows.push(Self::Name("Bounce".to_owned()));
                let keys = look.bounce_keys(photons).into_iter();
                let shown = keys.filter(|key| key.is_shown);
                rows.extend(shown.map(|key| Self::Key(key.colour, key.name(), percent(key.share))));
                rows.push(Self::Gap);
                rows.push(note("brighter where more photons lie"));
            }
            PhotonColours::Power => {
                rows.push(Self::Name("Power in a pixel".to_owned()));
                let keys = look.power_keys(scale).into_iter();
                rows.extend(keys.map(|(colour, text)| Self::Key(colour, text, String::new())));
                rows.push(Self::Gap);
                rows.push(note("in the photons' own colours"));
            }
        }
        rows.extend(facts(photons).map(Self::Note));
        rows
    }

    fn height(&self) -> usize {
        match self {
            Self::Name(_) => ROW + UNIT,
            Self::Key(..) | Self::Note(_) => ROW,
            Self::Gap => UNIT,
        }
    }

    /// Draws it with its upper left corner at a place of the page.
    fn draw(&self, canvas: &mut Canvas, typesetter: &Typesetter, (x, y): (usize, usize)) {
        let baseline = (y + 2 * UNIT) as f32;
        let room = LEGEND as f32;
        match self {
            Self::Name(text) => {
                let at = (x as f32, baseline);
                typesetter.write(canvas, text, at, Align::Left, &NAME);
            }
            Self::Key(colour, name, figure) => {
                let outer = Rect {
                    x,
                    y: y + UNIT / 4,
                    width: SWATCH + 2,
                    height: SWATCH + 2,
                };
                let inner = Rect {
                    x: x + 1,
                    y: outer.y + 1,
                    width: SWATCH,
                    height: SWATCH,
                };
                canvas.fill(outer, FRAME);
                canvas.fill(inner, *colour);
                let at = ((x + SWATCH + UNIT + 2) as f32, baseline);
                typesetter.write(canvas, name, at, Align::Left, &WORDS);
                let at = ((x + 16 * UNIT) as f32, baseline);
                typesetter.write(canvas, figure, at, Align::Right, &NOTE);
            }
            Self::Note(text) => {
                let text = typesetter.shortened(text, &NOTE, room);
                let at = (x as f32, baseline);
                typesetter.write(canvas, &text, at, Align::Left, &NOTE);
            }
            Self::Gap => {}
        }
    }
}
