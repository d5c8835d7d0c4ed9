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
use neumann_core::film::{Features, Film};
use neumann_core::radiometry::Rgb;

use super::Metadata;
use super::planes::{floats, interleave};
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
    if !raw.is_full_precision {
        return Err(odd(
            "it has half floats, which are too coarse to go on from",
        ));
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
    let film = Film::from_parts(
        (raw.width, raw.height),
        metadata.iterations.count(),
        layers,
        total,
        &variance,
        metadata.n_refused,
    )
    .map_err(|e| odd(&e.to_string()))?;
    Ok(Checkpoint {
        film,
        features,
        metadata,
    })
}

/// Reads the pictures of any OpenEXR file: the main one, and layers by name.
///
/// # Errors
/// If the file cannot be read, is broken, or has no picture in colour or grey.
pub fn read_layers(path: &Path) -> Result<Image, PictureError> {
    let mut raw = Raw::read(path)?;
    let names: Vec<String> = raw
        .planes
        .keys()
        .filter_map(|name| name.rsplit_once('.').map(|(layer, _)| layer.to_owned()))
        .collect();
    let main = raw.take_rgb("").or_else(|| raw.take_grey(""));
    let mut layers = BTreeMap::new();
    for name in names {
        let pixels = raw
            .take_rgb(&name)
            .or_else(|| raw.take_xyz(&name))
            .or_else(|| raw.take_grey(&name));
        if let Some(pixels) = pixels {
            layers.insert(name, pixels);
        }
    }
    // A picture in parts may keep its colours in the first one, under a name.
    let main = main.or_else(|| {
        ["rgba", "rgb", "beauty", "color", "combined"]
            .iter()
            .find_map(|usual| {
                let is_usual =
                    |(name, _): &(&String, &Vec<Rgb>)| name.to_lowercase().contains(usual);
                layers.iter().find(is_usual).map(|(_, p)| p.clone())
            })
            .or_else(|| layers.values().next().cloned())
    });
    let Some(pixels) = main else {
        return Err(PictureError::content(
            path,
            "has neither channels R, G, B nor Y; name a picture",
        ));
    };
    Ok(Image {
        width: raw.width,
        height: raw.height,
        pixels,
        layers,
    })
}

/// All channels of the first part and of those of the same size, by full name.
struct Raw {
    width: usize,
    height: usize,
    attributes: LayerAttributes,
    is_full_precision: bool,
    planes: BTreeMap<String, Vec<f32>>,
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
        check(&meta.headers, length).map_err(|what| PictureError::content(path, what))?;
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
        })
    }

    fn take_rgb(&mut self, layer: &str) -> Option<Vec<Rgb>> {
        self.take_three(layer, ["R", "G", "B"], Rgb::new)
    }

    fn take_xyz(&mut self, layer: &str) -> Option<Vec<Rgb>> {
        self.take_three(layer, ["X", "Y", "Z"], Rgb::new)
    }

    fn take_grey(&mut self, layer: &str) -> Option<Vec<Rgb>> {
        let plane = ["Y", "Z", "V"]
            .iter()
            .find_map(|channel| self.planes.remove(&full_name(layer, channel)))?;
        Some(plane.into_iter().map(Rgb::splat).collect())
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
fn check(headers: &[Header], length: u64) -> Result<(), String> {
    let mut bytes = 0u128;
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
    Ok(())
}
