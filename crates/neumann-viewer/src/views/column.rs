//! The column beside a picture, in which a view says what it found.

use egui::{
    Align2, Frame, Margin, Painter, Rect, Response, ScrollArea, Sense, Ui, UiBuilder, Vec2, pos2,
};

use crate::theme::{self, GRID, Palette};
use crate::widgets::{choice_row, focus_ring};

/// Height of a row of a table.
pub(super) const ROW: f32 = 22.0;

/// Width of a column, points.
#[derive(Clone, Copy)]
pub(super) struct Width {
    pub(super) most: f32,
    pub(super) least: f32,
    /// Of the stage.
    pub(super) share: f32,
}

/// That of figures of a picture.
pub(super) const FIGURES: Width = Width {
    most: 380.0,
    least: 190.0,
    share: 0.44,
};

/// The room of the picture, and that of the column on its right.
pub(super) fn split(whole: Rect, width: Width) -> [Rect; 2] {
    let width = (width.share * whole.width()).clamp(width.least, width.most);
    let edge = whole.right() - width;
    [
        Rect::from_min_max(whole.min, pos2(edge, whole.bottom())),
        Rect::from_min_max(pos2(edge, whole.top()), whole.max),
    ]
}

/// Draws a column, which scrolls.
pub(super) fn show(ui: &mut Ui, rect: Rect, name: &str, contents: impl FnOnce(&mut Ui)) {
    let p = Palette::of(ui);
    theme::fill_panel(ui, rect);
    ui.painter()
        .vline(rect.left() + 0.5, rect.y_range(), (1.0, p.line));
    let area = rect.shrink2(Vec2::new(GRID, 0.0));
    ui.scope_builder(UiBuilder::new().max_rect(area).id_salt(name), |ui| {
        let scroll = ScrollArea::vertical().id_salt("figures").auto_shrink(false);
        scroll.show(ui, |ui| {
            let margin = Margin::symmetric(GRID as i8, GRID as i8);
            Frame::new().inner_margin(margin).show(ui, |ui| {
                ui.set_width(ui.available_width());
                contents(ui);
            });
        });
    });
}

/// A row of a table that can be chosen: what `name` draws from the left edge on, and cells that end
/// at shares of the width.
pub(super) fn table_row(
    ui: &mut Ui,
    is_chosen: bool,
    ends: &[f32],
    cells: &[&str],
    name: impl FnOnce(&Painter, f32, f32),
) -> Response {
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), ROW);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let wide = rect.expand2(Vec2::new(GRID, 0.0));
    if is_chosen || response.hovered() {
        let fill = if is_chosen { p.chosen } else { p.raised };
        ui.painter().rect_filled(wide, 4, fill);
    }
    let middle = rect.center().y;
    let painter = ui.painter_at(wide);
    name(&painter, rect.left(), middle);
    for (end, text) in ends.iter().zip(cells) {
        let at = pos2(rect.left() + end * rect.width(), middle);
        painter.text(at, Align2::RIGHT_CENTER, text, theme::small(), p.text);
    }
    focus_ring(ui, &response, wide, 4);
    response
}

/// The heading of a table of such rows.
pub(super) fn table_heading(ui: &mut Ui, ends: &[f32], titles: &[&str]) {
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), ROW);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    for (end, title) in ends.iter().zip(titles) {
        let at = pos2(rect.left() + end * rect.width(), rect.center().y);
        let painter = ui.painter();
        painter.text(at, Align2::RIGHT_CENTER, title, theme::small(), p.weak);
    }
}

/// The choice of how many iterations something has; `about` says what each number means.
pub(super) fn lengths(
    ui: &mut Ui,
    name: &str,
    all: &[u32],
    about: impl Fn(u32) -> String,
    chosen: &mut u32,
) {
    let labels: Vec<String> = all.iter().map(u32::to_string).collect();
    let labels: Vec<&str> = labels.iter().map(String::as_str).collect();
    let now = all.iter().position(|n| n == chosen).unwrap_or(0);
    if let Some(i) = choice_row(ui, name, &labels, |i| about(all[i]), now) {
        *chosen = all[i];
    }
}
