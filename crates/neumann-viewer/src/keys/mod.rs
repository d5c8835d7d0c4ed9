//! Keys: one table drives the input, and it is the help page.
//!
//! Lines of the window are rows of [`HELP`]; those of views stand in their own rows of `VIEWS`.

mod places;
mod table;

use egui::{Context, Event, Key, Modifiers};

use crate::views::VIEWS;

pub use places::Places;
pub use table::HELP;
pub(crate) use table::{DISPLAY, NONE, SHIFT, line, on};

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
    /// Pause or resume.
    Pause,
    /// Begin again.
    Restart,
    /// Frame the whole scene.
    FrameAll,
    /// Back to the file's camera.
    ResetCamera,
    /// Undo the last edit.
    Undo,
    /// Redo what was undone last.
    Redo,
    /// The material under the pointer, or in the middle of the picture.
    Pick,
    /// Go to a kept view of the scene, from 0.
    GoToView(usize),
    /// Keep the camera as that view.
    KeepView(usize),
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
    /// The next drag draws a region that is rendered alone; or the whole picture again.
    Region,
    /// A film of the size that fits the window.
    FitFilm,
    /// Hold the present picture as A.
    HoldA,
    /// Hold the present picture as B.
    HoldB,
    /// The wipe between A and B, on or off.
    Wipe,
    /// What the pixel under the pointer holds, on or off.
    Probe,
    /// The difference from the reference, on or off.
    Difference,
    /// The view so many places further in the choice "Show".
    Show(i32),
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
    /// Send the picture to tev from now on, or no longer.
    SendToTev,
    /// Copy the picture.
    Copy,
    /// Copy the command that renders the same.
    CopyCommand,
    /// Copy all that has been chosen, as text.
    CopyState,
    /// Show or hide the panels.
    Panels,
    /// Show a panel.
    Panel(usize),
    /// Give the keyboard to the panel, or take it away.
    Controls,
    /// Light or dark.
    Theme,
    /// Text larger by so many tenths; 0 brings back the usual size.
    TextScale(i32),
    /// Picture, caption, method and filmstrip alone, large; or no longer.
    Present,
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
            let (key, place, modifiers) = match event {
                Event::Copy if !is_typing => {
                    actions.push(Action::Copy);
                    return false;
                }
                Event::Key {
                    key,
                    physical_key,
                    pressed: true,
                    modifiers,
                    ..
                } => (*key, *physical_key, *modifiers),
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
            let Some(binding) = places::binding(key, place, modifiers) else {
                return true;
            };
            if is_typing && matches!(binding.action, Action::Undo | Action::Redo) {
                // A text field undoes what is typed into it.
                return true;
            }
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
        Key::F1 | Key::F2 | Key::F3 | Key::F4 | Key::F5 | Key::F6 | Key::F11
    )
}

#[cfg(test)]
mod tests {
    use egui::{Key, Modifiers};
    use winit::keyboard::KeyCode;

    use super::places::binding;
    use super::{Action, Places, all, lines, same};

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

    /// What egui tells of a key: by the name of what is printed, else by the name of its place.
    #[test]
    fn keys_do_the_same_on_all_keyboards() {
        const NONE: Modifiers = Modifiers::NONE;
        const SHIFT: Modifiers = Modifiers::SHIFT;
        let cases = [
            ("us 4", Key::Num4, Key::Num4, NONE, Some(Action::Term(4))),
            (
                "us !",
                Key::Exclamationmark,
                Key::Num1,
                SHIFT,
                Some(Action::Upto(1)),
            ),
            (
                "us ?",
                Key::Questionmark,
                Key::Slash,
                SHIFT,
                Some(Action::Help),
            ),
            (
                "us =",
                Key::Equals,
                Key::Equals,
                NONE,
                Some(Action::Zoom(1)),
            ),
            ("fr '", Key::Quote, Key::Num4, NONE, Some(Action::Term(4))),
            ("fr -", Key::Minus, Key::Num6, NONE, Some(Action::Term(6))),
            ("fr 4", Key::Num4, Key::Num4, SHIFT, Some(Action::Upto(4))),
            (
                "fr ^",
                Key::OpenBracket,
                Key::OpenBracket,
                NONE,
                Some(Action::Method(-1)),
            ),
            (
                "fr [",
                Key::OpenBracket,
                Key::Num5,
                NONE,
                Some(Action::Method(-1)),
            ),
            ("fr W", Key::W, Key::Z, NONE, None),
            ("de /", Key::Slash, Key::Num7, SHIFT, Some(Action::Upto(7))),
            (
                "de ?",
                Key::Questionmark,
                Key::Minus,
                SHIFT,
                Some(Action::Help),
            ),
            (
                "de ]",
                Key::CloseBracket,
                Key::Num9,
                NONE,
                Some(Action::Method(1)),
            ),
            (
                "de +",
                Key::Plus,
                Key::CloseBracket,
                NONE,
                Some(Action::Zoom(1)),
            ),
            (
                "de ü",
                Key::OpenBracket,
                Key::OpenBracket,
                NONE,
                Some(Action::Method(-1)),
            ),
            ("de -", Key::Minus, Key::Slash, NONE, Some(Action::Zoom(-1))),
            ("de Z", Key::Z, Key::Y, NONE, Some(Action::ZoomFit)),
            ("cz +", Key::Plus, Key::Num1, NONE, Some(Action::Term(1))),
            ("cz 1", Key::Num1, Key::Num1, SHIFT, Some(Action::Upto(1))),
            (
                "number pad",
                Key::Num7,
                Key::Num7,
                NONE,
                Some(Action::Term(7)),
            ),
            (
                "its arrow",
                Key::ArrowLeft,
                Key::Num4,
                NONE,
                Some(Action::Step(-1)),
            ),
        ];
        for (what, printed, place, held, expected) in cases {
            let found = binding(printed, Some(place), held).map(|b| b.action);
            assert_eq!(found, expected, "{what}");
        }
    }

    #[test]
    fn the_help_page_names_keys_as_they_are_printed() {
        let brackets = lines().find(|line| line.keys == "[ ]").expect("a line");
        let printed = |left, right| {
            let mut places = Places::default();
            places.learn(KeyCode::BracketLeft, left);
            places.learn(KeyCode::BracketRight, right);
            places.keys(brackets).map(std::borrow::Cow::into_owned)
        };
        assert_eq!(printed("[", "]").as_deref(), Some("[ ]"));
        assert_eq!(printed("^", "$").as_deref(), Some("^ $"));
        assert_eq!(printed("ú", ")").as_deref(), Some("ú )"));
        // The second one magnifies.
        assert_eq!(printed("ü", "+"), None);
        assert_eq!(Places::default().keys(brackets).as_deref(), Some("[ ]"));
    }
}
