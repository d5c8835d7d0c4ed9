//! The help page: every key, from the table that drives them.

use egui::{Align2, Area, Id, Key, Order, Rect, Role, Sense, Ui, Vec2, WidgetInfo, pos2};

use crate::keys;
use crate::theme::{self, GRID, Palette};

/// Draws the page over the window; a click closes it.
pub fn show(ui: &Ui, is_open: &mut bool) {
    let p = Palette::of(ui);
    let window = ui.ctx().content_rect();
    Area::new(Id::unique("help"))
        .order(Order::Foreground)
        .fixed_pos(window.min)
        .show(ui.ctx(), |ui| {
            let response = ui.allocate_rect(window, Sense::click());
            let painter = ui.painter();
            painter.rect_filled(window, 0, p.ground.gamma_multiply(0.7));
            let groups: Vec<&str> = keys::lines().fold(Vec::new(), |mut groups, line| {
                if groups.last() != Some(&line.group) {
                    groups.push(line.group);
                }
                groups
            });
            let is_tight = window.height() < 700.0;
            let row = if is_tight { 18.0 } else { 22.0 };
            let n_columns = if window.width() >= 1100.0 { 3 } else { 2 };
            let columns = columns(&groups, n_columns);
            let column_width = 292.0;
            let n_rows = columns.iter().map(|c| n_rows(c)).max().unwrap_or(0) as f32;
            let size = Vec2::new(
                column_width * n_columns as f32 + 3.0 * GRID,
                n_rows * row + 4.0 * GRID,
            );
            let plate = Rect::from_center_size(window.center(), size.min(window.size()));
            painter.rect(plate, 8, p.panel, (1.0, p.line), egui::StrokeKind::Inside);
            let mut spoken = String::new();
            for (i, column) in columns.iter().enumerate() {
                let x = plate.left() + 3.0 * GRID + column_width * i as f32;
                let mut y = plate.top() + 2.0 * GRID;
                for group in column {
                    let at = pos2(x, y + row / 2.0);
                    painter.text(at, Align2::LEFT_CENTER, group, theme::semibold(), p.text);
                    y += row;
                    for line in keys::lines().filter(|line| line.group == *group) {
                        let center = y + row / 2.0;
                        let keys = pos2(x, center);
                        painter.text(keys, Align2::LEFT_CENTER, line.keys, theme::small(), p.text);
                        let text = pos2(x + 96.0, center);
                        let wide = painter.layout(
                            line.text.to_owned(),
                            theme::small(),
                            p.weak,
                            column_width - 96.0 - GRID,
                        );
                        let height = wide.size().y;
                        let n_lines = (height / 14.0).round().max(1.0);
                        let top = if n_lines > 1.0 {
                            y + 3.0
                        } else {
                            text.y - height / 2.0
                        };
                        painter.galley(pos2(text.x, top), wide, p.weak);
                        y += row + (n_lines - 1.0) * 14.0;
                        spoken.push_str(&format!("{}: {}; ", line.keys, line.text));
                    }
                    y += row * 0.5;
                }
            }
            response.widget_info(|| WidgetInfo::labeled(Role::Dialog, true, "keys"));
            response
                .ctx
                .accesskit_node_builder(response.id, |node| node.set_description(spoken.as_str()));
            if response.clicked() || ui.input(|i| i.key_pressed(Key::Enter)) {
                *is_open = false;
            }
        });
}

/// Rows that a column takes, a blank half between groups rounded up.
fn n_rows(groups: &[&str]) -> usize {
    let lines = keys::lines().filter(|line| groups.contains(&line.group));
    lines.count() + groups.len() + groups.len().div_ceil(2) + 1
}

/// Groups in columns of about the same length, in order.
fn columns<'a>(groups: &[&'a str], n_columns: usize) -> Vec<Vec<&'a str>> {
    let target = n_rows(groups).div_ceil(n_columns);
    let mut columns: Vec<Vec<&str>> = vec![Vec::new()];
    for group in groups {
        let is_last = columns.len() == n_columns;
        let Some(column) = columns.last_mut() else {
            break;
        };
        let mut longer = column.clone();
        longer.push(group);
        if !column.is_empty() && n_rows(&longer) > target + 4 && !is_last {
            columns.push(vec![group]);
        } else {
            *column = longer;
        }
    }
    columns
}
