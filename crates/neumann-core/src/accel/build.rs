//! Builds trees: a binary one, which is collapsed.

use glam::Vec3;
use rayon::prelude::*;

use super::binary::{Aabb, BinaryTree};
use super::clusters::{Reach, clustered};
use super::reinsertion::reinsert;
use super::wide::WideTree;

/// How much work goes into a tree. What a ray meets is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeQuality {
    /// Soon there: neighbours on a space-filling curve are merged as they come.
    Quick,
    /// Soon walked: the best merge among many, and nodes put back where they cost least.
    Full,
}

/// Rounds of merging neighbours before the search for them widens.
const WIDENED_AFTER: usize = 3;

/// A binary tree with one item in each leaf. Reinsertion of half the nodes makes nearly the best
/// tree at half its time; big scenes get less of it.
pub(super) fn binary_tree(items: &[Aabb], quality: TreeQuality) -> BinaryTree {
    let (reach, reinserted) = match quality {
        TreeQuality::Quick => (Reach::Neighbours, 0.0),
        TreeQuality::Full if items.len() > 500_000 => (
            Reach::Wide {
                after: WIDENED_AFTER,
            },
            0.15,
        ),
        TreeQuality::Full => (
            Reach::Wide {
                after: WIDENED_AFTER,
            },
            0.5,
        ),
    };
    if items.is_empty() {
        return BinaryTree::default();
    }
    let mut tree = clustered(items, reach);
    if reinserted > 0.0 {
        reinsert(&mut tree, reinserted);
    }
    tree
}

/// A wide tree over triangles with finite corners.
pub(super) fn tree_of_triangles(triangles: &[[Vec3; 3]], quality: TreeQuality) -> WideTree {
    // What the builder works with is gone before the wide tree is made, which takes most memory.
    let binary = binary_tree(&boxes_of(triangles), quality);
    let tree = WideTree::of_triangles(&binary, triangles);
    if tree.fits_stack() {
        return tree;
    }
    WideTree::of_triangles(&BinaryTree::of_halves(&boxes_of(triangles)), triangles)
}

/// A wide tree over anything that has a box.
pub(super) fn tree_of_items(boxes: &[Aabb], quality: TreeQuality) -> WideTree {
    let tree = WideTree::of_items(&binary_tree(boxes, quality));
    if tree.fits_stack() {
        return tree;
    }
    WideTree::of_items(&BinaryTree::of_halves(boxes))
}

/// The boxes around triangles.
pub(super) fn boxes_of(triangles: &[[Vec3; 3]]) -> Vec<Aabb> {
    triangles
        .par_iter()
        .map(|corners| Aabb::of(corners))
        .collect()
}

#[cfg(test)]
pub(super) mod tests {
    use glam::Vec3A;

    use super::super::binary::{Aabb, BinaryTree};
    use super::{TreeQuality, tree_of_items};
    use crate::sampling::{Sampler, warp};

    /// What trees are hard to build of, by name: ties, progressions, boxes over one another.
    pub(in super::super) fn hard_cases(n: usize) -> Vec<(&'static str, Vec<Aabb>)> {
        let unit_at = |place: Vec3A| Aabb::of(&[place, place + Vec3A::ONE]);
        let random = |i: usize| {
            let mut sampler = Sampler::new(21, i as u64, 0);
            let [x, y] = sampler.next_2d();
            let place = Vec3A::new(x, y, sampler.next_1d());
            (place, Vec3A::from(warp::uniform_sphere(sampler.next_2d())))
        };
        let grows = |i: usize, by: f32| by.powf(i as f32 * (4096.0 / n as f32).min(1.0));
        let each = |at: &dyn Fn(usize) -> Aabb| (0..n).map(at).collect::<Vec<_>>();
        vec![
            ("at random", each(&|i| unit_at(100.0 * random(i).0))),
            ("a line", each(&|i| unit_at(1.5 * i as f32 * Vec3A::X))),
            ("one spot", each(&|_| unit_at(Vec3A::ZERO))),
            (
                "two spots",
                each(&|i| unit_at((i % 2 * 5) as f32 * Vec3A::X)),
            ),
            ("points", each(&|i| Aabb::of(&[Vec3A::splat(i as f32)]))),
            ("flat", each(&|i| Aabb::of(&[Vec3A::Y * (i % 7) as f32]))),
            (
                "growing steps",
                each(&|i| unit_at(grows(i, 1.003) * Vec3A::X)),
            ),
            (
                "growing boxes",
                each(&|i| {
                    let size = grows(i, 1.003);
                    Aabb::of(&[Vec3A::splat(size), Vec3A::splat(2.0 * size)])
                }),
            ),
            (
                "shells",
                each(&|i| Aabb::of(&[Vec3A::splat(-(i as f32)), Vec3A::splat(i as f32)])),
            ),
            (
                "shells that double",
                each(&|i| {
                    let size = 2f32.powi(i as i32 % 80 - 60);
                    Aabb::of(&[Vec3A::splat(-size), Vec3A::splat(size)])
                }),
            ),
            (
                "slivers through one spot",
                each(&|i| {
                    let (_, towards) = random(i);
                    Aabb::of(&[-50.0 * towards, 50.0 * towards])
                }),
            ),
            (
                "slivers",
                each(&|i| {
                    let (place, towards) = random(i);
                    Aabb::of(&[10.0 * place - 5.0 * towards, 10.0 * place + 5.0 * towards])
                }),
            ),
        ]
    }

    /// The items of a tree in order. Every box lies in that above it, or this panics.
    pub(in super::super) fn items_below(tree: &BinaryTree) -> Vec<u32> {
        let mut items = Vec::new();
        let mut stack = vec![0];
        while let Some(index) = stack.pop() {
            let node = &tree.nodes[index];
            items.extend(node.item());
            for child in node.children().into_iter().flatten() {
                let inside = tree.nodes[child].bounds;
                assert_eq!(inside.union(&node.bounds), node.bounds, "node {child}");
                stack.push(child);
            }
        }
        items.sort_unstable();
        items
    }

    #[test]
    fn trees_of_hard_cases_fit_the_stack() {
        for (name, boxes) in hard_cases(20_000) {
            for quality in [TreeQuality::Quick, TreeQuality::Full] {
                assert!(tree_of_items(&boxes, quality).fits_stack(), "{name}");
            }
        }
    }
}
