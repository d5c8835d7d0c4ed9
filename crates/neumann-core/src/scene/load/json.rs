//! Typed, checked access to the JSON of a glTF file.
//!
//! An [`Item`] is a JSON object that knows where it stands, so that whatever is
//! wrong with one of its fields can be named. Absent fields (and `null`) are
//! `None`; fields of the wrong type are faults. Nothing here panics or recurses.

use std::collections::BTreeSet;

use serde_json::{Map, Value};

use super::error::{EXPORT_AGAIN, Fault};
use crate::memory::Share;

/// More commas and opening brackets than this are refused before parsing. A hundred thousand
/// nodes need a million.
const MOST_VALUES: usize = 1 << 23;

/// What each of them takes once parsed, at most.
const BYTES_PER_VALUE: u64 = 128;

/// The top-level arrays that others refer to by index.
const COLLECTIONS: [&str; 13] = [
    "accessors",
    "animations",
    "buffers",
    "bufferViews",
    "cameras",
    "images",
    "materials",
    "meshes",
    "nodes",
    "samplers",
    "scenes",
    "skins",
    "textures",
];

/// A parsed glTF document.
#[derive(Debug)]
pub(super) struct Document {
    root: Map<String, Value>,
    /// Pays for it.
    _memory: Share,
}

impl Document {
    /// Parses the JSON text; a byte order mark and padding are tolerated.
    pub(super) fn parse(text: &[u8]) -> Result<Self, Fault> {
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        let end = text
            .iter()
            .rposition(|&b| b != 0 && !b.is_ascii_whitespace())
            .map_or(0, |last| last + 1);
        let text = &text[..end];
        if text.is_empty() {
            return Err(Fault::new("", "there is no JSON in it", EXPORT_AGAIN));
        }
        let n_values = text.iter().filter(|b| b",[{".contains(b)).count();
        if n_values > MOST_VALUES {
            return Err(Fault::new(
                "",
                format!("its JSON has more than {MOST_VALUES} values"),
                "keep the data in binary buffers",
            ));
        }
        let memory = Share::of_process(n_values as u64 * BYTES_PER_VALUE)
            .map_err(|shortage| Fault::short("", "its JSON", shortage))?;
        let value: Value = serde_json::from_slice(text).map_err(|error| {
            Fault::new(
                "",
                format!("is not valid JSON: {error}"),
                "a scene is a .gltf or .glb file; if this is one, fetch or export it again",
            )
        })?;
        let Value::Object(root) = value else {
            return Err(Fault::new("", "its JSON is not an object", EXPORT_AGAIN));
        };
        Ok(Self {
            root,
            _memory: memory,
        })
    }

    /// Fails unless every top-level collection is an array, as it is from version 2 on.
    pub(super) fn check_collections(&self) -> Result<(), Fault> {
        for collection in COLLECTIONS {
            if let Some(value) = self.root.get(collection)
                && !value.is_array()
            {
                return Err(Fault::broken(collection, "is not an array"));
            }
        }
        Ok(())
    }

    /// The outermost object.
    pub(super) fn root(&self) -> Item<'_> {
        Item {
            fields: &self.root,
            at: String::new(),
        }
    }

    /// The names of all extensions that any object of the document carries.
    pub(super) fn extensions_in_use(&self) -> BTreeSet<&str> {
        let mut names = BTreeSet::new();
        let mut objects = vec![&self.root];
        let mut arrays: Vec<&Vec<Value>> = Vec::new();
        loop {
            let values: Box<dyn Iterator<Item = &Value>> = if let Some(object) = objects.pop() {
                if let Some(Value::Object(extensions)) = object.get("extensions") {
                    names.extend(extensions.keys().map(String::as_str));
                }
                // Whatever the user keeps in extras is no extension of ours.
                Box::new(
                    object
                        .iter()
                        .filter(|(key, _)| *key != "extras")
                        .map(|(_, v)| v),
                )
            } else if let Some(array) = arrays.pop() {
                Box::new(array.iter())
            } else {
                return names;
            };
            for value in values {
                match value {
                    Value::Object(object) => objects.push(object),
                    Value::Array(array) => arrays.push(array),
                    _ => {}
                }
            }
        }
    }

    /// How many things a top-level array holds.
    pub(super) fn count(&self, collection: &str) -> usize {
        self.array(collection).len()
    }

    /// A thing of a top-level array, as `accessors[3]`.
    pub(super) fn item(&self, collection: &str, index: usize) -> Result<Item<'_>, Fault> {
        let at = format!("{collection}[{index}]");
        match self.array(collection).get(index) {
            Some(Value::Object(fields)) => Ok(Item { fields, at }),
            Some(_) => Err(Fault::broken(at, "is not an object")),
            None => Err(Fault::broken(at, "does not exist")),
        }
    }

    /// The index that `key` of `from` holds, checked against the collection.
    pub(super) fn reference(
        &self,
        from: &Item<'_>,
        key: &str,
        collection: &str,
    ) -> Result<Option<usize>, Fault> {
        let Some(index) = from.index(key)? else {
            return Ok(None);
        };
        self.check(&from.path(key), index, collection).map(Some)
    }

    /// Checks an index into a collection found at `field`.
    pub(super) fn check(
        &self,
        field: &str,
        index: usize,
        collection: &str,
    ) -> Result<usize, Fault> {
        let count = self.count(collection);
        if index < count {
            Ok(index)
        } else {
            Err(Fault::broken(
                field,
                format!("refers to {collection}[{index}], but there are {count} {collection}"),
            ))
        }
    }

    fn array(&self, collection: &str) -> &[Value] {
        self.root
            .get(collection)
            .and_then(Value::as_array)
            .map_or(&[], Vec::as_slice)
    }
}

/// A JSON object and its place in the document.
#[derive(Clone, Debug)]
pub(super) struct Item<'a> {
    fields: &'a Map<String, Value>,
    at: String,
}

impl<'a> Item<'a> {
    /// Where this object stands, as `materials[1].pbrMetallicRoughness`.
    pub(super) fn at(&self) -> &str {
        &self.at
    }

    /// Where a field of this object stands.
    pub(super) fn path(&self, key: &str) -> String {
        if self.at.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.at)
        }
    }

    /// True when the field is there.
    pub(super) fn has(&self, key: &str) -> bool {
        self.value(key).is_some()
    }

    /// A nested object.
    pub(super) fn child(&self, key: &str) -> Result<Option<Self>, Fault> {
        match self.value(key) {
            None => Ok(None),
            Some(Value::Object(fields)) => Ok(Some(Item {
                fields,
                at: self.path(key),
            })),
            Some(_) => Err(Fault::broken(self.path(key), "is not an object")),
        }
    }

    /// A nested object that may legally be anything else (`extras`).
    pub(super) fn child_if_object(&self, key: &str) -> Option<Self> {
        self.child(key).ok().flatten()
    }

    /// The object of an extension.
    pub(super) fn extension(&self, name: &str) -> Result<Option<Self>, Fault> {
        match self.child("extensions")? {
            Some(extensions) => extensions.child(name),
            None => Ok(None),
        }
    }

    /// A nested array of any values; empty when absent.
    pub(super) fn list(&self, key: &str) -> Result<&'a [Value], Fault> {
        match self.value(key) {
            None => Ok(&[]),
            Some(Value::Array(values)) => Ok(values),
            Some(_) => Err(Fault::broken(self.path(key), "is not an array")),
        }
    }

    /// One object of a nested array; `None` past its end.
    pub(super) fn list_item(&self, key: &str, index: usize) -> Result<Option<Self>, Fault> {
        match self.list(key)?.get(index) {
            None => Ok(None),
            Some(Value::Object(fields)) => Ok(Some(Item {
                fields,
                at: format!("{}[{index}]", self.path(key)),
            })),
            Some(_) => Err(Fault::broken(
                format!("{}[{index}]", self.path(key)),
                "is not an object",
            )),
        }
    }

    /// A nested array of non-negative integers; empty when absent.
    pub(super) fn indices(&self, key: &str) -> Result<Vec<usize>, Fault> {
        self.list(key)?
            .iter()
            .enumerate()
            .map(|(i, value)| {
                index_from_value(value).ok_or_else(|| {
                    Fault::broken(
                        format!("{}[{i}]", self.path(key)),
                        "is not a non-negative integer",
                    )
                })
            })
            .collect()
    }

    /// A string.
    pub(super) fn text(&self, key: &str) -> Result<Option<&'a str>, Fault> {
        self.typed(key, "a string", Value::as_str)
    }

    /// A boolean.
    pub(super) fn flag(&self, key: &str) -> Result<Option<bool>, Fault> {
        self.typed(key, "true or false", Value::as_bool)
    }

    /// A non-negative integer.
    pub(super) fn index(&self, key: &str) -> Result<Option<usize>, Fault> {
        self.typed(key, "a non-negative integer", index_from_value)
    }

    /// A number; beyond the range of `f32` it becomes infinite.
    pub(super) fn number(&self, key: &str) -> Result<Option<f32>, Fault> {
        self.typed(key, "a number", |v| v.as_f64().map(|x| x as f32))
    }

    /// An array of exactly `N` numbers.
    pub(super) fn numbers<const N: usize>(&self, key: &str) -> Result<Option<[f32; N]>, Fault> {
        if !self.has(key) {
            return Ok(None);
        }
        let wrong = || Fault::broken(self.path(key), format!("is not an array of {N} numbers"));
        let values = self.list(key).map_err(|_| wrong())?;
        if values.len() != N {
            return Err(wrong());
        }
        let mut numbers = [0.0; N];
        for (number, value) in numbers.iter_mut().zip(values) {
            *number = value.as_f64().ok_or_else(wrong)? as f32;
        }
        Ok(Some(numbers))
    }

    /// The fields of the object, which must all be indices.
    pub(super) fn indices_of_fields(&self) -> Result<Vec<usize>, Fault> {
        let mut indices = Vec::new();
        for key in self.fields.keys() {
            indices.extend(self.index(key)?);
        }
        Ok(indices)
    }

    /// The `name` of the object, if it is a string with something in it.
    pub(super) fn name(&self) -> Option<&'a str> {
        self.value("name")
            .and_then(Value::as_str)
            .filter(|name| !name.trim().is_empty())
    }

    fn value(&self, key: &str) -> Option<&'a Value> {
        self.fields.get(key).filter(|value| !value.is_null())
    }

    fn typed<T>(
        &self,
        key: &str,
        what: &str,
        convert: impl Fn(&'a Value) -> Option<T>,
    ) -> Result<Option<T>, Fault> {
        match self.value(key) {
            None => Ok(None),
            Some(value) => match convert(value) {
                Some(converted) => Ok(Some(converted)),
                None => Err(Fault::broken(self.path(key), format!("is not {what}"))),
            },
        }
    }
}

/// Integers, also when written as `3.0`.
fn index_from_value(value: &Value) -> Option<usize> {
    const LARGEST_EXACT: f64 = 9_007_199_254_740_992.0;
    if let Some(integer) = value.as_u64() {
        return usize::try_from(integer).ok();
    }
    let float = value.as_f64()?;
    (float.fract() == 0.0 && (0.0..LARGEST_EXACT).contains(&float)).then_some(float as usize)
}

#[cfg(test)]
mod tests {
    use super::Document;

    #[test]
    fn fields_are_typed_and_named() {
        let text = b"\xef\xbb\xbf{\"nodes\":[{\"mesh\":2,\"x\":[1,2],\"n\":null,\"f\":3.0}]} \0\0";
        let document = Document::parse(text).unwrap();
        let node = document.item("nodes", 0).unwrap();
        assert_eq!(node.index("mesh").unwrap(), Some(2));
        assert_eq!(node.index("f").unwrap(), Some(3));
        assert_eq!(node.index("n").unwrap(), None);
        assert_eq!(node.numbers::<2>("x").unwrap(), Some([1.0, 2.0]));
        assert_eq!(node.numbers::<3>("x").unwrap_err().field, "nodes[0].x");
        assert_eq!(node.text("mesh").unwrap_err().field, "nodes[0].mesh");
        let fault = document.reference(&node, "mesh", "meshes").unwrap_err();
        assert_eq!(
            fault.what(),
            "nodes[0].mesh: refers to meshes[2], but there are 0 meshes"
        );
        assert!(document.item("nodes", 1).is_err());
    }

    #[test]
    fn odd_texts_are_refused() {
        for text in [&b""[..], b"  ", b"[]", b"{", b"{\"a\":1e999}"] {
            assert!(Document::parse(text).is_err());
        }
        assert!(Document::parse("[".repeat(100_000).as_bytes()).is_err());
    }
}
