//! Errors over processor time, on logarithmic axes, and the time to a quality.

use egui::{Align2, Key, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2};
use neumann_picture::figures::significant;
use neumann_picture::race::{Chart, Point};

use super::RaceView;
use super::tiles::{colour, marker};
use crate::theme::{self, GRID, Palette};
use crate::widgets::focus_ring;

/// Room for numbers on the left and below.
const LEFT: f32 = 6.0 * GRID;
const BELOW: f32 = 2.0 * GRID;
/// Height of the line below.
const LINE: f32 = 20.0;
/// A key makes the quality better or worse by this factor.
const STEP: f64 = 1.122_018_454_301_963_3;

/// Draws the curves, and below them the line.
pub(super) fn show(ui: &mut Ui, rect: Rect, view: &mut RaceView) {
    let p = Palette::of(ui);
    let curves: Vec<&[Point]> = view.report.standings.iter().map(|s| &s.curve[..]).collect();
    let Some(chart) = Chart::new(&curves, view.measure) else {
        let (at, text) = (rect.center(), "no errors yet …");
        ui.painter()
            .text(at, Align2::CENTER_CENTER, text, theme::small(), p.weak);
        return;
    };
    let plot = Rect::from_min_max(
        rect.min + vec2(LEFT, 0.0),
        rect.max - vec2(0.0, BELOW + LINE),
    );
    if plot.height() < 24.0 {
        return quality_line(ui, rect, view);
    }
    ui.painter().rect_filled(plot, 2, p.panel);
    axes(ui, plot, &chart, &p);
    let at = |[x, y]: [f64; 2]| {
        pos2(
            plot.left() + x as f32 * plot.width(),
            plot.bottom() - y as f32 * plot.height(),
        )
    };
    guide(ui, chart.guide.map(at), &p);
    for (i, curve) in curves.iter().enumerate() {
        let places: Vec<Pos2> = curve
            .iter()
            .filter_map(|c| chart.place(c))
            .map(at)
            .collect();
        for place in &places {
            marker(ui, *place, i, 2.5);
        }
        ui.painter()
            .add(Shape::line(places, Stroke::new(2.0, colour(ui, i))));
    }
    let quality = view.times_to_quality().map(|(quality, _)| quality);
    if let Some(y) = quality.and_then(|q| chart.error.place(q)) {
        let y = at([0.0, y.clamp(0.0, 1.0)]).y;
        let stroke = Stroke::new(1.0, p.amber);
        ui.painter().hline(plot.x_range(), y, stroke);
    }
    legend(ui, plot, view, &p);
    take_quality(ui, plot, view, &chart);
    quality_line(ui, rect, view);
}

fn axes(ui: &Ui, plot: Rect, chart: &Chart, p: &Palette) {
    let painter = ui.painter();
    let stroke = Stroke::new(1.0, p.line);
    let mut free = f32::NEG_INFINITY;
    for tick in &chart.seconds.ticks {
        let x = plot.left() + tick.at as f32 * plot.width();
        painter.vline(x, plot.y_range(), stroke);
        let galley = painter.layout_no_wrap(tick.label.clone(), theme::small(), p.weak);
        let left = x - galley.size().x / 2.0;
        // The unit stands at the end.
        if left > free && x + galley.size().x < plot.right() - GRID {
            free = left + galley.size().x + GRID;
            painter.galley(pos2(left, plot.bottom() + 1.0), galley, p.weak);
        }
    }
    let end = pos2(plot.right(), plot.bottom() + 1.0);
    painter.text(end, Align2::RIGHT_TOP, "s", theme::small(), p.weak);
    let mut free = f32::INFINITY;
    for tick in &chart.error.ticks {
        let y = plot.bottom() - tick.at as f32 * plot.height();
        painter.hline(plot.x_range(), y, stroke);
        if y + 6.0 < free && !tick.label.is_empty() && plot.y_range().shrink(4.0).contains(y) {
            free = y - 8.0;
            let at = pos2(plot.left() - 6.0, y);
            painter.text(
                at,
                Align2::RIGHT_CENTER,
                &tick.label,
                theme::small(),
                p.weak,
            );
        }
    }
}

/// The slope of an unbiased method.
fn guide(ui: &Ui, ends: [Pos2; 2], p: &Palette) {
    let stroke = Stroke::new(1.0, p.weak);
    ui.painter()
        .extend(Shape::dashed_line(&ends, stroke, 6.0, 5.0));
}

/// Which error it is, and what the dashes are.
fn legend(ui: &Ui, plot: Rect, view: &RaceView, p: &Palette) {
    let (name, slope) = (view.measure.name(), view.measure.slope_text());
    let text = format!("{name} · - - {slope}");
    let galley = ui.painter().layout_no_wrap(text, theme::small(), p.weak);
    let at = plot.right_top() + vec2(-GRID - galley.size().x, 3.0);
    let plate = Rect::from_min_size(at, galley.size()).expand2(vec2(4.0, 1.0));
    ui.painter()
        .rect_filled(plate, 3, p.panel.gamma_multiply(0.85));
    ui.painter().galley(at, galley, p.weak);
}

/// Lets pointer and arrows choose the quality.
fn take_quality(ui: &mut Ui, plot: Rect, view: &mut RaceView, chart: &Chart) {
    let id = ui.scope_id().with("race quality");
    let response = ui.interact(plot, id, Sense::click_and_drag());
    if response.is_pointer_button_down_on()
        && let Some(at) = response.interact_pointer_pos()
    {
        let y = (plot.bottom() - at.y) / plot.height();
        view.quality = Some(chart.error.value(f64::from(y.clamp(0.0, 1.0))));
    }
    if response.double_clicked() {
        view.quality = None;
    }
    let now = view.times_to_quality().map(|(quality, _)| quality);
    if let Some(now) = now.filter(|_| response.has_focus()) {
        let pressed = |key| ui.input(|input| input.key_pressed(key));
        for (key, factor) in [(Key::ArrowUp, STEP), (Key::ArrowDown, 1.0 / STEP)] {
            if pressed(key) {
                view.quality = Some(now * factor);
            }
        }
        if pressed(Key::Backspace) {
            view.quality = None;
        }
        ui.memory_mut(|memory| {
            let filter = egui::EventFilter {
                vertical_arrows: true,
                ..egui::EventFilter::default()
            };
            memory.set_focus_lock_filter(response.id, filter);
        });
    }
    focus_ring(ui, &response, plot, 2);
    response.widget_info(|| WidgetInfo::slider(true, now.unwrap_or(0.0), "quality"));
    let about = "Errors over processor time. A press chooses the error that the time to is told \
                 of, and so do the arrows; a double click or Backspace, the worst of the latest.";
    response.on_hover_text(about);
}

/// How long each method took to a quality.
fn quality_line(ui: &mut Ui, rect: Rect, view: &RaceView) {
    let Some((quality, times)) = view.times_to_quality() else {
        return;
    };
    let p = Palette::of(ui);
    let name = view.measure.name();
    let standings = view.report.standings.iter();
    let all = standings.zip(times).map(|(standing, time)| {
        let time = time.map_or("not yet".to_owned(), |s| format!("{} s", significant(s, 2)));
        format!("{} {time}", standing.name)
    });
    let all: Vec<String> = all.collect();
    let text = format!(
        "time to {name} {}: {}",
        significant(quality, 2),
        all.join(" · ")
    );
    let mut job = egui::text::LayoutJob::simple_singleline(text.clone(), theme::small(), p.text);
    job.wrap = egui::text::TextWrapping::truncate_at_width(rect.width());
    let galley = ui.painter().layout_job(job);
    let spot = Rect::from_min_max(pos2(rect.left(), rect.bottom() - LINE), rect.max);
    let at = pos2(spot.left(), spot.center().y - galley.size().y / 2.0);
    ui.painter().galley(at, galley, p.text);
    let response = ui.interact(spot, ui.scope_id().with("time to quality"), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &text));
}
