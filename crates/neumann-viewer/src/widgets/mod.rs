//! The window's own controls: quiet, on the grid, each with a name for assistive technology.

mod button;
mod color;
mod fold;
mod icon;
mod segmented;
mod slider;
mod switch;
mod text;

pub use button::{button, icon_button, row_button};
pub use color::color_sliders;
pub use fold::fold;
pub use icon::Icon;
pub use segmented::{choice_row, segmented, segmented_width, tabs};
pub use slider::{Slider, significant};
pub use switch::switch;
pub use text::{fact, heading, hint, paragraph, rule, text_field};

use egui::{Response, Stroke, StrokeKind, Ui};

use crate::theme::Palette;

/// Outlines a control while it has the keyboard.
pub fn focus_ring(ui: &Ui, response: &Response, rect: egui::Rect, radius: u8) {
    if response.has_focus() {
        let stroke = Stroke::new(1.5, Palette::of(ui).amber);
        ui.painter()
            .rect_stroke(rect.expand(1.0), radius, stroke, StrokeKind::Outside);
    }
}
