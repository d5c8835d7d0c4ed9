//! Binary trees by locally ordered clustering.
//!
//! Items lie in the order of a space-filling curve. In each pass every cluster looks among its
//! neighbours for the one with which it makes the smallest box, and two that choose each other
//! are merged (Meister and Bittner 2018, "Parallel Locally-Ordered Clustering for Bounding Volume
//! Hierarchy Construction").
//!
//! The paper does not bound the passes: one merges a single pair where every cluster prefers the
//! next, as among equal boxes in a row or boxes that grow in a progression. Here, of equal costs
//! the one counts that both clusters agree on, and clusters that have not been halved after
//! [`SEARCHES`] passes are paired with their neighbours.

use glam::DVec3;
use rayon::prelude::*;

use super::binary::{Aabb, BinaryNode, BinaryTree};

/// As many searches for each cluster may go by until half of them are left; usual scenes need
/// three or four. Fewer than about sixty clusters are halved in as many passes whatever they are.
const SEARCHES: usize = 24;
/// Clusters that one task searches for.
const CHUNK: usize = 2048;
/// How far a wide search goes along the curve.
const WIDE: usize = 14;
/// Bits of a place on the curve for each axis.
const CURVE_BITS: u32 = 21;

/// How far clusters search.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reach {
    /// Next to them.
    Neighbours,
    /// Next to them in the first passes, when they are many, then further.
    Wide { after: usize },
}

/// A binary tree of at least one item.
pub(super) fn clustered(items: &[Aabb], reach: Reach) -> BinaryTree {
    clustered_and_counted(items, reach).0
}

/// The tree, and how often a cluster searched.
fn clustered_and_counted(items: &[Aabb], reach: Reach) -> (BinaryTree, usize) {
    let mut clusters = along_curve(items);
    let mut merged = Vec::with_capacity(clusters.len());
    let mut choices = vec![0i8; clusters.len()];
    let mut nodes = vec![BinaryNode::EMPTY; 2 * items.len() - 1];
    // Nodes are written from the last on, so that the first are the uppermost.
    let mut end = nodes.len();
    let (mut n_passes, mut n_searches) = (0, 0);
    let (mut half, mut searches_left) = (clusters.len() / 2, SEARCHES * clusters.len());
    while clusters.len() > 1 {
        let n = clusters.len();
        let choices = &mut choices[..n];
        if searches_left < n {
            pair(choices);
        } else {
            match reach {
                Reach::Wide { after } if n_passes >= after => search::<WIDE>(&clusters, choices),
                _ => search::<1>(&clusters, choices),
            }
            searches_left -= n;
            n_searches += n;
        }
        merged.clear();
        for (index, cluster) in clusters.iter().enumerate() {
            let choice = choices[index];
            let other = index.wrapping_add_signed(isize::from(choice));
            if choice == 0 || choices[other] != -choice {
                merged.push(*cluster);
            } else if other < index {
                end -= 2;
                nodes[end] = clusters[other];
                nodes[end + 1] = *cluster;
                let bounds = clusters[other].bounds.union(&cluster.bounds);
                merged.push(BinaryNode::inner(bounds, end));
            }
        }
        std::mem::swap(&mut clusters, &mut merged);
        n_passes += 1;
        if clusters.len() <= half {
            (half, searches_left) = (clusters.len() / 2, SEARCHES * clusters.len());
        }
    }
    nodes[0] = clusters[0];
    (BinaryTree { nodes }, n_searches)
}

/// A leaf for each item, in the order of their middles along a Morton curve.
fn along_curve(items: &[Aabb]) -> Vec<BinaryNode> {
    let bounds = items
        .par_iter()
        .copied()
        .reduce(|| Aabb::EMPTY, |a, b| a.union(&b));
    let cells = f64::from((1u32 << CURVE_BITS) - 1);
    // Along an axis in which all is flat there is no order.
    let per_metre = (bounds.max - bounds.min)
        .as_dvec3()
        .to_array()
        .map(|extent| if extent > 0.0 { cells / extent } else { 0.0 });
    let mut places: Vec<(u64, u32)> = items
        .par_iter()
        .enumerate()
        .map(|(index, item)| {
            let from_corner = (item.center() - bounds.min).as_dvec3();
            let place = from_corner * DVec3::from_array(per_metre);
            let bits = place.to_array().map(|x| spread_bits(x as u64));
            (bits[0] | bits[1] << 1 | bits[2] << 2, index as u32)
        })
        .collect();
    places.par_sort_unstable();
    places
        .par_iter()
        .map(|(_, item)| BinaryNode::leaf(items[*item as usize], *item))
        .collect()
}

/// Moves each of the lowest 21 bits to three times its place.
fn spread_bits(x: u64) -> u64 {
    let mut x = x & ((1 << CURVE_BITS) - 1);
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Pairs every cluster with a neighbour: `choices` are offsets, 0 where there is none.
fn pair(choices: &mut [i8]) {
    let n = choices.len();
    for (index, choice) in choices.iter_mut().enumerate() {
        *choice = match index % 2 {
            0 if index + 1 < n => 1,
            0 => 0,
            _ => -1,
        };
    }
}

/// Finds for every cluster the one within `REACH` places with which it makes the smallest box.
///
/// Of equal costs that counts whose index differs in the lower bits, which is the same seen from
/// either. So the cheapest pair of all is merged, and of equal boxes in a row all are.
fn search<const REACH: usize>(clusters: &[BinaryNode], choices: &mut [i8]) {
    let search_chunk = |(chunk, choices): (usize, &mut [i8])| {
        let start = chunk * CHUNK;
        let end = start + choices.len();
        // Costs from `REACH` places before the chunk on; what is found for others is not used.
        let before = start.saturating_sub(REACH);
        let mut costs = [f32::INFINITY; CHUNK + 2 * WIDE];
        let mut best = [0i8; CHUNK + 2 * WIDE];
        let mut offer = |at: usize, offset: i8, cost: f32| {
            let i = at - before;
            let differs_by = |offset: i8| at ^ at.wrapping_add_signed(isize::from(offset));
            if cost < costs[i] || cost == costs[i] && differs_by(offset) < differs_by(best[i]) {
                costs[i] = cost;
                best[i] = offset;
            }
        };
        for a in before..end {
            let bounds = &clusters[a].bounds;
            let (first, last) = ((a + 1).max(start), (a + REACH + 1).min(clusters.len()));
            for (b, other) in (first..).zip(&clusters[first..last]) {
                let cost = bounds.union(&other.bounds).half_area();
                let offset = (b - a) as i8;
                offer(a, offset, cost);
                offer(b, -offset, cost);
            }
        }
        choices.copy_from_slice(&best[start - before..end - before]);
    };
    choices
        .par_chunks_mut(CHUNK)
        .enumerate()
        .for_each(search_chunk);
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::super::build::tests::{hard_cases, items_below};
    use super::{Aabb, Reach, SEARCHES, clustered_and_counted};

    #[test]
    fn searches_are_bounded_whatever_is_clustered() {
        for n in [1, 2, 3, 1000, 4097] {
            for (name, boxes) in hard_cases(n) {
                for reach in [Reach::Neighbours, Reach::Wide { after: 3 }] {
                    let (tree, n_searches) = clustered_and_counted(&boxes, reach);
                    assert!(
                        n_searches <= 2 * SEARCHES * n,
                        "{name}: {n_searches} searches for {n}"
                    );
                    assert!(items_below(&tree).into_iter().eq(0..n as u32), "{name}");
                }
            }
        }
    }

    #[test]
    fn equal_boxes_in_a_row_are_halved_by_every_pass() {
        let boxes: Vec<Aabb> = (0..1 << 10)
            .map(|i| Aabb::of(&[Vec3A::X * i as f32, Vec3A::X * i as f32 + 0.5]))
            .collect();
        let (_, n_searches) = clustered_and_counted(&boxes, Reach::Wide { after: 3 });
        assert_eq!(n_searches, 2 * boxes.len() - 2);
    }
}
