//! Scores as a picture: noise is grey, bias lights up.
//!
//! A pixel has the colour of the smallest cell around it that is beyond the limit: orange where the
//! first method is brighter, blue where it is darker. Where there is none, it has the grey of its
//! own score. Of single pixels, it has the colour of its own score, where that is beyond theirs.

use super::{Agreement, Term};
use crate::false_colour;
use crate::figures::significant;
use crate::png_file::Pixels8;
use crate::sheet::Scale;

/// Scores of a pixel that are darkest and lightest.
const GREYS: f32 = 4.0;
/// The colour is full at so many limits.
pub const FULL_COLOUR: f32 = 4.0;
/// How much colour a score just beyond the limit has.
const FAINTEST: f32 = 0.6;

/// What has a colour of its own on a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Grain {
    /// The cells, by which two methods are judged.
    #[default]
    Blocks,
    /// Each pixel.
    Pixels,
}

/// The map of a term, as large as the picture.
#[must_use]
pub fn map(agreement: &Agreement, term: &Term, grain: Grain) -> Pixels8 {
    let cells = agreement.cells;
    let (width, height) = cells.size();
    let limit = agreement.limit;
    let beyond = |x: usize, y: usize| {
        cells.around(x, y).find_map(|cell| {
            let score = term.scores[cell]?;
            score.is_beyond(limit).then_some(score.deviations / limit)
        })
    };
    let pixels = (0..width * height).map(|pixel| {
        let limits = match grain {
            Grain::Blocks => beyond(pixel % width, pixel / width),
            Grain::Pixels => (term.is_beyond(pixel, agreement.pixel_limit))
                .then(|| f64::from(term.pixels[pixel]) / agreement.pixel_limit),
        };
        match limits {
            Some(limits) => colour(limits as f32),
            None => grey(term.pixels[pixel] / GREYS),
        }
    });
    Pixels8 {
        width,
        height,
        pixels: pixels.collect(),
    }
}

/// The colour of a score, in limits.
#[must_use]
pub fn colour(limits: f32) -> [u8; 3] {
    if limits.abs() <= 1.0 {
        return grey(limits);
    }
    let over = ((limits.abs() - 1.0) / (FULL_COLOUR - 1.0)).min(1.0);
    false_colour::diverging((FAINTEST + (1.0 - FAINTEST) * over).copysign(limits))
}

/// What the colours mean where the limit is so many standard deviations.
#[must_use]
pub fn scale(limit: f64) -> Scale {
    const N: usize = 65;
    let places = (0..N).map(|i| 2.0 * i as f32 / (N - 1) as f32 - 1.0);
    let marks = [-FULL_COLOUR, -1.0, 0.0, 1.0, FULL_COLOUR].map(|limits| {
        let number = significant(f64::from(limits.abs()) * limit, 2);
        let sign = if limits < 0.0 { "−" } else { "" };
        (0.5 + 0.5 * limits / FULL_COLOUR, format!("{sign}{number}"))
    });
    Scale {
        unit: "deviations".to_owned(),
        colours: places.map(|t| colour(t * FULL_COLOUR)).collect(),
        marks: marks.into(),
    }
}

/// A grey about that of zero.
fn grey(t: f32) -> [u8; 3] {
    const MIDDLE: f32 = 70.0;
    const SPAN: f32 = 30.0;
    let t = if t.is_nan() { 0.0 } else { t.clamp(-1.0, 1.0) };
    [(MIDDLE + SPAN * t + 0.5) as u8; 3]
}

#[cfg(test)]
mod tests {
    use super::{FULL_COLOUR, colour};

    #[test]
    fn noise_has_no_hue_and_bias_has_one_on_either_side() {
        for limits in [-1.0, -0.4, 0.0, 0.9, 1.0] {
            let [r, g, b] = colour(limits);
            assert!(r == g && g == b, "{limits}");
        }
        assert!(colour(-0.5) < colour(0.0) && colour(0.0) < colour(0.5));
        for limits in [1.01, 2.0, FULL_COLOUR, 100.0] {
            let (brighter, darker) = (colour(limits), colour(-limits));
            assert!(brighter[0] > brighter[2] + 50, "orange: {brighter:?}");
            assert!(darker[2] > darker[0] + 50, "blue: {darker:?}");
        }
    }
}
