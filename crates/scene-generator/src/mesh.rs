//! Triangle meshes, and the shapes that the scenes are made of.
//!
//! Everything is computed in `f64` and rounded to `f32` once, when the file is
//! written: so the last bit of a platform's sine does not reach the file.
//! Triangles are counter-clockwise seen from the front; the front of a closed
//! shape is its outside. A mesh without normals is shaded flat, as glTF asks.

use glam::{DVec2, DVec3, dvec3};

use crate::revolve::smooth_profile;

/// An indexed triangle mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    /// Metres.
    pub(crate) positions: Vec<DVec3>,
    /// One unit vector per position, or none at all for flat shading.
    pub(crate) normals: Vec<DVec3>,
    /// Three per triangle.
    pub(crate) indices: Vec<u32>,
}

impl Mesh {
    /// Four corners, counter-clockwise seen from the front.
    pub(crate) fn quad(corners: [DVec3; 4]) -> Self {
        Self {
            positions: corners.to_vec(),
            normals: Vec::new(),
            indices: vec![0, 1, 2, 0, 2, 3],
        }
    }

    /// A square of side 1 around the origin, facing down (-Y).
    pub(crate) fn square_facing_down() -> Self {
        Self::quad([
            dvec3(-0.5, 0.0, -0.5),
            dvec3(0.5, 0.0, -0.5),
            dvec3(0.5, 0.0, 0.5),
            dvec3(-0.5, 0.0, 0.5),
        ])
    }

    /// An axis-aligned box between two opposite corners.
    pub(crate) fn cuboid(min: DVec3, max: DVec3) -> Self {
        let positions = (0..8)
            .map(|i| {
                dvec3(
                    if i & 1 == 0 { min.x } else { max.x },
                    if i & 2 == 0 { min.y } else { max.y },
                    if i & 4 == 0 { min.z } else { max.z },
                )
            })
            .collect();
        let faces = [
            [0, 4, 6, 2], // -X
            [1, 3, 7, 5], // +X
            [0, 1, 5, 4], // -Y
            [2, 6, 7, 3], // +Y
            [0, 2, 3, 1], // -Z
            [4, 5, 7, 6], // +Z
        ];
        let indices = faces
            .iter()
            .flat_map(|f| [f[0], f[1], f[2], f[0], f[2], f[3]])
            .collect();
        Self {
            positions,
            normals: Vec::new(),
            indices,
        }
    }

    /// Draws a smooth profile of (z, y) out along X from `-half_width` to
    /// `half_width`. The front is on the left of the profile as it is walked
    /// towards -Z: above, for a floor.
    pub(crate) fn extrusion(profile: &[(f64, f64)], half_width: f64) -> Self {
        let mut mesh = Self::default();
        for (row, p) in smooth_profile(profile).iter().enumerate() {
            for x in [-half_width, half_width] {
                mesh.positions.push(dvec3(x, p.point.y, p.point.x));
                mesh.normals.push(dvec3(0.0, p.normal.y, p.normal.x));
            }
            if row > 0 {
                let b = u32::try_from(2 * row).unwrap_or(u32::MAX);
                let a = b - 2;
                mesh.indices.extend([a, a + 1, b + 1, a, b + 1, b]);
            }
        }
        mesh
    }

    /// A sheet over `[-1, 1]²` times `half_size` with `cells` x `cells` quads,
    /// facing up; `surface` gives height and unit normal at (x, z).
    pub(crate) fn sheet(
        half_size: DVec2,
        cells: u32,
        surface: impl Fn(f64, f64) -> (f64, DVec3),
    ) -> Self {
        let mut mesh = Self::default();
        let coordinate = |i: u32| 2.0 * f64::from(i) / f64::from(cells) - 1.0;
        for row in 0..=cells {
            for column in 0..=cells {
                let (x, z) = (
                    half_size.x * coordinate(column),
                    half_size.y * coordinate(row),
                );
                let (height, normal) = surface(x, z);
                mesh.positions.push(dvec3(x, height, z));
                mesh.normals.push(normal);
            }
        }
        let stride = cells + 1;
        for row in 0..cells {
            for column in 0..cells {
                let a = row * stride + column;
                let (b, c, d) = (a + stride, a + stride + 1, a + 1);
                mesh.indices.extend([a, b, c, a, c, d]);
            }
        }
        mesh
    }

    /// A unit icosphere without normals: 20 · 4^`subdivisions` facets.
    pub(crate) fn icosphere(subdivisions: u32) -> Self {
        let mut mesh = icosahedron();
        for _ in 0..subdivisions {
            mesh = subdivided(&mesh);
        }
        mesh
    }

    /// The same surface with front and back exchanged.
    pub(crate) fn inside_out(mut self) -> Self {
        for triangle in self.indices.chunks_exact_mut(3) {
            triangle.swap(1, 2);
        }
        for normal in &mut self.normals {
            *normal = -*normal;
        }
        self
    }

    /// The same mesh, moved.
    pub(crate) fn moved(mut self, by: DVec3) -> Self {
        for position in &mut self.positions {
            *position += by;
        }
        self
    }

    /// Several meshes as one.
    pub(crate) fn union(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut mesh = Self::default();
        for part in parts {
            mesh.append(&part);
        }
        mesh
    }

    /// Adds the triangles of another mesh.
    pub(crate) fn append(&mut self, other: &Self) {
        let mixed =
            !self.positions.is_empty() && self.normals.is_empty() != other.normals.is_empty();
        assert!(!mixed, "flat and smooth meshes do not mix");
        let offset = u32::try_from(self.positions.len()).unwrap_or(u32::MAX);
        self.positions.extend(&other.positions);
        self.normals.extend(&other.normals);
        self.indices
            .extend(other.indices.iter().map(|i| i + offset));
    }
}

fn icosahedron() -> Mesh {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut positions = Vec::new();
    for a in [-1.0, 1.0] {
        for b in [-golden, golden] {
            positions.extend([dvec3(0.0, a, b), dvec3(a, b, 0.0), dvec3(b, 0.0, a)]);
        }
    }
    // The faces are the triples of vertices at edge length (2) from each other.
    let adjacent = |i: usize, j: usize| (positions[i].distance(positions[j]) - 2.0).abs() < 1e-9;
    let mut indices = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if adjacent(i, j) && adjacent(j, k) && adjacent(i, k) {
                    let [a, b, c]: [DVec3; 3] = [positions[i], positions[j], positions[k]];
                    let outward = (b - a).cross(c - a).dot(a) > 0.0;
                    let face = if outward { [i, j, k] } else { [i, k, j] };
                    indices.extend(face.map(|index| u32::try_from(index).unwrap_or(u32::MAX)));
                }
            }
        }
    }
    Mesh {
        positions: positions.into_iter().map(DVec3::normalize).collect(),
        normals: Vec::new(),
        indices,
    }
}

/// Each facet of a unit sphere becomes four.
fn subdivided(mesh: &Mesh) -> Mesh {
    let mut result = Mesh {
        positions: mesh.positions.clone(),
        ..Mesh::default()
    };
    let mut midpoints = std::collections::BTreeMap::new();
    let mut midpoint = |a: u32, b: u32| {
        *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
            let sum = mesh.positions[a as usize] + mesh.positions[b as usize];
            result.positions.push(sum.normalize());
            u32::try_from(result.positions.len() - 1).unwrap_or(u32::MAX)
        })
    };
    for triangle in mesh.indices.chunks_exact(3) {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
        let (ab, bc, ca) = (midpoint(a, b), midpoint(b, c), midpoint(c, a));
        result
            .indices
            .extend([a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca]);
    }
    result
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::dvec2;

    use super::*;
    use crate::revolve::Sweep;

    /// Volume by the divergence theorem: positive when the outside is the front.
    fn volume(mesh: &Mesh) -> f64 {
        mesh.indices
            .chunks_exact(3)
            .map(|t| {
                let [a, b, c] = [0, 1, 2].map(|i| mesh.positions[t[i] as usize]);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    #[test]
    fn closed_shapes_face_outwards() {
        let ball = 4.0 / 3.0 * PI;
        assert!((volume(&Mesh::sphere(64)) / ball - 1.0).abs() < 2e-3);
        assert!((volume(&Mesh::icosphere(3)) / ball - 1.0).abs() < 2e-2);
        assert!((volume(&Mesh::cuboid(DVec3::ZERO, dvec3(1.0, 2.0, 3.0))) - 6.0).abs() < 1e-12);
        let torus = 2.0 * PI * PI * 0.5 * 0.01;
        let mesh = Mesh::torus(0.5, 0.1, 32, Sweep::full(64));
        assert!((volume(&mesh) / torus - 1.0).abs() < 1e-2);
        assert!(volume(&Mesh::icosphere(1).inside_out()) < 0.0);
    }

    #[test]
    fn normals_agree_with_the_winding() {
        let flat = |_: f64, _: f64| (0.0, DVec3::Y);
        for mesh in [
            Mesh::sphere(16),
            Mesh::torus(0.5, 0.1, 16, Sweep::full(32)),
            Mesh::lathe(&[(0.2, 0.0), (0.3, 1.0), (0.0, 1.0)], Sweep::full(32)),
            Mesh::lathe(&[(0.2, 0.0), (0.0, 1.0)], Sweep::full(32)),
            Mesh::lathe(&[(0.0, 0.0), (0.2, 1.0)], Sweep::arc(0.0, 2.0, 8)),
            Mesh::extrusion(&[(1.0, 0.0), (0.0, 0.0), (-1.0, 1.0)], 1.0),
            Mesh::sheet(dvec2(1.0, 1.0), 4, flat),
        ] {
            for t in mesh.indices.chunks_exact(3) {
                let [a, b, c] = [0, 1, 2].map(|i| mesh.positions[t[i] as usize]);
                let ng = (b - a).cross(c - a);
                for corner in t {
                    assert!(ng.dot(mesh.normals[*corner as usize]) > 0.0);
                }
            }
        }
    }
}
