//! Single-precision numbers that read back with the same bits.
//!
//! A JSON reader takes a number for one of double precision, and may be off by its last place. The
//! shortest text that stands for a number of single precision is written where that does no harm,
//! which is nearly always; otherwise all of its digits are.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A finite number that comes back from a file with the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exact(pub f32);

impl Exact {
    /// Each of several numbers.
    #[must_use]
    pub fn all<const N: usize>(values: [f32; N]) -> [Self; N] {
        values.map(Self)
    }

    /// The numbers themselves.
    #[must_use]
    pub fn values<const N: usize>(all: [Self; N]) -> [f32; N] {
        all.map(|value| value.0)
    }
}

impl Serialize for Exact {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let wide = f64::from(self.0);
        let short = self.0.to_string().parse().unwrap_or(wide);
        let is_safe = [short.next_down(), short, short.next_up()]
            .into_iter()
            .all(|near| (near as f32).to_bits() == self.0.to_bits());
        serializer.serialize_f64(if is_safe { short } else { wide })
    }
}

impl<'de> Deserialize<'de> for Exact {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = f64::deserialize(deserializer)? as f32;
        if value.is_finite() {
            Ok(Self(value))
        } else {
            Err(D::Error::custom(
                "the number is too large; use one below 3e38",
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Exact;

    fn there_and_back(value: f32) -> (String, f32) {
        let text = serde_json::to_string(&Exact(value)).unwrap();
        let Exact(back) = serde_json::from_str(&text).unwrap();
        (text, back)
    }

    #[test]
    fn numbers_come_back_with_their_bits() {
        let odd = [0.0, -0.0, f32::MIN_POSITIVE, 1e-45, f32::MAX, 16_777_216.0];
        // A walk over all exponents and many mantissas.
        let walk = (0..200_000u32).map(|i| f32::from_bits(i.wrapping_mul(2_654_435_761)));
        for value in odd.into_iter().chain(walk).filter(|v| v.is_finite()) {
            let (text, back) = there_and_back(value);
            assert_eq!(back.to_bits(), value.to_bits(), "{text}");
        }
    }

    #[test]
    fn numbers_are_written_short() {
        assert_eq!(there_and_back(0.1).0, "0.1");
        assert_eq!(there_and_back(-2.5).0, "-2.5");
    }

    #[test]
    fn numbers_without_bounds_are_refused() {
        for text in ["1e39", "-1e300", "null", "\"1\""] {
            assert!(serde_json::from_str::<Exact>(text).is_err(), "{text}");
        }
    }
}
