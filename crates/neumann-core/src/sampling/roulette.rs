//! Russian roulette: ends paths without bias ([Veach 1997] 10.4.1).

use crate::radiometry::Rgb;

use super::Sampler;

/// Scattering events that a path goes through before any of them may end it. Ending paths costs noise in the bounces
/// beyond and saves their time: on a Cornell box, three free events are where time to a given error is shortest.
const N_FREE: u32 = 3;

/// Decides whether a path goes on from a scattering event, by one number: the factor by which its throughput grows if
/// it does (at least 1, and 1 without a number where the event is free), `None` where it ends.
///
/// `n_before` are the events before this one, and `throughput` is what remains beyond it, relative to `1` at the path's
/// start. Nothing is to be decided at a delta lobe: glass takes little from a path, and a caustic would be played for at
/// each of its surfaces. Whether these events count, the caller says. Where camera paths alone can find a
/// caustic, they should not: what lies behind glass carries as much as what lies before it (a Cornell box with
/// glass: a tenth less time to the same error). Where light paths find it, they may: it costs nothing and saves some time.
#[inline]
pub fn play(n_before: u32, throughput: Rgb, sampler: &mut Sampler<'_>) -> Option<f32> {
    if n_before < N_FREE {
        return Some(1.0);
    }
    let survival = survival(throughput);
    (sampler.next_1d() < survival).then(|| 1.0 / survival)
}

/// The probability with which [`play`] lets a path go on.
#[inline(always)]
pub(crate) fn survival_after(n_before: u32, throughput: Rgb) -> f32 {
    if n_before < N_FREE {
        1.0
    } else {
        survival(throughput)
    }
}

/// Probability to go on for a path of the given throughput, relative to `1` at its start.
///
/// Its root: where what a path finds varies as much as its mean, a probability proportional to the root of the
/// second moment over the cost is the most efficient (Bolin and Meyer 1997; Rath et al. 2022, "EARS"); bounces
/// that are looked at one by one keep more of their paths than the throughput itself would leave them.
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
            let mut sampler = Sampler::new(3, 1, i);
            if let Some(factor) = play(N_FREE, Rgb::splat(0.25), &mut sampler) {
                sum += factor;
                n_alive += 1;
            }
        }
        assert_eq!((sum, n_alive), (n as f32, n / 2));
    }

    #[test]
    fn the_first_events_end_nothing() {
        let mut sampler = Sampler::new(3, 1, 0);
        let factors = (0..N_FREE).map(|n| play(n, Rgb::BLACK, &mut sampler));
        assert!(factors.eq([Some(1.0); N_FREE as usize]));
    }
}
