//! Icons, drawn as strokes on a 16-point field so that they match the type.

use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, Vec2, pos2};

/// A small picture on a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Icon {
    /// Two bars.
    Pause,
    /// A triangle.
    Play,
    /// A circular arrow.
    Restart,
    /// An arrow into a tray.
    Save,
    /// A question mark's circle.
    Help,
    /// A half-filled disc.
    Theme,
    /// A rectangle with a column.
    Panel,
    /// A small triangle pointing down.
    Down,
    /// A small triangle pointing up.
    Up,
    /// A cross.
    Close,
}

impl Icon {
    /// Draws it centred at `center`.
    pub fn paint(self, painter: &Painter, center: Pos2, color: Color32) {
        let stroke = Stroke::new(1.5, color);
        let at = |x: f32, y: f32| center + Vec2::new(x, y);
        let filled = |points: Vec<Pos2>| Shape::convex_polygon(points, color, Stroke::NONE);
        match self {
            Self::Pause => {
                for x in [-3.0, 3.0] {
                    let bar = Rect::from_center_size(at(x, 0.0), Vec2::new(3.0, 10.0));
                    painter.rect_filled(bar, 0, color);
                }
            }
            Self::Play => {
                painter.add(filled(vec![at(-3.5, -5.0), at(5.0, 0.0), at(-3.5, 5.0)]));
            }
            Self::Restart => {
                painter.add(Shape::line(arc(center, 5.0, -0.9, 4.2), stroke));
                let tip = at(3.1, -3.9);
                painter.add(filled(vec![
                    tip + Vec2::new(2.6, -2.4),
                    tip + Vec2::new(2.8, 2.2),
                    tip + Vec2::new(-2.0, 1.6),
                ]));
            }
            Self::Save => {
                painter.line_segment([at(0.0, -6.0), at(0.0, 2.0)], stroke);
                painter.add(Shape::line(
                    vec![at(-3.0, -1.0), at(0.0, 2.2), at(3.0, -1.0)],
                    stroke,
                ));
                painter.add(Shape::line(
                    vec![at(-5.5, 2.0), at(-5.5, 5.5), at(5.5, 5.5), at(5.5, 2.0)],
                    stroke,
                ));
            }
            Self::Help => {
                painter.circle_stroke(center, 6.5, stroke);
                let font = crate::theme::small();
                painter.text(center, egui::Align2::CENTER_CENTER, "?", font, color);
            }
            Self::Theme => {
                painter.circle_stroke(center, 5.5, stroke);
                let mut half = arc(
                    center,
                    5.5,
                    -std::f32::consts::FRAC_PI_2,
                    std::f32::consts::PI,
                );
                half.push(at(0.0, 5.5));
                painter.add(filled(half));
            }
            Self::Panel => {
                let frame = Rect::from_center_size(center, Vec2::new(13.0, 11.0));
                painter.rect_stroke(frame, 2, stroke, egui::StrokeKind::Middle);
                painter.line_segment([at(2.5, -5.5), at(2.5, 5.5)], stroke);
            }
            Self::Down => {
                painter.add(filled(vec![at(-3.5, -1.75), at(3.5, -1.75), at(0.0, 2.25)]));
            }
            Self::Up => {
                painter.add(filled(vec![at(-3.5, 1.75), at(0.0, -2.25), at(3.5, 1.75)]));
            }
            Self::Close => {
                painter.line_segment([at(-3.5, -3.5), at(3.5, 3.5)], stroke);
                painter.line_segment([at(-3.5, 3.5), at(3.5, -3.5)], stroke);
            }
        }
    }
}

/// Points along an arc from `start` radians over `sweep` radians, clockwise on the screen.
fn arc(center: Pos2, radius: f32, start: f32, sweep: f32) -> Vec<Pos2> {
    (0..=20)
        .map(|i| {
            let angle = start + sweep * i as f32 / 20.0;
            pos2(
                center.x + radius * angle.cos(),
                center.y + radius * angle.sin(),
            )
        })
        .collect()
}
