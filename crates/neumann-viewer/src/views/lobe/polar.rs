//! A polar plot in the plane of normal and viewer.

use egui::{Align2, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2};
use neumann_core::render::lobe::Viewed;
use neumann_picture::figures::significant;
use neumann_picture::lobe::{Plot, PolarChart};
use neumann_picture::race::colours;

use crate::theme::{self, GRID, Palette};

/// Room for numbers at the surface.
const NUMBERS: f32 = 2.0 * GRID;
/// Length of the head of an arrow.
const HEAD: f32 = 7.0;
/// Segments of a ring.
const N_SEGMENTS: usize = 96;

/// Its height for a width.
pub(super) fn height(width: f32, is_whole: bool) -> f32 {
    if is_whole {
        width
    } else {
        0.5 * width + NUMBERS
    }
}

/// Draws the plot of a view.
pub(super) fn show(ui: &Ui, rect: Rect, viewed: &Viewed, plot: Plot, is_whole: bool) {
    let p = Palette::of(ui);
    let chart = PolarChart::new(viewed, plot);
    let radius = 0.5 * rect.width() - 1.0;
    let is_behind = viewed.wo.z < 0.0;
    let y = if is_whole {
        rect.center().y
    } else if is_behind {
        rect.top() + NUMBERS
    } else {
        rect.bottom() - NUMBERS
    };
    let origin = pos2(rect.center().x, y);
    let at = |[x, y]: [f32; 2]| pos2(origin.x + radius * x, origin.y - radius * y);
    let painter = ui.painter();
    let thin = Stroke::new(1.0, p.weak.gamma_multiply(0.4));
    let (from, length) = match (is_whole, is_behind) {
        (true, _) => (0.0, std::f32::consts::TAU),
        (false, false) => (0.0, std::f32::consts::PI),
        (false, true) => (std::f32::consts::PI, std::f32::consts::PI),
    };
    for ring in &chart.rings {
        let corner = |i: usize| {
            let (sin, cos) = (from + length * i as f32 / N_SEGMENTS as f32).sin_cos();
            at([ring.radius * cos, ring.radius * sin])
        };
        painter.add(Shape::line((0..=N_SEGMENTS).map(corner).collect(), thin));
    }
    let up = if is_behind { -1.0 } else { 1.0 };
    painter.line_segment([at([-1.0, 0.0]), at([1.0, 0.0])], (1.0, p.weak));
    painter.line_segment([at([0.0, 0.0]), at([0.0, up])], thin);
    painter.line_segment([at([0.0, 0.0]), at(chart.viewer)], (1.5, p.amber));
    let [values, density, _, _] =
        colours(ui.visuals().dark_mode).map(|[r, g, b]| egui::Color32::from_rgb(r, g, b));
    let places = |line: &[[f32; 2]]| line.iter().map(|p| at(*p)).collect::<Vec<Pos2>>();
    for line in &chart.densities {
        let stroke = Stroke::new(1.5, density);
        painter.extend(Shape::dashed_line(&places(line), stroke, 5.0, 4.0));
    }
    for line in &chart.curves {
        painter.add(Shape::line(places(line), Stroke::new(2.0, values)));
    }
    for arrow in &chart.arrows {
        let tip = at(arrow.tip);
        let along = (tip - origin).normalized();
        let stroke = Stroke::new(2.0, p.strong);
        painter.line_segment([origin, tip], stroke);
        let head = HEAD.min(origin.distance(tip));
        for side in [-0.5, 0.5] {
            let barb = tip - head * (along + side * along.rot90());
            painter.line_segment([tip, barb], stroke);
        }
    }
    let side = if is_behind {
        Align2::RIGHT_BOTTOM
    } else {
        Align2::RIGHT_TOP
    };
    let mut free = f32::INFINITY;
    for ring in chart.rings.iter().rev() {
        let place = at([ring.radius, 0.0]);
        let galley = painter.layout_no_wrap(ring.label.clone(), theme::small(), p.weak);
        if place.x < free {
            free = place.x - galley.size().x - GRID;
            painter.text(place, side, &ring.label, theme::small(), p.weak);
        }
    }
    let response = ui.interact(rect, ui.scope_id().with("polar"), Sense::hover());
    let angle = significant(f64::from(viewed.angle), 3);
    let most = chart.rings.last().map_or("0", |ring| &ring.label);
    let mut name = format!(
        "polar plot of {}, viewer at {angle}°, outer ring {most} sr⁻¹",
        plot.plotted.name()
    );
    for arrow in &chart.arrows {
        let share = significant(100.0 * f64::from(arrow.share), 3);
        name += &format!(", mirror-like {share} %");
    }
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
    response.on_hover_text(
        "The plane of normal and viewer: each direction as far from the point as its value, in the \
         brightest channel. Rings have their values at the surface, sr⁻¹. The amber line \
         points to the viewer. Arrows are mirror-like lobes, the outer ring being all of the \
         light. Dashes are the density of BSDF sampling, scaled to the same integral.",
    );
}
