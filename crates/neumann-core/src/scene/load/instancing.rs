//! Copies of a mesh below one node (`EXT_mesh_gpu_instancing`).

use glam::{DVec3, Mat4};

use super::File;
use super::accessor::Accessor;
use super::error::Fault;
use super::json::Item;
use super::node::unit_quaternion;
use crate::scene::description::InstanceDescription;

/// The transforms `node_from_copy[copy]`; `None` when the node is not instanced.
///
/// Each of them will take an instance with a name of `name_length` bytes.
pub(super) fn read(
    file: &File<'_>,
    node: &Item<'_>,
    name_length: usize,
) -> Result<Option<Vec<Mat4>>, Fault> {
    let Some(extension) = node.extension("EXT_mesh_gpu_instancing")? else {
        return Ok(None);
    };
    let Some(attributes) = extension.child("attributes")? else {
        return Ok(None);
    };
    let open = |key, kind| Accessor::open(file, &attributes, key, &[kind]);
    let translations = open("TRANSLATION", "VEC3")?;
    let rotations = open("ROTATION", "VEC4")?.map(Accessor::normalized);
    let scales = open("SCALE", "VEC3")?;

    let counts = [&translations, &rotations, &scales].map(|a| a.as_ref().map(Accessor::count));
    let Some(count) = counts.into_iter().flatten().next() else {
        return Ok(None);
    };
    if counts.into_iter().flatten().any(|other| other != count) {
        return Err(Fault::broken(
            attributes.at(),
            "name accessors of different counts",
        ));
    }
    let size = size_of::<InstanceDescription>() + size_of::<Mat4>() + name_length + 24;
    file.allowance.spend(count, size, attributes.at())?;
    let transform = |copy: usize| {
        let vector = |accessor: &Option<Accessor<'_>>, default| {
            let values = accessor.as_ref().map_or(default, |a| a.floats(copy));
            DVec3::from_array(values.map(f64::from))
        };
        let rotation = rotations
            .as_ref()
            .and_then(|a| unit_quaternion(a.floats(copy)));
        Mat4::from_scale_rotation_translation(
            vector(&scales, [1.0; 3]).as_vec3(),
            rotation.unwrap_or_default().as_quat(),
            vector(&translations, [0.0; 3]).as_vec3(),
        )
    };
    Ok(Some((0..count).map(transform).collect()))
}
