//! Eight-wide nodes over leaves of four triangles.

use glam::Vec3;

use crate::math::triangle::ExactTriangle;

/// Nodes and leaves that may wait while a tree is walked.
pub(super) const STACK_SIZE: usize = 256;
/// Children of a wide node.
pub(super) const WIDTH: usize = 8;
/// Triangles of a leaf.
pub(super) const LEAF_SIZE: usize = 4;
/// Marks a child that is a leaf,
pub(super) const LEAF: u32 = 1 << 31;
/// and one of which the triangles lie side by side in one plane: a ray that starts or ends on one
/// of them meets none of the others, as double precision finds as well. (Single precision may take
/// one for met where a ray leaves its plane by less than a thousandth: one in a million that is
/// scattered.)
pub(super) const FLAT: u32 = 1 << 30;

/// A node with up to eight children.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// `bounds[2 * axis + side][child]`: side 0 is the minimum; never met where there is no child.
    pub(super) bounds: [[f32; WIDTH]; 6],
    /// Index of a node, or [`LEAF`], perhaps [`FLAT`], with the index of a leaf.
    pub(super) children: [u32; WIDTH],
}

/// Up to four triangles.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Leaf {
    /// `corners[corner][axis][lane]`; unused lanes repeat the first triangle.
    pub(super) corners: [[[f32; LEAF_SIZE]; 3]; 3],
    /// Index of the triangle in each lane.
    pub(super) triangles: [u32; LEAF_SIZE],
}

/// A collapsed tree; the root is node 0.
#[derive(Debug, Default)]
pub(super) struct WideTree {
    pub(super) nodes: Vec<Node>,
    pub(super) leaves: Vec<Leaf>,
    /// Wide nodes on the longest way down.
    pub(super) depth: usize,
    /// The box around everything: minimum and maximum.
    pub(super) bounds: [Vec3; 2],
    /// The largest coordinate of anything.
    pub(super) reach: f32,
    /// True if it is so big that most of it is not at hand in the processor's caches.
    pub(super) is_far: bool,
}

/// Bytes of a tree from which on it pays to ask for nodes before they are visited: a core's own
/// cache holds about as much.
const FAR_BYTES: usize = 512 << 10;

/// Leaves of a tree that is small, at most; there are fewer nodes.
pub(super) const SMALL_LEAVES: usize = 16;

/// A node without children.
pub(super) const EMPTY_NODE: Node = Node {
    bounds: [
        [f32::INFINITY; WIDTH],
        [f32::NEG_INFINITY; WIDTH],
        [f32::INFINITY; WIDTH],
        [f32::NEG_INFINITY; WIDTH],
        [f32::INFINITY; WIDTH],
        [f32::NEG_INFINITY; WIDTH],
    ],
    // A ray with numbers that are not finite may come here all the same: it finds a leaf, and never
    // the root again.
    children: [LEAF; WIDTH],
};

/// A leaf without triangles.
pub(super) const EMPTY_LEAF: Leaf = Leaf {
    corners: [[[0.0; LEAF_SIZE]; 3]; 3],
    triangles: [0; LEAF_SIZE],
};

/// Index of the leaf that a link leads to.
#[inline(always)]
pub(super) fn leaf_of(link: u32) -> usize {
    (link & !(LEAF | FLAT)) as usize
}

impl WideTree {
    /// The box around everything: minimum and maximum.
    fn bounds(&self) -> [Vec3; 2] {
        let side = |side: usize, pick: fn(f32, f32) -> f32, start: f32| {
            Vec3::from_array([0, 1, 2].map(|axis| {
                let rows = self.nodes.first().map(|root| root.bounds[2 * axis + side]);
                rows.into_iter().flatten().fold(start, pick)
            }))
        };
        [
            side(0, f32::min, f32::INFINITY),
            side(1, f32::max, f32::NEG_INFINITY),
        ]
    }

    /// Boxes (minimum and maximum) that together hold everything: the children of the `n_nodes`
    /// uppermost nodes.
    pub(super) fn boxes(&self, n_nodes: usize) -> Vec<[Vec3; 2]> {
        let mut boxes = Vec::new();
        let mut opened: Vec<usize> = (0..self.nodes.len().min(1)).collect();
        let mut next = 0;
        while let Some(node) = opened.get(next).map(|index| &self.nodes[*index]) {
            next += 1;
            for (child, &link) in node.children.iter().enumerate() {
                let side = |side: usize| {
                    Vec3::from_array([0, 1, 2].map(|axis| node.bounds[2 * axis + side][child]))
                };
                let [min, max] = [0, 1].map(side);
                if min.x > max.x {
                    continue;
                }
                if link & LEAF == 0 && opened.len() < n_nodes {
                    opened.push(link as usize);
                } else {
                    boxes.push([min, max]);
                }
            }
        }
        boxes
    }

    /// The same, knowing how big it is.
    pub(super) fn measured(self) -> Self {
        let bounds = self.bounds();
        Self {
            bounds,
            reach: bounds[0].abs().max(bounds[1].abs()).max_element(),
            is_far: self.n_bytes() > FAR_BYTES,
            ..self
        }
    }

    /// True if it is so small that many rays walk it together sooner than each by itself.
    pub(super) fn is_small(&self) -> bool {
        self.leaves.len() <= SMALL_LEAVES
    }

    /// True if the stack of a walk has room for the longest way down, on which all children but one
    /// wait at each node.
    pub(super) fn fits_stack(&self) -> bool {
        self.depth * (WIDTH - 1) < STACK_SIZE
    }

    /// Memory that it takes, bytes.
    pub(super) fn n_bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.leaves.as_slice())
    }
}

/// True if triangles lie side by side in one plane, as far as their coordinates are known.
pub(super) fn is_flat(members: &[u32], triangles: &[[Vec3; 3]]) -> bool {
    let exact = |member: &u32| ExactTriangle::new(&triangles[*member as usize]);
    (1..members.len()).all(|i| {
        let a = exact(&members[i]);
        members[..i].iter().all(|other| {
            let b = exact(other);
            a.lies_in(&b) && b.lies_in(&a) && !a.overlaps(&b)
        })
    })
}

impl Leaf {
    pub(super) fn new(members: &[u32], triangles: &[[Vec3; 3]]) -> Self {
        let mut leaf = EMPTY_LEAF;
        for lane in 0..LEAF_SIZE {
            let triangle = *members.get(lane).unwrap_or(&members[0]);
            leaf.triangles[lane] = triangle;
            for (corner, position) in triangles[triangle as usize].iter().enumerate() {
                for axis in 0..3 {
                    leaf.corners[corner][axis][lane] = position[axis];
                }
            }
        }
        leaf
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::is_flat;

    #[test]
    fn triangles_side_by_side_in_one_plane_are_flat() {
        let at = |x: f32, y: f32| Vec3::new(x, 0.5 * x + y, 7.0 + x);
        let pair = [
            [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0)],
            [at(0.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)],
        ];
        assert!(is_flat(&[0], &pair) && is_flat(&[0, 1], &pair));
        // One that lies on the others, one that is turned out of the plane, one a step above.
        let apart = |by: Vec3| pair[1].map(|corner| corner + by);
        let folded = [pair[1][0], pair[1][1], pair[1][2] + 0.01 * Vec3::Z];
        for other in [pair[0], folded, apart(1e-4 * Vec3::Z)] {
            let three = [pair[0], pair[1], other];
            assert!(!is_flat(&[0, 1, 2], &three), "{other:?}");
        }
        assert!(!is_flat(&[0, 1], &[pair[0], folded]));
    }
}
