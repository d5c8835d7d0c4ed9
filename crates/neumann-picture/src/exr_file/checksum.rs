//! Whether a checkpoint is what was written: a hash of every channel, and one of the header.
//!
//! `neumann.checksums` lists the channels as `T0.R=0123456789abcdef`; its entry `header` is of all
//! other attributes `neumann.…`. Hashes are FNV-1a of 64 bits, word by word: one changed word
//! always
//! changes them. They find what disks and networks do to a file, not forgery. Files without the
//! attribute, which earlier versions wrote, are taken as they are.

use std::collections::BTreeMap;

use exr::image::{AnyChannel, FlatSamples};
use exr::meta::attribute::AttributeValue;
use exr::meta::header::LayerAttributes;

use super::metadata::{PREFIX, fnv1a, text, text_of};

/// The attribute.
const NAME: &str = "neumann.checksums";
/// The entry of the header.
const HEADER: &str = "header";

/// Adds the hashes of the channels and of the attributes so far.
pub(super) fn put(attributes: &mut LayerAttributes, channels: &[AnyChannel<FlatSamples>]) {
    let mut entries: Vec<String> = channels
        .iter()
        .filter_map(|channel| match &channel.sample_data {
            FlatSamples::F32(values) => {
                let name = String::from_utf8_lossy(channel.name.as_slice());
                Some(format!("{name}={:016x}", of_plane(values)))
            }
            _ => None,
        })
        .collect();
    entries.push(format!("{HEADER}={:016x}", of_header(attributes)));
    let entries = text(&entries.join(" "));
    attributes.other.insert(text_of(NAME), entries);
}

/// Finds what is not as it was written, if the file has hashes.
///
/// # Errors
/// What is damaged, in words.
pub(super) fn verify(
    attributes: &LayerAttributes,
    planes: &BTreeMap<String, Vec<f32>>,
) -> Result<(), String> {
    let Some(entries) = attributes.other.get(&text_of(NAME)) else {
        return Ok(());
    };
    let AttributeValue::Text(entries) = entries else {
        return Err(format!("its header entry '{NAME}' is no text"));
    };
    let entries = String::from_utf8_lossy(entries.as_slice()).into_owned();
    let mut n_planes = 0;
    let mut has_header = false;
    for entry in entries.split_whitespace() {
        let (name, hash) = entry.split_once('=').unwrap_or((entry, ""));
        let found = if name == HEADER {
            has_header = true;
            of_header(attributes)
        } else {
            n_planes += 1;
            let plane = planes.get(name);
            of_plane(plane.ok_or_else(|| format!("its channel '{name}' is missing"))?)
        };
        if u64::from_str_radix(hash, 16) != Ok(found) {
            let what = if name == HEADER {
                "its header".to_owned()
            } else {
                format!("its channel '{name}'")
            };
            return Err(format!("{what} is not what was written (checksum)"));
        }
    }
    if !has_header || n_planes != planes.len() {
        return Err(format!("'{NAME}' does not cover all of it"));
    }
    Ok(())
}

fn of_plane(values: &[f32]) -> u64 {
    fnv1a(values.iter().map(|value| value.to_bits()))
}

/// Of our own attributes, in the order of their names.
fn of_header(attributes: &LayerAttributes) -> u64 {
    let mut entries: Vec<(Vec<u8>, Vec<u8>)> = attributes
        .other
        .iter()
        .filter(|(name, _)| {
            let name = name.as_slice();
            name != NAME.as_bytes() && name.starts_with(PREFIX.as_bytes())
        })
        .map(|(name, value)| {
            let value = match value {
                AttributeValue::Text(text) => text.as_slice().to_vec(),
                AttributeValue::I32(number) => number.to_le_bytes().to_vec(),
                AttributeValue::F64(number) => number.to_le_bytes().to_vec(),
                AttributeValue::Bytes { bytes, .. } => bytes.to_vec(),
                // Nothing else is written.
                _ => Vec::new(),
            };
            (name.as_slice().to_vec(), value)
        })
        .collect();
    entries.sort();
    let words = entries.iter().flat_map(|(name, value)| {
        let parts = name.iter().chain(b"=").chain(value).chain(b"\n");
        parts.map(|byte| u32::from(*byte))
    });
    fnv1a(words)
}
