//! Builds the tree over lights, top down.
//!
//! Lights are put into bins along each axis of the box around their centres, and split between two
//! bins where the sum of the costs of both sides is least (after the surface area orientation
//! heuristic of [Conty & Kulla 2018]). The binary tree is then folded so that a node has up to four
//! children.

use glam::Vec3;

use super::bounds::LightBounds;
use super::tree::{LightTree, WIDTH};

/// Bins along an axis.
const N_BINS: usize = 12;

/// A light on its way into the tree.
#[derive(Clone, Copy)]
struct Item {
    bounds: LightBounds,
    center: Vec3,
    light: u32,
}

/// The binary tree, children before their parents.
enum Binary {
    Light(u32),
    Split(usize, usize),
}

struct BinaryNode {
    bounds: LightBounds,
    kind: Binary,
}

/// A tree over those of the lights that have bounds: `bounds[light]`, and the bounds of all, if
/// there are any. Intensities are multiplied
/// by `scale`.
pub(super) fn build(
    bounds: &[Option<LightBounds>],
    scale: f64,
) -> (LightTree, Option<LightBounds>) {
    let mut items: Vec<Item> = (0..)
        .zip(bounds)
        .filter_map(|(light, bounds)| {
            bounds.map(|bounds| Item {
                bounds,
                center: bounds.center(),
                light,
            })
        })
        .collect();
    let mut tree = LightTree::empty(bounds.len());
    if items.is_empty() {
        return (tree, None);
    }
    let mut binary = Vec::with_capacity(2 * items.len());
    let root = split(&mut items, &mut binary);
    fold(&binary, root, None, scale, &mut tree);
    (tree, Some(binary[root].bounds))
}

/// Splits lights until each is alone; yields the number of the node that holds them all.
fn split(items: &mut [Item], nodes: &mut Vec<BinaryNode>) -> usize {
    let node = if let [item] = items {
        BinaryNode {
            bounds: item.bounds,
            kind: Binary::Light(item.light),
        }
    } else {
        let middle = partition(items);
        let (left, right) = items.split_at_mut(middle);
        let left = split(left, nodes);
        let right = split(right, nodes);
        BinaryNode {
            bounds: nodes[left].bounds.union(&nodes[right].bounds),
            kind: Binary::Split(left, right),
        }
    };
    nodes.push(node);
    nodes.len() - 1
}

/// Puts the lights of one side before those of the other and yields how many there are.
fn partition(items: &mut [Item]) -> usize {
    let half = items.len() / 2;
    if items.len() == 2 {
        return half;
    }
    let first = items[0].center;
    let (min, max) = items.iter().fold((first, first), |(min, max), item| {
        (min.min(item.center), max.max(item.center))
    });
    let Some(best) = best_split(items, min, max) else {
        return half;
    };
    let mut n_left = 0;
    for i in 0..items.len() {
        if best.bins.of(items[i].center) < best.first_right {
            items.swap(i, n_left);
            n_left += 1;
        }
    }
    n_left
}

struct Split {
    bins: Bins,
    first_right: usize,
    cost: f32,
}

/// The cheapest split; `None` if all centres are the same.
fn best_split(items: &[Item], min: Vec3, max: Vec3) -> Option<Split> {
    let n_bins = items.len().min(N_BINS);
    let longest = (max - min).max_element();
    let mut best: Option<Split> = None;
    for axis in 0..3 {
        let Some(bins) = Bins::new(axis, n_bins, min[axis], max[axis]) else {
            continue;
        };
        let mut groups: [Option<LightBounds>; N_BINS] = [None; N_BINS];
        for item in items {
            let group = &mut groups[bins.of(item.center)];
            *group = joined(group.as_ref(), Some(&item.bounds));
        }
        // Costs of all bins from one on, then of all bins up to it.
        let mut right_costs = [0.0; N_BINS];
        let mut right = None;
        for i in (1..n_bins).rev() {
            right = joined(right.as_ref(), groups[i].as_ref());
            right_costs[i] = right.as_ref().map_or(0.0, LightBounds::cost);
        }
        // Thin boxes are better cut across than along.
        let regularity = longest / (max[axis] - min[axis]);
        let mut left = None;
        for (i, right_cost) in right_costs.iter().enumerate().take(n_bins).skip(1) {
            left = joined(left.as_ref(), groups[i - 1].as_ref());
            let left_cost = left.as_ref().map_or(0.0, LightBounds::cost);
            let cost = regularity * (left_cost + right_cost);
            if best.as_ref().is_none_or(|b| cost < b.cost) {
                best = Some(Split {
                    bins,
                    first_right: i,
                    cost,
                });
            }
        }
    }
    best
}

fn joined(a: Option<&LightBounds>, b: Option<&LightBounds>) -> Option<LightBounds> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.union_but_cone(b)),
        (a, b) => a.or(b).copied(),
    }
}

/// Equal intervals along one axis; the first and the last are never empty.
#[derive(Clone, Copy)]
struct Bins {
    axis: usize,
    n: usize,
    min: f32,
    per_metre: f32,
}

impl Bins {
    fn new(axis: usize, n: usize, min: f32, max: f32) -> Option<Self> {
        let per_metre = n as f32 / (max - min);
        (max > min && per_metre.is_finite()).then_some(Self {
            axis,
            n,
            min,
            per_metre,
        })
    }

    fn of(&self, center: Vec3) -> usize {
        (((center[self.axis] - self.min) * self.per_metre) as usize).min(self.n - 1)
    }
}

/// Makes a node of the wide tree from a binary one, by opening the costliest of its parts until it
/// has enough children.
fn fold(
    binary: &[BinaryNode],
    root: usize,
    parent: Option<(usize, usize)>,
    scale: f64,
    tree: &mut LightTree,
) {
    let node = tree.push(parent);
    let mut children = vec![root];
    while children.len() < WIDTH {
        let costliest = (0..children.len())
            .filter(|i| matches!(binary[children[*i]].kind, Binary::Split(..)))
            .max_by(|a, b| {
                let cost = |i: &usize| binary[children[*i]].bounds.cost();
                cost(a).total_cmp(&cost(b))
            });
        let Some(i) = costliest else { break };
        if let Binary::Split(left, right) = binary[children[i]].kind {
            children[i] = left;
            children.insert(i + 1, right);
        }
    }
    for (lane, child) in children.into_iter().enumerate() {
        let part = &binary[child];
        tree.set_lane(node, lane, &part.bounds, scale);
        match part.kind {
            Binary::Light(light) => tree.set_light(node, lane, light as usize),
            Binary::Split(..) => fold(binary, child, Some((node, lane)), scale, tree),
        }
    }
}
