//! A linear colour: a swatch that opens a picker, and its numbers.
//!
//! The window's colours are scene-referred: linear RGB with the primaries of sRGB, before exposure
//! and tone curve. What has a strength, such as the radiance of a lamp, keeps it apart: its colour
//! has 1 as its largest channel. Hue, saturation and value are those of the linear channels
//! ([Smith 1978] "Color gamut transform pairs").

use egui::ecolor::{Hsva, gamma_from_linear, gamma_u8_from_linear_f32, linear_from_gamma};
use egui::{
    Align, Align2, Color32, Id, Layout, Mesh, Popup, PopupCloseBehavior, Rect, Role, Sense, Stroke,
    StrokeKind, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use neumann_core::radiometry::Rgb;

use super::{Slider, fact, focus_ring, paragraph, settled, significant};
use crate::theme::{self, GRID, Palette};

/// What the numbers of every colour are.
const SPACE: &str = "Linear RGB with the primaries of sRGB, before exposure and tone curve.";

/// Width of a picker, points.
const PICKER: f32 = 220.0;

/// What a picker chooses.
#[derive(Clone, Copy, PartialEq)]
enum Of {
    /// Channels from 0 to 1.
    Share,
    /// A colour whose largest channel is 1.
    Hue,
}

/// A name and a swatch, which opens a picker; true when the colour was changed. `of` is whose
/// colour it is, for whoever hears it.
pub fn color_row(ui: &mut Ui, name: &str, of: &str, color: &mut Rgb, about: &str) -> bool {
    row(ui, name, of, color, about, Of::Share)
}

/// As [`color_row`], of what has a strength, which stays: the colour is shown and chosen with 1 as
/// its largest channel. Nothing is shown of what is black.
pub fn hue_row(ui: &mut Ui, name: &str, of: &str, value: &mut Rgb, about: &str) -> bool {
    let strength = value.max_channel();
    let is_lit = strength > 0.0;
    if !settled(ui, ("hue", name), is_lit) {
        return false;
    }
    let mut hue = if is_lit {
        *value * (1.0 / strength)
    } else {
        Rgb::WHITE
    };
    let about = format!("{about} Its strength is kept: the largest channel is 1.");
    let is_changed = row(ui, name, of, &mut hue, &about, Of::Hue) && is_lit;
    if is_changed {
        *value = hue * (strength / hue.max_channel());
    }
    is_changed
}

/// A swatch that opens a picker, and sliders for red, green and blue up to 1; true when the colour
/// was changed.
pub fn color_sliders(ui: &mut Ui, name: &str, of: &str, color: &mut Rgb, about: &str) -> bool {
    let is_picked = color_row(ui, name, of, color, about);
    channels(ui, name, color) || is_picked
}

/// A slider for each channel.
fn channels(ui: &mut Ui, name: &str, color: &mut Rgb) -> bool {
    let mut is_changed = false;
    for (channel, value) in [
        ("red", &mut color.r),
        ("green", &mut color.g),
        ("blue", &mut color.b),
    ] {
        let mut number = f64::from(*value);
        let label = format!("{name} {channel}");
        let slider = Slider::new(&label, 0.0, 1.0).about(SPACE);
        if slider.show(ui, &mut number).changed() {
            *value = number as f32;
            is_changed = true;
        }
    }
    is_changed
}

fn row(ui: &mut Ui, name: &str, of: &str, color: &mut Rgb, about: &str, kind: Of) -> bool {
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), 26.0);
    let (rect, hover) = ui.allocate_exact_size(size, Sense::hover());
    ui.painter().text(
        rect.left_center(),
        Align2::LEFT_CENTER,
        name,
        theme::body(),
        p.weak,
    );
    let swatch = Rect::from_min_max(
        pos2(rect.right() - 40.0, rect.top() + 4.0),
        pos2(rect.right(), rect.bottom() - 4.0),
    );
    let id = ui.scope_id().with(("colour", name, of));
    let response = ui.interact(swatch, id, Sense::click());
    ui.painter().rect_filled(swatch, 3, shown(*color));
    let line = if response.hovered() { p.strong } else { p.line };
    let stroke = Stroke::new(1.0, line);
    ui.painter()
        .rect_stroke(swatch, 3, stroke, StrokeKind::Inside);
    focus_ring(ui, &response, swatch, 3);
    let spoken = format!("{name} of {of}");
    response.widget_info(|| WidgetInfo::labeled(Role::ColorWell, ui.is_enabled(), &spoken));
    let about = format!("{about} {SPACE}");
    let mut is_changed = false;
    Popup::menu(&response)
        .id(id.with("picker"))
        .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
        .show(|ui| {
            ui.set_width(PICKER);
            // A menu would stretch its lines.
            ui.with_layout(Layout::top_down(Align::Min), |ui| {
                is_changed = picker(ui, id, color, kind);
                paragraph(ui, SPACE);
            });
        });
    response.on_hover_text(&about);
    hover.on_hover_text(about);
    is_changed
}

/// A field of hues and saturations, and sliders; true when the colour was changed.
fn picker(ui: &mut Ui, id: Id, color: &mut Rgb, kind: Of) -> bool {
    // Grey has no hue, and black no saturation: those that were chosen last stay.
    let last = ui.data(|d| d.get_temp::<(Hsva, [f32; 3])>(id));
    let now = color.to_array();
    let is_it = |of: [f32; 3]| of.into_iter().zip(now).all(|(a, b)| (a - b).abs() < 1e-4);
    let last = last.filter(|(_, of)| is_it(*of));
    let now = now.map(|c| c.clamp(0.0, 1.0));
    let mut hsv = last.map_or_else(|| Hsva::from_rgb(now), |(hsv, _)| hsv);
    let mut is_changed = field(ui, &mut hsv);
    let mut part = |ui: &mut Ui, name: &str, scale: f64, about: &str, value: &mut f32| {
        let mut number = f64::from(*value) * scale;
        let unit = if scale > 1.0 { "°" } else { "" };
        let slider = Slider::new(name, 0.0, scale).unit(unit).about(about);
        if slider.show(ui, &mut number).changed() {
            *value = (number / scale) as f32;
            is_changed = true;
        }
    };
    let about = "Place on the circle of hues: 0 is red, 120 green, 240 blue.";
    part(ui, "Hue", 360.0, about, &mut hsv.h);
    let about = "0 is grey, 1 the pure hue.";
    part(ui, "Saturation", 1.0, about, &mut hsv.s);
    match kind {
        Of::Share => part(ui, "Value", 1.0, "The largest channel.", &mut hsv.v),
        Of::Hue => hsv.v = 1.0,
    }
    if is_changed {
        let [r, g, b] = hsv.to_rgb();
        *color = Rgb::new(r, g, b);
        ui.data_mut(|d| d.insert_temp(id, (hsv, color.to_array())));
    }
    match kind {
        Of::Share => channels(ui, "Picked", color) || is_changed,
        Of::Hue => {
            let numbers = color.to_array().map(|c| significant(f64::from(c), 3));
            fact(ui, "Red, green, blue", &numbers.join("  "));
            is_changed
        }
    }
}

/// Hue to the right, saturation upwards, as even steps on the screen.
fn field(ui: &mut Ui, hsv: &mut Hsva) -> bool {
    const STEPS: [usize; 2] = [36, 8];
    let (rect, response) = ui.allocate_exact_size(vec2(PICKER, 110.0), Sense::click_and_drag());
    response
        .widget_info(|| WidgetInfo::labeled(Role::Group, ui.is_enabled(), "Hue and saturation"));
    let mut is_changed = false;
    let inside = |at: egui::Pos2| (at - rect.min) / rect.size();
    if let Some(at) = response.interact_pointer_pos().map(inside) {
        // The end of the hues is their beginning.
        let hue = at.x.clamp(0.0, 0.999);
        let saturation = 1.0 - linear_from_gamma(at.y.clamp(0.0, 1.0));
        is_changed = hue != hsv.h || saturation != hsv.s;
        (hsv.h, hsv.s) = (hue, saturation);
    }
    let [columns, rows] = STEPS;
    let mut mesh = Mesh::default();
    for i in 0..=columns {
        for j in 0..=rows {
            let at = vec2(i as f32 / columns as f32, j as f32 / rows as f32);
            let saturation = 1.0 - linear_from_gamma(at.y);
            let [r, g, b] = Hsva::new(at.x, saturation, 1.0, 1.0).to_rgb();
            mesh.colored_vertex(rect.min + at * rect.size(), shown(Rgb::new(r, g, b)));
        }
    }
    let n = rows + 1;
    for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
        let [a, b, c, d] = [
            i * n + j,
            i * n + j + 1,
            (i + 1) * n + j,
            (i + 1) * n + j + 1,
        ]
        .map(|index| index as u32);
        mesh.add_triangle(a, b, c);
        mesh.add_triangle(c, b, d);
    }
    ui.painter().add(mesh);
    let at = vec2(hsv.h, gamma_from_linear(1.0 - hsv.s));
    let spot = rect.min + at * rect.size();
    ui.painter()
        .circle_stroke(spot, 6.0, Stroke::new(3.0, Color32::BLACK));
    ui.painter()
        .circle_stroke(spot, 6.0, Stroke::new(1.5, Color32::WHITE));
    ui.add_space(GRID / 2.0);
    is_changed
}

/// A colour on the screen; what is brighter than white is shown as bright as that.
fn shown(color: Rgb) -> Color32 {
    let top = color.max_channel().max(1.0);
    let [r, g, b] = color
        .to_array()
        .map(|c| gamma_u8_from_linear_f32((c / top).clamp(0.0, 1.0)));
    Color32::from_rgb(r, g, b)
}
