//! Russian roulette: ends paths without bias ([Veach 1997] 10.4.1).

use crate::radiometry::Rgb;

/// The bounce from which paths may end: the terms that a film keeps apart by default are never
/// thinned out, since each of them is there to be looked at.
pub const FIRST_BOUNCE: u32 = 7;

/// Probability to go on for a path of the given throughput, relative to `1` at its start.
#[inline]
#[must_use]
pub fn survival(throughput: Rgb) -> f32 {
    throughput.max_channel().clamp(0.05, 1.0)
}
