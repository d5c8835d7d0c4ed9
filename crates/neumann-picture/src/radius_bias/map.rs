//! Noise and bias of each pixel as colours of one scale.

use super::RadiusBias;
use crate::false_colour::ColourMap;
use crate::quantity::{QuantityLook, QuantityPlane};

/// Pixels to each side that a value of the map is the root mean square of: of a single one, two
/// renders say little.
const REACH: usize = 2;

/// Stops that the colours span.
const STOPS: f32 = 8.0;

/// What is shown of the error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// What chance makes.
    Noise,
    /// What the radius makes.
    Bias,
}

impl Half {
    /// Both, in the order of the maps.
    pub const ALL: [Self; 2] = [Self::Noise, Self::Bias];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Noise => "noise",
            Self::Bias => "radius bias",
        }
    }
}

/// Noise and bias of a part, by its number: root mean squares over 5×5 pixels of the luminance.
#[must_use]
pub fn planes(of: &RadiusBias, view: usize) -> [QuantityPlane; 2] {
    let size = of.cells().size();
    let n = size.0 * size.1;
    let means: Vec<f32> = (0..n).map(|i| of.pixel(view, i)[0].mean as f32).collect();
    Half::ALL.map(|half| {
        let square = |pixel| match half {
            Half::Noise => of.variance(view, pixel),
            Half::Bias => of.square(view, pixel)[0],
        };
        let squares: Vec<f64> = (0..n).map(square).collect();
        let errors = smoothed(&squares, size).into_iter().zip(&means);
        let errors = errors.map(|(square, mean)| [square.max(0.0).sqrt() as f32, *mean]);
        QuantityPlane::of_known_errors(size, errors.collect())
    })
}

/// The look in which all of these planes have the same colours, the largest error the last one.
#[must_use]
pub fn common_look(planes: &[QuantityPlane; 2], map: ColourMap) -> QuantityLook {
    let largest = planes.iter().map(QuantityPlane::largest_error);
    QuantityLook {
        map,
        stops: STOPS,
        exposure_ev: -largest.fold(f32::MIN_POSITIVE, f32::max).log2(),
    }
}

/// Means over squares of pixels, as far as they lie in the picture.
fn smoothed(values: &[f64], (width, height): (usize, usize)) -> Vec<f64> {
    let around = |i: usize, n: usize| i.saturating_sub(REACH)..(i + REACH + 1).min(n);
    let pixels = (0..width * height).map(|pixel| {
        let (columns, rows) = (around(pixel % width, width), around(pixel / width, height));
        let n = (columns.len() * rows.len()) as f64;
        let row = |y: usize| columns.clone().map(move |x| values[y * width + x]);
        rows.flat_map(row).sum::<f64>() / n
    });
    pixels.collect()
}
