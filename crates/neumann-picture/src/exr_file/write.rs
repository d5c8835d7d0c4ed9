//! Writing.

use std::path::Path;

use exr::image::write::WritableImage;
use exr::image::{AnyChannels, Blocks, Encoding, Layer};
use exr::meta::attribute::LineOrder;
use exr::meta::header::LayerAttributes;
use exr::prelude::Compression;
use neumann_core::film::{Features, Film};
use neumann_core::radiometry::Rgb;

use super::Metadata;
use super::metadata::{PREFIX, text, text_of};
use super::planes::Planes;
use crate::PictureError;
use crate::files::write_atomically;

/// How many bits a sample has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32: nothing is lost, and the render can be gone on with.
    #[default]
    Full,
    /// 16: half the size, values up to 65504, three digits.
    Half,
}

/// Writes a film with everything that is needed to go on with its render.
///
/// # Errors
/// If the place cannot be written to.
pub fn write_exr(
    path: &Path,
    film: &Film,
    features: Option<&Features>,
    metadata: &Metadata,
) -> Result<(), PictureError> {
    write_exr_as(path, film, features, metadata, Precision::Full)
}

/// Writes a film with samples of the given precision.
///
/// # Errors
/// If the place cannot be written to.
pub fn write_exr_as(
    path: &Path,
    film: &Film,
    features: Option<&Features>,
    metadata: &Metadata,
    precision: Precision,
) -> Result<(), PictureError> {
    let mut planes = Planes::new(precision);
    planes.rgb("", film.total());
    for (k, layer) in film.layers().iter().enumerate() {
        let name = if k == film.n_layers() {
            "tail".to_owned()
        } else {
            format!("T{k}")
        };
        planes.rgb(&name, layer);
    }
    let variance: Vec<Rgb> = (0..film.total().len())
        .map(|pixel| film.variance_of_mean(pixel))
        .collect();
    planes.rgb("variance", &variance);
    if let Some(features) = features {
        planes.rgb("albedo", &features.albedo);
        planes.xyz("normal", &features.normal);
        planes.plane("depth", "Z", &features.depth, |z| *z);
    }
    let mut attributes = LayerAttributes::default();
    metadata.put(&mut attributes);
    write(path, (film.width(), film.height()), planes, attributes)
}

/// Writes one linear picture with a few texts in its header, as attributes `neumann.…`.
///
/// # Errors
/// If the place cannot be written to.
pub fn write_image_exr(
    path: &Path,
    (width, height): (usize, usize),
    pixels: &[Rgb],
    notes: &[(&str, &str)],
) -> Result<(), PictureError> {
    let mut planes = Planes::new(Precision::Full);
    planes.rgb("", pixels);
    let mut attributes = LayerAttributes::default();
    for (name, value) in notes {
        let name = text_of(&format!("{PREFIX}{name}"));
        attributes.other.insert(name, text(value));
    }
    write(path, (width, height), planes, attributes)
}

fn write(
    path: &Path,
    (width, height): (usize, usize),
    planes: Planes,
    attributes: LayerAttributes,
) -> Result<(), PictureError> {
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let channels = AnyChannels::sort(planes.list.into());
    let layer = Layer::new((width, height), attributes, encoding, channels);
    let image = exr::image::Image::from_layer(layer);
    write_atomically(path, |writer| {
        image.write().to_buffered(writer).map_err(|e| match e {
            exr::error::Error::Io(error) => error.into(),
            error => error.to_string().into(),
        })
    })
}
