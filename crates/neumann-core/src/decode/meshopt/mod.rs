//! meshopt streams: numbers of bufferViews, packed by the likeness of neighbours.
//!
//! The formats are those of the glTF extensions `KHR_meshopt_compression` and
//! `EXT_meshopt_compression`, of which the former holds the latter: its appendices A and B are the
//! source of every rule here.
//!
//! | file | what it decodes |
//! |---|---|
//! | `attributes` | elements of any kind, as differences of their bytes, words or bits |
//! | `triangles` | corners of triangles that share edges |
//! | `indices` | other indices |
//! | `filter` | what attributes stand for: directions, rotations, floats, colours |

mod attributes;
mod filter;
mod indices;
mod triangles;

use std::fmt::Display;

use super::DecodeError;
use crate::memory;

/// How a stream is packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Elements of any kind.
    Attributes,
    /// Indices, three to a triangle.
    Triangles,
    /// Indices of any meaning.
    Indices,
}

/// What is done with attributes after they are unpacked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// Nothing.
    None,
    /// Unit vectors from an octahedron.
    Octahedral,
    /// Unit quaternions from three of their components.
    Quaternion,
    /// Floats from mantissa and exponent.
    Exponential,
    /// Colours from luma and chroma.
    Color,
}

/// What a stream holds.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// How it is packed.
    pub mode: Mode,
    /// What is done afterwards.
    pub filter: Filter,
    /// Number of elements.
    pub count: usize,
    /// Bytes of an element.
    pub stride: usize,
}

impl Mode {
    /// From its name in glTF.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "ATTRIBUTES" => Some(Self::Attributes),
            "TRIANGLES" => Some(Self::Triangles),
            "INDICES" => Some(Self::Indices),
            _ => None,
        }
    }
}

impl Filter {
    /// From its name in glTF.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "NONE" => Some(Self::None),
            "OCTAHEDRAL" => Some(Self::Octahedral),
            "QUATERNION" => Some(Self::Quaternion),
            "EXPONENTIAL" => Some(Self::Exponential),
            "COLOR" => Some(Self::Color),
            _ => None,
        }
    }
}

impl Layout {
    /// Bytes of all elements, if the specification allows such a layout.
    fn n_bytes(&self) -> Result<usize, DecodeError> {
        let stride = self.stride;
        let is_allowed = match (self.mode, self.filter) {
            (Mode::Attributes, Filter::None | Filter::Exponential) => {
                stride.is_multiple_of(4) && (4..=256).contains(&stride)
            }
            (Mode::Attributes, Filter::Octahedral | Filter::Color) => stride == 4 || stride == 8,
            (Mode::Attributes, Filter::Quaternion) => stride == 8,
            (Mode::Triangles | Mode::Indices, Filter::None) => stride == 2 || stride == 4,
            (Mode::Triangles | Mode::Indices, _) => false,
        };
        if !is_allowed {
            return Err(DecodeError::Content(format!(
                "has a byteStride of {stride}, which mode {:?} with filter {:?} does not allow",
                self.mode, self.filter
            )));
        }
        if self.mode == Mode::Triangles && !self.count.is_multiple_of(3) {
            return Err(DecodeError::Content(format!(
                "has a count of {}, which is no multiple of three",
                self.count
            )));
        }
        let n_bytes = self.count.checked_mul(stride);
        n_bytes.ok_or_else(|| DecodeError::Content(format!("has a count of {}", self.count)))
    }
}

/// Unpacks a stream into `layout.count` times `layout.stride` bytes, which the caller has paid for.
///
/// # Errors
/// If the layout is not allowed, or the stream is not exactly one of that layout.
pub fn decode(stream: &[u8], layout: &Layout) -> Result<Vec<u8>, DecodeError> {
    let n_bytes = layout.n_bytes()?;
    let mut elements = memory::filled(0, n_bytes)?;
    match layout.mode {
        Mode::Attributes => attributes::decode(stream, layout.stride, &mut elements)?,
        Mode::Triangles => triangles::decode(stream, layout.stride, &mut elements)?,
        Mode::Indices => indices::decode(stream, layout.stride, &mut elements)?,
    }
    filter::apply(layout.filter, layout.stride, &mut elements);
    Ok(elements)
}

/// What is left of a stream.
#[derive(Clone, Copy, Debug)]
struct Rest<'a>(&'a [u8]);

impl<'a> Rest<'a> {
    /// What lies between the first byte, which must be one of `headers`, and the last `n_tail`
    /// bytes; with that byte and those.
    fn open(
        stream: &'a [u8],
        headers: &[u8],
        n_tail: impl Fn(u8) -> usize,
    ) -> Result<(Self, u8, &'a [u8]), DecodeError> {
        let (&header, rest) = stream.split_first().ok_or_else(too_short)?;
        if !headers.contains(&header) {
            return Err(DecodeError::broken(format_args!(
                "its first byte is {header:#04x}, not {:#04x}",
                headers[0]
            )));
        }
        let n_data = rest.len().checked_sub(n_tail(header));
        let (data, tail) = rest.split_at(n_data.ok_or_else(too_short)?);
        Ok((Self(data), header, tail))
    }

    fn take(&mut self, n: usize) -> Result<&'a [u8], DecodeError> {
        let (taken, rest) = self.0.split_at_checked(n).ok_or_else(too_short)?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, DecodeError> {
        self.take(1).map(|bytes| bytes[0])
    }

    /// Seven bits a byte, the lowest first; the highest bit says that more follow.
    fn varint(&mut self) -> Result<u32, DecodeError> {
        let mut value = 0;
        for k in 0..5 {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f) << (7 * k);
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(broken("a number in it has more than five bytes"))
    }

    fn end(self) -> Result<(), DecodeError> {
        if self.0.is_empty() {
            Ok(())
        } else {
            let n = self.0.len();
            Err(broken(format_args!("{n} bytes of it are left over")))
        }
    }
}

/// Whole numbers with their sign in the lowest bit.
fn signed(code: u32) -> u32 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}

/// Writes one index; of two bytes, the lower half.
fn write_index(element: &mut [u8], index: u32) {
    let n = element.len();
    element.copy_from_slice(&index.to_le_bytes()[..n]);
}

fn too_short() -> DecodeError {
    broken("it ends too early")
}

fn broken(reason: impl Display) -> DecodeError {
    DecodeError::broken(reason)
}

#[cfg(test)]
mod tests;
