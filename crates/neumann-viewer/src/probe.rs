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

/// Where readings may stand.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// All of the area.
    pub stage: Rect,
    /// The picture in it.
    pub picture: Rect,
    /// What the caption covers.
    pub caption: Rect,
}

/// How far the plate reaches beyond the text.
const MARGIN: Vec2 = Vec2::new(GRID, 6.0);
/// How far the text keeps off an edge.
const GAP: Vec2 = Vec2::new(2.0 * GRID, 1.5 * GRID);

/// Draws readings in the upper right corner of the stage, or elsewhere, if they would cover the
/// caption or the place `at` that they are of there, or lie across the edge of the picture; the
/// bars of `part` stand out.
pub fn show(ui: &Ui, room: &Room, at: Pos2, reading: &Reading, part: Part) {
    const LINE: f32 = 17.0;
    const BARS: f32 = 40.0;
    let p = Palette::of(ui);
    let painter = ui.painter().with_clip_rect(room.stage);
    let lines = reading.lines.iter().cloned();
    let lines: Vec<_> = lines
        .map(|line| painter.layout_no_wrap(line, theme::small(), p.text))
        .collect();
    let width = lines.iter().map(|l| l.size().x).fold(152.0, f32::max);
    let bars = if reading.bounces.is_empty() {
        0.0
    } else {
        BARS
    };
    let height = lines.len() as f32 * LINE + bars;
    let spot = room.spot(Vec2::new(width, height), at);
    let ground = theme::plate(&p);
    painter.rect_filled(spot.expand2(MARGIN), 6, ground);
    for (i, line) in lines.into_iter().enumerate() {
        let at = pos2(spot.right() - line.size().x, spot.top() + i as f32 * LINE);
        painter.galley(at, line, p.text);
    }
    bounce_bars(&painter, spot, reading, part, &p);
}

impl Room {
    /// Where text of a size stands that tells of the place `at`. It covers neither that nor the
    /// caption, nor lies across the edge of the picture, as far as there is room.
    fn spot(&self, size: Vec2, at: Pos2) -> Rect {
        let spots = self.spots(size);
        let is_off = |spot: &Rect| !spot.expand(3.0 * GRID).contains(at);
        let is_beside_caption = |spot: &Rect| !spot.expand(GRID).intersects(self.caption);
        let is_whole = |spot: &Rect| {
            let plate = spot.expand2(MARGIN);
            self.picture.contains_rect(plate) || !self.picture.intersects(plate)
        };
        // There may be no caption to stand below.
        let is_on_stage = |spot: &&Rect| self.stage.contains_rect(**spot);
        let find = |is_fit: &dyn Fn(&Rect) -> bool| {
            let mut spots = spots.iter().filter(is_on_stage).copied();
            spots.find(is_fit)
        };
        find(&|spot| is_off(spot) && is_beside_caption(spot) && is_whole(spot))
            .or_else(|| find(&|spot| is_off(spot) && is_beside_caption(spot)))
            .or_else(|| find(&is_off))
            .unwrap_or(spots[0])
    }

    /// The places for text of a size, the best one first; a legend may stand in the lower right.
    fn spots(&self, size: Vec2) -> [Rect; 7] {
        let corner = |area: Rect, is_low: bool| {
            let least = area.min + GAP;
            let most = area.max - GAP - size;
            let y = if is_low { most.y } else { least.y };
            Rect::from_min_size(pos2(most.x, y), size)
        };
        let left = |x: f32, y: f32| Rect::from_min_size(pos2(x, y), size);
        let below = self.caption.bottom() + GAP.y;
        let x = self.picture.left() + GAP.x;
        [
            corner(self.stage, false),
            corner(self.picture, false),
            left(self.caption.left() + GRID, below),
            corner(self.stage, true),
            corner(self.picture, true),
            left(x, below.max(self.picture.top() + GAP.y)),
            left(x, self.picture.bottom() - GAP.y - size.y),
        ]
    }
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
    use egui::{Pos2, Rect, Vec2, pos2, vec2};

    use super::{MARGIN, Room};

    const SIZE: Vec2 = vec2(154.0, 90.0);
    /// A place that nothing comes near.
    const FAR: Pos2 = pos2(500.0, 480.0);

    fn rect(x: f32, y: f32, right: f32, bottom: f32) -> Rect {
        Rect::from_min_max(pos2(x, y), pos2(right, bottom))
    }

    fn room(picture: Rect, caption: Rect) -> Room {
        Room {
            stage: rect(0.0, 40.0, 1000.0, 500.0),
            picture,
            caption,
        }
    }

    #[test]
    fn readings_leave_what_they_are_of_alone() {
        let stage = rect(0.0, 40.0, 1000.0, 500.0);
        let room = room(stage, Rect::NOTHING);
        let usual = rect(830.0, 52.0, 984.0, 142.0);
        assert_eq!(room.spot(SIZE, FAR), usual);
        for at in [pos2(900.0, 100.0), pos2(815.0, 60.0), pos2(990.0, 145.0)] {
            let moved = room.spot(SIZE, at);
            assert!(!moved.expand(8.0).contains(at), "{at:?}: {moved:?}");
            assert!(stage.contains_rect(moved) && moved.size() == SIZE);
        }
    }

    #[test]
    fn readings_leave_the_caption_alone() {
        let stage = rect(0.0, 40.0, 1000.0, 500.0);
        let spot = |caption| room(stage, caption).spot(SIZE, FAR);
        assert_eq!(spot(rect(8.0, 46.0, 250.0, 160.0)), spot(Rect::NOTHING));
        let wide = rect(8.0, 46.0, 840.0, 160.0);
        let moved = spot(wide);
        assert!(!moved.intersects(wide) && moved.left() < 20.0, "{moved:?}");
    }

    #[test]
    fn readings_do_not_lie_across_the_edge_of_the_picture() {
        // Pictures of all widths and heights in the middle of the stage.
        for (dx, dy) in (0..99).flat_map(|i| [0.0, 20.0, 60.0].map(|dy| (5.0 * i as f32, dy))) {
            let picture = rect(dx, 40.0 + dy, 1000.0 - dx, 500.0 - dy);
            let caption = rect(8.0, 46.0, 90.0, 90.0);
            let room = room(picture, caption);
            for at in [picture.center(), picture.right_top(), picture.left_top()] {
                let spot = room.spot(SIZE, at);
                let plate = spot.expand2(MARGIN);
                let is_whole = picture.contains_rect(plate) || !picture.intersects(plate);
                assert!(is_whole, "{picture:?} {at:?}: {spot:?}");
                assert!(room.stage.contains_rect(plate), "{picture:?}: {spot:?}");
                assert!(!spot.intersects(caption), "{picture:?}: {spot:?}");
                assert!(
                    !spot.expand(8.0).contains(at),
                    "{picture:?} {at:?}: {spot:?}"
                );
            }
        }
        // What was whole stays where it was.
        let beside = room(rect(200.0, 40.0, 700.0, 500.0), Rect::NOTHING);
        assert_eq!(beside.spot(SIZE, FAR), rect(830.0, 52.0, 984.0, 142.0));
        let across = room(rect(100.0, 40.0, 900.0, 500.0), Rect::NOTHING);
        assert_eq!(across.spot(SIZE, FAR).right(), 884.0, "within the picture");
    }
}
