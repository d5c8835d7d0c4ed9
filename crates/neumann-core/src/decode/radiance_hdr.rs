//! Radiance HDR, in the dialects that programs write (G. Ward, Real Pixels, Graphics Gems II;
//! Radiance 5, `color.c`, `resolu.c`).
//!
//! A reader of our own, since the decoder of the crate `image` takes `#?RADIANCE` alone, knows
//! one of the eight orientations, leaves `EXPOSURE` in the pixels, and makes twelve bytes of
//! four. Header: a line that begins with `#?`, lines `NAME=value`, an empty one, the resolution.
//! `EXPOSURE` and `COLORCORR` say what the pixels were multiplied by; of several lines all count.
//! Then scanlines: flat, with old runs (a pixel 1 1 1 n repeats the last one), or by component.

use super::{DecodeError, StoredRadiances};
use crate::memory::{self, Share};
use crate::radiometry::Rgb;

/// What the head of a file says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// Texels per row of the upright picture, at least 1.
    pub width: usize,
    /// Its rows, at least 1.
    pub height: usize,
    order: Order,
    /// What the pixels have to be multiplied by.
    factor: Rgb,
    is_xyz: bool,
    /// Where the scanlines begin.
    offset: usize,
}

/// In which order the pixels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Order {
    /// True if a scanline is a column.
    is_by_column: bool,
    /// True if the first column is the rightmost.
    is_from_right: bool,
    /// True if the first row is the lowest.
    is_from_below: bool,
}

/// True if the bytes begin as such a file does.
#[must_use]
pub fn is_hdr(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?")
}

/// Reads the head of a file.
///
/// # Errors
/// If it is not such a file, or broken.
pub fn header(bytes: &[u8]) -> Result<Header, DecodeError> {
    let mut offset = 0;
    let mut factor = [1f64; 3];
    let mut is_xyz = false;
    let mut is_first = true;
    loop {
        let line = next_line(bytes, &mut offset)?;
        if is_first && !line.starts_with("#?") {
            return Err(DecodeError::Content(
                "is not a Radiance HDR image".to_owned(),
            ));
        }
        if line.is_empty() {
            break;
        }
        if !is_first && let Some((name, value)) = line.split_once('=') {
            match name.trim_end() {
                "FORMAT" => {
                    is_xyz = match value.trim() {
                        "32-bit_rle_rgbe" => false,
                        "32-bit_rle_xyze" => true,
                        other => {
                            return Err(content(format!("is in the format '{other}'")));
                        }
                    };
                }
                "EXPOSURE" => divide(&mut factor, &[0; 3], value, &line)?,
                "COLORCORR" => divide(&mut factor, &[0, 1, 2], value, &line)?,
                _ => {}
            }
        }
        is_first = false;
    }
    let line = next_line(bytes, &mut offset)?;
    let (order, width, height) = resolution(&line).ok_or_else(|| {
        content(format!(
            "its resolution is '{line}', not such as -Y 8 +X 16"
        ))
    })?;
    if width == 0 || height == 0 {
        return Err(content("has no texels".to_owned()));
    }
    let factor = Rgb::from(factor.map(|f| f as f32));
    if !factor.is_radiance() || factor.is_black() {
        return Err(content(
            "its exposures multiply to nothing sensible".to_owned(),
        ));
    }
    Ok(Header {
        width,
        height,
        order,
        factor,
        is_xyz,
        offset,
    })
}

/// Decodes the picture, upright, radiance as it was before any exposure.
///
/// # Errors
/// If it is broken or cut short, or there is no memory for it.
pub fn decode(bytes: &[u8], memory: &mut Share) -> Result<StoredRadiances, DecodeError> {
    let header = header(bytes)?;
    let (width, height) = (header.width, header.height);
    let n = width
        .checked_mul(height)
        .ok_or_else(|| content(format!("is {width} by {height}")))?;
    memory.grow(memory::bytes_of::<[u8; 4]>(n))?;
    let mut texels = memory::filled([0u8; 4], n)?;
    let (n_scanlines, n_pixels) = if header.order.is_by_column {
        (width, height)
    } else {
        (height, width)
    };
    let mut reader = Reader {
        bytes: &bytes[header.offset..],
    };
    let mut scanline = memory::filled([0u8; 4], n_pixels)?;
    for i in 0..n_scanlines {
        reader
            .scanline(&mut scanline)
            .ok_or_else(|| content(format!("is broken or cut short at scanline {i}")))?;
        for (k, pixel) in scanline.iter().enumerate() {
            let (x, y) = if header.order.is_by_column {
                (i, k)
            } else {
                (k, i)
            };
            let x = if header.order.is_from_right {
                width - 1 - x
            } else {
                x
            };
            let y = if header.order.is_from_below {
                height - 1 - y
            } else {
                y
            };
            texels[y * width + x] = *pixel;
        }
    }
    let stored = StoredRadiances::Rgbe {
        texels,
        factor: header.factor,
    };
    if !header.is_xyz {
        return Ok(stored);
    }
    let mut texels = stored.into_floats(memory)?;
    for texel in &mut texels {
        *texel = rgb_from_xyz(*texel);
    }
    Ok(StoredRadiances::Float(texels))
}

fn content(problem: String) -> DecodeError {
    DecodeError::Content(problem)
}

/// The next line without its end, which may be that of Windows.
fn next_line(bytes: &[u8], offset: &mut usize) -> Result<String, DecodeError> {
    let rest = &bytes[*offset..];
    let end = rest
        .iter()
        .position(|b| *b == b'\n')
        .ok_or_else(|| content("is cut short within its header".to_owned()))?;
    *offset += end + 1;
    let line = rest[..end].strip_suffix(b"\r").unwrap_or(&rest[..end]);
    Ok(String::from_utf8_lossy(line).into_owned())
}

/// Divides channel k by the number `which[k]` of the line's value.
fn divide(
    factor: &mut [f64; 3],
    which: &[usize; 3],
    value: &str,
    line: &str,
) -> Result<(), DecodeError> {
    let numbers: Vec<f64> = value
        .split_whitespace()
        .map_while(|word| word.parse().ok())
        .filter(|number: &f64| number.is_finite() && *number > 0.0)
        .collect();
    for (channel, index) in factor.iter_mut().zip(which) {
        *channel /= numbers
            .get(*index)
            .ok_or_else(|| content(format!("its header says '{line}', which is no factor")))?;
    }
    Ok(())
}

/// `±Y height ±X width`, or columns first: order, width, height.
fn resolution(line: &str) -> Option<(Order, usize, usize)> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [first, n_first, second, n_second] = words[..] else {
        return None;
    };
    let (n_first, n_second): (usize, usize) = (n_first.parse().ok()?, n_second.parse().ok()?);
    let is_by_column = first.ends_with(['X', 'x']);
    let (x, width, y, height) = if is_by_column {
        (first, n_first, second, n_second)
    } else {
        (second, n_second, first, n_first)
    };
    let order = Order {
        is_by_column,
        is_from_right: match x {
            "+X" | "+x" => false,
            "-X" | "-x" => true,
            _ => return None,
        },
        is_from_below: match y {
            "-Y" | "-y" => false,
            "+Y" | "+y" => true,
            _ => return None,
        },
    };
    Some((order, width, height))
}

/// To the primaries that Radiance takes its own RGB to have, with white of equal energy.
fn rgb_from_xyz(c: Rgb) -> Rgb {
    Rgb::new(
        2.565_3 * c.r - 1.166_8 * c.g - 0.398_4 * c.b,
        -1.022_1 * c.r + 1.978_3 * c.g + 0.043_8 * c.b,
        0.074_7 * c.r - 0.251_9 * c.g + 1.177_2 * c.b,
    )
    .map(|c| c.max(0.0))
}

/// The bytes that are left.
struct Reader<'a> {
    bytes: &'a [u8],
}

/// Scanlines by component are between so long.
const BY_COMPONENT: std::ops::RangeInclusive<usize> = 8..=32767;

impl Reader<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.bytes.split_first()?;
        self.bytes = rest;
        Some(*first)
    }

    fn pixel(&mut self) -> Option<[u8; 4]> {
        let (first, rest) = self.bytes.split_first_chunk()?;
        self.bytes = rest;
        Some(*first)
    }

    /// `None` if it is not well formed.
    fn scanline(&mut self, pixels: &mut [[u8; 4]]) -> Option<()> {
        let start: [u8; 4] = *self.bytes.first_chunk()?;
        let is_by_component =
            BY_COMPONENT.contains(&pixels.len()) && start[..2] == [2, 2] && start[2] < 128;
        if !is_by_component {
            return self.old_scanline(pixels);
        }
        let n = usize::from(start[2]) << 8 | usize::from(start[3]);
        if n != pixels.len() {
            return None;
        }
        self.pixel()?;
        for component in 0..4 {
            let mut i = 0;
            while i < n {
                let code = self.byte()?;
                let (length, run) = if code > 128 {
                    (usize::from(code - 128), Some(self.byte()?))
                } else {
                    (usize::from(code), None)
                };
                for pixel in pixels.get_mut(i..i + length)? {
                    pixel[component] = match run {
                        Some(value) => value,
                        None => self.byte()?,
                    };
                }
                i += length;
            }
        }
        Some(())
    }

    fn old_scanline(&mut self, pixels: &mut [[u8; 4]]) -> Option<()> {
        let (mut i, mut shift) = (0, 0);
        while i < pixels.len() {
            let pixel = self.pixel()?;
            if pixel[..3] == [1, 1, 1] {
                let last = *pixels.get(i.checked_sub(1)?)?;
                let length = usize::from(pixel[3]).checked_shl(shift)?;
                let end = i.checked_add(length)?;
                pixels.get_mut(i..end)?.fill(last);
                i = end;
                shift = (shift + 8).min(32);
            } else {
                pixels[i] = pixel;
                i += 1;
                shift = 0;
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::{StoredRadiances, decode, header};
    use crate::decode::DecodeError;
    use crate::memory::Share;
    use crate::radiometry::Rgb;

    const W: usize = 9;
    const H: usize = 3;

    /// A pixel whose red says its column and whose green says its row.
    fn pixel(x: usize, y: usize) -> [u8; 4] {
        [128 + x as u8, 128 + 16 * y as u8, 7, 129]
    }

    fn file(head: &str, resolution: &str, pixels: impl IntoIterator<Item = u8>) -> Vec<u8> {
        let mut bytes = format!("{head}\n{resolution}\n").into_bytes();
        bytes.extend(pixels);
        bytes
    }

    /// Flat pixels by the order of the resolution line.
    fn oriented(resolution: &str) -> Vec<u8> {
        let is_by_column = resolution.find('X') < resolution.find('Y');
        let (n_lines, n) = if is_by_column { (W, H) } else { (H, W) };
        let pixels = (0..n_lines).flat_map(|i| (0..n).map(move |k| (i, k)));
        let pixels = pixels.flat_map(|(i, k)| {
            let (x, y) = if is_by_column { (i, k) } else { (k, i) };
            let x = if resolution.contains("-X") {
                W - 1 - x
            } else {
                x
            };
            let y = if resolution.contains("+Y") {
                H - 1 - y
            } else {
                y
            };
            pixel(x, y)
        });
        file("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", resolution, pixels)
    }

    fn read(bytes: &[u8]) -> Result<StoredRadiances, DecodeError> {
        decode(bytes, &mut Share::default())
    }

    #[test]
    fn all_eight_orientations_stand_upright() {
        let mut n = 0;
        for (y, x) in [("-Y", "+X"), ("-Y", "-X"), ("+Y", "+X"), ("+Y", "-X")] {
            for resolution in [format!("{y} {H} {x} {W}"), format!("{x} {W} {y} {H}")] {
                let bytes = oriented(&resolution);
                let head = header(&bytes).unwrap();
                assert_eq!((head.width, head.height), (W, H), "{resolution}");
                let StoredRadiances::Rgbe { texels, .. } = read(&bytes).unwrap() else {
                    panic!("not as stored");
                };
                let wanted: Vec<_> = (0..W * H).map(|i| pixel(i % W, i / W)).collect();
                assert_eq!(texels, wanted, "{resolution}");
                n += 1;
            }
        }
        assert_eq!(n, 8);
    }

    #[test]
    fn headers_of_many_programs_are_read() {
        let plain = [128, 64, 0, 130];
        let texel = |head: &str| read(&file(head, "-Y 1 +X 1", plain)).map(|s| s.get(0));
        let wanted = Rgb::new(2.0, 1.0, 0.0);
        for head in [
            "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n",
            "#?RGBE\nFORMAT=32-bit_rle_rgbe\n",
            "#?AUTOPANO\n",
            "#?RADIANCE\r\n# made by\r\nFORMAT=32-bit_rle_rgbe\r\n\r",
            "#?RADIANCE\nEXPOSURE=1.000000e+00\nVIEW= -vtv -vp 0 0 0\nFORMAT=32-bit_rle_rgbe\n",
        ] {
            assert_eq!(texel(head).unwrap(), wanted, "{head}");
        }
        let exposed = texel("#?RGBE\nEXPOSURE=2\nEXPOSURE= 4.0\n").unwrap();
        assert_eq!(exposed, wanted * 0.125);
        let corrected = texel("#?RGBE\nCOLORCORR=2 4 1\nEXPOSURE=0.5\n").unwrap();
        assert_eq!(corrected, Rgb::new(2.0, 0.5, 0.0));
        for head in [
            "#?RGBE\nEXPOSURE=0\n",
            "#?RGBE\nEXPOSURE=bright\n",
            "#?RGBE\nCOLORCORR=1 2\n",
            "#?RGBE\nFORMAT=16-bit\n",
            "P6\n",
        ] {
            assert!(texel(head).is_err(), "{head}");
        }
        let white = texel("#?RGBE\nFORMAT=32-bit_rle_xyze\n").unwrap();
        assert!(white.is_radiance() && white.r > white.b);
    }

    #[test]
    fn both_kinds_of_runs_are_undone() {
        let head = "#?RGBE\n";
        let old = [
            [5, 6, 7, 130],
            [1, 1, 1, 3],
            [8, 9, 10, 131],
            [1, 1, 1, 0],
            [1, 1, 1, 1],
        ];
        // A count of 0, and one of 1 in units of 256.
        let n = 1 + 3 + 1 + 256;
        let bytes = file(head, &format!("-Y 1 +X {n}"), old.into_iter().flatten());
        let StoredRadiances::Rgbe { texels, .. } = read(&bytes).unwrap() else {
            panic!("not as stored");
        };
        assert_eq!(texels[..4], [[5, 6, 7, 130]; 4]);
        assert_eq!(texels[4..], [[8, 9, 10, 131]; 257]);

        let mut new = vec![2u8, 2, 0, 9];
        for component in 0..4u8 {
            new.extend([128 + 5, 100 + component, 4, 1, 2, 3, 4]);
        }
        let StoredRadiances::Rgbe { texels, .. } =
            read(&file(head, "-Y 1 +X 9", new.clone())).unwrap()
        else {
            panic!("not as stored");
        };
        assert_eq!(texels[4], [100, 101, 102, 103]);
        assert_eq!(texels[8], [4; 4]);

        for cut in 0..new.len() {
            assert!(read(&file(head, "-Y 1 +X 9", new[..cut].to_vec())).is_err());
        }
        let first_repeats = [1, 1, 1, 1, 5, 5, 5, 130];
        assert!(read(&file(head, "-Y 1 +X 2", first_repeats)).is_err());
        let too_long = [5, 5, 5, 130, 1, 1, 1, 200];
        assert!(read(&file(head, "-Y 1 +X 2", too_long)).is_err());
        for resolution in [
            "",
            "-Y 1",
            "-Y 0 +X 4",
            "-Y a +X 1",
            "-X 1 +X 1",
            "-Y -1 +X 1",
        ] {
            assert!(
                read(&file(head, resolution, [0; 64])).is_err(),
                "{resolution}"
            );
        }
    }
}
