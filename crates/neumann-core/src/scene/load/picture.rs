//! Images of textures: PNG, JPEG and WebP, decoded in parallel.
//!
//! Only images that a used material refers to are fetched and decoded. A
//! missing or broken image costs its textures and a warning, not the scene;
//! one for which there is no memory costs the scene, since its picture would
//! otherwise depend on the machine; so does one for which there is no decoder.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::File;
use super::error::{Fault, quoted};
use super::material;
use super::notes::Notes;
use super::source::{Bytes, Source};
use crate::decode::{DecodeError, bitmap};
use crate::memory::{Share, Shortage};
use crate::scene::description::{ImageDescription, MaterialDescription};

/// Wider or higher images are refused.
pub(super) const LARGEST_SIDE: u32 = 16384;

/// Bytes of an image that wait to be decoded.
enum Encoded<'a> {
    Fetched(Bytes),
    View(&'a [u8]),
}

/// An image that is paid for.
struct Wanted<'a> {
    name: String,
    bytes: Encoded<'a>,
    memory: Share,
}

/// Decodes the images of the used materials and lets their textures refer to
/// them; other materials lose their textures.
pub(super) fn read(
    file: &File<'_>,
    source: &mut Source<'_>,
    materials: &mut [MaterialDescription],
    is_used: &[bool],
    notes: &mut Notes,
) -> Result<Vec<ImageDescription>, Fault> {
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

    // Fetching and paying are sequential, so that hash and errors do not depend on threads.
    let mut working = Working::default();
    let mut encoded = Vec::with_capacity(wanted.len());
    for &index in &wanted {
        encoded.push(fetch(file, source, index, &mut working)?);
    }
    let decoded: Vec<Result<ImageDescription, DecodeError>> = encoded
        .into_par_iter()
        .map(|wanted| {
            let Wanted {
                name,
                bytes,
                memory,
            } = wanted?;
            let bitmap = bitmap::decode(&bytes, memory)?;
            Ok(ImageDescription {
                name,
                width: bitmap.width,
                height: bitmap.height,
                texels: bitmap.texels,
            })
        })
        .collect();
    drop(working);

    let mut images = Vec::new();
    let mut image_from_file_index = BTreeMap::new();
    for (index, result) in wanted.into_iter().zip(decoded) {
        match result {
            Ok(image) => {
                image_from_file_index.insert(index, images.len());
                images.push(image);
            }
            Err(DecodeError::Content(problem)) => notes.warn(format!(
                "image {}: {problem}; its textures are left out",
                quoted(&image_name(file, index)),
            )),
            Err(error) => {
                let name = quoted(&image_name(file, index));
                return Err(Fault::undecoded(
                    format!("images[{index}]"),
                    &name,
                    error,
                    "",
                ));
            }
        }
    }
    for texture in materials.iter_mut().flat_map(material::textures) {
        *texture = texture.and_then(|mut found| {
            found.image = *image_from_file_index.get(&found.image)?;
            Some(found)
        });
    }
    Ok(images)
}

/// What the decoders that run at one time take beside the texels: as many as there are threads,
/// of which any may be the largest.
#[derive(Default)]
struct Working {
    largest: BinaryHeap<Reverse<u64>>,
    memory: Share,
}

impl Working {
    fn add(&mut self, n_bytes: u64) -> Result<(), Shortage> {
        let replaced = if self.largest.len() < rayon::current_num_threads() {
            0
        } else {
            self.largest.peek().map_or(0, |least| least.0)
        };
        if n_bytes > replaced {
            self.memory.grow(n_bytes - replaced)?;
            if replaced > 0 {
                self.largest.pop();
            }
            self.largest.push(Reverse(n_bytes));
        }
        Ok(())
    }
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

/// The bytes of an image of the file, with memory for its texels.
///
/// The inner error costs the image, the outer one the scene.
fn fetch<'a>(
    file: &'a File<'_>,
    source: &mut Source<'_>,
    index: usize,
    working: &mut Working,
) -> Result<Result<Wanted<'a>, DecodeError>, Fault> {
    let encoded = match encoded(file, source, index) {
        Ok(encoded) => encoded,
        Err(fault) => return Ok(Err(DecodeError::Content(fault.what()))),
    };
    let header = match bitmap::header(&encoded) {
        Ok(header) => header,
        Err(error) => return Ok(Err(error)),
    };
    let (width, height) = (header.width, header.height);
    let size = format!("is {width} by {height}");
    if width.max(height) > LARGEST_SIDE as usize {
        let problem = format!("{size}; at most {LARGEST_SIDE} each way are read");
        return Ok(Err(DecodeError::Content(problem)));
    }
    let memory = Share::of_process(header.n_bytes)
        .and_then(|memory| working.add(header.n_working_bytes).map(|()| memory))
        .map_err(|shortage| too_large(file, index, &format!("{size} and "), &shortage))?;
    Ok(Ok(Wanted {
        name: image_name(file, index),
        bytes: encoded,
        memory,
    }))
}

fn too_large(file: &File<'_>, index: usize, size: &str, shortage: &Shortage) -> Fault {
    let name = quoted(&image_name(file, index));
    let what = format!("{name} {size}");
    Fault::short(format!("images[{index}]"), what.trim_end(), *shortage)
}

/// The bytes of an image of the file, from a URI or a buffer.
fn encoded<'a>(
    file: &'a File<'_>,
    source: &mut Source<'_>,
    index: usize,
) -> Result<Encoded<'a>, Fault> {
    let item = file.document.item("images", index)?;
    match item.text("uri")? {
        Some(uri) => Ok(Encoded::Fetched(source.fetch(uri, &item.path("uri"))?)),
        None => match file.buffers.view(&file.document, &item, &file.allowance)? {
            Some(view) => Ok(Encoded::View(view.bytes)),
            None => Err(Fault::broken(item.at(), "has neither uri nor bufferView")),
        },
    }
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
