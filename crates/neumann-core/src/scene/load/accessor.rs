//! Typed arrays within buffers (glTF 2.0, 3.6.2).
//!
//! One reader for every component type, normalised or not, packed or
//! interleaved, sparse or without any data. Everything is checked when the
//! accessor is opened; reading an element afterwards cannot fail.

use super::File;
use super::buffer::View;
use super::error::Fault;
use super::json::Item;
use crate::decode::draco::{Attribute, Number};

/// An accessor without data may stand for this many zeros, and no more.
const MOST_ZEROS: usize = 1 << 24;

/// How one number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// An array of vectors, ready to be read.
#[derive(Debug)]
pub(super) struct Accessor<'a> {
    count: usize,
    n_components: usize,
    component: Component,
    is_normalized: bool,
    /// `None` reads as zeros.
    base: Option<Strided<'a>>,
    sparse: Option<Sparse<'a>>,
    at: String,
}

/// Elements at equal distances; long enough for all of them.
#[derive(Clone, Copy, Debug)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// Elements that differ from the base.
#[derive(Debug)]
struct Sparse<'a> {
    /// Strictly increasing.
    indices: Vec<u32>,
    values: Strided<'a>,
}

impl<'a> Accessor<'a> {
    /// Opens the accessor that `item[key]` refers to, if the field is there.
    ///
    /// `kinds` are the values of `type` that the caller can use.
    pub(super) fn open(
        file: &'a File<'_>,
        item: &Item<'_>,
        key: &str,
        kinds: &[&str],
    ) -> Result<Option<Self>, Fault> {
        let Some(index) = file.document.reference(item, key, "accessors")? else {
            return Ok(None);
        };
        let accessor = file.document.item("accessors", index)?;
        Self::read(file, &accessor, &item.path(key), kinds).map(Some)
    }

    fn read(
        file: &'a File<'_>,
        item: &Item<'_>,
        user: &str,
        kinds: &[&str],
    ) -> Result<Self, Fault> {
        let component = component_type(item)?;
        let kind = item.text("type")?.unwrap_or("");
        if !kinds.contains(&kind) {
            return Err(Fault::broken(
                item.path("type"),
                format!(
                    "is \"{}\", but {user} needs {}",
                    kind.chars().take(20).collect::<String>(),
                    kinds.join(" or ")
                ),
            ));
        }
        let n_components = match kind {
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => 1,
        };
        let Some(count) = item.index("count")? else {
            return Err(Fault::broken(item.path("count"), "is missing"));
        };
        let element = n_components * component.size();
        let base = match file.buffers.view(&file.document, item, &file.allowance)? {
            Some(view) => Some(strided(item, view, count, element)?),
            None => None,
        };
        if base.is_none() && count > MOST_ZEROS {
            return Err(Fault::broken(
                item.path("count"),
                format!(
                    "is {count}, but there is no bufferView, and at most {MOST_ZEROS} zeros are \
                     made up"
                ),
            ));
        }
        let sparse = match item.child("sparse")? {
            Some(sparse) => Some(open_sparse(file, &sparse, count, element)?),
            None => None,
        };
        Ok(Self {
            count,
            n_components,
            component,
            is_normalized: item.flag("normalized")?.unwrap_or(false),
            base,
            sparse,
            at: item.at().to_owned(),
        })
    }

    /// The same, with the elements that a Draco stream has for it.
    pub(super) fn over(mut self, attribute: &'a Attribute, count: usize) -> Result<Self, Fault> {
        let n_components = attribute.n_components;
        if n_components != self.n_components {
            return Err(Fault::broken(
                format!("{}.type", self.at),
                format!(
                    "stands for {} numbers, but the Draco stream has {n_components}",
                    self.n_components
                ),
            ));
        }
        self.component = match attribute.number {
            Number::I8 => Component::I8,
            Number::U8 => Component::U8,
            Number::I16 => Component::I16,
            Number::U16 => Component::U16,
            Number::U32 => Component::U32,
            Number::F32 => Component::F32,
        };
        self.count = count;
        self.base = Some(Strided {
            bytes: &attribute.bytes,
            stride: n_components * self.component.size(),
        });
        self.sparse = None;
        Ok(self)
    }

    /// Number of elements.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Numbers in each element.
    pub(super) fn n_components(&self) -> usize {
        self.n_components
    }

    /// Where the accessor stands in the file.
    pub(super) fn at(&self) -> &str {
        &self.at
    }

    /// Takes integers for fractions of their largest value, said or unsaid.
    pub(super) fn normalized(mut self) -> Self {
        self.is_normalized = true;
        self
    }

    /// Fails unless the numbers are unsigned integers.
    pub(super) fn unsigned(self) -> Result<Self, Fault> {
        match self.component {
            Component::U8 | Component::U16 | Component::U32 => Ok(self),
            _ => Err(Fault::broken(
                format!("{}.componentType", self.at),
                "is not an unsigned integer type, as indices are",
            )),
        }
    }

    /// Element `index` as floats; components beyond the element's are zero.
    pub(super) fn floats<const N: usize>(&self, index: usize) -> [f32; N] {
        let mut floats = [0.0; N];
        let element = self.element(index);
        for (k, float) in floats.iter_mut().enumerate().take(self.n_components) {
            *float = self.float(element, k);
        }
        floats
    }

    /// Element `index` as unsigned integers, after [`Self::unsigned`].
    pub(super) fn integers<const N: usize>(&self, index: usize) -> [u32; N] {
        let mut integers = [0; N];
        let element = self.element(index);
        for (k, integer) in integers.iter_mut().enumerate().take(self.n_components) {
            *integer = self.component.unsigned(element, k);
        }
        integers
    }

    /// The bytes of an element; empty stands for zeros.
    fn element(&self, index: usize) -> &'a [u8] {
        if let Some(sparse) = &self.sparse
            && let Ok(key) = u32::try_from(index)
            && let Ok(k) = sparse.indices.binary_search(&key)
        {
            return sparse.values.from(k);
        }
        self.base.map_or(&[], |base| base.from(index))
    }

    fn float(&self, element: &[u8], k: usize) -> f32 {
        let value = self.component.float(element, k);
        if !self.is_normalized {
            return value;
        }
        match self.component {
            Component::I8 => (value / 127.0).max(-1.0),
            Component::U8 => value / 255.0,
            Component::I16 => (value / 32767.0).max(-1.0),
            Component::U16 => value / 65535.0,
            Component::U32 | Component::F32 => value,
        }
    }
}

impl<'a> Strided<'a> {
    fn from(self, index: usize) -> &'a [u8] {
        self.bytes.get(index * self.stride..).unwrap_or(&[])
    }
}

impl Component {
    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    fn float(self, element: &[u8], k: usize) -> f32 {
        match self {
            Self::I8 => f32::from(at::<1>(element, k)[0] as i8),
            Self::U8 => f32::from(at::<1>(element, k)[0]),
            Self::I16 => f32::from(i16::from_le_bytes(at(element, k))),
            Self::U16 => f32::from(u16::from_le_bytes(at(element, k))),
            Self::U32 => u32::from_le_bytes(at(element, k)) as f32,
            Self::F32 => f32::from_le_bytes(at(element, k)),
        }
    }

    fn unsigned(self, element: &[u8], k: usize) -> u32 {
        match self {
            Self::U8 => u32::from(at::<1>(element, k)[0]),
            Self::U16 => u32::from(u16::from_le_bytes(at(element, k))),
            Self::U32 => u32::from_le_bytes(at(element, k)),
            Self::I8 | Self::I16 | Self::F32 => 0,
        }
    }
}

/// Bytes of component `k`; zeros past the end, which is how absent data reads.
fn at<const SIZE: usize>(element: &[u8], k: usize) -> [u8; SIZE] {
    element
        .get(k * SIZE..)
        .and_then(|rest| rest.first_chunk())
        .copied()
        .unwrap_or([0; SIZE])
}

fn component_type(item: &Item<'_>) -> Result<Component, Fault> {
    match item.index("componentType")? {
        Some(5120) => Ok(Component::I8),
        Some(5121) => Ok(Component::U8),
        Some(5122) => Ok(Component::I16),
        Some(5123) => Ok(Component::U16),
        Some(5125) => Ok(Component::U32),
        Some(5126) => Ok(Component::F32),
        Some(other) => Err(Fault::broken(
            item.path("componentType"),
            format!("is {other}, which glTF does not know"),
        )),
        None => Err(Fault::broken(item.path("componentType"), "is missing")),
    }
}

/// Checks that `count` elements of `element` bytes lie within the view.
fn strided<'a>(
    item: &Item<'_>,
    view: View<'a>,
    count: usize,
    element: usize,
) -> Result<Strided<'a>, Fault> {
    let stride = view.stride.unwrap_or(element);
    if stride < element {
        return Err(Fault::broken(
            item.path("bufferView"),
            format!("has a byteStride of {stride}, but one element takes {element} bytes"),
        ));
    }
    let offset = item.index("byteOffset")?.unwrap_or(0);
    let needed = match count.checked_sub(1) {
        None => Some(0),
        Some(last) => last
            .checked_mul(stride)
            .and_then(|n| n.checked_add(element))
            .and_then(|n| n.checked_add(offset)),
    };
    match (needed, view.bytes.get(offset..)) {
        (Some(needed), Some(bytes)) if needed <= view.bytes.len() => Ok(Strided { bytes, stride }),
        _ => Err(Fault::broken(
            item.path("count"),
            format!(
                "is {count}, but that many elements do not fit into the {} bytes of the bufferView",
                view.bytes.len()
            ),
        )),
    }
}

fn open_sparse<'a>(
    file: &'a File<'_>,
    sparse: &Item<'_>,
    count: usize,
    element: usize,
) -> Result<Sparse<'a>, Fault> {
    let missing = |field: String| Fault::broken(field, "is missing");
    let part = |key: &str| -> Result<(Item<'_>, View<'a>), Fault> {
        let item = sparse
            .child(key)?
            .ok_or_else(|| missing(sparse.path(key)))?;
        let view = file
            .buffers
            .view(&file.document, &item, &file.allowance)?
            .ok_or_else(|| missing(item.path("bufferView")))?;
        Ok((item, view))
    };
    let Some(n_sparse) = sparse.index("count")? else {
        return Err(missing(sparse.path("count")));
    };
    if n_sparse > count {
        return Err(Fault::broken(
            sparse.path("count"),
            format!("is {n_sparse}, more than the accessor's {count}"),
        ));
    }
    let (item, view) = part("indices")?;
    let component = component_type(&item)?;
    if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
        return Err(Fault::broken(
            item.path("componentType"),
            "is not an unsigned integer type, as indices are",
        ));
    }
    let stored = strided(&item, view, n_sparse, component.size())?;
    file.allowance
        .spend(n_sparse, size_of::<u32>(), sparse.at())?;
    let indices: Vec<u32> = (0..n_sparse)
        .map(|k| component.unsigned(stored.from(k), 0))
        .collect();
    let is_increasing = indices.windows(2).all(|pair| pair[0] < pair[1]);
    if !is_increasing || indices.last().is_some_and(|&last| last as usize >= count) {
        return Err(Fault::broken(
            item.at(),
            format!("do not increase strictly or reach beyond the accessor's count of {count}"),
        ));
    }
    let (item, view) = part("values")?;
    let values = strided(&item, view, n_sparse, element)?;
    Ok(Sparse { indices, values })
}
