//! Indices: steps from either of two running ones.

use super::{Rest, signed, write_index};
use crate::decode::DecodeError;

/// Zeros at the end, for fast decoders.
const N_TAIL: usize = 4;

/// Fills `elements` with indices.
pub(super) fn decode(stream: &[u8], stride: usize, elements: &mut [u8]) -> Result<(), DecodeError> {
    let (mut data, _, _) = Rest::open(stream, &[0xd1], |_| N_TAIL)?;
    let mut running = [0_u32; 2];
    for element in elements.chunks_exact_mut(stride) {
        let code = data.varint()?;
        let index = &mut running[(code & 1) as usize];
        *index = index.wrapping_add(signed(code >> 1));
        write_index(element, *index);
    }
    data.end()
}
