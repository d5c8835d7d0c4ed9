//! Buffers and the views into them.
//!
//! A buffer that cannot be read is a fault only when something refers to it.

use super::container::Container;
use super::error::{EXPORT_AGAIN, Fault};
use super::json::{Document, Item};
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
        Self { buffers }
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
    pub(super) fn view(
        &self,
        document: &Document,
        item: &Item<'_>,
    ) -> Result<Option<View<'_>>, Fault> {
        let Some(index) = document.reference(item, "bufferView", "bufferViews")? else {
            return Ok(None);
        };
        let view = document.item("bufferViews", index)?;
        let Some(buffer) = document.reference(&view, "buffer", "buffers")? else {
            return Err(Fault::broken(view.path("buffer"), "is missing"));
        };
        let buffer = match &self.buffers[buffer] {
            Ok(buffer) => buffer.bytes(),
            Err(fault) => return Err(with_compression_named(fault, &view)),
        };
        let Some(length) = view.index("byteLength")? else {
            return Err(Fault::broken(view.path("byteLength"), "is missing"));
        };
        let offset = view.index("byteOffset")?.unwrap_or(0);
        let bytes = offset
            .checked_add(length)
            .and_then(|end| buffer.get(offset..end))
            .ok_or_else(|| {
                Fault::broken(
                    view.path("byteLength"),
                    format!(
                        "bytes from {offset}, {length} of them, lie beyond the buffer's {}",
                        buffer.len()
                    ),
                )
            })?;
        // Zero is not allowed, but was once written for "tightly packed".
        let stride = view.index("byteStride")?.filter(|&stride| stride > 0);
        Ok(Some(View { bytes, stride }))
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
    let Some(length) = item.index("byteLength")? else {
        return Err(Fault::broken(item.path("byteLength"), "is missing"));
    };
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

/// Compressed views may name a fallback buffer that is not there.
fn with_compression_named(fault: &Fault, view: &Item<'_>) -> Fault {
    let extensions = view.child_if_object("extensions");
    let name = ["EXT_meshopt_compression", "KHR_meshopt_compression"]
        .into_iter()
        .find(|name| extensions.as_ref().is_some_and(|e| e.has(name)));
    match name {
        Some(name) => Fault::new(
            view.at(),
            format!("is compressed with {name}, which cannot be read, and has no fallback"),
            "store the scene without mesh compression (gltfpack without -c, gltf-transform)",
        ),
        None => fault.clone(),
    }
}
