//! The techniques of a method on one sheet: Veach's pyramid.
//!
//! One row for each bounce; in it the ways to cut the path in two, from s = 0 on the left (the
//! camera's walk found the light) on, then the merges. A column keeps its s, and dark rows are
//! brightened. The pyramid stands there three times: as each technique counts, as each would be
//! alone, and how much each weighs.

use neumann_core::film::{Joint, Strategy, TechniqueFilm, TechniqueImage, TechniqueTable};

use super::canvas::{Canvas, Rect, Thumbnail};
use super::label::percent;
use super::text::{Align, Face, Style, Typesetter};
use super::{
    BRIGHT, FRAME, GROUND, HEADING, MARGIN, PLAIN, QUIET, SUBTITLE, SheetInfo, TITLE, UNIT,
};
use crate::png_file::Pixels8;
use crate::tone::Display;

const GUTTER: usize = 2 * UNIT;
const LABEL: usize = 4 * UNIT;
const BLOCK_TITLE: usize = 6 * UNIT;
/// Between the connections of a row and its merges.
const MERGE_GAP: usize = 4 * UNIT;
/// Width of the names of rows.
const ROW_NAME: usize = 8 * UNIT;
const EDGE: usize = 16 * UNIT;
const NARROWEST: usize = 13 * UNIT;

const BLOCK: Style = Style {
    face: Face::SemiBold,
    size: 18.0,
    colour: BRIGHT,
};
const NAME: Style = Style {
    face: Face::Regular,
    size: 13.0,
    colour: PLAIN,
};
const SHARE: Style = Style {
    face: Face::Regular,
    size: 13.0,
    colour: QUIET,
};

/// What a technique is called: `s1 t2`, or `s2 + t2` for a merge.
#[must_use]
pub fn technique_name(strategy: Strategy) -> String {
    let Strategy { s, t, joint } = strategy;
    match joint {
        Joint::Hit | Joint::Connect => format!("s{s} t{t}"),
        Joint::Merge => format!("s{s} + t{t}"),
    }
}

/// Lays out everything that a technique film holds.
#[must_use]
pub fn technique_sheet(film: &TechniqueFilm, info: &SheetInfo) -> Pixels8 {
    let table = film.table();
    let layout = Layout::new(film, &table);
    let typesetter = Typesetter::new();
    let mut canvas = Canvas::new(layout.width, layout.height, GROUND);
    let write = |canvas: &mut Canvas, text: &str, (x, y): (usize, usize), align, style: &Style| {
        typesetter.write(canvas, text, (x as f32, y as f32), align, style);
    };
    let baseline = MARGIN + 3 * UNIT;
    write(
        &mut canvas,
        &info.title,
        (MARGIN, baseline),
        Align::Left,
        &TITLE,
    );
    let below = (MARGIN, baseline + 4 * UNIT);
    write(&mut canvas, &info.subtitle, below, Align::Left, &SUBTITLE);
    for (block, image) in TechniqueImage::ALL.into_iter().enumerate() {
        let top = layout.block(block);
        let title = match image {
            TechniqueImage::Weighted => "As each technique counts: these add up to L",
            TechniqueImage::Raw => "As each technique would be alone",
            TechniqueImage::Weight => "What each technique weighs",
        };
        let at = (MARGIN, top + 3 * UNIT);
        write(&mut canvas, title, at, Align::Left, &BLOCK);
        for (k, row) in table.rows.iter().enumerate() {
            let y = top + BLOCK_TITLE + k * (layout.cell.1 + LABEL);
            let middle = (MARGIN, y + layout.cell.1 / 2);
            write(&mut canvas, &format!("k = {k}"), middle, Align::Left, &NAME);
            let display = match image {
                TechniqueImage::Weight => Display::default(),
                TechniqueImage::Weighted | TechniqueImage::Raw => Display {
                    exposure_ev: info.display.exposure_ev + f32::from(row.gain),
                    ..info.display
                },
            };
            if image != TechniqueImage::Weight && row.gain > 0 {
                let below = (MARGIN, middle.1 + 2 * UNIT);
                let gain = format!("+{} EV", row.gain);
                write(&mut canvas, &gain, below, Align::Left, &SHARE);
            }
            for cell in &row.cells {
                let strategy = cell.strategy;
                let x = layout.x(cell.column);
                let rect = Rect {
                    x,
                    y,
                    width: layout.cell.0,
                    height: layout.cell.1,
                };
                if cell.is_made {
                    let pixels = film.image(strategy, image);
                    let source = Thumbnail {
                        pixels: &pixels,
                        size: (film.width(), film.height()),
                    };
                    canvas.picture(rect, &source, &display);
                } else {
                    canvas.fill(rect, FRAME);
                    canvas.fill(rect.inner(), GROUND);
                }
                let line = y + layout.cell.1 + 2 * UNIT;
                let name = technique_name(strategy);
                write(&mut canvas, &name, (x, line), Align::Left, &NAME);
                if image == TechniqueImage::Weighted && cell.is_made {
                    let share = percent(cell.share);
                    write(
                        &mut canvas,
                        &share,
                        (x + layout.cell.0, line),
                        Align::Right,
                        &SHARE,
                    );
                }
            }
        }
    }
    canvas.into_pixels()
}

struct Layout {
    first_merge: Option<usize>,
    cell: (usize, usize),
    width: usize,
    height: usize,
    block_height: usize,
}

impl Layout {
    fn new(film: &TechniqueFilm, table: &TechniqueTable) -> Self {
        let longer = film.width().max(film.height()).max(1);
        let scaled = |n: usize| (n * EDGE).div_ceil(longer).max(1);
        let mut cell = (scaled(film.width()), scaled(film.height()));
        if cell.0 < NARROWEST {
            cell = (NARROWEST, (cell.1 * NARROWEST / cell.0).min(2 * EDGE));
        }
        let gap = table.first_merge.map_or(0, |_| MERGE_GAP);
        let widest = ROW_NAME + table.n_columns * (cell.0 + GUTTER) + gap;
        let block_height = BLOCK_TITLE + table.rows.len() * (cell.1 + LABEL) + 4 * UNIT;
        Self {
            first_merge: table.first_merge,
            cell,
            width: 2 * MARGIN + widest.max(80 * UNIT),
            height: 2 * MARGIN + HEADING + TechniqueImage::ALL.len() * block_height,
            block_height,
        }
    }

    fn block(&self, block: usize) -> usize {
        MARGIN + HEADING + block * self.block_height
    }

    /// Left edge of a column.
    fn x(&self, column: usize) -> usize {
        let is_merge = self.first_merge.is_some_and(|first| column >= first);
        let gap = if is_merge { MERGE_GAP } else { 0 };
        MARGIN + ROW_NAME + column * (self.cell.0 + GUTTER) + gap
    }
}
