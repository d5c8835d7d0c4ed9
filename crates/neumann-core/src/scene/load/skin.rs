//! Skins, in the pose that the nodes stand in.
//!
//! Animations are not played, yet a skinned mesh only has its right shape and
//! place through its joints: vertex = `Σ_j w_j · world_from_joint_j ·
//! inverse_bind_j · v`, the transform of the mesh's own node being ignored
//! (glTF 2.0, 3.7.3.3).

use glam::{Mat3, Mat4};

use super::File;
use super::accessor::Accessor;
use super::draco::Attributes;
use super::error::Fault;
use super::node::Hierarchy;
use super::notes::Notes;
use crate::scene::description::MeshDescription;

/// Sets `JOINTS_0` to `JOINTS_3` are read: sixteen joints for each vertex.
const MOST_SETS: usize = 4;

/// The joints of one skin.
#[derive(Debug)]
pub(super) struct Skin {
    /// `world_from_bind[joint]`: where the joint takes the mesh as modelled.
    world_from_bind: Vec<Mat4>,
}

impl Skin {
    /// Reads a skin.
    pub(super) fn read(
        file: &File<'_>,
        hierarchy: &Hierarchy,
        index: usize,
        notes: &mut Notes,
    ) -> Result<Self, Fault> {
        let item = file.document.item("skins", index)?;
        let joints = item.indices("joints")?;
        file.allowance
            .spend(joints.len(), size_of::<Mat4>(), item.at())?;
        let inverse_binds = Accessor::open(file, &item, "inverseBindMatrices", &["MAT4"])?;
        if let Some(inverse_binds) = &inverse_binds
            && inverse_binds.count() < joints.len()
        {
            return Err(Fault::broken(
                item.path("inverseBindMatrices"),
                format!(
                    "has {} matrices for {} joints",
                    inverse_binds.count(),
                    joints.len()
                ),
            ));
        }
        let mut n_odd = 0;
        let mut world_from_bind = Vec::with_capacity(joints.len());
        for (i, &joint) in joints.iter().enumerate() {
            file.document
                .check(&format!("{}[{i}]", item.path("joints")), joint, "nodes")?;
            let inverse_bind = inverse_binds.as_ref().map_or(Mat4::IDENTITY, |matrices| {
                Mat4::from_cols_array(&matrices.floats(i))
            });
            n_odd += usize::from(!inverse_bind.is_finite());
            let inverse_bind = Some(inverse_bind).filter(|matrix| matrix.is_finite());
            world_from_bind
                .push(hierarchy.world_from_node[joint] * inverse_bind.unwrap_or(Mat4::IDENTITY));
        }
        if n_odd > 0 {
            notes.warn(format!(
                "{}: {n_odd} matrices are not finite; the identity stands in",
                item.path("inverseBindMatrices")
            ));
        }
        Ok(Self { world_from_bind })
    }

    /// Moves a mesh, whose vertices are `vertices` of the primitive, to the world.
    ///
    /// Returns false, and leaves the mesh alone, when it has no joints.
    pub(super) fn pose(
        &self,
        file: &File<'_>,
        attributes: &Attributes<'_>,
        vertices: &[u32],
        mesh: &mut MeshDescription,
        notes: &mut Notes,
    ) -> Result<bool, Fault> {
        let Some(blended) = self.blend(file, attributes, vertices, notes)? else {
            return Ok(false);
        };
        for (position, matrix) in mesh.positions.iter_mut().zip(&blended) {
            *position = matrix.transform_point3(*position);
        }
        if let Some(normals) = &mut mesh.normals {
            for (normal, matrix) in normals.iter_mut().zip(&blended) {
                let linear = Mat3::from_mat4(*matrix);
                let cofactors = Mat3::from_cols(
                    linear.y_axis.cross(linear.z_axis),
                    linear.z_axis.cross(linear.x_axis),
                    linear.x_axis.cross(linear.y_axis),
                );
                let sign = linear.determinant().signum();
                *normal = (cofactors * *normal * sign).normalize_or(*normal);
            }
        }
        if let Some(tangents) = &mut mesh.tangents {
            for (tangent, matrix) in tangents.iter_mut().zip(&blended) {
                let turned = matrix.transform_vector3(tangent.truncate());
                let unit = turned.normalize_or(tangent.truncate());
                *tangent = unit.extend(tangent.w);
            }
        }
        // Joints that mirror turn the mesh inside out; its triangles follow.
        let n_mirrored = blended.iter().filter(|m| m.determinant() < 0.0).count();
        if 2 * n_mirrored > blended.len() {
            for triangle in &mut mesh.triangles {
                triangle.swap(1, 2);
            }
        }
        Ok(true)
    }

    /// The weighted mean of the joints' matrices, for each vertex.
    fn blend(
        &self,
        file: &File<'_>,
        attributes: &Attributes<'_>,
        vertices: &[u32],
        notes: &mut Notes,
    ) -> Result<Option<Vec<Mat4>>, Fault> {
        let mut n_odd = 0;
        let mut sums: Option<Vec<(Mat4, f32)>> = None;
        for set in 0..MOST_SETS {
            let (joints_key, weights_key) = (format!("JOINTS_{set}"), format!("WEIGHTS_{set}"));
            let joints = attributes.open(file, &joints_key, &["VEC4"])?;
            let weights = attributes.open(file, &weights_key, &["VEC4"])?;
            let (Some(joints), Some(weights)) = (joints, weights) else {
                break;
            };
            let (joints, weights) = (joints.unsigned()?, weights.normalized());
            let needed = vertices.iter().max().map_or(0, |&last| last as usize + 1);
            if joints.count().min(weights.count()) < needed {
                return Err(Fault::broken(
                    attributes.path(&joints_key),
                    "has fewer elements than POSITION",
                ));
            }
            if sums.is_none() {
                file.allowance.spend(
                    vertices.len(),
                    2 * size_of::<(Mat4, f32)>(),
                    attributes.at(),
                )?;
            }
            let sums = sums.get_or_insert_with(|| vec![(Mat4::ZERO, 0.0); vertices.len()]);
            for ((sum, total), &vertex) in sums.iter_mut().zip(vertices) {
                let joints: [u32; 4] = joints.integers(vertex as usize);
                let weights: [f32; 4] = weights.floats(vertex as usize);
                for (joint, weight) in joints.into_iter().zip(weights) {
                    n_odd += usize::from(!weight.is_finite());
                    if !(weight.is_finite() && weight > 0.0) {
                        continue;
                    }
                    let Some(matrix) = self.world_from_bind.get(joint as usize) else {
                        return Err(Fault::broken(
                            attributes.path(&joints_key),
                            format!(
                                "names joint {joint}, but the skin has {}",
                                self.world_from_bind.len()
                            ),
                        ));
                    };
                    *sum += *matrix * weight;
                    *total += weight;
                }
            }
        }
        if n_odd > 0 {
            notes.warn(format!(
                "{}: {n_odd} weights of joints are not finite and count as 0",
                attributes.at()
            ));
        }
        Ok(sums.map(|sums| {
            let first = self.world_from_bind.first().copied().unwrap_or_default();
            sums.into_iter()
                .map(|(sum, total)| {
                    if total > 0.0 {
                        sum * total.recip()
                    } else {
                        first
                    }
                })
                .collect()
        }))
    }
}
