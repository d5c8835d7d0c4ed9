//! The series on one sheet: the terms in one row, the partial sums below them.
//!
//! `L = L_e + T L_e + T²L_e + …`: each picture has its formula and its share of the
//! energy (of the mean luminance of L). All of them are shown with the same exposure,
//! on a ground without hue, so that they can be compared by eye.

mod agreement;
pub(crate) mod board;
mod canvas;
pub(crate) mod curves;
mod hemisphere;
mod label;
mod lobe;
mod photons;
mod picture;
mod race;
mod radius_bias;
mod techniques;
pub(crate) mod text;

use neumann_core::film::{Film, View};
use neumann_core::radiometry::Rgb;

use crate::exr_file::Metadata;
use crate::png_file::Pixels8;
use crate::tone::Display;
use canvas::{Canvas, Thumbnail};
use label::percent;
use text::{Align, Face, Style, Typesetter};

pub(crate) use canvas::Rect;

pub use agreement::{AgreementSheet, agreement_sheet};
pub use hemisphere::{HemisphereSheet, hemisphere_sheet};
pub use label::formula;
pub use lobe::{LobeSheet, lobe_sheet};
pub use photons::photon_sheet;
pub use picture::{PictureSheet, Scale, Stroke, Wipe, picture_sheet};
pub use race::{RacePicture, RaceSheet, race_sheet};
pub use radius_bias::{RadiusBiasSheet, radius_bias_sheet};
pub use techniques::{technique_name, technique_sheet};

/// What stands on the sheet beside the pictures.
#[derive(Clone, Debug, Default)]
pub struct SheetInfo {
    /// Heading: the scene.
    pub title: String,
    /// The line below it: how it was made.
    pub subtitle: String,
    /// How the pictures are shown.
    pub display: Display,
    /// Terms beyond this power are not computed, and left out.
    pub max_bounces: u32,
}

impl SheetInfo {
    /// What a film's metadata say.
    #[must_use]
    pub fn of(film: &Film, metadata: &Metadata, display: Display) -> Self {
        let sign = if display.exposure_ev < 0.0 {
            "−"
        } else {
            "+"
        };
        Self {
            title: metadata.scene.clone(),
            subtitle: format!(
                "{} · {}×{} · exposure {sign}{:.1} EV · tone {}",
                metadata.summary(),
                film.width(),
                film.height(),
                display.exposure_ev.abs(),
                display.tone
            ),
            display,
            max_bounces: metadata.max_bounces,
        }
    }
}

/// Lays out the series of a film.
#[must_use]
pub fn sheet(film: &Film, info: &SheetInfo) -> Pixels8 {
    let columns = columns(film, info.max_bounces);
    let layout = Layout::new(film, columns.len());
    let typesetter = Typesetter::new();
    let mut page = Page {
        canvas: Canvas::new(layout.width, layout.height, GROUND),
        typesetter: &typesetter,
        layout: &layout,
    };
    page.heading(info);
    page.rows(film, &columns, info);
    page.canvas.into_pixels()
}

/// Greys without hue.
const GROUND: [u8; 3] = [0x16; 3];
const MAT: [u8; 3] = [0x26; 3];
const QUIET: [u8; 3] = [0x8c; 3];
const PLAIN: [u8; 3] = [0xc8; 3];
const BRIGHT: [u8; 3] = [0xf2; 3];

/// The grid, pixels.
const UNIT: usize = 8;
const MARGIN: usize = 6 * UNIT;
const GUTTER: usize = 4 * UNIT;
const HEADING: usize = 10 * UNIT;
const ROW_TITLE: usize = 4 * UNIT;
const LABEL: usize = 6 * UNIT;
const ROW_GAP: usize = 4 * UNIT;
/// Longer edge of a picture on the sheet.
const EDGE: usize = 32 * UNIT;
/// A narrower picture would be narrower than its label.
const NARROWEST: usize = 20 * UNIT;
/// No sheet is wider than this, as far as the narrowest pictures allow.
const WIDEST: usize = 8192;

const TITLE: Style = Style {
    face: Face::SemiBold,
    size: 28.0,
    colour: BRIGHT,
};
const SUBTITLE: Style = Style {
    face: Face::Regular,
    size: 16.0,
    colour: QUIET,
};
/// Words beside and below a picture, and what is less to be read.
const WORDS: Style = Style {
    face: Face::Regular,
    size: 15.0,
    colour: PLAIN,
};
const NOTE: Style = Style {
    face: Face::Regular,
    size: 15.0,
    colour: QUIET,
};
/// A frame around a picture: a black edge would not be told from the ground.
const FRAME: [u8; 3] = [0x30; 3];
const FORMULA: Style = Style {
    face: Face::SemiBold,
    size: 18.0,
    colour: BRIGHT,
};
const SHARE: Style = Style {
    face: Face::Regular,
    size: 16.0,
    colour: PLAIN,
};
const OPERATOR: Style = Style {
    face: Face::Regular,
    size: 22.0,
    colour: QUIET,
};

/// One term and the partial sum up to it.
struct Column {
    term: View,
    sum: View,
    share: f64,
    share_so_far: f64,
}

fn columns(film: &Film, max_bounces: u32) -> Vec<Column> {
    let n_layers = film.n_layers();
    let shares = film.energy_shares();
    let mut share_so_far = 0.0;
    let n_terms = n_layers.min(max_bounces as usize + 1);
    let has_tail = max_bounces as usize >= n_layers;
    (0..n_terms)
        .chain(has_tail.then_some(n_layers))
        .map(|k| {
            let share = shares.get(k).copied().unwrap_or(0.0);
            share_so_far += share;
            let is_last = k + 1 == n_terms + usize::from(has_tail);
            Column {
                term: if k == n_layers {
                    View::Tail
                } else {
                    View::Term(k)
                },
                sum: if is_last { View::Total } else { View::Upto(k) },
                share,
                share_so_far,
            }
        })
        .collect()
}

struct Layout {
    cell: (usize, usize),
    width: usize,
    height: usize,
}

impl Layout {
    fn new(film: &Film, n_columns: usize) -> Self {
        let room = WIDEST.saturating_sub(2 * MARGIN + (n_columns - 1) * GUTTER) / n_columns;
        let edge = EDGE.min(room);
        let longer = film.width().max(film.height()).max(1);
        let scaled = |n: usize| (n * edge).div_ceil(longer).max(1);
        let mut cell = (scaled(film.width()), scaled(film.height()));
        if cell.0 < NARROWEST {
            cell = (NARROWEST, cell.1 * NARROWEST / cell.0);
        }
        let row = ROW_TITLE + cell.1 + LABEL;
        Self {
            cell,
            width: 2 * MARGIN + n_columns * cell.0 + (n_columns - 1) * GUTTER,
            height: 2 * MARGIN + HEADING + 2 * row + ROW_GAP,
        }
    }

    fn x(&self, column: usize) -> usize {
        MARGIN + column * (self.cell.0 + GUTTER)
    }

    /// Top of the pictures of row 0 or 1.
    fn y(&self, row: usize) -> usize {
        MARGIN + HEADING + ROW_TITLE + row * (ROW_TITLE + self.cell.1 + LABEL + ROW_GAP)
    }
}

struct Page<'a> {
    canvas: Canvas,
    typesetter: &'a Typesetter,
    layout: &'a Layout,
}

impl Page<'_> {
    fn heading(&mut self, info: &SheetInfo) {
        let baseline = (MARGIN + 3 * UNIT) as f32;
        let left = MARGIN as f32;
        let right = (self.layout.width - MARGIN) as f32;
        let equation = "L = Σ T^{k}L_{e}";
        let room = right - left - self.typesetter.width(equation, &TITLE) - GUTTER as f32;
        let title = self.typesetter.shortened(&info.title, &TITLE, room);
        self.write(&title, left, baseline, Align::Left, &TITLE);
        self.write(equation, right, baseline, Align::Right, &TITLE);
        let below = baseline + (4 * UNIT) as f32;
        let subtitle = self
            .typesetter
            .shortened(&info.subtitle, &SUBTITLE, right - left);
        self.write(&subtitle, left, below, Align::Left, &SUBTITLE);
    }

    fn rows(&mut self, film: &Film, columns: &[Column], info: &SheetInfo) {
        let titles = ["Terms", "Partial sums"];
        for (row, title) in titles.into_iter().enumerate() {
            let baseline = (self.layout.y(row) - 2 * UNIT) as f32;
            self.write(title, MARGIN as f32, baseline, Align::Left, &SUBTITLE);
        }
        let mut pixels = vec![Rgb::BLACK; film.n_pixels()];
        for (index, column) in columns.iter().enumerate() {
            let entries = [
                (column.term, column.share),
                (column.sum, column.share_so_far),
            ];
            for (row, (view, share)) in entries.into_iter().enumerate() {
                film.compose(view, &mut pixels);
                self.cell(row, index, film, &pixels, info);
                self.label(row, index, &formula(view, film.n_layers()), share);
            }
            if index > 0 {
                let x = self.layout.x(index) as f32 - GUTTER as f32 / 2.0;
                let y = (self.layout.y(0) + self.layout.cell.1 / 2) as f32 + 8.0;
                self.write("+", x, y, Align::Centre, &OPERATOR);
            }
        }
    }

    fn cell(&mut self, row: usize, column: usize, film: &Film, pixels: &[Rgb], info: &SheetInfo) {
        let source = Thumbnail {
            pixels,
            size: (film.width(), film.height()),
        };
        let rect = Rect {
            x: self.layout.x(column),
            y: self.layout.y(row),
            width: self.layout.cell.0,
            height: self.layout.cell.1,
        };
        self.canvas.picture(rect, &source, &info.display);
    }

    /// A bar as long as the share, the formula on the left, the figure on the right.
    fn label(&mut self, row: usize, column: usize, formula: &str, share: f64) {
        let (x, width) = (self.layout.x(column), self.layout.cell.0);
        let top = self.layout.y(row) + self.layout.cell.1 + UNIT;
        let bar = Rect {
            x,
            y: top,
            width,
            height: 2,
        };
        self.canvas.fill(bar, MAT);
        let filled = (share.clamp(0.0, 1.0) * width as f64).round() as usize;
        self.canvas.fill(
            Rect {
                width: filled,
                ..bar
            },
            PLAIN,
        );
        let baseline = (top + 3 * UNIT + 2) as f32;
        self.write(formula, x as f32, baseline, Align::Left, &FORMULA);
        let right = (x + width) as f32;
        self.write(&percent(share), right, baseline, Align::Right, &SHARE);
    }

    fn write(&mut self, text: &str, x: f32, baseline: f32, align: Align, style: &Style) {
        self.typesetter
            .write(&mut self.canvas, text, (x, baseline), align, style);
    }
}

#[cfg(test)]
mod tests {
    use neumann_core::film::{Film, View};
    use neumann_core::radiometry::Rgb;

    use super::{GROUND, Layout, SheetInfo, columns, sheet};

    /// A film of uniform layers `1/2^k`.
    fn film(width: usize, height: usize) -> Film {
        let n = width * height;
        let layers: Vec<Vec<Rgb>> = (0..4)
            .map(|k| vec![Rgb::splat(0.5f32.powi(k)); n])
            .collect();
        let total = vec![Rgb::splat(1.875); n];
        Film::from_parts((width, height), 1, layers, total, &vec![Rgb::BLACK; n], 0).unwrap()
    }

    fn info(max_bounces: u32) -> SheetInfo {
        SheetInfo {
            title: "furnace".to_owned(),
            subtitle: "pt-mis".to_owned(),
            max_bounces,
            ..SheetInfo::default()
        }
    }

    #[test]
    fn columns_are_the_terms_that_were_computed() {
        let film = film(8, 8);
        let all = columns(&film, 16);
        assert_eq!(all.len(), 4, "three terms and the tail");
        assert_eq!((all[3].term, all[3].sum), (View::Tail, View::Total));
        assert!((all[0].share - 8.0 / 15.0).abs() < 1e-6);
        assert!((all[3].share_so_far - 1.0).abs() < 1e-6);
        let two = columns(&film, 1);
        assert_eq!(two.len(), 2);
        assert_eq!((two[1].term, two[1].sum), (View::Term(1), View::Total));
    }

    #[test]
    fn pictures_stand_where_the_layout_says_and_nothing_has_a_hue() {
        let film = film(64, 32);
        let layout = Layout::new(&film, 4);
        let page = sheet(&film, &info(16));
        assert_eq!((page.width, page.height), (layout.width, layout.height));
        let at = |x: usize, y: usize| page.pixels[y * page.width + x];
        assert_eq!(at(1, 1), GROUND);
        let (cx, cy) = (layout.cell.0 / 2, layout.cell.1 / 2);
        let term = |k| at(layout.x(k) + cx, layout.y(0) + cy)[0];
        assert_eq!(term(0), 255);
        assert!(term(1) > term(2) && term(2) > term(3), "terms fade");
        let sum = |k| at(layout.x(k) + cx, layout.y(1) + cy)[0];
        assert_eq!((sum(0), sum(3)), (255, 255));
        assert!(page.pixels.iter().all(|[r, g, b]| r == g && g == b));
    }

    #[test]
    fn labels_are_drawn() {
        let film = film(64, 64);
        let layout = Layout::new(&film, 4);
        let page = sheet(&film, &info(16));
        let label = layout.y(0) + layout.cell.1 + 16..layout.y(0) + layout.cell.1 + 40;
        for column in 0..4 {
            let lit = label
                .clone()
                .flat_map(|y| (0..layout.cell.0).map(move |x| (x, y)))
                .filter(|(x, y)| page.pixels[y * page.width + layout.x(column) + x] != GROUND)
                .count();
            assert!(lit > 100, "column {column}: {lit}");
        }
    }

    #[test]
    fn odd_shapes_are_laid_out() {
        for (width, height) in [(1, 1), (2, 500), (500, 2)] {
            let page = sheet(&film(width, height), &info(0));
            assert_eq!(page.pixels.len(), page.width * page.height);
        }
    }
}
