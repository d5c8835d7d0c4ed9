//! All techniques at once, one row for each bounce; or one of them, large.

use std::sync::Arc;

use egui::{
    Align2, Color32, FontId, Galley, Painter, Pos2, Rect, Response, Role, ScrollArea, Sense,
    Stroke, StrokeKind, TextureId, Ui, UiBuilder, Vec2, WidgetInfo, pos2,
};
use neumann_core::film::{Joint, Strategy, TechniqueFilm, TechniqueImage, View as Part};

use super::pictures::{Allowance, Made, Tile};
use super::{TechniqueView, description, label};
use crate::display::{ViewSettings, ground};
use crate::formula::Formula;
use crate::session::Session;
use crate::theme::{self, GRID, Palette};
use crate::widgets::{focus_ring, segmented, segmented_width};

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
        } else if session.picture.stats.is_done {
            "done: begin again (R) to record"
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
            |ui| segmented(ui, "technique image", &names, chosen.unwrap_or(0)),
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

fn made(view: &TechniqueView, viewing: &ViewSettings) -> Made {
    Made {
        version: view.version,
        image: view.image,
        display: (viewing.exposure_ev, viewing.tone),
    }
}

/// Sizes of the pyramid.
struct Layout {
    image: Vec2,
    pitch: Vec2,
    size: Vec2,
}

impl Layout {
    /// Images as large as the widest row allows, within reason; beyond that it scrolls.
    fn new(view: &TechniqueView, film: &TechniqueFilm, room: Vec2) -> Self {
        let widest = view.rows.iter().map(Vec::len).max().unwrap_or(1).max(1) as f32;
        let fitting = (room.x - MERGE_GAP) / widest - GRID;
        let aspect = film.width() as f32 / film.height().max(1) as f32;
        let tallest = 0.2 * room.y;
        let width = fitting.clamp(88.0, 176.0).min((tallest * aspect).max(64.0));
        let image = Vec2::new(width, width / aspect).round();
        // Labels of merges need some room whatever the shape of the image.
        let pitch = Vec2::new(image.x.max(84.0) + GRID, image.y + LABEL + GRID);
        let n_rows = view.rows.iter().filter(|row| !row.is_empty()).count();
        let size = Vec2::new(widest * pitch.x + MERGE_GAP, n_rows as f32 * pitch.y + GRID);
        Self { image, pitch, size }
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
    let wanted = made(view, viewing);
    let names = Rect::from_min_max(rect.min, pos2(rect.left() + MARGIN, rect.bottom()));
    let room = Rect::from_min_max(names.right_top(), rect.max - Vec2::new(GRID, 0.0));
    let layout = Layout::new(view, film, room.size());
    let names = ui.painter().with_clip_rect(names);
    let mut area = ScrollArea::both().id_salt("pyramid").auto_shrink(false);
    if !view.is_centered {
        view.is_centered = true;
        area = area.horizontal_scroll_offset(0.5 * (layout.size.x - room.width()).max(0.0));
    }
    let mut allowance = Allowance::new();
    ui.scope_builder(UiBuilder::new().max_rect(room), |ui| {
        area.show_viewport(ui, |ui, viewport| {
            let size = layout.size.max(room.size());
            let (content, _) = ui.allocate_exact_size(size, Sense::hover());
            let seen = viewport.translate(content.min.to_vec2()).expand(2.0);
            let rows = view.rows.iter_mut().enumerate();
            let rows = rows.filter(|(_, row)| !row.is_empty());
            for (place, (k, row)) in rows.enumerate() {
                let top = content.top() + place as f32 * layout.pitch.y;
                let at = pos2(rect.left() + 2.0 * GRID, top + 0.5 * layout.image.y - 10.0);
                Formula::name(&names, Part::Term(k), theme::BODY, p.text).paint(&names, at);
                let is_merge = |s: Strategy| s.joint == Joint::Merge;
                let has_merges = row.iter().any(|tile| is_merge(tile.strategy));
                let gap = if has_merges { MERGE_GAP } else { 0.0 };
                let width = row.len() as f32 * layout.pitch.x + gap;
                let left = content.center().x - 0.5 * width;
                for (i, tile) in row.iter_mut().enumerate() {
                    let x =
                        i as f32 * layout.pitch.x + if is_merge(tile.strategy) { gap } else { 0.0 };
                    let spot = Rect::from_min_size(
                        pos2((left + x).round(), top.round()),
                        layout.pitch - Vec2::splat(GRID),
                    );
                    // What is scrolled away can still be reached by keyboard.
                    let response =
                        ui.interact(spot, ui.scope_id().with(tile.strategy), Sense::click());
                    name_for_ears(&response, tile.strategy, tile.share);
                    if response.gained_focus() {
                        response.scroll_to_me(None);
                    }
                    if response.clicked() {
                        view.enlarged = Some(tile.strategy);
                    }
                    if !spot.intersects(seen) {
                        continue;
                    }
                    let texture = tile.picture(ui.ctx(), film, wanted, &mut allowance);
                    let picture = Rect::from_min_size(
                        pos2(spot.center().x - 0.5 * layout.image.x, spot.top()).round(),
                        layout.image,
                    );
                    paint(ui.painter(), texture, picture);
                    caption(ui, &response, picture, tile);
                }
            }
        });
    });
}

/// What stands on and under an image: share and label.
fn caption(ui: &Ui, response: &Response, picture: Rect, tile: &Tile) {
    let p = Palette::of(ui);
    let painter = ui.painter();
    if response.hovered() {
        let stroke = Stroke::new(1.0, p.strong);
        painter.rect_stroke(picture, 0, stroke, StrokeKind::Outside);
    }
    chip(painter, picture.max - Vec2::splat(3.0), tile.share, &p);
    let color = if response.hovered() { p.text } else { p.weak };
    painter.text(
        pos2(picture.center().x, picture.bottom() + 2.0),
        Align2::CENTER_TOP,
        label(tile.strategy),
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
    let wanted = made(view, viewing);
    let aspect = film.width() as f32 / film.height().max(1) as f32;
    let room = rect.size();
    let size = Vec2::new(room.x.min(room.y * aspect), room.y.min(room.x / aspect));
    let picture = Rect::from_center_size(rect.center(), size.floor());
    let response = ui.interact(rect, ui.scope_id().with("enlarged"), Sense::click());
    let mut tiles = view.rows.iter_mut().flatten();
    let Some(tile) = tiles.find(|tile| tile.strategy == strategy) else {
        view.enlarged = None;
        return;
    };
    let texture = tile.picture(ui.ctx(), film, wanted, &mut Allowance::new());
    let share = tile.share;
    let painter = ui.painter().with_clip_rect(rect);
    paint(&painter, texture, picture);
    let k = strategy.bounce();
    let lines = [
        (label(strategy), theme::sized(theme::CAPTION), p.text),
        (description(strategy), theme::body(), p.text),
        (
            format!("bounce {k} · {} of the energy", share_text(share)),
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
