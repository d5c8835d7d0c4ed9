//! Text in panels: headings, paragraphs, facts, fields.

use std::sync::Arc;

use egui::text::{LayoutJob, TextWrapping};
use egui::{
    Align2, Color32, FontId, Galley, Key, Label, Painter, Response, RichText, Role, Sense,
    TextEdit, Ui, Vec2, WidgetInfo,
};

use crate::theme::{self, GRID, Palette, ROW};

/// A heading with the space that belongs above it.
pub fn heading(ui: &mut Ui, text: &str) {
    ui.add_space(GRID);
    ui.add(Label::new(RichText::new(text).font(theme::semibold())).wrap());
}

/// Secondary text over several lines.
pub fn paragraph(ui: &mut Ui, text: &str) {
    let weak = Palette::of(ui).weak;
    ui.add(Label::new(RichText::new(text).font(theme::small()).color(weak)).wrap());
}

/// A line of secondary text, cut with an ellipsis where it is too long.
pub fn hint(ui: &mut Ui, text: &str) {
    let weak = Palette::of(ui).weak;
    ui.add(Label::new(RichText::new(text).font(theme::small()).color(weak)).truncate());
}

/// A hairline across the panel, with space around it.
pub fn rule(ui: &mut Ui) {
    ui.add_space(GRID);
    let line = Palette::of(ui).line;
    let (rect, _) = ui.allocate_exact_size(Vec2::new(ui.available_width(), 1.0), Sense::hover());
    let x = rect.x_range().expand(16.0);
    ui.painter().hline(x, rect.center().y, (1.0, line));
}

/// A name on the left, its value on the right.
pub fn fact(ui: &mut Ui, name: &str, value: &str) {
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), 20.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    let right = painter.layout_no_wrap(value.to_owned(), theme::body(), p.text);
    let at = egui::pos2(
        rect.right() - right.size().x,
        rect.center().y - right.size().y / 2.0,
    );
    painter.galley(at, right, p.text);
    painter.text(
        rect.left_center(),
        Align2::LEFT_CENTER,
        name,
        theme::body(),
        p.weak,
    );
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("{name}: {value}")));
}

/// A line, cut where it has no room, points.
pub fn cut_line(
    painter: &Painter,
    text: String,
    font: FontId,
    color: Color32,
    room: f32,
) -> Arc<Galley> {
    let mut job = LayoutJob::simple_singleline(text, font, color);
    job.wrap = TextWrapping::truncate_at_width(room.max(0.0));
    painter.layout_job(job)
}

/// A field for a path; true when `Enter` says that it is complete.
pub fn path_field(ui: &mut Ui, name: &str, path: &mut String) -> bool {
    let field = text_field(ui, name, path);
    field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter)) && !path.trim().is_empty()
}

/// A one-line text field with a name.
pub fn text_field(ui: &mut Ui, name: &str, text: &mut String) -> Response {
    let field = TextEdit::singleline(text)
        .hint_text(name)
        .font(theme::body())
        .margin(egui::Margin::symmetric(8, 4))
        .desired_width(f32::INFINITY)
        .min_size(Vec2::new(0.0, ROW));
    ui.add(field).accessible_name(name)
}
