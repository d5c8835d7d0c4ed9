//! The scale of false colours and of differences, beside the picture.

use egui::{Align2, Color32, Mesh, Painter, Rect, Shape, pos2};
use neumann_picture::false_colour::diverging;

use super::ViewSettings;
use crate::theme::{self, GRID, Palette};
use crate::widgets::significant;

/// Draws the legend in the lower right corner of `area`.
pub fn show(painter: &Painter, area: Rect, settings: &ViewSettings, p: &Palette) {
    let height = (area.height() * 0.5).clamp(80.0, 240.0);
    let plate = Rect::from_min_max(
        pos2(area.right() - 96.0, area.bottom() - height - 56.0),
        area.max - egui::vec2(GRID, GRID),
    );
    painter.rect_filled(plate, 6, p.ground.gamma_multiply(0.8));
    let bar = Rect::from_min_max(
        pos2(plate.left() + 12.0, plate.bottom() - height - 12.0),
        pos2(plate.left() + 24.0, plate.bottom() - 12.0),
    );
    let color = |t: f32| {
        let [r, g, b] = if settings.is_difference {
            diverging(2.0 * t - 1.0)
        } else {
            settings.map.rgb(t)
        };
        Color32::from_rgb(r, g, b)
    };
    let mut mesh = Mesh::default();
    const N: u32 = 32;
    for i in 0..=N {
        let t = i as f32 / N as f32;
        let y = bar.bottom() - t * bar.height();
        mesh.colored_vertex(pos2(bar.left(), y), color(t));
        mesh.colored_vertex(pos2(bar.right(), y), color(t));
        if i > 0 {
            let v = 2 * i;
            mesh.add_triangle(v - 2, v - 1, v);
            mesh.add_triangle(v - 1, v + 1, v);
        }
    }
    painter.add(Shape::mesh(mesh));
    let labels: Vec<(f32, String)> = if settings.is_difference {
        let end = f64::from(settings.difference_range());
        [-1.0, -0.5, 0.0, 0.5, 1.0]
            .map(|t: f32| {
                let value = significant(end * f64::from(t), 2);
                let sign = if t > 0.0 { "+" } else { "" };
                (0.5 + 0.5 * t, format!("{sign}{value}"))
            })
            .into()
    } else {
        let [low, high] = settings.map_range();
        (0..=4u8)
            .map(|i| {
                let t = f32::from(i) / 4.0;
                let value = f64::from(low + (high - low) * t).exp2();
                (t, significant(value, 2))
            })
            .collect()
    };
    for (t, text) in labels {
        let y = bar.bottom() - t * bar.height();
        painter.hline(bar.right()..=bar.right() + 4.0, y, (1.0, p.weak));
        let at = pos2(bar.right() + 8.0, y);
        painter.text(at, Align2::LEFT_CENTER, text, theme::small(), p.text);
    }
    painter.text(
        pos2(plate.left() + 12.0, plate.top() + 8.0),
        Align2::LEFT_TOP,
        "W m⁻² sr⁻¹",
        theme::small(),
        p.weak,
    );
}
