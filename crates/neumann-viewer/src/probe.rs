//! What the pixel under the pointer holds: place, radiance, error, and the radiance of each bounce.

use egui::{Align2, Painter, Rect, Ui, Vec2, pos2};
use neumann_core::film::{Film, View as Part};
use neumann_core::radiometry::Rgb;

use crate::theme::{self, GRID, Palette};
use crate::widgets::significant;

/// The readings of one pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Column and row at full resolution.
    pub pixel: (usize, usize),
    /// Radiance of the part of the series that is shown, W m⁻² sr⁻¹.
    pub radiance: Rgb,
    /// Standard error of L relative to it; `None` before there is one.
    pub relative_error: Option<f32>,
    /// Luminance of each layer, tail last.
    pub bounces: Vec<f32>,
}

impl Reading {
    /// Reads the film at a share of its width and height; `divisor` is that of the ladder.
    #[must_use]
    pub fn new(film: &Film, part: Part, fraction: [f32; 2], divisor: usize) -> Self {
        let size = (film.width(), film.height());
        let (x, y) = crate::display::image_area::Placement::pixel(fraction, size);
        let index = y * size.0 + x;
        let total = film.radiance(Part::Total, index).luminance();
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
            radiance: film.radiance(part, index),
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

/// Draws readings in the upper right corner of `rect`; the bars of `part` stand out.
pub fn show(ui: &Ui, rect: Rect, reading: &Reading, part: Part) {
    const LINE: f32 = 17.0;
    const BARS: f32 = 40.0;
    let p = Palette::of(ui);
    let painter = ui.painter().with_clip_rect(rect);
    let lines: Vec<_> = reading
        .lines()
        .into_iter()
        .map(|line| painter.layout_no_wrap(line, theme::small(), p.text))
        .collect();
    let width = lines.iter().map(|l| l.size().x).fold(152.0, f32::max);
    let corner = pos2(rect.right() - 2.0 * GRID, rect.top() + 1.5 * GRID);
    let height = lines.len() as f32 * LINE + BARS;
    let spot = Rect::from_min_max(
        pos2(corner.x - width, corner.y),
        pos2(corner.x, corner.y + height),
    );
    let ground = theme::plate(&p);
    painter.rect_filled(spot.expand2(Vec2::new(GRID, 6.0)), 6, ground);
    for (i, line) in lines.into_iter().enumerate() {
        let at = pos2(corner.x - line.size().x, corner.y + i as f32 * LINE);
        painter.galley(at, line, p.text);
    }
    bounce_bars(&painter, spot, reading, part, &p);
}

/// Luminance of each bounce at the pixel, as bars under the numbers.
fn bounce_bars(painter: &Painter, spot: Rect, reading: &Reading, part: Part, p: &Palette) {
    let n = reading.bounces.len().max(1);
    let largest = reading.bounces.iter().copied().fold(1e-20, f32::max);
    let area = Rect::from_min_max(
        pos2(spot.left(), spot.bottom() - 34.0),
        spot.max - Vec2::new(0.0, 10.0),
    );
    let pitch = area.width() / n as f32;
    let shown = part.layers(n - 1).unwrap_or(0..0);
    for (k, value) in reading.bounces.iter().enumerate() {
        let height = (value / largest).clamp(0.0, 1.0) * area.height();
        let x = area.left() + k as f32 * pitch;
        let bar = Rect::from_min_max(
            pos2(x + 1.0, area.bottom() - height.max(1.0)),
            pos2(x + pitch - 1.0, area.bottom()),
        );
        let color = if shown.contains(&k) { p.amber } else { p.fill };
        painter.rect_filled(bar, 0, color);
        let name = if k + 1 == n {
            "t".to_owned()
        } else {
            k.to_string()
        };
        let at = pos2(bar.center().x, area.bottom() + 1.0);
        painter.text(at, Align2::CENTER_TOP, name, theme::sized(9.0), p.weak);
    }
}
