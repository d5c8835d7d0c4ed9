//! The numbers in the pixels, when they are magnified enough to hold them.

use egui::{Align2, Color32, Painter, Rect, pos2};
use neumann_core::film::{Film, View};

use super::image_area::Placement;
use crate::theme;
use crate::widgets::significant;

/// Smallest edge of a pixel, points, that holds three numbers.
const EDGE: f32 = 44.0;

/// Writes red, green and blue of the view into each pixel of the film that is large enough, and
/// in `visible`. The film stands at `place`.
pub fn show(painter: &Painter, place: Rect, visible: Rect, film: &Film, view: View, exposure: f32) {
    let size = (film.width(), film.height());
    let visible = visible.intersect(place);
    let edge = place.width() / size.0 as f32;
    if edge < EDGE || !visible.is_positive() {
        return;
    }
    let corner = |at: egui::Pos2| {
        let f = (at - place.min) / place.size();
        Placement::pixel([f.x.max(0.0), f.y.max(0.0)], size)
    };
    let (x0, y0) = corner(visible.min);
    let (x1, y1) = corner(visible.max);
    let painter = painter.with_clip_rect(visible);
    for y in y0..=y1 {
        for x in x0..=x1 {
            let value = film.radiance(view, y * size.0 + x);
            let is_bright = value.luminance() * exposure > 0.25;
            let color = if is_bright {
                Color32::from_gray(16)
            } else {
                Color32::from_gray(224)
            };
            let center = pos2(
                place.left() + (x as f32 + 0.5) * edge,
                place.top() + (y as f32 + 0.5) * edge,
            );
            for (channel, line) in value.to_array().into_iter().zip([-1.0, 0.0, 1.0]) {
                painter.text(
                    center + egui::vec2(0.0, line * 13.0),
                    Align2::CENTER_CENTER,
                    significant(f64::from(channel), 3),
                    theme::small(),
                    color,
                );
            }
        }
    }
}
