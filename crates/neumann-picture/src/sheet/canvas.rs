//! A page of eight-bit pixels: rectangles, pictures, coverage.

use neumann_core::radiometry::Rgb;

use crate::png_file::Pixels8;
use crate::tone::Display;

/// A page.
pub(super) struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

/// A rectangle, pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rect {
    pub(crate) x: usize,
    pub(crate) y: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl Rect {
    /// The same with its edge taken off, one pixel on each side.
    pub(super) fn inner(self) -> Self {
        Self {
            x: self.x + 1,
            y: self.y + 1,
            width: self.width.saturating_sub(2),
            height: self.height.saturating_sub(2),
        }
    }
}

/// A picture to be scaled.
pub(super) struct Thumbnail<'a> {
    pub(super) pixels: &'a [Rgb],
    pub(super) size: (usize, usize),
}

impl Canvas {
    pub(super) fn new(width: usize, height: usize, ground: [u8; 3]) -> Self {
        Self {
            width,
            height,
            pixels: vec![ground; width * height],
        }
    }

    pub(super) fn into_pixels(self) -> Pixels8 {
        Pixels8 {
            width: self.width,
            height: self.height,
            pixels: self.pixels,
        }
    }

    /// Fills a rectangle.
    pub(super) fn fill(&mut self, rect: Rect, colour: [u8; 3]) {
        for y in rect.y..(rect.y + rect.height).min(self.height) {
            let end = (rect.x + rect.width).min(self.width);
            self.pixels[y * self.width + rect.x..y * self.width + end].fill(colour);
        }
    }

    /// Puts pixels on the page as they are, their upper left corner at `(x, y)`; what reaches
    /// beyond it is cut off.
    pub(super) fn paste(&mut self, x: usize, y: usize, source: &Pixels8) {
        let width = source.width.min(self.width.saturating_sub(x));
        if width == 0 {
            return;
        }
        let rows = source.pixels.chunks_exact(source.width);
        for (row, pixels) in rows.take(self.height.saturating_sub(y)).enumerate() {
            let start = (y + row) * self.width + x;
            self.pixels[start..start + width].copy_from_slice(&pixels[..width]);
        }
    }

    /// Draws a picture scaled to a rectangle: radiance is averaged, then shown.
    pub(super) fn picture(&mut self, rect: Rect, source: &Thumbnail<'_>, display: &Display) {
        for y in 0..rect.height {
            let rows = span(y, rect.height, source.size.1);
            for x in 0..rect.width {
                let columns = span(x, rect.width, source.size.0);
                let mut sum = Rgb::BLACK;
                for (row, weight_y) in rows.weights() {
                    for (column, weight_x) in columns.weights() {
                        let value = source.pixels[row * source.size.0 + column];
                        sum += value * (weight_x * weight_y);
                    }
                }
                let at = (rect.y + y) * self.width + rect.x + x;
                self.pixels[at] = display.srgb8(sum);
            }
        }
    }

    /// Draws a straight line with round ends.
    pub(super) fn line(&mut self, ends: [(f32, f32); 2], width: f32, colour: [u8; 3]) {
        self.faint_line(ends, width, colour, 1.0);
    }

    /// The same, of which `opacity` covers what is below.
    pub(super) fn faint_line(
        &mut self,
        [from, to]: [(f32, f32); 2],
        width: f32,
        colour: [u8; 3],
        opacity: f32,
    ) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let squared = (dx * dx + dy * dy).max(f32::MIN_POSITIVE);
        let reach = 0.5 * width + 1.0;
        let bounds = |a: f32, b: f32| {
            let (least, most) = (a.min(b) - reach, a.max(b) + reach);
            least.floor() as i32..=most.ceil() as i32
        };
        for y in bounds(from.1, to.1) {
            for x in bounds(from.0, to.0) {
                let (px, py) = (x as f32 + 0.5 - from.0, y as f32 + 0.5 - from.1);
                let along = ((px * dx + py * dy) / squared).clamp(0.0, 1.0);
                let distance = (px - along * dx).hypot(py - along * dy);
                let coverage = (0.5 * width + 0.5 - distance).clamp(0.0, 1.0);
                self.cover(x, y, opacity * coverage, colour);
            }
        }
    }

    /// Lays a colour over a pixel; outside of the page nothing happens.
    pub(super) fn cover(&mut self, x: i32, y: i32, coverage: f32, colour: [u8; 3]) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else {
            return;
        };
        if x >= self.width || y >= self.height {
            return;
        }
        let pixel = &mut self.pixels[y * self.width + x];
        let coverage = coverage.clamp(0.0, 1.0);
        *pixel = std::array::from_fn(|k| {
            let (under, over) = (f32::from(pixel[k]), f32::from(colour[k]));
            (under + (over - under) * coverage + 0.5) as u8
        });
    }
}

/// The part of a source axis that falls on one target pixel.
struct Span {
    start: f32,
    end: f32,
    n: usize,
}

fn span(target: usize, n_target: usize, n_source: usize) -> Span {
    let scale = n_source as f32 / n_target as f32;
    Span {
        start: target as f32 * scale,
        end: (target + 1) as f32 * scale,
        n: n_source,
    }
}

impl Span {
    /// Source pixels with their weights, which add up to one.
    fn weights(&self) -> impl Iterator<Item = (usize, f32)> {
        let length = self.end - self.start;
        let last = (self.end.ceil() as usize).min(self.n);
        let first = (self.start as usize).min(self.n - 1);
        let (start, end) = (self.start, self.end);
        (first..last.max(first + 1)).map(move |i| {
            let overlap = end.min(i as f32 + 1.0) - start.max(i as f32);
            (i, overlap / length)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::span;

    #[test]
    fn weights_add_up_to_one_whether_shrinking_or_growing() {
        for (n_target, n_source) in [(7, 100), (100, 7), (5, 5), (1, 3)] {
            for target in 0..n_target {
                let sum: f32 = span(target, n_target, n_source)
                    .weights()
                    .map(|w| w.1)
                    .sum();
                assert!(
                    (sum - 1.0).abs() < 1e-3,
                    "{target} of {n_target} from {n_source}: {sum}"
                );
            }
        }
    }
}
