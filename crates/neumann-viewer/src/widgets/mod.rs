//! The window's own controls: quiet, on the grid, each with a name for assistive technology.

mod button;
mod color;
mod fold;
mod icon;
mod segmented;
mod settled;
mod slider;
mod switch;
mod text;

pub use button::{button, button_width, icon_button, row_button};
pub use color::{color_row, color_sliders, hue_row};
pub use fold::{fold, fold_opened};
pub use icon::Icon;
pub use neumann_picture::figures::significant;
pub use segmented::{choice_row, choice_rows, explained_choice, segmented_width, segments, tabs};
pub use settled::settled;
pub use slider::Slider;
pub use switch::switch;
pub use text::{cut_line, fact, heading, hint, paragraph, path_field, rule, text_field};

use egui::{Response, Stroke, StrokeKind, Ui};

use crate::theme::Palette;

/// Outlines a control while it has the keyboard: strong and with a gap, as amber is for what is
/// chosen.
pub fn focus_ring(ui: &Ui, response: &Response, rect: egui::Rect, radius: u8) {
    if response.has_focus() {
        let stroke = Stroke::new(2.0, Palette::of(ui).strong);
        ui.painter()
            .rect_stroke(rect.expand(2.0), radius + 2, stroke, StrokeKind::Outside);
    }
}
