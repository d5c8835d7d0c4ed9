//! The node hierarchy: who stands where, and what is visible.
//!
//! Every node gets its world transform, also those of other scenes, because
//! joints may stand anywhere. The hierarchy must be a forest: a node with two
//! parents, or one that is its own ancestor, is a fault. Nothing recurses, so a
//! chain of a million nodes is as good as any.
//!
//! Transforms are kept as the file has them: they may mirror (negative
//! scale), in which case whoever builds the scene turns the triangles around.

use glam::{DMat4, DQuat, DVec3, Mat4};

use super::error::Fault;
use super::json::{Document, Item};
use super::notes::Notes;

/// All nodes of the file.
#[derive(Debug)]
pub(super) struct Hierarchy {
    /// Nodes of the scene, in ascending order.
    pub(super) nodes: Vec<usize>,
    /// `world_from_node[node]`.
    pub(super) world_from_node: Vec<Mat4>,
    /// `is_visible[node]`: neither hidden itself nor by an ancestor.
    pub(super) is_visible: Vec<bool>,
}

/// Reads the nodes, and which of them belong to the scene (all, without one).
pub(super) fn read(
    document: &Document,
    scene: Option<&Item<'_>>,
    notes: &mut Notes,
) -> Result<Hierarchy, Fault> {
    let n_nodes = document.count("nodes");
    let (children, parents) = read_family(document)?;

    // Parents come before their children on this walk, so each node finds its
    // parent's transform ready.
    let mut world = vec![DMat4::IDENTITY; n_nodes];
    let mut is_visible = vec![true; n_nodes];
    let mut n_placed = 0;
    let mut stack: Vec<usize> = (0..n_nodes).filter(|&n| parents[n].is_none()).collect();
    while let Some(node) = stack.pop() {
        let item = document.item("nodes", node)?;
        let local = local_transform(&item, notes)?;
        let is_shown = match item.extension("KHR_node_visibility")? {
            Some(visibility) => visibility.flag("visible")?.unwrap_or(true),
            None => true,
        };
        (world[node], is_visible[node]) = match parents[node] {
            Some(parent) => (world[parent] * local, is_visible[parent] && is_shown),
            None => (local, is_shown),
        };
        n_placed += 1;
        stack.extend(&children[node]);
    }
    if n_placed < n_nodes {
        return Err(cycle(&parents));
    }

    let roots = match scene {
        Some(scene) => scene_roots(document, scene, &parents, notes)?,
        None => (0..n_nodes).filter(|&n| parents[n].is_none()).collect(),
    };
    let mut is_in_scene = vec![false; n_nodes];
    let mut stack = roots;
    while let Some(node) = stack.pop() {
        if !is_in_scene[node] {
            is_in_scene[node] = true;
            stack.extend(&children[node]);
        }
    }
    Ok(Hierarchy {
        nodes: (0..n_nodes).filter(|&node| is_in_scene[node]).collect(),
        world_from_node: world.iter().map(DMat4::as_mat4).collect(),
        is_visible,
    })
}

/// `children[node]` and `parents[node]`.
type Family = (Vec<Vec<usize>>, Vec<Option<usize>>);

fn read_family(document: &Document) -> Result<Family, Fault> {
    let n_nodes = document.count("nodes");
    let mut children = Vec::with_capacity(n_nodes);
    let mut parents = vec![None; n_nodes];
    for node in 0..n_nodes {
        let item = document.item("nodes", node)?;
        let of_node = item.indices("children")?;
        for (i, &child) in of_node.iter().enumerate() {
            let field = || format!("{}[{i}]", item.path("children"));
            if child >= n_nodes {
                document.check(&field(), child, "nodes")?;
            }
            if let Some(other) = parents[child].replace(node) {
                return Err(Fault::broken(
                    field(),
                    format!("names nodes[{child}], which is a child of nodes[{other}] already"),
                ));
            }
        }
        children.push(of_node);
    }
    Ok((children, parents))
}

/// Names a node that is its own ancestor; there is one.
fn cycle(parents: &[Option<usize>]) -> Fault {
    // A node without a root above it leads, parent by parent, into a cycle;
    // nodes above a tree's root end the walk, and the next start is tried.
    let mut reached_from = vec![usize::MAX; parents.len()];
    for start in 0..parents.len() {
        let mut node = start;
        while reached_from[node] == usize::MAX {
            reached_from[node] = start;
            match parents[node] {
                Some(parent) => node = parent,
                None => break,
            }
        }
        if reached_from[node] == start && parents[node].is_some() {
            return Fault::broken(
                format!("nodes[{node}].children"),
                format!("nodes[{node}] is its own ancestor"),
            );
        }
    }
    Fault::broken("nodes", "do not form a tree")
}

fn scene_roots(
    document: &Document,
    scene: &Item<'_>,
    parents: &[Option<usize>],
    notes: &mut Notes,
) -> Result<Vec<usize>, Fault> {
    let roots = scene.indices("nodes")?;
    for (i, &root) in roots.iter().enumerate() {
        let field = format!("{}[{i}]", scene.path("nodes"));
        document.check(&field, root, "nodes")?;
        if parents[root].is_some() {
            notes.warn(format!(
                "{field}: nodes[{root}] is not a root; it is placed below its parent all the same"
            ));
        }
    }
    Ok(roots)
}

/// `matrix`, or translation times rotation times scale.
fn local_transform(node: &Item<'_>, notes: &mut Notes) -> Result<DMat4, Fault> {
    if let Some(columns) = node.numbers::<16>("matrix")? {
        return Ok(Mat4::from_cols_array(&columns).as_dmat4());
    }
    let translation = node.numbers("translation")?.unwrap_or([0.0; 3]);
    let scale = node.numbers("scale")?.unwrap_or([1.0; 3]);
    let rotation = node.numbers("rotation")?.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let rotation = unit_quaternion(rotation).unwrap_or_else(|| {
        notes.warn(format!(
            "{}: is not a rotation; the node is left unrotated",
            node.path("rotation")
        ));
        DQuat::IDENTITY
    });
    Ok(DMat4::from_scale_rotation_translation(
        DVec3::from_array(scale.map(f64::from)),
        rotation,
        DVec3::from_array(translation.map(f64::from)),
    ))
}

/// Normalises; `None` when there is nothing to normalise.
pub(super) fn unit_quaternion(xyzw: [f32; 4]) -> Option<DQuat> {
    let quaternion = DQuat::from_array(xyzw.map(f64::from));
    let length = quaternion.length();
    (length.is_finite() && length > 1e-12).then(|| quaternion / length)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::json::Document;
    use super::super::notes::Notes;
    use super::{Hierarchy, read};
    use crate::scene::load::error::Fault;

    fn hierarchy(text: &str) -> Result<Hierarchy, Fault> {
        let document = Document::parse(text.as_bytes()).unwrap();
        let scene = document.item("scenes", 0).ok();
        read(&document, scene.as_ref(), &mut Notes::default())
    }

    #[test]
    fn transforms_multiply_and_hiding_descends() {
        let found = hierarchy(
            r#"{"scenes":[{"nodes":[2]}],"nodes":[
                {"translation":[1,0,0]},{"name":"elsewhere"},
                {"scale":[-2,2,2],"rotation":[0,0,0,0],"children":[0],
                 "extensions":{"KHR_node_visibility":{"visible":false}}}]}"#,
        )
        .unwrap();
        assert_eq!(found.nodes, [0, 2]);
        let origin = found.world_from_node[0].transform_point3(Vec3::ZERO);
        assert_eq!(origin, Vec3::new(-2.0, 0.0, 0.0));
        assert_eq!(found.is_visible, [false, true, false]);
    }

    #[test]
    fn quaternions_are_normalised() {
        let found = hierarchy(r#"{"nodes":[{"rotation":[0,0,3,3]}]}"#).unwrap();
        let x = found.world_from_node[0].transform_vector3(Vec3::X);
        assert!(x.distance(Vec3::Y) < 1e-6);
    }

    #[test]
    fn only_forests_are_accepted() {
        for text in [
            r#"{"nodes":[{"children":[0]}]}"#,
            r#"{"nodes":[{},{"children":[2]},{"children":[3]},{"children":[1]}]}"#,
            r#"{"nodes":[{"children":[2]},{"children":[2]},{}]}"#,
            r#"{"nodes":[{"children":[1,1]},{}]}"#,
            r#"{"nodes":[{"children":[1]}]}"#,
            r#"{"nodes":[{}],"scenes":[{"nodes":[1]}]}"#,
        ] {
            assert!(hierarchy(text).is_err(), "{text}");
        }
        let fault = hierarchy(r#"{"nodes":[{"children":[1]},{"children":[0]}]}"#).unwrap_err();
        assert!(fault.problem.contains("own ancestor"));
    }

    #[test]
    fn long_chains_do_not_overflow_the_stack() {
        let n = 200_000;
        let mut text = String::from(r#"{"nodes":["#);
        for i in 1..n {
            text.push_str(&format!(r#"{{"children":[{i}]}},"#));
        }
        text.push_str("{}]}");
        assert_eq!(hierarchy(&text).unwrap().nodes.len(), n);
    }
}
