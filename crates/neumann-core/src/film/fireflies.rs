//! Pixels that a few rare paths have made far brighter than what is around them.

use super::{Film, View};

/// A pixel may be one if its standard error is at least this share of its luminance: its brightness
/// hangs on few paths.
const UNSETTLED: f32 = 0.25;
/// It stands out if it is so many times as bright as the pixels around it.
const OUTSHINES: f32 = 3.0;
/// Pixels whose surroundings are looked at, for each that is asked for.
const CANDIDATES: usize = 32;

/// A pixel that stands out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Firefly {
    /// Column and row.
    pub pixel: [usize; 2],
    /// Luminance of L, W m⁻² sr⁻¹.
    pub luminance: f32,
    /// The median luminance of the pixels around it.
    pub around: f32,
}

impl Film {
    /// The pixels that stand out most, at most `n`, and that further paths may well take back: the
    /// brightest above the median of their neighbours first.
    ///
    /// By [`Replay`](crate::render::Renderer::replay) their paths are known; nothing is kept of
    /// them while rendering.
    #[must_use]
    pub fn fireflies(&self, n: usize) -> Vec<Firefly> {
        let luminance = |index: usize| self.radiance(View::Total, index).luminance();
        let mut candidates: Vec<(usize, f32)> = (0..self.n_pixels())
            .map(|index| (index, luminance(index)))
            .filter(|(index, l)| *l > 0.0 && self.luminance_error(*index) >= UNSETTLED * l)
            .collect();
        candidates.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        candidates.truncate(CANDIDATES * n);
        let (width, height) = (self.width(), self.height());
        let mut found: Vec<Firefly> = candidates
            .into_iter()
            .map(|(index, of_pixel)| {
                let (x, y) = (index % width, index / width);
                let rows = y.saturating_sub(1)..(y + 2).min(height);
                let columns = x.saturating_sub(1)..(x + 2).min(width);
                let near = rows.flat_map(|y| columns.clone().map(move |x| y * width + x));
                let mut near: Vec<f32> = near.filter(|i| *i != index).map(luminance).collect();
                near.sort_by(f32::total_cmp);
                Firefly {
                    pixel: [x, y],
                    luminance: of_pixel,
                    around: near.get(near.len() / 2).copied().unwrap_or(0.0),
                }
            })
            .filter(|firefly| firefly.luminance > OUTSHINES * firefly.around)
            .collect();
        let excess = |firefly: &Firefly| firefly.luminance - firefly.around;
        found.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
        found.truncate(n);
        found
    }
}

#[cfg(test)]
mod tests {
    use super::Film;
    use crate::radiometry::Rgb;

    /// A grey film of 9 × 7 pixels over 16 iterations with some pixels of other brightness, and
    /// those of which the error is large.
    fn film(bright: &[([usize; 2], f32)], unsettled: &[[usize; 2]]) -> Film {
        let at = |pixel: &[usize; 2]| pixel[1] * 9 + pixel[0];
        let mut total = vec![Rgb::splat(1.0); 63];
        for (pixel, luminance) in bright {
            total[at(pixel)] = Rgb::splat(*luminance);
        }
        let mut variance = vec![Rgb::splat(1e-6); 63];
        for pixel in unsettled {
            variance[at(pixel)] = Rgb::splat(0.5 * total[at(pixel)].r.powi(2));
        }
        let layers = vec![total.clone(), vec![Rgb::BLACK; 63]];
        Film::from_parts((9, 7), 16, layers, total, &variance, 0).unwrap()
    }

    #[test]
    fn what_stands_out_and_is_not_settled_is_found() {
        let bright = [([4, 3], 50.0), ([0, 0], 9.0), ([7, 5], 70.0), ([2, 5], 2.0)];
        let film = film(&bright, &[[4, 3], [0, 0], [2, 5], [8, 1]]);
        let pixels: Vec<_> = film.fireflies(5).iter().map(|f| f.pixel).collect();
        // One is as bright as it should be, one hardly brighter than the others.
        assert_eq!(pixels, [[4, 3], [0, 0]]);
        assert_eq!(film.fireflies(1).len(), 1);
        assert_eq!(film.fireflies(1)[0].around, 1.0);
    }

    /// The edge of a lamp is bright, too, but not alone.
    #[test]
    fn edges_are_none() {
        let bright: Vec<_> = (0..7)
            .flat_map(|y| (5..9).map(move |x| ([x, y], 40.0)))
            .collect();
        let edge: Vec<_> = (0..7).map(|y| [5, y]).collect();
        assert_eq!(film(&bright, &edge).fireflies(9), []);
    }
}
