//! Attributes: each byte as its difference from that of the element before.
//!
//! Elements come in blocks. A block has, for each byte of the element, the differences of all its
//! elements, sixteen to a group; a group spends 0, 1, 2, 4 or 8 bits on each of them. Version 1
//! (`0xa1`) can skip a byte or store it plainly, and knows differences of words and of bits.

use super::{Rest, broken};
use crate::decode::DecodeError;

/// Elements of a group.
const GROUP: usize = 16;

/// Elements of the largest block.
const MOST_ELEMENTS: usize = 256;

/// What the differences of four neighbouring bytes are.
#[derive(Clone, Copy, Debug)]
enum Channel {
    Bytes,
    Words,
    /// Bits that change, rotated left by so much.
    Bits(u32),
}

/// Fills `elements`, whose number and stride are allowed ones.
pub(super) fn decode(stream: &[u8], stride: usize, elements: &mut [u8]) -> Result<(), DecodeError> {
    let n_channels = stride / 4;
    // The tail is padded, so that fast decoders may read beyond the blocks.
    let n_tail = |header| match header {
        0xa0 => stride.max(32),
        _ => (stride + n_channels).max(24),
    };
    let (mut rest, header, tail) = Rest::open(stream, &[0xa1, 0xa0], n_tail)?;
    let is_plain = header == 0xa0;
    let (before, modes) = if is_plain {
        (&tail[tail.len() - stride..], &[][..])
    } else {
        tail[tail.len() - stride - n_channels..].split_at(stride)
    };
    let mut channels = vec![Channel::Bytes; n_channels];
    for (channel, &mode) in channels.iter_mut().zip(modes) {
        *channel = Channel::from_mode(mode)?;
    }
    let mut last = before.to_vec();
    let n_block = (8192 / stride / GROUP * GROUP).min(MOST_ELEMENTS);
    for block in elements.chunks_mut(n_block * stride) {
        let n_elements = block.len() / stride;
        let controls = if is_plain {
            &[][..]
        } else {
            rest.take(n_channels)?
        };
        for (k, channel) in channels.iter().enumerate() {
            // The differences of four bytes, byte by byte.
            let mut planes = [[0; MOST_ELEMENTS]; 4];
            for (byte, plane) in planes.iter_mut().enumerate() {
                let plane = &mut plane[..n_elements.next_multiple_of(GROUP)];
                match controls.get(k).map(|control| (control >> (2 * byte)) & 3) {
                    None => read_groups(&mut rest, [0, 2, 4, 8], plane)?,
                    Some(0) => read_groups(&mut rest, [0, 1, 2, 4], plane)?,
                    Some(1) => read_groups(&mut rest, [1, 2, 4, 8], plane)?,
                    Some(2) => {}
                    _ => plane[..n_elements].copy_from_slice(rest.take(n_elements)?),
                }
            }
            let at = 4 * k;
            let mut value = [last[at], last[at + 1], last[at + 2], last[at + 3]];
            for (i, element) in block.chunks_exact_mut(stride).enumerate() {
                value = channel.next(value, planes.each_ref().map(|plane| plane[i]));
                element[at..at + 4].copy_from_slice(&value);
            }
            last[at..at + 4].copy_from_slice(&value);
        }
    }
    rest.end()
}

impl Channel {
    fn from_mode(mode: u8) -> Result<Self, DecodeError> {
        match (mode & 15, mode >> 4) {
            (0, 0) => Ok(Self::Bytes),
            (1, 0) => Ok(Self::Words),
            (2, rotation) => Ok(Self::Bits(u32::from(rotation))),
            _ => Err(broken(format_args!("channel mode {mode:#04x} is unknown"))),
        }
    }

    /// The value after `value`.
    fn next(self, value: [u8; 4], delta: [u8; 4]) -> [u8; 4] {
        match self {
            Self::Bytes => {
                let unfold = |code: u8| (code >> 1) ^ (code & 1).wrapping_neg();
                std::array::from_fn(|k| value[k].wrapping_add(unfold(delta[k])))
            }
            Self::Words => {
                let word = |k: usize| {
                    let code = u16::from_le_bytes([delta[k], delta[k + 1]]);
                    let step = (code >> 1) ^ (code & 1).wrapping_neg();
                    u16::from_le_bytes([value[k], value[k + 1]])
                        .wrapping_add(step)
                        .to_le_bytes()
                };
                let ([a, b], [c, d]) = (word(0), word(2));
                [a, b, c, d]
            }
            Self::Bits(rotation) => {
                let change = u32::from_le_bytes(delta).rotate_left(rotation);
                (u32::from_le_bytes(value) ^ change).to_le_bytes()
            }
        }
    }
}

/// Reads the groups of one byte, each with one of four numbers of bits.
fn read_groups(rest: &mut Rest<'_>, n_bits: [u32; 4], plane: &mut [u8]) -> Result<(), DecodeError> {
    let n_groups = plane.len() / GROUP;
    let choices = rest.take(n_groups.div_ceil(4))?;
    for (i, group) in plane.chunks_exact_mut(GROUP).enumerate() {
        let choice = (choices[i / 4] >> (2 * (i % 4))) & 3;
        read_group(rest, n_bits[usize::from(choice)], group)?;
    }
    Ok(())
}

/// Reads sixteen differences; one whose bits are all set stands in a byte after them.
fn read_group(rest: &mut Rest<'_>, n_bits: u32, group: &mut [u8]) -> Result<(), DecodeError> {
    if n_bits == 0 {
        group.fill(0);
        return Ok(());
    }
    let packed = rest.take(2 * n_bits as usize)?;
    if n_bits == 8 {
        group.copy_from_slice(packed);
        return Ok(());
    }
    let escape = (1 << n_bits) - 1;
    let per_byte = 8 / n_bits as usize;
    for (i, delta) in group.iter_mut().enumerate() {
        let place = (i % per_byte) as u32;
        // Single bits begin at the lowest, longer ones at the highest.
        let shift = if n_bits == 1 {
            place
        } else {
            8 - n_bits * (place + 1)
        };
        *delta = (packed[i / per_byte] >> shift) & escape;
        if *delta == escape {
            *delta = rest.byte()?;
        }
    }
    Ok(())
}
