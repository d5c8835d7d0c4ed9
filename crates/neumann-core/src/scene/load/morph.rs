//! Morph targets, added once with their default weights.
//!
//! position = base + `Σ_k w_k · target_k`; normals and tangents likewise
//! (glTF 2.0, 3.7.2.2).

use glam::Vec3;

use super::File;
use super::accessor::Accessor;
use super::error::Fault;
use super::json::Item;
use super::notes::Notes;
use crate::scene::description::MeshDescription;

/// The `weights` of a mesh or a node.
pub(super) fn weights(item: &Item<'_>) -> Result<Option<Vec<f32>>, Fault> {
    if !item.has("weights") {
        return Ok(None);
    }
    let number = |(i, value): (usize, &serde_json::Value)| {
        value.as_f64().map(|weight| weight as f32).ok_or_else(|| {
            Fault::broken(format!("{}[{i}]", item.path("weights")), "is not a number")
        })
    };
    let weights: Result<Vec<f32>, Fault> = item
        .list("weights")?
        .iter()
        .enumerate()
        .map(number)
        .collect();
    weights.map(Some)
}

/// Adds the targets whose weight is not zero to a mesh.
pub(super) fn add_targets(
    file: &File<'_>,
    primitive: &Item<'_>,
    weights: &[f32],
    vertices: &[u32],
    mesh: &mut MeshDescription,
    notes: &mut Notes,
) -> Result<(), Fault> {
    for (k, &weight) in weights.iter().enumerate() {
        if weight == 0.0 {
            continue;
        }
        if !weight.is_finite() {
            notes.warn(format!(
                "{}: weight {k} of the morph targets is not finite and is ignored",
                primitive.at()
            ));
            continue;
        }
        let Some(target) = primitive.list_item("targets", k)? else {
            break;
        };
        let mut n_odd = 0;
        let mut add = |key: &str, values: &mut dyn Iterator<Item = &mut Vec3>| {
            add_weighted(file, &target, key, weight, vertices, values).map(|n| n_odd += n)
        };
        add("POSITION", &mut mesh.positions.iter_mut())?;
        add("NORMAL", &mut mesh.normals.iter_mut().flatten())?;
        if let Some(tangents) = &mut mesh.tangents {
            let mut xyz: Vec<Vec3> = tangents.iter().map(|t| t.truncate()).collect();
            add("TANGENT", &mut xyz.iter_mut())?;
            for (tangent, xyz) in tangents.iter_mut().zip(xyz) {
                *tangent = xyz.extend(tangent.w);
            }
        }
        if n_odd > 0 {
            notes.warn(format!(
                "{}: {n_odd} vectors are not finite and move nothing",
                target.at()
            ));
        }
    }
    Ok(())
}

/// Adds one attribute; tells how many of its vectors are not finite and left out.
fn add_weighted(
    file: &File<'_>,
    target: &Item<'_>,
    key: &str,
    weight: f32,
    vertices: &[u32],
    values: &mut dyn Iterator<Item = &mut Vec3>,
) -> Result<usize, Fault> {
    let Some(accessor) = Accessor::open(file, target, key, &["VEC3"])? else {
        return Ok(0);
    };
    file.allowance
        .spend(vertices.len(), size_of::<Vec3>(), target.at())?;
    let mut n_odd = 0;
    for (value, &vertex) in values.zip(vertices) {
        if vertex as usize >= accessor.count() {
            return Err(Fault::broken(
                format!("{}.count", accessor.at()),
                format!("is {}, fewer than there are positions", accessor.count()),
            ));
        }
        let offset = weight * Vec3::from_array(accessor.floats(vertex as usize));
        if offset.is_finite() {
            *value += offset;
        } else {
            n_odd += 1;
        }
    }
    Ok(n_odd)
}
