//! Writing.

use std::path::Path;

use exr::image::write::WritableImage;
use exr::image::{AnyChannels, Blocks, Encoding, Layer};
use exr::meta::attribute::LineOrder;
use exr::meta::header::LayerAttributes;
use exr::prelude::Compression;
use neumann_core::film::{Film, Joint, TechniqueFilm, TechniqueImage};
use neumann_core::radiometry::Rgb;

use super::metadata::{PREFIX, text, text_of};
use super::planes::Planes;
use super::{Beside, Metadata, checksum, spread};
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

/// Values that half floats have no room for, written as the largest that they have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clamped {
    /// How many there were.
    pub n_values: usize,
    /// The largest, without its sign.
    pub largest: f32,
}

/// What L and the layers of a film are called, in the order of a file: nothing, `T0`, …, `tail`.
pub(crate) fn layer_names(n_layers: usize) -> impl Iterator<Item = String> {
    let terms = (0..n_layers).map(|k| format!("T{k}"));
    std::iter::once(String::new())
        .chain(terms)
        .chain(std::iter::once("tail".to_owned()))
}

/// The pixels of what has that place among [`layer_names`].
pub(crate) fn layer_of(film: &Film, place: usize) -> Vec<Rgb> {
    match place.checked_sub(1) {
        None => film.total(),
        Some(k) => film.layer(k),
    }
}

/// Writes a film with everything that is needed to go on with its render.
///
/// # Errors
/// If the place cannot be written to.
pub fn write_exr<'a>(
    path: &Path,
    film: &Film,
    beside: impl Into<Beside<'a>>,
    metadata: &Metadata,
) -> Result<(), PictureError> {
    write_exr_as(path, film, beside, metadata, Precision::Full)?;
    Ok(())
}

/// Writes a film with samples of the given precision. Returns which had to be clamped.
///
/// # Errors
/// If the place cannot be written to.
pub fn write_exr_as<'a>(
    path: &Path,
    film: &Film,
    beside: impl Into<Beside<'a>>,
    metadata: &Metadata,
    precision: Precision,
) -> Result<Clamped, PictureError> {
    let mut planes = Planes::new(precision);
    for (i, name) in layer_names(film.n_layers()).enumerate() {
        planes.rgb(&name, &layer_of(film, i));
    }
    let variance: Vec<Rgb> = (0..film.n_pixels())
        .map(|pixel| film.variance_of_mean(pixel))
        .collect();
    planes.rgb("variance", &variance);
    let mut attributes = LayerAttributes::default();
    metadata.put(&mut attributes);
    beside.into().put(&mut planes, &mut attributes);
    if precision == Precision::Full {
        spread::put(&mut attributes, film.spread());
    }
    checksum::put(&mut attributes, &planes.list);
    let clamped = planes.clamped;
    write(path, (film.width(), film.height()), planes, attributes)?;
    Ok(clamped)
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

/// Writes the techniques of a method: `R, G, B` is L at their resolution, `s1t2.R …` what a
/// technique adds to it, `s1t2.raw.R …` what it would be alone, `s1t2.weight.Y` its mean weight,
/// and `rest.R …` longer paths; merges are called `merge-s2t2`. Texts go to the header as
/// attributes `neumann.…`.
///
/// # Errors
/// If the place cannot be written to.
pub fn write_techniques_exr(
    path: &Path,
    film: &TechniqueFilm,
    notes: &[(&str, &str)],
) -> Result<(), PictureError> {
    let mut planes = Planes::new(Precision::Full);
    let mut total = film.rest();
    planes.rgb("rest", &total);
    for strategy in (0..film.n_bounces()).flat_map(|k| film.techniques(k)) {
        let kind = if strategy.joint == Joint::Merge {
            "merge-"
        } else {
            ""
        };
        let name = format!("{kind}s{}t{}", strategy.s, strategy.t);
        let weighted = film.image(strategy, TechniqueImage::Weighted);
        for (sum, value) in total.iter_mut().zip(&weighted) {
            *sum += *value;
        }
        planes.rgb(&name, &weighted);
        let raw = film.image(strategy, TechniqueImage::Raw);
        planes.rgb(&format!("{name}.raw"), &raw);
        let weight = film.image(strategy, TechniqueImage::Weight);
        planes.plane(&format!("{name}.weight"), "Y", &weight, |w| w.g);
    }
    planes.rgb("", &total);
    let mut attributes = LayerAttributes::default();
    for (name, value) in notes {
        let name = text_of(&format!("{PREFIX}{name}"));
        attributes.other.insert(name, text(value));
    }
    write(path, (film.width(), film.height()), planes, attributes)
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
