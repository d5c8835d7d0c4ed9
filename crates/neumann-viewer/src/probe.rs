//! What the pixel under the pointer holds: place, radiance, error, and the radiance of each bounce.

use neumann_core::film::{Film, View};
use neumann_core::radiometry::Rgb;

use crate::widgets::significant;

/// The readings of one pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Column and row at full resolution.
    pub pixel: (usize, usize),
    /// Radiance of the view, W m⁻² sr⁻¹.
    pub radiance: Rgb,
    /// Standard error of L relative to it; `None` before there is one.
    pub relative_error: Option<f32>,
    /// Luminance of each layer, tail last.
    pub bounces: Vec<f32>,
}

impl Reading {
    /// Reads the film at a share of its width and height; `divisor` is that of the ladder.
    #[must_use]
    pub fn new(film: &Film, view: View, fraction: [f32; 2], divisor: usize) -> Self {
        let size = (film.width(), film.height());
        let (x, y) = crate::display::image_area::Placement::pixel(fraction, size);
        let index = y * size.0 + x;
        let total = film.radiance(View::Total, index).luminance();
        let variance = film.variance_of_mean(index);
        // Channels are correlated; this takes them as moving together, which is the safe side.
        let weights = Rgb::new(0.2126, 0.7152, 0.0722);
        let deviation = (variance.map(f32::sqrt) * weights)
            .to_array()
            .iter()
            .sum::<f32>();
        let is_known = film.n_iterations() > 1 && total > 0.0;
        Self {
            pixel: (x * divisor, y * divisor),
            radiance: film.radiance(view, index),
            relative_error: is_known.then(|| deviation / total),
            bounces: (0..=film.n_layers())
                .map(|layer| film.layer_at(layer, index).luminance())
                .collect(),
        }
    }

    /// The readings in lines, as they stand on the picture.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let number = |v: f32| significant(f64::from(v), 4);
        let Rgb { r, g, b } = self.radiance;
        let mut lines = vec![
            format!("x {}  y {}", self.pixel.0, self.pixel.1),
            format!("{}  {}  {}", number(r), number(g), number(b)),
        ];
        lines.push(match self.relative_error {
            Some(error) => format!(
                "W m⁻² sr⁻¹  ± {} % of L",
                significant(f64::from(100.0 * error), 2)
            ),
            None => "W m⁻² sr⁻¹".to_owned(),
        });
        lines
    }
}
