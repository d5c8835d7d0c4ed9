//! Builds trees: obvhs makes the binary one, which is collapsed.

use glam::Vec3;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::triangle::Triangle;
use rayon::prelude::*;

use super::wide::WideTree;

/// How much work goes into a tree. What a ray meets is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeQuality {
    /// Soon there: neighbours on a space-filling curve are merged as they come.
    Quick,
    /// Soon walked: the best merge among many, and nodes put back where they cost least.
    Full,
}

/// A binary tree with one item in each leaf. Reinsertion of half the nodes makes nearly the best tree at half its time; big
/// scenes get less of it.
pub(super) fn binary_tree<T: Boundable>(items: &[T], quality: TreeQuality) -> Bvh2 {
    let n = items.len();
    let (search, threshold, reinserted) = match quality {
        TreeQuality::Quick => (PlocSearchDistance::Minimum, 0, 0.0),
        TreeQuality::Full if n > 500_000 => (PlocSearchDistance::Medium, WIDENED_AFTER, 0.15),
        TreeQuality::Full => (PlocSearchDistance::Medium, WIDENED_AFTER, 0.5),
    };
    let mut tree = PlocBuilder::with_capacity(n).build(
        search,
        items,
        (0..n as u32).collect(),
        SortPrecision::U64,
        threshold,
    );
    if reinserted > 0.0 {
        ReinsertionOptimizer::default().run(&mut tree, reinserted, None);
    }
    tree
}

/// Rounds of merging neighbours before the search for them widens: obvhs's own for trees of medium quality.
const WIDENED_AFTER: usize = 3;

/// A wide tree over triangles with finite corners.
pub(super) fn tree_of_triangles(triangles: &[[Vec3; 3]], quality: TreeQuality) -> WideTree {
    if triangles.is_empty() {
        return WideTree::default();
    }
    // What the builder works with is gone before the wide tree is made, which takes most memory.
    let binary = binary_tree(&for_builder(triangles), quality);
    let tree = WideTree::of_triangles(&binary, triangles);
    if tree.fits_stack() {
        return tree;
    }
    WideTree::of_triangles(&halves(&for_builder(triangles)), triangles)
}

/// Triangles as obvhs has them.
pub(super) fn for_builder(triangles: &[[Vec3; 3]]) -> Vec<Triangle> {
    triangles
        .par_iter()
        .map(|t| Triangle {
            v0: t[0].into(),
            v1: t[1].into(),
            v2: t[2].into(),
        })
        .collect()
}

/// A binary tree that is no deeper than it must be: items in the order of their middles along the longest axis, halved again
/// and again. A way out should another tree be too deep to be walked; no triangles are known that make it so.
pub(super) fn halves<T: Boundable>(items: &[T]) -> Bvh2 {
    let boxes: Vec<Aabb> = items.iter().map(Boundable::aabb).collect();
    let mut order: Vec<u32> = (0..items.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default()];
    let mut stack = vec![(0, 0..items.len())];
    while let Some((index, range)) = stack.pop() {
        let mut bounds = Aabb::empty();
        for item in &order[range.clone()] {
            bounds.extend(boxes[*item as usize].min);
            bounds.extend(boxes[*item as usize].max);
        }
        if range.len() == 1 {
            nodes[index] = Bvh2Node::new(bounds, 1, range.start as u32);
            continue;
        }
        let axis = bounds.largest_axis();
        let middle = range.len() / 2;
        order[range.clone()].select_nth_unstable_by(middle, |a, b| {
            let center = |item: &u32| boxes[*item as usize].center()[axis];
            center(a).total_cmp(&center(b)).then(a.cmp(b))
        });
        let children = nodes.len();
        nodes[index] = Bvh2Node::new(bounds, 0, children as u32);
        nodes.extend([Bvh2Node::default(); 2]);
        let cut = range.start + middle;
        stack.push((children, range.start..cut));
        stack.push((children + 1, cut..range.end));
    }
    Bvh2 {
        nodes,
        primitive_indices: order,
        ..Bvh2::default()
    }
}
