//! OpenEXR: the pictures in a file by name, and any of them in its display window.
//!
//! Blocks go from the decompressor straight to the picture that is wanted, as half or single
//! precision as in the file: neither other layers nor planes are kept. Pixels outside of the
//! display window (overscan) are cut; where the data window does not reach, it is black.

use std::io::{Read, Seek};

use exr::block::reader::{ChunksReader, Reader};
use exr::meta::attribute::{EnvironmentMap, SampleType};
use exr::meta::header::Header;
use half::f16;

use super::{DecodeError, StoredRadiances, quietly};
use crate::memory::{self, Share};
use crate::radiometry::Rgb;

/// The first bytes of a file.
pub const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// A picture within a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Empty for that of the channels `R`, `G`, `B` or `Y` of a part without a name.
    pub name: String,
    /// True for red, green and blue, or luminance; not for depths, normals and masks.
    pub is_color: bool,
    part: usize,
    /// Positions in the part's list: three channels, or three times the same.
    channels: [usize; 3],
}

/// A file whose head has been read.
pub struct File<R> {
    reader: Reader<R>,
    /// Its pictures: colours first, then by name.
    pub layers: Vec<Layer>,
    /// Pixels per row of the display window.
    pub width: usize,
    /// Its rows.
    pub height: usize,
    /// True if it says that it is the six sides of a cube.
    pub is_cube: bool,
    length: u64,
}

/// Names of layers that stand for the whole picture.
const USUAL: [&str; 5] = ["rgba", "rgb", "beauty", "color", "combined"];

impl<R: Read + Seek> File<R> {
    /// Reads the head of a file of so many bytes.
    ///
    /// # Errors
    /// If it is no such file, broken, or its windows do not meet.
    pub fn open(mut bytes: R, length: u64) -> Result<Self, DecodeError> {
        let reduced = reduced_channels(&mut bytes).map_err(DecodeError::broken)?;
        if let Some(names) = reduced {
            return Err(content(format!(
                "has channels of less than full size, as luminance and chroma do, which cannot be \
                 read; its channels are {names}"
            )));
        }
        quietly(|| {
            let reader = exr::block::read(bytes, false).map_err(DecodeError::broken)?;
            let headers = reader.headers();
            let first = headers
                .first()
                .ok_or_else(|| content("has no picture in it"))?;
            let size = first.shared_attributes.display_window.size;
            let mut layers = Vec::new();
            for (part, header) in headers.iter().enumerate() {
                add_layers(part, header, &mut layers);
            }
            layers.sort_by(|a: &Layer, b| (!a.is_color, &a.name).cmp(&(!b.is_color, &b.name)));
            layers.dedup_by(|b, a| a.name == b.name);
            Ok(Self {
                layers,
                width: size.width(),
                height: size.height(),
                is_cube: first.own_attributes.environment_map == Some(EnvironmentMap::Cube),
                reader,
                length,
            })
        })
    }

    /// The picture of that name, or the main one.
    ///
    /// # Errors
    /// If there is none, or no main one among several; the text lists what is there.
    pub fn layer(&self, name: Option<&str>) -> Result<Layer, DecodeError> {
        let name = name.filter(|name| *name != "L").unwrap_or("");
        let is_named = |l: &&Layer| l.name == name && (l.is_color || !name.is_empty());
        if let Some(layer) = self.layers.iter().find(is_named) {
            return Ok(layer.clone());
        }
        let colors: Vec<&Layer> = self.layers.iter().filter(|l| l.is_color).collect();
        let usual = |layer: &&&Layer| {
            let name = layer.name.to_lowercase();
            USUAL.iter().any(|usual| name.contains(usual))
        };
        let main = match colors[..] {
            [only] => Some(only),
            _ => colors.iter().find(usual).copied(),
        };
        match main.filter(|_| name.is_empty()) {
            Some(layer) => Ok(layer.clone()),
            None => Err(self.no_layer(name)),
        }
    }

    fn no_layer(&self, name: &str) -> DecodeError {
        let wanted = if name.is_empty() {
            "has no picture in R, G, B or Y".to_owned()
        } else {
            format!("has no layer '{name}'")
        };
        let known: Vec<&str> = self
            .layers
            .iter()
            .map(|l| if l.name.is_empty() { "L" } else { &l.name })
            .collect();
        if known.is_empty() {
            let channels = self.channel_names().join(", ");
            content(format!("{wanted}; its channels are {channels}"))
        } else {
            content(format!("{wanted}; there are {}", known.join(", ")))
        }
    }

    fn channel_names(&self) -> Vec<String> {
        let headers = self.reader.headers().iter();
        headers
            .flat_map(|header| header.channels.list.iter().map(|c| full_name(header, c)))
            .collect()
    }

    /// Decodes pictures of the file, paid for by `memory`.
    ///
    /// # Errors
    /// If the file is broken, or there is no memory for them.
    pub fn read(
        self,
        layers: &[Layer],
        memory: &mut Share,
    ) -> Result<Vec<StoredRadiances>, DecodeError> {
        let n = self
            .width
            .checked_mul(self.height)
            .ok_or_else(|| content("is too large"))?;
        let all = n as u128 * layers.len() as u128 * size_of::<Rgb>() as u128;
        if all > FREE_BYTES_OF_WINDOW.max(u128::from(self.length) * LARGEST_RATIO) {
            return Err(content(format!(
                "cannot be decoded (its display window is {}x{}, in a file of {} bytes)",
                self.width, self.height, self.length
            )));
        }
        let headers = self.reader.headers();
        check(headers, layers, self.length)?;
        let mut targets = Vec::with_capacity(layers.len());
        for layer in layers {
            targets.push(Target::new(&headers[layer.part], layer, n, memory)?);
        }
        // Blocks that are decompressed at one time, as they are and as they come.
        let block = |layer: &Layer| headers[layer.part].max_block_byte_size() as u64;
        let n_blocks = 2 * (rayon::current_num_threads() as u64 + 2);
        let working = layers.iter().map(block).max().unwrap_or(0);
        let _working = Share::of_process(working.saturating_mul(n_blocks))?;
        let (width, height) = (self.width, self.height);
        quietly(|| {
            let is_wanted = |part: usize| layers.iter().any(|layer| layer.part == part);
            let chunks = self
                .reader
                .filter_chunks(false, |_, _, block| {
                    is_wanted(block.layer) && block.level == exr::math::Vec2(0, 0)
                })
                .map_err(DecodeError::broken)?;
            let insert = |meta: &exr::meta::MetaData, block: exr::block::UncompressedBlock| {
                let header = &meta.headers[block.index.layer];
                for line in block.lines(&header.channels) {
                    let at = line.location;
                    let Some(y) = at.position.y().checked_add_signed(offset(header, 1)) else {
                        continue;
                    };
                    if y >= height {
                        continue;
                    }
                    for (layer, target) in layers.iter().zip(&mut targets) {
                        if layer.part == at.layer && layer.channels.contains(&at.channel) {
                            let kind = header.channels.list[at.channel].sample_type;
                            let row = y * width..(y + 1) * width;
                            let x = at.position.x() as isize + offset(header, 0);
                            target.put(row, x, layer.channels, at.channel, kind, line.value);
                        }
                    }
                }
                Ok(())
            };
            chunks
                .decompress_parallel(false, insert)
                .map_err(DecodeError::broken)
        })?;
        Ok(targets.into_iter().map(|target| target.0).collect())
    }
}

/// The names of all channels of the first part, if one of them is not stored for every pixel:
/// the decoder would refuse the file without saying what is in it.
fn reduced_channels(bytes: &mut (impl Read + Seek)) -> std::io::Result<Option<String>> {
    let mut head = Vec::new();
    bytes.by_ref().take(1 << 16).read_to_end(&mut head)?;
    bytes.rewind()?;
    let list = b"channels\0chlist\0";
    let Some(at) = head.windows(list.len()).position(|w| w == list) else {
        return Ok(None);
    };
    let mut rest = head.get(at + list.len() + 4..).unwrap_or(&[]);
    let (mut names, mut is_reduced) = (Vec::new(), false);
    // A name, zero, type and flags in eight bytes, and the sampling each way in four.
    while let Some(end) = rest.iter().position(|b| *b == 0).filter(|end| *end > 0) {
        let (name, fields) = rest.split_at(end);
        let Some(sampling) = fields.get(9..17) else {
            break;
        };
        names.push(String::from_utf8_lossy(name).into_owned());
        is_reduced |= sampling != [1, 0, 0, 0, 1, 0, 0, 0];
        rest = &fields[17..];
    }
    Ok(is_reduced.then(|| names.join(", ")))
}

/// Where the data window begins in the display window, x or y.
fn offset(header: &Header, axis: usize) -> isize {
    let data = header.own_attributes.layer_position;
    let display = header.shared_attributes.display_window.position;
    let difference = |a: i32, b: i32| i64::from(a) - i64::from(b);
    let value = if axis == 0 {
        difference(data.x(), display.x())
    } else {
        difference(data.y(), display.y())
    };
    value as isize
}

/// Pixels under construction.
struct Target(StoredRadiances);

impl Target {
    fn new(
        header: &Header,
        layer: &Layer,
        n: usize,
        memory: &mut Share,
    ) -> Result<Self, DecodeError> {
        let channels = layer.channels.map(|i| header.channels.list[i].sample_type);
        Ok(Self(if channels == [SampleType::F16; 3] {
            memory.grow(memory::bytes_of::<[f16; 3]>(n))?;
            StoredRadiances::Half(memory::filled([f16::ZERO; 3], n)?)
        } else {
            memory.grow(memory::bytes_of::<Rgb>(n))?;
            StoredRadiances::Float(memory::filled(Rgb::BLACK, n)?)
        }))
    }

    /// Takes a line of one channel of the file, whose first sample is at column `x` of the row.
    fn put(
        &mut self,
        row: std::ops::Range<usize>,
        x: isize,
        channels: [usize; 3],
        channel: usize,
        kind: SampleType,
        line: &[u8],
    ) {
        let n_bytes = if kind == SampleType::F16 { 2 } else { 4 };
        let skipped = usize::try_from(-x).unwrap_or(0);
        let start = row.start + usize::try_from(x).unwrap_or(0);
        let samples = line.get(skipped.saturating_mul(n_bytes)..).unwrap_or(&[]);
        for slot in (0..3).filter(|slot| channels[*slot] == channel) {
            match &mut self.0 {
                StoredRadiances::Half(pixels) => {
                    let pixels = pixels.get_mut(start..row.end).unwrap_or(&mut []);
                    let (samples, _) = samples.as_chunks::<2>();
                    for (pixel, sample) in pixels.iter_mut().zip(samples) {
                        pixel[slot] = f16::from_ne_bytes(*sample);
                    }
                }
                StoredRadiances::Float(pixels) => {
                    let pixels = pixels.get_mut(start..row.end).unwrap_or(&mut []);
                    let values = pixels.iter_mut().map(|pixel| &mut pixel_mut(pixel)[slot]);
                    match kind {
                        SampleType::F16 => {
                            copy(values, samples, |two| f16::from_ne_bytes(two).to_f32());
                        }
                        SampleType::F32 => copy(values, samples, f32::from_ne_bytes),
                        SampleType::U32 => {
                            copy(values, samples, |four| u32::from_ne_bytes(four) as f32);
                        }
                    }
                }
                StoredRadiances::Rgbe { .. } => {}
            }
        }
    }
}

fn pixel_mut(pixel: &mut Rgb) -> &mut [f32; 3] {
    bytemuck::cast_mut(pixel)
}

fn copy<'a, const N: usize>(
    values: impl Iterator<Item = &'a mut f32>,
    samples: &[u8],
    float: impl Fn([u8; N]) -> f32,
) {
    let (samples, _) = samples.as_chunks::<N>();
    for (value, sample) in values.zip(samples) {
        *value = float(*sample);
    }
}

/// The channel's name after that of its part, which channels often repeat.
fn full_name(header: &Header, channel: &exr::meta::attribute::ChannelDescription) -> String {
    let name = channel.name.to_string();
    match &header.own_attributes.layer_name {
        Some(part) if !name.starts_with(&format!("{part}.")) => format!("{part}.{name}"),
        _ => name,
    }
}

/// The pictures of one part.
fn add_layers(part: usize, header: &Header, layers: &mut Vec<Layer>) {
    let is_full =
        |c: &exr::meta::attribute::ChannelDescription| c.sampling == exr::math::Vec2(1, 1);
    // Lines of a part with channels of reduced size are not where the decoder looks for them.
    if header.deep || !header.channels.list.iter().all(is_full) {
        return;
    }
    let names: Vec<String> = header
        .channels
        .list
        .iter()
        .map(|channel| full_name(header, channel))
        .collect();
    let mut prefixes: Vec<&str> = names
        .iter()
        .map(|name| name.rsplit_once('.').map_or("", |(layer, _)| layer))
        .collect();
    prefixes.sort_unstable();
    prefixes.dedup();
    for prefix in prefixes {
        let find = |channel: &str| {
            names.iter().position(|name| {
                name.strip_prefix(prefix)
                    .map(|rest| rest.strip_prefix('.').unwrap_or(rest))
                    .is_some_and(|rest| rest == channel)
            })
        };
        let three = |names: [&str; 3]| -> Option<[usize; 3]> {
            Some([find(names[0])?, find(names[1])?, find(names[2])?])
        };
        let grey = |name: &str| find(name).map(|i| [i; 3]);
        let color = three(["R", "G", "B"]);
        let found = color
            .or_else(|| three(["X", "Y", "Z"]))
            .or_else(|| ["Y", "Z", "V", "A"].into_iter().find_map(grey));
        let is_grey = color.is_none() && three(["X", "Y", "Z"]).is_none() && find("Y").is_some();
        if let Some(channels) = found {
            layers.push(Layer {
                name: prefix.to_owned(),
                is_color: color.is_some() || is_grey,
                part,
                channels,
            });
        }
    }
}

/// Bytes of samples that any file may have, however short it is.
const FREE_BYTES: u128 = 64 << 20;
/// Bytes of a display window that any file may have: it may hold a small part of it.
const FREE_BYTES_OF_WINDOW: u128 = 1 << 30;
/// Bytes of samples to each byte of the file: no compression does better than that.
const LARGEST_RATIO: u128 = 1100;

/// Refuses headers that promise more than the file can hold.
fn check(headers: &[Header], layers: &[Layer], length: u64) -> Result<(), DecodeError> {
    let is_wanted = |part: usize| layers.iter().any(|layer| layer.part == part);
    let wanted = headers
        .iter()
        .enumerate()
        .filter(|(part, _)| is_wanted(*part));
    let mut bytes = 0u128;
    for (_, header) in wanted {
        let size = header.layer_size;
        let n = size.width() as u128 * size.height() as u128;
        bytes += n * header.channels.bytes_per_pixel as u128;
        let display = header.shared_attributes.display_window.size;
        let meets = |offset: isize, n: usize, shown: usize| {
            (offset as i64) < shown as i64 && offset as i64 + n as i64 > 0
        };
        if !meets(offset(header, 0), size.width(), display.width())
            || !meets(offset(header, 1), size.height(), display.height())
        {
            return Err(content("its data window lies beside its display window"));
        }
    }
    if bytes > FREE_BYTES.max(u128::from(length) * LARGEST_RATIO) {
        return Err(content(format!(
            "cannot be decoded (its head promises {bytes} bytes of pixels in a file of {length})"
        )));
    }
    Ok(())
}

fn content(problem: impl Into<String>) -> DecodeError {
    DecodeError::Content(problem.into())
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
    use exr::math::Vec2;
    use exr::meta::attribute::IntegerBounds;
    use exr::meta::header::{ImageAttributes, LayerAttributes};
    use exr::prelude::{Text, WritableImage};
    use half::f16;

    use super::File;
    use crate::decode::{DecodeError, StoredRadiances};
    use crate::memory::Share;
    use crate::radiometry::Rgb;

    /// A file whose data window is 4 by 2 at `at`; channel k holds 10 k and the number of the
    /// pixel.
    fn file(at: (i32, i32), display: IntegerBounds, channels: &[&str], is_half: bool) -> Vec<u8> {
        let list = channels.iter().enumerate().map(|(k, name)| {
            let values = (0..8).map(|i| (10 * k + i) as f32);
            let samples = if is_half {
                FlatSamples::F16(values.map(f16::from_f32).collect())
            } else {
                FlatSamples::F32(values.collect())
            };
            AnyChannel::new(Text::from(*name), samples)
        });
        let layer = Layer::new(
            (4, 2),
            LayerAttributes::default().with_position(Vec2(at.0, at.1)),
            Encoding::FAST_LOSSLESS,
            AnyChannels::sort(list.collect()),
        );
        let mut image = Image::from_layer(layer);
        image.attributes = ImageAttributes::new(display);
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    fn window(x: i32, y: i32, width: usize, height: usize) -> IntegerBounds {
        IntegerBounds::new((x, y), (width, height))
    }

    fn read(bytes: &[u8], name: Option<&str>) -> Result<(usize, StoredRadiances), DecodeError> {
        let file = File::open(Cursor::new(bytes), bytes.len() as u64)?;
        let layer = file.layer(name)?;
        let width = file.width;
        let mut pictures = file.read(&[layer], &mut Share::default())?;
        Ok((width, pictures.pop().unwrap()))
    }

    /// Numbers of the pixels in red, −1 where it is black.
    fn reds((width, picture): &(usize, StoredRadiances)) -> Vec<Vec<i32>> {
        let numbers: Vec<i32> = picture
            .iter()
            .map(|c| if c == Rgb::BLACK { -1 } else { c.r as i32 - 20 })
            .collect();
        numbers.chunks(*width).map(<[i32]>::to_vec).collect()
    }

    #[test]
    fn the_data_window_is_placed_in_the_display_window() {
        for is_half in [false, true] {
            // Channel by channel, as sorted: B, G, R.
            let place = |at, display| {
                let bytes = file(at, display, &["B", "G", "R"], is_half);
                reds(&read(&bytes, None).unwrap())
            };
            let whole = [vec![0, 1, 2, 3], vec![4, 5, 6, 7]];
            assert_eq!(place((0, 0), window(0, 0, 4, 2)), whole);
            assert_eq!(place((-7, 100), window(-7, 100, 4, 2)), whole);
            let cropped = place((1, 1), window(0, 0, 6, 4));
            assert_eq!(cropped[0], [-1; 6]);
            assert_eq!(cropped[1], [-1, 0, 1, 2, 3, -1]);
            assert_eq!(cropped[2], [-1, 4, 5, 6, 7, -1]);
            assert_eq!(cropped[3], [-1; 6]);
            let overscan = place((-1, -1), window(0, 0, 2, 1));
            assert_eq!(overscan, [[5, 6]]);
            let shifted = place((-2, 1), window(0, 0, 3, 3));
            assert_eq!(shifted, [[-1, -1, -1], [2, 3, -1], [6, 7, -1]]);
        }
        let beside = file((4, 0), window(0, 0, 4, 2), &["B", "G", "R"], false);
        assert!(
            read(&beside, None)
                .unwrap_err()
                .to_string()
                .contains("beside")
        );
    }

    #[test]
    fn layers_are_read_by_name_or_listed() {
        let display = window(0, 0, 4, 2);
        let grey = file((0, 0), display, &["Y"], false);
        assert_eq!(read(&grey, None).unwrap().1.get(3), Rgb::splat(3.0));
        let only = file((0, 0), display, &["sky.B", "sky.G", "sky.R"], true);
        let (_, half) = read(&only, None).unwrap();
        assert!(matches!(half, StoredRadiances::Half(_)));
        assert_eq!(half.get(1), Rgb::new(21.0, 11.0, 1.0));
        let names = ["a.B", "a.G", "a.R", "b.B", "b.G", "b.R", "depth.Z"];
        let several = file((0, 0), display, &names, false);
        assert_eq!(read(&several, Some("b")).unwrap().1.get(0).r, 50.0);
        assert_eq!(read(&several, Some("depth")).unwrap().1.get(1).g, 61.0);
        for name in [None, Some("c")] {
            let error = read(&several, name).unwrap_err().to_string();
            assert!(error.contains("there are a, b, depth"), "{error}");
        }
        let usual = ["beauty.B", "beauty.G", "beauty.R", "a.R", "a.G", "a.B"];
        let mut usual = usual.to_vec();
        usual.sort_unstable();
        let bytes = file((0, 0), display, &usual, false);
        assert_eq!(read(&bytes, None).unwrap().1.get(0).r, 50.0);
        let mut chroma = file((0, 0), display, &["BY", "RY", "Y"], false);
        let list = chroma.windows(6).position(|w| w == b"chlist").unwrap();
        chroma[list + 7 + 4 + 3 + 8] = 2;
        let error = read(&chroma, None).unwrap_err().to_string();
        assert!(error.contains("channels are BY, RY, Y"), "{error}");
        let none = file((0, 0), display, &["Z"], false);
        assert!(read(&none, None).is_err());
        assert!(read(b"\x76\x2f\x31\x01 and nothing", None).is_err());
    }
}
