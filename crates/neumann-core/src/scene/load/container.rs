//! From the bytes of a file to its JSON and its binary chunk.
//!
//! A `.gltf` is JSON; a `.glb` is a header of 12 bytes and chunks, little
//! endian (glTF 2.0, 4.4). Which of the two it is, the first bytes say, not the
//! file's name.

use super::error::{EXPORT_AGAIN, Fault, quoted};
use super::json::Document;

const MAGIC: &[u8] = b"glTF";
const CHUNK_JSON: u32 = 0x4e4f_534a;
const CHUNK_BIN: u32 = 0x004e_4942;

/// The two parts of a glTF file.
#[derive(Debug)]
pub(super) struct Container<'a> {
    pub(super) document: Document,
    /// The GLB's binary chunk.
    pub(super) binary: Option<&'a [u8]>,
}

/// Takes a file apart and checks that it is glTF 2.
pub(super) fn open(bytes: &[u8]) -> Result<Container<'_>, Fault> {
    if bytes.is_empty() {
        return Err(Fault::new("", "is empty", EXPORT_AGAIN));
    }
    let container = if bytes.starts_with(MAGIC) {
        open_glb(bytes)?
    } else {
        Container {
            document: Document::parse(bytes)?,
            binary: None,
        }
    };
    check_version(&container.document)?;
    container.document.check_collections()?;
    Ok(container)
}

fn open_glb(bytes: &[u8]) -> Result<Container<'_>, Fault> {
    let truncated = |problem: String| Fault::new("", problem, EXPORT_AGAIN);
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        return Err(truncated("ends within the GLB header".to_owned()));
    };
    if version != 2 {
        return Err(wrong_version(&format!("GLB version {version}")));
    }
    let length = length as usize;
    // Bytes after the declared length belong to nobody and are left alone.
    let Some(bytes) = bytes.get(..length) else {
        return Err(truncated(format!(
            "is cut short: its header promises {length} bytes, but there are {}",
            bytes.len()
        )));
    };
    let mut json = None;
    let mut binary = None;
    let mut offset = 12;
    while let (Some(size), Some(kind)) = (u32_at(bytes, offset), u32_at(bytes, offset + 4)) {
        let start = offset + 8;
        let end = start + size as usize;
        let Some(chunk) = bytes.get(start..end) else {
            return Err(truncated(format!(
                "is cut short: a chunk reaches to byte {end}, but the GLB ends at {length}"
            )));
        };
        match kind {
            CHUNK_JSON if json.is_none() => json = Some(chunk),
            CHUNK_BIN if binary.is_none() => binary = Some(chunk),
            _ => {} // Unknown chunks are to be ignored (4.4.3).
        }
        offset = next_chunk(bytes, end);
    }
    let Some(json) = json else {
        return Err(truncated("has no JSON chunk".to_owned()));
    };
    Ok(Container {
        document: Document::parse(json)?,
        binary,
    })
}

/// Where the chunk after one that ends at `end` begins.
///
/// Chunks are to end on multiples of 4. Some writers pad them but leave the padding out of the
/// size, others do not pad: the place at which a chunk of a known kind begins is taken.
fn next_chunk(bytes: &[u8], end: usize) -> usize {
    let padded = end.next_multiple_of(4);
    let is_known = |offset: usize| {
        let size = u32_at(bytes, offset).map(|size| size as usize);
        let is_inside = size.is_some_and(|size| offset + 8 + size <= bytes.len());
        is_inside && matches!(u32_at(bytes, offset + 4), Some(CHUNK_JSON | CHUNK_BIN))
    };
    if is_known(end) && !is_known(padded) {
        end
    } else {
        padded
    }
}

fn u32_at(bytes: &[u8], offset: usize) -> Option<u32> {
    let four = bytes.get(offset..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*four))
}

fn check_version(document: &Document) -> Result<(), Fault> {
    let root = document.root();
    let asset = root.child_if_object("asset");
    // Version 1 was also written as a number, or, in drafts, not at all.
    let version = asset.as_ref().and_then(|asset| {
        let text = asset.text("version").ok().flatten().map(str::to_owned);
        let number = || asset.number("version").ok().flatten();
        text.or_else(|| number().map(|number| format!("{number:?}")))
    });
    if let Some(version) = &version
        && !(version == "2" || version.starts_with("2."))
    {
        return Err(wrong_version(&format!("glTF version {}", quoted(version))));
    }
    // Its objects had names in place of numbers.
    let is_first = ["meshes", "nodes", "accessors"]
        .iter()
        .any(|key| root.child_if_object(key).is_some());
    if version.is_none() && is_first {
        return Err(wrong_version("glTF version 1 (objects have names)"));
    }
    let Some(asset) = root.child("asset")? else {
        return Err(Fault::new(
            "asset",
            "is missing",
            "a scene is a glTF 2.0 file; other JSON cannot be shown",
        ));
    };
    if version.is_none() {
        return Err(Fault::broken("asset.version", "is missing"));
    }
    match asset.text("minVersion")? {
        None | Some("2.0" | "2") => Ok(()),
        Some(newer) => Err(Fault::new(
            "asset.minVersion",
            format!("asks for a reader of glTF {newer}"),
            "export the scene as glTF 2.0",
        )),
    }
}

fn wrong_version(found: &str) -> Fault {
    Fault::new(
        "asset.version",
        format!("is {found}; only glTF 2.x can be read"),
        "convert version 1 with 'npx gltf-pipeline -i old.gltf -o new.gltf', or export again",
    )
}

#[cfg(test)]
mod tests {
    use super::open;

    fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
        let mut json = json.as_bytes().to_vec();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        let length = 12 + 8 + json.len() + 8 + binary.len();
        bytes.extend((length as u32).to_le_bytes());
        bytes.extend((json.len() as u32).to_le_bytes());
        bytes.extend(b"JSON");
        bytes.extend(json);
        bytes.extend((binary.len() as u32).to_le_bytes());
        bytes.extend(b"BIN\0");
        bytes.extend(binary);
        bytes
    }

    #[test]
    fn glb_is_taken_apart() {
        let mut bytes = glb(r#"{"asset":{"version":"2.0"}}"#, &[1, 2, 3, 4]);
        assert_eq!(open(&bytes).unwrap().binary, Some(&[1, 2, 3, 4][..]));
        bytes.extend([0; 7]);
        assert!(open(&bytes).is_ok(), "trailing bytes are tolerated");
        bytes.truncate(bytes.len() - 9);
        assert!(open(&bytes).unwrap_err().problem.contains("cut short"));
        for n in 0..bytes.len() {
            assert!(open(&bytes[..n]).is_err());
        }
    }

    /// A GLB whose JSON chunk has an odd length, with or without padding that is not counted.
    fn odd_glb(is_padded: bool) -> Vec<u8> {
        let json = br#"{"asset":{"version":"2.0"},"x":1}"#;
        assert!(json.len() % 4 == 1);
        let mut body = (json.len() as u32).to_le_bytes().to_vec();
        body.extend(b"JSON");
        body.extend(json);
        if is_padded {
            body.extend(b"   ");
        }
        body.extend([4, 0, 0, 0]);
        body.extend(b"BIN\0\x01\x02\x03\x04");
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((12 + body.len() as u32).to_le_bytes());
        bytes.extend(body);
        bytes
    }

    #[test]
    fn chunks_are_found_with_and_without_padding() {
        for is_padded in [true, false] {
            let bytes = odd_glb(is_padded);
            let container = open(&bytes).unwrap();
            assert_eq!(container.binary, Some(&[1, 2, 3, 4][..]), "{is_padded}");
        }
    }

    #[test]
    fn other_versions_are_refused() {
        let fault = open(br#"{"asset":{"version":"1.0"}}"#).unwrap_err();
        assert_eq!(fault.field, "asset.version");
        for text in [
            r#"{"asset":{"version":1.0}}"#,
            r#"{"asset":{"version":0.8},"meshes":7}"#,
            r#"{"asset":{},"nodes":{"a":{"children":[]}}}"#,
            r#"{"meshes":{"a":{"primitives":[]}}}"#,
            r#"{"asset":{"version":"1.1"},"accessors":{}}"#,
        ] {
            let fault = open(text.as_bytes()).unwrap_err();
            assert!(fault.problem.contains("only glTF 2"), "{text}: {fault:?}");
        }
        let fault = open(br#"{"asset":{"version":"2.0"},"nodes":{}}"#).unwrap_err();
        assert!(fault.problem.contains("not an array"), "{fault:?}");
        assert!(open(br#"{"asset":{"version":2}}"#).is_ok());
        assert!(open(br#"{"asset":{"version":"2.1"}}"#).is_ok());
        assert!(open(br#"{"asset":{"version":"2.0","minVersion":"2.1"}}"#).is_err());
        assert!(open(b"glTF\x01\0\0\0\x14\0\0\0").is_err());
        assert!(open(b"{}").is_err());
    }
}
