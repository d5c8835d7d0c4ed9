//! Sets short lines in Inter, with true subscripts and superscripts.
//!
//! `T^{2}L_{e}` raises the 2 and lowers the e.

use ab_glyph::{Font, FontRef, Glyph, GlyphId, ScaleFont, point};

use super::canvas::Canvas;

/// The typefaces, SIL Open Font License 1.1 (`assets/fonts/OFL.txt`).
static REGULAR: &[u8] = include_bytes!("../../../../assets/fonts/Inter-Regular.otf");
static SEMI_BOLD: &[u8] = include_bytes!("../../../../assets/fonts/Inter-SemiBold.otf");

/// Size of scripts, in sizes of the text around them.
pub(crate) const SCRIPT_SIZE: f32 = 0.68;
/// How far superscripts are raised, in sizes of the text.
const RAISE: f32 = 0.34;
/// How far subscripts are lowered, in sizes of the text.
const LOWER: f32 = 0.16;

/// Weight of a line.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Face {
    Regular,
    SemiBold,
}

/// How a line looks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Style {
    pub(crate) face: Face,
    /// Pixels per em.
    pub(crate) size: f32,
    pub(crate) colour: [u8; 3],
}

/// Which point of a line is given.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Align {
    Left,
    Centre,
    Right,
}

/// The fonts, read.
pub(super) struct Typesetter {
    /// `None` only if the embedded file were broken, which a test rules out.
    regular: Option<FontRef<'static>>,
    semi_bold: Option<FontRef<'static>>,
}

impl Typesetter {
    pub(super) fn new() -> Self {
        Self {
            regular: FontRef::try_from_slice(REGULAR).ok(),
            semi_bold: FontRef::try_from_slice(SEMI_BOLD).ok(),
        }
    }

    /// Width of a line, pixels.
    pub(super) fn width(&self, line: &str, style: &Style) -> f32 {
        self.set(line, style).1
    }

    /// The line, cut with an ellipsis if it is wider than there is room; for plain text.
    pub(super) fn shortened(&self, line: &str, style: &Style, room: f32) -> String {
        if self.width(line, style) <= room {
            return line.to_owned();
        }
        let mut short: Vec<char> = line.chars().collect();
        while !short.is_empty() {
            short.pop();
            let candidate: String = short.iter().chain(&['…']).collect();
            if self.width(&candidate, style) <= room {
                return candidate;
            }
        }
        String::new()
    }

    /// Draws a line with its baseline at `y`.
    pub(super) fn write(
        &self,
        canvas: &mut Canvas,
        line: &str,
        (x, y): (f32, f32),
        align: Align,
        style: &Style,
    ) {
        let Some(font) = self.font(style.face) else {
            return;
        };
        let (glyphs, width) = self.set(line, style);
        let left = match align {
            Align::Left => x,
            Align::Centre => x - width / 2.0,
            Align::Right => x - width,
        };
        for mut glyph in glyphs {
            glyph.position += point(left, y);
            let Some(outline) = font.outline_glyph(glyph) else {
                continue;
            };
            let corner = outline.px_bounds().min;
            outline.draw(|dx, dy, coverage| {
                let (x, y) = (corner.x as i32 + dx as i32, corner.y as i32 + dy as i32);
                canvas.cover(x, y, coverage, style.colour);
            });
        }
    }

    fn font(&self, face: Face) -> Option<&FontRef<'static>> {
        match face {
            Face::Regular => self.regular.as_ref(),
            Face::SemiBold => self.semi_bold.as_ref(),
        }
    }

    /// Glyphs of a line that begins at the origin, and its width.
    fn set(&self, line: &str, style: &Style) -> (Vec<Glyph>, f32) {
        let Some(font) = self.font(style.face) else {
            return (Vec::new(), 0.0);
        };
        // ab_glyph scales by the height of a line; sizes here are per em.
        let per_em = font.height_unscaled() / font.units_per_em().unwrap_or(1000.0);
        let mut glyphs = Vec::new();
        let mut x = 0.0;
        for (text, level) in runs(line) {
            let size = match level {
                Level::Base => style.size,
                _ => style.size * SCRIPT_SIZE,
            };
            let rise = style.size * level.rise();
            let scaled = font.as_scaled(size * per_em);
            let mut before: Option<GlyphId> = None;
            for character in text.chars() {
                let id = scaled.glyph_id(character);
                if let Some(before) = before {
                    x += scaled.kern(before, id);
                }
                glyphs.push(id.with_scale_and_position(size * per_em, point(x, -rise)));
                x += scaled.h_advance(id);
                before = Some(id);
            }
        }
        (glyphs, x)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Level {
    Base,
    Super,
    Sub,
}

impl Level {
    /// How far its baseline is above that of the line, in ems of the line.
    pub(crate) fn rise(self) -> f32 {
        match self {
            Self::Base => 0.0,
            Self::Super => RAISE,
            Self::Sub => -LOWER,
        }
    }
}

/// Splits a line at its scripts.
pub(crate) fn runs(line: &str) -> Vec<(&str, Level)> {
    let mut runs = Vec::new();
    let mut rest = line;
    while !rest.is_empty() {
        let (base, after) = match (rest.find("^{"), rest.find("_{")) {
            (None, None) => (rest, None),
            (a, b) => {
                let at = a.unwrap_or(usize::MAX).min(b.unwrap_or(usize::MAX));
                (&rest[..at], Some(&rest[at..]))
            }
        };
        if !base.is_empty() {
            runs.push((base, Level::Base));
        }
        let Some(script) = after else { break };
        let level = if script.starts_with('^') {
            Level::Super
        } else {
            Level::Sub
        };
        let end = script.find('}').unwrap_or(script.len());
        runs.push((&script[2..end], level));
        rest = script.get(end + 1..).unwrap_or("");
    }
    runs
}

#[cfg(test)]
mod tests {
    use ab_glyph::Font;

    use super::{Face, Level, Style, Typesetter, runs};

    const STYLE: Style = Style {
        face: Face::Regular,
        size: 20.0,
        colour: [255; 3],
    };

    #[test]
    fn the_fonts_hold_every_character_of_the_sheet() {
        let typesetter = Typesetter::new();
        for face in [Face::Regular, Face::SemiBold] {
            let font = typesetter.font(face).expect("embedded font");
            for c in "LTek0123456789+=…Σ≥<.,% ·×()-−µnmkMWsr⁻¹²:".chars() {
                assert_ne!(font.glyph_id(c).0, 0, "{c}");
            }
        }
    }

    #[test]
    fn scripts_are_found() {
        let expected = [
            ("T", Level::Base),
            ("12", Level::Super),
            ("L", Level::Base),
            ("e", Level::Sub),
            (" + …", Level::Base),
        ];
        assert_eq!(runs("T^{12}L_{e} + …"), expected);
        assert_eq!(runs("a^b"), [("a^b", Level::Base)]);
        assert_eq!(runs("x_{"), [("x", Level::Base), ("", Level::Sub)]);
    }

    #[test]
    fn scripts_are_smaller_and_off_the_baseline() {
        let typesetter = Typesetter::new();
        let (glyphs, _) = typesetter.set("e^{e}e_{e}", &STYLE);
        let y: Vec<f32> = glyphs.iter().map(|g| g.position.y).collect();
        assert!(y[1] < y[0] && y[3] > y[2], "{y:?}");
        assert!(glyphs[1].scale.y < glyphs[0].scale.y);
    }

    #[test]
    fn long_lines_are_cut() {
        let typesetter = Typesetter::new();
        let line = "a scene with a name that goes on and on";
        assert_eq!(typesetter.shortened(line, &STYLE, 1e6), line);
        let short = typesetter.shortened(line, &STYLE, 120.0);
        assert!(short.ends_with('…') && typesetter.width(&short, &STYLE) <= 120.0);
        assert!(typesetter.width("LLLL", &STYLE) > typesetter.width("LL", &STYLE));
    }
}
