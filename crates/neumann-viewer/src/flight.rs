//! Flying: the camera moves while its keys are held.

use egui::{Context, Key};
use glam::Vec3;

use crate::setup::Setup;

/// Moves the camera by this frame's share.
pub fn steer(ctx: &Context, setup: &mut Setup) {
    if ctx.text_edit_focused() || setup.camera.is_none() {
        return;
    }
    let step = ctx.input(|i| {
        if i.modifiers.command || i.modifiers.alt {
            return Vec3::ZERO;
        }
        let held = |plus, minus| {
            // A press and its release within one frame count as a step too.
            let is_on = |key| i.key_down(key) || i.key_pressed(key);
            f32::from(i8::from(is_on(plus)) - i8::from(is_on(minus)))
        };
        let direction = Vec3::new(
            held(Key::D, Key::A),
            held(Key::PageUp, Key::PageDown),
            held(Key::W, Key::S),
        );
        let speed = if i.modifiers.shift { 2.0 } else { 0.5 };
        direction * speed * i.stable_dt.min(0.1)
    });
    if step == Vec3::ZERO {
        return;
    }
    if let Some(control) = &mut setup.camera {
        control.fly(step * control.radius());
        setup.is_changed = true;
        ctx.request_repaint();
    }
}
