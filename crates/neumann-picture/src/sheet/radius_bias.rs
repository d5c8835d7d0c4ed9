//! Noise and the bias of a radius side by side, in colours of one scale.

use super::agreement::scaled;
use super::{PictureSheet, UNIT, Wipe, picture_sheet};
use crate::false_colour::ColourMap;
use crate::png_file::Pixels8;
use crate::quantity::QuantityPlane;
use crate::radius_bias::{Half, common_look};

/// What is laid out.
#[derive(Clone, Debug)]
pub struct RadiusBiasSheet<'a> {
    /// A name, such as that of the scene, and a line on how the maps were made.
    pub heading: [String; 2],
    /// Noise, and bias.
    pub planes: &'a [QuantityPlane; 2],
    /// The colours of numbers.
    pub map: ColourMap,
    /// What follows, a line each.
    pub lines: Vec<String>,
}

/// A map is at least so many pixels wide or high.
const LEAST: usize = 48 * UNIT;

/// Lays out both maps.
#[must_use]
pub fn radius_bias_sheet(sheet: &RadiusBiasSheet<'_>) -> Pixels8 {
    let look = common_look(sheet.planes, sheet.map);
    let (width, height) = sheet.planes[0].size;
    let by = LEAST.div_ceil(width.max(height).max(1)).max(1);
    let (width, height) = (by * width, by * height);
    let maps = sheet.planes.each_ref().map(|plane| {
        let map = plane.pixels(&look);
        scaled(&map, width, height).pixels
    });
    let pixels = (0..2 * width * height).map(|i| {
        let (x, y) = (i % (2 * width), i / (2 * width));
        maps[x / width][y * width + x % width]
    });
    picture_sheet(&PictureSheet {
        heading: sheet.heading.clone(),
        picture: Pixels8 {
            width: 2 * width,
            height,
            pixels: pixels.collect(),
        },
        wipe: Some(Wipe {
            place: 0.5,
            names: Half::ALL.map(|half| half.name().to_owned()),
        }),
        strokes: Vec::new(),
        scale: Some(sheet.planes[0].scale(&look)),
        lines: sheet.lines.clone(),
    })
}
