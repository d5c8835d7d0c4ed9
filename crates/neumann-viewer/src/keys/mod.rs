//! Keys: one table drives the input, and it is the help page.
//!
//! Lines of the window are rows of [`HELP`]; those of views stand in their own rows of `VIEWS`.

mod table;

use egui::{Context, Event, Key, Modifiers};

use crate::views::VIEWS;

pub use table::HELP;
pub(crate) use table::{DISPLAY, NONE, line, on};

/// What a key does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Show a term of the series.
    Term(usize),
    /// Show a partial sum.
    Upto(usize),
    /// Show everything.
    Total,
    /// Step along the filmstrip.
    Step(i32),
    /// Go to the row of terms (true) or of sums.
    Row(bool),
    /// The method so many places further.
    Method(i32),
    /// Pause or go on.
    Pause,
    /// Begin again.
    Restart,
    /// Frame the whole scene.
    FrameAll,
    /// Back to the file's camera.
    ResetCamera,
    /// Change the exposure by so many thirds of a stop.
    Exposure(i32),
    /// Exposure follows the picture.
    AutoExposure,
    /// The tone curve so many places further.
    Tone(i32),
    /// False colour on or off.
    FalseColour,
    /// Magnify by so many factors of two.
    Zoom(i32),
    /// Show the whole picture.
    ZoomFit,
    /// Hold the present picture as A.
    HoldA,
    /// Hold the present picture as B.
    HoldB,
    /// The wipe between A and B, on or off.
    Wipe,
    /// The difference to the reference, on or off.
    Difference,
    /// A view by its id, or the picture where it is shown already.
    View(&'static str),
    /// Open a scene.
    Open,
    /// Save the picture as PNG.
    SavePng,
    /// Save all layers as EXR.
    SaveExr,
    /// Save all that has been chosen.
    SaveState,
    /// Save the series as a sheet.
    SaveSheet,
    /// Copy the picture.
    Copy,
    /// Show or hide the panels.
    Panels,
    /// Show a panel.
    Panel(usize),
    /// Give the keyboard to the controls.
    Controls,
    /// Light or dark.
    Theme,
    /// The help page.
    Help,
    /// Fill the screen.
    Fullscreen,
    /// Close what lies over the picture.
    Escape,
    /// Leave.
    Quit,
}

/// A key with what it does.
pub struct Binding {
    /// Keys held down.
    pub modifiers: Modifiers,
    /// The key.
    pub key: Key,
    /// What it does.
    pub action: Action,
}

/// One line of the help page.
pub struct HelpLine {
    /// Heading under which it stands.
    pub group: &'static str,
    /// The keys, in words.
    pub keys: &'static str,
    /// What they do.
    pub text: &'static str,
    /// The bindings it explains.
    bindings: &'static [Binding],
}

/// Takes from the frame's events those that the table binds, in the order they came.
///
/// While a text field has the keyboard only combinations with Ctrl and function keys act; while
/// another control has it, arrows, Space and Tab stay with it.
pub fn take_actions(ctx: &Context) -> Vec<Action> {
    let is_typing = ctx.text_edit_focused();
    let focused = ctx.memory(|m| m.focused());
    let mut actions = Vec::new();
    let mut has_taken_tab = false;
    ctx.input_mut(|input| {
        input.events.retain(|event| {
            let (key, modifiers) = match event {
                Event::Copy if !is_typing => {
                    actions.push(Action::Copy);
                    return false;
                }
                Event::Key {
                    key,
                    pressed: true,
                    modifiers,
                    ..
                } => (*key, *modifiers),
                _ => return true,
            };
            let belongs_to_control = if is_typing {
                !(modifiers.command || is_function_key(key) || key == Key::Escape)
            } else {
                focused.is_some()
                    && matches!(
                        key,
                        Key::Tab
                            | Key::Space
                            | Key::Enter
                            | Key::ArrowLeft
                            | Key::ArrowRight
                            | Key::ArrowUp
                            | Key::ArrowDown
                    )
            };
            if belongs_to_control {
                return true;
            }
            let Some(binding) = all().find(|b| b.key == key && same(modifiers, b.modifiers)) else {
                return true;
            };
            has_taken_tab |= key == Key::Tab;
            actions.push(binding.action);
            // Escape must reach a text field that has the keyboard.
            key == Key::Escape
        });
    });
    if has_taken_tab {
        ctx.memory_mut(|m| m.move_focus(egui::FocusDirection::None));
    }
    actions
}

/// All lines of the help page; those of views stand at the end of the group that they belong to.
pub fn lines() -> impl Iterator<Item = &'static HelpLine> {
    let mut lines: Vec<&HelpLine> = HELP.iter().collect();
    for line in VIEWS.iter().filter_map(|row| row.key.as_ref()) {
        let group = lines.iter().rposition(|other| other.group == line.group);
        lines.insert(group.map_or(lines.len(), |last| last + 1), line);
    }
    lines.into_iter()
}

fn all() -> impl Iterator<Item = &'static Binding> {
    lines().flat_map(|line| line.bindings)
}

fn same(held: Modifiers, wanted: Modifiers) -> bool {
    held.alt == wanted.alt
        && held.shift == wanted.shift
        && (held.ctrl || held.command || held.mac_cmd) == (wanted.ctrl || wanted.command)
}

fn is_function_key(key: Key) -> bool {
    matches!(
        key,
        Key::F1 | Key::F2 | Key::F3 | Key::F4 | Key::F6 | Key::F11
    )
}

#[cfg(test)]
mod tests {
    use super::{all, same};

    #[test]
    fn no_key_does_two_things() {
        let bindings: Vec<_> = all().collect();
        for (i, a) in bindings.iter().enumerate() {
            for b in &bindings[i + 1..] {
                let clash = a.key == b.key && same(a.modifiers, b.modifiers);
                assert!(!clash, "{:?} and {:?}", a.action, b.action);
            }
        }
    }
}
