//! All triangles of a scene in world space, and what their corners carry.

use glam::{Vec2, Vec3, Vec4};

use crate::accel::Bvh;

/// All triangles of a scene.
#[derive(Debug)]
pub struct Geometry {
    pub(super) meshes: Vec<PlacedMesh>,
    /// `facets[triangle]`.
    pub(super) facets: Vec<Facet>,
    pub(super) bvh: Bvh,
    pub(super) min: Vec3,
    pub(super) max: Vec3,
}

/// What every hit of a triangle needs of it, in one line of cache.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Facet {
    /// First corner, world space, metres.
    pub corner: Vec3,
    /// From the first corner to the second and the third.
    pub edges: [Vec3; 2],
    /// Normal, unit, towards the front side.
    pub ng: Vec3,
    /// Bound of the rounding error of points on it, metres.
    pub error: f32,
    /// Index of its mesh.
    pub mesh: u32,
}

impl Facet {
    /// A facet of mesh number `mesh` with an area that is not zero.
    #[must_use]
    pub fn new(corners: &[Vec3; 3], mesh: u32) -> Self {
        let edges = [corners[1] - corners[0], corners[2] - corners[0]];
        Self {
            corner: corners[0],
            edges,
            ng: edges[0].cross(edges[1]).normalize(),
            error: position_error(corners),
            mesh,
        }
    }

    /// The point with the given barycentric coordinates of the second and third corner.
    #[inline]
    #[must_use]
    pub fn at(&self, b: [f32; 2]) -> Vec3 {
        self.corner + self.edges[0] * b[0] + self.edges[1] * b[1]
    }
}

/// A mesh in world space.
#[derive(Clone, Debug)]
pub struct PlacedMesh {
    /// Name of the node that placed it.
    pub name: String,
    /// Index of its first triangle in the scene.
    pub first_triangle: u32,
    /// Index of its material.
    pub material: u32,
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

impl Geometry {
    /// The tree over all triangles.
    #[inline]
    #[must_use]
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Number of triangles.
    #[must_use]
    pub fn n_triangles(&self) -> usize {
        self.facets.len()
    }

    /// The meshes.
    #[must_use]
    pub fn meshes(&self) -> &[PlacedMesh] {
        &self.meshes
    }

    /// Shape and place of a triangle.
    #[inline]
    #[must_use]
    pub fn facet(&self, triangle: u32) -> &Facet {
        &self.facets[triangle as usize]
    }

    /// The mesh of a triangle, and the triangle's corners as vertices of it.
    #[inline]
    #[must_use]
    pub fn triangle(&self, triangle: u32) -> (&PlacedMesh, [usize; 3]) {
        let mesh = &self.meshes[self.facets[triangle as usize].mesh as usize];
        let corners = mesh.triangles[(triangle - mesh.first_triangle) as usize];
        (mesh, corners.map(|v| v as usize))
    }
}

impl PlacedMesh {
    /// Positions of three vertices.
    #[inline]
    #[must_use]
    pub fn corners(&self, vertices: [usize; 3]) -> [Vec3; 3] {
        vertices.map(|v| self.positions[v])
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

/// Bound of the rounding error of a point on a triangle, metres: what interpolation of its
/// corners and the ray-triangle test lose, with room to spare. It grows with the distance from
/// the origin, as the spacing of floating-point numbers does.
#[inline]
#[must_use]
pub fn position_error(corners: &[Vec3; 3]) -> f32 {
    let magnitude = corners[0]
        .abs()
        .max(corners[1].abs())
        .max(corners[2].abs())
        .max_element();
    32.0 * f32::EPSILON * magnitude
}
