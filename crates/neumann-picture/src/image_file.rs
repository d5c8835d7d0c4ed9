//! Any picture file as linear radiance: OpenEXR, PNG, Radiance HDR.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use image::{ImageReader, Limits};
use neumann_core::radiometry::Rgb;

use crate::tone::linear_from_srgb;
use crate::{PictureError, exr_file};

/// A linear picture, with whatever named layers its file has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `pixels[y * width + x]`, row 0 on top; Rec. 709.
    pub pixels: Vec<Rgb>,
    /// Further pictures of the same size by name, such as `T0` or `albedo`.
    pub layers: BTreeMap<String, Vec<Rgb>>,
}

impl Image {
    /// The picture, or one of its layers, alone.
    ///
    /// # Errors
    /// If there is no such layer; the message lists those that there are.
    pub fn layer(&self, name: Option<&str>) -> Result<Self, PictureError> {
        let pixels = match name {
            None | Some("L") => &self.pixels,
            Some(name) => self.layers.get(name).ok_or_else(|| {
                let names: Vec<_> = self.layers.keys().map(String::as_str).collect();
                let known = if names.is_empty() {
                    "there are none".to_owned()
                } else {
                    format!("there are L, {}", names.join(", "))
                };
                PictureError::Mismatch(format!("no layer '{name}'; {known}"))
            })?,
        };
        Ok(Self {
            width: self.width,
            height: self.height,
            pixels: pixels.clone(),
            layers: BTreeMap::new(),
        })
    }
}

/// Reads a picture; the kind of file is told by its content.
///
/// # Errors
/// If the file cannot be read, is of no known kind, or is broken.
pub fn read_image(path: &Path) -> Result<Image, PictureError> {
    let mut start = [0; 4];
    let mut file = open_regular(path)?;
    let n = file
        .read(&mut start)
        .map_err(|e| PictureError::io(path, "read", e))?;
    if n == 4 && start == EXR_MAGIC {
        return exr_file::read_layers(path);
    }
    let file = open_regular(path)?;
    let mut reader = ImageReader::new(BufReader::new(file))
        .with_guessed_format()
        .map_err(|e| PictureError::io(path, "read", e))?;
    if reader.format().is_none() {
        return Err(PictureError::content(
            path,
            "not a picture that can be read; use .exr, .png or .hdr",
        ));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_EDGE);
    limits.max_image_height = Some(MAX_EDGE);
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    let is_linear = reader.format() == Some(image::ImageFormat::Hdr);
    let decoded = reader
        .decode()
        .map_err(|e| PictureError::content(path, format!("broken picture: {e}")))?;
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    let is_deep = decoded.color().bytes_per_pixel() / decoded.color().channel_count() > 1;
    let pixels = if is_linear {
        let to_rgb = |p: &image::Rgb<f32>| Rgb::from(p.0);
        decoded.into_rgb32f().pixels().map(to_rgb).collect()
    } else if is_deep {
        let to_rgb =
            |p: &image::Rgb<u16>| Rgb::from(p.0.map(|c| linear_from_srgb(f32::from(c) / 65535.0)));
        decoded.into_rgb16().pixels().map(to_rgb).collect()
    } else {
        let table: Vec<f32> = (0..=255u8)
            .map(|c| linear_from_srgb(f32::from(c) / 255.0))
            .collect();
        let to_rgb = |p: &image::Rgb<u8>| Rgb::from(p.0.map(|c| table[usize::from(c)]));
        decoded.into_rgb8().pixels().map(to_rgb).collect()
    };
    Ok(Image {
        width,
        height,
        pixels,
        layers: BTreeMap::new(),
    })
}

/// The first bytes of every OpenEXR file.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Pixels along an edge of a picture that is not OpenEXR.
const MAX_EDGE: u32 = 65_535;
/// Memory that reading such a picture may take.
const MAX_BYTES: u64 = 4 << 30;

/// Opens a file for reading if it is an ordinary one: a pipe could hang, a folder is no picture.
pub(crate) fn open_regular(path: &Path) -> Result<File, PictureError> {
    let metadata = std::fs::metadata(path).map_err(|e| PictureError::io(path, "read", e))?;
    if !metadata.is_file() {
        return Err(PictureError::content(
            path,
            "not an ordinary file; name a picture file",
        ));
    }
    File::open(path).map_err(|e| PictureError::io(path, "read", e))
}

#[cfg(test)]
mod tests {
    use super::read_image;
    use crate::files::tests::TestFolder;

    #[test]
    fn what_is_no_picture_is_refused_with_its_name() {
        let folder = TestFolder::new();
        let path = folder.join("a.png");
        let error = read_image(&path).unwrap_err().to_string();
        assert!(
            error.contains("a.png") && error.contains("check the path"),
            "{error}"
        );
        std::fs::write(&path, b"no picture at all").unwrap();
        let error = read_image(&path).unwrap_err().to_string();
        assert!(error.contains("not a picture"), "{error}");
        std::fs::write(&path, b"\x89PNG\r\n\x1a\nrubbish").unwrap();
        let error = read_image(&path).unwrap_err().to_string();
        assert!(error.contains("broken"), "{error}");
        assert!(read_image(&folder.join("")).is_err());
    }

    #[test]
    fn a_radiance_file_is_linear() {
        let folder = TestFolder::new();
        let path = folder.join("a.hdr");
        let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
        // 128/256 * 2^(129-128) = 1 in red, 4 in blue of the second pixel.
        bytes.extend([128, 0, 0, 129, 0, 0, 128, 131]);
        std::fs::write(&path, bytes).unwrap();
        let image = read_image(&path).unwrap();
        assert_eq!((image.width, image.height), (2, 1));
        assert!((image.pixels[0].r - 1.0).abs() < 0.02, "{:?}", image.pixels);
        assert!((image.pixels[1].b - 4.0).abs() < 0.05, "{:?}", image.pixels);
    }
}
