//! The binary glTF container: one JSON chunk, one chunk of vertex data.
//!
//! Little-endian throughout, each chunk padded to four bytes, as the glTF 2.0
//! specification asks in its section on the GLB file format. Indices are 16 bits
//! wide where they fit.

use glam::DVec3;
use serde_json::{Value, json};

use crate::mesh::Mesh;

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

/// Vertex data under construction, with the accessors that describe it.
#[derive(Debug, Default)]
pub(crate) struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Appends a mesh and returns the primitive that draws it.
    pub(crate) fn push(&mut self, mesh: &Mesh) -> Value {
        let mut attributes = json!({});
        if !mesh.normals.is_empty() {
            let normals = self.push_vectors(&mesh.normals);
            attributes["NORMAL"] = json!(normals);
        }
        let positions = self.push_vectors(&mesh.positions);
        self.accessors[positions]["max"] = extent(&mesh.positions, f32::max);
        self.accessors[positions]["min"] = extent(&mesh.positions, f32::min);
        attributes["POSITION"] = json!(positions);
        let indices = self.push_indices(&mesh.indices, mesh.positions.len());
        json!({ "attributes": attributes, "indices": indices })
    }

    /// Adds the data to `document` and returns the whole file.
    pub(crate) fn finish(mut self, mut document: Value) -> Vec<u8> {
        self.pad();
        document["accessors"] = Value::Array(self.accessors);
        document["bufferViews"] = Value::Array(self.views);
        document["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');

        let mut file = Vec::new();
        file.extend(b"glTF");
        file.extend(2_u32.to_le_bytes());
        file.extend(length(12 + 8 + text.len() + 8 + self.bytes.len()));
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &self.bytes)] {
            file.extend(length(chunk.len()));
            file.extend(kind);
            file.extend(chunk);
        }
        file
    }

    fn push_vectors(&mut self, vectors: &[DVec3]) -> usize {
        let start = self.bytes.len();
        for number in vectors.iter().flat_map(|v| v.to_array()) {
            self.bytes.extend(single(number).to_le_bytes());
        }
        self.push_accessor(start, ARRAY_BUFFER, FLOAT, "VEC3", vectors.len())
    }

    fn push_indices(&mut self, indices: &[u32], n_vertices: usize) -> usize {
        let start = self.bytes.len();
        // The greatest 16-bit index is reserved for primitive restart.
        let kind = if n_vertices < usize::from(u16::MAX) {
            let short = |&index| u16::try_from(index).unwrap_or(u16::MAX).to_le_bytes();
            self.bytes.extend(indices.iter().flat_map(short));
            UNSIGNED_SHORT
        } else {
            self.bytes
                .extend(indices.iter().flat_map(|index| index.to_le_bytes()));
            UNSIGNED_INT
        };
        self.push_accessor(start, ELEMENT_ARRAY_BUFFER, kind, "SCALAR", indices.len())
    }

    fn push_accessor(
        &mut self,
        start: usize,
        target: u32,
        component: u32,
        shape: &str,
        count: usize,
    ) -> usize {
        self.views.push(json!({
            "buffer": 0,
            "byteLength": self.bytes.len() - start,
            "byteOffset": start,
            "target": target,
        }));
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1,
            "componentType": component,
            "count": count,
            "type": shape,
        }));
        self.pad();
        self.accessors.len() - 1
    }

    fn pad(&mut self) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }
}

fn extent(positions: &[DVec3], choose: fn(f32, f32) -> f32) -> Value {
    let axis = |i: usize| {
        let values = positions.iter().map(|p| single(p[i]));
        f64::from(values.reduce(choose).unwrap_or(0.0))
    };
    json!([axis(0), axis(1), axis(2)])
}

/// To single precision, without negative zeros or the dust of a sine of pi.
fn single(number: f64) -> f32 {
    #[allow(clippy::cast_possible_truncation, reason = "as glTF stores it")]
    if number.abs() < 1e-9 {
        0.0
    } else {
        number as f32
    }
}

fn length(n_bytes: usize) -> [u8; 4] {
    u32::try_from(n_bytes).unwrap_or(u32::MAX).to_le_bytes()
}
