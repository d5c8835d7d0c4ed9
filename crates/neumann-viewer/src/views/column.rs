//! The column of figures beside a picture.

use egui::{Margin, Rect, ScrollArea, Ui, UiBuilder, Vec2, pos2};

use crate::theme::{self, GRID, Palette};

/// Its width where nothing else is asked for, points: at most, at least, and as a share of the
/// stage.
pub(super) const WIDTH: (f32, f32, f32) = (380.0, 190.0, 0.44);

/// Cuts a stage into the room for the picture and that for the column.
pub(super) fn beside(stage: Rect, (most, least, share): (f32, f32, f32)) -> [Rect; 2] {
    let width = (share * stage.width()).clamp(least, most);
    let edge = stage.right() - width;
    [
        Rect::from_min_max(stage.min, pos2(edge, stage.bottom())),
        Rect::from_min_max(pos2(edge, stage.top()), stage.max),
    ]
}

/// Draws a column with `contents` into `rect`; it scrolls. `name` keeps it apart from others.
pub(super) fn show(ui: &mut Ui, rect: Rect, name: &str, gap: f32, contents: impl FnOnce(&mut Ui)) {
    theme::fill_panel(ui, rect);
    let line = (1.0, Palette::of(ui).line);
    ui.painter().vline(rect.left() + 0.5, rect.y_range(), line);
    let area = rect.shrink2(Vec2::new(GRID, 0.0));
    ui.scope_builder(UiBuilder::new().max_rect(area).id_salt(name), |ui| {
        let scroll = ScrollArea::vertical().id_salt("figures").auto_shrink(false);
        scroll.show(ui, |ui| {
            let margin = Margin::symmetric(GRID as i8, GRID as i8);
            egui::Frame::new().inner_margin(margin).show(ui, |ui| {
                ui.set_width(ui.available_width());
                ui.spacing_mut().item_spacing.y = gap;
                contents(ui);
            });
        });
    });
}
