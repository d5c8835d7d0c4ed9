//! Numbers that must lie in a range.
//!
//! A value outside of the range that glTF gives it is brought to the range's
//! end, and the user is told; a scene with one odd number can still be seen.

use std::ops::RangeInclusive;

use super::error::{Fault, quoted};
use super::json::Item;
use super::notes::Notes;
use crate::radiometry::Rgb;

/// Where glTF sets no upper end: far above the sun (about 2e7), and two such
/// factors still multiply to something whose square is finite.
pub(super) const LARGEST: f32 = 1e9;

/// Reads numbers of one object (a material, a light) for which warnings speak.
#[derive(Debug)]
pub(super) struct Factors<'a> {
    /// As `material "red"`.
    pub(super) owner: String,
    pub(super) notes: &'a mut Notes,
}

impl<'a> Factors<'a> {
    /// Speaks of the `kind` (material, light) with this name.
    pub(super) fn of(kind: &str, name: &str, notes: &'a mut Notes) -> Self {
        Self {
            owner: format!("{kind} {}", quoted(name)),
            notes,
        }
    }

    /// A number, or `default` when it is absent.
    pub(super) fn number(
        &mut self,
        item: &Item<'_>,
        key: &str,
        default: f32,
        range: RangeInclusive<f32>,
    ) -> Result<f32, Fault> {
        Ok(match item.number(key)? {
            None => default,
            Some(value) => self.in_range(value, &item.path(key), range),
        })
    }

    /// `N` numbers, or `default` when they are absent.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        item: &Item<'_>,
        key: &str,
        default: [f32; N],
        range: &RangeInclusive<f32>,
    ) -> Result<[f32; N], Fault> {
        Ok(match item.numbers(key)? {
            None => default,
            Some(values) => values.map(|v| self.in_range(v, &item.path(key), range.clone())),
        })
    }

    /// A linear colour, or `default` when it is absent.
    pub(super) fn color(
        &mut self,
        item: &Item<'_>,
        key: &str,
        default: Rgb,
        range: &RangeInclusive<f32>,
    ) -> Result<Rgb, Fault> {
        self.numbers(item, key, default.to_array(), range)
            .map(Rgb::from)
    }

    /// The nearest value in the range, with a warning if it is another one.
    fn in_range(&mut self, value: f32, field: &str, range: RangeInclusive<f32>) -> f32 {
        if range.contains(&value) {
            return value;
        }
        let (low, high) = range.into_inner();
        let used = if value.is_nan() {
            low
        } else {
            value.clamp(low, high)
        };
        self.notes.warn(format!(
            "{}: {field} is {value}, outside of {low} to {high}; {used} is used",
            self.owner
        ));
        used
    }
}
