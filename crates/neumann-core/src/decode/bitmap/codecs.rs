//! The decoders: the feature `pictures`.
//!
//! PNG is read by its own crate, since that keeps texels of 1, 2 and 4 bits and palettes as they
//! are; JPEG and WebP come through the crate `image`.

use std::io::Cursor;

use bytemuck::{Pod, cast_slice_mut};
use image::codecs::jpeg::JpegDecoder;
use image::codecs::webp::WebPDecoder;
use image::{ColorType, ImageDecoder, ImageFormat};

use super::Header;
use crate::decode::{DecodeError, Indexed, StoredTexels};
use crate::memory;

/// Width, height, and the texels.
type Stored = (usize, usize, StoredTexels);

/// True if the bytes begin as one of the formats do.
pub(super) fn is_known(bytes: &[u8]) -> bool {
    format(bytes).is_ok()
}

/// What the head of a file says.
pub(super) fn header(bytes: &[u8]) -> Result<Header, DecodeError> {
    match format(bytes)? {
        ImageFormat::Png => {
            let reader = png_reader(bytes)?;
            let (width, height) = reader.info().size();
            let n_bytes = reader
                .output_buffer_size()
                .ok_or_else(|| DecodeError::broken("it is too large"))?;
            Ok(Header {
                width: width as usize,
                height: height as usize,
                n_bytes: n_bytes as u64,
                n_working_bytes: PNG_WORK,
            })
        }
        ImageFormat::Jpeg => {
            let decoder = jpeg_decoder(bytes)?;
            let texels = u64::from(decoder.dimensions().0) * u64::from(decoder.dimensions().1);
            // Its start of frame, FF C2, says that it is progressive: all coefficients, two bytes
            // each, wait for the last scan.
            let is_progressive = bytes.windows(2).any(|two| two == [0xff, 0xc2]);
            let coefficients = if is_progressive { 8 * texels } else { 0 };
            Ok(header_of(&decoder, 2 * bytes.len() as u64 + coefficients))
        }
        _ => {
            let decoder = webp_decoder(bytes)?;
            let texels = u64::from(decoder.dimensions().0) * u64::from(decoder.dimensions().1);
            // A canvas and a frame, four bytes each.
            Ok(header_of(&decoder, bytes.len() as u64 + 8 * texels))
        }
    }
}

/// The picture of a file.
pub(super) fn decode(bytes: &[u8]) -> Result<Stored, DecodeError> {
    match format(bytes)? {
        ImageFormat::Png => decode_png(bytes),
        ImageFormat::Jpeg => decode_with(jpeg_decoder(bytes)?),
        _ => decode_with(webp_decoder(bytes)?),
    }
}

/// Rows and the window of the decompressor.
const PNG_WORK: u64 = 1 << 20;

/// Chunks beside the picture may take this much together.
const PNG_CHUNKS: usize = 64 << 20;

fn format(bytes: &[u8]) -> Result<ImageFormat, DecodeError> {
    let is_read = |format: &ImageFormat| {
        matches!(
            format,
            ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP
        )
    };
    image::guess_format(bytes)
        .ok()
        .filter(is_read)
        .ok_or_else(|| DecodeError::Content("is not a PNG, JPEG or WebP image".to_owned()))
}

fn jpeg_decoder(bytes: &[u8]) -> Result<JpegDecoder<Cursor<&[u8]>>, DecodeError> {
    JpegDecoder::new(Cursor::new(bytes)).map_err(DecodeError::broken)
}

fn webp_decoder(bytes: &[u8]) -> Result<WebPDecoder<Cursor<&[u8]>>, DecodeError> {
    WebPDecoder::new(Cursor::new(bytes)).map_err(DecodeError::broken)
}

fn header_of(decoder: &impl ImageDecoder, n_working_bytes: u64) -> Header {
    let (width, height) = decoder.dimensions();
    Header {
        width: width as usize,
        height: height as usize,
        n_bytes: decoder.total_bytes(),
        n_working_bytes,
    }
}

fn decode_with(decoder: impl ImageDecoder) -> Result<Stored, DecodeError> {
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    let n = width * height;
    let stored = match decoder.color_type() {
        ColorType::L8 => StoredTexels::Grey8(read(decoder, n)?),
        ColorType::La8 => StoredTexels::GreyAlpha8(read(decoder, n)?),
        ColorType::Rgb8 => StoredTexels::Rgb8(read(decoder, n)?),
        ColorType::Rgba8 => StoredTexels::Rgba8(read(decoder, n)?),
        other => {
            let problem = format!("has texels of kind {other:?}, which cannot be read");
            return Err(DecodeError::Content(problem));
        }
    };
    Ok((width, height, stored))
}

fn read<T: Pod>(decoder: impl ImageDecoder, n: usize) -> Result<Vec<T>, DecodeError> {
    let mut texels = memory::filled(T::zeroed(), n)?;
    decoder
        .read_image(cast_slice_mut(&mut texels))
        .map_err(DecodeError::broken)?;
    Ok(texels)
}

/// A reader that has come to the picture itself.
fn png_reader(bytes: &[u8]) -> Result<png::Reader<Cursor<&[u8]>>, DecodeError> {
    let limits = png::Limits { bytes: PNG_CHUNKS };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let info = decoder.read_header_info().map_err(DecodeError::broken)?;
    let is_packed = is_packed(info);
    if !is_packed {
        // A transparent colour becomes an alpha channel.
        decoder.set_transformations(png::Transformations::EXPAND);
    }
    decoder.read_info().map_err(DecodeError::broken)
}

/// True for texels that name one of at most 256 colours.
fn is_packed(info: &png::Info<'_>) -> bool {
    info.color_type == png::ColorType::Indexed || (info.bit_depth as usize) < 8
}

fn decode_png(bytes: &[u8]) -> Result<Stored, DecodeError> {
    let mut reader = png_reader(bytes)?;
    let (width, height) = reader.info().size();
    let (width, height) = (width as usize, height as usize);
    let n = width * height;
    let stored = if is_packed(reader.info()) {
        let n_bits = reader.info().bit_depth as usize;
        let colors = palette(reader.info());
        let rows = read_png(&mut reader, (width * n_bits).div_ceil(8) * height)?;
        StoredTexels::Indexed(Indexed::new(width, n_bits, rows, &colors))
    } else {
        use png::{BitDepth, ColorType};
        match reader.output_color_type() {
            (ColorType::Grayscale, BitDepth::Sixteen) => {
                StoredTexels::Grey16(read_png_words(&mut reader, n)?)
            }
            (ColorType::GrayscaleAlpha, BitDepth::Sixteen) => {
                StoredTexels::GreyAlpha16(read_png_words(&mut reader, n)?)
            }
            (ColorType::Rgb, BitDepth::Sixteen) => {
                StoredTexels::Rgb16(read_png_words(&mut reader, n)?)
            }
            (ColorType::Rgba, BitDepth::Sixteen) => {
                StoredTexels::Rgba16(read_png_words(&mut reader, n)?)
            }
            (ColorType::Grayscale | ColorType::Indexed, _) => {
                StoredTexels::Grey8(read_png(&mut reader, n)?)
            }
            (ColorType::GrayscaleAlpha, _) => StoredTexels::GreyAlpha8(read_png(&mut reader, n)?),
            (ColorType::Rgb, _) => StoredTexels::Rgb8(read_png(&mut reader, n)?),
            (ColorType::Rgba, _) => StoredTexels::Rgba8(read_png(&mut reader, n)?),
        }
    };
    Ok((width, height, stored))
}

/// RGBA by index: the palette, or steps of grey.
fn palette(info: &png::Info<'_>) -> Vec<[u8; 4]> {
    let transparent = info.trns.as_deref().unwrap_or_default();
    if info.color_type == png::ColorType::Indexed {
        let (colors, _) = info.palette.as_deref().unwrap_or_default().as_chunks::<3>();
        let alpha = |i: usize| transparent.get(i).copied().unwrap_or(255);
        return colors
            .iter()
            .enumerate()
            .map(|(i, &[r, g, b])| [r, g, b, alpha(i)])
            .collect();
    }
    let last = (1_u16 << info.bit_depth as u16) - 1;
    // One byte of it, or two, the large one first, of which the first is 0.
    let hole = transparent.last().map(|low| u16::from(*low));
    (0..=last)
        .map(|i| {
            let grey = (i * 255 / last) as u8;
            let alpha = if hole == Some(i) { 0 } else { 255 };
            [grey, grey, grey, alpha]
        })
        .collect()
}

fn read_png<T: Pod>(
    reader: &mut png::Reader<Cursor<&[u8]>>,
    n: usize,
) -> Result<Vec<T>, DecodeError> {
    let mut texels = memory::filled(T::zeroed(), n)?;
    reader
        .next_frame(cast_slice_mut(&mut texels))
        .map_err(DecodeError::broken)?;
    Ok(texels)
}

/// Numbers of two bytes, which the file has the large one first.
fn read_png_words<T: Pod>(
    reader: &mut png::Reader<Cursor<&[u8]>>,
    n: usize,
) -> Result<Vec<T>, DecodeError> {
    let mut texels = read_png(reader, n)?;
    for word in cast_slice_mut::<T, u16>(&mut texels) {
        *word = u16::from_be(*word);
    }
    Ok(texels)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use image::{ImageFormat, RgbaImage};

    use crate::decode::StoredTexels;
    use crate::decode::bitmap::{decode, header};
    use crate::memory::Share;

    /// A PNG of the numbers as they are stored, row by row.
    fn png(
        (width, height): (u32, u32),
        color: png::ColorType,
        depth: png::BitDepth,
        rows: &[u8],
        more: impl Fn(&mut png::Encoder<'_, &mut Vec<u8>>),
    ) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(color);
        encoder.set_depth(depth);
        more(&mut encoder);
        encoder
            .write_header()
            .unwrap()
            .write_image_data(rows)
            .unwrap();
        bytes
    }

    /// RGBA of the texels of the first row, times 255.
    fn first_row(bytes: &[u8]) -> Vec<[f32; 4]> {
        let head = header(bytes).unwrap();
        let bitmap = decode(bytes, Share::default()).unwrap();
        assert_eq!((bitmap.width, bitmap.height), (head.width, head.height));
        (0..bitmap.width)
            .map(|x| bitmap.texels.rgba(bitmap.width, x, 0).map(|c| c * 255.0))
            .collect()
    }

    #[test]
    fn formats_are_told_by_their_bytes() {
        let image = RgbaImage::from_fn(3, 2, |x, y| image::Rgba([x as u8, y as u8, 7, 255]));
        for format in [ImageFormat::Png, ImageFormat::WebP] {
            let mut bytes = Cursor::new(Vec::new());
            image.write_to(&mut bytes, format).unwrap();
            let bitmap = decode(bytes.get_ref(), Share::default()).unwrap();
            assert_eq!((bitmap.width, bitmap.height), (3, 2));
            let texel = bitmap.texels.rgba(3, 1, 1).map(|c| (c * 255.0).round());
            assert_eq!(texel, [1.0, 1.0, 7.0, 255.0]);
        }
        for bytes in [&b"not an image"[..], b"", b"\x89PNG\r\n\x1a\nrubbish"] {
            assert!(header(bytes).is_err() && decode(bytes, Share::default()).is_err());
        }
    }

    #[test]
    fn pictures_of_few_bits_keep_them() {
        use png::{BitDepth, ColorType};
        // 1 0 1 1 0 0 0 0, then 1.
        let size = (9, 1);
        let bits = png(
            size,
            ColorType::Grayscale,
            BitDepth::One,
            &[0xb0, 0x80],
            |_| {},
        );
        assert_eq!(header(&bits).unwrap().n_bytes, 2);
        let reds: Vec<f32> = first_row(&bits).iter().map(|t| t[0]).collect();
        assert_eq!(reds, [255.0, 0.0, 255.0, 255.0, 0.0, 0.0, 0.0, 0.0, 255.0]);

        let size = (3, 1);
        let fours = png(
            size,
            ColorType::Grayscale,
            BitDepth::Four,
            &[0x0f, 0x30],
            |e| {
                e.set_trns(vec![0u8, 3]);
            },
        );
        let row = first_row(&fours);
        assert_eq!(row[1], [255.0; 4]);
        assert_eq!(row[2], [51.0, 51.0, 51.0, 0.0], "the transparent grey");

        let named = png(
            size,
            ColorType::Indexed,
            BitDepth::Two,
            &[0b0110_1100],
            |e| {
                e.set_palette(vec![0u8, 0, 0, 10, 20, 30, 40, 50, 60]);
                e.set_trns(vec![255u8, 7]);
            },
        );
        let row = first_row(&named);
        assert_eq!(row[0].map(f32::round), [10.0, 20.0, 30.0, 7.0]);
        assert_eq!(row[1].map(f32::round), [40.0, 50.0, 60.0, 255.0]);
        assert_eq!(row[2], [0.0, 0.0, 0.0, 255.0], "beyond the palette");
    }

    #[test]
    fn sixteen_bits_stay_sixteen() {
        use png::{BitDepth, ColorType};
        let words = [3u16, 300, 65535, 257, 258, 259];
        let rows: Vec<u8> = words.iter().flat_map(|w| w.to_be_bytes()).collect();
        let bytes = png((2, 1), ColorType::Rgb, BitDepth::Sixteen, &rows, |_| {});
        let bitmap = decode(&bytes, Share::default()).unwrap();
        let StoredTexels::Rgb16(texels) = bitmap.texels.stored() else {
            panic!("{bitmap:?}");
        };
        assert_eq!(texels[..], [[3, 300, 65535], [257, 258, 259]]);
        let grey = png(
            (2, 1),
            ColorType::Grayscale,
            BitDepth::Sixteen,
            &rows[..4],
            |_| {},
        );
        let second = first_row(&grey)[1][1];
        assert!((second - 300.0 / 257.0).abs() < 1e-5, "{second}");
        let alpha = png(
            (1, 1),
            ColorType::GrayscaleAlpha,
            BitDepth::Sixteen,
            &rows[..4],
            |_| {},
        );
        assert!((first_row(&alpha)[0][3] - 300.0 / 257.0).abs() < 1e-5);
    }

    #[test]
    fn a_head_tells_what_its_picture_needs() {
        let image = RgbaImage::new(1, 1);
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let mut bytes = bytes.into_inner();
        bytes[16..20].copy_from_slice(&1_000_000_u32.to_be_bytes());
        assert!(header(&bytes).is_err(), "its checksum is wrong");
    }
}
