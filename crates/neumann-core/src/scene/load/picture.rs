//! Images of textures: PNG, JPEG and WebP, decoded in parallel.
//!
//! Only images that a used material refers to are fetched and decoded. A
//! missing or broken image costs its textures and a warning, not the scene.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

use super::File;
use super::error::{Fault, quoted};
use super::material;
use super::notes::Notes;
use super::source::{Bytes, Source};
use crate::scene::description::{ImageDescription, MaterialDescription};

/// Wider or higher images are refused.
pub(super) const LARGEST_SIDE: u32 = 16384;

/// One image may take this much while it is decoded.
const LARGEST_IMAGE: u64 = 1 << 30;

/// All images of a scene may take this much once decoded.
const LARGEST_TOTAL: u64 = 4 << 30;

/// Bytes of an image that wait to be decoded.
enum Encoded<'a> {
    Fetched(Bytes),
    View(&'a [u8]),
}

/// Decodes the images of the used materials and lets their textures refer to
/// them; other materials lose their textures.
pub(super) fn read(
    file: &File<'_>,
    source: &mut Source<'_>,
    materials: &mut [MaterialDescription],
    is_used: &[bool],
    notes: &mut Notes,
) -> Vec<ImageDescription> {
    let mut wanted = Vec::new();
    for (material, &is_used) in materials.iter_mut().zip(is_used) {
        for texture in material::textures(material) {
            match texture {
                Some(texture) if is_used => wanted.push(texture.image),
                _ => *texture = None,
            }
        }
    }
    wanted.sort_unstable();
    wanted.dedup();

    // Fetching is sequential, for the sake of the hash.
    let mut left = LARGEST_TOTAL;
    let mut encoded = Vec::with_capacity(wanted.len());
    for &index in &wanted {
        let fetched = fetch(file, source, index).and_then(|(name, bytes)| {
            let problem = |problem: String| Fault::broken(format!("images[{index}]"), problem);
            let (width, height) = dimensions(&bytes).map_err(problem)?;
            left = left
                .checked_sub(4 * u64::from(width) * u64::from(height))
                .ok_or_else(|| {
                    problem(format!(
                        "is {width} by {height}, and the images together pass {LARGEST_TOTAL} bytes"
                    ))
                })?;
            Ok((name, bytes))
        });
        encoded.push(fetched);
    }
    let decoded: Vec<Result<ImageDescription, Fault>> = encoded
        .into_par_iter()
        .zip(&wanted)
        .map(|(encoded, index)| {
            let (name, bytes) = encoded?;
            decode(&name, &bytes)
                .map_err(|problem| Fault::broken(format!("images[{index}]"), problem))
        })
        .collect();

    let mut images = Vec::new();
    let mut image_from_file_index = BTreeMap::new();
    for (index, result) in wanted.into_iter().zip(decoded) {
        match result {
            Ok(image) => {
                image_from_file_index.insert(index, images.len());
                images.push(image);
            }
            Err(fault) => notes.warn(format!(
                "image {}: {}; its textures are left out",
                quoted(&image_name(file, index)),
                fault.what()
            )),
        }
    }
    for texture in materials.iter_mut().flat_map(material::textures) {
        *texture = texture.and_then(|mut found| {
            found.image = *image_from_file_index.get(&found.image)?;
            Some(found)
        });
    }
    images
}

impl std::ops::Deref for Encoded<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Fetched(bytes) => bytes,
            Self::View(bytes) => bytes,
        }
    }
}

/// The bytes of an image of the file, from a URI or a buffer, and its name.
fn fetch<'a>(
    file: &'a File<'_>,
    source: &mut Source<'_>,
    index: usize,
) -> Result<(String, Encoded<'a>), Fault> {
    let item = file.document.item("images", index)?;
    let encoded = match item.text("uri")? {
        Some(uri) => Encoded::Fetched(source.fetch(uri, &item.path("uri"))?),
        None => match file.buffers.view(&file.document, &item)? {
            Some(view) => Encoded::View(view.bytes),
            None => return Err(Fault::broken(item.at(), "has neither uri nor bufferView")),
        },
    };
    Ok((image_name(file, index), encoded))
}

/// Name, else URI, else number.
fn image_name(file: &File<'_>, index: usize) -> String {
    let item = file.document.item("images", index).ok();
    let name = item.as_ref().and_then(|item| {
        let uri = item.text("uri").ok().flatten();
        item.name().or(uri.filter(|uri| !uri.starts_with("data:")))
    });
    name.map_or_else(|| format!("image {index}"), str::to_owned)
}

/// Width and height from the header.
fn dimensions(bytes: &[u8]) -> Result<(u32, u32), String> {
    quietly(|| reader(bytes)?.into_dimensions().map_err(broken))
}

/// Decodes to RGBA, eight bits a channel.
fn decode(name: &str, bytes: &[u8]) -> Result<ImageDescription, String> {
    let decoded = quietly(|| {
        let mut decoder = reader(bytes)?.into_decoder().map_err(broken)?;
        decoder.set_limits(limits()).map_err(broken)?;
        DynamicImage::from_decoder(decoder).map_err(broken)
    })?;
    let rgba = decoded.into_rgba8();
    let (width, height) = rgba.dimensions();
    let (texels, _) = rgba.as_raw().as_chunks::<4>();
    if texels.is_empty() {
        return Err("has no texels".to_owned());
    }
    Ok(ImageDescription {
        name: name.to_owned(),
        width: width as usize,
        height: height as usize,
        texels: texels.to_vec(),
    })
}

/// The format is told by the bytes; names and MIME types are often wrong.
fn reader(bytes: &[u8]) -> Result<ImageReader<Cursor<&[u8]>>, String> {
    let format = image::guess_format(bytes)
        .ok()
        .filter(|format| {
            matches!(
                format,
                ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP
            )
        })
        .ok_or("is not a PNG, JPEG or WebP image")?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits());
    Ok(reader)
}

fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST_SIDE);
    limits.max_image_height = Some(LARGEST_SIDE);
    limits.max_alloc = Some(LARGEST_IMAGE);
    limits
}

fn broken(error: impl std::fmt::Display) -> String {
    format!("cannot be decoded ({error})")
}

/// Runs a decoder of others; should it panic on odd bytes, that is an error.
pub(super) fn quietly<T>(decode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err("cannot be decoded (the decoder gave up)".to_owned()))
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use image::{ImageFormat, RgbaImage};

    use super::decode;

    #[test]
    fn formats_are_told_by_their_bytes() {
        let image = RgbaImage::from_fn(3, 2, |x, y| image::Rgba([x as u8, y as u8, 7, 255]));
        for format in [ImageFormat::Png, ImageFormat::WebP] {
            let mut bytes = Cursor::new(Vec::new());
            image.write_to(&mut bytes, format).unwrap();
            let decoded = decode("x", bytes.get_ref()).unwrap();
            assert_eq!((decoded.width, decoded.height), (3, 2));
            assert_eq!(decoded.texels[4], [1, 1, 7, 255]);
        }
        assert!(decode("x", b"not an image").is_err());
        assert!(decode("x", b"").is_err());
    }

    #[test]
    fn claims_of_size_are_limited() {
        let image = RgbaImage::new(1, 1);
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let mut bytes = bytes.into_inner();
        bytes[16..20].copy_from_slice(&1_000_000_u32.to_be_bytes());
        assert!(decode("x", &bytes).is_err());
    }
}
