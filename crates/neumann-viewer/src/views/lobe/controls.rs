//! What is chosen beside the panels: the material, from which side, and how it is plotted.

use egui::{Area, Frame, Id, Margin, Order, Rect, ScrollArea, Stroke, Ui, UiBuilder, Vec2, pos2};
use neumann_picture::lobe::{Plotted, Radius};

use super::worker::Choice;
use super::{LobeView, curve, name_of};
use crate::session::Session;
use crate::theme::{GRID, Palette};
use crate::widgets::{hint, row_button, segments, switch};

/// Width of the list of materials.
const LIST: f32 = 220.0;

/// Draws the controls into `rect`, with the curve of albedo below them where there is room.
pub(super) fn show(
    ui: &mut Ui,
    rect: Rect,
    view: &mut LobeView,
    session: &Session,
    with_curve: bool,
) {
    let area = rect.shrink2(Vec2::new(2.0 * GRID, 0.0));
    let builder = UiBuilder::new().max_rect(area).id_salt("lobe controls");
    ui.scope_builder(builder, |ui| {
        let scroll = ScrollArea::vertical()
            .id_salt("lobe choices")
            .auto_shrink(false);
        scroll.show(ui, |ui| {
            ui.set_width(area.width() - GRID);
            ui.spacing_mut().item_spacing.y = 4.0;
            ui.add_space(GRID);
            choices(ui, view, session);
            if with_curve && let Some(lobes) = view.found().cloned() {
                curve::show(ui, &lobes);
            }
            ui.add_space(GRID);
        });
    });
}

fn choices(ui: &mut Ui, view: &mut LobeView, session: &Session) {
    let material = view.material();
    let name = material.map_or("no material".to_owned(), |m| name_of(session, m));
    let name = format!("Material: {name}");
    let row = row_button(ui, &name, "list", view.menu.is_some());
    let spot = row.rect;
    let about = "The material that is looked at. Opens the list of all; ← and → step through \
                 it, and a click into the picture takes the surface there.";
    if row.on_hover_text(about).clicked() {
        view.menu = if view.menu.is_some() {
            None
        } else {
            Some(spot)
        };
    }
    hint(ui, &place(view));
    let about = "Looks from the other side of the surface: from inside glass.";
    let side = switch(ui, "Other side", &mut view.is_other_side);
    side.on_hover_text(about);
    ui.horizontal_wrapped(|ui| {
        let names = Plotted::ALL.map(Plotted::name);
        let about = |i: usize| Plotted::ALL[i].about().to_owned();
        let chosen = Plotted::ALL.iter().position(|p| *p == view.plot.plotted);
        if let Some(i) = segments(ui, "plot", &names, about, chosen.unwrap_or(0)) {
            view.plot.plotted = Plotted::ALL[i];
        }
        let names = Radius::ALL.map(Radius::name);
        let about = |i: usize| Radius::ALL[i].about().to_owned();
        let chosen = Radius::ALL.iter().position(|r| *r == view.plot.radius);
        let name = "distance from the middle";
        if let Some(i) = segments(ui, name, &names, about, chosen.unwrap_or(0)) {
            view.plot.radius = Radius::ALL[i];
        }
    });
}

/// Where its textures are read.
fn place(view: &LobeView) -> String {
    let Some(Choice::Pixel([x, y])) = view.choice else {
        return "textures at (0, 0)".to_owned();
    };
    let surface = view.surface();
    match surface.and_then(|surface| surface.angle) {
        Some(angle) => format!("at pixel {x}, {y}, seen under {angle:.0}°"),
        None => format!("at pixel {x}, {y}"),
    }
}

/// Draws the list of materials if it is open.
pub(super) fn menu(ui: &mut Ui, view: &mut LobeView, session: &Session) {
    let Some(spot) = view.menu else { return };
    let p = Palette::of(ui);
    let window = ui.ctx().content_rect();
    let now = view.material();
    let mut chosen = None;
    let area = Area::new(Id::unique("lobe materials"))
        .order(Order::Foreground)
        .fixed_pos(pos2(spot.left(), spot.bottom() + 4.0))
        .constrain_to(window)
        .show(ui.ctx(), |ui| {
            let frame = Frame::new()
                .fill(p.panel)
                .stroke(Stroke::new(1.0, p.line))
                .corner_radius(6)
                .inner_margin(Margin::symmetric(16, 8));
            frame.show(ui, |ui| {
                ui.set_width(LIST);
                let room = (window.bottom() - spot.bottom() - 4.0 * GRID).max(96.0);
                let list = ScrollArea::vertical().max_height(room);
                list.show(ui, |ui| {
                    for material in 0..view.n_materials {
                        let name = name_of(session, material);
                        let row = row_button(ui, &name, "", now == Some(material));
                        let about = format!("Shows the lobes of {name}.");
                        if row.on_hover_text(about).clicked() {
                            chosen = Some(material);
                        }
                    }
                });
            });
        });
    let is_left = area.response.clicked_elsewhere() && !ui.rect_contains_pointer(spot);
    if let Some(material) = chosen {
        view.choice = Some(Choice::Material(material));
    }
    if chosen.is_some() || is_left {
        view.menu = None;
    }
}
