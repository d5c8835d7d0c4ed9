//! Makes wide trees of binary ones.
//!
//! Which binary nodes become wide ones is decided by dynamic programming on the surface
//! area heuristic (Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on
//! GPUs Through Compressed Wide BVHs", 3.1): `cost(n, j)` is the cheapest way to represent
//! the subtree of n by at most j wide nodes or leaves.
//!
//! A big tree is cut below its root into subtrees, which are planned side by side and written side
//! by side: what comes out depends on no thread.

use glam::Vec3;
use rayon::prelude::*;

use super::binary::BinaryTree;
use super::memory::in_large_pages;
use super::wide::{
    EMPTY_LEAF, EMPTY_NODE, FLAT, LEAF, LEAF_SIZE, Leaf, Node, WIDTH, WideTree, is_flat,
};

/// Cost of testing the boxes of a node, and of testing the triangles of a leaf.
const NODE_COST: f32 = 1.0;
const LEAF_COST: f32 = 0.5;
/// The same for a leaf whose triangles lie side by side in one plane, as a share of that: rays that
/// start or end there are not tested against them. A wall and a lamp right below it are better off
/// as two leaves.
const FLAT_SHARE: f32 = 0.9;
/// Trees of fewer nodes are not cut,
const MIN_NODES_TO_CUT: usize = 1 << 15;
/// and others after so many levels.
const CUT_LEVELS: usize = 9;

/// How a subtree is best represented by at most j roots: as one leaf,
const AS_LEAF: u8 = 0;
/// as one wide node,
const AS_NODE: u8 = 1;
/// as with one root less,
const AS_FEWER: u8 = 2;
/// or, above this, by as many roots as it is above in the first child's subtree and the rest in the
/// second's.
const SPLIT: u8 = 2;

/// The plan for one binary node.
#[derive(Clone, Copy, Debug)]
struct Plan {
    /// `cost[j - 1]` for at most j roots, j = 1…7.
    cost: [f32; WIDTH - 1],
    choice: [u8; WIDTH - 1],
    /// How a wide node made of this one splits its eight children.
    split: u8,
    n_items: u32,
    /// True if it would be a leaf that is [`FLAT`].
    is_flat: bool,
    /// The binary node.
    source: u32,
    /// Where the plan of the second child is; that of the first comes next.
    second: u32,
}

/// Marks, in [`Plan::second`], where the upper part is cut: the number of the part that goes on
/// from there.
const CUT: u32 = 1 << 31;

/// Plans of a binary tree: those of its upper part, then those of the subtrees below, each part
/// depth first.
struct Plans<'a> {
    binary: &'a BinaryTree,
    items: Items<'a>,
    leaf_size: usize,
    parts: Vec<Vec<Plan>>,
}

/// Where a plan is.
#[derive(Clone, Copy)]
struct Place {
    part: u32,
    index: u32,
}

/// A child of a wide node: its plan, and its number among the wide nodes or leaves of its part.
#[derive(Clone, Copy)]
struct Child {
    place: Place,
    kind: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    Leaf(usize),
    Node(usize),
    /// The root of a part of its own.
    Cut(usize),
}

/// What a part of the wide tree consists of.
#[derive(Clone, Default)]
struct Extent {
    n_nodes: usize,
    n_leaves: usize,
    /// Wide nodes on the longest way down.
    depth: usize,
    /// The parts that hang below it, with their depth.
    cuts: Vec<(Place, usize)>,
}

/// What leaves are made of.
#[derive(Clone, Copy)]
enum Items<'a> {
    /// Triangles, up to [`LEAF_SIZE`] together.
    Triangles(&'a [[Vec3; 3]]),
    /// Anything, one by one: leaves stand for the items themselves.
    Others,
}

impl WideTree {
    /// Collapses a binary tree with one triangle in each leaf; leaves of the wide tree have four.
    pub(super) fn of_triangles(binary: &BinaryTree, triangles: &[[Vec3; 3]]) -> Self {
        collapse(binary, Items::Triangles(triangles), cut_levels(binary))
    }

    /// Collapses a binary tree with one item in each leaf; those of the wide tree stand for the
    /// items themselves.
    pub(super) fn of_items(binary: &BinaryTree) -> Self {
        collapse(binary, Items::Others, cut_levels(binary))
    }
}

/// After how many levels a tree is cut, if it is worth it.
fn cut_levels(binary: &BinaryTree) -> Option<usize> {
    (binary.nodes.len() >= MIN_NODES_TO_CUT).then_some(CUT_LEVELS)
}

fn collapse(binary: &BinaryTree, items: Items<'_>, cut_levels: Option<usize>) -> WideTree {
    if binary.nodes.is_empty() {
        return WideTree::default();
    }
    let leaf_size = match items {
        Items::Triangles(_) => LEAF_SIZE,
        Items::Others => 1,
    };
    let plans = Plans::new(binary, items, leaf_size, cut_levels);
    let root = Place { part: 0, index: 0 };
    let top = plans.walk(root, |_, _| ());
    let below: Vec<Extent> = top
        .cuts
        .par_iter()
        .map(|(place, _)| plans.walk(*place, |_, _| ()))
        .collect();
    let extents = || std::iter::once(&top).chain(&below);

    let n_leaves = match items {
        Items::Triangles(_) => extents().map(|e| e.n_leaves).sum(),
        Items::Others => 0,
    };
    let mut tree = WideTree {
        nodes: in_large_pages(EMPTY_NODE, extents().map(|e| e.n_nodes).sum()),
        leaves: in_large_pages(EMPTY_LEAF, n_leaves),
        depth: top.depth,
        bounds: [Vec3::ZERO; 2],
        reach: 0.0,
        is_far: false,
    };
    let mut parts = Vec::with_capacity(1 + below.len());
    let mut rest = (tree.nodes.as_mut_slice(), tree.leaves.as_mut_slice());
    let (mut first_node, mut first_leaf) = (0, 0);
    for (extent, place) in extents().zip(std::iter::once(root).chain(top.cuts.iter().map(|c| c.0)))
    {
        let n_leaves = extent.n_leaves.min(rest.1.len());
        let (nodes, more_nodes) = rest.0.split_at_mut(extent.n_nodes);
        let (leaves, more_leaves) = rest.1.split_at_mut(n_leaves);
        rest = (more_nodes, more_leaves);
        parts.push(Part {
            place,
            first_node,
            first_leaf,
            nodes,
            leaves,
        });
        first_node += extent.n_nodes;
        first_leaf += extent.n_leaves;
    }
    let first_nodes: Vec<usize> = parts.iter().skip(1).map(|part| part.first_node).collect();
    parts
        .into_par_iter()
        .for_each(|part| part.write(&plans, items, &first_nodes));
    for ((_, depth), extent) in top.cuts.iter().zip(&below) {
        tree.depth = tree.depth.max(depth + extent.depth);
    }
    tree.measured()
}

/// A part of the wide tree that is to be written.
struct Part<'a> {
    place: Place,
    first_node: usize,
    first_leaf: usize,
    nodes: &'a mut [Node],
    leaves: &'a mut [Leaf],
}

impl Part<'_> {
    /// `first_nodes` are those of the parts that hang below this one.
    fn write(self, plans: &Plans<'_>, items: Items<'_>, first_nodes: &[usize]) {
        let mut members = Vec::with_capacity(plans.leaf_size);
        plans.walk(self.place, |index, children| {
            let mut node = EMPTY_NODE;
            for (lane, child) in children.iter().enumerate() {
                let bounds = plans.binary.nodes[plans.at(child.place).source as usize].bounds;
                for axis in 0..3 {
                    node.bounds[2 * axis][lane] = bounds.min[axis];
                    node.bounds[2 * axis + 1][lane] = bounds.max[axis];
                }
                node.children[lane] = match child.kind {
                    Kind::Node(i) => (self.first_node + i) as u32,
                    Kind::Cut(i) => first_nodes[i] as u32,
                    Kind::Leaf(i) => {
                        members.clear();
                        plans.collect(child.place, &mut members);
                        match items {
                            Items::Triangles(triangles) => {
                                self.leaves[i] = Leaf::new(&members, triangles);
                                let is_flat = plans.at(child.place).is_flat;
                                let flat = if is_flat { FLAT } else { 0 };
                                LEAF | flat | (self.first_leaf + i) as u32
                            }
                            Items::Others => LEAF | members[0],
                        }
                    }
                };
            }
            self.nodes[index] = node;
        });
    }
}

impl<'a> Plans<'a> {
    fn new(
        binary: &'a BinaryTree,
        items: Items<'a>,
        leaf_size: usize,
        cut_levels: Option<usize>,
    ) -> Self {
        let mut plans = Self {
            binary,
            items,
            leaf_size,
            parts: vec![Vec::new()],
        };
        let mut cuts = Vec::new();
        let mut top = plans.unfinished(0, cut_levels, &mut cuts);
        let below: Vec<Vec<Plan>> = cuts
            .par_iter()
            .map(|source| {
                let mut part = plans.unfinished(*source, None, &mut Vec::new());
                plans.finish(&mut part, &[]);
                part
            })
            .collect();
        plans.finish(&mut top, &below);
        plans.parts[0] = top;
        plans.parts.extend(below);
        plans
    }

    /// Plans below a binary node, depth first, in which only the way down is found. Nodes that lie
    /// as deep as `levels` are cut off: they are added to `cuts`.
    fn unfinished(&self, source: u32, levels: Option<usize>, cuts: &mut Vec<u32>) -> Vec<Plan> {
        let mut plans: Vec<Plan> = Vec::new();
        let mut stack = vec![(source, None, 0)];
        while let Some((source, parent, level)) = stack.pop() {
            let index = plans.len();
            if let Some(parent) = parent {
                let parent: &mut Plan = &mut plans[parent];
                parent.second = index as u32;
            }
            let mut plan = Plan {
                cost: [0.0; WIDTH - 1],
                choice: [AS_LEAF; WIDTH - 1],
                split: 0,
                n_items: 0,
                is_flat: false,
                source,
                second: 0,
            };
            let node = &self.binary.nodes[source as usize];
            if levels == Some(level) {
                plan.second = CUT | cuts.len() as u32;
                cuts.push(source);
            } else if let Some([first, second]) = node.children() {
                stack.push((second as u32, Some(index), level + 1));
                stack.push((first as u32, None, level + 1));
            }
            plans.push(plan);
        }
        plans
    }

    /// Finds the costs, children before parents; `below` are the parts that this one is cut off
    /// from.
    fn finish(&self, plans: &mut [Plan], below: &[Vec<Plan>]) {
        for index in (0..plans.len()).rev() {
            let Plan { source, second, .. } = plans[index];
            let node = &self.binary.nodes[source as usize];
            let area = node.bounds.half_area();
            let mut is_flat = false;
            let (cost, choice, split, n_items) = if second & CUT != 0 {
                let root = &below[(second & !CUT) as usize][0];
                (root.cost, root.choice, root.split, root.n_items)
            } else if node.item().is_some() {
                let cost = [area * LEAF_COST; WIDTH - 1];
                is_flat = matches!(self.items, Items::Triangles(_));
                (cost, [AS_LEAF; WIDTH - 1], 0, 1)
            } else {
                let children = [&plans[index + 1], &plans[second as usize]];
                is_flat = children.iter().all(|child| child.is_flat) && self.is_flat(source);
                best_plan(children, area, self.leaf_size, is_flat)
            };
            plans[index] = Plan {
                cost,
                choice,
                split,
                n_items,
                is_flat,
                ..plans[index]
            };
        }
    }

    /// True if the triangles below a binary node make a leaf that is flat.
    fn is_flat(&self, source: u32) -> bool {
        let Items::Triangles(triangles) = self.items else {
            return false;
        };
        let mut members = Vec::with_capacity(LEAF_SIZE);
        let mut stack = vec![source as usize];
        while let Some(index) = stack.pop() {
            let node = &self.binary.nodes[index];
            members.extend(node.item());
            stack.extend(node.children().into_iter().flatten());
            if members.len() + stack.len() > self.leaf_size {
                return false;
            }
        }
        is_flat(&members, triangles)
    }

    #[inline]
    fn at(&self, place: Place) -> &Plan {
        &self.parts[place.part as usize][place.index as usize]
    }

    /// Where the children of an inner node are.
    #[inline]
    fn children(&self, place: Place) -> [Place; 2] {
        [place.index + 1, self.at(place).second].map(|index| {
            let place = Place { index, ..place };
            match self.at(place).second {
                cut if cut & CUT != 0 => Place {
                    part: 1 + (cut & !CUT),
                    index: 0,
                },
                _ => place,
            }
        })
    }

    /// Visits the wide nodes of a part, each with its number and its children, which are numbered
    /// in a row.
    fn walk(&self, root: Place, mut visit: impl FnMut(usize, &[Child])) -> Extent {
        let mut extent = Extent {
            n_nodes: 1,
            ..Extent::default()
        };
        let mut stack = vec![(root, 0, 1)];
        let mut places = Vec::with_capacity(WIDTH);
        let mut children = Vec::with_capacity(WIDTH);
        while let Some((place, index, depth)) = stack.pop() {
            extent.depth = extent.depth.max(depth);
            places.clear();
            let plan = self.at(place);
            if plan.choice[0] == AS_LEAF {
                // The whole tree is a leaf, below a root that has no other.
                places.push(place);
            } else {
                let [first, second] = self.children(place);
                let split = plan.split as usize;
                self.gather(first, split, &mut places);
                self.gather(second, WIDTH - split, &mut places);
            }
            children.clear();
            for place in &places {
                let kind = if self.at(*place).choice[0] == AS_LEAF {
                    extent.n_leaves += 1;
                    Kind::Leaf(extent.n_leaves - 1)
                } else if place.part != root.part {
                    extent.cuts.push((*place, depth));
                    Kind::Cut(extent.cuts.len() - 1)
                } else {
                    extent.n_nodes += 1;
                    stack.push((*place, extent.n_nodes - 1, depth + 1));
                    Kind::Node(extent.n_nodes - 1)
                };
                children.push(Child {
                    place: *place,
                    kind,
                });
            }
            visit(index, &children);
        }
        extent
    }

    /// The roots that represent a subtree by at most `j` of them; recurses at most seven deep.
    fn gather(&self, place: Place, j: usize, roots: &mut Vec<Place>) {
        match self.at(place).choice[j - 1] {
            AS_LEAF | AS_NODE => roots.push(place),
            AS_FEWER => self.gather(place, j - 1, roots),
            split => {
                let k = (split - SPLIT) as usize;
                let [first, second] = self.children(place);
                self.gather(first, k, roots);
                self.gather(second, j - k, roots);
            }
        }
    }

    /// The items below a node that becomes a leaf.
    fn collect(&self, place: Place, items: &mut Vec<u32>) {
        let node = &self.binary.nodes[self.at(place).source as usize];
        if let Some(item) = node.item() {
            items.push(item);
        } else {
            for child in self.children(place) {
                self.collect(child, items);
            }
        }
    }
}

/// Costs and choices of a node, how it splits its children, and how many items are below it.
type Best = ([f32; WIDTH - 1], [u8; WIDTH - 1], u8, u32);

fn best_plan([left, right]: [&Plan; 2], area: f32, leaf_size: usize, is_flat: bool) -> Best {
    // The cheapest split of j roots between both children.
    let split = |j: usize| {
        (1..j)
            .filter(|k| *k < WIDTH && j - k < WIDTH)
            .map(|k| (left.cost[k - 1] + right.cost[j - k - 1], k as u8))
            .fold((f32::INFINITY, 1), |a, b| if b.0 < a.0 { b } else { a })
    };
    let n_items = left.n_items + right.n_items;
    let (children_cost, children_split) = split(WIDTH);
    let as_node = children_cost + area * NODE_COST;
    let as_leaf = if n_items as usize <= leaf_size {
        area * LEAF_COST * if is_flat { FLAT_SHARE } else { 1.0 }
    } else {
        f32::INFINITY
    };
    let mut cost = [as_node.min(as_leaf); WIDTH - 1];
    let mut choice = [AS_FEWER; WIDTH - 1];
    choice[0] = if as_leaf <= as_node { AS_LEAF } else { AS_NODE };
    for j in 2..WIDTH {
        let (split_cost, k) = split(j);
        cost[j - 1] = cost[j - 2];
        if split_cost < cost[j - 1] {
            cost[j - 1] = split_cost;
            choice[j - 1] = SPLIT + k;
        }
    }
    (cost, choice, children_split, n_items)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::build::{TreeQuality, binary_tree, boxes_of};
    use super::super::wide::leaf_of;
    use super::{Items, LEAF, WideTree, collapse};
    use crate::sampling::{Sampler, warp};

    /// What a tree holds, whatever its order: boxes of children, and triangles of leaves.
    fn contents(tree: &WideTree) -> (Vec<[u32; 6]>, Vec<[u32; 4]>) {
        let mut boxes = Vec::new();
        let mut leaves = Vec::new();
        let mut stack = vec![0usize];
        while let Some(index) = stack.pop() {
            let node = &tree.nodes[index];
            for lane in 0..8 {
                if node.bounds[0][lane] > node.bounds[1][lane] {
                    continue;
                }
                boxes.push(node.bounds.map(|row| row[lane].to_bits()));
                let child = node.children[lane];
                if child & LEAF == 0 {
                    stack.push(child as usize);
                } else {
                    leaves.push(tree.leaves[leaf_of(child)].triangles);
                }
            }
        }
        boxes.sort_unstable();
        leaves.sort_unstable();
        (boxes, leaves)
    }

    #[test]
    fn a_tree_planned_in_parts_is_the_tree_planned_at_once() {
        let triangles: Vec<[Vec3; 3]> = (0..3000)
            .map(|i| {
                let mut sampler = Sampler::new(11, i, 0);
                let [x, y] = sampler.next_2d();
                let center = Vec3::new(x, y, sampler.next_1d());
                [(); 3].map(|()| center + 0.05 * warp::uniform_sphere(sampler.next_2d()))
            })
            .collect();
        for n in [1, 4, 5, 300, 3000] {
            let binary = binary_tree(&boxes_of(&triangles[..n]), TreeQuality::Full);
            let items = Items::Triangles(&triangles[..n]);
            let whole = collapse(&binary, items, None);
            let (boxes, leaves) = contents(&whole);
            let mut seen = leaves.concat();
            seen.sort_unstable();
            seen.dedup();
            assert_eq!(seen, (0..n as u32).collect::<Vec<_>>(), "every triangle");
            for levels in [1, 3, 9] {
                let cut = collapse(&binary, items, Some(levels));
                assert_eq!(cut.nodes.len(), whole.nodes.len(), "{n}, cut at {levels}");
                assert_eq!(cut.leaves.len(), whole.leaves.len());
                assert_eq!(cut.depth, whole.depth);
                assert!(contents(&cut) == (boxes.clone(), leaves.clone()));
            }
        }
    }
}
