//! Russian roulette: ends paths without bias ([Veach 1997] 10.4.1).

use crate::radiometry::Rgb;

/// Scattering events that a path goes through before they may end it, unless it carries very
/// little. Ending paths costs noise in the bounces beyond and saves their time: on a Cornell box,
/// three free events are where time to a given error is shortest.
const N_FREE: u32 = 3;
/// They end none that carries at least this share of what it started with. A path that carries less
/// has met something dark, or gone where many are sent and few are of worth: a Cornell box with
/// glass takes a tenth less time to the same error than if it were let go.
const LITTLE: f32 = 0.125;

/// Decides whether a path goes on from a scattering event, by one number: the factor by which its
/// throughput grows if it does (at least 1), `None` where it ends.
///
/// `n_before` are the events before this one, and `throughput` is what remains beyond it, relative
/// to `1` at the path's start. Nothing is to be decided at a delta lobe: glass takes little from a
/// path, and a caustic would be played for at each of its surfaces. Whether these events count, the
/// caller says. Where camera paths alone can find a caustic, they should not: what lies behind
/// glass carries as much as what lies before it (a Cornell box with glass: a tenth less time to the
/// same error). Where light paths find it, they may: it costs nothing and saves some time.
#[inline]
pub fn play(n_before: u32, throughput: Rgb, number: f32) -> Option<f32> {
    let survival = survival_after(n_before, throughput);
    (number < survival).then(|| 1.0 / survival)
}

/// The probability with which [`play`] lets a path go on.
#[inline(always)]
pub(crate) fn survival_after(n_before: u32, throughput: Rgb) -> f32 {
    let enough = if n_before < N_FREE { LITTLE } else { 1.0 };
    survival(throughput * (1.0 / enough))
}

/// Probability to go on for a path of the given throughput, relative to `1` at its start.
///
/// Its root: where what a path finds varies as much as its mean, a probability proportional to the
/// root of the second moment over the cost is the most efficient (Bolin and Meyer 1997; Rath et al.
/// 2022, "EARS"); bounces that are looked at one by one keep more of their paths than the
/// throughput itself would leave them.
#[inline(always)]
fn survival(throughput: Rgb) -> f32 {
    throughput.max_channel().max(0.0).sqrt().clamp(0.05, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_paths_go_on_and_carry_the_rest() {
        let n = 4096;
        let (mut sum, mut n_alive) = (0.0, 0);
        for i in 0..n {
            let number = (i as f32 + 0.5) / n as f32;
            if let Some(factor) = play(N_FREE, Rgb::splat(0.25), number) {
                sum += factor;
                n_alive += 1;
            }
        }
        assert_eq!((sum, n_alive), (n as f32, n / 2));
    }

    #[test]
    fn the_first_events_end_what_carries_little_and_nothing_else() {
        let factors = (0..N_FREE).map(|n| play(n, Rgb::splat(LITTLE), 0.999));
        assert!(factors.eq([Some(1.0); N_FREE as usize]));
        assert_eq!(survival_after(N_FREE - 1, Rgb::splat(LITTLE / 4.0)), 0.5);
        assert_eq!(survival_after(N_FREE, Rgb::splat(0.25)), 0.5);
    }
}
