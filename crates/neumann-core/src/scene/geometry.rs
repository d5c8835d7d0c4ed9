//! All triangles of a scene in world space, and what their corners carry.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Affine3A, Mat3, Mat4, Vec2, Vec3, Vec4};

use crate::accel::{Bvh, Hit, Placement, TreeQuality};
use crate::math::lanes::select;
use crate::math::prefetch;
use crate::math::triangle::point_between;

/// All triangles of a scene.
#[derive(Debug)]
pub struct Geometry {
    /// Those that stand in the world by themselves, then instances, both in the order of their
    /// triangles.
    pub(super) meshes: Vec<PlacedMesh>,
    /// `facets[triangle]` of the meshes that stand in the world by themselves.
    pub(super) facets: Vec<Facet>,
    /// Index of the first mesh that is an instance.
    pub(super) first_instance: usize,
    pub(super) n_triangles: usize,
    pub(super) min: Vec3,
    pub(super) max: Vec3,
    /// Corners of the box around what the scene is about.
    pub(super) subject: (Vec3, Vec3),
}

/// What every hit of a triangle needs of it, in one line of cache.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Facet {
    /// World space, metres.
    pub corners: [Vec3; 3],
    /// Normal, unit, towards the front side.
    pub ng: Vec3,
    /// Index of its mesh.
    pub mesh: u32,
    vertices: [u32; 3],
}

impl Facet {
    /// A facet of mesh number `mesh` between three of its vertices, at corners that span an area.
    #[must_use]
    pub fn new(corners: &[Vec3; 3], mesh: u32, vertices: [u32; 3]) -> Self {
        let [to_second, to_third] = [corners[1] - corners[0], corners[2] - corners[0]];
        Self {
            corners: *corners,
            ng: to_second.cross(to_third).normalize_or(Vec3::Y),
            mesh,
            vertices,
        }
    }

    /// A facet of which only place and shape matter.
    #[inline(always)]
    pub(crate) fn new_at(corners: [Vec3; 3], ng: Vec3) -> Self {
        Self {
            corners,
            ng,
            mesh: 0,
            vertices: [0; 3],
        }
    }

    /// Its corners, as vertices of the mesh.
    #[inline]
    #[must_use]
    pub fn vertices(&self) -> [usize; 3] {
        self.vertices.map(|v| v as usize)
    }

    /// From the first corner to the second and the third.
    #[inline]
    #[must_use]
    pub fn edges(&self) -> [Vec3; 2] {
        let [a, b, c] = self.corners;
        [b - a, c - a]
    }

    /// The point with the given barycentric coordinates of the second and third corner.
    #[inline]
    #[must_use]
    pub fn at(&self, b: [f32; 2]) -> Vec3 {
        point_between(&self.corners, b)
    }

    /// Where a ray meets it, as exactly as single precision can say, however large the facet is.
    /// Barycentric
    /// coordinates decide where the ray runs along the facet, as far as can be told.
    #[inline(always)]
    pub(crate) fn met_by(&self, origin: Vec3, direction: Vec3, hit: &Hit) -> MetAt {
        let t = self.distance_along(origin, direction);
        if MetAt::is_known(t) {
            MetAt::new(origin, direction, t)
        } else {
            self.met_somewhere(hit)
        }
    }

    /// How far its plane is along a ray, in lengths of its direction.
    #[inline(always)]
    pub(crate) fn distance_along(&self, origin: Vec3, direction: Vec3) -> f64 {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a);
        normal.dot(a - origin.as_dvec3()) / normal.dot(direction.as_dvec3())
    }

    /// Where a ray meets it of which [`Self::distance_along`] is not known.
    #[cold]
    pub(crate) fn met_somewhere(&self, hit: &Hit) -> MetAt {
        MetAt {
            position: self.at(hit.barycentrics),
            distance: hit.t.max(LEAST_DISTANCE),
        }
    }
}

/// Where a ray meets a facet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MetAt {
    /// World space, metres.
    pub(crate) position: Vec3,
    /// In lengths of the ray's direction.
    pub(crate) distance: f32,
}

impl MetAt {
    /// The point of a ray at a distance that is known.
    #[inline(always)]
    pub(crate) fn new(origin: Vec3, direction: Vec3, t: f64) -> Self {
        let distance = t as f32;
        Self {
            position: (origin.as_dvec3() + direction.as_dvec3() * t).as_vec3(),
            distance: select(distance > LEAST_DISTANCE, distance, LEAST_DISTANCE),
        }
    }

    /// False where a ray runs along a facet.
    #[inline(always)]
    pub(crate) fn is_known(t: f64) -> bool {
        t.abs() < f64::MAX
    }
}

/// Distance between surfaces that touch, metres: its square is still a number.
const LEAST_DISTANCE: f32 = 1e-15;

/// A mesh that stands in the world.
#[derive(Clone, Debug)]
pub struct PlacedMesh {
    /// Name of the node that placed it.
    pub name: String,
    /// Index of its first triangle in the scene.
    pub first_triangle: u32,
    /// Index of its material.
    pub material: u32,
    /// Number of the object that it is part of: what a node has placed there.
    pub(super) object: u32,
    /// What its vertices carry: in world space, or, for an instance, in the mesh's own space.
    pub arrays: Arc<MeshArrays>,
    /// Where an instance stands; `None` for a mesh in world space.
    pub(super) placement: Option<Box<MeshPlacement>>,
}

/// What the vertices of a mesh carry.
#[derive(Clone, Debug, Default)]
pub struct MeshArrays {
    /// Corners of each triangle; counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// `positions[vertex]`, metres.
    pub positions: Vec<Vec3>,
    /// `normals[vertex]`, unit.
    pub normals: Option<Vec<Vec3>>,
    /// `tangents[vertex]`: xyz unit, w the sign of the bitangent.
    pub tangents: Option<Vec<Vec4>>,
    /// `uv_sets[set][vertex]`.
    pub uv_sets: Vec<Vec<Vec2>>,
    /// `colors[vertex]`, linear RGBA.
    pub colors: Option<Vec<Vec4>>,
}

/// How what an instance's vertices carry is taken to world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshPlacement {
    pub(super) world_from_mesh: Affine3A,
    /// Takes normals along, lengths aside.
    pub(super) normal_matrix: Mat3,
    pub(super) is_mirrored: bool,
}

impl MeshPlacement {
    /// The placement by an affine transform.
    pub(super) fn new(world_from_mesh: Mat4) -> Self {
        let linear = Mat3::from_mat4(world_from_mesh);
        let is_mirrored = linear.determinant() < 0.0;
        Self {
            world_from_mesh: Affine3A::from_mat4(world_from_mesh),
            normal_matrix: Mat3::from_cols(
                linear.y_axis.cross(linear.z_axis),
                linear.z_axis.cross(linear.x_axis),
                linear.x_axis.cross(linear.y_axis),
            ) * if is_mirrored { -1.0 } else { 1.0 },
            is_mirrored,
        }
    }

    /// A tangent in world space, the sign of its bitangent kept up.
    pub(super) fn tangent(&self, tangent: Vec4) -> Vec4 {
        let along = self.world_from_mesh.transform_vector3(tangent.truncate());
        along.extend(if self.is_mirrored {
            -tangent.w
        } else {
            tangent.w
        })
    }
}

impl Geometry {
    /// A new tree over all triangles.
    #[must_use]
    pub(super) fn tree(&self, quality: TreeQuality) -> Bvh {
        tree(&self.meshes, self.first_instance, quality)
    }

    /// Number of triangles.
    #[must_use]
    pub fn n_triangles(&self) -> usize {
        self.n_triangles
    }

    /// The meshes.
    #[must_use]
    pub fn meshes(&self) -> &[PlacedMesh] {
        &self.meshes
    }

    /// Asks for the facet of a triangle, which is far away in memory where there are many.
    #[inline(always)]
    pub(crate) fn approach(&self, triangle: u32) {
        if let Some(facet) = self.facets.get(triangle as usize) {
            prefetch(facet);
        }
    }

    /// Shape and place of a triangle.
    #[inline]
    #[must_use]
    pub fn facet(&self, triangle: u32) -> Facet {
        match self.facets.get(triangle as usize) {
            Some(facet) => *facet,
            None => self.facet_of_instance(triangle),
        }
    }

    #[inline(never)]
    fn facet_of_instance(&self, triangle: u32) -> Facet {
        let instances = &self.meshes[self.first_instance..];
        let index = instances.partition_point(|m| m.first_triangle <= triangle) - 1;
        let mesh = &instances[index];
        let vertices = mesh.arrays.triangles[(triangle - mesh.first_triangle) as usize];
        let corners = mesh.corners(vertices.map(|v| v as usize));
        Facet::new(&corners, (self.first_instance + index) as u32, vertices)
    }
}

/// A tree over meshes that stand in the world by themselves and, from `first_instance` on,
/// instances of shared ones.
pub(super) fn tree(meshes: &[PlacedMesh], first_instance: usize, quality: TreeQuality) -> Bvh {
    let (single, instances) = meshes.split_at(first_instance);
    let mut triangles = Vec::with_capacity(single.iter().map(|m| m.arrays.triangles.len()).sum());
    triangles.extend(single.iter().flat_map(PlacedMesh::triangles));
    let mut numbers = HashMap::new();
    let mut shared: Vec<Vec<[Vec3; 3]>> = Vec::new();
    let mut placements = Vec::new();
    for instance in instances {
        let Some(placement) = &instance.placement else {
            continue;
        };
        let arrays = &instance.arrays;
        let mesh = *numbers.entry(Arc::as_ptr(arrays)).or_insert_with(|| {
            let corners = |t: &[u32; 3]| t.map(|v| arrays.positions[v as usize]);
            shared.push(arrays.triangles.iter().map(corners).collect());
            shared.len() - 1
        });
        placements.push(Placement {
            mesh,
            world_from_mesh: placement.world_from_mesh,
            first_triangle: instance.first_triangle,
        });
    }
    Bvh::with_instances(&triangles, &shared, &placements, quality)
}

impl PlacedMesh {
    /// Corners of each triangle, world space.
    pub(super) fn triangles(&self) -> impl Iterator<Item = [Vec3; 3]> {
        let triangles = self.arrays.triangles.iter();
        triangles.map(|t| self.corners(t.map(|v| v as usize)))
    }

    /// Its triangles as those of mesh number `number`.
    pub(super) fn facets(&self, number: u32) -> impl Iterator<Item = Facet> {
        let triangles = self.triangles().zip(&self.arrays.triangles);
        triangles.map(move |(corners, vertices)| Facet::new(&corners, number, *vertices))
    }

    /// Positions of three vertices, world space.
    #[inline]
    #[must_use]
    pub fn corners(&self, vertices: [usize; 3]) -> [Vec3; 3] {
        let corners = vertices.map(|v| self.arrays.positions[v]);
        match &self.placement {
            None => corners,
            Some(placement) => corners.map(|p| placement.world_from_mesh.transform_point3(p)),
        }
    }

    /// The normal interpolated between three vertices, world space, not unit; `None` without
    /// normals.
    #[inline]
    #[must_use]
    pub fn normal(&self, vertices: [usize; 3], b: [f32; 2]) -> Option<Vec3> {
        let normals = self.arrays.normals.as_ref()?;
        let n = interpolate(vertices.map(|v| normals[v]), b);
        Some(match &self.placement {
            None => n,
            Some(placement) => placement.normal_matrix * n,
        })
    }

    /// The tangent interpolated between three vertices, world space, not unit; `None` without
    /// tangents.
    #[must_use]
    pub fn tangent(&self, vertices: [usize; 3], b: [f32; 2]) -> Option<Vec4> {
        let tangents = self.arrays.tangents.as_ref()?;
        let tangent = interpolate(vertices.map(|v| tangents[v]), b);
        Some(match &self.placement {
            None => tangent,
            Some(placement) => placement.tangent(tangent),
        })
    }
}

/// Interpolates between three corners; `b` weighs the second and third.
#[inline]
pub(crate) fn interpolate<T>(values: [T; 3], b: [f32; 2]) -> T
where
    T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    let [v0, v1, v2] = values;
    v0 * (1.0 - b[0] - b[1]) + v1 * b[0] + v2 * b[1]
}
