//! How far two pictures are apart.
//!
//! With a the picture and b the reference, over N pixels and three channels:
//!
//! - `RMSE = sqrt(mean((a − b)²))`, in units of radiance;
//! - `relMSE = mean((a − b)² / (b² + 0.01))`, which counts dark regions too;
//! - `mean ratio = mean(a) / mean(b)` in each channel: 1 for an unbiased estimate;
//! - FLIP, what an eye would see on a screen after tone mapping ([`flip`]).
//!
//! Pixels that are not finite in one of the two are counted and left out of the
//! first three; FLIP takes them as black.

mod flip;

use neumann_core::memory;
use neumann_core::radiometry::Rgb;

pub use flip::flip;

use crate::png_file::Pixels8;
use crate::tone::Display;
use crate::{Image, PictureError, false_colour};

/// How far two pictures are apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Root mean square error.
    pub rmse: f64,
    /// Mean relative square error.
    pub rel_mse: f64,
    /// Mean FLIP error in [0, 1], at 67 pixels per degree.
    pub flip: f64,
    /// Mean of the picture over mean of the reference, red, green, blue; NaN where both
    /// are black, infinite where the reference alone is.
    pub mean_ratio: [f64; 3],
    /// Mean of the picture.
    pub mean: [f64; 3],
    /// Mean of the reference.
    pub mean_reference: [f64; 3],
    /// The largest difference of a channel.
    pub largest_difference: f64,
    /// Pixels left out because they are not finite in one of the two.
    pub n_skipped: usize,
}

/// Compares a picture with a reference; `display` says how both would be shown, for FLIP.
///
/// # Errors
/// If their sizes differ.
pub fn compare(
    image: &Image,
    reference: &Image,
    display: &Display,
) -> Result<Comparison, PictureError> {
    if (image.width, image.height) != (reference.width, reference.height) {
        return Err(PictureError::Mismatch(format!(
            "pictures of different size: {}x{} and {}x{}; render both with the same --size",
            image.width, image.height, reference.width, reference.height
        )));
    }
    let mut sums = Sums::default();
    for (a, b) in image.pixels.iter().zip(&reference.pixels) {
        sums.add(*a, *b);
    }
    let n = sums.n_pixels.max(1) as f64;
    let mean = sums.image.map(|s| s / n);
    let mean_reference = sums.reference.map(|s| s / n);
    Ok(Comparison {
        rmse: (sums.squares / (3.0 * n)).sqrt(),
        rel_mse: sums.relative_squares / (3.0 * n),
        flip: mean_of(&flip(image, reference, display)),
        mean_ratio: std::array::from_fn(|k| mean[k] / mean_reference[k]),
        mean,
        mean_reference,
        largest_difference: sums.largest_difference,
        n_skipped: image.pixels.len() - sums.n_pixels,
    })
}

/// Memory that [`compare`] takes for so many pixels: lightness, colours and edges of both pictures,
/// and filtered planes.
#[must_use]
pub fn working_bytes(n_pixels: usize) -> u64 {
    const PER_PIXEL: usize = 84;
    memory::bytes_of::<[u8; PER_PIXEL]>(n_pixels)
}

/// The signed difference of luminance as a picture: orange where `image` is brighter than
/// the reference, blue where it is darker, grey where they agree.
///
/// Full colour stands for the 99th percentile of the differences; it is returned as well.
#[must_use]
pub fn difference_picture(image: &Image, reference: &Image) -> (Pixels8, f32) {
    let differences: Vec<f32> = image
        .pixels
        .iter()
        .zip(&reference.pixels)
        .map(|(a, b)| (*a - *b).luminance())
        .collect();
    let mut magnitudes: Vec<f32> = differences
        .iter()
        .map(|d| d.abs())
        .filter(|d| d.is_finite() && *d > 0.0)
        .collect();
    magnitudes.sort_unstable_by(f32::total_cmp);
    let scale = magnitudes
        .get((magnitudes.len() * 99 / 100).min(magnitudes.len().saturating_sub(1)))
        .copied()
        .unwrap_or(1.0);
    let picture = Pixels8 {
        width: image.width,
        height: image.height,
        pixels: differences
            .iter()
            .map(|d| false_colour::diverging(d / scale))
            .collect(),
    };
    (picture, scale)
}

#[derive(Default)]
struct Sums {
    n_pixels: usize,
    squares: f64,
    relative_squares: f64,
    image: [f64; 3],
    reference: [f64; 3],
    largest_difference: f64,
}

impl Sums {
    fn add(&mut self, a: Rgb, b: Rgb) {
        let (a, b) = (a.to_array().map(f64::from), b.to_array().map(f64::from));
        if !a.iter().chain(&b).all(|v| v.is_finite()) {
            return;
        }
        self.n_pixels += 1;
        for k in 0..3 {
            let square = (a[k] - b[k]).powi(2);
            self.squares += square;
            self.relative_squares += square / (b[k] * b[k] + 1e-2);
            self.image[k] += a[k];
            self.reference[k] += b[k];
            self.largest_difference = self.largest_difference.max((a[k] - b[k]).abs());
        }
    }
}

fn mean_of(errors: &[f32]) -> f64 {
    let sum: f64 = errors.iter().map(|e| f64::from(*e)).sum();
    sum / errors.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use neumann_core::radiometry::Rgb;

    use super::{compare, difference_picture};
    use crate::Image;
    use crate::tone::Display;

    fn image(pixels: &[Rgb]) -> Image {
        Image {
            width: pixels.len(),
            height: 1,
            pixels: pixels.to_vec(),
            ..Image::default()
        }
    }

    #[test]
    fn a_picture_is_no_distance_from_itself() {
        let a = image(&[Rgb::new(0.2, 0.5, 3.0), Rgb::WHITE]);
        let c = compare(&a, &a, &Display::default()).unwrap();
        assert_eq!((c.rmse, c.rel_mse, c.flip), (0.0, 0.0, 0.0));
        assert_eq!(c.mean_ratio, [1.0; 3]);
    }

    #[test]
    fn errors_follow_their_formulas() {
        let a = image(&[Rgb::new(1.0, 0.0, 0.0), Rgb::BLACK]);
        let b = image(&[Rgb::new(0.5, 0.0, 0.0), Rgb::new(0.5, 2.0, 0.0)]);
        let c = compare(&a, &b, &Display::default()).unwrap();
        let squares = 0.25 + 0.25 + 4.0;
        assert!((c.rmse - (squares / 6.0f64).sqrt()).abs() < 1e-12);
        let relative = 0.25 / 0.26 + 0.25 / 0.26 + 4.0 / 4.01;
        assert!((c.rel_mse - relative / 6.0).abs() < 1e-12);
        assert_eq!(c.mean_ratio[..2], [1.0, 0.0]);
        assert!(c.mean_ratio[2].is_nan());
        assert_eq!(c.largest_difference, 2.0);
    }

    #[test]
    fn what_is_not_finite_is_counted_and_left_out() {
        let a = image(&[Rgb::WHITE, Rgb::splat(f32::NAN)]);
        let b = image(&[Rgb::WHITE, Rgb::WHITE]);
        let c = compare(&a, &b, &Display::default()).unwrap();
        assert_eq!((c.n_skipped, c.rmse), (1, 0.0));
        assert!(c.flip > 0.1, "shown as black: {}", c.flip);
    }

    #[test]
    fn sizes_must_agree() {
        let (a, b) = (image(&[Rgb::WHITE]), image(&[Rgb::WHITE; 2]));
        let error = compare(&a, &b, &Display::default()).unwrap_err();
        assert!(error.to_string().contains("1x1 and 2x1"), "{error}");
    }

    #[test]
    fn the_picture_of_the_difference_shows_its_sign() {
        let a = image(&[Rgb::splat(2.0), Rgb::WHITE, Rgb::BLACK]);
        let b = image(&[Rgb::WHITE; 3]);
        let (picture, scale) = difference_picture(&a, &b);
        assert!((scale - 1.0).abs() < 1e-6);
        let [more, same, less] = picture.pixels[..] else {
            panic!("three pixels")
        };
        assert!(more[0] > more[2] && less[2] > less[0]);
        assert!(same[0] == same[1] && same[1] == same[2]);
    }
}
