//! Names of views, set as formulas with true sub- and superscripts.
//!
//! `T²L_e` is four pieces of text on three baselines. The first is that of the line; exponents
//! stand above it and indices below, at 0.68 of its size.

use std::sync::Arc;

use egui::{Color32, Galley, Painter, Pos2, Role, Sense, Ui, Vec2, WidgetInfo};
use neumann_core::film::View;

use crate::theme;

/// Where a piece stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Line,
    Exponent,
    Index,
}

/// A formula, laid out and ready to paint.
pub struct Formula {
    pieces: Vec<(Vec2, Arc<Galley>)>,
    /// Size of its box; exponents and indices included.
    pub size: Vec2,
}

/// The baseline is this far below the top of a formula, as a share of the size.
pub(crate) const LINE_BASELINE: f32 = 1.15;
const SCRIPT_SIZE: f32 = 0.68;
const RAISE: f32 = 0.36;
const LOWER: f32 = 0.18;

impl Formula {
    /// The short name of a view, as under a thumbnail: `T²L_e`, `≤ 3`, `tail`, `L`.
    #[must_use]
    pub fn name(painter: &Painter, view: View, size: f32, color: Color32) -> Self {
        let mut text = Vec::new();
        match view {
            View::Total => text.push(("L".to_owned(), Place::Line)),
            View::Tail => text.push(("tail".to_owned(), Place::Line)),
            View::Term(k) => push_term(&mut text, k),
            View::Upto(k) => text.push((format!("≤ {k}"), Place::Line)),
        }
        Self::layout(painter, &text, size, color)
    }

    /// The full formula of a view, as on the picture: `L_e + … + T³L_e`.
    #[must_use]
    pub fn full(painter: &Painter, view: View, size: f32, color: Color32) -> Self {
        let View::Upto(last) = view else {
            return Self::name(painter, view, size, color);
        };
        let mut text = Vec::new();
        for k in 0..=last {
            let is_elided = last > 3 && k > 1 && k < last;
            if is_elided && k > 2 {
                continue;
            }
            if k > 0 {
                text.push((" + ".to_owned(), Place::Line));
            }
            if is_elided {
                text.push(("…".to_owned(), Place::Line));
            } else {
                push_term(&mut text, k);
            }
        }
        Self::layout(painter, &text, size, color)
    }

    /// `T^k L_e`, the general term.
    #[must_use]
    pub fn general_term(painter: &Painter, size: f32, color: Color32) -> Self {
        let text = [
            ("T".to_owned(), Place::Line),
            ("k".to_owned(), Place::Exponent),
            ("L".to_owned(), Place::Line),
            ("e".to_owned(), Place::Index),
        ];
        Self::layout(painter, &text, size, color)
    }

    /// A formula as it is typed: `_` is before an index, `^` before an exponent, of one word or, in
    /// braces, of anything.
    #[must_use]
    pub fn typed(painter: &Painter, text: &str, size: f32, color: Color32) -> Self {
        Self::layout(painter, &pieces(text), size, color)
    }

    /// Paints with the top left corner of its box at `at`.
    pub fn paint(&self, painter: &Painter, at: Pos2) {
        for (offset, galley) in &self.pieces {
            painter.galley(at + *offset, Arc::clone(galley), Color32::PLACEHOLDER);
        }
    }

    fn layout(painter: &Painter, text: &[(String, Place)], size: f32, color: Color32) -> Self {
        let line_baseline = size * LINE_BASELINE;
        let mut x = 0.0;
        let mut bottom: f32 = 0.0;
        let mut pieces = Vec::with_capacity(text.len());
        for (piece, place) in text {
            let (scale, shift) = match place {
                Place::Line => (1.0, 0.0),
                Place::Exponent => (SCRIPT_SIZE, -RAISE),
                Place::Index => (SCRIPT_SIZE, LOWER),
            };
            let font = theme::sized(size * scale);
            let galley = painter.layout_no_wrap(piece.clone(), font, color);
            let baseline = baseline_of(&galley).unwrap_or(size * scale);
            let y = line_baseline + size * shift - baseline;
            let width = galley.size().x;
            bottom = bottom.max(y + galley.size().y);
            pieces.push((Vec2::new(x, y), galley));
            // Scripts stand a little apart from what follows them.
            x += width
                + if *place == Place::Line {
                    0.0
                } else {
                    size * 0.05
                };
        }
        Self {
            pieces,
            size: Vec2::new(x, bottom),
        }
    }
}

/// Lines of formulas one below the other, made smaller where the widest has no room; read out as
/// they are typed.
pub fn lines(ui: &mut Ui, text: &str, color: Color32) {
    const SMALLEST: f32 = 0.7;
    let full = theme::small().size;
    let widest = |size| {
        let widths = text.lines().map(|line| {
            let formula = Formula::typed(ui.painter(), line.trim_start(), size, color);
            formula.size.x + indent(line, size)
        });
        widths.fold(0.0, f32::max)
    };
    let scale = (ui.available_width() / widest(full)).clamp(SMALLEST, 1.0);
    let size = full * scale;
    let step = (size * 1.6).round();
    let height = step * text.lines().count() as f32;
    let (rect, response) =
        ui.allocate_exact_size(Vec2::new(ui.available_width(), height), Sense::hover());
    for (line, y) in text.lines().zip(0..) {
        let at = rect.min + Vec2::new(indent(line, size), step * y as f32);
        let formula = Formula::typed(ui.painter(), line.trim_start(), size, color);
        formula.paint(ui.painter(), at);
    }
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, text));
}

/// How far a line is indented.
fn indent(line: &str, size: f32) -> f32 {
    let n_spaces = line.chars().take_while(|c| *c == ' ').count();
    n_spaces as f32 * size * 0.55
}

/// A typed formula, piece by piece.
fn pieces(text: &str) -> Vec<(String, Place)> {
    let mut pieces = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find(['_', '^']) {
        let place = if rest[at..].starts_with('_') {
            Place::Index
        } else {
            Place::Exponent
        };
        pieces.push((rest[..at].to_owned(), Place::Line));
        let script = &rest[at + 1..];
        let in_braces = script.strip_prefix('{').and_then(|s| s.split_once('}'));
        let (script, after) = in_braces.unwrap_or_else(|| {
            let is_over = |c: char| !c.is_alphabetic() && !c.is_ascii_digit();
            script.split_at(script.find(is_over).unwrap_or(script.len()))
        });
        pieces.push((script.to_owned(), place));
        rest = after;
    }
    pieces.push((rest.to_owned(), Place::Line));
    pieces.retain(|(piece, _)| !piece.is_empty());
    pieces
}

/// A view's name in plain text, for those who hear the window: `T^2 L_e`.
#[must_use]
pub fn spoken(view: View) -> String {
    match view {
        View::Total => "everything, L".to_owned(),
        View::Tail => "tail".to_owned(),
        View::Term(0) => "term L_e".to_owned(),
        View::Term(1) => "term T L_e".to_owned(),
        View::Term(k) => format!("term T^{k} L_e"),
        View::Upto(k) => format!("sum up to {k}"),
    }
}

fn push_term(text: &mut Vec<(String, Place)>, k: usize) {
    match k {
        0 => {}
        1 => text.push(("T ".to_owned(), Place::Line)),
        _ => {
            text.push(("T".to_owned(), Place::Line));
            text.push((k.to_string(), Place::Exponent));
        }
    }
    text.push(("L".to_owned(), Place::Line));
    text.push(("e".to_owned(), Place::Index));
}

/// How far the first baseline is below the top; `None` without a glyph.
pub(crate) fn baseline_of(galley: &Galley) -> Option<f32> {
    let row = galley.rows.first()?;
    let glyph = row.row.glyphs.first()?;
    Some(row.pos.y + glyph.pos.y)
}

#[cfg(test)]
mod tests {
    use super::{Place, pieces};

    #[test]
    fn scripts_are_a_word_or_what_is_in_braces() {
        let set = |text: &str| -> Vec<(String, Place)> { pieces(text) };
        let piece = |text: &str, place| (text.to_owned(), place);
        assert_eq!(
            set("w_{s,t} = p_ω² x^{α − 1} L_e"),
            [
                piece("w", Place::Line),
                piece("s,t", Place::Index),
                piece(" = p", Place::Line),
                piece("ω", Place::Index),
                piece("² x", Place::Line),
                piece("α − 1", Place::Exponent),
                piece(" L", Place::Line),
                piece("e", Place::Index),
            ]
        );
        // What has no end is no reason to stop.
        assert_eq!(set("x_{a")[0], piece("x", Place::Line));
    }
}
