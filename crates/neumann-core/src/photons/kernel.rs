//! How much a photon counts by its distance.

use std::f32::consts::FRAC_1_PI;

/// A kernel over the disk of a radius that integrates to one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// The same everywhere: `1 / πr²`.
    Constant,
    /// `2 / πr² · (1 - d²/r²)`: no edges, at a little more noise.
    Epanechnikov,
}

impl Kernel {
    /// Its value at a squared distance, 1/m².
    #[inline]
    #[must_use]
    pub fn at(self, distance_squared: f32, radius_squared: f32) -> f32 {
        let flat = FRAC_1_PI / radius_squared;
        match self {
            Self::Constant => flat,
            Self::Epanechnikov => 2.0 * flat * (1.0 - distance_squared / radius_squared).max(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Kernel;

    #[test]
    fn kernels_integrate_to_one() {
        let radius = 0.3f32;
        for kernel in [Kernel::Constant, Kernel::Epanechnikov] {
            let n = 10_000;
            let sum: f64 = (0..n)
                .map(|i| {
                    let d = radius * (i as f32 + 0.5) / n as f32;
                    let ring = std::f32::consts::TAU * d * radius / n as f32;
                    f64::from(kernel.at(d * d, radius * radius) * ring)
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-4, "{kernel:?}: {sum}");
        }
    }
}
