//! Buttons: with words, with an icon, and whole rows.

use egui::{Align2, Response, Role, Sense, Ui, Vec2, WidgetInfo};

use super::{Icon, focus_ring};
use crate::theme::{self, GRID, Palette, ROW};

/// A button with words on it.
pub fn button(ui: &mut Ui, text: &str) -> Response {
    let p = Palette::of(ui);
    let size = Vec2::new(button_width(ui, text), ROW);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let fill = if response.is_pointer_button_down_on() {
        p.chosen
    } else if response.hovered() {
        p.hovered
    } else {
        p.raised
    };
    ui.painter().rect_filled(rect, 4, fill);
    let color = if ui.is_enabled() { p.text } else { p.weak };
    ui.painter().text(
        rect.center(),
        Align2::CENTER_CENTER,
        text,
        theme::body(),
        color,
    );
    focus_ring(ui, &response, rect, 4);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, ui.is_enabled(), text));
    response
}

/// Width of a [`button`] with these words, points.
#[must_use]
pub fn button_width(ui: &Ui, text: &str) -> f32 {
    let color = Palette::of(ui).text;
    let painter = ui.painter();
    let galley = painter.layout_no_wrap(text.to_owned(), theme::body(), color);
    galley.size().x + 3.0 * GRID
}

/// A square button with an icon; `name` says what it does, `keys` which keys do the same, and
/// `about` what comes of it, in a sentence.
pub fn icon_button(ui: &mut Ui, icon: Icon, name: &str, keys: &str, about: &str) -> Response {
    let p = Palette::of(ui);
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(28.0), Sense::click());
    if response.hovered() {
        ui.painter().rect_filled(rect, 4, p.hovered);
    }
    let color = if response.hovered() { p.strong } else { p.weak };
    icon.paint(ui.painter(), rect.center(), color);
    focus_ring(ui, &response, rect, 4);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, ui.is_enabled(), name));
    response.on_hover_text(format!("{name}  ({keys})\n{about}"))
}

/// A row as wide as the panel: a name, a remark on the right, marked when chosen.
pub fn row_button(ui: &mut Ui, name: &str, remark: &str, is_chosen: bool) -> Response {
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), ROW);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let wide = rect.expand2(Vec2::new(GRID, 0.0));
    if is_chosen || response.hovered() {
        let fill = if is_chosen { p.chosen } else { p.raised };
        ui.painter().rect_filled(wide, 4, fill);
    }
    let painter = ui.painter_at(rect);
    let right = painter.layout_no_wrap(remark.to_owned(), theme::small(), p.weak);
    let room = rect.width() - right.size().x - GRID;
    painter.galley(
        egui::pos2(
            rect.right() - right.size().x,
            rect.center().y - right.size().y / 2.0,
        ),
        right,
        p.weak,
    );
    let mut job = egui::text::LayoutJob::simple_singleline(name.to_owned(), theme::body(), p.text);
    job.wrap = egui::text::TextWrapping::truncate_at_width(room.max(0.0));
    let left = painter.layout_job(job);
    let y = rect.center().y - left.size().y / 2.0;
    painter.galley(egui::pos2(rect.left(), y), left, p.text);
    focus_ring(ui, &response, wide, 4);
    response.widget_info(|| WidgetInfo::selected(Role::Button, ui.is_enabled(), is_chosen, name));
    response
}
