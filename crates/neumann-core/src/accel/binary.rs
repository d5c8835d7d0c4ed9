//! Binary trees, which are built first, and of which wide ones are made.

use glam::Vec3A;

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Aabb {
    pub(super) min: Vec3A,
    pub(super) max: Vec3A,
}

/// A binary tree with one item in each leaf. The root is node 0; the others lie in pairs, with
/// the first at an odd index.
#[derive(Clone, Debug, Default)]
pub(super) struct BinaryTree {
    pub(super) nodes: Vec<BinaryNode>,
}

/// A node with two children, or a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    pub(super) bounds: Aabb,
    link: Link,
}

#[derive(Clone, Copy, Debug)]
enum Link {
    Item(u32),
    /// Where the first child is; the second comes next.
    Children(u32),
}

impl Aabb {
    pub(super) const EMPTY: Self = Self {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
    };

    #[inline]
    pub(super) fn of(points: &[impl Into<Vec3A> + Copy]) -> Self {
        points.iter().fold(Self::EMPTY, |bounds, point| {
            let point = (*point).into();
            Self {
                min: bounds.min.min(point),
                max: bounds.max.max(point),
            }
        })
    }

    #[inline]
    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    #[inline]
    pub(super) fn center(&self) -> Vec3A {
        0.5 * (self.min + self.max)
    }

    /// Half of the surface's area.
    #[inline]
    pub(super) fn half_area(&self) -> f32 {
        let d = self.max - self.min;
        (d.x + d.y) * d.z + d.x * d.y
    }
}

impl BinaryNode {
    pub(super) const EMPTY: Self = Self::leaf(Aabb::EMPTY, 0);

    pub(super) const fn leaf(bounds: Aabb, item: u32) -> Self {
        Self {
            bounds,
            link: Link::Item(item),
        }
    }

    /// Its children are at `first` and at the next index.
    pub(super) const fn inner(bounds: Aabb, first: usize) -> Self {
        Self {
            bounds,
            link: Link::Children(first as u32),
        }
    }

    #[inline]
    pub(super) fn item(&self) -> Option<u32> {
        match self.link {
            Link::Item(item) => Some(item),
            Link::Children(_) => None,
        }
    }

    #[inline]
    pub(super) fn children(&self) -> Option<[usize; 2]> {
        match self.link {
            Link::Item(_) => None,
            Link::Children(first) => Some([first as usize, first as usize + 1]),
        }
    }
}

impl BinaryTree {
    /// One that is no deeper than it must be: items in the order of their middles along the
    /// longest axis, halved again and again.
    pub(super) fn of_halves(items: &[Aabb]) -> Self {
        let mut order: Vec<u32> = (0..items.len() as u32).collect();
        let mut nodes = vec![BinaryNode::EMPTY; items.len().min(1)];
        let mut stack = vec![(0, 0..items.len())];
        while let Some((index, range)) = stack.pop() {
            let bounds = order[range.clone()]
                .iter()
                .fold(Aabb::EMPTY, |a, item| a.union(&items[*item as usize]));
            match range.len() {
                0 => continue,
                1 => {
                    nodes[index] = BinaryNode::leaf(bounds, order[range.start]);
                    continue;
                }
                _ => {}
            }
            let axis = (bounds.max - bounds.min).max_position();
            let middle = range.len() / 2;
            order[range.clone()].select_nth_unstable_by(middle, |a, b| {
                let center = |item: &u32| items[*item as usize].center()[axis];
                center(a).total_cmp(&center(b)).then(a.cmp(b))
            });
            let children = nodes.len();
            nodes[index] = BinaryNode::inner(bounds, children);
            nodes.extend([BinaryNode::EMPTY; 2]);
            let cut = range.start + middle;
            stack.push((children, range.start..cut));
            stack.push((children + 1, cut..range.end));
        }
        Self { nodes }
    }

    /// For each node the one above it; the root is its own.
    pub(super) fn parents(&self) -> Vec<u32> {
        let mut parents = vec![0; self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate() {
            for child in node.children().into_iter().flatten() {
                parents[child] = index as u32;
            }
        }
        parents
    }
}
