//! Where two methods agree: a map for each term, with what its colours mean.

use super::canvas::{Canvas, Rect};
use super::text::{Align, Face, Style, Typesetter};
use super::{
    BRIGHT, FORMULA, FRAME, GROUND, GUTTER, HEADING, MARGIN, NOTE, PLAIN, SHARE, SUBTITLE, TITLE,
    UNIT, WORDS, formula,
};
use crate::agreement::{Agreement, FULL_COLOUR, Grain, Term, colour, map};
use crate::figures::significant;
use crate::png_file::Pixels8;

/// What is laid out.
#[derive(Clone, Debug)]
pub struct AgreementSheet<'a> {
    /// A name, such as that of the scene, and a line on how the maps were made.
    pub heading: [&'a str; 2],
    /// What the methods are called.
    pub names: [&'a str; 2],
    /// Bounce layers of their films.
    pub n_layers: usize,
    /// The scores.
    pub agreement: &'a Agreement,
    /// What has a colour of its own.
    pub grain: Grain,
    /// What follows from them, a line each.
    pub lines: &'a [String],
}

/// Maps in a row.
const COLUMNS: usize = 5;
/// Longer edge of a map.
const EDGE: usize = 36 * UNIT;
/// Its narrowest; what is said of it has no less room.
const NARROWEST: usize = 20 * UNIT;
const LINE: usize = 3 * UNIT;
const LABEL: usize = 3 * LINE + UNIT;
const BAR: Rect = Rect {
    x: MARGIN,
    y: 0,
    width: 50 * UNIT,
    height: 2 * UNIT,
};
/// Room for words beside the scale.
const WORDS_BESIDE: usize = 24 * UNIT;
/// The legend: the scale, its numbers and its words.
const LEGEND: usize = BAR.height + 2 * LINE + UNIT;

const VERDICT: Style = Style {
    face: Face::SemiBold,
    size: 15.0,
    colour: BRIGHT,
};
const ALARM: Style = Style {
    face: Face::SemiBold,
    size: 16.0,
    colour: BRIGHT,
};

/// Lays out the maps of all terms.
#[must_use]
pub fn agreement_sheet(sheet: &AgreementSheet<'_>) -> Pixels8 {
    let terms = &sheet.agreement.terms;
    let tile = tile(sheet.agreement.cells.size());
    let columns = COLUMNS.min(terms.len().max(1));
    let row = tile.1 + LABEL;
    let top = MARGIN + HEADING;
    let legend = top + terms.len().div_ceil(COLUMNS) * row + UNIT;
    let width = columns * (tile.0 + GUTTER) - GUTTER;
    let content = width.max(BAR.width + GUTTER + WORDS_BESIDE);
    let below = legend + LEGEND;
    let page = (
        content + 2 * MARGIN,
        below + sheet.lines.len() * LINE + MARGIN,
    );
    let mut page = Page {
        canvas: Canvas::new(page.0, page.1, GROUND),
        typesetter: Typesetter::new(),
    };
    let headings = sheet.heading.iter().zip([(&TITLE, 3), (&SUBTITLE, 7)]);
    for (text, (style, down)) in headings {
        page.left((MARGIN, MARGIN + down * UNIT), content, text, style);
    }
    for (i, term) in terms.iter().enumerate() {
        let x = MARGIN + i % COLUMNS * (tile.0 + GUTTER);
        let y = top + i / COLUMNS * row;
        page.term(sheet, term, (x, y), tile);
    }
    page.legend(sheet, legend);
    for (i, line) in sheet.lines.iter().enumerate() {
        let style = if i == 0 { &VERDICT } else { &WORDS };
        page.left((MARGIN, below + (i + 1) * LINE), content, line, style);
    }
    page.canvas.into_pixels()
}

struct Page {
    canvas: Canvas,
    typesetter: Typesetter,
}

impl Page {
    fn left(&mut self, at: (usize, usize), room: usize, text: &str, style: &Style) {
        let text = self.typesetter.shortened(text, style, room as f32);
        self.write(at, Align::Left, &text, style);
    }

    fn write(&mut self, (x, y): (usize, usize), align: Align, text: &str, style: &Style) {
        let at = (x as f32, y as f32);
        self.typesetter
            .write(&mut self.canvas, text, at, align, style);
    }

    fn term(
        &mut self,
        sheet: &AgreementSheet<'_>,
        term: &Term,
        (x, y): (usize, usize),
        (width, height): (usize, usize),
    ) {
        let frame = Rect {
            x: x - 1,
            y: y - 1,
            width: width + 2,
            height: height + 2,
        };
        self.canvas.fill(frame, FRAME);
        let map = scaled(&map(sheet.agreement, term, sheet.grain), width, height);
        self.canvas.paste(x, y, &map);
        let base = y + height + LINE + 2;
        let right = x + width;
        self.write(
            (x, base),
            Align::Left,
            &formula(term.view, sheet.n_layers),
            &FORMULA,
        );
        let [a, b] = term.means;
        let ratio = if a > 0.0 && b > 0.0 {
            format!("× {:.4}", a / b)
        } else {
            format!("black by {}", sheet.names[usize::from(a > 0.0)])
        };
        self.write((right, base), Align::Right, &ratio, &SHARE);
        let Some((_, largest)) = term.largest() else {
            self.left(
                (x, base + LINE),
                width,
                "not judged: light is too rare",
                &NOTE,
            );
            return;
        };
        let score = significant(largest.deviations.abs(), 2);
        let text = format!("score up to {score}");
        self.write((x, base + LINE), Align::Left, &text, &NOTE);
        if term.n_beyond == 0 {
            self.write((right, base + LINE), Align::Right, "noise", &NOTE);
            return;
        }
        let style = Style {
            colour: colour(FULL_COLOUR.copysign(largest.deviations as f32)),
            ..ALARM
        };
        let text = format!("{} of {} cells", term.n_beyond, term.n_judged());
        self.write((right, base + LINE), Align::Right, &text, &style);
    }

    /// The scale, with the limits on it.
    fn legend(&mut self, sheet: &AgreementSheet<'_>, top: usize) {
        let bar = Rect { y: top, ..BAR };
        for column in 0..bar.width {
            let t = (column as f32 + 0.5) / bar.width as f32;
            let line = Rect {
                x: bar.x + column,
                width: 1,
                ..bar
            };
            self.canvas
                .fill(line, colour((2.0 * t - 1.0) * FULL_COLOUR));
        }
        let limit = sheet.agreement.limit as f32;
        let numbers = top + bar.height + 2 * UNIT + 4;
        for (limits, sign) in [
            (-FULL_COLOUR, "−"),
            (-1.0, "−"),
            (0.0, ""),
            (1.0, ""),
            (FULL_COLOUR, ""),
        ] {
            let x = bar.x as f32 + (0.5 + 0.5 * limits / FULL_COLOUR) * bar.width as f32;
            let is_end = limits.abs() >= FULL_COLOUR;
            if !is_end && limits != 0.0 {
                let tick = Rect {
                    x: x as usize,
                    width: 1,
                    ..bar
                };
                self.canvas.fill(tick, PLAIN);
            }
            let align = match (is_end, limits > 0.0) {
                (true, true) => Align::Right,
                (true, false) => Align::Left,
                _ => Align::Centre,
            };
            let number = significant(f64::from(limits.abs() * limit), 2);
            let text = format!("{sign}{number}");
            self.write((x as usize, numbers), align, &text, &WORDS);
        }
        let words = numbers + LINE;
        let [a, b] = sheet.names;
        let room = bar.width / 3;
        self.left((bar.x, words), room, &format!("{a} darker"), &NOTE);
        let middle = bar.x + bar.width / 2;
        self.write((middle, words), Align::Centre, "noise", &NOTE);
        let right = self
            .typesetter
            .shortened(&format!("{a} brighter"), &NOTE, room as f32);
        self.write((bar.x + bar.width, words), Align::Right, &right, &NOTE);
        let beside = bar.x + bar.width + GUTTER;
        self.left(
            (beside, numbers),
            WORDS_BESIDE,
            "standard deviations",
            &NOTE,
        );
        self.left((beside, words), WORDS_BESIDE, &format!("than {b}"), &NOTE);
    }
}

/// Size of a map on the sheet.
fn tile((width, height): (usize, usize)) -> (usize, usize) {
    let scaled = |n: usize| (n * EDGE).div_ceil(width.max(height)).max(1);
    let tile = (scaled(width), scaled(height));
    if tile.0 < NARROWEST {
        (NARROWEST, tile.1 * NARROWEST / tile.0)
    } else {
        tile
    }
}

/// A picture made larger pixel by pixel, or smaller by averages of what is shown.
pub(super) fn scaled(source: &Pixels8, width: usize, height: usize) -> Pixels8 {
    let span = |i: usize, n: usize, length: usize| {
        let start = i * length / n;
        start..((i + 1) * length / n).max(start + 1)
    };
    let pixels = (0..width * height).map(|pixel| {
        let mut sum = [0u32; 3];
        let mut n = 0;
        for y in span(pixel / width, height, source.height) {
            for x in span(pixel % width, width, source.width) {
                for (sum, code) in sum.iter_mut().zip(source.pixels[y * source.width + x]) {
                    *sum += u32::from(code);
                }
                n += 1;
            }
        }
        sum.map(|sum| ((sum + n / 2) / n) as u8)
    });
    Pixels8 {
        width,
        height,
        pixels: pixels.collect(),
    }
}

#[cfg(test)]
mod tests {
    use neumann_core::film::Film;
    use neumann_core::radiometry::Rgb;

    use super::super::{HEADING, MARGIN};
    use super::{AgreementSheet, agreement_sheet, scaled, tile};
    use crate::agreement::{Agreement, Batches, Grain, colour};
    use crate::png_file::Pixels8;

    /// Batches of a uniform picture of two layers, with some noise.
    fn batches(size: (usize, usize), value: f32) -> Batches {
        let mut batches = Batches::new(size.0, size.1, 1);
        for i in 0..16 {
            let noise = 1.0 + 0.01 * ((i * 7 % 16) as f32 - 7.5) / 7.5;
            let n = size.0 * size.1;
            let layers = vec![vec![Rgb::WHITE; n], vec![Rgb::splat(value * noise); n]];
            let total = vec![Rgb::splat(1.0 + value * noise); n];
            let film = Film::from_parts(size, 1, layers, total, &vec![Rgb::BLACK; n], 0);
            batches.take(&film.unwrap());
        }
        batches
    }

    fn page(size: (usize, usize), values: [f32; 2]) -> Pixels8 {
        let [a, b] = values.map(|value| batches(size, value));
        agreement_sheet(&AgreementSheet {
            heading: ["cornell", "by two methods"],
            names: ["pt-mis", "bdpt"],
            n_layers: 1,
            agreement: &Agreement::of([&a, &b], 0.01),
            grain: Grain::Blocks,
            lines: &["They disagree.".to_owned()],
        })
    }

    #[test]
    fn what_disagrees_has_a_colour_on_its_map_and_nothing_else_has() {
        let page = page((16, 16), [1.0, 2.0]);
        let at = |x: usize, y: usize| page.pixels[y * page.width + x];
        let (width, _) = tile((16, 16));
        let y = MARGIN + HEADING + 20;
        let [r, g, b] = at(MARGIN + 20, y);
        assert!(r == g && g == b, "the first term is the same");
        let second = at(MARGIN + width + super::GUTTER + 20, y);
        assert!(second[2] > second[0] + 50, "darker is blue: {second:?}");
        assert_ne!(colour(0.0), second);
    }

    #[test]
    fn odd_shapes_and_black_terms_are_laid_out() {
        for size in [(1, 1), (3, 400), (400, 3)] {
            let page = page(size, [0.0, 1.0]);
            assert_eq!(page.pixels.len(), page.width * page.height);
        }
    }

    #[test]
    fn maps_are_scaled_by_whole_pixels_or_by_averages() {
        let source = Pixels8 {
            width: 2,
            height: 1,
            pixels: vec![[0; 3], [100; 3]],
        };
        assert_eq!(scaled(&source, 1, 1).pixels, [[50; 3]]);
        let large = scaled(&source, 4, 2).pixels;
        let row = [[0; 3], [0; 3], [100; 3], [100; 3]];
        assert_eq!(large, [row, row].concat());
    }
}
