//! Takes nodes out of a binary tree and puts them back where they cost least.
//!
//! Cost is area, as by the surface area heuristic (Meister and Bittner 2018, "Parallel Reinsertion
//! for Bounding Volume Hierarchy Optimization"). Which nodes go where is found side by side, in a
//! tree that stands still, then done one by one. The paper does not bound the search for a place:
//! where boxes lie over one another, it visits most of the tree for each node. Here it ends after
//! [`VISITS`].

use rayon::prelude::*;

use super::binary::{BinaryNode, BinaryTree};

/// Nodes that the search for one node's place visits at most.
const VISITS: usize = 512;
/// A node is not moved if there are more above its new place.
const DEEPEST: usize = 1024;
/// Rounds; each takes one in 1, 3, 5, … of the nodes that the first takes,
const N_ROUNDS: usize = 16;
/// but no fewer than this, if there are as many: in a small tree, a round that considers its larger
/// nodes only leaves the sides of a block with the walls of the room, and rays pay for it.
const FEWEST: usize = 4096;

/// Where a node is to go: beside the node `to`, by which areas become smaller by `gain`.
#[derive(Clone, Copy, Debug)]
struct Reinsertion {
    from: u32,
    to: u32,
    gain: f32,
}

/// Moves nodes of a tree that has its uppermost nodes first; the first round considers the given
/// share of them.
pub(super) fn reinsert(tree: &mut BinaryTree, share: f32) {
    let n = tree.nodes.len();
    if n < 3 {
        return;
    }
    let mut moving = Moving {
        parents: tree.parents(),
        nodes: &mut tree.nodes,
    };
    let mut is_touched = vec![false; n];
    for round in 0..N_ROUNDS {
        let n_candidates = (n as f32 * share / (2 * round + 1) as f32) as usize;
        let n_candidates = n_candidates.max(FEWEST).min(n - 1);
        let mut found = moving.find(&moving.candidates(n_candidates));
        found.par_sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.from.cmp(&b.from)));
        if found.is_empty() {
            return;
        }
        is_touched.fill(false);
        for reinsertion in found {
            moving.apply(reinsertion, &mut is_touched);
        }
    }
}

/// A tree of which nodes are moved.
struct Moving<'a> {
    nodes: &'a mut [BinaryNode],
    parents: Vec<u32>,
}

impl Moving<'_> {
    /// The nodes of largest area among twice as many that come first, the root not counted.
    fn candidates(&self, n: usize) -> Vec<u32> {
        let first = 2 * (n + 1);
        let mut candidates: Vec<(f32, u32)> = self
            .nodes
            .iter()
            .take(first)
            .enumerate()
            .skip(1)
            .map(|(index, node)| (node.bounds.half_area(), index as u32))
            .collect();
        if n < candidates.len() {
            let larger_first =
                |a: &(f32, u32), b: &(f32, u32)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
            candidates.select_nth_unstable_by(n, larger_first);
            candidates.truncate(n);
        }
        candidates.into_iter().map(|(_, index)| index).collect()
    }

    /// The best place of each candidate, if it gains anything.
    fn find(&self, candidates: &[u32]) -> Vec<Reinsertion> {
        candidates
            .par_iter()
            .map_init(Vec::new, |stack, from| self.best_place(*from, stack))
            .flatten()
            .collect()
    }

    /// What a node gains by going is found on the way up: its parent goes, and those above it
    /// become smaller. What it costs to arrive is found on the way down from each of their other
    /// children: those that it comes to lie below become bigger, and it gets a new parent.
    fn best_place(&self, from: u32, stack: &mut Vec<(f32, usize)>) -> Option<Reinsertion> {
        let from = from as usize;
        let bounds = self.nodes[from].bounds;
        let area = bounds.half_area();
        let parent = self.parents[from] as usize;
        let mut best = (0.0, None);
        let mut visits_left = VISITS;
        // The node above which all is seen to, what going gains up to there, and the box of what
        // is left below it.
        let mut pivot = parent;
        let mut sibling = sibling_of(from);
        let mut gain = self.nodes[parent].bounds.half_area();
        let mut rest = self.nodes[sibling].bounds;
        loop {
            stack.clear();
            stack.push((gain, sibling));
            while let Some((gain, place)) = stack.pop() {
                if gain - area <= best.0 {
                    continue;
                }
                if visits_left == 0 {
                    break;
                }
                visits_left -= 1;
                let node = &self.nodes[place];
                let gain_here = gain - node.bounds.union(&bounds).half_area();
                // Beside its sibling, and beside its parent, it is now.
                if gain_here > best.0 && place != sibling_of(from) {
                    best = (gain_here, Some(place));
                }
                if let Some(children) = node.children() {
                    let gain_below = gain_here + node.bounds.half_area();
                    stack.extend(children.map(|child| (gain_below, child)));
                }
            }
            if pivot != parent {
                rest = rest.union(&self.nodes[sibling].bounds);
                gain += self.nodes[pivot].bounds.half_area() - rest.half_area();
            }
            if pivot == 0 || visits_left == 0 {
                break;
            }
            sibling = sibling_of(pivot);
            pivot = self.parents[pivot] as usize;
        }
        let (gain, to) = best;
        to.map(|to| Reinsertion {
            from: from as u32,
            to: to as u32,
            gain,
        })
    }

    /// Moves a node, unless another that has moved has touched the same place.
    fn apply(&mut self, Reinsertion { from, to, .. }: Reinsertion, is_touched: &mut [bool]) {
        let (from, to) = (from as usize, to as usize);
        let sibling = sibling_of(from);
        let parent = self.parents[from] as usize;
        let touched = [to, from, sibling, self.parents[to] as usize, parent];
        if touched.iter().any(|node| is_touched[*node]) || !self.may_go_to(from, to) {
            return;
        }
        for node in touched {
            is_touched[node] = true;
        }
        // The node and what it joins become a pair where it was; its sibling takes the place of
        // their parent.
        let (joined, left) = (self.nodes[to], self.nodes[sibling]);
        let bounds = joined.bounds.union(&self.nodes[from].bounds);
        self.nodes[to] = BinaryNode::inner(bounds, from.min(sibling));
        self.put(joined, sibling);
        self.put(left, parent);
        self.parents[sibling] = to as u32;
        self.parents[from] = to as u32;
        self.fit_above(to);
        self.fit_above(parent);
    }

    /// True unless the place is below the node itself, where an earlier move can have brought it,
    /// or very deep.
    fn may_go_to(&self, from: usize, to: usize) -> bool {
        let mut above = to;
        for _ in 0..DEEPEST {
            if above == from {
                return false;
            }
            if above == 0 {
                return true;
            }
            above = self.parents[above] as usize;
        }
        false
    }

    /// Puts a node somewhere, and tells its children.
    fn put(&mut self, node: BinaryNode, at: usize) {
        self.nodes[at] = node;
        for child in node.children().into_iter().flatten() {
            self.parents[child] = at as u32;
        }
    }

    /// Makes the boxes above a node what their children need.
    fn fit_above(&mut self, node: usize) {
        let mut node = node;
        while node != 0 {
            node = self.parents[node] as usize;
            let bounds = match self.nodes[node].children() {
                Some([a, b]) => self.nodes[a].bounds.union(&self.nodes[b].bounds),
                None => return,
            };
            if bounds == self.nodes[node].bounds {
                return;
            }
            self.nodes[node].bounds = bounds;
        }
    }
}

/// The other node of a pair.
fn sibling_of(node: usize) -> usize {
    if node % 2 == 1 { node + 1 } else { node - 1 }
}

#[cfg(test)]
mod tests {
    use super::super::build::tests::{hard_cases, items_below};
    use super::super::clusters::{Reach, clustered};
    use super::reinsert;

    #[test]
    fn every_item_stays_in_its_boxes_whatever_is_moved() {
        for n in [1, 2, 3, 500, 3000] {
            for (name, boxes) in hard_cases(n) {
                let mut tree = clustered(&boxes, Reach::Wide { after: 3 });
                let cost = |tree: &super::BinaryTree| -> f64 {
                    let areas = tree.nodes.iter().map(|node| node.bounds.half_area());
                    areas.map(f64::from).sum()
                };
                let before = cost(&tree);
                reinsert(&mut tree, 0.5);
                assert!(items_below(&tree).into_iter().eq(0..n as u32), "{name}");
                assert!(cost(&tree) <= 1.0001 * before, "{name}: {before}");
            }
        }
    }
}
