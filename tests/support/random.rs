//! Independent random numbers for tests that draw samples themselves.

use neumann_core::sampling::Sampler;

/// A stream of the program's own random numbers, one path after the other, so
/// that successive draws are independent (those of one path over its iterations are not).
#[derive(Clone, Debug)]
pub struct Random {
    seed: u64,
    draw: u64,
}

impl Random {
    /// A stream.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { seed, draw: 0 }
    }

    /// The next numbers: as many as a sampler can give that no one has used yet.
    pub fn sampler(&mut self) -> Sampler<'static> {
        self.draw += 1;
        Sampler::new(self.seed, self.draw, 0)
    }

    /// A point in [0, 1)².
    pub fn pair(&mut self) -> [f32; 2] {
        self.sampler().next_2d()
    }

    /// A point in [0, 1)³: a lobe and a direction within it.
    pub fn triple(&mut self) -> [f32; 3] {
        let mut sampler = self.sampler();
        let [a, b] = sampler.next_2d();
        [sampler.next_1d(), a, b]
    }
}
