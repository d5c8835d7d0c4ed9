//! Any picture file as linear radiance: OpenEXR, PNG, Radiance HDR.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use neumann_core::decode::{DecodeError, bitmap, openexr, radiance_hdr};
use neumann_core::memory::{self, Share};
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

/// Reads a picture; the kind of file is told by its content.
///
/// # Errors
/// If the file cannot be read, is of no known kind, is broken, or does not fit into memory.
pub fn read_image(path: &Path) -> Result<Image, PictureError> {
    read_layer(path, None, &mut Share::default())
}

/// Reads a picture with all layers that its file has.
///
/// # Errors
/// As [`read_image`].
pub fn read_image_with_layers(path: &Path) -> Result<Image, PictureError> {
    let mut start = Vec::new();
    let file = open_regular(path)?;
    let read = file
        .take(openexr::MAGIC.len() as u64)
        .read_to_end(&mut start);
    read.map_err(|e| PictureError::io(path, "read", e))?;
    if start == openexr::MAGIC {
        return exr_file::read_layers(path);
    }
    read_image(path)
}

/// Reads a layer of a picture by its name, or the main one; `memory` pays for it.
///
/// # Errors
/// As [`read_image`], and if there is no such layer; the message lists those that there are.
pub fn read_layer(
    path: &Path,
    name: Option<&str>,
    memory: &mut Share,
) -> Result<Image, PictureError> {
    let failed = |e| PictureError::io(path, "read", e);
    let mut start = Vec::new();
    let mut file = open_regular(path)?;
    let length = file.metadata().map_err(failed)?.len();
    file.by_ref()
        .take(4)
        .read_to_end(&mut start)
        .map_err(failed)?;
    if start == openexr::MAGIC {
        return exr_file::read_layer(path, name, memory);
    }
    if let Some(name) = name.filter(|name| *name != "L") {
        let problem = format!("no layer '{name}'; only OpenEXR files have layers");
        return Err(PictureError::content(path, problem));
    }
    let decoded = Share::of_process(length)
        .and_then(|paid| {
            let n_more = usize::try_from(length).unwrap_or(usize::MAX);
            Ok((paid, memory::empty::<u8>(n_more)?))
        })
        .map_err(DecodeError::from);
    let (_paid, mut bytes) = decoded.map_err(|error| PictureError::decode(path, error))?;
    bytes.extend(start);
    file.take(length.saturating_sub(bytes.len() as u64))
        .read_to_end(&mut bytes)
        .map_err(failed)?;
    let decoded = if radiance_hdr::is_hdr(&bytes) {
        read_hdr(&bytes, memory)
    } else if bitmap::is_bitmap(&bytes) {
        read_bitmap(&bytes, memory)
    } else {
        let problem = "not a picture that can be read".to_owned();
        Err(DecodeError::Content(problem))
    };
    decoded.map_err(|error| PictureError::decode(path, error))
}

fn read_hdr(bytes: &[u8], memory: &mut Share) -> Result<Image, DecodeError> {
    let header = radiance_hdr::header(bytes)?;
    Ok(Image {
        width: header.width,
        height: header.height,
        pixels: radiance_hdr::decode(bytes, memory)?.into_floats(memory)?,
        ..Image::default()
    })
}

/// Colours without their alpha.
fn read_bitmap(bytes: &[u8], memory: &mut Share) -> Result<Image, DecodeError> {
    let header = bitmap::header(bytes)?;
    let _working = Share::of_process(header.n_working_bytes)?;
    let bitmap = bitmap::decode(bytes, Share::of_process(header.n_bytes)?)?;
    let (width, height) = (bitmap.width, bitmap.height);
    memory.grow(memory::bytes_of::<Rgb>(width * height))?;
    let mut pixels = memory::empty(width * height)?;
    for y in 0..height {
        pixels.extend((0..width).map(|x| {
            let [r, g, b, _] = bitmap.texels.rgba(width, x, y);
            Rgb::new(r, g, b).map(linear_from_srgb)
        }));
    }
    Ok(Image {
        width,
        height,
        pixels,
        ..Image::default()
    })
}

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
        assert!(error.contains("cannot be decoded"), "{error}");
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
