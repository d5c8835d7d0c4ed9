//! A thing that is turned by hand: by dragging it, or by arrows while it has the keyboard.

use egui::{CursorIcon, EventFilter, Key, Rect, Response, Ui, Vec2};

/// Turn, radians, for a drag across its height.
const TURN: f32 = 3.0;
/// Turn for a press of an arrow, radians.
const STEP: f32 = 0.1;

/// How far it is turned, about the vertical and up, radians.
pub(super) fn taken(ui: &Ui, response: &Response, rect: Rect) -> Vec2 {
    let drag = response.drag_delta() / rect.height().max(1.0);
    let mut turn = TURN * Vec2::new(-drag.x, drag.y);
    if response.has_focus() {
        let presses = |key| ui.input(|input| input.num_presses(key)) as f32;
        let x = presses(Key::ArrowRight) - presses(Key::ArrowLeft);
        let y = presses(Key::ArrowUp) - presses(Key::ArrowDown);
        turn += STEP * Vec2::new(x, y);
        ui.memory_mut(|memory| {
            let filter = EventFilter {
                horizontal_arrows: true,
                vertical_arrows: true,
                ..EventFilter::default()
            };
            memory.set_focus_lock_filter(response.id, filter);
        });
    }
    if response.dragged() {
        ui.ctx().set_cursor_icon(CursorIcon::Grabbing);
    }
    turn
}
