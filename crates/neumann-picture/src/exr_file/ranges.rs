//! Which iterations a film is the mean of.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Disjoint ranges of iteration numbers, in order, none empty and no two touching.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IterationRanges(Vec<Range<u32>>);

impl IterationRanges {
    /// One range; none if it is empty.
    #[must_use]
    pub fn of(range: Range<u32>) -> Self {
        Self(if range.is_empty() {
            vec![]
        } else {
            vec![range]
        })
    }

    /// The ranges.
    #[must_use]
    pub fn ranges(&self) -> &[Range<u32>] {
        &self.0
    }

    /// Number of iterations.
    #[must_use]
    pub fn count(&self) -> u32 {
        let sum: u64 = self.0.iter().map(|r| u64::from(r.end - r.start)).sum();
        u32::try_from(sum).unwrap_or(u32::MAX)
    }

    /// The first iteration, 0 if there is none.
    #[must_use]
    pub fn first(&self) -> u32 {
        self.0.first().map_or(0, |r| r.start)
    }

    /// One beyond the last iteration, 0 if there is none.
    #[must_use]
    pub fn end(&self) -> u32 {
        self.0.last().map_or(0, |r| r.end)
    }

    /// The iterations that both have.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        let mut common = Vec::new();
        for a in &self.0 {
            for b in &other.0 {
                let range = a.start.max(b.start)..a.end.min(b.end);
                if !range.is_empty() {
                    common.push(range);
                }
            }
        }
        Self::sorted(common)
    }

    /// The iterations that either has.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self::sorted(self.0.iter().chain(&other.0).cloned().collect())
    }

    fn sorted(mut ranges: Vec<Range<u32>>) -> Self {
        ranges.sort_by_key(|r| (r.start, r.end));
        let mut joined: Vec<Range<u32>> = Vec::new();
        for range in ranges {
            match joined.last_mut() {
                Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
                _ => joined.push(range),
            }
        }
        Self(joined)
    }
}

impl fmt::Display for IterationRanges {
    /// As `0-63,128-191`, last ones included; `none` if there is none.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return f.write_str("none");
        }
        for (i, range) in self.0.iter().enumerate() {
            let comma = if i == 0 { "" } else { "," };
            write!(f, "{comma}{}-{}", range.start, range.end - 1)?;
        }
        Ok(())
    }
}

/// The text is not a list of ranges.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is not a list of iterations such as 0-63,128-191")]
pub struct RangesError(String);

impl FromStr for IterationRanges {
    type Err = RangesError;

    fn from_str(text: &str) -> Result<Self, RangesError> {
        if text == "none" {
            return Ok(Self::default());
        }
        let parse = |part: &str| {
            let (first, last) = part.split_once('-')?;
            let (first, last) = (first.parse::<u32>().ok()?, last.parse::<u32>().ok()?);
            let end = last.checked_add(1)?;
            (first < end).then_some(first..end)
        };
        let ranges: Option<Vec<Range<u32>>> = text.split(',').map(parse).collect();
        let is_ordered = |r: &Vec<Range<u32>>| r.windows(2).all(|pair| pair[0].end < pair[1].start);
        ranges
            .filter(is_ordered)
            .map(Self)
            .ok_or_else(|| RangesError(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::IterationRanges;

    #[test]
    fn ranges_join_where_they_touch() {
        let low = IterationRanges::of(0..32);
        let high = IterationRanges::of(64..96);
        let both = low.union(&high);
        assert_eq!(both.to_string(), "0-31,64-95");
        assert_eq!((both.count(), both.first(), both.end()), (64, 0, 96));
        let whole = both.union(&IterationRanges::of(32..64));
        assert_eq!(whole, IterationRanges::of(0..96));
    }

    #[test]
    fn common_iterations_are_found() {
        let ranges: IterationRanges = "0-9,20-29".parse().unwrap();
        let common = ranges.intersection(&IterationRanges::of(8..25));
        assert_eq!(common.to_string(), "8-9,20-24");
        assert_eq!(ranges.intersection(&IterationRanges::of(10..20)).count(), 0);
    }

    #[test]
    fn text_reads_back_and_nonsense_does_not() {
        for text in ["none", "0-63,128-191", "7-7"] {
            let ranges: IterationRanges = text.parse().unwrap();
            assert_eq!(ranges.to_string(), text);
        }
        for text in [
            "",
            "5",
            "9-3",
            "-4",
            "0-4294967295",
            "a-b",
            "0-7,4-9",
            "8-9,0-3",
            "0-7,8-9",
        ] {
            assert!(text.parse::<IterationRanges>().is_err(), "{text}");
        }
    }
}
