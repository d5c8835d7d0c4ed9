//! Packed geometry, as bufferViews of glTF files hold it.

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, GeometryAttributeType, Mesh, MeshEncoder,
    PointAttribute,
};
use neumann_core::decode::draco;
use neumann_core::decode::meshopt::{Filter, Layout, Mode, decode};

use crate::Target;

/// What the first byte of an input chooses from: mode, filter, bytes of an element.
const LAYOUTS: [(Mode, Filter, usize); 8] = [
    (Mode::Triangles, Filter::None, 4),
    (Mode::Indices, Filter::None, 2),
    (Mode::Attributes, Filter::None, 8),
    (Mode::Attributes, Filter::Octahedral, 8),
    (Mode::Attributes, Filter::Quaternion, 8),
    (Mode::Attributes, Filter::Exponential, 8),
    (Mode::Attributes, Filter::Color, 8),
    (Mode::Attributes, Filter::Color, 4),
];

/// meshopt streams, after a byte for their layout and one for the number of elements.
pub(crate) const MESHOPT: Target = Target {
    name: "meshopt",
    run: |bytes| {
        let Some((&[layout, count], stream)) = bytes.split_first_chunk() else {
            return false;
        };
        let (mode, filter, stride) = LAYOUTS[usize::from(layout) % LAYOUTS.len()];
        let count = usize::from(count);
        let layout = Layout {
            mode,
            filter,
            count,
            stride,
        };
        match decode(stream, &layout) {
            Ok(elements) => {
                assert_eq!(elements.len(), count * stride);
                true
            }
            Err(_) => false,
        }
    },
    seeds: || {
        let triangles = b"\xe1\xf0\x10\xfe\xff\xf0\x0c\xff\x02\x02\x02\
            \0\x76\x87\x56\x67\x78\xa9\x86\x65\x89\x68\x98\x01\x69\0\0";
        let indices = b"\xd1\x00\x04\xcd\x01\x04\x07\x98\x1f\0\0\0\0";
        let attributes = b"\xa1\x9f\xab\0\xc8\x58\xe8\x78\x08\0\0\x02\x03\x05\x07\x01\x15\x50\
            \0\0\0\x0d\x0d\x0d\x0d\x0d\0\0\0\0\0\0\0\0\
            \0\0\0\0\0\0\0\0\0\0\x2c\x01\0\0\x01\0";
        let mut seeds = vec![
            [b"\0\x0c", &triangles[..]].concat(),
            [b"\x01\x06", &indices[..]].concat(),
        ];
        seeds.extend((2..7).map(|layout| [&[layout, 6], &attributes[..]].concat()));
        seeds
    },
};

/// Draco streams.
pub(crate) const DRACO: Target = Target {
    name: "draco",
    run: |bytes| {
        let limits = draco::Limits {
            n_points: 4096,
            n_triangles: 4096,
        };
        match draco::decode(bytes, &[0, 1], limits) {
            Ok(mesh) => {
                let mut corners = mesh.triangles.iter().flatten();
                assert!(corners.all(|&corner| (corner as usize) < mesh.n_points));
                true
            }
            Err(_) => false,
        }
    },
    seeds: || [0, 5, 10].into_iter().map(packed_grid).collect(),
};

/// A grid of nine by nine points with normals, packed small (0) or fast (10).
fn packed_grid(speed: i32) -> Vec<u8> {
    const SIDE: u32 = 9;
    let n_points = (SIDE * SIDE) as usize;
    let mut mesh = Mesh::new();
    for kind in [
        GeometryAttributeType::Position,
        GeometryAttributeType::Normal,
    ] {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, 3, DataType::Float32, false, n_points);
        for i in 0..SIDE * SIDE {
            let [x, y] = [i % SIDE, i / SIDE].map(|v| v as f32 / 4.0 - 1.0);
            let z = (1.5 - 0.5 * (x * x + y * y)).max(0.0);
            let bytes: Vec<u8> = [x, y, z].iter().flat_map(|v| v.to_le_bytes()).collect();
            attribute.buffer_mut().write(12 * i as usize, &bytes);
        }
        mesh.add_attribute(attribute);
    }
    for y in 0..SIDE - 1 {
        for x in 0..SIDE - 1 {
            let a = y * SIDE + x;
            mesh.add_face([a, a + 1, a + SIDE].map(Into::into));
            mesh.add_face([a + SIDE, a + 1, a + SIDE + 1].map(Into::into));
        }
    }
    let mut options = EncoderOptions::new();
    options.set_global_int("encoding_speed", speed);
    options.set_global_int("decoding_speed", speed);
    for attribute in 0..2 {
        options.set_attribute_int(attribute, "quantization_bits", 9);
    }
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut buffer = EncoderBuffer::new();
    match encoder.encode(&options, &mut buffer) {
        Ok(()) => buffer.data().to_vec(),
        Err(_) => Vec::new(),
    }
}
