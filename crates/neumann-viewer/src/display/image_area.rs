//! The picture on its ground: where it stands, and how it is drawn.

use egui::{Painter, Pos2, Rect, Vec2, pos2};

use super::{Draw, MAX_ZOOM, Mode, SharedPlanes, Slot, ViewSettings};

/// Where the film is on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The whole film, points; reaches beyond the area when magnified.
    pub film: Rect,
    /// The part of it within the area.
    pub visible: Rect,
    /// Pixels of the film at full resolution.
    pub size: (usize, usize),
    /// Physical pixels per pixel of the film.
    pub magnification: f32,
}

impl Placement {
    /// Places a film of `size` pixels in `area`.
    #[must_use]
    pub fn new(
        area: Rect,
        pixels_per_point: f32,
        size: (usize, usize),
        settings: &ViewSettings,
    ) -> Self {
        let pixels = Vec2::new(size.0.max(1) as f32, size.1.max(1) as f32);
        let room = area.size() * pixels_per_point;
        let fit = (room.x / pixels.x).min(room.y / pixels.y);
        // A film made for this area may be a fraction of a pixel smaller than it.
        let fit = if (1.0..1.02).contains(&fit) { 1.0 } else { fit };
        let magnification = settings.zoom.unwrap_or(fit);
        let extent = pixels * magnification / pixels_per_point;
        let center = Vec2::from(settings.center);
        let middle = if settings.zoom.is_some() {
            center
        } else {
            Vec2::splat(0.5)
        };
        let corner = area.center() - extent * middle;
        let snap = |v: f32| (v * pixels_per_point).round() / pixels_per_point;
        let film = Rect::from_min_size(pos2(snap(corner.x), snap(corner.y)), extent);
        Self {
            film,
            visible: film.intersect(area),
            size,
            magnification,
        }
    }

    /// Share of width and height of the film at a place on the screen; `None` beside it.
    #[must_use]
    pub fn fraction(&self, at: Pos2) -> Option<[f32; 2]> {
        if !self.visible.contains(at) {
            return None;
        }
        let f = (at - self.film.min) / self.film.size();
        ((0.0..1.0).contains(&f.x) && (0.0..1.0).contains(&f.y)).then_some([f.x, f.y])
    }

    /// The pixel of a film of `size` pixels at a share of its width and height.
    #[must_use]
    pub fn pixel(fraction: [f32; 2], size: (usize, usize)) -> (usize, usize) {
        let at = |f: f32, n: usize| ((f * n as f32) as usize).min(n.saturating_sub(1));
        (at(fraction[0], size.0), at(fraction[1], size.1))
    }
}

/// Draws the picture as the settings ask, as draw call number `index`.
pub fn draw(
    painter: &Painter,
    placement: &Placement,
    settings: &ViewSettings,
    planes: &SharedPlanes,
    pictures: Pictures,
    index: usize,
) {
    let visible = placement.visible;
    if !visible.is_positive() {
        return;
    }
    let origin = (visible.min - placement.film.min) / placement.film.size();
    let part = visible.size() / placement.film.size();
    let mut look = settings.look();
    look.left = [origin.x, origin.y, part.x, part.y];
    look.right = look.left;
    let is_whole = (placement.magnification - placement.magnification.round()).abs() < 1e-3;
    let live_width = planes.lock().plane(Slot::Live).width;
    let is_coarse = live_width < placement.size.0;
    let is_smooth = settings.zoom.is_none() && (is_coarse || !is_whole);
    let mut variant = settings.variant(is_smooth);
    let (left, right) = match pictures {
        Pictures::One(slot) => (slot, slot),
        Pictures::Wipe(left, right) => {
            variant.is_wiping = true;
            look.scale[3] = (settings.wipe - origin.x) / part.x;
            (left, right)
        }
        Pictures::Difference(left, right) => {
            variant.tone = 0;
            variant.mode = Mode::Difference;
            (left, right)
        }
    };
    painter.add(egui_wgpu::Callback::new_paint_callback(
        visible,
        Draw {
            planes: planes.clone(),
            left,
            right,
            look,
            variant,
            index,
        },
    ));
}

/// What stands on the picture's place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pictures {
    /// One picture.
    One(Slot),
    /// Two, with the wipe between them.
    Wipe(Slot, Slot),
    /// One less the other.
    Difference(Slot, Slot),
}

/// Magnifies by a factor of two to the power `steps`, keeping what is at `anchor` (share of width
/// and height) where it is.
pub fn zoom(settings: &mut ViewSettings, placement: &Placement, factor: f32, anchor: [f32; 2]) {
    let old = placement.magnification;
    let new = (old * factor).min(MAX_ZOOM);
    let fit = if settings.zoom.is_none() { old } else { 0.0 };
    let smallest = fit.clamp(0.05, 1.0);
    if new <= smallest && factor < 1.0 {
        settings.zoom = None;
        settings.center = [0.5, 0.5];
        return;
    }
    let from = if settings.zoom.is_some() {
        settings.center
    } else {
        [0.5, 0.5]
    };
    settings.center =
        [0, 1].map(|i| (anchor[i] + (from[i] - anchor[i]) * old / new).clamp(0.0, 1.0));
    settings.zoom = Some(new);
}

#[cfg(test)]
mod tests {
    use egui::{Rect, pos2};

    use super::{Placement, zoom};
    use crate::display::ViewSettings;

    #[test]
    fn magnifying_keeps_the_anchor() {
        let area = Rect::from_min_max(pos2(0.0, 40.0), pos2(800.0, 640.0));
        let mut settings = ViewSettings::default();
        let place = |s: &ViewSettings| Placement::new(area, 1.0, (800, 600), s);
        let at = pos2(200.0, 190.0);
        let before = place(&settings).fraction(at).unwrap();
        assert_eq!(before, [0.25, 0.25]);
        let whole = place(&settings);
        zoom(&mut settings, &whole, 4.0, before);
        let after = place(&settings).fraction(at).unwrap();
        assert!(
            (after[0] - 0.25).abs() < 2e-3 && (after[1] - 0.25).abs() < 2e-3,
            "{after:?}"
        );
    }

    #[test]
    fn every_pixel_is_within_the_film() {
        assert_eq!(Placement::pixel([0.999_999, 0.0], (7, 3)), (6, 0));
    }
}
