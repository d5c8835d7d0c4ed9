//! bufferViews that are packed by meshopt (`KHR_meshopt_compression`, `EXT_meshopt_compression`).
//!
//! The extension names the packed bytes; the view itself says what they become, and its own buffer
//! may be missing.

use super::allowance::Allowance;
use super::error::{EXPORT_AGAIN, Fault, quoted};
use super::json::Item;
use crate::decode::meshopt::{Filter, Layout, Mode, decode};

/// Both names of the extension; the formats are one.
const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// The extension of a view or a buffer, if it has one.
pub(super) fn extension<'a>(item: &Item<'a>) -> Result<Option<Item<'a>>, Fault> {
    for name in NAMES {
        if let Some(extension) = item.extension(name)? {
            return Ok(Some(extension));
        }
    }
    Ok(None)
}

/// True for a buffer that only programs without the extension need.
pub(super) fn is_fallback(buffer: &Item<'_>) -> Result<bool, Fault> {
    match extension(buffer)? {
        Some(extension) => Ok(extension.flag("fallback")?.unwrap_or(false)),
        None => Ok(false),
    }
}

/// Unpacks a view of `length` bytes.
pub(super) fn unpack(
    extension: &Item<'_>,
    stream: &[u8],
    length: usize,
    allowance: &Allowance,
) -> Result<Vec<u8>, Fault> {
    let layout = layout(extension)?;
    if layout.count.checked_mul(layout.stride) != Some(length) {
        return Err(Fault::broken(
            extension.path("count"),
            format!(
                "is {}, but that many elements of {} bytes do not make the bufferView's {length}",
                layout.count, layout.stride
            ),
        ));
    }
    allowance.spend(length, 1, extension.at())?;
    decode(stream, &layout)
        .map_err(|error| Fault::undecoded(extension.at(), "", error, EXPORT_AGAIN))
}

fn layout(extension: &Item<'_>) -> Result<Layout, Fault> {
    let number = |key: &str| {
        let number = extension.index(key)?;
        number.ok_or_else(|| Fault::broken(extension.path(key), "is missing"))
    };
    let unknown = |key: &str, name: &str| {
        Fault::broken(
            extension.path(key),
            format!("is {}, which is unknown", quoted(name)),
        )
    };
    let mode = extension.text("mode")?.unwrap_or("");
    let filter = extension.text("filter")?.unwrap_or("NONE");
    Ok(Layout {
        mode: Mode::from_name(mode).ok_or_else(|| unknown("mode", mode))?,
        filter: Filter::from_name(filter).ok_or_else(|| unknown("filter", filter))?,
        count: number("count")?,
        stride: number("byteStride")?,
    })
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::super::LoadError;
    use super::super::tests::{Builder, square};

    /// The square with indices that are packed, and no other bytes for them.
    fn packed_square() -> Builder {
        let mut builder = square();
        let stream = b"\xd1\x00\x04\x04\x00\x02\x08\x00\x00\x00\x00";
        let at = builder.bytes.len();
        builder.view(stream);
        let fallback = builder.push(
            "buffers",
            json!({"byteLength": 24, "uri": "not-there.bin",
                "extensions": {"EXT_meshopt_compression": {"fallback": true}}}),
        );
        let view = builder.push(
            "bufferViews",
            json!({"buffer": fallback, "byteLength": 24, "extensions": {"EXT_meshopt_compression":
                {"buffer": 0, "byteOffset": at, "byteLength": stream.len(), "byteStride": 4,
                 "count": 6, "mode": "INDICES"}}}),
        );
        let accessor = json!({"bufferView": view, "componentType": 5125, "count": 6,
            "type": "SCALAR"});
        let accessor = builder.push("accessors", accessor);
        builder.primitive()["indices"] = json!(accessor);
        builder.primitive()["mode"] = json!(4);
        builder.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
        builder
    }

    fn refused(change: impl FnOnce(&mut Value)) -> LoadError {
        let mut builder = packed_square();
        change(&mut builder.json["bufferViews"][2]["extensions"]["EXT_meshopt_compression"]);
        builder.load().unwrap_err()
    }

    #[test]
    fn packed_indices_without_a_fallback() {
        let scene = packed_square().load().unwrap();
        assert_eq!(scene.meshes[0].triangles, [[0, 1, 2], [2, 1, 3]]);
        assert!(scene.report.warnings.is_empty(), "{:?}", scene.report);
        assert_eq!(scene.report.extensions_used, ["EXT_meshopt_compression"]);
    }

    #[test]
    fn broken_ones_name_the_view_and_the_remedy() {
        let at = "bufferViews[2].extensions.EXT_meshopt_compression";
        let error = refused(|packed| packed["byteLength"] = json!(9));
        assert_eq!(
            (error.field.as_str(), error.problem.contains("too early")),
            (at, true)
        );
        assert!(error.remedy.contains("export it again"));
        let error = refused(|packed| packed["count"] = json!(7));
        assert_eq!(error.field, format!("{at}.count"));
        let error = refused(|packed| packed["mode"] = json!("ZIP"));
        assert_eq!(error.field, format!("{at}.mode"));
        let error = refused(|packed| packed["filter"] = json!("COLOR"));
        assert!(error.problem.contains("does not allow"), "{error}");
        let error = refused(|packed| packed["byteLength"] = json!(1 << 20));
        assert_eq!(error.field, format!("{at}.byteLength"));
        let error = refused(|packed| packed["buffer"] = json!(1));
        assert_eq!(error.field, "buffers[1]");
        assert!(error.problem.contains("fallback"), "{error}");
    }

    #[test]
    fn what_unpacks_to_too_much_is_refused_before_it_is_there() {
        let mut builder = packed_square();
        let view = &mut builder.json["bufferViews"][2];
        view["byteLength"] = json!(1_u64 << 40);
        view["extensions"]["EXT_meshopt_compression"]["count"] = json!(1_u64 << 38);
        let error = builder.load().unwrap_err();
        assert!(error.problem.contains("out of proportion"), "{error}");
    }
}
