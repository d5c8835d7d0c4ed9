//! What the pixel under the pointer holds, in words, and bounce by bounce as bars.

use egui::{Align2, Painter, Pos2, Rect, Ui, Vec2, pos2};
use neumann_core::film::{Film, View as Part};
use neumann_core::radiometry::Rgb;

use crate::theme::{self, GRID, Palette};
use crate::widgets::significant;

/// The readings of one pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// What it holds in words, its place first.
    pub lines: Vec<String>,
    /// What each bounce has of it, tail last: luminance, or a number of photons. Empty where that
    /// is not known.
    pub bounces: Vec<f32>,
}

impl Reading {
    /// What there is to say of a place outside the region that is rendered.
    #[must_use]
    pub fn outside_region(place: String) -> Self {
        Self {
            lines: vec![place, "outside the region".to_owned()],
            bounces: Vec::new(),
        }
    }

    /// Reads the film at a share of its width and height; `divisor` is that of the ladder.
    #[must_use]
    pub fn of_film(film: &Film, part: Part, fraction: [f32; 2], divisor: usize) -> Self {
        let size = (film.width(), film.height());
        let (x, y) = crate::display::image_area::Placement::pixel(fraction, size);
        let index = y * size.0 + x;
        let total = film.radiance(Part::Total, index).luminance();
        let deviation = film.luminance_error(index);
        let is_known = film.n_iterations() > 1 && total > 0.0;
        let number = |v: f32| significant(f64::from(v), 4);
        let Rgb { r, g, b } = film.radiance(part, index);
        let place = format!("x {}  y {}", x * divisor, y * divisor);
        let radiance = format!("{}  {}  {}", number(r), number(g), number(b));
        let error = if is_known {
            let error = f64::from(100.0 * deviation / total);
            format!("W m⁻² sr⁻¹  ± {} % of L", significant(error, 2))
        } else {
            "W m⁻² sr⁻¹".to_owned()
        };
        Self {
            lines: vec![place, radiance, error],
            bounces: (0..=film.n_layers())
                .map(|layer| film.layer_at(layer, index).luminance())
                .collect(),
        }
    }
}

/// Draws readings in the upper right corner of `rect`, or below the caption where they would cover
/// that, or in the lower right corner where they would cover the place `at` that they are of; the
/// bars of `part` stand out.
pub fn show(ui: &Ui, [rect, caption]: [Rect; 2], at: Pos2, reading: &Reading, part: Part) {
    const LINE: f32 = 17.0;
    const BARS: f32 = 40.0;
    let p = Palette::of(ui);
    let painter = ui.painter().with_clip_rect(rect);
    let lines = reading.lines.iter().cloned();
    let lines: Vec<_> = lines
        .map(|line| painter.layout_no_wrap(line, theme::small(), p.text))
        .collect();
    let width = lines.iter().map(|l| l.size().x).fold(152.0, f32::max);
    let corner = pos2(rect.right() - 2.0 * GRID, rect.top() + 1.5 * GRID);
    let bars = if reading.bounces.is_empty() {
        0.0
    } else {
        BARS
    };
    let height = lines.len() as f32 * LINE + bars;
    let spot = Rect::from_min_max(
        pos2(corner.x - width, corner.y),
        pos2(corner.x, corner.y + height),
    );
    let spot = away_from(at, beside(spot, caption), rect);
    let ground = theme::plate(&p);
    painter.rect_filled(spot.expand2(Vec2::new(GRID, 6.0)), 6, ground);
    for (i, line) in lines.into_iter().enumerate() {
        let at = pos2(spot.right() - line.size().x, spot.top() + i as f32 * LINE);
        painter.galley(at, line, p.text);
    }
    bounce_bars(&painter, spot, reading, part, &p);
}

/// The place for what would stand at `spot`: below the caption if it would cover that.
fn beside(spot: Rect, caption: Rect) -> Rect {
    if !spot.expand(GRID).intersects(caption) {
        return spot;
    }
    let corner = pos2(caption.left() + GRID, caption.bottom() + 1.5 * GRID);
    Rect::from_min_size(corner, spot.size())
}

/// The place for what would stand at `spot`: in the lower right corner of `rect` if it would cover
/// a point or come near it.
fn away_from(at: Pos2, spot: Rect, rect: Rect) -> Rect {
    if !spot.expand(3.0 * GRID).contains(at) {
        return spot;
    }
    let corner = rect.max - Vec2::new(2.0 * GRID, 1.5 * GRID);
    Rect::from_min_size(corner - spot.size(), spot.size())
}

/// What each bounce has of the pixel, as bars under the numbers.
fn bounce_bars(painter: &Painter, spot: Rect, reading: &Reading, part: Part, p: &Palette) {
    if reading.bounces.is_empty() {
        return;
    }
    let n = reading.bounces.len();
    let largest = reading.bounces.iter().copied().fold(1e-20, f32::max);
    let area = Rect::from_min_max(
        pos2(spot.left(), spot.bottom() - 34.0),
        spot.max - Vec2::new(0.0, 10.0),
    );
    let pitch = area.width() / n as f32;
    // Where bars are narrow, every second one is named, or every fourth.
    let step = (12.0 / pitch).ceil().max(1.0) as usize;
    let step = step.next_power_of_two();
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
        } else if k % step == 0 && k + step < n {
            k.to_string()
        } else {
            continue;
        };
        let at = pos2(bar.center().x, area.bottom() + 1.0);
        painter.text(at, Align2::CENTER_TOP, name, theme::sized(9.0), p.weak);
    }
}

#[cfg(test)]
mod tests {
    use egui::{Rect, pos2};

    use super::{away_from, beside};

    #[test]
    fn readings_leave_what_they_are_of_alone() {
        let rect = Rect::from_min_max(pos2(0.0, 40.0), pos2(1000.0, 500.0));
        let spot = Rect::from_min_max(pos2(830.0, 52.0), pos2(984.0, 140.0));
        assert_eq!(away_from(pos2(500.0, 300.0), spot, rect), spot);
        for at in [pos2(900.0, 100.0), pos2(815.0, 60.0), pos2(990.0, 145.0)] {
            let moved = away_from(at, spot, rect);
            assert!(!moved.expand(8.0).contains(at), "{at:?}: {moved:?}");
            assert!(rect.contains_rect(moved) && moved.size() == spot.size());
        }
    }

    #[test]
    fn readings_leave_the_caption_alone() {
        let rect = |x: f32, y: f32, right: f32, bottom: f32| {
            Rect::from_min_max(pos2(x, y), pos2(right, bottom))
        };
        let caption = rect(8.0, 46.0, 250.0, 160.0);
        let apart = rect(750.0, 50.0, 990.0, 180.0);
        assert_eq!(beside(apart, caption), apart);
        assert_eq!(beside(apart, Rect::NOTHING), apart);
        let moved = beside(rect(130.0, 50.0, 380.0, 180.0), caption);
        assert!(
            !moved.intersects(caption) && moved.left() < 20.0,
            "{moved:?}"
        );
    }
}
