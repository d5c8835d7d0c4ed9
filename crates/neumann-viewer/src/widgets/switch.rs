//! On or off.

use egui::{Align2, Response, Role, Sense, Ui, Vec2, WidgetInfo};

use super::focus_ring;
use crate::theme::{self, Palette, ROW};

/// A name on the left and a switch on the right; the whole row can be clicked.
pub fn switch(ui: &mut Ui, name: &str, is_on: &mut bool) -> Response {
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), ROW);
    let (rect, mut response) = ui.allocate_exact_size(size, Sense::click());
    if response.clicked() {
        *is_on = !*is_on;
        response.mark_changed();
    }
    let color = if ui.is_enabled() { p.text } else { p.weak };
    let painter = ui.painter();
    painter.with_clip_rect(rect).text(
        rect.left_center(),
        Align2::LEFT_CENTER,
        name,
        theme::body(),
        color,
    );
    let track = egui::Rect::from_min_size(
        egui::pos2(rect.right() - 28.0, rect.center().y - 8.0),
        Vec2::new(28.0, 16.0),
    );
    painter.rect_filled(track, 8, if *is_on { p.fill } else { p.line });
    let x = if *is_on {
        track.right() - 8.0
    } else {
        track.left() + 8.0
    };
    let knob = if *is_on { p.strong } else { p.weak };
    let knob = if ui.visuals().dark_mode || !*is_on {
        knob
    } else {
        p.chosen
    };
    painter.circle_filled(egui::pos2(x, track.center().y), 6.0, knob);
    focus_ring(ui, &response, track, 8);
    let state = *is_on;
    response.widget_info(|| WidgetInfo::selected(Role::Switch, ui.is_enabled(), state, name));
    response
}
