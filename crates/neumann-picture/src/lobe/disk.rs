//! The density of directions in false colour, on disks as those of the hemisphere.

use neumann_core::render::lobe::Viewed;

use crate::false_colour::ColourMap;

/// Of the pixels where there is a density, so many may be beyond the end of the colours.
const BEYOND: f64 = 0.01;

/// The density of directions.
#[derive(Clone, Debug)]
pub struct Disk {
    /// Pixels per row, and rows.
    pub size: (usize, usize),
    /// sRGB, row 0 on top; black outside of the disks.
    pub pixels: Vec<[u8; 3]>,
    /// The density that is shown by the last colour, 1/sr; `None` if there is none.
    pub white: Option<f32>,
    /// Directions that were drawn, pixels from the upper left corner.
    pub dots: Vec<[f32; 2]>,
    /// Mirror-like directions, too.
    pub points: Vec<[f32; 2]>,
}

impl Disk {
    /// Of a view.
    #[must_use]
    pub fn new(view: &Viewed) -> Self {
        let map = &view.map;
        let width = map.size().0;
        let mut lit: Vec<f32> = view.density.iter().copied().filter(|d| *d > 0.0).collect();
        lit.sort_by(f32::total_cmp);
        let last = lit.len().saturating_sub(1);
        let index = (last as f64 * (1.0 - BEYOND)).round() as usize;
        let white = lit.get(index).copied();
        let pixel = |(i, density): (usize, &f32)| {
            let place = [(i % width) as f32 + 0.5, (i / width) as f32 + 0.5];
            if map.direction(place).is_none() {
                return [0; 3];
            }
            let share = white.map_or(0.0, |white| density / white);
            ColourMap::default().rgb(share)
        };
        let deltas = view.drawn.deltas.iter();
        Self {
            size: map.size(),
            pixels: view.density.iter().enumerate().map(pixel).collect(),
            white,
            dots: view
                .drawn
                .dots
                .iter()
                .filter_map(|dot| map.place(*dot))
                .collect(),
            points: deltas.filter_map(|lobe| map.place(lobe.wi)).collect(),
        }
    }
}
