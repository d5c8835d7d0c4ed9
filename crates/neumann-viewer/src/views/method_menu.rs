//! The menu of a method that takes part in something: another method, parameters of its own, or no
//! method; and the button that opens it.

use egui::{
    Area, Frame, Id, Key, Margin, Order, Pos2, Rect, Response, Role, Sense, Stroke, Ui, WidgetInfo,
    pos2, vec2,
};
use neumann_core::integrator::METHODS;
use neumann_picture::race::Entrant;

use super::entry::Entry;
use crate::setup::Setup;
use crate::theme::{self, GRID, Palette};
use crate::widgets::{Icon, button, cut_line, focus_ring, hint, row_button, text_field};

/// The menu, if it is open, of which of the methods.
#[derive(Default)]
pub(super) struct MethodMenu {
    open: Option<(usize, Field)>,
}

/// What a menu allows.
pub(super) struct Rules {
    /// So many methods remain.
    pub(super) least: usize,
    /// A method may stand beside itself.
    pub(super) may_repeat: bool,
    /// What comes of taking one out.
    pub(super) why_removed: &'static str,
}

/// What stands in the text field, and why it is no method.
#[derive(Clone, Debug, Default)]
struct Field {
    text: String,
    wrong: Option<String>,
    /// The button that it hangs from.
    spot: Option<Rect>,
}

const WIDTH: f32 = 300.0;

impl MethodMenu {
    /// Opens the menu of a method, or closes it.
    pub(super) fn toggle(&mut self, which: usize, spot: Rect, name: String) {
        if self.open.as_ref().is_some_and(|(open, _)| *open == which) {
            self.open = None;
            return;
        }
        let field = Field {
            text: name,
            wrong: None,
            spot: Some(spot),
        };
        self.open = Some((which, field));
    }

    /// Closes it; false if it was not open.
    pub(super) fn close(&mut self) -> bool {
        self.open.take().is_some()
    }

    /// Draws the menu that is open.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        entries: &mut Vec<Entry>,
        rules: &Rules,
        setup: &Setup,
    ) {
        let Some((which, mut field)) = self.open.clone() else {
            return;
        };
        let p = Palette::of(ui);
        let Some((entry, spot)) = entries.get(which).cloned().zip(field.spot) else {
            self.open = None;
            return;
        };
        let window = ui.ctx().content_rect();
        let left = spot
            .left()
            .min(window.right() - WIDTH - 5.0 * GRID)
            .max(0.0);
        let mut chosen = None;
        let mut is_removed = false;
        let area = Area::new(Id::unique("method menu"))
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
                    if entries.len() > rules.least {
                        ui.add_space(GRID / 2.0);
                        let about = rules.why_removed;
                        is_removed = button(ui, "Remove method").on_hover_text(about).clicked();
                    }
                });
            });
        let is_left = area.response.clicked_elsewhere() && !ui.rect_contains_pointer(spot);
        if is_removed {
            entries.remove(which);
            self.open = None;
        } else if let Some(chosen) = chosen {
            let is_twice = |(i, e): (usize, &Entry)| {
                i != which && e.entrant(setup).name == chosen.entrant(setup).name
            };
            if !rules.may_repeat && entries.iter().enumerate().any(is_twice) {
                field.wrong = Some("this takes part already".to_owned());
                self.open = Some((which, field));
            } else {
                entries[which] = chosen;
                self.open = None;
            }
        } else if is_left {
            self.open = None;
        } else {
            self.open = Some((which, field));
        }
    }
}

/// The name of method number `i` as a button, which opens the menu; `spoken` is what it is called
/// to whoever does not see it, and `mark` draws what stands for the method.
pub(super) fn name_button(
    ui: &Ui,
    rect: Rect,
    i: usize,
    [name, spoken]: [&str; 2],
    mark: impl FnOnce(&Ui, Pos2),
) -> (Response, Rect) {
    let p = Palette::of(ui);
    let middle = rect.center().y;
    let room = rect.width() - 4.5 * GRID;
    let galley = cut_line(
        ui.painter(),
        name.to_owned(),
        theme::semibold(),
        p.text,
        room,
    );
    let size = vec2(galley.size().x + 4.5 * GRID, rect.height() - 4.0);
    let spot = Rect::from_min_size(pos2(rect.left(), rect.top() + 2.0), size);
    let response = ui.interact(spot, ui.scope_id().with((spoken, i)), Sense::click());
    if response.hovered() {
        ui.painter().rect_filled(spot, 4, p.hovered);
    }
    mark(ui, pos2(spot.left() + 5.0, middle));
    let at = pos2(spot.left() + 1.75 * GRID, middle - galley.size().y / 2.0);
    ui.painter().galley(at, galley, p.text);
    let arrow = pos2(spot.right() - 1.25 * GRID, middle);
    Icon::Down.paint(ui.painter(), arrow, p.weak);
    focus_ring(ui, &response, spot, 4);
    let spoken = format!("{spoken} {}: {name}", i + 1);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &spoken));
    (response, spot)
}
