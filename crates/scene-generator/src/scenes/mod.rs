//! The built-in scenes: a file for each kind, a row here for each scene.
//!
//! Metres, +Y up; the camera looks down its -Z. Emission is chosen so that the
//! picture is well exposed at exposure 0. Every surface is exact Lambert unless
//! the scene is about something else.

mod bleed;
mod caustic;
mod cornell;
mod furnace;
mod lamps;
mod many;
mod plates;
mod pool;
mod sky;
mod stress;

use crate::scene::Scene;

/// File name without extension, and the function that builds the scene.
pub(crate) type Row = (&'static str, fn() -> Scene);

/// All of them, in the order of the gallery.
pub(crate) const SCENES: [Row; 10] = [
    ("cornell", cornell::cornell),
    ("cornell-glass", cornell::cornell_glass),
    ("bleed", bleed::bleed),
    ("plates", plates::plates),
    ("lamps", lamps::lamps),
    ("caustic", caustic::caustic),
    ("pool", pool::pool),
    ("furnace", furnace::furnace),
    ("sky", sky::sky),
    ("many", many::many),
];

/// Scenes too big to embed, for measuring.
pub(crate) const STRESS_SCENES: [Row; 2] = [
    ("five-million", stress::five_million),
    ("ten-thousand", stress::ten_thousand),
];
