//! Pictures over the hemisphere as disks, with what falls on them.

use egui::{
    Color32, ColorImage, Context, Painter, Pos2, Rect, Response, Role, Sense, Shape, Stroke,
    TextureFilter, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo, pos2,
};
use neumann_core::film::View as Part;
use neumann_core::render::Hemisphere;
use neumann_core::render::hemisphere::{Estimator, Integrand};
use neumann_picture::hemisphere::{
    DENSITIES, INTEGRANDS, Panel, about, colour, formula, outline, shows,
};
use neumann_picture::tone::Display;

use crate::formula::Formula;
use crate::theme::{self, GRID, Palette};
use crate::widgets::focus_ring;

/// Height of what stands below a disk.
const LABEL: f32 = 40.0;
/// The least diameter of a disk, points, and the largest.
const DIAMETERS: (f32, f32) = (72.0, 168.0);

/// All pictures, kept while what they show stays the same.
#[derive(Default)]
pub(super) struct Disks {
    shown: Vec<(Panel, TextureHandle)>,
    /// What they show: directions so far, part, exposure and tone.
    of: Option<(u32, Part, Display)>,
}

impl Disks {
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Draws them anew if anything has changed.
    pub(super) fn follow(
        &mut self,
        ctx: &Context,
        hemisphere: &Hemisphere,
        part: Part,
        display: Display,
    ) {
        let now = (hemisphere.n_passes(), part, display);
        if self.of == Some(now) {
            return;
        }
        self.of = Some(now);
        let old = std::mem::take(&mut self.shown);
        let mut old = old.into_iter().map(|(_, texture)| texture);
        let all = INTEGRANDS.into_iter().chain(DENSITIES);
        self.shown = all
            .map(|integrand| {
                let panel = Panel::new(hemisphere, integrand, part, &display);
                let texture = texture(ctx, &panel, hemisphere, old.next());
                (panel, texture)
            })
            .collect();
    }

    /// Rows of disks: those of the equation, or those of the densities.
    pub(super) fn show(&self, ui: &mut Ui, hemisphere: &Hemisphere, are_densities: bool) {
        let n_disks = hemisphere.map().n_disks() as f32;
        let is_shown =
            |panel: &Panel| matches!(panel.integrand, Integrand::Density(_)) == are_densities;
        let shown: Vec<_> = self.shown.iter().filter(|(p, _)| is_shown(p)).collect();
        let room = ui.available_width();
        let fit = ((room + GRID) / (n_disks * DIAMETERS.0 + GRID)).floor();
        // Four in a row, or two rows of two.
        let n_columns = match fit as usize {
            n if n >= shown.len() => shown.len(),
            n if n >= 2 => 2,
            _ => 1,
        };
        let width = (room + GRID) / n_columns as f32 - GRID;
        let diameter = (width / n_disks).min(DIAMETERS.1);
        let size = Vec2::new(width, diameter + LABEL);
        for row in shown.chunks(n_columns) {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = GRID;
                for (panel, texture) in row {
                    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
                    draw(ui, rect, (diameter, panel, texture), hemisphere, response);
                }
            });
        }
    }
}

/// Pixels outside of the disks are left out.
fn texture(
    ctx: &Context,
    panel: &Panel,
    hemisphere: &Hemisphere,
    old: Option<TextureHandle>,
) -> TextureHandle {
    let (width, height) = panel.size;
    let corner = |i: usize, dx: f32, dy: f32| [(i % width) as f32 + dx, (i / width) as f32 + dy];
    let map = hemisphere.map();
    // What lies across the edge is drawn, and covered by the outline.
    let touches = |i: usize| {
        let corners = [[0.01, 0.01], [0.99, 0.01], [0.01, 0.99], [0.99, 0.99]];
        let mut corners = corners.into_iter();
        corners.any(|[dx, dy]| map.direction(corner(i, dx, dy)).is_some())
    };
    let pixels = panel.pixels.iter().enumerate();
    let pixels = pixels.map(|(i, [r, g, b])| {
        if touches(i) {
            Color32::from_rgb(*r, *g, *b)
        } else {
            Color32::TRANSPARENT
        }
    });
    let image = ColorImage::new([width, height], pixels.collect());
    let options = TextureOptions {
        magnification: TextureFilter::Nearest,
        ..TextureOptions::LINEAR
    };
    match old {
        Some(mut texture) => {
            texture.set(image, options);
            texture
        }
        None => ctx.load_texture("hemisphere", image, options),
    }
}

fn draw(
    ui: &Ui,
    rect: Rect,
    (diameter, panel, texture): (f32, &Panel, &TextureHandle),
    hemisphere: &Hemisphere,
    response: Response,
) {
    let p = Palette::of(ui);
    let n_disks = hemisphere.map().n_disks() as f32;
    let disks = Rect::from_min_size(rect.min, Vec2::new(n_disks * diameter, diameter));
    let painter = ui.painter_at(rect.expand(3.0));
    let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    painter.image(texture.id(), disks, uv, Color32::WHITE);
    let scale = diameter / panel.size.1 as f32;
    let at = |[x, y]: [f32; 2]| disks.min + Vec2::new(x, y) * scale;
    cover_edge(&painter, hemisphere, at, scale, &p);
    if let Integrand::Density(estimator) = panel.integrand {
        let [r, g, b] = colour(estimator, true);
        let colour = Color32::from_rgb(r, g, b);
        let radius = (diameter / 110.0).clamp(0.8, 1.6);
        for dot in hemisphere.dots(estimator) {
            if let Some(place) = hemisphere.map().place(dot) {
                painter.circle_filled(at(place), radius + 0.6, Color32::BLACK);
                painter.circle_filled(at(place), radius, colour);
            }
        }
    }
    for point in hemisphere.points() {
        if shows(panel.integrand, point)
            && let Some(place) = hemisphere.map().place(point.direction)
        {
            ring(&painter, at(place));
        }
    }
    let (name, note) = (formula(panel.integrand), panel.note());
    let formula = Formula::typed(&painter, name, theme::BODY, p.text);
    let below = rect.min + Vec2::new(0.0, diameter + 4.0);
    formula.paint(&painter, below);
    let note_at = below + Vec2::new(0.0, formula.size.y);
    let mut job = egui::text::LayoutJob::simple_singleline(note.clone(), theme::small(), p.weak);
    job.wrap = egui::text::TextWrapping::truncate_at_width(rect.width());
    let galley = painter.layout_job(job);
    painter.galley(note_at, galley, p.weak);
    focus_ring(ui, &response, rect.expand(2.0), 4);
    let plain = name.replace(['_', '{', '}'], "");
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, format!("{plain}: {note}")));
    response.on_hover_text(format!("{}\n{note}", about(panel.integrand)));
}

/// Covers the corners of pixels that reach out of a disk.
fn cover_edge(
    painter: &Painter,
    hemisphere: &Hemisphere,
    at: impl Fn([f32; 2]) -> Pos2,
    scale: f32,
    p: &Palette,
) {
    for corners in outline(hemisphere) {
        let line: Vec<Pos2> = corners.into_iter().map(&at).collect();
        let middle = Rect::from_points(&line).center();
        let width = 1.6 * scale;
        let out = |at: &Pos2| *at + (*at - middle).normalized() * (0.5 * width);
        let outer = line.iter().map(out).collect();
        painter.add(Shape::closed_line(outer, Stroke::new(width, p.panel)));
        painter.add(Shape::closed_line(line, Stroke::new(1.0, p.line)));
    }
}

fn ring(painter: &Painter, at: Pos2) {
    painter.circle_stroke(at, 4.5, Stroke::new(3.0, Color32::BLACK));
    painter.circle_stroke(at, 4.5, Stroke::new(1.5, Color32::WHITE));
}

/// The colour of an estimator.
pub(super) fn colour_of(estimator: Estimator, ui: &Ui) -> Color32 {
    let [r, g, b] = colour(estimator, ui.visuals().dark_mode);
    Color32::from_rgb(r, g, b)
}
