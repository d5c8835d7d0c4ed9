//! Emissive triangles of a mesh that stands in the world many times: kept once, in the mesh's own
//! space.
//!
//! The tree over all lights leads to an instance, and a tree of the mesh's own, which the point is
//! taken to, on to a
//! triangle. What is in front of a triangle, or of the point, stays so under any affine map, so
//! that bounds
//! rule out the same lights in either space; only estimates suffer where the map stretches.

use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec3};

use super::area::{AreaLight, Emitter, Panel};
use super::bounds::LightBounds;
use super::build::build;
use super::receiver::{Chosen, Receiver};
use super::tree::LightTree;
use crate::sampling::discrete::AliasTable;

/// The lights of a mesh.
#[derive(Debug)]
pub struct MeshLights {
    /// In the mesh's own space; their triangles are counted within the mesh.
    lights: Vec<AreaLight>,
    /// `of_triangle[triangle]`: its light, or `u32::MAX`.
    of_triangle: Vec<u32>,
    /// Choice by power.
    power: AliasTable,
    /// Choice by what they send to a point.
    tree: LightTree,
    bounds: LightBounds,
    /// Power of all, W, mean of the channels.
    total: f64,
}

/// The lights of a mesh, placed in the world.
#[derive(Clone, Debug)]
pub struct LightInstance {
    mesh: Arc<MeshLights>,
    world_from_mesh: Affine3A,
    mesh_from_world: Affine3A,
    /// Takes normals along, towards the front, and areas with them.
    normal_matrix: Mat3,
    /// Number of the mesh's first triangle in the scene.
    first_triangle: u32,
    /// Number of its first light in the scene.
    pub(super) first_light: usize,
}

impl MeshLights {
    /// The lights of a mesh of so many triangles, which face the other way if the mesh is placed as
    /// its mirror image;
    /// `None` if they have no power.
    #[must_use]
    pub fn new(lights: Vec<AreaLight>, n_triangles: usize, is_mirrored: bool) -> Option<Self> {
        let bounds: Vec<Option<LightBounds>> = lights
            .iter()
            .map(|light| {
                let bounds = light.emitter().bounds();
                let side = if is_mirrored { -1.0 } else { 1.0 };
                (bounds.intensity > 0.0 && bounds.intensity.is_finite()).then_some(LightBounds {
                    axis: bounds.axis * side,
                    vector: bounds.vector * side,
                    ..bounds
                })
            })
            .collect();
        let power: Vec<f64> = lights
            .iter()
            .map(|light| f64::from(light.emitter().power().mean()))
            .collect();
        let power_table = AliasTable::new(&power)?;
        let intensity: f64 = bounds
            .iter()
            .flatten()
            .map(|b| f64::from(b.intensity))
            .sum();
        let (tree, root) = build(&bounds, 1.0 / intensity);
        let mut of_triangle = vec![u32::MAX; n_triangles];
        for (light, i) in lights.iter().zip(0..) {
            of_triangle[light.triangle() as usize] = i;
        }
        Some(Self {
            lights,
            of_triangle,
            power: power_table,
            tree,
            bounds: root?,
            total: power.iter().sum(),
        })
    }
}

impl LightInstance {
    /// The mesh placed by a transform that can be undone, where its triangles have numbers from
    /// `first_triangle` on.
    #[must_use]
    pub fn new(mesh: Arc<MeshLights>, world_from_mesh: Affine3A, first_triangle: u32) -> Self {
        let linear = Mat3::from(world_from_mesh.matrix3);
        let side = 1f32.copysign(linear.determinant());
        let normal_matrix = Mat3::from_cols(
            linear.y_axis.cross(linear.z_axis),
            linear.z_axis.cross(linear.x_axis),
            linear.x_axis.cross(linear.y_axis),
        ) * side;
        Self {
            mesh_from_world: world_from_mesh.inverse(),
            mesh,
            world_from_mesh,
            normal_matrix,
            first_triangle,
            first_light: 0,
        }
    }

    pub(super) fn n_lights(&self) -> usize {
        self.mesh.lights.len()
    }

    /// How much larger areas are in the world: exact for a map that keeps angles, else a mean over
    /// directions.
    fn area_scale(&self) -> f32 {
        let columns = self.normal_matrix.to_cols_array_2d();
        let squared: f32 = columns.iter().flatten().map(|x| x * x).sum();
        (squared / 3.0).sqrt()
    }

    /// Power, W, mean of the channels.
    pub(super) fn power(&self) -> f64 {
        self.mesh.total * f64::from(self.area_scale())
    }

    /// Where its lights are and where they shine; `None` if they are too weak or strong for
    /// numbers.
    pub(super) fn bounds(&self) -> Option<LightBounds> {
        let own = &self.mesh.bounds;
        let corners = (0..8).map(|i| {
            let pick = |bit, low, high| if i & bit == 0 { low } else { high };
            self.world_from_mesh.transform_point3(Vec3::new(
                pick(1, own.min.x, own.max.x),
                pick(2, own.min.y, own.max.y),
                pick(4, own.min.z, own.max.z),
            ))
        });
        let (min, max) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), p| {
            (min.min(p), max.max(p))
        });
        let vector = self.normal_matrix * own.vector;
        let intensity = (own.intensity * self.area_scale()).max(vector.length());
        let axis = (self.normal_matrix * own.axis).try_normalize();
        let theta_o = if self.keeps_angles() {
            own.theta_o + SAME_ANGLE
        } else {
            std::f32::consts::PI
        };
        (intensity > 0.0 && intensity.is_finite()).then_some(LightBounds {
            min,
            max,
            axis: axis.unwrap_or(Vec3::Z),
            theta_o: if axis.is_some() {
                theta_o
            } else {
                std::f32::consts::PI
            },
            intensity,
            vector,
            ..*own
        })
    }

    /// True for a rotation with a scale that is the same along all axes.
    fn keeps_angles(&self) -> bool {
        let m = Mat3::from(self.world_from_mesh.matrix3);
        let squared = m.x_axis.length_squared();
        let products = [
            m.y_axis.length_squared() - squared,
            m.z_axis.length_squared() - squared,
            m.x_axis.dot(m.y_axis),
            m.y_axis.dot(m.z_axis),
            m.z_axis.dot(m.x_axis),
        ];
        products.iter().all(|x| x.abs() <= SAME_ANGLE * squared)
    }

    /// A light of the mesh by its power, by a number in [0, 1).
    pub(super) fn by_power(&self, u: f32) -> Chosen {
        let (index, part) = self.mesh.power.sample_and_rest(u);
        Chosen {
            light: index,
            pmf: self.mesh.power.pmf(index),
            part,
        }
    }

    /// Probability of a light of the mesh by power.
    pub(super) fn pmf_by_power(&self, light: usize) -> f32 {
        self.mesh.power.pmf(light)
    }

    /// A light of the mesh by what it may send to a point, by a number in [0, 1); `None` where none
    /// can reach it.
    pub(super) fn by_tree(&self, at: &Receiver, u: f32) -> Option<Chosen> {
        let at = self.receiver(at);
        let tree = &self.mesh.tree;
        tree.sample(&at, tree.root(&at), u)
    }

    /// Probability of a light of the mesh by what it may send to a point.
    pub(super) fn pmf_by_tree(&self, at: &Receiver, light: usize) -> f32 {
        let tree = &self.mesh.tree;
        if !tree.has(light) {
            return 0.0;
        }
        let at = self.receiver(at);
        tree.pmf(&at, tree.root(&at), light)
    }

    /// The point in the mesh's own space.
    fn receiver(&self, at: &Receiver) -> Receiver {
        let position = self.mesh_from_world.transform_point3(at.position);
        let linear = Mat3::from(self.world_from_mesh.matrix3);
        match (linear.transpose() * at.normal).try_normalize() {
            Some(normal) => Receiver::new(position, normal, at.has_both_sides()),
            None => Receiver::new(position, Vec3::Z, true),
        }
    }

    /// A light of the mesh as it stands in the world.
    pub(super) fn emitter(&self, light: usize) -> Emitter<'_> {
        let own = self.mesh.lights[light].emitter();
        let corners = own
            .panel
            .corners
            .map(|p| self.world_from_mesh.transform_point3(p));
        let triangle = self.first_triangle + own.panel.triangle;
        Emitter {
            panel: Panel::new(corners, triangle, own.panel.is_double_sided),
            ..own
        }
    }

    /// The light of the mesh that a triangle of the scene is, if any.
    pub(super) fn of_triangle(&self, triangle: u32) -> Option<usize> {
        let own = triangle.checked_sub(self.first_triangle)?;
        let light = *self.mesh.of_triangle.get(own as usize)?;
        (light != u32::MAX).then_some(light as usize)
    }

    /// Number of the first triangle of the mesh in the scene.
    pub(super) fn first_triangle(&self) -> u32 {
        self.first_triangle
    }
}

/// How much angles, in radians, may change without counting.
const SAME_ANGLE: f32 = 1e-3;
