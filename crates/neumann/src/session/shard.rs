//! One of several equal parts of a render, for several machines.

use std::ops::Range;
use std::str::FromStr;

/// Part number `number` of `count`, from 1 on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    number: u32,
    count: u32,
}

impl Shard {
    /// The iterations of this part. Parts are disjoint, together they are all iterations, and their
    /// lengths differ by one at most.
    pub(crate) fn part_of(self, all: Range<u32>) -> Range<u32> {
        let n = u64::from(all.end - all.start);
        let start_of = |number: u32| {
            let before = n * u64::from(number - 1) / u64::from(self.count);
            all.start + before as u32
        };
        start_of(self.number)..start_of(self.number + 1)
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

/// Parts of a render, at most.
const MAX_COUNT: u32 = 1_000_000;

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (number, count) = text.split_once('/')?;
            let (number, count) = (number.trim().parse().ok()?, count.trim().parse().ok()?);
            Some(Self { number, count })
        };
        parse()
            .filter(|s| (1..=MAX_COUNT).contains(&s.count) && (1..=s.count).contains(&s.number))
            .ok_or_else(|| {
                "use I/N such as 3/8, the third of eight parts; I goes from 1 to N".to_owned()
            })
    }
}

#[cfg(test)]
mod tests {
    use super::Shard;

    #[test]
    fn parts_are_disjoint_and_together_all() {
        for (all, count) in [(0..64, 8), (5..105, 7), (0..u32::MAX, 3), (2..5, 8)] {
            let mut next = all.start;
            for number in 1..=count {
                let part = Shard { number, count }.part_of(all.clone());
                assert_eq!(part.start, next, "{all:?} {number}/{count}");
                let even = (all.end - all.start) / count;
                assert!((even..=even + 1).contains(&(part.end - part.start)));
                next = part.end;
            }
            assert_eq!(next, all.end);
        }
    }

    #[test]
    fn parts_count_from_one() {
        let third = Shard {
            number: 3,
            count: 8,
        };
        assert_eq!("3/8".parse(), Ok(third));
        assert_eq!(third.to_string(), "3/8");
        for text in ["0/8", "9/8", "3", "3/0", "-1/8", "a/b", "", "1/9999999"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
