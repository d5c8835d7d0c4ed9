//! Eight-bit sRGB PNG files.

use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::files::write_atomically;
use crate::tone::Display;
use crate::{Image, PictureError};

/// Eight-bit sRGB pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels8 {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `pixels[y * width + x]`, row 0 on top.
    pub pixels: Vec<[u8; 3]>,
}

impl Pixels8 {
    /// A linear picture as it is shown.
    #[must_use]
    pub fn of(image: &Image, display: &Display) -> Self {
        Self {
            width: image.width,
            height: image.height,
            pixels: image.pixels.iter().map(|p| display.srgb8(*p)).collect(),
        }
    }
}

/// Writes a PNG file.
///
/// # Errors
/// If the place cannot be written to.
pub fn write_png(path: &Path, pixels: &Pixels8) -> Result<(), PictureError> {
    write_atomically(path, |writer| {
        let (width, height) = (u32::try_from(pixels.width)?, u32::try_from(pixels.height)?);
        PngEncoder::new_with_quality(writer, CompressionType::Default, FilterType::Adaptive)
            .write_image(
                pixels.pixels.as_flattened(),
                width,
                height,
                ExtendedColorType::Rgb8,
            )?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::{Pixels8, write_png};
    use crate::files::tests::TestFolder;
    use crate::image_file::read_image;
    use crate::tone::Display;

    #[test]
    fn a_picture_comes_back_code_by_code() {
        let folder = TestFolder::new();
        let path = folder.join("a.png");
        let pixels = Pixels8 {
            width: 16,
            height: 16,
            pixels: (0..=255u8).map(|i| [i, 255 - i, i / 2]).collect(),
        };
        write_png(&path, &pixels).unwrap();
        let back = read_image(&path).unwrap();
        assert_eq!(Pixels8::of(&back, &Display::default()), pixels);
    }
}
