//! One viewing direction: the angle, a polar plot, the lobe in space, the density with drawn
//! directions, and figures.

use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

use egui::epaint::Vertex;
use egui::{
    Align2, Color32, ColorImage, Context, Mesh, Pos2, Rect, Role, Sense, Shape, Stroke,
    TextureHandle, TextureOptions, Ui, UiBuilder, WidgetInfo, pos2, vec2,
};
use neumann_core::render::lobe::{LARGEST_ANGLE, Lobes, Viewed};
use neumann_picture::figures::significant;
use neumann_picture::hemisphere::ring;
use neumann_picture::lobe::{Disk, Plot, Radius, SolidStyle, Turn, draw, figures};

use super::{LobeView, polar};
use crate::theme::{self, GRID, Palette};
use crate::views::turning;
use crate::widgets::{Slider, focus_ring};

/// Height of the slider, of a figure, and of what stands below a disk.
const SLIDER: f32 = 38.0;
const FIGURE: f32 = 18.0;
const LABEL: f32 = 20.0;
/// Most figures of a view.
const N_FIGURES: f32 = 5.0;
/// The largest width of plots, and the least that they are made smaller to.
const WIDEST: f32 = 320.0;
const NARROWEST: f32 = 130.0;
/// Square points of a disk for each of its dots, at least.
const DOT: f32 = 70.0;

/// What a lobe in space was drawn of.
type Drawn = (Plot, Turn, [usize; 2], SolidStyle);

/// Pictures of a view, kept while what they show stays the same.
pub(super) struct Panel {
    of: Arc<Lobes>,
    solid: Option<(TextureHandle, Drawn)>,
    disk: Option<(Disk, TextureHandle, Radius)>,
}

/// Forgets pictures of other lobes.
pub(super) fn follow(panels: &mut Vec<Panel>, lobes: &Arc<Lobes>) {
    let is_same = panels.len() == lobes.views.len()
        && panels.iter().all(|panel| Arc::ptr_eq(&panel.of, lobes));
    if !is_same {
        let empty = |_: &Viewed| Panel {
            of: Arc::clone(lobes),
            solid: None,
            disk: None,
        };
        *panels = lobes.views.iter().map(empty).collect();
    }
}

/// Heights of the plots of a panel, and their width.
#[derive(Clone, Copy)]
pub(super) struct Heights {
    width: f32,
    polar: f32,
    solid: f32,
    disk: f32,
}

impl Heights {
    /// In a column of a width; narrower where all of it fits a height then.
    pub(super) fn new(column: f32, room: f32, is_whole: bool) -> Self {
        let of = |width: f32| Self {
            width,
            polar: polar::height(width, is_whole),
            solid: if is_whole { 0.75 * width } else { 0.62 * width },
            disk: if is_whole { 0.5 * width } else { 0.62 * width },
        };
        let widest = of(column.min(WIDEST));
        let too_much = widest.total() - room;
        // Heights of plots grow as their width does.
        let share = (widest.polar + widest.solid + widest.disk) / widest.width;
        let fit = (widest.width - too_much.max(0.0) / share).floor();
        if fit >= NARROWEST { of(fit) } else { widest }
    }

    /// Of the whole panel.
    pub(super) fn total(self) -> f32 {
        SLIDER + self.polar + self.solid + self.disk + LABEL + N_FIGURES * FIGURE + 4.0 * GRID
    }
}

/// Draws the panel of a view.
pub(super) fn show(
    ui: &mut Ui,
    rect: Rect,
    view: &mut LobeView,
    lobes: &Arc<Lobes>,
    index: usize,
    (h, is_whole): (Heights, bool),
) {
    let viewed = &lobes.views[index];
    let left = rect.center().x - 0.5 * h.width;
    let mut top = rect.top();
    let mut next = |height: f32| {
        let place = Rect::from_min_size(pos2(left, top), vec2(h.width, height));
        top += height + GRID;
        place
    };
    let builder = UiBuilder::new()
        .max_rect(next(SLIDER))
        .id_salt(("lobe", index));
    ui.scope_builder(builder, |ui| {
        let mut angle = f64::from(view.angles[index]);
        let name = format!("Angle {}", index + 1);
        let slider = Slider::new(&name, 0.0, f64::from(LARGEST_ANGLE))
            .step(1.0)
            .unit("°")
            .default(f64::from(neumann_core::render::lobe::ANGLES[index]))
            .about("Angle between the normal and the viewer.");
        slider.show(ui, &mut angle);
        view.angles[index] = angle as f32;
        polar::show(ui, next(h.polar), viewed, view.plot, is_whole);
        solid(ui, next(h.solid), view, viewed, index);
        let place = next(h.disk + LABEL);
        let radius = view.plot.radius;
        disk(ui, place, &mut view.panels[index], viewed, radius);
        rows(ui, next(N_FIGURES * FIGURE), viewed);
    });
}

fn texture(ctx: &Context, image: ColorImage, old: Option<TextureHandle>) -> TextureHandle {
    match old {
        Some(mut texture) => {
            texture.set(image, TextureOptions::LINEAR);
            texture
        }
        None => ctx.load_texture("lobe", image, TextureOptions::LINEAR),
    }
}

fn colours(pixels: &[[u8; 3]]) -> Vec<Color32> {
    let colour = |[r, g, b]: &[u8; 3]| Color32::from_rgb(*r, *g, *b);
    pixels.iter().map(colour).collect()
}

/// The lobe in space; a drag turns it, and so do arrows while it has the keyboard.
fn solid(ui: &Ui, rect: Rect, view: &mut LobeView, viewed: &Viewed, index: usize) {
    let p = Palette::of(ui);
    let id = ui.scope_id().with("solid");
    let response = ui.interact(rect, id, Sense::click_and_drag());
    let turn = turning::taken(ui, &response, rect);
    if response.double_clicked() {
        view.turn = Turn::default();
    }
    view.turn.yaw += turn.x;
    view.turn.pitch = (view.turn.pitch + turn.y).clamp(-0.98 * FRAC_PI_2, 0.98 * FRAC_PI_2);
    let scale = ui.pixels_per_point();
    let size = [rect.width(), rect.height()].map(|n| ((n * scale) as usize).max(1));
    let code = |c: Color32| [c.r(), c.g(), c.b()];
    let style = SolidStyle {
        ground: code(p.ground),
        line: code(p.weak),
        viewer: code(p.amber),
        arrow: code(p.strong),
    };
    let wanted = (view.plot, view.turn, size, style);
    let panel = &mut view.panels[index];
    if panel.solid.as_ref().is_none_or(|(_, of)| *of != wanted) {
        let [w, h] = size;
        let drawn = draw(viewed, view.plot, view.turn, (w, h), &style);
        let image = ColorImage::new([drawn.width, drawn.height], colours(&drawn.pixels));
        let old = panel.solid.take().map(|(texture, _)| texture);
        panel.solid = Some((texture(ui.ctx(), image, old), wanted));
    }
    if let Some((texture, _)) = &panel.solid {
        let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        ui.painter().image(texture.id(), rect, uv, Color32::WHITE);
    }
    focus_ring(ui, &response, rect.shrink(2.0), 4);
    let angle = significant(f64::from(viewed.angle), 3);
    let name = format!("lobe in space, viewer at {angle}°");
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
    response.on_hover_text(
        "The lobe in space: every direction as far from the point as its value. Drag to turn all \
         four; arrows turn them while this has the keyboard, a double click turns them back. The \
         amber line points to the viewer.",
    );
}

/// The density with the directions that were drawn.
fn disk(ui: &Ui, rect: Rect, panel: &mut Panel, viewed: &Viewed, radius: Radius) {
    let p = Palette::of(ui);
    let diameter = rect.height() - LABEL;
    if panel.disk.as_ref().is_none_or(|(_, _, of)| *of != radius) {
        let disk = Disk::new(viewed, radius);
        let (w, h) = disk.size;
        let image = ColorImage::new([w, h], colours(&disk.pixels));
        let old = panel.disk.take().map(|(_, texture, _)| texture);
        panel.disk = Some((disk, texture(ui.ctx(), image, old), radius));
    }
    let Some((disk, texture, _)) = &panel.disk else {
        return;
    };
    let (columns, rows) = disk.size;
    let scale = diameter / rows as f32;
    let n_disks = columns / rows.max(1);
    let width = columns as f32 * scale;
    let left = rect.center().x - 0.5 * width;
    let place = Rect::from_min_size(pos2(left, rect.top()), vec2(width, diameter));
    let painter = ui.painter();
    for i in 0..n_disks {
        let middle = place.min + vec2((i as f32 + 0.5) * diameter, 0.5 * diameter);
        let corners = ring(middle.into(), 0.5 * diameter)
            .into_iter()
            .map(Pos2::from);
        let mut mesh = Mesh::with_texture(texture.id());
        for corner in std::iter::once(middle).chain(corners.clone()) {
            mesh.vertices.push(Vertex {
                pos: corner,
                uv: ((corner - place.min) / place.size()).to_pos2(),
                color: Color32::WHITE,
            });
        }
        for i in 1..mesh.vertices.len() as u32 - 1 {
            mesh.add_triangle(0, i, i + 1);
        }
        painter.add(mesh);
        painter.add(Shape::closed_line(
            corners.collect(),
            Stroke::new(1.0, p.weak.gamma_multiply(0.4)),
        ));
    }
    let at = |[x, y]: [f32; 2]| place.min + vec2(x, y) * scale;
    let size = (diameter / 110.0).clamp(0.7, 1.5);
    // As many as leave something of the colours to be seen.
    let n_dots = (diameter * diameter / DOT) as usize;
    for dot in disk.dots.iter().take(n_dots) {
        painter.circle_filled(at(*dot), size + 0.6, Color32::BLACK);
        painter.circle_filled(at(*dot), size, Color32::WHITE);
    }
    for point in &disk.points {
        painter.circle_stroke(at(*point), 4.5, (3.0, Color32::BLACK));
        painter.circle_stroke(at(*point), 4.5, (1.5, Color32::WHITE));
    }
    let note = disk.note();
    let below = pos2(rect.center().x, place.bottom() + 4.0);
    painter.text(below, Align2::CENTER_TOP, &note, theme::small(), p.weak);
    let response = ui.interact(rect, ui.scope_id().with("disk"), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &note));
    response.on_hover_text(
        "How densely BSDF sampling draws directions, and the first that it has drawn. The middle \
         is the normal, the viewer is below; rings are mirror-like directions. Where light passes \
         through the surface, the second disk has the directions behind it.",
    );
}

fn rows(ui: &Ui, rect: Rect, viewed: &Viewed) {
    let p = Palette::of(ui);
    for (i, figure) in figures(viewed).into_iter().enumerate() {
        let top = rect.top() + i as f32 * FIGURE;
        let row = Rect::from_min_size(pos2(rect.left(), top), vec2(rect.width(), FIGURE));
        let painter = ui.painter();
        let (left, right) = (row.left_center(), row.right_center());
        painter.text(
            left,
            Align2::LEFT_CENTER,
            figure.name,
            theme::small(),
            p.weak,
        );
        painter.text(
            right,
            Align2::RIGHT_CENTER,
            &figure.text,
            theme::small(),
            p.text,
        );
        let response = ui.interact(row, ui.scope_id().with(("figure", i)), Sense::hover());
        let spoken = format!("{}: {}", figure.name, figure.text);
        response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &spoken));
        response.on_hover_text(figure.about);
    }
}
