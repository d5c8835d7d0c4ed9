//! Reading: any file's pictures, and our own files as checkpoints.
//!
//! Files are not trusted. The header alone is read first; what it asks for must be in
//! proportion to the length of the file before anything of that size is allocated.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use exr::image::read::read;
use exr::meta::MetaData;
use exr::meta::header::{Header, LayerAttributes};
use exr::prelude::{ReadChannels, ReadLayers, SampleType};
use glam::Vec3;
use neumann_core::decode::openexr;
use neumann_core::film::{Features, Film};
use neumann_core::memory::Share;
use neumann_core::radiometry::Rgb;

use super::planes::{floats, interleave};
use super::{Metadata, beside, checksum, spread};
use crate::image_file::open_regular;
use crate::{Image, PictureError};

/// A film as its file keeps it.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    /// The film.
    pub film: Film,
    /// What the camera sees first, if the file has it.
    pub features: Option<Features>,
    /// How the film was made.
    pub metadata: Metadata,
    /// Whether the file has layers of expressions and lights beside it, which are not read.
    pub has_classes: bool,
}

/// True of an OpenEXR file that is twice as wide as high and that neumann did not write: it is more
/// likely a map of a sky than a picture of a scene.
#[must_use]
pub fn is_panorama(path: &Path) -> bool {
    let Ok(file) = open_regular(path) else {
        return false;
    };
    let meta = MetaData::read_from_buffered(BufReader::new(file), false);
    meta.is_ok_and(|meta| {
        meta.headers.first().is_some_and(|header| {
            let is_wide = header.layer_size.x() == 2 * header.layer_size.y();
            is_wide && Metadata::take(&header.own_attributes).is_err()
        })
    })
}

/// Reads how a picture was made, from the header of a file that [`super::write_exr`] wrote.
///
/// # Errors
/// If the file cannot be read, or is not such a file.
pub fn read_metadata(path: &Path) -> Result<Metadata, PictureError> {
    let meta = MetaData::read_from_buffered(BufReader::new(open_regular(path)?), false);
    let meta = meta.map_err(|error| {
        PictureError::content(path, format!("no OpenEXR file, or a broken one: {error}"))
    })?;
    let first = meta.headers.first();
    let found = first.map_or(Err("version"), |header| {
        Metadata::take(&header.own_attributes)
    });
    found.map_err(|name| {
        let what =
            format!("not a film that neumann wrote: it has no proper entry 'neumann.{name}'");
        PictureError::content(path, format!("{what}; render it again"))
    })
}

/// Reads a file that [`super::write_exr`] wrote.
///
/// # Errors
/// If the file cannot be read, is broken, or is not such a file.
pub fn read_exr(path: &Path) -> Result<Checkpoint, PictureError> {
    let mut raw = Raw::read(path)?;
    let odd = |what: &str| {
        PictureError::content(
            path,
            format!("not a film that neumann wrote: {what}; render it again"),
        )
    };
    let metadata = Metadata::take(&raw.attributes)
        .map_err(|name| odd(&format!("its header has no proper entry 'neumann.{name}'")))?;
    if metadata.iterations.count() == 0 {
        return Err(odd("it has no iterations"));
    }
    if !raw.is_full_precision {
        return Err(odd(
            "it has half floats, which are too coarse to go on from",
        ));
    }
    checksum::verify(&raw.attributes, &raw.planes).map_err(|what| {
        let remedy = "the file is damaged; use a copy of it, or render it again";
        PictureError::content(path, format!("{what}: {remedy}"))
    })?;
    if let Some(name) = impossible_plane(&raw.planes) {
        return Err(odd(&format!(
            "its channel '{name}' has values that no film has (not finite, or negative)"
        )));
    }
    let mut layers = Vec::new();
    while let Some(layer) = raw.take_rgb(&format!("T{}", layers.len())) {
        layers.push(layer);
    }
    let missing = |name: &str| odd(&format!("it has no layer '{name}'"));
    layers.push(raw.take_rgb("tail").ok_or_else(|| missing("tail"))?);
    let total = raw.take_rgb("").ok_or_else(|| missing("R, G, B"))?;
    let variance = raw
        .take_rgb("variance")
        .ok_or_else(|| missing("variance"))?;
    let features = raw.take_features();
    let has_classes = beside::has_classes(&raw.attributes);
    let mut film = Film::from_parts(
        (raw.width, raw.height),
        metadata.iterations.count(),
        layers,
        total,
        &variance,
        metadata.n_refused,
    )
    .map_err(|e| odd(&e.to_string()))?;
    spread::restore(&mut film, &raw.attributes).map_err(|e| odd(&e.to_string()))?;
    Ok(Checkpoint {
        film,
        features,
        metadata,
        has_classes,
    })
}

/// The first channel with a value that nothing measured can be.
fn impossible_plane(planes: &BTreeMap<String, Vec<f32>>) -> Option<&str> {
    let is_possible = |name: &str, value: f32| match name {
        // What the camera does not see anything at is infinitely far away.
        "depth.Z" => value >= 0.0,
        "normal.X" | "normal.Y" | "normal.Z" => value.is_finite(),
        _ => value.is_finite() && value >= 0.0,
    };
    planes
        .iter()
        .find(|(name, values)| values.iter().any(|v| !is_possible(name, *v)))
        .map(|(name, _)| name.as_str())
}

/// Reads the pictures of any OpenEXR file: the main one, and layers by name.
///
/// # Errors
/// If the file cannot be read, is broken, has no picture in colour or grey, or does not fit into
/// memory.
pub fn read_layers(path: &Path) -> Result<Image, PictureError> {
    let file = open(path)?;
    let failed = |error| PictureError::decode(path, error);
    let main = file.layer(None).map_err(failed)?;
    let layers = file.layers.clone();
    let (width, height) = (file.width, file.height);
    let mut memory = Share::default();
    let pictures = file.read(&layers, &mut memory).map_err(failed)?;
    let mut image = Image {
        width,
        height,
        ..Image::default()
    };
    for (layer, picture) in layers.into_iter().zip(pictures) {
        let pixels = picture.into_floats(&mut memory);
        let pixels = pixels.map_err(|shortage| PictureError::decode(path, shortage.into()))?;
        if layer == main {
            image.pixels.clone_from(&pixels);
        }
        if !layer.name.is_empty() {
            image.layers.insert(layer.name, pixels);
        }
    }
    Ok(image)
}

/// Reads one picture of any OpenEXR file, by its layer's name, or the main one; `memory` pays.
///
/// # Errors
/// As [`read_layers`], and if there is no such layer; the message lists those that there are.
pub fn read_layer(
    path: &Path,
    name: Option<&str>,
    memory: &mut Share,
) -> Result<Image, PictureError> {
    let file = open(path)?;
    let failed = |error| PictureError::decode(path, error);
    let layer = file.layer(name).map_err(failed)?;
    let (width, height) = (file.width, file.height);
    let mut pixels = Vec::new();
    for picture in file.read(&[layer], memory).map_err(failed)? {
        let floats = picture.into_floats(memory);
        pixels = floats.map_err(|shortage| PictureError::decode(path, shortage.into()))?;
    }
    Ok(Image {
        width,
        height,
        pixels,
        layers: BTreeMap::new(),
    })
}

fn open(path: &Path) -> Result<openexr::File<BufReader<std::fs::File>>, PictureError> {
    let file = open_regular(path)?;
    let metadata = file
        .metadata()
        .map_err(|e| PictureError::io(path, "read", e))?;
    let reader = BufReader::with_capacity(1 << 18, file);
    openexr::File::open(reader, metadata.len()).map_err(|e| PictureError::decode(path, e))
}

/// All channels of the first part and of those of the same size, by full name: a film.
struct Raw {
    width: usize,
    height: usize,
    attributes: LayerAttributes,
    is_full_precision: bool,
    planes: BTreeMap<String, Vec<f32>>,
    /// Pays for the planes and for what is made of them.
    _memory: Share,
}

impl Raw {
    fn read(path: &Path) -> Result<Self, PictureError> {
        let broken = |e: exr::error::Error| match e {
            exr::error::Error::Io(error) => PictureError::io(path, "read", error),
            error => PictureError::content(path, format!("broken OpenEXR file: {error}")),
        };
        let file = open_regular(path)?;
        let length = file
            .metadata()
            .map_err(|e| PictureError::io(path, "read", e))?
            .len();
        let meta = MetaData::read_from_buffered(BufReader::new(file), false).map_err(broken)?;
        let n_bytes =
            check(&meta.headers, length).map_err(|what| PictureError::content(path, what))?;
        let paid = Share::of_process(n_bytes.saturating_mul(2));
        let memory = paid.map_err(|shortage| PictureError::decode(path, shortage.into()))?;
        let file = open_regular(path)?;
        // A bug of the decoder on odd bytes is an error of the file, not the end of the program.
        let decode = || {
            read()
                .no_deep_data()
                .largest_resolution_level()
                .all_channels()
                .all_layers()
                .all_attributes()
                .from_buffered(BufReader::with_capacity(1 << 18, file))
        };
        let image = catch_unwind(AssertUnwindSafe(decode))
            .map_err(|_| PictureError::content(path, "broken OpenEXR file"))?
            .map_err(broken)?;
        let mut parts = image.layer_data.into_iter();
        let first = parts
            .next()
            .ok_or_else(|| PictureError::content(path, "has no picture in it"))?;
        let size = first.size;
        let attributes = first.attributes.clone();
        let mut planes = BTreeMap::new();
        let mut is_full_precision = true;
        for part in std::iter::once(first).chain(parts.filter(|p| p.size == size)) {
            let prefix = part
                .attributes
                .layer_name
                .as_ref()
                .map(|name| format!("{}.", String::from_utf8_lossy(name.as_slice())));
            for channel in part.channel_data.list {
                let name = String::from_utf8_lossy(channel.name.as_slice()).into_owned();
                // Parts often repeat their name in their channels.
                let name = match &prefix {
                    Some(prefix) if !name.starts_with(prefix.as_str()) => {
                        format!("{prefix}{name}")
                    }
                    _ => name,
                };
                is_full_precision &= matches!(channel.sample_data, exr::image::FlatSamples::F32(_));
                planes.entry(name).or_insert(floats(channel.sample_data));
            }
        }
        let n = size.width() * size.height();
        planes.retain(|_, plane| plane.len() == n);
        Ok(Self {
            width: size.width(),
            height: size.height(),
            attributes,
            is_full_precision,
            planes,
            _memory: memory,
        })
    }

    fn take_rgb(&mut self, layer: &str) -> Option<Vec<Rgb>> {
        self.take_three(layer, ["R", "G", "B"], Rgb::new)
    }

    fn take_three<T>(
        &mut self,
        layer: &str,
        channels: [&str; 3],
        make: impl Fn(f32, f32, f32) -> T,
    ) -> Option<Vec<T>> {
        let names = channels.map(|channel| full_name(layer, channel));
        if !names.iter().all(|name| self.planes.contains_key(name)) {
            return None;
        }
        let planes = names.map(|name| self.planes.remove(&name).unwrap_or_default());
        Some(interleave([&planes[0], &planes[1], &planes[2]], make))
    }

    fn take_features(&mut self) -> Option<Features> {
        Some(Features {
            width: self.width,
            albedo: self.take_rgb("albedo")?,
            normal: self.take_three("normal", ["X", "Y", "Z"], Vec3::new)?,
            depth: self.planes.remove("depth.Z")?,
        })
    }
}

fn full_name(layer: &str, channel: &str) -> String {
    if layer.is_empty() {
        channel.to_owned()
    } else {
        format!("{layer}.{channel}")
    }
}

/// Bytes of samples that any file may have, however short it is.
const FREE_BYTES: u128 = 64 << 20;
/// Bytes of samples to each byte of the file: no compression does better than that.
const LARGEST_RATIO: u128 = 1100;
/// Bytes of samples that no file may exceed.
const MOST_BYTES: u128 = 32 << 30;

/// Refuses what a reader cannot take in, and headers that promise more than the file can hold.
///
/// Returns the bytes of samples, single precision.
fn check(headers: &[Header], length: u64) -> Result<u64, String> {
    let (mut bytes, mut n_samples) = (0u128, 0u128);
    for header in headers {
        if header.deep {
            return Err("holds deep data; name a flat picture".to_owned());
        }
        let pixels = header.layer_size.width() as u128 * header.layer_size.height() as u128;
        for channel in &header.channels.list {
            if channel.sampling.width() != 1 || channel.sampling.height() != 1 {
                return Err(
                    "has channels of reduced resolution; name a picture with R, G, B".to_owned(),
                );
            }
            n_samples += pixels;
            bytes += pixels
                * match channel.sample_type {
                    SampleType::F16 => 2,
                    SampleType::F32 | SampleType::U32 => 4,
                };
        }
    }
    let allowed = FREE_BYTES
        .max(u128::from(length) * LARGEST_RATIO)
        .min(MOST_BYTES);
    if bytes > allowed {
        return Err(format!(
            "broken OpenEXR file: its header promises {bytes} bytes of pixels in a file of {length}"
        ));
    }
    Ok(u64::try_from(4 * n_samples).unwrap_or(u64::MAX))
}
