//! Buffers and the views into them.
//!
//! A buffer that cannot be read is a fault only when something refers to it.

use std::cell::OnceCell;

use super::allowance::Allowance;
use super::container::Container;
use super::error::{EXPORT_AGAIN, Fault};
use super::json::{Document, Item};
use super::meshopt;
use super::source::{Bytes, Source};

/// The bytes of one buffer.
#[derive(Debug)]
enum Buffer<'a> {
    Chunk(&'a [u8]),
    Fetched { bytes: Bytes, length: usize },
}

/// All buffers of a file.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    buffers: Vec<Result<Buffer<'a>, Fault>>,
    /// Views that are packed, each unpacked when something first refers to it.
    unpacked: Vec<OnceCell<Result<Vec<u8>, Fault>>>,
}

/// A stretch of a buffer.
#[derive(Clone, Copy, Debug)]
pub(super) struct View<'a> {
    pub(super) bytes: &'a [u8],
    /// Distance of elements, where it is not just their size.
    pub(super) stride: Option<usize>,
}

impl<'a> Buffers<'a> {
    /// Reads every buffer, in order.
    pub(super) fn read(container: &Container<'a>, source: &mut Source<'_>) -> Self {
        let document = &container.document;
        let buffers = (0..document.count("buffers"))
            .map(|index| {
                let item = document.item("buffers", index)?;
                let chunk = container.binary.filter(|_| index == 0);
                read_buffer(&item, chunk, source)
            })
            .collect();
        let unpacked = vec![OnceCell::new(); document.count("bufferViews")];
        Self { buffers, unpacked }
    }

    /// Bytes of all buffers together.
    pub(super) fn n_bytes(&self) -> u64 {
        self.buffers
            .iter()
            .filter_map(|buffer| buffer.as_ref().ok())
            .map(|buffer| buffer.bytes().len() as u64)
            .sum()
    }

    /// The view that `item.bufferView` refers to, if the field is there.
    ///
    /// `allowance` pays for it if it has to be unpacked.
    pub(super) fn view(
        &self,
        document: &Document,
        item: &Item<'_>,
        allowance: &Allowance,
    ) -> Result<Option<View<'_>>, Fault> {
        let Some(index) = document.reference(item, "bufferView", "bufferViews")? else {
            return Ok(None);
        };
        let view = document.item("bufferViews", index)?;
        let bytes = match meshopt::extension(&view)? {
            None => self.stretch(document, &view)?,
            Some(packed) => {
                let unpack = || {
                    let stream = self.stretch(document, &packed)?;
                    meshopt::unpack(&packed, stream, length(&view)?, allowance)
                };
                let unpacked = self.unpacked[index].get_or_init(unpack);
                unpacked.as_ref().map_err(Fault::clone)?
            }
        };
        // Zero is not allowed, but was once written for "tightly packed".
        let stride = view.index("byteStride")?.filter(|&stride| stride > 0);
        Ok(Some(View { bytes, stride }))
    }

    /// The bytes that `item` names by buffer, offset and length.
    fn stretch(&self, document: &Document, item: &Item<'_>) -> Result<&[u8], Fault> {
        let Some(buffer) = document.reference(item, "buffer", "buffers")? else {
            return Err(Fault::broken(item.path("buffer"), "is missing"));
        };
        let buffer = match &self.buffers[buffer] {
            Ok(buffer) => buffer.bytes(),
            Err(fault) => return Err(fault.clone()),
        };
        let length = length(item)?;
        let offset = item.index("byteOffset")?.unwrap_or(0);
        offset
            .checked_add(length)
            .and_then(|end| buffer.get(offset..end))
            .ok_or_else(|| {
                Fault::broken(
                    item.path("byteLength"),
                    format!(
                        "bytes from {offset}, {length} of them, lie beyond the buffer's {}",
                        buffer.len()
                    ),
                )
            })
    }
}

impl Buffer<'_> {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::Chunk(bytes) => bytes,
            // `read_buffer` has checked the length.
            Self::Fetched { bytes, length } => &bytes[..*length],
        }
    }
}

fn read_buffer<'a>(
    item: &Item<'_>,
    chunk: Option<&'a [u8]>,
    source: &mut Source<'_>,
) -> Result<Buffer<'a>, Fault> {
    let length = length(item)?;
    if meshopt::is_fallback(item)? {
        return Err(Fault::broken(
            item.at(),
            "is a fallback of packed bufferViews, but something else refers to it",
        ));
    }
    let too_short = |found: usize| {
        Fault::broken(
            item.path("byteLength"),
            format!("is {length}, but there are only {found} bytes"),
        )
    };
    if let Some(uri) = item.text("uri")? {
        let bytes = source.fetch(uri, &item.path("uri"))?;
        if bytes.len() < length {
            return Err(too_short(bytes.len()));
        }
        return Ok(Buffer::Fetched { bytes, length });
    }
    match chunk {
        Some(chunk) => chunk
            .get(..length)
            .map(Buffer::Chunk)
            .ok_or_else(|| too_short(chunk.len())),
        None => Err(Fault::new(
            item.path("uri"),
            "is missing, and there is no binary chunk to stand in for it",
            EXPORT_AGAIN,
        )),
    }
}

fn length(item: &Item<'_>) -> Result<usize, Fault> {
    let length = item.index("byteLength")?;
    length.ok_or_else(|| Fault::broken(item.path("byteLength"), "is missing"))
}
