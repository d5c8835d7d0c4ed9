//! A linear colour: a swatch and three sliders.

use egui::{Color32, Rect, Sense, Ui, Vec2, pos2};
use neumann_core::radiometry::Rgb;

use super::Slider;
use crate::theme::{self, Palette};

/// Sliders for red, green and blue up to `max`; true when the colour was changed.
pub fn color_sliders(ui: &mut Ui, name: &str, color: &mut Rgb, max: f64) -> bool {
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), 24.0);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    ui.painter().text(
        rect.left_center(),
        egui::Align2::LEFT_CENTER,
        name,
        theme::body(),
        p.weak,
    );
    let swatch = Rect::from_min_max(
        pos2(rect.right() - 40.0, rect.top() + 4.0),
        pos2(rect.right(), rect.bottom() - 4.0),
    );
    let top = color.max_channel().max(1.0);
    let shown = [color.r / top, color.g / top, color.b / top].map(gamma_byte);
    ui.painter()
        .rect_filled(swatch, 3, Color32::from_rgb(shown[0], shown[1], shown[2]));
    let mut is_changed = false;
    for (channel, value) in [
        ("red", &mut color.r),
        ("green", &mut color.g),
        ("blue", &mut color.b),
    ] {
        let mut number = f64::from(*value);
        let label = format!("{name} {channel}");
        if Slider::new(&label, 0.0, max)
            .show(ui, &mut number)
            .changed()
        {
            *value = number as f32;
            is_changed = true;
        }
    }
    is_changed
}

fn gamma_byte(linear: f32) -> u8 {
    egui::ecolor::gamma_u8_from_linear_f32(linear.clamp(0.0, 1.0))
}
