//! One picture of the race as large as there is room, alone or wiped over another one.

use egui::{Color32, CursorIcon, EventFilter, Key, Pos2, Rect, Sense, Ui, UiBuilder};
use egui::{WidgetInfo, pos2, vec2};

use super::RaceView;
use super::tiles::{Picture, facts, picture_of, texture_of, title};
use crate::display::ViewSettings;
use crate::theme::{self, GRID, Palette};
use crate::views::method_menu::line;
use crate::widgets::{focus_ring, segmented_width, segments};

/// Height of the line of facts, and of the choice below it.
const LINE: f32 = 20.0;
const CHOICE: f32 = 32.0;
/// A key moves the line of the wipe by this share of the width.
const STEP: f32 = 0.02;

/// Another picture, right of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wipe {
    /// Its place: a method's, or behind them that of the reference.
    pub with: usize,
    /// Where the line is, from 0 to 1.
    pub at: f32,
}

/// Draws it.
pub(super) fn show(ui: &mut Ui, rect: Rect, view: &mut RaceView, settings: &ViewSettings) {
    let n = view.entries.len() + 1;
    let Some(i) = view.enlarged.filter(|i| *i < n) else {
        view.enlarged = None;
        return;
    };
    view.pictures.resize_with(n, Picture::default);
    let p = Palette::of(ui);
    let size = view.report.reference.as_ref();
    let (w, h) = size.map_or((4.0, 3.0), |r| (r.width as f32, r.height as f32));
    let room = Rect::from_min_max(rect.min, rect.max - vec2(0.0, LINE + CHOICE));
    let scale = (room.width() / w).min(room.height() / h);
    let picture = Rect::from_center_size(room.center(), scale * vec2(w, h)).round();
    if picture_of(ui, picture, view, i, settings) {
        view.enlarged = None;
    }
    let mut told = vec![i];
    if let Some(mut wipe) = view.wipe.filter(|wipe| wipe.with != i && wipe.with < n) {
        let texture = texture_of(ui.ctx(), picture.width(), view, wipe.with, settings);
        let x = picture.left() + wipe.at * picture.width();
        if let Some(texture) = texture {
            let right = Rect::from_min_max(pos2(x, picture.top()), picture.max);
            let part = Rect::from_min_max(pos2(wipe.at, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture, right, part, Color32::WHITE);
        }
        take_line(ui, picture, &mut wipe);
        view.wipe = Some(wipe);
        told.push(wipe.with);
    }
    let texts = told.iter().map(|i| {
        let facts = facts(view, *i);
        format!("{}: {}", title(view, *i), facts.join(", "))
    });
    let texts: Vec<String> = texts.collect();
    let galley = line(
        ui,
        texts.join("  |  "),
        theme::small(),
        p.text,
        rect.width(),
    );
    let left = Pos2::new(rect.center().x - galley.size().x / 2.0, room.bottom() + 3.0);
    ui.painter().galley(left, galley, p.text);
    choice(ui, rect, view, (i, n));
}

/// The line of the wipe, which pointer and arrows move.
fn take_line(ui: &mut Ui, picture: Rect, wipe: &mut Wipe) {
    let p = Palette::of(ui);
    let x = picture.left() + wipe.at * picture.width();
    let grip = Rect::from_x_y_ranges(x - 6.0..=x + 6.0, picture.y_range());
    let response = ui
        .interact(grip, ui.scope_id().with("race wipe"), Sense::drag())
        .on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
    if let Some(at) = response.interact_pointer_pos() {
        wipe.at = (at.x - picture.left()) / picture.width();
    }
    if response.has_focus() {
        let pressed = |key| ui.input(|input| input.key_pressed(key));
        for (key, step) in [(Key::ArrowLeft, -STEP), (Key::ArrowRight, STEP)] {
            if pressed(key) {
                wipe.at += step;
            }
        }
        let filter = EventFilter {
            horizontal_arrows: true,
            ..EventFilter::default()
        };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    }
    wipe.at = wipe.at.clamp(0.0, 1.0);
    ui.painter()
        .vline(x.round() + 0.5, picture.y_range(), (1.0, p.amber));
    focus_ring(ui, &response, grip, 2);
    response.widget_info(|| WidgetInfo::slider(true, f64::from(wipe.at), "wipe line"));
    response.on_hover_text("Drag the line, or move it by the arrows, to see more of either.");
}

/// Which picture stands right of the line.
fn choice(ui: &mut Ui, rect: Rect, view: &mut RaceView, (i, n): (usize, usize)) {
    let others: Vec<usize> = (0..n).filter(|other| *other != i).collect();
    let titles: Vec<String> = others.iter().map(|other| title(view, *other)).collect();
    let mut labels = vec!["alone"];
    labels.extend(titles.iter().map(String::as_str));
    let chosen = view
        .wipe
        .and_then(|wipe| others.iter().position(|o| *o == wipe.with));
    let chosen = chosen.map_or(0, |place| place + 1);
    let width = segmented_width(ui, &labels).min(rect.width());
    let spot = Rect::from_min_size(
        pos2(
            rect.center().x - width / 2.0,
            rect.bottom() - CHOICE + GRID / 2.0,
        ),
        vec2(width, CHOICE),
    );
    let builder = UiBuilder::new().max_rect(spot).id_salt("race wipe with");
    let clicked = ui.scope_builder(builder, |ui| {
        let about = |place: usize| match place {
            0 => "The picture stands alone.".to_owned(),
            place => format!("Right of a line stands the picture by {}.", labels[place]),
        };
        segments(ui, "wipe with", &labels, about, chosen)
    });
    if let Some(place) = clicked.inner {
        let with = place.checked_sub(1).and_then(|place| others.get(place));
        view.wipe = with.map(|with| Wipe {
            with: *with,
            at: 0.5,
        });
    }
}
