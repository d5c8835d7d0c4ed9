//! How much memory may go to what files hold: one allowance for the process.
//!
//! A small file can ask for a lot: a PNG of 33 kB may hold 16384 by 16384 texels. Whoever
//! decodes a file takes a [`Share`] of the allowance first, allocates what it has paid for
//! with [`filled`], which fails where the system does, and keeps the share as long as the
//! memory. The allowance is half of what is free when it is first asked for, or what
//! [`set_allowed`] says (`--memory`).
//!
//! Films, trees and photons are not counted here: their sizes are asked for by name.

use std::sync::atomic::{AtomicU64, Ordering};

use thiserror::Error;

mod free;

pub use free::free_bytes;

/// What to do about a [`Shortage`].
pub const REMEDY: &str = "allow more with --memory, or make the file's pictures smaller";

/// The allowance where the system does not say how much memory is free.
const UNKNOWN: u64 = 4 << 30;

static PROCESS: Allowance = Allowance::new(0);

/// Sets the allowance, bytes.
pub fn set_allowed(bytes: u64) {
    PROCESS.allowed.store(bytes.max(1), Ordering::Relaxed);
}

/// The allowance, bytes.
#[must_use]
pub fn allowed() -> u64 {
    PROCESS.allowed()
}

/// What may still be taken, bytes.
#[must_use]
pub fn left() -> u64 {
    PROCESS.left()
}

/// Memory that cannot be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Shortage {
    /// The allowance does not reach.
    #[error(
        "needs {} of memory, but {} of the {} for files are left",
        amount(*needed), amount(*left), amount(*allowed)
    )]
    Allowance {
        /// What was asked for, bytes.
        needed: u64,
        /// What could have been had, bytes.
        left: u64,
        /// The allowance, bytes.
        allowed: u64,
    },
    /// The system has no more.
    #[error("needs {} of memory, which the system does not give", amount(*needed))]
    System {
        /// What was asked for, bytes.
        needed: u64,
    },
}

/// A part of the allowance, given back when it is dropped.
#[derive(Debug)]
pub struct Share {
    of: &'static Allowance,
    bytes: u64,
}

impl Default for Share {
    fn default() -> Self {
        Self {
            of: &PROCESS,
            bytes: 0,
        }
    }
}

impl Share {
    /// Takes a part of the process's allowance.
    ///
    /// # Errors
    /// If less is left.
    pub fn of_process(bytes: u64) -> Result<Self, Shortage> {
        let mut share = Self::default();
        share.grow(bytes)?;
        Ok(share)
    }

    /// Its size, bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Takes more.
    ///
    /// # Errors
    /// If less is left; the share stays as it is.
    pub fn grow(&mut self, bytes: u64) -> Result<(), Shortage> {
        self.of.take(bytes)?;
        self.bytes += bytes;
        Ok(())
    }

    /// Gives back whatever is beyond `bytes`.
    pub fn shrink_to(&mut self, bytes: u64) {
        let rest = self.bytes.saturating_sub(bytes);
        self.of.give_back(rest);
        self.bytes -= rest;
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        self.of.give_back(self.bytes);
    }
}

/// `n` copies of a value, in memory that the caller has paid for.
///
/// # Errors
/// If the system does not give so much.
pub fn filled<T: Clone>(value: T, n: usize) -> Result<Vec<T>, Shortage> {
    let mut values = empty(n)?;
    values.resize(n, value);
    Ok(values)
}

/// An empty vector with room for `n` values, in memory that the caller has paid for.
///
/// # Errors
/// If the system does not give so much.
pub fn empty<T>(n: usize) -> Result<Vec<T>, Shortage> {
    let mut values = Vec::new();
    values.try_reserve_exact(n).map_err(|_| Shortage::System {
        needed: bytes_of::<T>(n),
    })?;
    Ok(values)
}

/// The bytes that `n` values take.
#[must_use]
pub fn bytes_of<T>(n: usize) -> u64 {
    (n as u64).saturating_mul(size_of::<T>() as u64)
}

/// A number of bytes for people, in powers of ten.
#[must_use]
pub fn amount(bytes: u64) -> String {
    let b = bytes as f64;
    match bytes {
        0..1_000 => format!("{bytes} bytes"),
        1_000..1_000_000 => format!("{:.1} kB", b * 1e-3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", b * 1e-6),
        _ => format!("{:.1} GB", b * 1e-9),
    }
}

/// What may be taken, and what is taken.
#[derive(Debug)]
struct Allowance {
    /// 0 until it is known.
    allowed: AtomicU64,
    taken: AtomicU64,
}

impl Allowance {
    const fn new(allowed: u64) -> Self {
        Self {
            allowed: AtomicU64::new(allowed),
            taken: AtomicU64::new(0),
        }
    }

    fn allowed(&self) -> u64 {
        match self.allowed.load(Ordering::Relaxed) {
            0 => {
                let half = free_bytes().map_or(UNKNOWN, |free| (free / 2).max(1));
                let set =
                    self.allowed
                        .compare_exchange(0, half, Ordering::Relaxed, Ordering::Relaxed);
                set.map_or_else(|already| already, |_| half)
            }
            known => known,
        }
    }

    fn left(&self) -> u64 {
        self.allowed()
            .saturating_sub(self.taken.load(Ordering::Relaxed))
    }

    fn take(&self, bytes: u64) -> Result<(), Shortage> {
        let allowed = self.allowed();
        let more = |taken: u64| {
            taken
                .checked_add(bytes)
                .filter(|sum| bytes == 0 || *sum <= allowed)
        };
        self.taken
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, more)
            .map(|_| ())
            .map_err(|taken| Shortage::Allowance {
                needed: bytes,
                left: allowed.saturating_sub(taken),
                allowed,
            })
    }

    fn give_back(&self, bytes: u64) {
        self.taken.fetch_sub(bytes, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::{Allowance, Share, Shortage, amount, filled};

    fn share(of: &'static Allowance) -> Share {
        Share { of, bytes: 0 }
    }

    #[test]
    fn shares_end_where_the_allowance_does_and_come_back() {
        static ALLOWANCE: Allowance = Allowance::new(100);
        let (mut a, mut b) = (share(&ALLOWANCE), share(&ALLOWANCE));
        a.grow(60).unwrap();
        let shortage = Shortage::Allowance {
            needed: 50,
            left: 40,
            allowed: 100,
        };
        assert_eq!(b.grow(50), Err(shortage));
        assert!(b.grow(u64::MAX).is_err());
        assert_eq!((b.bytes(), ALLOWANCE.left()), (0, 40));
        a.shrink_to(10);
        b.grow(50).unwrap();
        drop((a, b));
        assert_eq!(ALLOWANCE.left(), 100);
    }

    #[test]
    fn a_shortage_says_what_is_needed_and_what_there_is() {
        static ALLOWANCE: Allowance = Allowance::new(1 << 20);
        let error = share(&ALLOWANCE).grow(5 << 30).unwrap_err().to_string();
        assert_eq!(
            error,
            "needs 5.4 GB of memory, but 1.0 MB of the 1.0 MB for files are left"
        );
        assert_eq!(amount(999), "999 bytes");
        assert!(
            filled(0u64, usize::MAX / 16).is_err(),
            "no machine has that"
        );
        assert_eq!(filled(7u8, 3), Ok(vec![7; 3]));
    }
}
