//! The caption on the picture: the part of the series as a formula and in words, and what the
//! method cannot see of it.

use egui::{Painter, Rect, Vec2};
use neumann_core::film::View as Part;

use crate::blind_spots;
use crate::display::ViewSettings;
use crate::formula::Formula;
use crate::session::Session;
use crate::theme::{self, GRID, Palette};

/// Draws the caption in the upper left corner of `rect`.
pub(super) fn show(
    painter: &Painter,
    rect: Rect,
    session: &Session,
    settings: &ViewSettings,
    p: &Palette,
) {
    let part = settings.part;
    let (formula, text) = if settings.is_difference && session.picture.reference.is_some() {
        (None, "difference to the reference, in luminance".to_owned())
    } else if part.layers(session.picture.n_layers).is_none() {
        (
            Some(part),
            "not kept apart; raise the number of terms".to_owned(),
        )
    } else {
        (Some(part), part.caption())
    };
    let at = rect.min + Vec2::new(2.0 * GRID, 1.5 * GRID);
    let formula = formula.map(|part: Part| Formula::full(painter, part, theme::CAPTION, p.text));
    let below = formula
        .as_ref()
        .map_or(0.0, |f| theme::CAPTION * 1.15 + f.size.y * 0.22);
    let galley = painter.layout_no_wrap(text, theme::body(), p.text);
    let note = blind_spots_of(session, settings).map(|note| {
        let room = rect.width() - 6.0 * GRID;
        painter.layout(note, theme::small(), p.weak, room)
    });
    let width = formula
        .as_ref()
        .map_or(0.0, |f| f.size.x)
        .max(galley.size().x)
        .max(note.as_ref().map_or(0.0, |n| n.size().x));
    let note_top = below + galley.size().y + 2.0;
    let height = note
        .as_ref()
        .map_or(note_top - 2.0, |n| note_top + n.size().y);
    let spot = Rect::from_min_size(at, Vec2::new(width, height));
    painter.rect_filled(spot.expand2(Vec2::new(GRID, 6.0)), 6, theme::plate(p));
    if let Some(formula) = formula {
        formula.paint(painter, at);
    }
    painter.galley(at + Vec2::new(0.0, below), galley, p.text);
    if let Some(note) = note {
        painter.galley(at + Vec2::new(0.0, note_top), note, p.weak);
    }
}

/// What the method on screen cannot see of this part, if the picture is of it.
fn blind_spots_of(session: &Session, settings: &ViewSettings) -> Option<String> {
    let open = session.setup.open.as_ref()?;
    if settings.is_difference || !session.is_current() {
        return None;
    }
    blind_spots::note(
        session.setup.method().sight,
        open.scene.appearance(),
        settings.part,
        session.picture.n_layers,
    )
}
