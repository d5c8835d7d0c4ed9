//! The albedo over the angle of the viewer, and how reciprocal the BSDF is.

use egui::{Align2, Color32, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo, pos2};
use neumann_core::render::lobe::Lobes;
use neumann_picture::lobe::{AlbedoChart, percent, reciprocity};

use crate::theme::{self, GRID, Palette};
use crate::widgets::{heading, paragraph};

/// Height of the chart, and room for numbers on the left and below.
const CHART: f32 = 110.0;
const LEFT: f32 = 3.0 * GRID;
const BELOW: f32 = 2.0 * GRID;
/// Red, green and blue that colour-blind people tell apart.
const CHANNELS: [Color32; 3] = [
    Color32::from_rgb(213, 94, 0),
    Color32::from_rgb(0, 158, 115),
    Color32::from_rgb(86, 180, 233),
];

/// Draws the curve with its words.
pub(super) fn show(ui: &mut Ui, lobes: &Lobes) {
    let p = Palette::of(ui);
    heading(ui, "Albedo over the angle");
    let size = Vec2::new(ui.available_width(), CHART);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let plot = Rect::from_min_max(
        rect.min + Vec2::new(LEFT, GRID),
        rect.max - Vec2::new(GRID, BELOW),
    );
    let painter = ui.painter();
    painter.rect_filled(plot, 2, p.raised);
    let chart = AlbedoChart::new(lobes);
    let at = |[x, y]: [f32; 2]| {
        pos2(
            plot.left() + x * plot.width(),
            plot.bottom() - y.clamp(0.0, 1.02) * plot.height(),
        )
    };
    for (value, text) in [(0.0, "0"), (0.5, "0.5"), (1.0, "1")] {
        let y = at([0.0, value]).y;
        painter.hline(plot.x_range(), y, (1.0, p.line));
        let place = pos2(plot.left() - 4.0, y);
        painter.text(place, Align2::RIGHT_CENTER, text, theme::small(), p.weak);
    }
    for (place, text) in &chart.ticks {
        let below = at([*place, 0.0]) + Vec2::new(0.0, 2.0);
        painter.text(below, Align2::CENTER_TOP, text, theme::small(), p.weak);
    }
    for [place, low, high] in &chart.sampled {
        let ends = [at([*place, *low]), at([*place, *high])];
        painter.line_segment(ends, (3.0, p.fill));
    }
    let places = |line: &[[f32; 2]]| line.iter().map(|p| at(*p)).collect::<Vec<Pos2>>();
    if chart.is_coloured {
        for (line, colour) in chart.channels.iter().zip(CHANNELS) {
            painter.add(Shape::line(places(line), Stroke::new(1.5, colour)));
        }
    }
    painter.add(Shape::line(places(&chart.all), Stroke::new(2.0, p.strong)));
    let dashes = Shape::dashed_line(&places(&chart.specular), Stroke::new(1.5, p.text), 5.0, 4.0);
    painter.extend(dashes);
    let ends = [lobes.albedo.first(), lobes.albedo.last()];
    let ends = ends.map(|at| at.map_or(0.0, |at| f64::from(at.albedo.luminance())));
    let [upright, grazing] = ends.map(percent);
    let name = format!("albedo over the angle: {upright} upright, {grazing} grazing");
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
    response.on_hover_text(
        "The share of the light arriving under an angle that is scattered: its luminance, and red, \
         green and blue where they differ. Dashes are what mirror-like lobes scatter. Grey bars \
         are the mean over drawn directions: they hold the truth 95 times of 100.",
    );
    paragraph(ui, &reciprocity(lobes));
}
