//! What a render needs to go on with the same bits, and no viewer shows.
//!
//! `neumann.deviations` holds the sums of squared deviations of L, R G B of every pixel row by row,
//! as floats of 32 bits, lowest byte first; `neumann.batchMeans` what the variance of the mean is
//! estimated from. Files without them, which earlier versions wrote, go on from `variance.*`.

use exr::meta::attribute::AttributeValue;
use exr::meta::header::LayerAttributes;
use neumann_core::film::{Film, FilmError, Spread};
use neumann_core::radiometry::Rgb;

use super::metadata::{PREFIX, text_of};

const DEVIATIONS: &str = "deviations";
const BATCH_MEANS: &str = "batchMeans";

/// Adds it to a header, as far as an attribute has room for it.
pub(super) fn put(attributes: &mut LayerAttributes, spread: Spread) {
    let channels = spread.deviations.iter().flat_map(|d| d.to_array());
    let deviations: Vec<u8> = channels.flat_map(f32::to_le_bytes).collect();
    // Neither is of use alone.
    if i32::try_from(deviations.len().max(spread.batch_means.len())).is_err() {
        return;
    }
    let entries = [(DEVIATIONS, deviations), (BATCH_MEANS, spread.batch_means)];
    for (name, bytes) in entries {
        let value = AttributeValue::Bytes {
            type_hint: text_of(name),
            bytes: bytes.into(),
        };
        let name = text_of(&format!("{PREFIX}{name}"));
        attributes.other.insert(name, value);
    }
}

/// Gives it to a film, if the header has it.
///
/// # Errors
/// If it cannot be that of the film.
pub(super) fn restore(film: &mut Film, attributes: &LayerAttributes) -> Result<(), FilmError> {
    let bytes = |name| match attributes.other.get(&text_of(&format!("{PREFIX}{name}"))) {
        Some(AttributeValue::Bytes { bytes, .. }) => Some(bytes.as_slice()),
        _ => None,
    };
    let (Some(deviations), Some(batch_means)) = (bytes(DEVIATIONS), bytes(BATCH_MEANS)) else {
        return Ok(());
    };
    let (floats, rest) = deviations.as_chunks::<4>();
    let (pixels, more) = floats.as_chunks::<3>();
    if !rest.is_empty() || !more.is_empty() {
        return Err(FilmError::Spread);
    }
    let deviations = pixels
        .iter()
        .map(|pixel| Rgb::from(pixel.map(f32::from_le_bytes)));
    film.set_spread(&Spread {
        deviations: deviations.collect(),
        batch_means: batch_means.to_vec(),
    })
}
