//! How much a file may cost to decode.
//!
//! A small file can ask for a lot: a thousand primitives may share one large
//! accessor, an accessor without data may claim any number of zeros. Whatever
//! is decoded from accessors is therefore paid from one allowance, which grows
//! with the bytes that the file really has. It bounds memory and time alike.

use std::cell::{Cell, RefCell};

use super::error::Fault;
use crate::memory::Share;

/// Bytes of decoded geometry that every file may have, however small it is.
const BASE_ALLOWANCE: u64 = 512 << 20;

/// Bytes of decoded geometry for each byte of the file's buffers: a strip of
/// `u8` indices grows twelvefold, everything else less.
const ALLOWANCE_PER_BYTE: u64 = 16;

/// What may still be decoded.
#[derive(Debug)]
pub(super) struct Allowance {
    bytes: Cell<u64>,
    /// What has been spent, as a share of the process's memory while the file is read.
    memory: RefCell<Share>,
}

impl Allowance {
    /// The allowance of a file whose buffers have `n_buffer_bytes`.
    pub(super) fn new(n_buffer_bytes: u64) -> Self {
        let bytes = n_buffer_bytes
            .saturating_mul(ALLOWANCE_PER_BYTE)
            .saturating_add(BASE_ALLOWANCE);
        Self {
            bytes: Cell::new(bytes),
            memory: RefCell::default(),
        }
    }

    /// Pays for `count` things of `size` bytes before they are allocated.
    pub(super) fn spend(&self, count: usize, size: usize, field: &str) -> Result<(), Fault> {
        let bytes = (count as u64).saturating_mul(size as u64);
        match self.bytes.get().checked_sub(bytes) {
            Some(rest) => {
                let mut memory = self.memory.borrow_mut();
                let paid = memory.grow(bytes);
                paid.map_err(|shortage| Fault::short(field, "", shortage))?;
                self.bytes.set(rest);
                Ok(())
            }
            None => Err(Fault::new(
                field,
                format!(
                    "needs {bytes} more bytes once decoded, out of proportion to the size of the \
                     file"
                ),
                "split the file, or let its primitives not share one huge accessor",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Allowance;

    #[test]
    fn the_allowance_ends() {
        let allowance = Allowance::new(0);
        assert!(allowance.spend(1 << 20, 12, "a").is_ok());
        assert!(allowance.spend(usize::MAX, 12, "a").is_err());
        while allowance.spend(1 << 20, 12, "a").is_ok() {}
        assert!(allowance.spend(1, 1 << 24, "a").is_err());
    }
}
