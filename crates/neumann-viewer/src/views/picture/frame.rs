//! The frame of a region, and of the rectangle that is being drawn for one.

use egui::{Painter, Rect, StrokeKind};

use crate::display::ViewSettings;
use crate::display::image_area::Placement;
use crate::region;
use crate::session::Session;
use crate::theme::Palette;

/// Draws it over the picture.
pub(super) fn show(
    painter: &Painter,
    placement: &Placement,
    session: &Session,
    settings: &ViewSettings,
    p: &Palette,
) {
    let setup = &session.setup;
    let drawn = settings.drawing.and_then(|drawn| drawn.region(setup.size));
    if let Some(region) = setup.region {
        frame(painter, region::rect(placement, Some(&region)), p);
    }
    if let Some(region) = drawn {
        frame(painter, region::rect(placement, Some(&region)), p);
    }
}

/// Two lines beside each other, so that one of them shows on any picture; they cover nothing of
/// what is within.
fn frame(painter: &Painter, rect: Rect, p: &Palette) {
    painter.rect_stroke(rect, 0, (2.0, p.ground), StrokeKind::Outside);
    painter.rect_stroke(rect, 0, (1.0, p.amber), StrokeKind::Outside);
}
