//! The wipe between A and B: a line to drag, with what stands on either side of it.

use egui::{Align2, CursorIcon, Rect, Sense, Ui, Vec2, WidgetInfo, pos2};

use crate::compared::Side;
use crate::display::ViewSettings;
use crate::display::image_area::Placement;
use crate::theme::{self, GRID, Palette};

/// Draws the line over the picture and lets it be dragged.
pub(super) fn show(
    ui: &Ui,
    rect: Rect,
    placement: &Placement,
    sides: &[Side; 2],
    settings: &mut ViewSettings,
) {
    let p = Palette::of(ui);
    let film = placement.film;
    let x = film.left() + film.width() * settings.wipe;
    let grip = Rect::from_min_max(
        pos2(x - 6.0, placement.visible.top()),
        pos2(x + 6.0, placement.visible.bottom()),
    );
    let response = ui
        .interact(grip, ui.scope_id().with("wipe"), Sense::drag())
        .on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
    let spoken = "wipe line";
    response.widget_info(|| WidgetInfo::slider(true, f64::from(settings.wipe), spoken));
    let response = response.on_hover_text("Drag the line to see more of A or of B.");
    if let Some(at) = response.interact_pointer_pos() {
        settings.wipe = ((at.x - film.left()) / film.width()).clamp(0.0, 1.0);
    }
    let painter = ui.painter().with_clip_rect(rect);
    painter.vline(x.round() + 0.5, grip.y_range(), (1.0, p.amber));
    let [a, b] = sides
        .each_ref()
        .map(|side| format!("{}  {}", side.name, side.label()));
    let y = placement.visible.bottom() - GRID;
    let (left, right) = (pos2(x - GRID, y), pos2(x + GRID, y));
    for (label, at, align) in [
        (a, left, Align2::RIGHT_BOTTOM),
        (b, right, Align2::LEFT_BOTTOM),
    ] {
        let galley = painter.layout_no_wrap(label, theme::small(), p.text);
        let spot = align.anchor_size(at, galley.size());
        painter.rect_filled(spot.expand2(Vec2::new(6.0, 3.0)), 4, theme::plate(&p));
        painter.galley(spot.min, galley, p.text);
    }
}
