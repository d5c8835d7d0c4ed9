//! All techniques at once, one row for each bounce; or one of them, large.

use std::sync::Arc;

use egui::{
    Align2, Color32, FontId, Galley, Painter, Pos2, Rect, Response, Role, ScrollArea, Sense,
    Stroke, StrokeKind, TextureId, Ui, UiBuilder, Vec2, WidgetInfo, pos2,
};
use neumann_core::film::{Joint, Strategy, TechniqueFilm, TechniqueImage, View as Part};

use super::pictures::{Allowance, Made, Tile};
use super::words::about_image;
use super::{TechniqueView, description, label};
use crate::display::{ViewSettings, ground};
use crate::formula::Formula;
use crate::session::Session;
use crate::theme::{self, GRID, Palette};
use crate::widgets::{focus_ring, segmented_width, segments};

/// Height of the line above the pyramid.
const HEAD: f32 = 48.0;
/// Width of the names of the rows.
const MARGIN: f32 = 56.0;
/// Height of the label under an image.
const LABEL: f32 = 18.0;
/// Space before the merges of a bounce.
const MERGE_GAP: f32 = 2.0 * GRID;

/// Draws the view into `rect`.
pub(super) fn show(
    ui: &mut Ui,
    rect: Rect,
    view: &mut TechniqueView,
    session: &Session,
    settings: &ViewSettings,
) {
    let p = Palette::of(ui);
    ground::fill(ui, rect, p.ground);
    let head = Rect::from_min_size(rect.min, Vec2::new(rect.width(), HEAD));
    head_line(ui, head, view, &p);
    let below = Rect::from_min_max(pos2(rect.left(), head.bottom()), rect.max);
    let Some(film) = view.film.clone() else {
        let text = if session.link.is_paused() {
            "paused: nothing is recorded until rendering goes on"
        } else {
            "recording …"
        };
        let at = below.center();
        ui.painter()
            .text(at, Align2::CENTER_CENTER, text, theme::body(), p.weak);
        return;
    };
    if let Some(strategy) = view.enlarged {
        enlarged(ui, below, view, &film, settings, strategy);
    } else {
        pyramid(ui, below, view, &film, settings);
    }
}

/// What this is, what it costs, and the choice of image.
fn head_line(ui: &mut Ui, rect: Rect, view: &mut TechniqueView, p: &Palette) {
    let names = TechniqueImage::ALL.map(TechniqueImage::name);
    let width = segmented_width(ui, &names);
    let spot = Rect::from_min_size(
        pos2(rect.right() - 2.0 * GRID - width, rect.center().y - 14.0),
        Vec2::new(width, 28.0),
    );
    let left = rect.left() + 2.0 * GRID;
    let room = spot.left() - GRID - left;
    let middle = rect.center().y;
    let title = [
        "Techniques: s vertices from the light, t from the camera",
        "Techniques (s, t)",
    ];
    let title = fitting(ui, title.map(str::to_owned), room, theme::body(), p.text);
    let at = pos2(left, middle - title.size().y);
    ui.painter().galley(at, title, p.text);
    if let Some(film) = &view.film {
        let megabytes = film.bytes() as f64 / 1e6;
        let (w, h) = (film.width(), film.height());
        let cost = [
            format!("kept apart at {w}×{h}, up to {megabytes:.0} MB"),
            format!("at {w}×{h}, up to {megabytes:.0} MB"),
        ];
        let cost = fitting(ui, cost, room, theme::small(), p.weak);
        ui.painter().galley(pos2(left, middle + 1.0), cost, p.weak);
    }
    let chosen = TechniqueImage::ALL.iter().position(|i| *i == view.image);
    let clicked = ui
        .scope_builder(
            UiBuilder::new().max_rect(spot).id_salt("technique image"),
            |ui| {
                let about = |i: usize| about_image(TechniqueImage::ALL[i]).to_owned();
                segments(ui, "technique image", &names, about, chosen.unwrap_or(0))
            },
        )
        .inner;
    if let Some(i) = clicked {
        view.image = TechniqueImage::ALL[i];
    }
}

/// The longer text if there is room for it, else the shorter.
fn fitting(ui: &Ui, texts: [String; 2], room: f32, font: FontId, color: Color32) -> Arc<Galley> {
    let [long, short] = texts.map(|text| ui.painter().layout_no_wrap(text, font.clone(), color));
    if long.size().x <= room { long } else { short }
}

/// A picture of a row that is brightened by `gain` stops; a weight is shown as it is.
fn made(image: TechniqueImage, version: u64, gain: u8, viewing: &ViewSettings) -> Made {
    let gain = match image {
        TechniqueImage::Weight => 0.0,
        TechniqueImage::Raw | TechniqueImage::Weighted => f32::from(gain),
    };
    Made {
        version,
        image,
        display: (viewing.exposure_ev + gain, viewing.tone),
    }
}

/// Sizes of the pyramid.
struct Layout {
    image: Vec2,
    pitch: Vec2,
    size: Vec2,
    first_merge: Option<usize>,
}

impl Layout {
    /// Images as large as the columns allow, within reason; beyond that it scrolls.
    fn new(view: &TechniqueView, film: &TechniqueFilm, room: Vec2) -> Self {
        let (n_columns, first_merge) = view.columns;
        let n_columns = n_columns.max(1) as f32;
        let gap = first_merge.map_or(0.0, |_| MERGE_GAP);
        let fitting = (room.x - gap) / n_columns - GRID;
        let aspect = film.width() as f32 / film.height().max(1) as f32;
        let tallest = 0.2 * room.y;
        let width = fitting.clamp(88.0, 176.0).min((tallest * aspect).max(64.0));
        let image = Vec2::new(width, width / aspect).round();
        // Labels of merges need some room whatever the shape of the image.
        let pitch = Vec2::new(image.x.max(84.0) + GRID, image.y + LABEL + GRID);
        let size = Vec2::new(
            n_columns * pitch.x + gap,
            view.rows.len() as f32 * pitch.y + GRID,
        );
        Self {
            image,
            pitch,
            size,
            first_merge,
        }
    }

    /// Left edge of a column.
    fn x(&self, column: usize) -> f32 {
        let is_merge = self.first_merge.is_some_and(|first| column >= first);
        column as f32 * self.pitch.x + if is_merge { MERGE_GAP } else { 0.0 }
    }
}

fn pyramid(
    ui: &mut Ui,
    rect: Rect,
    view: &mut TechniqueView,
    film: &TechniqueFilm,
    viewing: &ViewSettings,
) {
    let p = Palette::of(ui);
    let names = Rect::from_min_max(rect.min, pos2(rect.left() + MARGIN, rect.bottom()));
    let room = Rect::from_min_max(names.right_top(), rect.max - Vec2::new(GRID, 0.0));
    let layout = Layout::new(view, film, room.size());
    let names = ui.painter().with_clip_rect(names);
    let mut allowance = Allowance::new();
    ui.scope_builder(UiBuilder::new().max_rect(room), |ui| {
        let area = ScrollArea::both().id_salt("pyramid").auto_shrink(false);
        area.show_viewport(ui, |ui, viewport| {
            let size = layout.size.max(room.size());
            let (content, _) = ui.allocate_exact_size(size, Sense::hover());
            let seen = viewport.translate(content.min.to_vec2()).expand(2.0);
            let left = content.center().x - 0.5 * layout.size.x;
            let (image, version) = (view.image, view.version);
            for (k, row) in view.rows.iter_mut().enumerate() {
                let wanted = made(image, version, row.gain, viewing);
                let top = content.top() + k as f32 * layout.pitch.y;
                let at = pos2(rect.left() + 2.0 * GRID, top + 0.5 * layout.image.y - 16.0);
                name_of_row(&names, at, k, wanted, viewing, &p);
                for tile in &mut row.tiles {
                    let cell = tile.cell;
                    let spot = Rect::from_min_size(
                        pos2((left + layout.x(cell.column)).round(), top.round()),
                        layout.pitch - Vec2::splat(GRID),
                    );
                    let picture = Rect::from_min_size(
                        pos2(spot.center().x - 0.5 * layout.image.x, spot.top()).round(),
                        layout.image,
                    );
                    if !cell.is_made {
                        empty(ui, spot, picture, cell.strategy);
                        continue;
                    }
                    // What is scrolled away can still be reached by keyboard.
                    let response =
                        ui.interact(spot, ui.scope_id().with(cell.strategy), Sense::click());
                    name_for_ears(&response, cell.strategy, cell.share);
                    if response.gained_focus() {
                        response.scroll_to_me(None);
                    }
                    if response.clicked() {
                        view.enlarged = Some(cell.strategy);
                    }
                    if !spot.intersects(seen) {
                        continue;
                    }
                    let texture = tile.picture(ui.ctx(), film, wanted, &mut allowance);
                    paint(ui.painter(), texture, picture);
                    caption(ui, &response, picture, tile);
                }
            }
        });
    });
}

/// The term that a row is of, and by how much it is brightened.
fn name_of_row(
    painter: &Painter,
    at: Pos2,
    k: usize,
    made: Made,
    viewing: &ViewSettings,
    p: &Palette,
) {
    Formula::name(painter, Part::Term(k), theme::BODY, p.text).paint(painter, at);
    let gain = made.display.0 - viewing.exposure_ev;
    if gain > 0.0 {
        let text = format!("+{gain:.0} EV");
        let below = at + Vec2::new(0.0, 20.0);
        painter.text(below, Align2::LEFT_TOP, text, theme::small(), p.weak);
    }
}

/// The frame of a technique that has made nothing yet.
fn empty(ui: &Ui, spot: Rect, picture: Rect, strategy: Strategy) {
    let p = Palette::of(ui);
    let painter = ui.painter();
    painter.rect_stroke(picture, 0, (1.0, p.line), StrokeKind::Inside);
    diagram(painter, picture.min + Vec2::splat(7.0), strategy, &p);
    let at = pos2(picture.center().x, picture.bottom() + 2.0);
    let name = label(strategy);
    painter.text(at, Align2::CENTER_TOP, name, theme::small(), p.weak);
    let response = ui.interact(
        spot,
        ui.scope_id().with(("empty", strategy)),
        Sense::hover(),
    );
    response.on_hover_text(format!("{}: nothing yet", description(strategy)));
}

/// The vertices of a path as circles: those from the camera full, those from the light open. Where
/// both parts were joined the line is dashed; where their ends were merged, one lies in the other.
fn diagram(painter: &Painter, at: Pos2, strategy: Strategy, p: &Palette) {
    const PITCH: f32 = 9.0;
    const RADIUS: f32 = 2.5;
    let (s, t) = (usize::from(strategy.s), usize::from(strategy.t));
    let is_merge = strategy.joint == Joint::Merge;
    let n = s + t - usize::from(is_merge);
    let center = |i: usize| at + Vec2::new(i as f32 * PITCH, 0.0);
    let last = center(n.saturating_sub(1));
    let plate = Rect::from_two_pos(at, last).expand(5.0);
    painter.rect_filled(plate, 5, theme::plate(p));
    for i in 1..n {
        let ends = [
            center(i - 1) + Vec2::new(RADIUS, 0.0),
            center(i) - Vec2::new(RADIUS, 0.0),
        ];
        let is_joint = strategy.joint == Joint::Connect && i == t;
        let stroke = Stroke::new(1.0, if is_joint { p.amber } else { p.weak });
        painter.line_segment(ends, stroke);
    }
    for i in 0..t {
        painter.circle_filled(center(i), RADIUS, p.text);
    }
    for i in n - s..n {
        let is_met = is_merge && i + s == n;
        let radius = if is_met { RADIUS + 1.5 } else { RADIUS };
        painter.circle_stroke(center(i), radius, Stroke::new(1.2, p.amber));
    }
}

/// What stands on and under an image: vertices, share and label.
fn caption(ui: &Ui, response: &Response, picture: Rect, tile: &Tile) {
    let p = Palette::of(ui);
    let painter = ui.painter();
    if response.hovered() {
        let stroke = Stroke::new(1.0, p.strong);
        painter.rect_stroke(picture, 0, stroke, StrokeKind::Outside);
    }
    let strategy = tile.cell.strategy;
    diagram(painter, picture.min + Vec2::splat(7.0), strategy, &p);
    chip(painter, picture.max - Vec2::splat(3.0), tile.cell.share, &p);
    let color = if response.hovered() { p.text } else { p.weak };
    painter.text(
        pos2(picture.center().x, picture.bottom() + 2.0),
        Align2::CENTER_TOP,
        label(strategy),
        theme::small(),
        color,
    );
    focus_ring(ui, response, response.rect, 2);
}

fn name_for_ears(response: &Response, strategy: Strategy, share: f64) {
    let name = format!("technique {}", label(strategy));
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    response.ctx.accesskit_node_builder(response.id, |node| {
        let (text, k) = (description(strategy), strategy.bounce());
        let share = share_text(share);
        node.set_description(format!("{text}, bounce {k}, {share} of the energy"));
    });
}

fn paint(painter: &Painter, texture: Option<TextureId>, rect: Rect) {
    match texture {
        Some(texture) => {
            let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
            painter.image(texture, rect, whole, Color32::WHITE);
        }
        None => {
            painter.rect_filled(rect, 0, Color32::BLACK);
        }
    }
}

fn share_text(share: f64) -> String {
    match 100.0 * share {
        percent if percent >= 9.95 => format!("{percent:.0} %"),
        percent if percent >= 0.05 => format!("{percent:.1} %"),
        percent if percent > 0.0 => "< 0.1 %".to_owned(),
        _ => "0 %".to_owned(),
    }
}

/// The share, with its lower right corner at `corner`.
fn chip(painter: &Painter, corner: Pos2, share: f64, p: &Palette) {
    let galley = painter.layout_no_wrap(share_text(share), theme::small(), p.text);
    let spot = Rect::from_min_max(corner - galley.size() - Vec2::new(8.0, 2.0), corner);
    painter.rect_filled(spot, 3, theme::plate(p));
    painter.galley(spot.min + Vec2::new(4.0, 1.0), galley, p.text);
}

/// One technique as large as there is room.
fn enlarged(
    ui: &mut Ui,
    rect: Rect,
    view: &mut TechniqueView,
    film: &TechniqueFilm,
    viewing: &ViewSettings,
    strategy: Strategy,
) {
    let p = Palette::of(ui);
    let (image, version) = (view.image, view.version);
    let aspect = film.width() as f32 / film.height().max(1) as f32;
    let room = rect.size();
    let size = Vec2::new(room.x.min(room.y * aspect), room.y.min(room.x / aspect));
    let picture = Rect::from_center_size(rect.center(), size.floor());
    let response = ui.interact(rect, ui.scope_id().with("enlarged"), Sense::click());
    let rows = view.rows.iter_mut();
    let mut tiles = rows.flat_map(|row| row.tiles.iter_mut().map(|tile| (row.gain, tile)));
    let Some((gain, tile)) = tiles.find(|(_, tile)| tile.cell.strategy == strategy) else {
        view.enlarged = None;
        return;
    };
    let wanted = made(image, version, gain, viewing);
    let texture = tile.picture(ui.ctx(), film, wanted, &mut Allowance::new());
    let share = tile.cell.share;
    let painter = ui.painter().with_clip_rect(rect);
    paint(&painter, texture, picture);
    let k = strategy.bounce();
    let lines = [
        (label(strategy), theme::sized(theme::CAPTION), p.text),
        (description(strategy), theme::body(), p.text),
        (
            match wanted.display.0 - viewing.exposure_ev {
                gain if gain > 0.0 => format!(
                    "bounce {k} · {} of the energy · {gain:.0} stops brighter",
                    share_text(share)
                ),
                _ => format!("bounce {k} · {} of the energy", share_text(share)),
            },
            theme::small(),
            p.weak,
        ),
    ];
    let wrap = rect.width() - 6.0 * GRID;
    let galleys: Vec<_> = lines
        .into_iter()
        .map(|(text, font, color)| painter.layout(text, font, color, wrap))
        .collect();
    let at = rect.min + Vec2::new(2.0 * GRID, 1.5 * GRID);
    let width = galleys.iter().map(|g| g.size().x).fold(0.0, f32::max);
    let height = galleys.iter().map(|g| g.size().y).sum();
    let spot = Rect::from_min_size(at, Vec2::new(width, height));
    painter.rect_filled(spot.expand2(Vec2::new(GRID, 6.0)), 6, theme::plate(&p));
    let mut y = at.y;
    for galley in galleys {
        let next = y + galley.size().y;
        painter.galley(pos2(at.x, y), galley, p.text);
        y = next;
    }
    focus_ring(ui, &response, rect.shrink(2.0), 2);
    response.widget_info(|| {
        let name = format!("enlarged technique {}", label(strategy));
        WidgetInfo::labeled(Role::Button, true, name)
    });
    response.ctx.accesskit_node_builder(response.id, |node| {
        let (text, share) = (description(strategy), share_text(share));
        node.set_description(format!("{text}, bounce {k}, {share} of the energy"));
    });
    if response.clicked() {
        view.enlarged = None;
    }
}
