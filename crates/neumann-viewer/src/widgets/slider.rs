//! A number on a track: drag it, step it with the arrow keys, type it, or reset it.

use egui::{
    Align2, CursorIcon, EventFilter, Id, Key, Rect, Response, Role, Sense, TextEdit, Ui, Vec2,
    WidgetInfo, accesskit, pos2,
};

use neumann_picture::figures::significant;

use super::focus_ring;
use crate::theme::{self, GRID, Palette};

/// A number between two others, with a name and a unit.
pub struct Slider<'a> {
    name: &'a str,
    unit: &'a str,
    range: (f64, f64),
    is_logarithmic: bool,
    step: Option<f64>,
    default: Option<f64>,
    about: &'a str,
    zero: &'a str,
}

/// Where a knob was taken.
#[derive(Clone, Copy, Debug)]
struct Grip {
    /// From the pointer to the middle of the knob, points.
    offset: f32,
    /// The knob has followed the pointer.
    has_moved: bool,
    /// Where the pointer was when it was taken.
    x: f32,
}

/// Half the width of a knob, points.
const KNOB: f32 = 6.0;

impl<'a> Slider<'a> {
    /// A slider from `min` to `max`.
    #[must_use]
    pub fn new(name: &'a str, min: f64, max: f64) -> Self {
        Self {
            name,
            unit: "",
            range: (min, max),
            is_logarithmic: false,
            step: None,
            default: None,
            about: "",
            zero: "",
        }
    }

    /// What stands in place of the number where it is 0.
    #[must_use]
    pub fn zero(mut self, zero: &'a str) -> Self {
        self.zero = zero;
        self
    }

    /// Shown behind the number.
    #[must_use]
    pub fn unit(mut self, unit: &'a str) -> Self {
        self.unit = unit;
        self
    }

    /// Equal distances are equal factors. A range that starts at 0 begins to be so at a 100 000th
    /// of its end.
    #[must_use]
    pub fn logarithmic(mut self, is_logarithmic: bool) -> Self {
        self.is_logarithmic = is_logarithmic;
        self
    }

    /// Only multiples of `step`.
    #[must_use]
    pub fn step(mut self, step: f64) -> Self {
        self.step = Some(step);
        self
    }

    /// What a double click or the reset button goes back to.
    #[must_use]
    pub fn default(mut self, default: f64) -> Self {
        self.default = Some(default);
        self
    }

    /// A sentence that says what it is.
    #[must_use]
    pub fn about(mut self, about: &'a str) -> Self {
        self.about = about;
        self
    }

    /// Draws it; the response is marked as changed when the value was.
    pub fn show(&self, ui: &mut Ui, value: &mut f64) -> Response {
        let p = Palette::of(ui);
        let before = *value;
        let size = Vec2::new(ui.available_width(), 34.0);
        let (rect, hover) = ui.allocate_exact_size(size, Sense::hover());
        let id = ui.scope_id().with(("slider", self.name));
        let track = Rect::from_min_max(pos2(rect.left(), rect.bottom() - 14.0), rect.max);
        let mut response = ui
            .interact(track, id, Sense::click_and_drag())
            .on_hover_cursor(CursorIcon::ResizeHorizontal);
        self.take_input(ui, &response, track, value);

        let painter = ui.painter().clone();
        let is_default = self.default.is_none_or(|d| (d - *value).abs() < 1e-9);
        let mut right = rect.right();
        if !is_default {
            let spot =
                Rect::from_center_size(pos2(right - 6.0, rect.top() + 9.0), Vec2::splat(16.0));
            right -= 20.0;
            self.reset_button(ui, spot, value);
        }
        let number = Rect::from_min_max(
            pos2(rect.center().x + GRID, rect.top()),
            pos2(right, rect.top() + 18.0),
        );
        self.number(ui, id, number, value);
        let label = Rect::from_min_max(rect.min, pos2(number.left() + 2.0 * GRID, number.bottom()));
        painter.with_clip_rect(label).text(
            label.left_center(),
            Align2::LEFT_CENTER,
            self.name,
            theme::body(),
            if ui.is_enabled() { p.weak } else { p.line },
        );

        let (left_x, right_x) = (track.left() + 5.0, track.right() - 5.0);
        let y = track.center().y;
        let x = left_x + (right_x - left_x) * self.fraction(*value) as f32;
        let bar = |from: f32, to: f32| Rect::from_min_max(pos2(from, y - 1.5), pos2(to, y + 1.5));
        painter.rect_filled(bar(track.left(), track.right()), 1, p.line);
        painter.rect_filled(bar(track.left(), x), 1, p.fill);
        let radius = if response.hovered() || response.dragged() {
            KNOB
        } else {
            KNOB - 1.0
        };
        painter.circle_filled(pos2(x, y), radius, p.strong);
        focus_ring(
            ui,
            &response,
            Rect::from_center_size(pos2(x, y), Vec2::splat(12.0)),
            8,
        );

        if (*value - before).abs() > 0.0 {
            response.mark_changed();
        }
        let shown = *value;
        response.widget_info(|| WidgetInfo::slider(ui.is_enabled(), shown, self.name));
        ui.ctx().accesskit_node_builder(id, |node| {
            node.set_min_numeric_value(self.range.0);
            node.set_max_numeric_value(self.range.1);
            for action in [
                accesskit::Action::SetValue,
                accesskit::Action::Increment,
                accesskit::Action::Decrement,
            ] {
                node.add_action(action);
            }
        });
        if !self.about.is_empty() {
            ui.ctx()
                .accesskit_node_builder(id, |node| node.set_description(self.about));
            hover.on_hover_text(self.about);
        }
        response
    }

    fn take_input(&self, ui: &Ui, response: &Response, track: Rect, value: &mut f64) {
        self.take_pointer(ui, response, track, value);
        if response.double_clicked()
            && let Some(default) = self.default
        {
            *value = default;
        }
        let mut steps = 0;
        if response.has_focus() {
            let filter = EventFilter {
                horizontal_arrows: true,
                ..EventFilter::default()
            };
            ui.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
            steps += ui.input(|i| i.num_presses(Key::ArrowRight)) as i64;
            steps -= ui.input(|i| i.num_presses(Key::ArrowLeft)) as i64;
        }
        ui.input(|i| {
            use accesskit::{Action, ActionData};
            steps += i.num_accesskit_action_requests(response.id, Action::Increment) as i64;
            steps -= i.num_accesskit_action_requests(response.id, Action::Decrement) as i64;
            for request in i.accesskit_action_requests(response.id, Action::SetValue) {
                if let Some(ActionData::NumericValue(wanted)) = request.data {
                    *value = self.admit(wanted);
                }
            }
        });
        if steps != 0 {
            *value = match self.step {
                Some(step) => self.admit(*value + steps as f64 * step),
                None => self.at_fraction(self.fraction(*value) + steps as f64 * 0.02),
            };
        }
    }

    /// The knob goes where the pointer is; taken by itself, it stays where it was taken, and a
    /// press alone changes nothing.
    fn take_pointer(&self, ui: &Ui, response: &Response, track: Rect, value: &mut f64) {
        let grip = response.id.with("grip");
        let Some(pointer) = response.interact_pointer_pos() else {
            ui.data_mut(|d| d.remove::<Grip>(grip));
            return;
        };
        let width = (track.width() - 10.0).max(1.0);
        let (left, knob) = (track.left() + 5.0, self.fraction(*value) as f32);
        let knob = left + width * knob;
        let taken = ui.data(|d| d.get_temp::<Grip>(grip)).unwrap_or_else(|| {
            let offset = knob - pointer.x;
            let taken = Grip {
                offset: if offset.abs() <= KNOB { offset } else { 0.0 },
                has_moved: offset.abs() > KNOB,
                x: pointer.x,
            };
            ui.data_mut(|d| d.insert_temp(grip, taken));
            taken
        });
        if !taken.has_moved && pointer.x == taken.x {
            return;
        }
        let has_moved = true;
        ui.data_mut(|d| d.insert_temp(grip, Grip { has_moved, ..taken }));
        let fraction = f64::from((pointer.x + taken.offset - left) / width);
        *value = self.at_fraction(fraction);
    }

    fn reset_button(&self, ui: &Ui, spot: Rect, value: &mut f64) {
        let p = Palette::of(ui);
        let id = ui.scope_id().with(("reset", self.name));
        let reset = ui.interact(spot, id, Sense::click());
        let color = if reset.hovered() { p.strong } else { p.weak };
        super::Icon::Restart.paint(ui.painter(), spot.center(), color);
        focus_ring(ui, &reset, spot, 4);
        reset.widget_info(|| {
            WidgetInfo::labeled(
                Role::Button,
                ui.is_enabled(),
                format!("Reset {}", lower(self.name)),
            )
        });
        if reset.clicked()
            && let Some(default) = self.default
        {
            *value = default;
        }
        reset.on_hover_text("Back to the usual value.");
    }

    /// The number; a click turns it into a text field.
    fn number(&self, ui: &mut Ui, id: Id, rect: Rect, value: &mut f64) {
        let p = Palette::of(ui);
        let typing = id.with("typing");
        let text = ui.data(|d| d.get_temp::<String>(typing));
        let Some(mut text) = text else {
            let shown = self.in_words(*value);
            let response = ui.interact(rect, id.with("number"), Sense::click());
            let color = if response.hovered() { p.strong } else { p.text };
            ui.painter().text(
                rect.right_center(),
                Align2::RIGHT_CENTER,
                &shown,
                theme::body(),
                color,
            );
            focus_ring(ui, &response, rect, 4);
            response.widget_info(|| {
                let name = format!("Type {}", lower(self.name));
                WidgetInfo::labeled(Role::Button, ui.is_enabled(), name)
            });
            if response.clicked() {
                let text = significant(*value, 6);
                ui.data_mut(|d| d.insert_temp(typing, text));
                ui.memory_mut(|m| m.request_focus(id.with("field")));
            }
            response.on_hover_text("A click lets the number be typed.");
            return;
        };
        let field = TextEdit::singleline(&mut text)
            .id(id.with("field"))
            .align(Align2::RIGHT_CENTER)
            .margin(egui::Margin::symmetric(4, 0))
            .font(theme::body());
        let response = ui.put(rect, field).accessible_name(self.name);
        if response.lost_focus() {
            if !ui.input(|i| i.key_pressed(Key::Escape))
                && let Ok(wanted) = text.trim().replace(',', ".").parse::<f64>()
            {
                *value = self.admit(wanted);
            }
            ui.data_mut(|d| d.remove::<String>(typing));
        } else {
            ui.data_mut(|d| d.insert_temp(typing, text));
        }
    }

    fn in_words(&self, value: f64) -> String {
        if value == 0.0 && !self.zero.is_empty() {
            return self.zero.to_owned();
        }
        let number = match self.step {
            Some(step) if step >= 1.0 => format!("{value:.0}"),
            _ => significant(value, 3),
        };
        if self.unit.is_empty() {
            number
        } else {
            format!("{number} {}", self.unit)
        }
    }

    fn admit(&self, value: f64) -> f64 {
        let stepped = match self.step {
            Some(step) => (value / step).round() * step,
            None => value,
        };
        stepped.clamp(self.range.0, self.range.1)
    }

    fn log_start(&self) -> f64 {
        if self.range.0 > 0.0 {
            self.range.0
        } else {
            self.range.1 * 1e-5
        }
    }

    fn fraction(&self, value: f64) -> f64 {
        let (min, max) = self.range;
        let fraction = if self.is_logarithmic {
            let start = self.log_start();
            (value.max(start) / start).ln() / (max / start).ln()
        } else {
            (value - min) / (max - min)
        };
        if fraction.is_finite() {
            fraction.clamp(0.0, 1.0)
        } else {
            0.0
        }
    }

    fn at_fraction(&self, fraction: f64) -> f64 {
        let (min, max) = self.range;
        let fraction = fraction.clamp(0.0, 1.0);
        let value = if self.is_logarithmic {
            if fraction <= 0.0 {
                min
            } else {
                let start = self.log_start();
                start * (max / start).powf(fraction)
            }
        } else {
            min + (max - min) * fraction
        };
        self.admit(value)
    }
}

/// A name within a sentence.
fn lower(name: &str) -> String {
    let mut characters = name.chars();
    let first = characters.next().into_iter().flat_map(char::to_lowercase);
    first.chain(characters).collect()
}

#[cfg(test)]
mod tests {
    use super::Slider;

    #[test]
    fn fractions_read_back() {
        for slider in [
            Slider::new("a", 0.0, 4.0),
            Slider::new("b", 0.1, 100.0).logarithmic(true),
        ] {
            for fraction in [0.0, 0.25, 0.9, 1.0] {
                let back = slider.fraction(slider.at_fraction(fraction));
                assert!((back - fraction).abs() < 1e-9, "{fraction} {back}");
            }
        }
    }

    #[test]
    fn nothing_has_a_word() {
        let rays = Slider::new("rays", 0.0, 64.0).step(1.0).unit("rays");
        assert_eq!(rays.in_words(0.0), "0 rays");
        assert_eq!(rays.zero("off").in_words(0.0), "off");
    }
}
