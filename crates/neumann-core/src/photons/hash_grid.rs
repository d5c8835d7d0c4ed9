//! Points found by place: a grid of cells as wide as twice the radius, hashed into a table.
//!
//! A ball of the radius meets at most 2×2×2 cells. Points of a cell lie side by side, in the
//! order in which they were given, so that sums over them have the same bits for any number of
//! threads. They are kept as copies, since a search that had to follow indices would wait for
//! memory most of its time.

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
    /// Those of the cells that the ball meets. No two are the same: neighbours differ in their
    /// places within blocks, whatever blocks they are in.
    buckets: [u32; 8],
}

/// An entry within the radius.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    /// Its number.
    pub number: u32,
    /// m².
    pub distance_squared: f32,
}

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

        // Counted two places behind, so that the sum up to a bucket is one behind: there it grows
        // to the bucket's end while that is filled, which is where the next one starts.
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

    /// The number that an entry had among the items that the grid was filled with.
    #[must_use]
    pub fn item_of(&self, entry: u32) -> u32 {
        self.order[entry as usize]
    }

    /// Finds the entries within the radius of `x`, and forgets what was found before.
    #[inline]
    pub fn find(&self, x: Vec3, near: &mut Vec<Near>) {
        near.clear();
        self.finish(&self.begin(x), near);
    }

    /// Begins a search for what is near `x`. Table, positions and entries are far away in memory:
    /// what else there is to do is best done between this, [`Self::approach`], [`Self::finish`] and
    /// reading what was found.
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

    /// Goes on with a search: asks for the positions that it will look at.
    #[inline]
    pub fn approach(&self, search: &Search) {
        for (start, end) in self.ranges(search) {
            if start < end {
                prefetch(&self.positions[start / LANES]);
                prefetch(&self.positions[(end - 1) / LANES]);
            }
        }
    }

    /// Ends a search: adds the entries within the radius to what was found before. They are asked
    /// for, not waited for: it is best to do something else before they are read.
    #[inline]
    pub fn finish(&self, search: &Search, near: &mut Vec<Near>) {
        let radius_squared = Vec4::splat(self.radius * self.radius);
        for (start, end) in self.ranges(search) {
            for group in start / LANES..end.div_ceil(LANES) {
                let first = group * LANES;
                let distances_squared = self.positions[group].distances_squared(search.x);
                let mut inside = distances_squared.cmplt(radius_squared).bitmask();
                // Those of the group that belong to other buckets.
                inside &= !0 << start.saturating_sub(first);
                inside &= !(!0 << (end - first).min(LANES));
                while inside != 0 {
                    let lane = inside.trailing_zeros() as usize;
                    inside &= inside - 1;
                    prefetch(&self.entries[first + lane]);
                    near.push(Near {
                        number: (first + lane) as u32,
                        distance_squared: distances_squared[lane],
                    });
                }
            }
        }
    }

    /// The entries of all buckets of a search, those of two cells side by side together where they
    /// follow each other.
    #[inline]
    fn ranges(&self, search: &Search) -> [(usize, usize); 8] {
        // All places in the table first, so that the memory answers them together.
        let mut ranges = search.buckets.map(|bucket| {
            let bucket = bucket as usize;
            let [start, end] = [bucket, bucket + 1].map(|i| self.starts[i] as usize);
            (start, end)
        });
        for pair in ranges.chunks_exact_mut(2) {
            if pair[0].1 == pair[1].0 {
                pair[0].1 = pair[1].1;
                pair[1] = (0, 0);
            }
        }
        ranges
    }

    #[inline]
    fn cell(&self, x: Vec3) -> IVec3 {
        floor(x * self.cells_per_metre)
    }

    /// Cells come in blocks of 4×4×4 that lie side by side in the table, so that a search touches
    /// few lines of memory; blocks are hashed as by Teschner et al. 2003, "Optimized Spatial
    /// Hashing for Collision Detection of Deformable Objects", with the high bits folded in.
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

/// The cell that a point lies in, without the calls that rounding down takes on processors as old
/// as this program may run on.
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
        let mut near = Vec::new();
        let numbered: Vec<(Vec3, usize)> = points.iter().copied().zip(0..).collect();
        for radius in [0.01, 0.2, 1.5] {
            let grid = HashGrid::new(&numbered, radius, |p| *p);
            for x in points.iter().step_by(37) {
                let x = *x + 0.3 * radius;
                grid.find(x, &mut near);
                let mut found: Vec<usize> = near
                    .iter()
                    .map(|near| grid.entries()[near.number as usize].1)
                    .collect();
                found.sort_unstable();
                let is_near = |p: &Vec3| p.distance_squared(x) < radius * radius;
                let expected: Vec<usize> =
                    (0..points.len()).filter(|i| is_near(&points[*i])).collect();
                assert_eq!(found, expected, "radius {radius}");
            }
        }
    }

    #[test]
    fn an_empty_grid_finds_nothing() {
        let grid = HashGrid::new(&[] as &[(Vec3, usize)], 0.1, |p| *p);
        let mut near = Vec::new();
        grid.find(Vec3::ZERO, &mut near);
        assert!(near.is_empty());
    }
}
