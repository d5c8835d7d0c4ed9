//! Which walls bound one body: the closed parts of a scene, what does not close, and cavities.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Mat3, Vec3};

use super::{MAX_BODIES, MOST_COMPARISONS, MediumKey, NONE, Seeker, Wall};
use crate::accel::Bvh;
use crate::material::Material;
use crate::scene::geometry::{Geometry, MeshArrays, PlacedMesh};

/// Walls that may bound a body.
pub(super) struct Part {
    pub(super) key: MediumKey,
    /// Indices of its meshes.
    pub(super) meshes: Vec<usize>,
    pub(super) shape: Shape,
    pub(super) is_closed: bool,
}

/// Sums over the triangles of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    /// Where `volume` is seen from.
    pub(super) from: DVec3,
    /// Of cones from there to each triangle, m³: the volume within, if the surface is closed.
    pub(super) volume: f64,
    /// Normals times areas, m²: zero, if it is closed.
    pub(super) vector_area: DVec3,
    pub(super) area: f64,
    pub(super) min: Vec3,
    pub(super) max: Vec3,
}

/// The vector area of what is closed is less than this share of its area;
const OPENING: f64 = 1e-3;
/// and its volume is more than this share of the 1.5th power of its area.
const THINNEST: f64 = 1e-6;

impl Shape {
    fn of(arrays: &MeshArrays) -> Self {
        let position = |v: u32| arrays.positions[v as usize];
        let first = arrays.triangles.first().map_or(0, |t| t[0]);
        let from = position(first).as_dvec3();
        let mut shape = Self {
            from,
            volume: 0.0,
            vector_area: DVec3::ZERO,
            area: 0.0,
            min: Vec3::INFINITY,
            max: Vec3::NEG_INFINITY,
        };
        for triangle in &arrays.triangles {
            let corners = triangle.map(position);
            let [p, q, r] = corners.map(|corner| corner.as_dvec3() - from);
            let area = (q - p).cross(r - p) / 2.0;
            shape.volume += p.dot(area) / 3.0;
            shape.vector_area += area;
            shape.area += area.length();
            for corner in corners {
                shape.min = shape.min.min(corner);
                shape.max = shape.max.max(corner);
            }
        }
        shape
    }

    /// The same surface as a mesh stands in the world.
    fn placed(self, mesh: &PlacedMesh) -> Self {
        let Some(placement) = &mesh.placement else {
            return self;
        };
        let affine = placement.world_from_mesh;
        let linear = Mat3::from(affine.matrix3).as_dmat3();
        let determinant = linear.determinant();
        let corners = (0..8).map(|i| {
            let pick = |bit, low, high| if i & bit == 0 { low } else { high };
            affine.transform_point3(Vec3::new(
                pick(1, self.min.x, self.max.x),
                pick(2, self.min.y, self.max.y),
                pick(4, self.min.z, self.max.z),
            ))
        });
        let (min, max) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), p| {
            (min.min(p), max.max(p))
        });
        Self {
            from: affine.transform_point3(self.from.as_vec3()).as_dvec3(),
            volume: self.volume * determinant,
            vector_area: linear.inverse().transpose() * self.vector_area * determinant,
            area: self.area * determinant.abs().powf(2.0 / 3.0),
            min,
            max,
        }
    }

    fn with(self, other: &Self) -> Self {
        let moved = (other.from - self.from).dot(other.vector_area) / 3.0;
        Self {
            from: self.from,
            volume: self.volume + other.volume + moved,
            vector_area: self.vector_area + other.vector_area,
            area: self.area + other.area,
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    fn is_closed(&self) -> bool {
        self.vector_area.length() <= OPENING * self.area
            && self.volume.abs() >= THINNEST * self.area.powf(1.5)
    }
}

/// What may bound bodies: for each object, the walls of each medium.
pub(super) fn parts(geometry: &Geometry, materials: &[Material]) -> Vec<Part> {
    let mut shapes: HashMap<*const MeshArrays, Shape> = HashMap::new();
    let mut numbers: HashMap<(u32, MediumKey), usize> = HashMap::new();
    let mut parts: Vec<Part> = Vec::new();
    for (index, mesh) in geometry.meshes().iter().enumerate() {
        let Some(key) = medium_within(&materials[mesh.material as usize]) else {
            continue;
        };
        let shape = shapes
            .entry(Arc::as_ptr(&mesh.arrays))
            .or_insert_with(|| Shape::of(&mesh.arrays))
            .placed(mesh);
        let next = parts.len();
        let number = *numbers.entry((mesh.object, key)).or_insert(next);
        if number == next {
            parts.push(Part {
                key,
                meshes: vec![index],
                shape,
                is_closed: false,
            });
        } else {
            let part = &mut parts[number];
            part.shape = part.shape.with(&shape);
            part.meshes.push(index);
        }
    }
    for part in &mut parts {
        part.is_closed = part.shape.is_closed();
    }
    parts
}

/// What is behind a surface of a material: index of refraction and absorption, as bits.
fn medium_within(material: &Material) -> Option<MediumKey> {
    let parameters = material.parameters();
    let is_wall = parameters.transmission > 0.0 && !material.is_unlit();
    let absorption = material.absorption().filter(|_| is_wall)?;
    let [r, g, b] = absorption.to_array();
    // A zero has one sign.
    Some([parameters.ior.max(1.0), r, g, b].map(|value| (value + 0.0).to_bits()))
}

/// Joins what is not closed, by media; and all, where there is too much to number.
pub(super) fn join_open(parts: &mut Vec<Part>) {
    let is_too_much = parts.len() > MAX_BODIES;
    let (mut joined, open): (Vec<Part>, Vec<Part>) = parts
        .drain(..)
        .partition(|part| part.is_closed && !is_too_much);
    let mut numbers: HashMap<MediumKey, usize> = HashMap::new();
    for part in open {
        let next = joined.len();
        let number = *numbers.entry(part.key).or_insert(next);
        if number == next {
            joined.push(part);
        } else {
            let whole = &mut joined[number];
            whole.shape = whole.shape.with(&part.shape);
            whole.meshes.extend(part.meshes);
        }
    }
    for number in numbers.into_values() {
        joined[number].is_closed = joined[number].shape.is_closed();
    }
    joined.truncate(NONE as usize);
    *parts = joined;
}

/// Makes closed surfaces that are turned inside out, and within another body, a part of that.
pub(super) fn fill_cavities(
    geometry: &Geometry,
    bvh: &Bvh,
    parts: &mut [Part],
    walls: &mut [Option<Wall>],
) {
    let is_body = |part: &Part| part.is_closed && part.shape.volume > 0.0;
    let mut n_left = MOST_COMPARISONS * parts.len();
    for cavity in 0..parts.len() {
        let Part { shape, .. } = parts[cavity];
        if !parts[cavity].is_closed || shape.volume > 0.0 {
            continue;
        }
        n_left = n_left.saturating_sub(parts.len());
        if n_left == 0 {
            return;
        }
        let mesh = &geometry.meshes()[parts[cavity].meshes[0]];
        let Some(corners) = mesh.triangles().next() else {
            continue;
        };
        let point = (corners[0] + corners[1] + corners[2]) / 3.0;
        let is_around =
            |part: &Part| point.cmpge(part.shape.min).all() && point.cmple(part.shape.max).all();
        let candidates = parts.iter().enumerate();
        let near: Vec<u16> = candidates
            .filter(|(_, part)| is_body(part) && is_around(part))
            .map(|(number, _)| number as u16)
            .collect();
        if near.is_empty() {
            continue;
        }
        let seeker = Seeker {
            bvh,
            geometry,
            walls,
            near: &near,
            end: geometry.min.distance(geometry.max),
        };
        let around = seeker.around(point, Vec3::ZERO, None);
        let volume = |number: &u16| parts[*number as usize].shape.volume;
        let host = around
            .into_iter()
            .min_by(|a, b| volume(a).total_cmp(&volume(b)));
        let Some(host) = host else { continue };
        let meshes = std::mem::take(&mut parts[cavity].meshes);
        for mesh in &meshes {
            walls[*mesh] = Some(Wall {
                body: host,
                is_inside_out: false,
            });
        }
        let host = &mut parts[host as usize];
        host.shape.volume += shape.volume;
        host.meshes.extend(meshes);
    }
}
