//! What unpacked attributes stand for.
//!
//! Each filter works in place. Values that the specification leaves open become 0 or the end of
//! their range.

use super::Filter;

/// Filters all elements.
pub(super) fn apply(filter: Filter, stride: usize, elements: &mut [u8]) {
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => bytes(elements, |v| {
            let v = v.map(|byte| i32::from(byte as i8));
            octahedral(v, 127.0).map(|n| n as i8 as u8)
        }),
        (Filter::Octahedral, _) => words(elements, |v| {
            let v = v.map(|word| i32::from(word as i16));
            octahedral(v, 32767.0).map(|n| n as i16 as u16)
        }),
        (Filter::Quaternion, _) => words(elements, quaternion),
        (Filter::Exponential, _) => {
            for float in elements.as_chunks_mut().0 {
                *float = exponential(i32::from_le_bytes(*float)).to_le_bytes();
            }
        }
        (Filter::Color, 4) => bytes(elements, |[y, co, cg, a]| {
            let chroma = [co, cg].map(|byte| i32::from(byte as i8));
            color(i32::from(y), chroma, u32::from(a), 255.0).map(|n| n as u8)
        }),
        (Filter::Color, _) => words(elements, |[y, co, cg, a]| {
            let chroma = [co, cg].map(|word| i32::from(word as i16));
            color(i32::from(y), chroma, u32::from(a), 65535.0).map(|n| n as u16)
        }),
    }
}

fn bytes(elements: &mut [u8], convert: impl Fn([u8; 4]) -> [u8; 4]) {
    for element in elements.as_chunks_mut().0 {
        *element = convert(*element);
    }
}

fn words(elements: &mut [u8], convert: impl Fn([u16; 4]) -> [u16; 4]) {
    for element in elements.as_chunks_mut::<8>().0 {
        let word = |k: usize| u16::from_le_bytes([element[2 * k], element[2 * k + 1]]);
        let converted = convert(std::array::from_fn(word));
        for (bytes, word) in element.as_chunks_mut().0.iter_mut().zip(converted) {
            *bytes = word.to_le_bytes();
        }
    }
}

/// A unit vector from x and y on the octahedron, with `one` as third component.
fn octahedral([x, y, one, rest]: [i32; 4], largest: f32) -> [f32; 4] {
    let [x, y] = [x, y].map(|v| v as f32 / one as f32);
    let z = 1.0 - x.abs() - y.abs();
    // The lower half is folded outwards.
    let fold = z.min(0.0);
    let [x, y] = [x, y].map(|v| v - fold.copysign(v));
    let scale = largest / (x * x + y * y + z * z).sqrt();
    let [x, y, z] = [x, y, z].map(|v| (v * scale).round());
    [x, y, z, rest as f32]
}

/// A unit quaternion from all but its largest component, which the lowest two bits name.
fn quaternion(v: [u16; 4]) -> [u16; 4] {
    let [a, b, c, one] = v.map(|word| word as i16);
    let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(one | 3);
    let [a, b, c] = [a, b, c].map(|v| f32::from(v) * scale);
    let largest = (1.0 - a * a - b * b - c * c).max(0.0).sqrt();
    let mut components = [largest, a, b, c].map(|v| (v * 32767.0).round() as i16 as u16);
    components.rotate_right(usize::from(one as u16 & 3));
    components
}

/// `m · 2^e`, of the lower 24 bits and the upper 8.
fn exponential(code: i32) -> f32 {
    let (exponent, mantissa) = (code >> 24, (code << 8) >> 8);
    (f64::from(mantissa) * f64::from(exponent).exp2()) as f32
}

/// Red, green, blue and alpha from luma and chroma; the highest bit of `alpha` says how fine.
fn color(y: i32, [co, cg]: [i32; 2], alpha: u32, largest: f32) -> [f32; 4] {
    // All bits up to and with the highest of alpha, which is not one of its own.
    let all = (1_u32 << (u32::BITS - alpha.leading_zeros())) - 1;
    let a = alpha & (all >> 1);
    let a = (a << 1) | (a & 1);
    let scale = largest / all as f32;
    [y + co - cg, y + cg, y - co - cg, a as i32].map(|v| (v as f32 * scale).round())
}
