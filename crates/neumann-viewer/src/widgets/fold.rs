//! A heading that folds away what stands under it.

use egui::{Align2, Role, Sense, Ui, Vec2, WidgetInfo};

use super::{Icon, focus_ring};
use crate::theme::{self, GRID, Palette};

/// Draws the heading; yields whether what belongs to it is to be shown.
pub fn fold(ui: &mut Ui, name: &str, is_open_at_first: bool) -> bool {
    fold_opened(ui, name, is_open_at_first, false)
}

/// The same; `opens` opens it, and scrolls to it.
pub fn fold_opened(ui: &mut Ui, name: &str, is_open_at_first: bool, opens: bool) -> bool {
    let p = Palette::of(ui);
    super::rule(ui);
    let size = Vec2::new(ui.available_width(), 28.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let key = ui.scope_id().with(("fold", name));
    let mut is_open = ui.data(|d| d.get_temp(key)).unwrap_or(is_open_at_first);
    if response.clicked() || (opens && !is_open) {
        is_open = !is_open;
        ui.data_mut(|d| d.insert_temp(key, is_open));
    }
    if opens {
        response.scroll_to_me(Some(egui::Align::Min));
    }
    let color = if response.hovered() { p.strong } else { p.text };
    let font = theme::semibold();
    ui.painter()
        .text(rect.left_center(), Align2::LEFT_CENTER, name, font, color);
    let center = egui::pos2(rect.right() - GRID, rect.center().y);
    let icon = if is_open { Icon::Up } else { Icon::Down };
    icon.paint(ui.painter(), center, p.weak);
    focus_ring(ui, &response, rect, 4);
    response.widget_info(|| {
        WidgetInfo::selected(Role::DisclosureTriangle, ui.is_enabled(), is_open, name)
    });
    is_open
}
