//! The table of keys.

use egui::{Key, Modifiers};

use super::{Action, Binding, HelpLine};

pub(crate) const NONE: Modifiers = Modifiers::NONE;
pub(crate) const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL: Modifiers = Modifiers::COMMAND;

/// A key that does something.
pub(crate) const fn on(modifiers: Modifiers, key: Key, action: Action) -> Binding {
    Binding {
        modifiers,
        key,
        action,
    }
}

/// A line of the help page.
pub(crate) const fn line(
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
pub(crate) const DISPLAY: &str = "Display";
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
        "partial sum up to that term",
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
        "the whole sum",
        &[on(NONE, Key::L, Action::Total)],
    ),
    line(
        SERIES,
        "← →",
        "previous, next in the row",
        &[
            on(NONE, Key::ArrowLeft, Action::Step(-1)),
            on(NONE, Key::ArrowRight, Action::Step(1)),
        ],
    ),
    line(
        SERIES,
        "↑ ↓",
        "row of terms, of sums",
        &[
            on(NONE, Key::ArrowUp, Action::Row(true)),
            on(NONE, Key::ArrowDown, Action::Row(false)),
        ],
    ),
    line(
        RENDERING,
        "[ ]",
        "previous, next method",
        &[
            on(NONE, Key::OpenBracket, Action::Method(-1)),
            on(NONE, Key::CloseBracket, Action::Method(1)),
        ],
    ),
    line(
        RENDERING,
        "M  Shift M",
        "next, previous method",
        &[
            on(NONE, Key::M, Action::Method(1)),
            on(SHIFT, Key::M, Action::Method(-1)),
        ],
    ),
    line(
        RENDERING,
        "Space",
        "pause, resume",
        &[on(NONE, Key::Space, Action::Pause)],
    ),
    line(
        RENDERING,
        "R",
        "restart",
        &[on(NONE, Key::R, Action::Restart)],
    ),
    line(
        RENDERING,
        "B",
        "draw a region; end it",
        &[on(NONE, Key::B, Action::Region)],
    ),
    line(
        RENDERING,
        "Ctrl Z  Ctrl Y",
        "undo, redo (or Ctrl Shift Z)",
        &[
            on(CTRL, Key::Z, Action::Undo),
            on(CTRL, Key::Y, Action::Redo),
            on(CTRL.plus(SHIFT), Key::Z, Action::Redo),
        ],
    ),
    line(CAMERA, "drag", "orbit", &[]),
    line(CAMERA, "Shift drag", "pan (or the middle button)", &[]),
    line(CAMERA, "wheel", "dolly", &[]),
    line(CAMERA, "Ctrl click", "focus the lens there", &[]),
    line(
        CAMERA,
        "Shift click",
        "show the material there (Shift I)",
        &[on(SHIFT, Key::I, Action::Pick)],
    ),
    line(CAMERA, "W A S D", "fly; PgUp, PgDn: up, down", &[]),
    line(CAMERA, "wheel in flight", "fly faster, slower", &[]),
    line(
        CAMERA,
        "F",
        "frame the whole scene",
        &[on(NONE, Key::F, Action::FrameAll)],
    ),
    line(
        CAMERA,
        "Home",
        "reset the camera",
        &[on(NONE, Key::Home, Action::ResetCamera)],
    ),
    line(
        CAMERA,
        "Ctrl 1 – 9",
        "go to a view that was kept",
        &[
            on(CTRL, Key::Num1, Action::GoToView(0)),
            on(CTRL, Key::Num2, Action::GoToView(1)),
            on(CTRL, Key::Num3, Action::GoToView(2)),
            on(CTRL, Key::Num4, Action::GoToView(3)),
            on(CTRL, Key::Num5, Action::GoToView(4)),
            on(CTRL, Key::Num6, Action::GoToView(5)),
            on(CTRL, Key::Num7, Action::GoToView(6)),
            on(CTRL, Key::Num8, Action::GoToView(7)),
            on(CTRL, Key::Num9, Action::GoToView(8)),
        ],
    ),
    line(
        CAMERA,
        "Ctrl Shift 1 – 9",
        "keep the view under that number",
        &[
            on(CTRL.plus(SHIFT), Key::Num1, Action::KeepView(0)),
            on(CTRL.plus(SHIFT), Key::Num2, Action::KeepView(1)),
            on(CTRL.plus(SHIFT), Key::Num3, Action::KeepView(2)),
            on(CTRL.plus(SHIFT), Key::Num4, Action::KeepView(3)),
            on(CTRL.plus(SHIFT), Key::Num5, Action::KeepView(4)),
            on(CTRL.plus(SHIFT), Key::Num6, Action::KeepView(5)),
            on(CTRL.plus(SHIFT), Key::Num7, Action::KeepView(6)),
            on(CTRL.plus(SHIFT), Key::Num8, Action::KeepView(7)),
            on(CTRL.plus(SHIFT), Key::Num9, Action::KeepView(8)),
        ],
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
        "N  Shift N",
        "albedo, normal, depth, …",
        &[
            on(NONE, Key::N, Action::Show(1)),
            on(SHIFT, Key::N, Action::Show(-1)),
        ],
    ),
    line(
        DISPLAY,
        "+ −  Z",
        "magnify; fit the picture",
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
        "Shift Z",
        "fit the film to the window",
        &[on(SHIFT, Key::Z, Action::FitFilm)],
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
        "I",
        "pixel values",
        &[on(NONE, Key::I, Action::Probe)],
    ),
    line(
        DISPLAY,
        "G",
        "difference from the reference",
        &[on(NONE, Key::G, Action::Difference)],
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
        "save the state, JSON",
        &[on(CTRL.plus(SHIFT), Key::S, Action::SaveState)],
    ),
    line(
        FILES,
        "Ctrl Shift E",
        "save all layers, EXR",
        &[on(CTRL.plus(SHIFT), Key::E, Action::SaveExr)],
    ),
    line(
        FILES,
        "Ctrl Shift P",
        "save the series as a sheet",
        &[on(CTRL.plus(SHIFT), Key::P, Action::SaveSheet)],
    ),
    line(
        FILES,
        "Ctrl Shift T",
        "send all layers to tev, live",
        &[on(CTRL.plus(SHIFT), Key::T, Action::SendToTev)],
    ),
    line(
        FILES,
        "Ctrl C",
        "copy the picture",
        &[on(CTRL, Key::C, Action::Copy)],
    ),
    line(
        FILES,
        "Ctrl Shift L",
        "copy as a command",
        &[on(CTRL.plus(SHIFT), Key::L, Action::CopyCommand)],
    ),
    line(
        FILES,
        "Ctrl Shift C",
        "copy the state",
        &[on(CTRL.plus(SHIFT), Key::C, Action::CopyState)],
    ),
    line(FILES, "Ctrl V", "paste a state", &[]),
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
        "F5",
        "present without panels",
        &[on(NONE, Key::F5, Action::Present)],
    ),
    line(
        WINDOW,
        "F6",
        "keyboard to the panel, back",
        &[on(NONE, Key::F6, Action::Controls)],
    ),
    line(
        WINDOW,
        "Ctrl T",
        "light or dark theme",
        &[on(CTRL, Key::T, Action::Theme)],
    ),
    line(
        WINDOW,
        "Ctrl +  −  0",
        "larger, smaller, usual text",
        &[
            on(CTRL, Key::Plus, Action::TextScale(1)),
            on(CTRL.plus(SHIFT), Key::Plus, Action::TextScale(1)),
            on(CTRL, Key::Equals, Action::TextScale(1)),
            on(CTRL, Key::Minus, Action::TextScale(-1)),
            on(CTRL, Key::Num0, Action::TextScale(0)),
        ],
    ),
    line(
        WINDOW,
        "F11",
        "full screen",
        &[on(NONE, Key::F11, Action::Fullscreen)],
    ),
    line(
        WINDOW,
        "?",
        "this help",
        &[
            on(NONE, Key::Questionmark, Action::Help),
            on(SHIFT, Key::Questionmark, Action::Help),
        ],
    ),
    line(
        WINDOW,
        "Esc",
        "close or go back",
        &[on(NONE, Key::Escape, Action::Escape)],
    ),
    line(WINDOW, "Ctrl Q", "quit", &[on(CTRL, Key::Q, Action::Quit)]),
];
