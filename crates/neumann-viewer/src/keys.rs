//! One table of keys: it drives the input and it is the help page.

use egui::{Context, Event, Key, Modifiers};

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
    /// The techniques apart, or the picture.
    Techniques,
    /// Open a scene.
    Open,
    /// Save the picture as PNG.
    SavePng,
    /// Save all layers as EXR.
    SaveExr,
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

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL: Modifiers = Modifiers::COMMAND;

const fn on(modifiers: Modifiers, key: Key, action: Action) -> Binding {
    Binding {
        modifiers,
        key,
        action,
    }
}

const fn line(
    group: &'static str,
    keys: &'static str,
    text: &'static str,
    bindings: &'static [Binding],
) -> HelpLine {
    HelpLine {
        group,
        keys,
        text,
        bindings,
    }
}

const SERIES: &str = "Series";
const RENDERING: &str = "Rendering";
const CAMERA: &str = "Camera";
const DISPLAY: &str = "Display";
const FILES: &str = "Files";
const WINDOW: &str = "Window";

/// All keys, in the order of the help page.
pub static HELP: &[HelpLine] = &[
    line(
        SERIES,
        "0 – 9",
        "one term of the series",
        &[
            on(NONE, Key::Num0, Action::Term(0)),
            on(NONE, Key::Num1, Action::Term(1)),
            on(NONE, Key::Num2, Action::Term(2)),
            on(NONE, Key::Num3, Action::Term(3)),
            on(NONE, Key::Num4, Action::Term(4)),
            on(NONE, Key::Num5, Action::Term(5)),
            on(NONE, Key::Num6, Action::Term(6)),
            on(NONE, Key::Num7, Action::Term(7)),
            on(NONE, Key::Num8, Action::Term(8)),
            on(NONE, Key::Num9, Action::Term(9)),
        ],
    ),
    line(
        SERIES,
        "Shift 0 – 9",
        "the sum up to it",
        &[
            on(SHIFT, Key::Num0, Action::Upto(0)),
            on(SHIFT, Key::Num1, Action::Upto(1)),
            on(SHIFT, Key::Num2, Action::Upto(2)),
            on(SHIFT, Key::Num3, Action::Upto(3)),
            on(SHIFT, Key::Num4, Action::Upto(4)),
            on(SHIFT, Key::Num5, Action::Upto(5)),
            on(SHIFT, Key::Num6, Action::Upto(6)),
            on(SHIFT, Key::Num7, Action::Upto(7)),
            on(SHIFT, Key::Num8, Action::Upto(8)),
            on(SHIFT, Key::Num9, Action::Upto(9)),
        ],
    ),
    line(
        SERIES,
        "L",
        "everything",
        &[on(NONE, Key::L, Action::Total)],
    ),
    line(
        SERIES,
        "← →",
        "step along the row",
        &[
            on(NONE, Key::ArrowLeft, Action::Step(-1)),
            on(NONE, Key::ArrowRight, Action::Step(1)),
        ],
    ),
    line(
        SERIES,
        "↑ ↓",
        "terms, sums",
        &[
            on(NONE, Key::ArrowUp, Action::Row(true)),
            on(NONE, Key::ArrowDown, Action::Row(false)),
        ],
    ),
    line(
        RENDERING,
        "[ ]",
        "method before, after",
        &[
            on(NONE, Key::OpenBracket, Action::Method(-1)),
            on(NONE, Key::CloseBracket, Action::Method(1)),
        ],
    ),
    line(
        RENDERING,
        "Space",
        "pause, go on",
        &[on(NONE, Key::Space, Action::Pause)],
    ),
    line(
        RENDERING,
        "R",
        "begin again",
        &[on(NONE, Key::R, Action::Restart)],
    ),
    line(CAMERA, "drag", "orbit", &[]),
    line(CAMERA, "Shift drag", "pan (or the middle button)", &[]),
    line(CAMERA, "wheel", "dolly", &[]),
    line(CAMERA, "Alt click", "focus the lens there", &[]),
    line(CAMERA, "W A S D", "fly; PgUp PgDn up and down", &[]),
    line(
        CAMERA,
        "F",
        "frame the whole scene",
        &[on(NONE, Key::F, Action::FrameAll)],
    ),
    line(
        CAMERA,
        "Home",
        "the file's own camera",
        &[on(NONE, Key::Home, Action::ResetCamera)],
    ),
    line(
        DISPLAY,
        "E  Shift E",
        "brighter, darker",
        &[
            on(NONE, Key::E, Action::Exposure(1)),
            on(SHIFT, Key::E, Action::Exposure(-1)),
        ],
    ),
    line(
        DISPLAY,
        "Ctrl E",
        "automatic exposure",
        &[on(CTRL, Key::E, Action::AutoExposure)],
    ),
    line(
        DISPLAY,
        "T  Shift T",
        "tone curve",
        &[
            on(NONE, Key::T, Action::Tone(1)),
            on(SHIFT, Key::T, Action::Tone(-1)),
        ],
    ),
    line(
        DISPLAY,
        "C",
        "false colour",
        &[on(NONE, Key::C, Action::FalseColour)],
    ),
    line(
        DISPLAY,
        "+ −  Z",
        "magnify; whole picture",
        &[
            on(NONE, Key::Plus, Action::Zoom(1)),
            on(SHIFT, Key::Plus, Action::Zoom(1)),
            on(NONE, Key::Equals, Action::Zoom(1)),
            on(NONE, Key::Minus, Action::Zoom(-1)),
            on(NONE, Key::Z, Action::ZoomFit),
        ],
    ),
    line(
        DISPLAY,
        "H  Shift H",
        "hold as A, as B",
        &[
            on(NONE, Key::H, Action::HoldA),
            on(SHIFT, Key::H, Action::HoldB),
        ],
    ),
    line(
        DISPLAY,
        "X",
        "wipe between A and B",
        &[on(NONE, Key::X, Action::Wipe)],
    ),
    line(
        DISPLAY,
        "G",
        "difference to the reference",
        &[on(NONE, Key::G, Action::Difference)],
    ),
    line(
        DISPLAY,
        "V",
        "techniques (s, t) apart",
        &[on(NONE, Key::V, Action::Techniques)],
    ),
    line(
        FILES,
        "Ctrl O",
        "open a scene",
        &[on(CTRL, Key::O, Action::Open)],
    ),
    line(
        FILES,
        "Ctrl S",
        "save the picture, PNG",
        &[on(CTRL, Key::S, Action::SavePng)],
    ),
    line(
        FILES,
        "Ctrl Shift S",
        "save all layers, EXR",
        &[on(CTRL.plus(SHIFT), Key::S, Action::SaveExr)],
    ),
    line(
        FILES,
        "Ctrl Alt S",
        "save the series as a sheet",
        &[on(CTRL.plus(Modifiers::ALT), Key::S, Action::SaveSheet)],
    ),
    line(
        FILES,
        "Ctrl C",
        "copy the picture",
        &[on(CTRL, Key::C, Action::Copy)],
    ),
    line(
        WINDOW,
        "Tab",
        "show or hide the panels",
        &[on(NONE, Key::Tab, Action::Panels)],
    ),
    line(
        WINDOW,
        "F1 – F4",
        "method, scene, camera, display",
        &[
            on(NONE, Key::F1, Action::Panel(0)),
            on(NONE, Key::F2, Action::Panel(1)),
            on(NONE, Key::F3, Action::Panel(2)),
            on(NONE, Key::F4, Action::Panel(3)),
        ],
    ),
    line(
        WINDOW,
        "F6",
        "keyboard to the controls: Tab, arrows, Enter; Esc leaves",
        &[on(NONE, Key::F6, Action::Controls)],
    ),
    line(
        WINDOW,
        "Ctrl T",
        "light or dark",
        &[on(CTRL, Key::T, Action::Theme)],
    ),
    line(
        WINDOW,
        "F11",
        "fill the screen",
        &[on(NONE, Key::F11, Action::Fullscreen)],
    ),
    line(
        WINDOW,
        "?",
        "this page",
        &[
            on(NONE, Key::Questionmark, Action::Help),
            on(SHIFT, Key::Questionmark, Action::Help),
            on(SHIFT, Key::Slash, Action::Help),
        ],
    ),
    line(
        WINDOW,
        "Esc",
        "close what lies over the picture",
        &[on(NONE, Key::Escape, Action::Escape)],
    ),
    line(WINDOW, "Ctrl Q", "quit", &[on(CTRL, Key::Q, Action::Quit)]),
];

/// Takes from the frame's events those that the table binds, in the order they came.
///
/// While a text field has the keyboard only combinations with Ctrl and function
/// keys act; while another control has it, arrows, Space and Tab stay with it.
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

fn all() -> impl Iterator<Item = &'static Binding> {
    HELP.iter().flat_map(|line| line.bindings)
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
