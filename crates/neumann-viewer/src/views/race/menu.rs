//! The menu of a method in the race: another method, parameters of its own, or no method.

use egui::{Area, Frame, Id, Key, Margin, Order, Rect, Stroke, Ui, pos2};
use neumann_core::integrator::METHODS;
use neumann_picture::race::Entrant;

use super::{Entry, RaceView};
use crate::setup::Setup;
use crate::theme::{GRID, Palette};
use crate::widgets::{button, hint, row_button, text_field};

/// What stands in the text field, and why it is no method.
#[derive(Clone, Debug, Default)]
pub(super) struct Field {
    text: String,
    wrong: Option<String>,
    /// The button that it hangs from.
    spot: Option<Rect>,
}

const WIDTH: f32 = 300.0;

/// Opens the menu of a method, or closes it.
pub(super) fn toggle(view: &mut RaceView, which: usize, spot: Rect, setup: &Setup) {
    if view.menu.as_ref().is_some_and(|(open, _)| *open == which) {
        view.menu = None;
        return;
    }
    let name = view.entries.get(which).map(|e| e.entrant(setup).name);
    let field = Field {
        text: name.unwrap_or_default(),
        wrong: None,
        spot: Some(spot),
    };
    view.menu = Some((which, field));
}

/// Draws the menu that is open.
pub(super) fn show(ui: &mut Ui, view: &mut RaceView, setup: &Setup) {
    let Some((which, mut field)) = view.menu.clone() else {
        return;
    };
    let p = Palette::of(ui);
    let Some((entry, spot)) = view.entries.get(which).cloned().zip(field.spot) else {
        view.menu = None;
        return;
    };
    let window = ui.ctx().content_rect();
    let left = spot
        .left()
        .min(window.right() - WIDTH - 5.0 * GRID)
        .max(0.0);
    let mut chosen = None;
    let mut is_removed = false;
    let area = Area::new(Id::unique("race menu"))
        .order(Order::Foreground)
        .fixed_pos(pos2(left, spot.bottom() + 4.0))
        .constrain_to(window)
        .show(ui.ctx(), |ui| {
            let frame = Frame::new()
                .fill(p.panel)
                .stroke(Stroke::new(1.0, p.line))
                .corner_radius(6)
                .inner_margin(Margin::symmetric(16, 8));
            frame.show(ui, |ui| {
                ui.set_width(WIDTH);
                let text = text_field(ui, "method:parameter=value", &mut field.text);
                let is_entered = text.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
                text.on_hover_text(
                    "A method with parameters of its own, as the command takes it: \
                     pt-mis:roulette=off",
                );
                if is_entered {
                    match Entrant::parse(field.text.trim()) {
                        Ok(entrant) => chosen = Some(Entry::Own(entrant)),
                        Err(wrong) => field.wrong = Some(wrong),
                    }
                }
                if let Some(wrong) = &field.wrong {
                    hint(ui, wrong);
                }
                let room = window.height() - 140.0;
                let list = egui::ScrollArea::vertical().max_height(room.max(80.0));
                list.show(ui, |ui| {
                    for (i, method) in METHODS.iter().enumerate() {
                        let is_it = entry == Entry::OfPage(i);
                        let row = row_button(ui, method.id, method.name, is_it);
                        let about = format!("{}. {}", method.name, method.about);
                        if row.on_hover_text(about).clicked() {
                            chosen = Some(Entry::OfPage(i));
                        }
                    }
                });
                if view.entries.len() > 2 {
                    ui.add_space(GRID / 2.0);
                    let about = "Takes this method out of the race, which begins anew.";
                    is_removed = button(ui, "Remove method").on_hover_text(about).clicked();
                }
            });
        });
    let is_left = area.response.clicked_elsewhere() && !ui.rect_contains_pointer(spot);
    if is_removed {
        view.entries.remove(which);
        view.menu = None;
    } else if let Some(chosen) = chosen {
        let is_twice = |(i, e): (usize, &Entry)| {
            i != which && e.entrant(setup).name == chosen.entrant(setup).name
        };
        if view.entries.iter().enumerate().any(is_twice) {
            field.wrong = Some("this takes part already".to_owned());
            view.menu = Some((which, field));
        } else {
            view.entries[which] = chosen;
            view.menu = None;
        }
    } else if is_left {
        view.menu = None;
    } else {
        view.menu = Some((which, field));
    }
}
