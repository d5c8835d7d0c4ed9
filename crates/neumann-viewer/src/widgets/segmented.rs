//! One of several: a segmented row, tabs, and a named choice.

use egui::{Align2, Rect, Role, Sense, Ui, Vec2, WidgetInfo, pos2};

use super::focus_ring;
use crate::theme::{self, GRID, Palette, ROW};

/// Width that [`segments`] needs for these labels.
#[must_use]
pub fn segmented_width(ui: &Ui, labels: &[&str]) -> f32 {
    labels.iter().map(|l| segment_width(ui, l)).sum::<f32>() + 4.0
}

fn segment_width(ui: &Ui, label: &str) -> f32 {
    let color = Palette::of(ui).text;
    let galley = ui
        .painter()
        .layout_no_wrap(label.to_owned(), theme::body(), color);
    (galley.size().x + 2.5 * GRID).round()
}

/// A row of segments of which one is chosen, where `about` says what each of them is; yields the
/// one that was clicked.
pub fn segments(
    ui: &mut Ui,
    name: &str,
    labels: &[&str],
    about: impl Fn(usize) -> String,
    chosen: usize,
) -> Option<usize> {
    let widths: Vec<f32> = labels.iter().map(|l| segment_width(ui, l)).collect();
    row_of_segments(ui, name, labels, &about, chosen, &widths)
}

fn row_of_segments(
    ui: &mut Ui,
    name: &str,
    labels: &[&str],
    about: &dyn Fn(usize) -> String,
    chosen: usize,
    widths: &[f32],
) -> Option<usize> {
    let p = Palette::of(ui);
    let total: f32 = widths.iter().sum();
    let (rect, _) = ui.allocate_exact_size(Vec2::new(total + 4.0, ROW + 4.0), Sense::hover());
    ui.painter().rect_filled(rect, 6, ground(ui));
    let mut x = rect.left() + 2.0;
    let mut clicked = None;
    for (i, (label, width)) in labels.iter().zip(widths).enumerate() {
        let segment = Rect::from_min_size(pos2(x, rect.top() + 2.0), Vec2::new(*width, ROW));
        x += width;
        let id = ui.scope_id().with((name, i));
        let response = ui.interact(segment, id, Sense::click());
        let is_chosen = i == chosen;
        if is_chosen {
            ui.painter().rect_filled(segment, 4, p.chosen);
        }
        let color = if is_chosen || response.hovered() {
            p.strong
        } else {
            p.weak
        };
        let font = theme::body();
        ui.painter()
            .text(segment.center(), Align2::CENTER_CENTER, label, font, color);
        focus_ring(ui, &response, segment, 4);
        response.widget_info(|| {
            WidgetInfo::selected(
                Role::RadioButton,
                ui.is_enabled(),
                is_chosen,
                format!("{name}: {label}"),
            )
        });
        if response.clicked() {
            clicked = Some(i);
        }
        response.on_hover_text(about(i));
    }
    clicked
}

fn ground(ui: &Ui) -> egui::Color32 {
    let p = Palette::of(ui);
    if ui.visuals().dark_mode {
        p.ground
    } else {
        p.raised
    }
}

/// Tabs over a panel: words, the chosen one underlined, where `about` says what stands on each of
/// them; yields the one that was clicked.
///
/// The chosen one is given the keyboard if `takes_keyboard`.
pub fn tabs(
    ui: &mut Ui,
    labels: &[&str],
    about: impl Fn(usize) -> String,
    chosen: usize,
    takes_keyboard: bool,
) -> Option<usize> {
    let p = Palette::of(ui);
    let (bar, _) = ui.allocate_exact_size(Vec2::new(ui.available_width(), 32.0), Sense::hover());
    let width = |label: &&str| {
        let galley = ui
            .painter()
            .layout_no_wrap((*label).to_owned(), theme::body(), p.text);
        galley.size().x
    };
    let widths: Vec<f32> = labels.iter().map(width).collect();
    let spare = bar.width() - widths.iter().sum::<f32>();
    let gap = (spare / labels.len().saturating_sub(1).max(1) as f32).clamp(GRID, 2.0 * GRID);
    let mut x = bar.left();
    let mut clicked = None;
    for (i, (label, width)) in labels.iter().zip(widths).enumerate() {
        let rect = Rect::from_min_size(pos2(x, bar.top()), Vec2::new(width, 32.0));
        x = rect.right() + gap;
        let response = ui.interact(
            rect.expand2(Vec2::new(GRID / 2.0, 0.0)),
            ui.scope_id().with(("tab", i)),
            Sense::click(),
        );
        let is_chosen = i == chosen;
        let color = if is_chosen || response.hovered() {
            p.strong
        } else {
            p.weak
        };
        ui.painter().text(
            rect.center(),
            Align2::CENTER_CENTER,
            label,
            theme::body(),
            color,
        );
        if is_chosen {
            let line = Rect::from_min_max(pos2(rect.left(), rect.bottom() - 2.0), rect.max);
            ui.painter().rect_filled(line, 0, p.amber);
        }
        if is_chosen && takes_keyboard {
            response.request_focus();
        }
        focus_ring(ui, &response, rect.shrink2(Vec2::new(-4.0, 6.0)), 4);
        response
            .widget_info(|| WidgetInfo::selected(Role::Tab, ui.is_enabled(), is_chosen, *label));
        if response.clicked() {
            clicked = Some(i);
        }
        response.on_hover_text(about(i));
    }
    clicked
}

/// As [`choice_row`], with one sentence that says what is chosen.
pub fn explained_choice(
    ui: &mut Ui,
    name: &str,
    about: &str,
    labels: &[&str],
    chosen: usize,
) -> Option<usize> {
    choice_row(ui, name, labels, |_| about.to_owned(), chosen)
}

/// A name, and below it a row of segments as wide as the panel, where `about` says what each of
/// them is; yields the one that was clicked.
pub fn choice_row(
    ui: &mut Ui,
    name: &str,
    labels: &[&str],
    about: impl Fn(usize) -> String,
    chosen: usize,
) -> Option<usize> {
    ui.add_space(GRID / 2.0);
    let title = ui.label(name);
    if labels.len() > chosen {
        title.on_hover_text(about(chosen));
    }
    // Closer together than in a bar, so that five words fit a panel.
    let natural: Vec<f32> = labels
        .iter()
        .map(|l| segment_width(ui, l) - 1.5 * GRID)
        .collect();
    let room = ui.available_width() - 4.0;
    let total: f32 = natural.iter().sum();
    if total <= room {
        let spare = (room - total) / labels.len().max(1) as f32;
        let widths: Vec<f32> = natural.iter().map(|w| w + spare).collect();
        return row_of_segments(ui, name, labels, &about, chosen, &widths);
    }
    let mut clicked = None;
    for (i, label) in labels.iter().enumerate() {
        let row = super::row_button(ui, label, "", i == chosen);
        if row.on_hover_text(about(i)).clicked() {
            clicked = Some(i);
        }
    }
    clicked
}

/// A heading, and below it rows of so many segments, as wide as the panel, of which one at most is
/// chosen; yields the one that was clicked. `about` says what each of them is.
pub fn choice_rows(
    ui: &mut Ui,
    name: &str,
    labels: &[&str],
    about: impl Fn(usize) -> String,
    per_row: usize,
    chosen: Option<usize>,
) -> Option<usize> {
    super::heading(ui, name);
    let room = ui.available_width() - 4.0;
    let mut clicked = None;
    for (row, labels) in labels.chunks(per_row).enumerate() {
        let first = row * per_row;
        let widths = vec![room / per_row as f32; labels.len()];
        let chosen = chosen.and_then(|i| i.checked_sub(first));
        let about = |i: usize| about(first + i);
        let chosen = chosen.unwrap_or(usize::MAX);
        let in_row = ui.push_id(row, |ui| {
            row_of_segments(ui, name, labels, &about, chosen, &widths)
        });
        let in_row = in_row.inner;
        clicked = clicked.or(in_row.map(|i| first + i));
    }
    clicked
}
