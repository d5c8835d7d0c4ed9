//! Light paths, which belong to no pixel: their random numbers, and what they leave behind.

use std::ops::Range;

use rayon::prelude::*;

use crate::sampling::Sampler;

/// The random numbers of light paths: one low-discrepancy sequence runs through all of an
/// iteration's paths and on through the next iteration's, so that together they cover the lights
/// evenly.
#[derive(Clone, Copy, Debug)]
pub struct LightNumbers {
    pub(super) seed: u64,
    /// Where this iteration's paths begin in the sequence.
    pub(super) first: u64,
}

impl LightNumbers {
    /// The numbers of a light path.
    #[inline]
    #[must_use]
    pub fn path(&self, index: usize) -> Sampler<'static> {
        Sampler::of_sequence(self.seed, self.first + index as u64)
    }
}

/// The random numbers of some light paths, one path after the other.
#[derive(Clone, Debug)]
pub struct LightPaths {
    pub(super) numbers: LightNumbers,
    pub(super) range: Range<usize>,
}

impl LightPaths {
    /// The number of the next path in its iteration.
    #[must_use]
    pub fn next_number(&self) -> usize {
        self.range.start
    }
}

impl Iterator for LightPaths {
    type Item = Sampler<'static>;

    #[inline]
    fn next(&mut self) -> Option<Sampler<'static>> {
        Some(self.numbers.path(self.range.next()?))
    }
}

/// What light paths left behind, path by path.
#[derive(Clone, Debug)]
pub struct Collected<T> {
    /// Everything, in the order of the paths.
    pub items: Vec<T>,
    /// `ends[path]`: index after the path's last item.
    pub(super) ends: Vec<u32>,
}

impl<T> Default for Collected<T> {
    fn default() -> Self {
        Self {
            items: Vec::new(),
            ends: Vec::new(),
        }
    }
}

impl<T> Collected<T> {
    /// What one path left.
    #[inline]
    #[must_use]
    pub fn of_path(&self, path: usize) -> &[T] {
        let start = if path == 0 { 0 } else { self.ends[path - 1] };
        &self.items[start as usize..self.ends[path] as usize]
    }

    /// The path that has left an item.
    #[must_use]
    pub fn path_of(&self, item: u32) -> u32 {
        self.ends.partition_point(|end| *end <= item) as u32
    }

    /// Number of paths.
    #[must_use]
    pub fn n_paths(&self) -> usize {
        self.ends.len()
    }

    /// Items of the paths so far; those behind them are of earlier paths.
    pub(super) fn n_written(&self) -> usize {
        self.ends.last().map_or(0, |end| *end as usize)
    }
}

impl<T: Copy> Collected<T> {
    /// Sorts what `n_paths` paths left, each with the number of its path; what one path left stays
    /// in its order.
    pub fn sort(&mut self, kept: &[(u32, T)], n_paths: usize) {
        self.ends.clear();
        self.ends.resize(n_paths, 0);
        let Some((_, any)) = kept.first() else {
            self.items.clear();
            return;
        };
        // First how many each path has, then where it goes on; at the end, where it ends.
        for (path, _) in kept {
            self.ends[*path as usize] += 1;
        }
        let mut start = 0;
        for end in &mut self.ends {
            start += std::mem::replace(end, start);
        }
        self.items.resize(kept.len(), *any);
        for (path, item) in kept {
            let next = &mut self.ends[*path as usize];
            self.items[*next as usize] = *item;
            *next += 1;
        }
    }
}

impl<T: Copy + Send + Sync> Collected<T> {
    /// Writes more paths behind those so far.
    pub(super) fn write(&mut self, parts: &[Self]) {
        let first = self.n_written();
        for part in parts {
            let offset = self.n_written() as u32;
            self.ends.extend(part.ends.iter().map(|end| end + offset));
        }
        let Some(any) = parts.iter().find_map(|part| part.items.first()) else {
            return;
        };
        let end = self.n_written();
        self.items.resize(self.items.len().max(end), *any);
        let mut rest = &mut self.items[first..end];
        let places: Vec<&mut [T]> = parts
            .iter()
            .filter_map(|part| rest.split_off_mut(..part.items.len()))
            .collect();
        places
            .into_par_iter()
            .zip(parts)
            .for_each(|(place, part)| place.copy_from_slice(&part.items));
    }
}
