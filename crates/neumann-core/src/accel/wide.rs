//! Eight-wide nodes over leaves of four triangles, collapsed from a binary tree.
//!
//! Which binary nodes become wide ones is decided by dynamic programming on the surface
//! area heuristic (Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on
//! GPUs Through Compressed Wide BVHs", 3.1): `cost(n, j)` is the cheapest way to represent
//! the subtree of n by at most j wide nodes or leaves.

use glam::Vec3;
use obvhs::bvh2::Bvh2;

/// Children of a wide node.
pub(super) const WIDTH: usize = 8;
/// Triangles of a leaf.
pub(super) const LEAF_SIZE: usize = 4;
/// Marks a child that is a leaf.
pub(super) const LEAF: u32 = 1 << 31;

/// A node with up to eight children.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// `bounds[2 * axis + side][child]`: side 0 is the minimum; never met where there is no child.
    pub(super) bounds: [[f32; WIDTH]; 6],
    /// Index of a node, or [`LEAF`] with the index of a leaf.
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
}

/// Cost of testing the boxes of a node, and of testing the triangles of a leaf.
const NODE_COST: f32 = 1.0;
const LEAF_COST: f32 = 0.5;

const EMPTY_NODE: Node = Node {
    bounds: [
        [f32::INFINITY; WIDTH],
        [f32::NEG_INFINITY; WIDTH],
        [f32::INFINITY; WIDTH],
        [f32::NEG_INFINITY; WIDTH],
        [f32::INFINITY; WIDTH],
        [f32::NEG_INFINITY; WIDTH],
    ],
    children: [0; WIDTH],
};

/// How a subtree is best represented by at most j roots.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Choice {
    /// As one leaf.
    Leaf,
    /// As one wide node.
    Node,
    /// By so many roots in the first child's subtree and the rest in the second's.
    Split(u8),
    /// As with one root less.
    Fewer,
}

/// The plan for one binary node.
#[derive(Clone, Copy, Debug)]
struct Plan {
    /// `cost[j - 1]` for at most j roots, j = 1…7.
    cost: [f32; WIDTH - 1],
    choice: [Choice; WIDTH - 1],
    /// How a wide node made of this one splits its eight children.
    split: u8,
    n_triangles: u32,
}

impl WideTree {
    /// Collapses a binary tree with one triangle in each leaf; leaves of the wide tree have four.
    pub(super) fn of_triangles(binary: &Bvh2, triangles: &[[Vec3; 3]]) -> Self {
        let mut leaves = Vec::with_capacity(triangles.len().div_ceil(2));
        let mut tree = Self::new(binary, LEAF_SIZE, |members| {
            leaves.push(Leaf::new(members, triangles));
            leaves.len() as u32 - 1
        });
        tree.leaves = leaves;
        tree
    }

    /// Collapses a binary tree with one item in each leaf; those of the wide tree stand for the items themselves.
    pub(super) fn of_items(binary: &Bvh2) -> Self {
        Self::new(binary, 1, |members| members[0])
    }

    /// Collapses a binary tree. `leaf` is told the items of each leaf, `leaf_size` at most, and yields its index.
    fn new(binary: &Bvh2, leaf_size: usize, mut leaf: impl FnMut(&[u32]) -> u32) -> Self {
        if binary.nodes.is_empty() {
            return Self::default();
        }
        let plans = plans(binary, leaf_size);
        let mut tree = Self::default();
        let mut members = Vec::with_capacity(leaf_size);
        let mut leaf_of = |source: usize| {
            members.clear();
            collect(binary, source, &mut members);
            LEAF | leaf(&members)
        };
        if let Choice::Leaf = plans[0].choice[0] {
            let mut root = EMPTY_NODE;
            set_child(&mut root, 0, 0, binary);
            root.children[0] = leaf_of(0);
            tree.nodes.push(root);
            tree.depth = 1;
            return tree;
        }
        // Depth first, so that a node's children lie near it.
        let mut work = vec![(0usize, None, 1usize)];
        let mut roots = Vec::with_capacity(WIDTH);
        while let Some((source, parent, depth)) = work.pop() {
            tree.depth = tree.depth.max(depth);
            let index = tree.nodes.len() as u32;
            if let Some((node, lane)) = parent {
                let node: &mut Node = &mut tree.nodes[node as usize];
                node.children[lane as usize] = index;
            }
            let mut node = EMPTY_NODE;
            let first = binary.nodes[source].first_index as usize;
            let split = plans[source].split as usize;
            roots.clear();
            gather(binary, &plans, first, split, &mut roots);
            gather(binary, &plans, first + 1, WIDTH - split, &mut roots);
            for (lane, root) in roots.iter().enumerate() {
                set_child(&mut node, lane, *root, binary);
                if let Choice::Leaf = plans[*root].choice[0] {
                    node.children[lane] = leaf_of(*root);
                } else {
                    work.push((*root, Some((index, lane as u32)), depth + 1));
                }
            }
            tree.nodes.push(node);
        }
        tree
    }

    /// The box around everything: minimum and maximum.
    pub(super) fn bounds(&self) -> [Vec3; 2] {
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

    /// Memory that it takes, bytes.
    pub(super) fn n_bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.leaves.as_slice())
    }
}

fn set_child(node: &mut Node, lane: usize, source: usize, binary: &Bvh2) {
    let bounds = binary.nodes[source].aabb();
    for axis in 0..3 {
        node.bounds[2 * axis][lane] = bounds.min[axis];
        node.bounds[2 * axis + 1][lane] = bounds.max[axis];
    }
}

impl Leaf {
    fn new(members: &[u32], triangles: &[[Vec3; 3]]) -> Self {
        let mut leaf = Self {
            corners: [[[0.0; LEAF_SIZE]; 3]; 3],
            triangles: [0; LEAF_SIZE],
        };
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

/// Plans for all nodes, children before parents.
fn plans(binary: &Bvh2, leaf_size: usize) -> Vec<Plan> {
    let mut plans = vec![
        Plan {
            cost: [0.0; WIDTH - 1],
            choice: [Choice::Leaf; WIDTH - 1],
            split: 0,
            n_triangles: 0,
        };
        binary.nodes.len()
    ];
    let mut order = Vec::with_capacity(binary.nodes.len());
    let mut stack = vec![0usize];
    while let Some(index) = stack.pop() {
        order.push(index);
        let node = &binary.nodes[index];
        if node.prim_count == 0 {
            stack.extend([node.first_index as usize, node.first_index as usize + 1]);
        }
    }
    for index in order.into_iter().rev() {
        let node = &binary.nodes[index];
        let area = node.aabb().half_area();
        plans[index] = if node.prim_count > 0 {
            Plan {
                cost: [area * LEAF_COST; WIDTH - 1],
                choice: [Choice::Leaf; WIDTH - 1],
                split: 0,
                n_triangles: node.prim_count,
            }
        } else {
            let first = node.first_index as usize;
            plan(&plans[first], &plans[first + 1], area, leaf_size)
        };
    }
    plans
}

fn plan(left: &Plan, right: &Plan, area: f32, leaf_size: usize) -> Plan {
    // The cheapest split of j roots between both children.
    let split = |j: usize| {
        (1..j)
            .filter(|k| *k < WIDTH && j - k < WIDTH)
            .map(|k| (left.cost[k - 1] + right.cost[j - k - 1], k as u8))
            .fold((f32::INFINITY, 1), |a, b| if b.0 < a.0 { b } else { a })
    };
    let n_triangles = left.n_triangles + right.n_triangles;
    let (children_cost, children_split) = split(WIDTH);
    let as_node = children_cost + area * NODE_COST;
    let as_leaf = if n_triangles as usize <= leaf_size {
        area * LEAF_COST
    } else {
        f32::INFINITY
    };
    let mut plan = Plan {
        cost: [as_node.min(as_leaf); WIDTH - 1],
        choice: [Choice::Fewer; WIDTH - 1],
        split: children_split,
        n_triangles,
    };
    plan.choice[0] = if as_leaf <= as_node {
        Choice::Leaf
    } else {
        Choice::Node
    };
    for j in 2..WIDTH {
        let (cost, k) = split(j);
        plan.cost[j - 1] = plan.cost[j - 2];
        if cost < plan.cost[j - 1] {
            plan.cost[j - 1] = cost;
            plan.choice[j - 1] = Choice::Split(k);
        }
    }
    plan
}

/// The roots that represent a subtree by at most `j` of them; recurses at most seven deep.
fn gather(binary: &Bvh2, plans: &[Plan], source: usize, j: usize, roots: &mut Vec<usize>) {
    match plans[source].choice[j - 1] {
        Choice::Leaf | Choice::Node => roots.push(source),
        Choice::Fewer => gather(binary, plans, source, j - 1, roots),
        Choice::Split(k) => {
            let first = binary.nodes[source].first_index as usize;
            gather(binary, plans, first, k as usize, roots);
            gather(binary, plans, first + 1, j - k as usize, roots);
        }
    }
}

/// The triangles below a node that becomes a leaf.
fn collect(binary: &Bvh2, source: usize, members: &mut Vec<u32>) {
    let node = &binary.nodes[source];
    let first = node.first_index as usize;
    if node.prim_count > 0 {
        let end = first + node.prim_count as usize;
        members.extend(&binary.primitive_indices[first..end]);
    } else {
        collect(binary, first, members);
        collect(binary, first + 1, members);
    }
}
