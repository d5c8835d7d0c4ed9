//! Russian roulette: ends paths without bias ([Veach 1997] 10.4.1).

use crate::radiometry::Rgb;

/// The bounce from which paths may end. Ending them costs noise in the bounces beyond and saves their time: on a Cornell
/// box, from the third bounce on is where time to a given error is shortest. Nothing is decided where a direction was
/// drawn from a delta lobe: glass takes little from a path, and a caustic would be played for at each of its surfaces.
pub const FIRST_BOUNCE: u32 = 3;

/// Probability to go on for a path of the given throughput, relative to `1` at its start.
///
/// Its root: where what a path finds varies as much as its mean, a probability proportional to the root of the
/// second moment over the cost is the most efficient (Bolin and Meyer 1997; Rath et al. 2022, "EARS"); bounces
/// that are looked at one by one keep more of their paths than the throughput itself would leave them.
#[inline]
#[must_use]
pub fn survival(throughput: Rgb) -> f32 {
    throughput.max_channel().max(0.0).sqrt().clamp(0.05, 1.0)
}
