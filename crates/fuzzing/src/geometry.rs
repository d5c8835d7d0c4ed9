//! Packed geometry, as bufferViews of glTF files hold it.

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
