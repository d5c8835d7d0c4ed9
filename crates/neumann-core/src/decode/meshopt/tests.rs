//! Streams that the reference encoder, meshoptimizer 1.3, has written for the values named here.

use super::{Filter, Layout, Mode, decode};

fn bytes(hex: &str) -> Vec<u8> {
    let digit = |c: u8| (c as char).to_digit(16).unwrap() as u8;
    let pairs = hex.as_bytes().chunks(2);
    pairs
        .map(|pair| 16 * digit(pair[0]) + digit(pair[1]))
        .collect()
}

fn attributes(filter: Filter, count: usize, stride: usize) -> Layout {
    let mode = Mode::Attributes;
    Layout {
        mode,
        filter,
        count,
        stride,
    }
}

fn indices(mode: Mode, count: usize) -> Layout {
    let (filter, stride) = (Filter::None, 4);
    Layout {
        mode,
        filter,
        count,
        stride,
    }
}

/// Every stream here, what it holds, and its values.
fn examples() -> Vec<(Vec<u8>, Layout, Vec<u8>)> {
    let u32s = |numbers: &[u32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let i16s = |numbers: &[i16]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let f32s = |numbers: &[f32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let squares: Vec<i16> = (0..6)
        .flat_map(|i| [i * i * 100, -i, 300 - 7 * i, 0])
        .collect();
    vec![
        (
            bytes("e1f010fefff00cff020202007687566778a9866589689801690000"),
            indices(Mode::Triangles, 12),
            u32s(&[0, 1, 2, 2, 1, 3, 4, 6, 5, 7, 8, 9]),
        ),
        (
            bytes("d10004cd010407981f00000000"),
            indices(Mode::Indices, 6),
            u32s(&[0, 1, 51, 2, 49, 1000]),
        ),
        (
            bytes(concat!(
                "a0013ff00000c8581787f7010bf0000004060601155000000110000000020ddddd000000",
                "0000000000000000000000000000000000000000000000000000000000000000002c0100",
                "00"
            )),
            attributes(Filter::None, 6, 8),
            i16s(&squares),
        ),
        (
            bytes(concat!(
                "a19fab00c858e878080000020305070115500000000d0d0d0d0d00000000000000000000",
                "00000000000000002c0100000100"
            )),
            attributes(Filter::None, 6, 8),
            i16s(&squares),
        ),
        (
            bytes(concat!(
                "a0010f00000091ee013f000000fefdb800013f000000fdfe040000000000000000000000",
                "00000000000000000000000000000000007f007f7f"
            )),
            attributes(Filter::Octahedral, 4, 4),
            bytes("7f00007f000081004c00667fc44cae81"),
        ),
        (
            bytes(concat!(
                "a0010f000000dcbc010f0000000711011b00000077013f0000000e0d0a00000127000000",
                "04013e000000fdfe000000000000000000000000000000000000000000000000ff070000",
                "ff07ff7f"
            )),
            attributes(Filter::Octahedral, 4, 8),
            bytes("ff7f00000000ff7f0000000001800000c54c00006b66ff7f97c2ca4c0dae0180"),
        ),
        (
            bytes(concat!(
                "a0013c000000c0bf013c0000002d2e013c000000bfc0013c0000002c2b013f000000bff3",
                "97013f0000002c0a6d013f00000005040300000000000000000000000000000000000000",
                "000000000000000000000000ff1f"
            )),
            attributes(Filter::Quaternion, 4, 8),
            bytes("000000000000ff7fff3f00c0004000400000cb4c6666000066660000000035b3"),
        ),
        (
            bytes(concat!(
                "a00103000000ff013f00000060c7e40106000000012b0000001000000000000000000000",
                "000000000000000000000000000000000000000000f2"
            )),
            attributes(Filter::Exponential, 4, 4),
            f32s(&[0.0, 1.5, -3.25, 1000.0]),
        ),
        (
            bytes(concat!(
                "a1ff007e02fe00fd7d7e0083fd00007d7ffe000000000000000000000000000000000000",
                "00407fc1ff00"
            )),
            attributes(Filter::Color, 4, 4),
            bytes("fe0100ff00fe00804180bf00ffffffff"),
        ),
        (
            bytes(concat!(
                "a1ffff000102010006020e00020201000d07080003020000160d00000200010005070e00",
                "000000000000000000000000000004ff0701fcff0f0000"
            )),
            attributes(Filter::Color, 4, 8),
            bytes("efff10000000ffff0000efff0000088014400880fbbf0000ffffffffffffffff"),
        ),
    ]
}

#[test]
fn every_mode_and_filter() {
    for (stream, layout, values) in examples() {
        assert_eq!(decode(&stream, &layout).unwrap(), values, "{layout:?}");
    }
}

#[test]
fn two_bytes_hold_the_lower_half_of_an_index() {
    let (stream, mut layout, values) = examples().swap_remove(1);
    layout.stride = 2;
    let halves: Vec<u8> = values
        .chunks(4)
        .flat_map(|index| [index[0], index[1]])
        .collect();
    assert_eq!(decode(&stream, &layout).unwrap(), halves);
}

#[test]
fn streams_of_another_length_or_count_are_refused() {
    for (stream, layout, _) in examples() {
        for n in 0..stream.len() {
            assert!(
                decode(&stream[..n], &layout).is_err(),
                "{layout:?}: {n} bytes"
            );
        }
        let mut longer = stream.clone();
        longer.insert(stream.len() / 2, 0);
        assert!(decode(&longer, &layout).is_err(), "{layout:?}");
        let mut other = stream.clone();
        other[0] = 0xb0;
        let error = decode(&other, &layout).unwrap_err().to_string();
        assert!(error.contains("first byte is 0xb0"), "{error}");
        for count in [layout.count + 48, layout.count - 3] {
            let layout = Layout { count, ..layout };
            // Groups of attributes are filled up to sixteen, and may be empty.
            let may_fit = layout.mode == Mode::Attributes;
            assert!(may_fit || decode(&stream, &layout).is_err(), "{layout:?}");
        }
    }
}

#[test]
fn layouts_beyond_the_specification_are_refused() {
    let refused = [
        attributes(Filter::None, 4, 6),
        attributes(Filter::None, 4, 260),
        attributes(Filter::Octahedral, 4, 12),
        attributes(Filter::Quaternion, 4, 4),
        attributes(Filter::None, usize::MAX / 2, 4),
        indices(Mode::Triangles, 4),
        Layout {
            stride: 1,
            ..indices(Mode::Indices, 4)
        },
        Layout {
            filter: Filter::Color,
            ..indices(Mode::Indices, 4)
        },
    ];
    for layout in refused {
        let error = decode(&[0xa0; 64], &layout).unwrap_err().to_string();
        assert!(error.starts_with("has a "), "{layout:?}: {error}");
    }
}

#[test]
fn triangles_refer_to_earlier_ones_only() {
    let (stream, layout, _) = examples().swap_remove(0);
    let mut first = stream;
    first[1] = 0x10;
    let error = decode(&first, &layout).unwrap_err().to_string();
    assert!(error.contains("before the first"), "{error}");
}
