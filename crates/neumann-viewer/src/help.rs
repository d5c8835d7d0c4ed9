//! The help page: every key, from the table that drives them.

use egui::{
    Align2, Area, Id, Key, Order, Painter, Pos2, Rect, Role, ScrollArea, Sense, StrokeKind, Ui,
    UiBuilder, Vec2, WidgetInfo, pos2, vec2,
};

use crate::keys::{self, HelpLine, Places};
use crate::theme::{self, GRID, Palette};

/// Width of a column, and where texts begin in it.
const COLUMN: f32 = 292.0;
const TEXT: f32 = 96.0;

/// Draws the page over the window; a click closes it. Keys are named as `places` prints them.
pub fn show(ui: &Ui, is_open: &mut bool, places: &Places) {
    let p = Palette::of(ui);
    let window = ui.ctx().content_rect();
    Area::new(Id::unique("help"))
        .order(Order::Foreground)
        .fixed_pos(window.min)
        .show(ui.ctx(), |ui| {
            let response = ui.allocate_rect(window, Sense::click());
            let painter = ui.painter();
            painter.rect_filled(window, 0, p.ground.gamma_multiply(0.7));
            let page = Page::new(places, window.size());
            let plate = Rect::from_center_size(window.center(), page.size().min(window.size()));
            painter.rect(plate, 8, p.panel, (1.0, p.line), StrokeKind::Inside);
            let inside = UiBuilder::new().max_rect(plate.shrink2(vec2(0.0, GRID)));
            ui.scope_builder(inside, |ui| {
                ScrollArea::vertical().show(ui, |ui| {
                    let room = page.size() - vec2(0.0, 2.0 * GRID);
                    let (at, _) = ui.allocate_exact_size(room, Sense::hover());
                    page.draw(ui.painter(), at.min + vec2(3.0 * GRID, GRID), &p);
                });
            });
            response.widget_info(|| WidgetInfo::labeled(Role::Dialog, true, "keys"));
            response.ctx.accesskit_node_builder(response.id, |node| {
                node.set_description(page.spoken().as_str());
            });
            if response.clicked() || ui.input(|i| i.key_pressed(Key::Enter)) {
                *is_open = false;
            }
        });
}

/// What stands on the page.
struct Page {
    columns: Vec<Vec<Group>>,
    row: f32,
}

struct Group {
    name: &'static str,
    lines: Vec<(String, &'static HelpLine)>,
}

impl Page {
    fn new(places: &Places, window: Vec2) -> Self {
        let mut groups: Vec<Group> = Vec::new();
        for line in keys::lines() {
            let Some(keys) = places.keys(line) else {
                continue;
            };
            let line = (keys.into_owned(), line);
            match groups.last_mut() {
                Some(group) if group.name == line.1.group => group.lines.push(line),
                _ => groups.push(Group {
                    name: line.1.group,
                    lines: vec![line],
                }),
            }
        }
        let n_columns = match window.x {
            x if x >= 1100.0 => 3,
            x if x >= 2.0 * COLUMN => 2,
            _ => 1,
        };
        Self {
            columns: columns(groups, n_columns),
            row: if window.y < 700.0 { 18.0 } else { 22.0 },
        }
    }

    fn size(&self) -> Vec2 {
        let rows = self.columns.iter().map(|groups| {
            let rows: f32 = groups.iter().map(Group::n_rows).sum();
            rows - BETWEEN
        });
        vec2(
            COLUMN * self.columns.len() as f32 + 3.0 * GRID,
            rows.fold(0.0, f32::max) * self.row + 4.0 * GRID,
        )
    }

    fn draw(&self, painter: &Painter, origin: Pos2, p: &Palette) {
        for (i, groups) in self.columns.iter().enumerate() {
            let x = origin.x + COLUMN * i as f32;
            let mut y = origin.y + self.row / 2.0;
            for group in groups {
                let write = |x, y, text: &str, font, colour| {
                    painter.text(pos2(x, y), Align2::LEFT_CENTER, text, font, colour);
                };
                write(x, y, group.name, theme::semibold(), p.text);
                y += self.row;
                for (keys, line) in &group.lines {
                    write(x, y, keys, theme::small(), p.text);
                    write(x + TEXT, y, line.text, theme::small(), p.weak);
                    y += self.row;
                }
                y += self.row * BETWEEN;
            }
        }
    }

    fn spoken(&self) -> String {
        let lines = self.columns.iter().flatten().flat_map(|group| &group.lines);
        let spoken = lines.map(|(keys, line)| format!("{keys}: {}", line.text));
        spoken.collect::<Vec<_>>().join("; ")
    }
}

/// Rows that are left free between groups.
const BETWEEN: f32 = 0.5;

impl Group {
    fn n_rows(&self) -> f32 {
        self.lines.len() as f32 + 1.0 + BETWEEN
    }
}

/// Groups in columns, in order, the longest of which is as short as can be.
fn columns(groups: Vec<Group>, n_columns: usize) -> Vec<Vec<Group>> {
    let rows: Vec<f32> = groups.iter().map(Group::n_rows).collect();
    let fits = |most: f32| {
        let (mut n, mut filled) = (1, 0.0);
        for rows in &rows {
            if filled + rows > most {
                (n, filled) = (n + 1, 0.0);
            }
            filled += rows;
        }
        n <= n_columns
    };
    let mut most = rows.iter().copied().fold(0.0, f32::max);
    while !fits(most) {
        most += BETWEEN;
    }
    let mut columns: Vec<Vec<Group>> = vec![Vec::new()];
    let mut filled = 0.0;
    for (group, rows) in groups.into_iter().zip(rows) {
        if filled + rows > most {
            columns.push(Vec::new());
            filled = 0.0;
        }
        filled += rows;
        if let Some(column) = columns.last_mut() {
            column.push(group);
        }
    }
    columns
}
