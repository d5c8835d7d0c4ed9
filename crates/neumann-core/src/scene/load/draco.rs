//! Primitives that are packed by Draco (`KHR_draco_mesh_compression`).
//!
//! The stream holds triangles and attributes; accessors say what an attribute means and how many
//! elements there are, which nothing in the stream may exceed.

use super::File;
use super::accessor::Accessor;
use super::error::{EXPORT_AGAIN, Fault};
use super::json::Item;
use crate::decode::draco::{Limits, Mesh, decode};

const NAME: &str = "KHR_draco_mesh_compression";

/// The attributes of a primitive, from accessors or out of a stream.
#[derive(Debug)]
pub(super) struct Attributes<'a> {
    item: Item<'a>,
    packed: Option<Packed<'a>>,
}

/// What a stream holds, and which attributes it has by their ids.
#[derive(Debug)]
struct Packed<'a> {
    mesh: Mesh,
    ids: Item<'a>,
}

impl<'a> Attributes<'a> {
    /// Those of a primitive, if it has any; a stream is unpacked.
    pub(super) fn read(file: &File<'_>, primitive: &Item<'a>) -> Result<Option<Self>, Fault> {
        let Some(item) = primitive.child("attributes")? else {
            return Ok(None);
        };
        let packed = match primitive.extension(NAME)? {
            Some(extension) => Some(unpack(file, primitive, &item, &extension)?),
            None => None,
        };
        Ok(Some(Self { item, packed }))
    }

    /// Where they stand in the file.
    pub(super) fn at(&self) -> &str {
        self.item.at()
    }

    /// Where one of them stands.
    pub(super) fn path(&self, key: &str) -> String {
        self.item.path(key)
    }

    /// The triangles of the stream, if the primitive is packed.
    pub(super) fn triangles(&self) -> Option<&[[u32; 3]]> {
        self.packed.as_ref().map(|packed| &*packed.mesh.triangles)
    }

    /// As [`Accessor::open`]; out of the stream where that has the attribute.
    pub(super) fn open<'b>(
        &'b self,
        file: &'b File<'_>,
        key: &str,
        kinds: &[&str],
    ) -> Result<Option<Accessor<'b>>, Fault> {
        let Some(accessor) = Accessor::open(file, &self.item, key, kinds)? else {
            return Ok(None);
        };
        let Some(packed) = &self.packed else {
            return Ok(Some(accessor));
        };
        let Some(id) = packed.ids.index(key)? else {
            return Ok(Some(accessor));
        };
        let mut attributes = packed.mesh.attributes.iter();
        let Some(attribute) = attributes.find(|attribute| attribute.id as usize == id) else {
            let problem = format!("is {id}, but the Draco stream has no such attribute");
            return Err(Fault::broken(packed.ids.path(key), problem));
        };
        accessor.over(attribute, packed.mesh.n_points).map(Some)
    }
}

fn unpack<'a>(
    file: &File<'_>,
    primitive: &Item<'_>,
    attributes: &Item<'_>,
    extension: &Item<'a>,
) -> Result<Packed<'a>, Fault> {
    let missing = |key: &str| Fault::broken(extension.path(key), "is missing");
    let count = |item: &Item<'_>, key: &str| -> Result<Option<usize>, Fault> {
        match file.document.reference(item, key, "accessors")? {
            Some(index) => file.document.item("accessors", index)?.index("count"),
            None => Ok(None),
        }
    };
    let ids = extension
        .child("attributes")?
        .ok_or_else(|| missing("attributes"))?;
    let wanted = ids.indices_of_fields()?;
    let wanted: Vec<u32> = wanted
        .iter()
        .filter_map(|&id| u32::try_from(id).ok())
        .collect();
    let n_points = count(attributes, "POSITION")?.unwrap_or(0);
    let n_indices = count(primitive, "indices")?.unwrap_or(n_points);
    let limits = Limits {
        n_points,
        n_triangles: n_indices / 3,
    };
    let view = file
        .buffers
        .view(&file.document, extension, &file.allowance)?;
    let view = view.ok_or_else(|| missing("bufferView"))?;
    // An element has sixteen bytes at most.
    let each = 16 * wanted.len();
    file.allowance
        .spend(limits.n_points, each, extension.at())?;
    file.allowance
        .spend(limits.n_triangles, size_of::<[u32; 3]>(), extension.at())?;
    let mesh = decode(view.bytes, &wanted, limits)
        .map_err(|error| Fault::undecoded(extension.at(), "", error, EXPORT_AGAIN))?;
    Ok(Packed { mesh, ids })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::super::tests::Builder;
    use crate::decode::draco::tests::square;

    /// The square, packed, with nothing else to fall back on.
    fn packed_square(speed: i32) -> Builder {
        let mut builder = Builder::new();
        let view = builder.view(&square(speed));
        builder.push(
            "accessors",
            json!({"componentType": 5126, "count": 4, "type": "VEC3"}),
        );
        builder.push(
            "accessors",
            json!({"componentType": 5123, "count": 6, "type": "SCALAR"}),
        );
        *builder.primitive() = json!({"attributes": {"POSITION": 0}, "indices": 1, "extensions":
            {"KHR_draco_mesh_compression": {"bufferView": view, "attributes": {"POSITION": 0}}}});
        builder.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
        builder
    }

    #[test]
    fn packed_primitives_have_their_triangles() {
        for speed in [0, 5, 10] {
            let scene = packed_square(speed).load().unwrap();
            let mesh = &scene.meshes[0];
            assert_eq!((mesh.triangles.len(), mesh.positions.len()), (2, 4));
            let sum: glam::Vec3 = mesh.positions.iter().sum();
            assert!(
                (sum - glam::Vec3::new(2.0, 2.0, 0.0)).length() < 0.05,
                "{sum}"
            );
            assert!(scene.report.warnings.is_empty(), "{:?}", scene.report);
        }
    }

    #[test]
    fn what_contradicts_the_stream_is_named() {
        let at = "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";
        let mut builder = packed_square(5);
        builder.json["accessors"][0]["count"] = json!(3);
        assert_eq!(builder.load().unwrap_err().field, at);
        let mut builder = packed_square(5);
        builder.json["accessors"][1]["count"] = json!(3);
        let error = builder.load().unwrap_err();
        assert_eq!(error.field, at);
        assert!(error.remedy.contains("export it again"));
        let mut builder = packed_square(5);
        let packed = &mut builder.primitive()["extensions"]["KHR_draco_mesh_compression"];
        packed["attributes"]["POSITION"] = json!(3);
        let error = builder.load().unwrap_err();
        assert_eq!(error.field, format!("{at}.attributes.POSITION"));
        let mut builder = packed_square(5);
        builder.json["accessors"][0]["count"] = json!(1_u64 << 40);
        let error = builder.load().unwrap_err();
        assert!(error.problem.contains("out of proportion"), "{error}");
        builder.json["accessors"][0]["count"] = json!(4);
        builder.json["accessors"][1]["count"] = json!(1_u64 << 40);
        let error = builder.load().unwrap_err();
        assert!(error.problem.contains("out of proportion"), "{error}");
    }
}
