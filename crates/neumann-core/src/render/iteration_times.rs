//! How long iterations took, to tell whether another one would end in time.

/// The times of the latest iterations, seconds.
#[derive(Clone, Copy, Debug, Default)]
pub struct IterationTimes {
    latest: [f64; N_LATEST],
    n: usize,
}

/// Iterations that are looked back on.
const N_LATEST: usize = 4;

impl IterationTimes {
    /// Takes in the time of an iteration, seconds.
    pub fn take(&mut self, seconds: f64) {
        self.latest[self.n % N_LATEST] = seconds;
        self.n += 1;
    }

    /// How long the next iteration may take: as long as the longest of the latest ones. Zero
    /// before the first one, which so is always begun.
    #[must_use]
    pub fn expected(&self) -> f64 {
        self.latest.into_iter().fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::IterationTimes;

    #[test]
    fn the_longest_of_the_latest_four_is_expected() {
        let mut times = IterationTimes::default();
        assert_eq!(times.expected(), 0.0);
        for (seconds, expected) in [(9.0, 9.0), (2.0, 9.0), (3.0, 9.0), (1.0, 9.0), (2.5, 3.0)] {
            times.take(seconds);
            assert_eq!(times.expected(), expected);
        }
    }
}
