//! What stands beside the picture: the equation, its pictures, its estimates and their course.

use egui::{Align2, Rect, Role, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo, pos2};
use neumann_core::film::View as Part;
use neumann_core::render::Hemisphere;
use neumann_core::render::hemisphere::Estimator;
use neumann_picture::figures::significant;
use neumann_picture::hemisphere::{Convergence, EQUATION, figures, points, with_interval};

use super::HemisphereView;
use super::disks::colour_of;
use crate::display::ViewSettings;
use crate::formula::Formula;
use crate::session::Session;
use crate::theme::{self, GRID, Palette};
use crate::views::column;
use crate::widgets::{fact, fold, hint, paragraph};

/// Height of a row of figures.
const ROW: f32 = 20.0;
/// Height of the chart.
const CHART: f32 = 132.0;
/// Room for numbers on its left and below.
const LEFT: f32 = 6.0 * GRID;
const BELOW: f32 = 2.0 * GRID;

/// Draws the column into `rect`.
pub(super) fn show(
    ui: &mut Ui,
    rect: Rect,
    view: &mut HemisphereView,
    session: &Session,
    settings: &ViewSettings,
) {
    column::show(ui, rect, "hemisphere", |ui| {
        ui.spacing_mut().item_spacing.y = 4.0;
        contents(ui, view, session, settings);
    });
}

fn contents(ui: &mut Ui, view: &mut HemisphereView, session: &Session, settings: &ViewSettings) {
    let p = Palette::of(ui);
    let [x, y] = view.pixel.unwrap_or_default();
    let found = match &view.found {
        None => {
            paragraph(ui, "Looking around …");
            return;
        }
        Some(Err(error)) => {
            paragraph(ui, &format!("Pixel {x}, {y}: {error}."));
            return;
        }
        Some(Ok(found)) => std::sync::Arc::clone(found),
    };
    let n = found.n_passes();
    fact(ui, &format!("Pixel {x}, {y}"), &format!("{n} samples"));
    let equation = Formula::typed(ui.painter(), EQUATION, 17.0, p.strong);
    let size = Vec2::new(ui.available_width(), equation.size.y + 4.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    equation.paint(ui.painter(), rect.min);
    let plain = EQUATION.replace(['_', '{', '}'], "");
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &plain));
    if settings.part != Part::Total {
        let part = crate::formula::spoken(settings.part);
        hint(ui, &format!("what arrives: {part} alone"));
    }
    view.disks
        .follow(ui.ctx(), &found, settings.part, settings.display());
    view.disks.show(ui, &found, false);
    if fold(ui, "One number", true) {
        numbers(ui, &found, view.of_film(session));
        course(ui, &found, view.of_film(session));
    }
    if fold(ui, "Where directions are drawn", true) {
        view.disks.show(ui, &found, true);
    }
}

/// The integral by all ways, beside what the film has.
fn numbers(ui: &mut Ui, found: &Hemisphere, of_film: Option<f64>) {
    let emitted = f64::from(found.emitted().luminance());
    for (i, figure) in figures(found).into_iter().enumerate() {
        let estimator = Estimator::ALL.get(i).copied();
        number(ui, figure.name, &figure.text, estimator, figure.about);
    }
    if let Some(film) = of_film {
        let text = significant(film - emitted, 4);
        let about = "What the film has at the pixel, less what the point emits. It is the mean \
                     over the whole pixel, the estimates are of the ray through its middle.";
        number(ui, "the film's pixel", &text, None, about);
    }
    if emitted > 0.0 {
        let about = "What the point emits itself; it is in the pixel, and not in the integral.";
        number(ui, "L_e", &significant(emitted, 4), None, about);
    }
    if let Some(words) = points(found) {
        hint(ui, &words);
    }
}

fn number(ui: &mut Ui, name: &str, text: &str, estimator: Option<Estimator>, about: &str) {
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), ROW);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    if let Some(estimator) = estimator {
        let at = pos2(rect.left() + 4.0, rect.center().y);
        painter.circle_filled(at, 4.0, colour_of(estimator, ui));
    }
    let at = pos2(rect.left() + 2.0 * GRID, rect.center().y);
    painter.text(at, Align2::LEFT_CENTER, name, theme::body(), p.text);
    let at = rect.right_center();
    painter.text(at, Align2::RIGHT_CENTER, text, theme::body(), p.strong);
    let spoken = format!("{name}: {text}");
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &spoken));
    response.on_hover_text(about);
}

/// Means over the number of paths, with their bands.
fn course(ui: &mut Ui, found: &Hemisphere, of_film: Option<f64>) {
    let Some(chart) = Convergence::new(found) else {
        return;
    };
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), CHART);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let plot = Rect::from_min_max(
        rect.min + Vec2::new(LEFT, 4.0),
        rect.max - Vec2::new(0.0, BELOW),
    );
    ui.painter().rect_filled(plot, 2, p.raised);
    let painter = ui.painter_at(plot);
    let at = |x: f64, y: f64| {
        pos2(
            plot.left() + x as f32 * plot.width(),
            plot.bottom() - y as f32 * plot.height(),
        )
    };
    for line in &chart.lines {
        let colour = colour_of(line.estimator, ui).gamma_multiply(0.22);
        for pair in line.band.windows(2) {
            let [[x0, low0, high0], [x1, low1, high1]] = [pair[0], pair[1]];
            let corners = vec![at(x0, low0), at(x1, low1), at(x1, high1), at(x0, high0)];
            painter.add(Shape::convex_polygon(corners, colour, Stroke::NONE));
        }
    }
    for line in &chart.lines {
        let places = line.mean.iter().map(|[x, y]| at(*x, *y)).collect();
        let stroke = Stroke::new(1.5, colour_of(line.estimator, ui));
        painter.add(Shape::line(places, stroke));
    }
    if let Some(film) = of_film {
        let up = chart.up(film - f64::from(found.emitted().luminance()));
        let ends = [at(0.0, up), at(1.0, up)];
        painter.extend(Shape::dashed_line(
            &ends,
            Stroke::new(1.0, p.strong),
            6.0,
            5.0,
        ));
    }
    let [least, most] = chart.values.map(|value| significant(value, 3));
    let numbers = [
        (
            pos2(plot.left() - 4.0, plot.bottom()),
            Align2::RIGHT_BOTTOM,
            least,
        ),
        (pos2(plot.left() - 4.0, plot.top()), Align2::RIGHT_TOP, most),
    ];
    for (at, align, text) in numbers {
        ui.painter().text(at, align, text, theme::small(), p.weak);
    }
    let mut free = f32::NEG_INFINITY;
    for (place, label) in &chart.ticks {
        let x = at(*place, 0.0).x;
        let galley = ui
            .painter()
            .layout_no_wrap(label.clone(), theme::small(), p.weak);
        let left = (x - 0.5 * galley.size().x).max(plot.left());
        if left > free && left + galley.size().x < plot.right() {
            free = left + galley.size().x + GRID;
            let top = pos2(left, plot.bottom() + 1.0);
            ui.painter().galley(top, galley, p.weak);
        }
    }
    let mis = with_interval(&found.estimate_by(Estimator::Mis).measured());
    let spoken = format!("Running means over the number of paths, MIS {mis}");
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &spoken));
    response.on_hover_text(
        "The running mean of each estimator over the number of its paths. A band holds the truth \
         95 times of 100; dashes are the film's pixel.",
    );
}
