//! The scale of false colours and of differences, beside the picture.

use egui::{Align2, Color32, Mesh, Painter, Rect, Shape, pos2};
use neumann_picture::sheet::Scale;

use crate::theme::{self, GRID, Palette};

/// Draws the legend in the lower right corner of `area`.
pub fn show(painter: &Painter, area: Rect, scale: &Scale, p: &Palette) {
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
    let mut mesh = Mesh::default();
    let last = scale.colours.len().saturating_sub(1).max(1);
    for (i, [r, g, b]) in scale.colours.iter().copied().enumerate() {
        let y = bar.bottom() - i as f32 / last as f32 * bar.height();
        let color = Color32::from_rgb(r, g, b);
        mesh.colored_vertex(pos2(bar.left(), y), color);
        mesh.colored_vertex(pos2(bar.right(), y), color);
        if i > 0 {
            let v = 2 * i as u32;
            mesh.add_triangle(v - 2, v - 1, v);
            mesh.add_triangle(v - 1, v + 1, v);
        }
    }
    painter.add(Shape::mesh(mesh));
    for (t, text) in &scale.marks {
        let y = bar.bottom() - t * bar.height();
        painter.hline(bar.right()..=bar.right() + 4.0, y, (1.0, p.weak));
        let at = pos2(bar.right() + 8.0, y);
        painter.text(at, Align2::LEFT_CENTER, text, theme::small(), p.text);
    }
    painter.text(
        pos2(plate.left() + 12.0, plate.top() + 8.0),
        Align2::LEFT_TOP,
        &scale.unit,
        theme::small(),
        p.weak,
    );
}
