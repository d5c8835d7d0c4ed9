//! Draco streams: triangle meshes, connectivity and attributes packed together.
//!
//! The decoder is `draco-core`'s, under the caller's limits. It knows both ways of packing
//! (edgebreaker and sequential); points without triangles are refused.

use draco_core::{DataType, DecodeLimits, DecoderBuffer, MeshDecoder, PointAttribute, PointIndex};

use super::{DecodeError, quietly};
use crate::memory::{self, Share};

/// Bytes that the decoder may need for each triangle and point while it works.
const WORKING: u64 = 256;

/// How one number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Number {
    /// Signed, 8 bits.
    I8,
    /// Unsigned, 8 bits.
    U8,
    /// Signed, 16 bits.
    I16,
    /// Unsigned, 16 bits.
    U16,
    /// Unsigned, 32 bits.
    U32,
    /// Floating point, 32 bits.
    F32,
}

/// What a stream may hold at most.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Points, which are the vertices.
    pub n_points: usize,
    /// Triangles.
    pub n_triangles: usize,
}

/// An attribute, point by point.
#[derive(Clone, Debug)]
pub struct Attribute {
    /// By which files name it.
    pub id: u32,
    /// Its numbers.
    pub number: Number,
    /// Numbers of a point.
    pub n_components: usize,
    /// Those of all points, little-endian.
    pub bytes: Vec<u8>,
}

/// What a stream holds.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Corners, all below `n_points`.
    pub triangles: Vec<[u32; 3]>,
    /// Number of points.
    pub n_points: usize,
    /// Those of the wanted attributes that the stream has.
    pub attributes: Vec<Attribute>,
}

/// Unpacks a mesh with the attributes of these ids.
///
/// # Errors
/// If the stream is no mesh, is broken, or holds more than the limits.
pub fn decode(stream: &[u8], ids: &[u32], limits: Limits) -> Result<Mesh, DecodeError> {
    // Name, version, kind (1 is a mesh), method, flags.
    match stream {
        [b'D', b'R', b'A', b'C', b'O', _, _, 1, ..] => {}
        [b'D', b'R', b'A', b'C', b'O', ..] => {
            return Err(DecodeError::broken("it is no mesh of triangles"));
        }
        _ => return Err(DecodeError::broken("it is no Draco stream")),
    }
    let n = limits.n_points.saturating_add(limits.n_triangles) as u64;
    let n_working = n.saturating_mul(WORKING);
    let _working = Share::of_process(n_working)?;
    let allowed = DecodeLimits::default()
        .with_max_points(limits.n_points as u64)
        .with_max_faces(limits.n_triangles as u64)
        .with_max_decoded_bytes(n_working);
    quietly(|| {
        let mut mesh = draco_core::Mesh::new();
        let mut buffer = DecoderBuffer::new(stream).with_limits(allowed);
        let decoded = MeshDecoder::new().decode(&mut buffer, &mut mesh);
        decoded.map_err(|error| DecodeError::broken(error.message()))?;
        let n_points = mesh.num_points();
        if n_points > limits.n_points || mesh.num_faces() > limits.n_triangles {
            return Err(DecodeError::broken("it holds more than the file says"));
        }
        let mut triangles = memory::empty(mesh.num_faces())?;
        triangles.extend(mesh.faces().iter().map(|face| face.map(|point| point.0)));
        let mut corners = triangles.iter().flatten();
        if corners.any(|&corner| corner as usize >= n_points) {
            return Err(DecodeError::broken(
                "a triangle names a point that is not there",
            ));
        }
        let mut attributes = Vec::new();
        for &id in ids {
            if let Some(attribute) = mesh.attribute_by_unique_id(id) {
                attributes.push(by_point(attribute, id, n_points)?);
            }
        }
        Ok(Mesh {
            triangles,
            n_points,
            attributes,
        })
    })
}

/// The values of an attribute, one to a point instead of each once.
fn by_point(attribute: &PointAttribute, id: u32, n: usize) -> Result<Attribute, DecodeError> {
    let (number, size) = match attribute.data_type() {
        DataType::Int8 => (Number::I8, 1),
        DataType::Uint8 => (Number::U8, 1),
        DataType::Int16 => (Number::I16, 2),
        DataType::Uint16 => (Number::U16, 2),
        DataType::Uint32 => (Number::U32, 4),
        DataType::Float32 => (Number::F32, 4),
        other => {
            let reason = format_args!("attribute {id} has numbers that glTF lacks: {other:?}");
            return Err(DecodeError::broken(reason));
        }
    };
    let n_components = usize::from(attribute.num_components());
    let element = n_components * size;
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(0);
    let stored = attribute.buffer().data();
    let mut bytes = memory::empty(n.saturating_mul(element))?;
    for point in 0..n {
        let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        let start = value.checked_mul(stride);
        let value = start.and_then(|start| stored.get(start..)?.get(..element));
        bytes.extend_from_slice(value.ok_or_else(|| {
            DecodeError::broken(format_args!(
                "attribute {id} lacks the value of point {point}"
            ))
        })?);
    }
    Ok(Attribute {
        id,
        number,
        n_components,
        bytes,
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use draco_core::{
        DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, Mesh,
        MeshEncoder, PointAttribute,
    };

    use super::{Limits, Number, decode};

    const LIMITS: Limits = Limits {
        n_points: 4,
        n_triangles: 2,
    };

    /// The unit square, packed fast or small; its positions are attribute 0.
    pub(crate) fn square(speed: i32) -> Vec<u8> {
        let mut positions = PointAttribute::new();
        positions.init(
            GeometryAttributeType::Position,
            3,
            DataType::Float32,
            false,
            4,
        );
        let corners = [0_f32, 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.];
        let bytes: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
        positions.buffer_mut().write(0, &bytes);
        let mut mesh = Mesh::new();
        mesh.add_attribute(positions);
        mesh.set_num_faces(2);
        for (i, [a, b, c]) in [[0_u32, 1, 2], [2, 1, 3]].into_iter().enumerate() {
            mesh.set_face(FaceIndex(i as u32), [a.into(), b.into(), c.into()]);
        }
        let mut options = EncoderOptions::new();
        options.set_global_int("encoding_speed", speed);
        options.set_global_int("decoding_speed", speed);
        options.set_attribute_int(0, "quantization_bits", 8);
        let mut encoder = MeshEncoder::new();
        encoder.set_mesh(mesh);
        let mut buffer = EncoderBuffer::new();
        encoder.encode(&options, &mut buffer).unwrap();
        buffer.data().to_vec()
    }

    #[test]
    fn both_ways_of_packing() {
        for (speed, method) in [(0, 1), (5, 1), (10, 0)] {
            let stream = square(speed);
            assert_eq!(stream[8], method, "speed {speed}");
            let mesh = decode(&stream, &[0, 7], LIMITS).unwrap();
            assert_eq!((mesh.n_points, mesh.attributes.len()), (4, 1));
            let positions = &mesh.attributes[0];
            assert_eq!((positions.number, positions.n_components), (Number::F32, 3));
            let at = |point: u32| -> Vec<f32> {
                let floats = positions.bytes.as_chunks().0;
                let floats = floats[3 * point as usize..][..3].iter();
                floats
                    .map(|float| f32::from_le_bytes(*float).round())
                    .collect()
            };
            // The order of points is the encoder's; the area and its front are not.
            let mut area = 0.0;
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(at);
                area += 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
            }
            assert_eq!(area, 1.0, "speed {speed}");
        }
    }

    #[test]
    fn broken_streams_and_those_beyond_the_limits_are_refused() {
        for speed in [0, 10] {
            let stream = square(speed);
            for n in 0..stream.len() {
                assert!(
                    decode(&stream[..n], &[0], LIMITS).is_err(),
                    "speed {speed}: {n} bytes"
                );
            }
            for limits in [
                Limits {
                    n_points: 3,
                    ..LIMITS
                },
                Limits {
                    n_triangles: 1,
                    ..LIMITS
                },
            ] {
                assert!(
                    decode(&stream, &[0], limits).is_err(),
                    "speed {speed}: {limits:?}"
                );
            }
            let mut points = stream.clone();
            points[7] = 0;
            let error = decode(&points, &[0], LIMITS).unwrap_err().to_string();
            assert!(error.contains("no mesh"), "{error}");
        }
    }
}
