//! Pictures on their way to the graphics device: half floats, with a common factor.
//!
//! The factor is a power of two near the picture's mean, so that half floats (6e-8 to 65504) reach
//! five orders of magnitude above it and keep eleven bits everywhere. Buffers are reused from frame
//! to frame.

use half::f16;
use half::slice::HalfFloatSliceExt;
use neumann_core::film::{Film, View};
use neumann_core::radiometry::Rgb;
use neumann_core::render::Thumbnail;

use super::image_area::Placement;

/// Which picture a plane holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// The view of the film.
    Live,
    /// What was held as A.
    HeldA,
    /// What was held as B.
    HeldB,
    /// The reference.
    Reference,
    /// All thumbnails, one below the other: terms, then partial sums.
    Thumbnails,
}

/// Number of [`Slot`]s.
pub(super) const N_SLOTS: usize = 5;

/// One picture.
#[derive(Clone, Debug, Default)]
pub struct Plane {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `pixels[4 * (y * width + x) + channel]`, RGBA, row 0 on top.
    pub pixels: Vec<f16>,
    /// Radiance per stored unit.
    pub scale: f32,
    /// Grows with every change; 0 while empty.
    pub version: u64,
}

/// All pictures that the device may be asked to show.
#[derive(Debug, Default)]
pub struct Planes {
    planes: [Plane; N_SLOTS],
    /// Sums of planes are made here.
    sum: Vec<Rgb>,
}

impl Planes {
    /// The picture in a slot.
    #[must_use]
    pub fn plane(&self, slot: Slot) -> &Plane {
        &self.planes[slot as usize]
    }

    /// Puts a view of the film into a slot; `mean` is about its mean radiance.
    pub fn put_view(&mut self, slot: Slot, film: &Film, view: View, mean: f32) {
        let (width, height) = (film.width(), film.height());
        let plane = &mut self.planes[slot as usize];
        self.sum.resize(width * height, Rgb::BLACK);
        film.compose(view, &mut self.sum);
        plane.fill(width, height, &self.sum, mean);
    }

    /// Puts a picture into a slot; `mean` is about its mean radiance.
    pub fn put_with(&mut self, slot: Slot, size: (usize, usize), pixels: &[Rgb], mean: f32) {
        self.planes[slot as usize].fill(size.0, size.1, pixels, mean);
    }

    /// Puts a picture into a slot.
    pub fn put(&mut self, slot: Slot, width: usize, height: usize, pixels: &[Rgb]) {
        let n = pixels.len().max(1) as f32;
        let mean = pixels.iter().map(|p| p.mean()).sum::<f32>() / n;
        self.put_with(slot, (width, height), pixels, mean);
    }

    /// Puts the thumbnails of terms, and of their partial sums, into their slot.
    pub fn put_thumbnails(&mut self, terms: &[Thumbnail]) {
        let Some(first) = terms.first() else { return };
        let n = first.width * first.height;
        let mut pixels = Vec::with_capacity(2 * terms.len() * n);
        for term in terms {
            pixels.extend_from_slice(&term.pixels);
        }
        let mut sum = vec![Rgb::BLACK; n];
        for term in terms {
            for (s, p) in sum.iter_mut().zip(&term.pixels) {
                *s += *p;
            }
            pixels.extend_from_slice(&sum);
        }
        let mean = mean_of(&sum);
        self.planes[Slot::Thumbnails as usize].fill(
            first.width,
            first.height * 2 * terms.len(),
            &pixels,
            mean,
        );
    }
}

/// Mean radiance of some pixels.
#[must_use]
pub fn mean_of(pixels: &[Rgb]) -> f32 {
    pixels.iter().map(|p| p.mean()).sum::<f32>() / pixels.len().max(1) as f32
}

impl Plane {
    /// The radiance at a share of width and height, of eleven bits.
    #[must_use]
    pub fn radiance(&self, fraction: [f32; 2]) -> Rgb {
        let (x, y) = Placement::pixel(fraction, (self.width, self.height));
        let at = 4 * (y * self.width + x);
        match self.pixels.get(at..at + 3) {
            Some([r, g, b]) => Rgb::new(r.to_f32(), g.to_f32(), b.to_f32()) * self.scale,
            _ => Rgb::BLACK,
        }
    }

    fn fill(&mut self, width: usize, height: usize, pixels: &[Rgb], mean: f32) {
        const CHUNK: usize = 512;
        self.width = width;
        self.height = height;
        self.version += 1;
        self.scale = if mean.is_finite() && mean > 1e-30 {
            mean.log2().round().exp2()
        } else {
            1.0
        };
        self.pixels.resize(4 * pixels.len(), f16::ZERO);
        let factor = 1.0 / self.scale;
        let mut wide = [0f32; 4 * CHUNK];
        for (from, to) in pixels.chunks(CHUNK).zip(self.pixels.chunks_mut(4 * CHUNK)) {
            for (p, w) in from.iter().zip(wide.chunks_exact_mut(4)) {
                w[0] = (p.r * factor).min(LARGEST_HALF);
                w[1] = (p.g * factor).min(LARGEST_HALF);
                w[2] = (p.b * factor).min(LARGEST_HALF);
                w[3] = 1.0;
            }
            to.convert_from_f32_slice(&wide[..to.len()]);
        }
    }
}

const LARGEST_HALF: f32 = 65504.0;

#[cfg(test)]
mod tests {
    use neumann_core::radiometry::Rgb;
    use neumann_core::render::Thumbnail;

    use super::{Planes, Slot};

    #[test]
    fn bright_pictures_keep_their_values() {
        let mut planes = Planes::default();
        planes.put(Slot::HeldA, 2, 1, &[Rgb::splat(3e6), Rgb::splat(1e6)]);
        let plane = planes.plane(Slot::HeldA);
        let value = plane.pixels[4].to_f32() * plane.scale;
        assert!((value / 1e6 - 1.0).abs() < 1e-3, "{value}");
    }

    #[test]
    fn sums_of_thumbnails_follow_the_terms() {
        let thumbnail = |v| Thumbnail {
            width: 1,
            height: 1,
            pixels: vec![Rgb::splat(v)],
        };
        let mut planes = Planes::default();
        planes.put_thumbnails(&[thumbnail(1.0), thumbnail(2.0)]);
        let plane = planes.plane(Slot::Thumbnails);
        let values: Vec<f32> = plane
            .pixels
            .chunks(4)
            .map(|p| p[0].to_f32() * plane.scale)
            .collect();
        assert_eq!(values, [1.0, 2.0, 1.0, 3.0]);
    }
}
