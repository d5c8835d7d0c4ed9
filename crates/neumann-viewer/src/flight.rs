//! Flying: the camera moves while its keys are held.

use egui::{Context, InputState, Key, Vec2};
use glam::Vec3;

use crate::setup::Setup;

/// How fast the camera flies.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// Half diagonals of what the scene is about, in a second.
    speed: f32,
}

/// Slowest and fastest.
const SPEEDS: (f32, f32) = (0.005, 50.0);

impl Default for Flight {
    fn default() -> Self {
        Self { speed: 0.5 }
    }
}

impl Flight {
    /// Half diagonals of what the scene is about, in a second.
    #[must_use]
    pub fn speed(&self) -> f32 {
        self.speed
    }

    /// Moves the camera by this frame's share. The wheel, turned meanwhile, changes the speed, and
    /// does nothing else. True if it has.
    pub fn steer(&mut self, ctx: &Context, setup: &mut Setup) -> bool {
        let Some(control) = &mut setup.camera else {
            return false;
        };
        if ctx.text_edit_focused() {
            return false;
        }
        let (direction, wheel, seconds) = ctx.input_mut(|i| {
            let direction = direction(i);
            if direction == Vec3::ZERO {
                return (direction, 0.0, 0.0);
            }
            let wheel = std::mem::replace(&mut i.smooth_scroll_delta, Vec2::ZERO).y;
            let hurry = if i.modifiers.shift { 4.0 } else { 1.0 };
            (direction * hurry, wheel, i.stable_dt.min(0.1))
        });
        self.speed = (self.speed * (wheel * 0.005).exp()).clamp(SPEEDS.0, SPEEDS.1);
        if direction != Vec3::ZERO {
            control.fly(direction * self.speed * seconds * control.radius());
            setup.is_changed = true;
            ctx.request_repaint();
        }
        wheel != 0.0
    }
}

/// Where the keys that are held point: right, up, ahead.
fn direction(i: &InputState) -> Vec3 {
    if i.modifiers.command || i.modifiers.alt {
        return Vec3::ZERO;
    }
    let held = |plus, minus| {
        // A press and its release within one frame count as a step too.
        let is_on = |key| i.key_down(key) || i.key_pressed(key);
        f32::from(i8::from(is_on(plus)) - i8::from(is_on(minus)))
    };
    Vec3::new(
        held(Key::D, Key::A),
        held(Key::PageUp, Key::PageDown),
        held(Key::W, Key::S),
    )
}
