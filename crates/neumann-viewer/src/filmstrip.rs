//! The lecture's own figure, alive: the terms of the series, and below them its partial sums.

use egui::scroll_area::ScrollBarVisibility;
use egui::{
    Align2, Rect, Role, ScrollArea, Sense, Stroke, StrokeKind, Ui, UiBuilder, Vec2, WidgetInfo,
    pos2,
};
use neumann_core::film::View;

use crate::display::{Draw, Slot, ViewSettings};
use crate::formula::{self, Formula};
use crate::picture::Picture;
use crate::theme::{self, GRID, Palette};
use crate::widgets::{focus_ring, segmented_width, segments, significant};

/// What the filmstrip looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// One row, names and shares only.
    Folded,
    /// Two rows of pictures of that height, points.
    Rows(f32),
}

impl Form {
    /// What suits a window of that size.
    #[must_use]
    pub fn of(window: Vec2) -> Self {
        if window.y < 640.0 || window.x < 1000.0 {
            Self::Folded
        } else if window.y < 960.0 {
            Self::Rows(80.0)
        } else {
            Self::Rows(112.0)
        }
    }

    /// What suits a window of that size when it is presented.
    #[must_use]
    pub fn presented(window: Vec2) -> Self {
        if window.y < 360.0 || window.x < 640.0 {
            Self::Folded
        } else {
            Self::Rows(72.0)
        }
    }

    /// Height that it takes, points.
    #[must_use]
    pub fn height(self) -> f32 {
        match self {
            Self::Folded => 44.0,
            Self::Rows(height) => 2.0 * height + 3.0 * GRID,
        }
    }
}

/// Width of the names of the rows.
const MARGIN: f32 = 80.0;

/// Draws the filmstrip into `rect`; a click chooses a view. Thumbnails are draw calls from number
/// `first_draw` on; yields the number of the next.
pub fn show(
    ui: &mut Ui,
    rect: Rect,
    form: Form,
    picture: &Picture,
    settings: &mut ViewSettings,
    first_draw: usize,
) -> usize {
    let p = Palette::of(ui);
    theme::fill_panel(ui, rect);
    ui.painter()
        .hline(rect.x_range(), rect.top(), (1.0, p.line));
    let n_layers = picture.shares.len().saturating_sub(1).max(1);
    let n_layers = if picture.shares.is_empty() {
        8
    } else {
        n_layers
    };
    let Form::Rows(row_height) = form else {
        chips(
            ui,
            rect.shrink2(Vec2::new(2.0 * GRID, GRID)),
            picture,
            settings,
            n_layers,
        );
        return first_draw;
    };
    let top = |is_sum: bool| {
        let row = if is_sum { row_height + GRID } else { 0.0 };
        rect.top() + GRID + row
    };
    for is_sum in [false, true] {
        let middle = top(is_sum) + row_height / 2.0;
        row_name(ui, pos2(rect.left() + 2.0 * GRID, middle), is_sum);
    }
    let room = Rect::from_min_max(
        pos2(rect.left() + MARGIN, rect.top()),
        pos2(rect.right() - 2.0 * GRID, rect.bottom()),
    );
    let mut next_draw = first_draw;
    let chosen = settings.place(n_layers).1;
    let widths = (NARROWEST_TILE, GRID);
    side_by_side(
        ui,
        room,
        n_layers + 1,
        widths,
        chosen,
        |ui, place, column| {
            for is_sum in [false, true] {
                let at = pos2(column.left(), top(is_sum));
                let tile = Rect::from_min_size(at, Vec2::new(column.width(), row_height));
                let which = (is_sum, place, n_layers);
                tile_of(ui, tile, picture, settings, which, next_draw);
                next_draw += 1;
            }
        },
    );
    next_draw
}

/// Narrower tiles and chips than these have no room for their names: the strip scrolls instead.
const NARROWEST_TILE: f32 = 92.0;
const NARROWEST_CHIP: f32 = 44.0;

/// Calls `draw` with the places of a row that are seen, and where they stand: side by side, of a
/// least width and with a gap between them (`widths`). Where there are more than `room` has place
/// for, the row scrolls, and the place that is chosen comes into view.
fn side_by_side(
    ui: &mut Ui,
    room: Rect,
    n: usize,
    widths: (f32, f32),
    chosen: usize,
    mut draw: impl FnMut(&mut Ui, usize, Rect),
) {
    let (least, gap) = widths;
    let pitch = ((room.width() + gap) / n as f32).max(least + gap);
    let last = ui.scope_id().with("chosen place");
    let is_new = ui.data_mut(|data| data.get_temp_mut_or(last, usize::MAX) != &chosen);
    ui.data_mut(|data| data.insert_temp(last, chosen));
    ui.scope_builder(UiBuilder::new().max_rect(room).id_salt("places"), |ui| {
        ui.style_mut().always_scroll_the_only_direction = true;
        ScrollArea::horizontal()
            .scroll_bar_visibility(ScrollBarVisibility::AlwaysHidden)
            .auto_shrink(false)
            .show(ui, |ui| {
                let size = Vec2::new(pitch * n as f32 - gap, room.height());
                let (all, _) = ui.allocate_exact_size(size, Sense::hover());
                for place in 0..n {
                    let left = (all.left() + pitch * place as f32).round();
                    let right = (all.left() + pitch * (place + 1) as f32 - gap).round();
                    let column = Rect::from_x_y_ranges(left..=right, room.y_range());
                    if place == chosen && is_new {
                        ui.scroll_to_rect(column, None);
                    }
                    if column.intersects(ui.clip_rect()) {
                        draw(ui, place, column);
                    }
                }
            });
    });
}

/// What a row of the strip shows.
fn about_row(index: usize) -> String {
    let about = [
        "One term of the series each: light scattered k times.",
        "Partial sums: light scattered up to k times.",
    ];
    about[index].to_owned()
}

fn row_name(ui: &Ui, at: egui::Pos2, is_sum: bool) {
    let p = Palette::of(ui);
    let painter = ui.painter();
    let name = if is_sum { "sums" } else { "terms" };
    painter.text(at, Align2::LEFT_BOTTOM, name, theme::body(), p.text);
    if is_sum {
        painter.text(at, Align2::LEFT_TOP, "up to k", theme::small(), p.weak);
    } else {
        Formula::general_term(painter, theme::SMALL, p.weak).paint(painter, at);
    }
}

/// What a place on the strip shows.
fn view_at(is_sum: bool, place: usize, n_layers: usize) -> View {
    let mut settings = ViewSettings::default();
    settings.choose(is_sum, place, n_layers);
    settings.part
}

fn tile_of(
    ui: &Ui,
    tile: Rect,
    picture: &Picture,
    settings: &mut ViewSettings,
    (is_sum, place, n_layers): (bool, usize, usize),
    draw: usize,
) {
    let p = Palette::of(ui);
    let view = view_at(is_sum, place, n_layers);
    let response = ui.interact(
        tile,
        ui.scope_id().with(("tile", is_sum, place)),
        Sense::click(),
    );
    if response.clicked() {
        settings.part = view;
    }
    let is_chosen = settings.part == view;
    let fill = if response.hovered() {
        p.hovered
    } else {
        p.raised
    };
    let painter = ui.painter();
    let painter = painter.with_clip_rect(tile.expand(2.0).intersect(painter.clip_rect()));
    painter.rect_filled(tile, 4, fill);
    let inner = tile.shrink(3.0);
    let aspect = picture
        .thumbnails
        .first()
        .map_or(1.0, |t| t.width as f32 / t.height.max(1) as f32);
    let bar_height = 3.0;
    let largest_in = |room: Vec2| {
        if room.x / room.y > aspect {
            Vec2::new(room.y * aspect, room.y)
        } else {
            Vec2::new(room.x, room.x / aspect)
        }
    };
    let below = Vec2::new(inner.width(), inner.height() - 20.0 - bar_height);
    let beside = Vec2::new(inner.width() - 60.0, inner.height() - bar_height - 2.0);
    // The text stands where it leaves the picture more room.
    let has_text_below = aspect > 1.3 || largest_in(below).x > largest_in(beside).x;
    let room = if has_text_below { below } else { beside };
    let size = largest_in(room);
    let image = if has_text_below {
        let center = pos2(inner.center().x, inner.top() + room.y / 2.0);
        Rect::from_center_size(center, size)
    } else {
        Rect::from_min_size(
            pos2(inner.left(), inner.top() + (room.y - size.y) / 2.0),
            size,
        )
    };
    let image = Rect::from_min_max(image.min.round(), image.max.round());
    let n_rows = 2 * picture.thumbnails.len();
    if n_rows == 0 {
        painter.rect_filled(image, 0, egui::Color32::BLACK);
    } else {
        let mut look = settings.look();
        let row = place + if is_sum { picture.thumbnails.len() } else { 0 };
        // Half a texel is left out above and below, so that neighbours do not shine in.
        let height = picture.thumbnails.first().map_or(1, |t| t.height) as f32;
        let texel = 1.0 / (n_rows as f32 * height);
        let origin = row as f32 / n_rows as f32 + 0.5 * texel;
        look.left = [0.0, origin, 1.0, 1.0 / n_rows as f32 - texel];
        look.right = look.left;
        painter.add(egui_wgpu::Callback::new_paint_callback(
            image,
            Draw {
                planes: picture.planes.clone(),
                left: Slot::Thumbnails,
                right: Slot::Thumbnails,
                look,
                variant: settings.variant(true),
                index: draw,
            },
        ));
    }
    let share = picture.share(view);
    let share_text = share.map_or_else(String::new, |s| format!("{:.1} %", 100.0 * s));
    let name_color = if is_chosen { p.strong } else { p.text };
    let name = Formula::name(&painter, view, theme::BODY, name_color);
    if has_text_below {
        // Name and share stand on one line.
        let y = inner.bottom() - bar_height - 10.0;
        let share_text = painter.layout_no_wrap(share_text, theme::small(), p.weak);
        let at = Align2::RIGHT_CENTER.anchor_size(pos2(inner.right() - 3.0, y), share_text.size());
        let baseline = formula::baseline_of(&share_text).map_or(y + 4.0, |b| at.top() + b);
        painter.galley(at.min, share_text, p.weak);
        let top = baseline - formula::LINE_BASELINE * theme::BODY;
        name.paint(&painter, pos2(inner.left() + 3.0, top));
    } else {
        let x = image.right() + GRID;
        name.paint(&painter, pos2(x, inner.center().y - 18.0));
        let at = pos2(x, inner.center().y + 8.0);
        painter.text(at, Align2::LEFT_CENTER, share_text, theme::small(), p.weak);
    }
    let track = Rect::from_min_max(
        pos2(tile.left() + 3.0, tile.bottom() - 4.0),
        tile.max - Vec2::new(3.0, 2.0),
    );
    painter.rect_filled(track, 1, p.line);
    let width = track.width() * share.unwrap_or(0.0).clamp(0.0, 1.0) as f32;
    let filled = Rect::from_min_size(track.min, Vec2::new(width, track.height()));
    painter.rect_filled(filled, 1, if is_chosen { p.amber } else { p.fill });
    if is_chosen {
        let stroke = Stroke::new(1.5, p.amber);
        painter.rect_stroke(tile, 4, stroke, StrokeKind::Inside);
    }
    focus_ring(ui, &response, tile, 4);
    explain(response, view, is_chosen, picture);
}

/// Says what a place shows: for whoever does not see it, and where the pointer rests on it.
fn explain(response: egui::Response, view: View, is_chosen: bool, picture: &Picture) {
    response.widget_info(|| {
        WidgetInfo::selected(Role::RadioButton, true, is_chosen, formula::spoken(view))
    });
    let about = about(view, picture);
    response.ctx.accesskit_node_builder(response.id, |node| {
        node.set_description(about.as_str());
    });
    response.on_hover_text(about);
}

/// What a view shows, its share of the energy and its error, as far as they are known.
fn about(view: View, picture: &Picture) -> String {
    let share = picture.share(view);
    let share = share.map(|s| format!(", {:.1} % of the energy", 100.0 * s));
    let error = picture.error(view).map(|error| {
        let percent = significant(100.0 * error, 2);
        format!(", error about {percent} %")
    });
    let [share, error] = [share, error].map(Option::unwrap_or_default);
    format!("{}{share}{error}", view.caption())
}

/// The strip of a small window: one row, names and shares only.
fn chips(ui: &mut Ui, rect: Rect, picture: &Picture, settings: &mut ViewSettings, n_layers: usize) {
    let p = Palette::of(ui);
    let (is_sum, place) = settings.place(n_layers);
    let labels = ["terms", "sums"];
    let width = segmented_width(ui, &labels);
    let switch = Rect::from_min_size(rect.min, Vec2::new(width, rect.height()));
    let clicked = ui
        .scope_builder(UiBuilder::new().max_rect(switch).id_salt("row"), |ui| {
            segments(ui, "row", &labels, about_row, usize::from(is_sum))
        })
        .inner;
    if let Some(row) = clicked {
        settings.choose(row == 1, place, n_layers);
    }
    let room = Rect::from_min_max(pos2(switch.right() + GRID, rect.top()), rect.max);
    let chosen = settings.place(n_layers).1;
    let widths = (NARROWEST_CHIP, 4.0);
    side_by_side(ui, room, n_layers + 1, widths, chosen, |ui, place, chip| {
        let view = view_at(is_sum, place, n_layers);
        let response = ui.interact(
            chip,
            ui.scope_id().with(("tile", is_sum, place)),
            Sense::click(),
        );
        if response.clicked() {
            settings.part = view;
        }
        let is_chosen = settings.part == view;
        let fill = if response.hovered() {
            p.hovered
        } else {
            p.raised
        };
        let painter = ui.painter();
        let painter = painter.with_clip_rect(chip.intersect(painter.clip_rect()));
        painter.rect_filled(chip, 4, fill);
        let share = picture.share(view);
        let text = share.map_or_else(String::new, |s| format!("{:.0} %", 100.0 * s));
        let name = Formula::name(&painter, view, theme::BODY, p.text);
        let y = chip.center().y;
        name.paint(&painter, pos2(chip.left() + 6.0, y - 10.0));
        let at = pos2(chip.right() - 6.0, y);
        let shown = painter.layout_no_wrap(text, theme::small(), p.weak);
        // Beside the name, where there is room for both.
        if name.size.x + shown.size().x + 16.0 <= chip.width() {
            let at = at - Vec2::new(shown.size().x, shown.size().y / 2.0);
            painter.galley(at, shown, p.weak);
        }
        if is_chosen {
            let stroke = Stroke::new(1.5, p.amber);
            painter.rect_stroke(chip, 4, stroke, StrokeKind::Inside);
        }
        focus_ring(ui, &response, chip, 4);
        explain(response, view, is_chosen, picture);
    });
}
