//! Keys that count by their place, and what is printed there.
//!
//! Digits are asked for by their place: French and Czech keyboards print something else there
//! without Shift, and most others with it. Brackets are asked for by what is printed, and by the
//! place that they have on an American keyboard where what is printed there means nothing else.

use std::borrow::Cow;

use egui::{Key, Modifiers};
use winit::keyboard::KeyCode;

use super::{Binding, HelpLine, all, same};

/// What a keyboard prints where an American one has brackets, as far as it is known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Places {
    brackets: [Option<String>; 2],
}

/// Places of brackets, and their names.
const BRACKETS: [(KeyCode, Key); 2] = [
    (KeyCode::BracketLeft, Key::OpenBracket),
    (KeyCode::BracketRight, Key::CloseBracket),
];

/// What a key is bound to.
///
/// # Parameters
/// - `printed`: what the layout makes of it with its modifiers; its place where egui has no name
///   for that.
/// - `place`: what an American keyboard has in its place, if that is known.
pub(super) fn binding(
    printed: Key,
    place: Option<Key>,
    held: Modifiers,
) -> Option<&'static Binding> {
    let find = |key| all().find(|b| b.key == key && same(held, b.modifiers));
    let digit = place.filter(|&place| is_digit(place) && !is_elsewhere(printed));
    let bracket = place.filter(|&place| is_bracket(place));
    digit
        .and_then(find)
        .or_else(|| find(printed))
        .or_else(|| bracket.and_then(find))
}

fn is_digit(key: Key) -> bool {
    (Key::Num0..=Key::Num9).contains(&key)
}

fn is_bracket(key: Key) -> bool {
    BRACKETS.iter().any(|(_, bracket)| *bracket == key)
}

/// True for what a digit's place may print by purpose: brackets by `AltGr`, and all that a number
/// pad does while its digits are off.
fn is_elsewhere(printed: Key) -> bool {
    is_bracket(printed)
        || matches!(
            printed,
            Key::ArrowLeft
                | Key::ArrowRight
                | Key::ArrowUp
                | Key::ArrowDown
                | Key::Home
                | Key::End
                | Key::PageUp
                | Key::PageDown
                | Key::Insert
                | Key::Delete
        )
}

impl Places {
    /// What the display tells of its keyboard; nothing where it tells nothing.
    #[must_use]
    pub fn of_display() -> Self {
        Self {
            brackets: display::printed(BRACKETS.map(|(code, _)| code)),
        }
    }

    /// Takes over what a key prints without modifiers. True if that is new.
    pub fn learn(&mut self, place: KeyCode, printed: &str) -> bool {
        let Some(i) = BRACKETS.iter().position(|(code, _)| *code == place) else {
            return false;
        };
        let known = self.brackets[i].replace(printed.to_owned());
        known.as_deref() != Some(printed)
    }

    /// The keys of a line of the help page, as this keyboard prints them; `None` if it has no keys
    /// for all that the line does.
    #[must_use]
    pub fn keys(&self, line: &HelpLine) -> Option<Cow<'static, str>> {
        if !line.bindings.iter().any(|b| is_bracket(b.key)) {
            return Some(line.keys.into());
        }
        let mut keys = Vec::new();
        for (printed, (_, bracket)) in self.brackets.iter().zip(BRACKETS) {
            let Some(printed) = printed else {
                return Some(line.keys.into());
            };
            let named = Key::from_name(printed).unwrap_or(bracket);
            let does = |key| binding(key, Some(bracket), Modifiers::NONE).map(|b| b.action);
            if does(named) != does(bracket) {
                return None;
            }
            keys.push(printed.as_str());
        }
        Some(keys.join(" ").into())
    }
}

#[cfg(all(unix, not(target_os = "macos")))]
mod display {
    use winit::keyboard::KeyCode;
    use winit::platform::scancode::PhysicalKeyExtScancode;
    use x11rb::protocol::xproto::ConnectionExt;

    /// Asks an X server; nothing where there is none.
    pub(super) fn printed(places: [KeyCode; 2]) -> [Option<String>; 2] {
        let Ok((connection, _)) = x11rb::connect(None) else {
            return [None, None];
        };
        places.map(|place| {
            // X counts keys from 8 on.
            let code = u8::try_from(place.to_scancode()? + 8).ok()?;
            let asked = connection.get_keyboard_mapping(code, 1).ok()?;
            character(*asked.reply().ok()?.keysyms.first()?).map(String::from)
        })
    }

    /// The character of a symbol of the X protocol (appendix A), or of a dead key of its extension.
    fn character(symbol: u32) -> Option<char> {
        match symbol {
            0x20..=0x7e | 0xa0..=0xff => char::from_u32(symbol),
            0x0100_0100..=0x0110_ffff => char::from_u32(symbol - 0x0100_0000),
            0xfe50 => Some('`'),
            0xfe51 => Some('´'),
            0xfe52 => Some('^'),
            0xfe53 => Some('~'),
            0xfe57 => Some('¨'),
            0xfe58 => Some('˚'),
            _ => None,
        }
    }
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
mod display {
    use winit::keyboard::KeyCode;

    /// No display here tells what its keyboard prints before a key is pressed.
    pub(super) fn printed(_: [KeyCode; 2]) -> [Option<String>; 2] {
        [None, None]
    }
}
