//! Points found by place: a grid of cells as wide as twice the radius, hashed into a table.
//!
//! A ball of the radius meets at most 2×2×2 cells. Points of a cell lie side by side, in the order
//! in which they were given, so that sums over them have the same bits for any number of threads. They are
//! kept as copies, since a search that had to follow indices would wait for memory most of its time.

use std::mem::take;

use glam::{IVec3, Vec3, Vec4};
use rayon::prelude::*;

use crate::math::prefetch;

/// Things that have a place, sorted by it.
#[derive(Clone, Debug)]
pub struct HashGrid<T> {
    radius: f32,
    cells_per_metre: f32,
    mask: u32,
    /// `starts[bucket]..starts[bucket + 1]`: its entries.
    starts: Vec<u32>,
    /// Bucket of each item, and items by bucket: of use only while the grid is filled.
    buckets: Vec<u32>,
    order: Vec<u32>,
    /// Apart from the entries: most that a search looks at are too far away.
    positions: Vec<Group>,
    entries: Vec<T>,
}

/// Entries whose distances are found at once.
const LANES: usize = 4;

/// Positions of [`LANES`] entries, axis by axis.
#[derive(Clone, Copy, Debug)]
struct Group([Vec4; 3]);

impl Group {
    fn of<T: Placed>(entries: &[T]) -> Self {
        let mut axes = [Vec4::ZERO; 3];
        for (lane, entry) in entries.iter().enumerate() {
            let position = entry.position();
            for (axis, values) in axes.iter_mut().enumerate() {
                values[lane] = position[axis];
            }
        }
        Self(axes)
    }

    #[inline]
    fn distances_squared(&self, x: Vec3) -> Vec4 {
        let [dx, dy, dz] = [0, 1, 2].map(|axis| self.0[axis] - x[axis]);
        dx * dx + dy * dy + dz * dz
    }
}

/// A search under way.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    x: Vec3,
    /// Those of the cells that the ball meets.
    buckets: [u32; 8],
}

/// Entries that are read together.
const BATCH: usize = 8;

/// Something that has a place.
pub trait Placed {
    /// World space, metres.
    fn position(&self) -> Vec3;
}

impl<T> Default for HashGrid<T> {
    /// A grid to be filled.
    fn default() -> Self {
        Self {
            radius: 1.0,
            cells_per_metre: 0.5,
            mask: 0,
            starts: vec![0; 2],
            buckets: Vec::new(),
            order: Vec::new(),
            positions: Vec::new(),
            entries: Vec::new(),
        }
    }
}

impl<T: Placed + Copy + Send + Sync> HashGrid<T> {
    /// Copies of what `entry` makes of each of `items`, for searches within `radius`, metres.
    #[must_use]
    pub fn new<I: Sync>(items: &[I], radius: f32, entry: impl Fn(&I) -> T + Sync) -> Self {
        let mut grid = Self::default();
        grid.fill(items, radius, entry);
        grid
    }

    /// As [`Self::new`], in place of what the grid held: in memory that it has already.
    pub fn fill<I: Sync>(&mut self, items: &[I], radius: f32, entry: impl Fn(&I) -> T + Sync) {
        // Surfaces fill a block's cells thinly.
        let n_buckets = (2 * items.len()).next_power_of_two().max(64);
        self.radius = radius;
        self.cells_per_metre = 0.5 / radius;
        self.mask = n_buckets as u32 - 1;
        let mut buckets = take(&mut self.buckets);
        items
            .par_iter()
            .with_min_len(4096)
            .map(|item| self.bucket(self.cell(entry(item).position())))
            .collect_into_vec(&mut buckets);

        // Counted two places behind, so that the sum up to a bucket is one behind: there it grows to the bucket's end while
        // that is filled, which is where the next one starts.
        let starts = &mut self.starts;
        starts.resize(n_buckets + 2, 0);
        starts.par_chunks_mut(1 << 16).for_each(|part| part.fill(0));
        for bucket in &buckets {
            starts[*bucket as usize + 2] += 1;
        }
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += *start;
            *start = sum;
        }
        self.order.resize(items.len(), 0);
        for (index, bucket) in buckets.iter().enumerate() {
            let place = &mut starts[*bucket as usize + 1];
            self.order[*place as usize] = index as u32;
            *place += 1;
        }
        self.buckets = buckets;

        self.order
            .par_iter()
            .with_min_len(4096)
            .map(|index| entry(&items[*index as usize]))
            .collect_into_vec(&mut self.entries);
        self.entries
            .par_chunks(LANES)
            .with_min_len(1024)
            .map(Group::of)
            .collect_into_vec(&mut self.positions);
    }

    /// Memory that it takes, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.starts.as_slice())
            + size_of_val(self.buckets.as_slice())
            + size_of_val(self.order.as_slice())
            + size_of_val(self.positions.as_slice())
            + size_of_val(self.entries.as_slice())
    }

    /// Number of entries.
    #[must_use]
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// True if there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// All entries, in the grid's own order.
    #[must_use]
    pub fn entries(&self) -> &[T] {
        &self.entries
    }

    /// Calls `found` with each entry within the radius of `x`, its number, and its squared distance.
    #[inline]
    pub fn for_each_near(&self, x: Vec3, found: impl FnMut(&T, u32, f32)) {
        self.finish(&self.begin(x), found);
    }

    /// Begins a search for what is near `x`. The table is far away in memory: what else there is to do is best done between
    /// this, [`Self::approach`] and [`Self::finish`].
    #[inline]
    #[must_use]
    pub fn begin(&self, x: Vec3) -> Search {
        let base = floor(x * self.cells_per_metre - 0.5);
        let mut buckets = [0u32; 8];
        for (corner, bucket) in buckets.iter_mut().enumerate() {
            let offset = IVec3::new(
                (corner & 1) as i32,
                (corner >> 1 & 1) as i32,
                (corner >> 2) as i32,
            );
            *bucket = self.bucket(base.wrapping_add(offset));
            prefetch(&self.starts[*bucket as usize]);
        }
        Search { x, buckets }
    }

    /// Goes on with a search: asks for the entries that it will look at.
    #[inline]
    pub fn approach(&self, search: &Search) {
        for bucket in search.buckets {
            let (start, end) = self.range(bucket);
            if start < end {
                prefetch(&self.positions[start / LANES]);
                prefetch(&self.entries[start]);
            }
        }
    }

    /// Ends a search: calls `found` with each entry within the radius, its number, and its squared distance.
    #[inline]
    pub fn finish(&self, search: &Search, mut found: impl FnMut(&T, u32, f32)) {
        let Search { x, buckets } = *search;
        let radius_squared = Vec4::splat(self.radius * self.radius);
        let (mut near, mut n_near) = ([(0u32, 0f32); BATCH], 0);
        // All places in the table first, so that the memory answers them together.
        let ranges = buckets.map(|bucket| self.range(bucket));
        for (corner, (start, end)) in ranges.into_iter().enumerate() {
            // Two cells may share a bucket, which must not be searched twice.
            if start == end || buckets[..corner].contains(&buckets[corner]) {
                continue;
            }
            for group in start / LANES..end.div_ceil(LANES) {
                let first = group * LANES;
                let distances_squared = self.positions[group].distances_squared(x);
                let mut inside = distances_squared.cmplt(radius_squared).bitmask();
                // Those of the group that belong to other buckets.
                inside &= !0 << start.saturating_sub(first);
                inside &= !(!0 << (end - first).min(LANES));
                while inside != 0 {
                    let lane = inside.trailing_zeros() as usize;
                    inside &= inside - 1;
                    prefetch(&self.entries[first + lane]);
                    near[n_near] = ((first + lane) as u32, distances_squared[lane]);
                    n_near += 1;
                    if n_near == near.len() {
                        self.hand_over(&near, &mut found);
                        n_near = 0;
                    }
                }
            }
        }
        self.hand_over(&near[..n_near], &mut found);
    }

    /// Reads entries together before it hands over the first, so that it waits for the memory once.
    #[inline]
    fn hand_over(&self, near: &[(u32, f32)], found: &mut impl FnMut(&T, u32, f32)) {
        let mut entries = [None; BATCH];
        for (entry, (number, _)) in entries.iter_mut().zip(near) {
            *entry = Some(self.entries[*number as usize]);
        }
        for (entry, (number, distance_squared)) in entries.iter().flatten().zip(near) {
            found(entry, *number, *distance_squared);
        }
    }

    /// The entries of a bucket.
    #[inline]
    fn range(&self, bucket: u32) -> (usize, usize) {
        let bucket = bucket as usize;
        (
            self.starts[bucket] as usize,
            self.starts[bucket + 1] as usize,
        )
    }

    #[inline]
    fn cell(&self, x: Vec3) -> IVec3 {
        floor(x * self.cells_per_metre)
    }

    /// Cells come in blocks of 4×4×4 that lie side by side in the table, so that a search touches few lines of memory;
    /// blocks are hashed as by Teschner et al. 2003, "Optimized Spatial Hashing for Collision Detection of Deformable
    /// Objects", with the high bits folded in.
    #[inline]
    fn bucket(&self, cell: IVec3) -> u32 {
        let block: IVec3 = cell >> 2;
        let inside: IVec3 = cell & 3;
        let h = (block.x as u32).wrapping_mul(73_856_093)
            ^ (block.y as u32).wrapping_mul(19_349_663)
            ^ (block.z as u32).wrapping_mul(83_492_791);
        let inside = (inside.x | inside.y << 2 | inside.z << 4) as u32;
        ((h ^ (h >> 15)) << 6 | inside) & self.mask
    }
}

/// The cell that a point lies in, without the calls that rounding down takes on processors as old as this program may
/// run on.
#[inline]
fn floor(x: Vec3) -> IVec3 {
    let towards_zero = x.as_ivec3();
    let is_above = towards_zero.as_vec3().cmpgt(x);
    towards_zero.wrapping_sub(IVec3::select(is_above, IVec3::ONE, IVec3::ZERO))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::{HashGrid, Placed};
    use crate::sampling::Sampler;

    impl Placed for (Vec3, usize) {
        fn position(&self) -> Vec3 {
            self.0
        }
    }

    #[test]
    fn finds_what_is_near_once_and_nothing_else() {
        let points: Vec<Vec3> = (0..5000)
            .map(|i| {
                let mut sampler = Sampler::new(3, i, 0);
                let [x, y] = sampler.next_2d();
                Vec3::new(x, y, sampler.next_1d()) * 4.0 - 2.0
            })
            .collect();
        let numbered: Vec<(Vec3, usize)> = points.iter().copied().zip(0..).collect();
        for radius in [0.01, 0.2, 1.5] {
            let grid = HashGrid::new(&numbered, radius, |p| *p);
            for x in points.iter().step_by(37) {
                let x = *x + 0.3 * radius;
                let mut found = Vec::new();
                grid.for_each_near(x, |entry, _, _| found.push(entry.1));
                found.sort_unstable();
                let near = |p: &Vec3| p.distance_squared(x) < radius * radius;
                let expected: Vec<usize> =
                    (0..points.len()).filter(|i| near(&points[*i])).collect();
                assert_eq!(found, expected, "radius {radius}");
            }
        }
    }

    #[test]
    fn an_empty_grid_finds_nothing() {
        let grid = HashGrid::new(&[] as &[(Vec3, usize)], 0.1, |p| *p);
        grid.for_each_near(Vec3::ZERO, |_, _, _| panic!("there is nothing"));
    }
}
