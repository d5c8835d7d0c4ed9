//! Multiple importance sampling: weights that add to one ([Veach 1997] ch. 9). Densities may have
//! any measure, if it is the same for both.

/// Balance heuristic for one sample of each of two techniques ([Veach 1997] eq. 9.8).
#[inline]
#[must_use]
pub fn balance_heuristic(density: f32, other_density: f32) -> f32 {
    if density.is_infinite() {
        return 1.0;
    }
    density / (density + other_density)
}

/// Power heuristic with exponent 2 for one sample of each of two techniques ([Veach 1997] 9.2.3.2).
#[inline]
#[must_use]
pub fn power_heuristic(density: f32, other_density: f32) -> f32 {
    // The ratio cannot overflow where the squares of the densities could.
    let ratio = other_density / density;
    1.0 / (1.0 + ratio * ratio)
}

#[cfg(test)]
mod tests {
    use super::{balance_heuristic, power_heuristic};

    #[test]
    fn weights_add_to_one() {
        for (a, b) in [(1.0, 2.0), (1e-20, 3.0), (1e25, 1e24), (5.0, 0.0)] {
            assert!((balance_heuristic(a, b) + balance_heuristic(b, a) - 1.0).abs() < 1e-6);
            assert!((power_heuristic(a, b) + power_heuristic(b, a) - 1.0).abs() < 1e-6);
        }
    }
}
