//! The pictures of a race, side by side, and what is said of each.

use std::sync::Arc;

use egui::{
    Color32, ColorImage, Context, Pos2, Rect, Role, Sense, StrokeKind, TextureHandle, TextureId,
    TextureOptions, Ui, WidgetInfo, pos2, vec2,
};
use neumann_core::radiometry::Rgb;
use neumann_picture::Image;
use neumann_picture::figures::significant;
use neumann_picture::race::{Point, colours};
use neumann_picture::tone::Display;

use super::{RaceView, Stage, Standing};
use crate::display::ViewSettings;
use crate::theme::{self, GRID, Palette};
use crate::views::method_menu;
use crate::widgets::{cut_line, focus_ring};

/// Height of the names above the pictures, and of a line of facts below them.
const NAME: f32 = 26.0;
const LINE: f32 = 16.0;

/// A picture on a texture.
#[derive(Default)]
pub(super) struct Picture {
    texture: Option<TextureHandle>,
    /// What it was made of.
    of: Option<(Arc<Image>, Display, usize)>,
}

impl Picture {
    /// The texture of an image that is shown so many pixels wide.
    fn show(
        &mut self,
        ctx: &Context,
        image: &Arc<Image>,
        display: Display,
        width: f32,
    ) -> Option<&TextureHandle> {
        let largest = ctx.input(|input| input.max_texture_side);
        let shrinking = (image.width as f32 / width.max(1.0)) as usize;
        let shrinking = shrinking
            .max(image.width.max(image.height).div_ceil(largest))
            .max(1);
        let is_made = self.of.as_ref().is_some_and(|(of, as_, by)| {
            Arc::ptr_eq(of, image) && *as_ == display && *by == shrinking
        });
        if !is_made {
            let pixels = shrunk(image, display, shrinking);
            match &mut self.texture {
                Some(texture) => texture.set(pixels, TextureOptions::LINEAR),
                None => {
                    let options = TextureOptions::LINEAR;
                    self.texture = Some(ctx.load_texture("race", pixels, options));
                }
            }
            self.of = Some((Arc::clone(image), display, shrinking));
        }
        self.texture.as_ref()
    }
}

/// An image as it is shown, of every `n` by `n` pixels their mean radiance.
fn shrunk(image: &Image, display: Display, n: usize) -> ColorImage {
    let size = [(image.width / n).max(1), (image.height / n).max(1)];
    let mut pixels = Vec::with_capacity(size[0] * size[1]);
    for y in 0..size[1] {
        for x in 0..size[0] {
            let mut sum = Rgb::BLACK;
            for row in n * y..(n * y + n).min(image.height) {
                let start = row * image.width + n * x;
                for value in &image.pixels[start..(start + n).min((row + 1) * image.width)] {
                    sum += *value;
                }
            }
            let [r, g, b] = display.srgb8(sum * (1.0 / (n * n) as f32));
            pixels.push(Color32::from_rgb(r, g, b));
        }
    }
    ColorImage::new(size, pixels)
}

/// Height of the row of `n` methods and the reference, which leaves room for the curves.
pub(super) fn height(room: Rect, n: usize, aspect: f32) -> f32 {
    let width = column(room, n + 1).1;
    let most = 0.62 * room.height();
    (width / aspect + NAME + 2.0 * LINE).min(most)
}

/// From column to column, and the width of one.
fn column(room: Rect, n: usize) -> (f32, f32) {
    let gap = 1.5 * GRID;
    let width = (room.width() - (n - 1) as f32 * gap) / n as f32;
    (width + gap, width)
}

/// Draws the pictures of all methods, and behind them the reference.
pub(super) fn row(ui: &mut Ui, rect: Rect, view: &mut RaceView, stage: &mut Stage<'_>) {
    let n = view.entries.len() + 1;
    let (pitch, width) = column(rect, n);
    let aspect = view.aspect(stage.session);
    view.pictures.resize_with(n, Picture::default);
    for i in 0..n {
        let spot = Rect::from_min_size(
            pos2(rect.left() + i as f32 * pitch, rect.top()),
            vec2(width, rect.height()),
        );
        let name = Rect::from_min_size(spot.min, vec2(width, NAME));
        name_of(ui, name, view, i, stage);
        let room = Rect::from_min_max(
            name.left_bottom(),
            pos2(spot.right(), spot.bottom() - 2.0 * LINE),
        );
        let size = vec2(
            room.width().min(room.height() * aspect),
            room.height().min(room.width() / aspect),
        );
        let picture = Rect::from_min_size(room.min, size).round();
        if picture_of(ui, picture, view, i, stage.settings) {
            view.enlarged = Some(i);
        }
        let at = pos2(spot.left(), picture.bottom() + 2.0);
        for (j, fact) in short_facts(ui, view, i, width).into_iter().enumerate() {
            let p = Palette::of(ui);
            let color = if j == 0 { p.weak } else { p.text };
            let galley = cut_line(ui.painter(), fact, theme::small(), color, width);
            let at = at + vec2(0.0, j as f32 * LINE);
            ui.painter().galley(at, galley, color);
        }
    }
}

/// What is said of a picture, in two lines: the longest of what there is room for.
fn short_facts(ui: &Ui, view: &RaceView, i: usize, room: f32) -> [String; 2] {
    let long = facts(view, i);
    let standing = view.report.standings.get(i);
    let Some(point) = standing
        .and_then(|s| s.curve.last())
        .filter(|_| i < view.entries.len())
    else {
        return long;
    };
    let error = significant(view.measure.of(&point.comparison), 3);
    let short = [
        format!("{}, {:.1} s", point.n_iterations, point.seconds),
        format!("{} {error}", view.measure.name()),
    ];
    let shortest = [format!("{:.1} s", point.seconds), error];
    let fits = |text: &String| {
        let painter = ui.painter();
        let galley = painter.layout_no_wrap(text.clone(), theme::small(), Color32::WHITE);
        galley.size().x <= room
    };
    [0, 1].map(|line| {
        let all = [&long[line], &short[line], &shortest[line]];
        all.into_iter()
            .find(|text| fits(text))
            .unwrap_or(all[2])
            .clone()
    })
}

/// The last one's facts, in two lines; what there is to say where there are none.
pub(super) fn facts(view: &RaceView, i: usize) -> [String; 2] {
    let report = &view.report;
    if i == view.entries.len() {
        // What is from the cache is told above.
        let mut parts = report.reference_words.split(", ");
        let first = parts.next().unwrap_or_default().to_owned();
        let rest: Vec<&str> = parts.take(2).collect();
        return [rest.join(", "), first];
    }
    let point = report.standings.get(i).and_then(|s| s.curve.last());
    point.map_or_else(|| ["…".to_owned(), String::new()], Point::facts)
}

/// The colour of a method's curve.
pub(super) fn colour(ui: &Ui, i: usize) -> Color32 {
    let all = colours(ui.visuals().dark_mode);
    let [r, g, b] = all[i.min(all.len() - 1)];
    Color32::from_rgb(r, g, b)
}

/// The name above a picture, which opens the menu of its method.
fn name_of(ui: &mut Ui, rect: Rect, view: &mut RaceView, i: usize, stage: &Stage<'_>) {
    let p = Palette::of(ui);
    let middle = rect.center().y;
    let Some(entry) = view.entries.get(i) else {
        let galley = cut_line(
            ui.painter(),
            "reference".to_owned(),
            theme::semibold(),
            p.text,
            rect.width(),
        );
        let at = pos2(rect.left(), middle - galley.size().y / 2.0);
        ui.painter().galley(at, galley, p.text);
        return;
    };
    let name = entry.entrant(&stage.session.setup).name;
    let mark = |ui: &Ui, at| marker(ui, at, i, 4.5);
    let (response, spot) = method_menu::name_button(ui, rect, i, [&name, "racer"], mark);
    if response.clicked() {
        view.menu.toggle(i, spot, name);
    }
    response.on_hover_text("A click shows other methods to race, and takes this one out.");
}

/// The mark of a method: each has a shape of its own beside its colour.
pub(super) fn marker(ui: &Ui, at: Pos2, i: usize, radius: f32) {
    let (painter, color) = (ui.painter(), colour(ui, i));
    let shape = |points: Vec<Pos2>| egui::Shape::convex_polygon(points, color, egui::Stroke::NONE);
    let off = |x: f32, y: f32| at + radius * vec2(x, y);
    match i {
        0 => {
            painter.circle_filled(at, radius, color);
        }
        1 => {
            let square = Rect::from_center_size(at, egui::Vec2::splat(1.8 * radius));
            painter.rect_filled(square, 0, color);
        }
        2 => {
            painter.add(shape(vec![off(0.0, -1.2), off(1.1, 0.8), off(-1.1, 0.8)]));
        }
        _ => {
            let points = [off(0.0, -1.3), off(1.3, 0.0), off(0.0, 1.3), off(-1.3, 0.0)];
            painter.add(shape(points.into()));
        }
    }
}

/// The picture of a method, or of the reference; true if it was clicked.
pub(super) fn picture_of(
    ui: &mut Ui,
    rect: Rect,
    view: &mut RaceView,
    i: usize,
    settings: &ViewSettings,
) -> bool {
    let p = Palette::of(ui);
    let name = name_for_ears(view, i);
    let response = ui.interact(rect, ui.scope_id().with(("picture", i)), Sense::click());
    let texture = texture_of(ui.ctx(), rect.width(), view, i, settings);
    match texture {
        Some(texture) => {
            let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
            ui.painter().image(texture, rect, whole, Color32::WHITE);
        }
        None => {
            ui.painter()
                .rect_stroke(rect, 0, (1.0, p.line), StrokeKind::Inside);
        }
    }
    if response.hovered() {
        ui.painter()
            .rect_stroke(rect, 0, (1.0, p.strong), StrokeKind::Outside);
    }
    focus_ring(ui, &response, rect, 2);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    let [first, second] = facts(view, i);
    let about = if view.enlarged.is_some() {
        format!("{first}; {second}. A click goes back to all.")
    } else {
        format!("{first}; {second}. A click enlarges the picture.")
    };
    let is_clicked = response.clicked();
    response.on_hover_text(about);
    is_clicked
}

/// The texture of a picture that is shown so many points wide.
pub(super) fn texture_of(
    ctx: &Context,
    width: f32,
    view: &mut RaceView,
    i: usize,
    settings: &ViewSettings,
) -> Option<TextureId> {
    let image = match standing(view, i) {
        Some(standing) => standing.image.clone(),
        None => view.report.reference.clone(),
    };
    let picture = view.pictures.get_mut(i)?;
    let width = width * ctx.pixels_per_point();
    let texture = picture.show(ctx, &image?, settings.display(), width);
    texture.map(TextureHandle::id)
}

/// The method of a picture; `None` of the reference.
fn standing(view: &RaceView, i: usize) -> Option<&Standing> {
    let mut standings = view.report.standings.iter().take(view.entries.len());
    standings.nth(i)
}

/// What a picture is by.
pub(super) fn title(view: &RaceView, i: usize) -> String {
    standing(view, i).map_or_else(|| "reference".to_owned(), |s| s.name.clone())
}

fn name_for_ears(view: &RaceView, i: usize) -> String {
    format!("picture by {}", title(view, i))
}
