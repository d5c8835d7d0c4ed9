//! Logarithmic axes of charts, and their ticks. Whoever draws puts them where it likes.

use crate::figures::significant;

/// A logarithmic axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Decimal logarithms of its ends.
    range: [f64; 2],
    /// Its ticks, lowest first.
    pub ticks: Vec<Tick>,
}

/// A tick of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Where, from 0 to 1.
    pub at: f64,
    /// The number there; empty where a line is enough.
    pub label: String,
}

impl Axis {
    /// An axis from a little below the least value to a little above the largest; at least half a
    /// decade long.
    #[must_use]
    pub fn around(values: impl Iterator<Item = f64>) -> Option<Self> {
        let logarithms = values.filter(|v| v.is_finite() && *v > 0.0).map(f64::log10);
        let ends = logarithms.fold(None, |ends: Option<[f64; 2]>, v| {
            Some(ends.map_or([v, v], |[least, most]| [least.min(v), most.max(v)]))
        });
        let [least, most] = ends?;
        let margin = (0.5 * (0.5 - (most - least)))
            .max(0.05 * (most - least))
            .max(0.02);
        let range = [least - margin, most + margin];
        Some(Self {
            ticks: ticks(range),
            range,
        })
    }

    /// Its length, in powers of ten.
    #[must_use]
    pub fn decades(&self) -> f64 {
        self.range[1] - self.range[0]
    }

    /// Where a value is, 0 to 1 within the axis.
    #[must_use]
    pub fn place(&self, value: f64) -> Option<f64> {
        let [from, to] = self.range;
        (value.is_finite() && value > 0.0).then(|| (value.log10() - from) / (to - from))
    }

    /// The value at a place.
    #[must_use]
    pub fn value(&self, place: f64) -> f64 {
        let [from, to] = self.range;
        10f64.powf(from + place * (to - from))
    }
}

/// Powers of ten, and where there are few, twice and five times them as well.
fn ticks([from, to]: [f64; 2]) -> Vec<Tick> {
    let n_decades = to - from;
    let factors: &[f64] = if n_decades < 2.5 {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0]
    };
    // So many decades a label.
    let step = (n_decades / 6.0).ceil().max(1.0) as i32;
    let exponents = (from.floor() as i32)..=(to.ceil() as i32);
    let all = exponents.flat_map(|exponent| factors.iter().map(move |f| (exponent, *f)));
    all.filter_map(|(exponent, factor)| {
        let logarithm = f64::from(exponent) + factor.log10();
        let at = (logarithm - from) / (to - from);
        (0.0..=1.0).contains(&at).then(|| Tick {
            at,
            label: if exponent.rem_euclid(step) == 0 {
                significant(factor * 10f64.powi(exponent), 1)
            } else {
                String::new()
            },
        })
    })
    .collect()
}
