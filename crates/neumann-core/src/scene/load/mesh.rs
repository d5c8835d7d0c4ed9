//! Primitives into triangle meshes.
//!
//! Each primitive becomes one mesh with the vertices that its indices name;
//! primitives that share one large vertex array thus do not copy all of it.
//! Points and lines are counted and left out. Morph targets are added with
//! their default weights, skins applied in the pose of the file.

use glam::{Vec2, Vec3, Vec4};
use rayon::iter::{
    IndexedParallelIterator, IntoParallelIterator, IntoParallelRefIterator, ParallelIterator,
};

use super::File;
use super::accessor::Accessor;
use super::draco::Attributes;
use super::error::{Fault, quoted};
use super::json::Item;
use super::morph;
use super::notes::Notes;
use super::skin::Skin;
use super::topology::Topology;
use crate::scene::description::MeshDescription;

/// `TEXCOORD_0` to `TEXCOORD_7` are read.
pub(super) const MOST_UV_SETS: usize = 8;

/// Fewer elements than this are not worth another thread.
const SMALLEST_TASK: usize = 1 << 14;

/// What a node does to the mesh it shows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Deformation<'a> {
    /// Weights of the morph targets, in place of the mesh's own.
    pub(super) weights: Option<&'a [f32]>,
    /// Joints.
    pub(super) skin: Option<&'a Skin>,
}

/// A mesh, and whether its positions are already those of the world.
#[derive(Debug)]
pub(super) struct ReadMesh {
    pub(super) mesh: MeshDescription,
    pub(super) is_in_world: bool,
}

/// Reads the primitives of a glTF mesh that have triangles.
pub(super) fn read(
    file: &File<'_>,
    index: usize,
    deformation: Deformation<'_>,
    notes: &mut Notes,
) -> Result<Vec<ReadMesh>, Fault> {
    let item = file.document.item("meshes", index)?;
    let own_name = item
        .name()
        .map_or_else(|| format!("mesh {index}"), str::to_owned);
    let own_weights = morph::weights(&item)?;
    let deformation = Deformation {
        weights: deformation.weights.or(own_weights.as_deref()),
        ..deformation
    };
    let n_primitives = item.list("primitives")?.len();
    let mut meshes = Vec::new();
    for k in 0..n_primitives {
        let Some(primitive) = item.list_item("primitives", k)? else {
            break;
        };
        let name = if n_primitives == 1 {
            own_name.clone()
        } else {
            format!("{own_name} #{k}")
        };
        file.allowance.spend(name.len(), 1, primitive.at())?;
        if let Some(mesh) = read_primitive(file, &primitive, name, deformation, notes)? {
            meshes.push(mesh);
        }
    }
    Ok(meshes)
}

fn read_primitive(
    file: &File<'_>,
    primitive: &Item<'_>,
    name: String,
    deformation: Deformation<'_>,
    notes: &mut Notes,
) -> Result<Option<ReadMesh>, Fault> {
    let mode = primitive.index("mode")?.unwrap_or(4);
    let Some(topology) = Topology::from_mode(mode) else {
        return Err(Fault::broken(
            primitive.path("mode"),
            format!("is {mode}; modes are 0 to 6"),
        ));
    };
    let attributes = Attributes::read(file, primitive)?;
    let positions = match &attributes {
        Some(attributes) => attributes.open(file, "POSITION", &["VEC3"])?,
        None => None,
    };
    let (Some(attributes), Some(positions)) = (&attributes, positions) else {
        notes.warn(format!(
            "mesh {}: {} has no positions and is left out",
            quoted(&name),
            primitive.at()
        ));
        return Ok(None);
    };

    let unpacked = attributes.triangles();
    // A Draco stream has triangles, whatever its strip was.
    let topology = unpacked.map_or(topology, |_| Topology::Triangles);
    let indices = match Accessor::open(file, primitive, "indices", &["SCALAR"])? {
        Some(indices) if unpacked.is_none() => Some(indices.unsigned()?),
        _ => None,
    };
    let n_indices = match (unpacked, &indices) {
        (Some(triangles), _) => 3 * triangles.len(),
        (None, Some(indices)) => indices.count(),
        (None, None) => positions.count(),
    };
    notes.n_points_skipped += topology.n_points(n_indices);
    notes.n_lines_skipped += topology.n_lines(n_indices);
    let n_triangles = topology.n_triangles(n_indices);
    if topology == Topology::Triangles && n_indices % 3 != 0 {
        notes.warn(format!(
            "mesh {}: {n_indices} indices are not a multiple of three; the last ones are left out",
            quoted(&name)
        ));
    }
    if n_triangles == 0 {
        return Ok(None);
    }

    file.allowance
        .spend(n_triangles, size_of::<[u32; 3]>(), primitive.at())?;
    let triangles = match unpacked {
        Some(triangles) => triangles.to_vec(),
        None => read_triangles(topology, n_triangles, indices.as_ref(), positions.count())?,
    };
    let (vertices, triangles) = select_vertices(file, triangles, positions.count(), primitive)?;

    let reader = Vertices {
        file,
        attributes,
        vertices: &vertices,
        n_vertices: positions.count(),
    };
    let mut mesh = MeshDescription {
        name,
        triangles,
        material: file
            .document
            .reference(primitive, "material", "materials")?,
        positions: reader.read(&positions, Vec3::from_array)?,
        normals: reader.optional("NORMAL", true, Vec3::from_array)?,
        uv_sets: read_uv_sets(&reader)?,
        colors: read_colors(&reader)?,
        tangents: None,
        object: None,
    };
    if mesh.normals.is_some() {
        mesh.tangents = reader.optional("TANGENT", true, Vec4::from_array)?;
    }
    if let Some(weights) = deformation.weights {
        morph::add_targets(file, primitive, weights, &vertices, &mut mesh, notes)?;
    }
    mend_numbers(&mut mesh, notes);
    mend_directions(&mut mesh, notes);
    let is_in_world = match deformation.skin {
        Some(skin) => skin.pose(file, attributes, &vertices, &mut mesh, notes)?,
        None => false,
    };
    Ok(Some(ReadMesh { mesh, is_in_world }))
}

/// Corners as vertex indices of the file, all below `n_vertices`.
fn read_triangles(
    topology: Topology,
    n_triangles: usize,
    indices: Option<&Accessor<'_>>,
    n_vertices: usize,
) -> Result<Vec<[u32; 3]>, Fault> {
    let triangle = |i: usize| {
        topology.corners(i).map(|corner| match indices {
            None => corner as u32,
            Some(indices) => indices.integers::<1>(corner)[0],
        })
    };
    let triangles: Vec<[u32; 3]> = (0..n_triangles)
        .into_par_iter()
        .with_min_len(SMALLEST_TASK)
        .map(triangle)
        .collect();
    let is_within = |&index: &u32| (index as usize) < n_vertices;
    if let Some(i) = triangles.iter().position(|t| !t.iter().all(is_within)) {
        let mut corners = topology.corners(i).into_iter().zip(triangles[i]);
        let (corner, index) = corners
            .find(|(_, index)| !is_within(index))
            .unwrap_or_default();
        return Err(Fault::broken(
            indices.map_or("indices", Accessor::at),
            format!("index {corner} is {index}, but there are {n_vertices} vertices"),
        ));
    }
    Ok(triangles)
}

/// The vertices to read, and the triangles with their corners among them.
fn select_vertices(
    file: &File<'_>,
    mut triangles: Vec<[u32; 3]>,
    n_vertices: usize,
    primitive: &Item<'_>,
) -> Result<(Vec<u32>, Vec<[u32; 3]>), Fault> {
    let n_corners = 3 * triangles.len();
    if n_vertices <= n_corners {
        file.allowance
            .spend(n_vertices, size_of::<u32>(), primitive.at())?;
        let all = u32::try_from(n_vertices)
            .map_err(|_| Fault::broken(primitive.at(), "has more than 2^32 vertices"))?;
        return Ok(((0..all).collect(), triangles));
    }
    file.allowance
        .spend(n_corners, size_of::<u32>(), primitive.at())?;
    let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    for corner in triangles.iter_mut().flatten() {
        // Found: every corner is among the vertices, which are sorted.
        *corner = vertices.partition_point(|&vertex| vertex < *corner) as u32;
    }
    Ok((vertices, triangles))
}

/// Reads attributes at the selected vertices.
struct Vertices<'a> {
    file: &'a File<'a>,
    attributes: &'a Attributes<'a>,
    vertices: &'a [u32],
    n_vertices: usize,
}

impl Vertices<'_> {
    fn read<const N: usize, T: Send>(
        &self,
        accessor: &Accessor<'_>,
        convert: impl Fn([f32; N]) -> T + Sync,
    ) -> Result<Vec<T>, Fault> {
        if accessor.count() < self.n_vertices {
            return Err(Fault::broken(
                format!("{}.count", accessor.at()),
                format!(
                    "is {}, but there are {} positions ({})",
                    accessor.count(),
                    self.n_vertices,
                    self.attributes.at()
                ),
            ));
        }
        self.file
            .allowance
            .spend(self.vertices.len(), size_of::<T>(), accessor.at())?;
        let read = |&vertex: &u32| convert(accessor.floats(vertex as usize));
        let vertices = self.vertices.par_iter().with_min_len(SMALLEST_TASK);
        Ok(vertices.map(read).collect())
    }

    /// An attribute of `N` components; `is_unit` normalises integers unsaid.
    fn optional<const N: usize, T: Send>(
        &self,
        key: &str,
        is_unit: bool,
        convert: impl Fn([f32; N]) -> T + Sync,
    ) -> Result<Option<Vec<T>>, Fault> {
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N.clamp(1, 4) - 1];
        match self.attributes.open(self.file, key, &[kind])? {
            None => Ok(None),
            Some(accessor) => {
                let accessor = if is_unit {
                    accessor.normalized()
                } else {
                    accessor
                };
                self.read(&accessor, convert).map(Some)
            }
        }
    }
}

/// All sets up to the last one present; gaps are filled with zeros.
fn read_uv_sets(reader: &Vertices<'_>) -> Result<Vec<Vec<Vec2>>, Fault> {
    let mut sets = Vec::new();
    for set in 0..MOST_UV_SETS {
        let key = format!("TEXCOORD_{set}");
        if let Some(uvs) = reader.optional(&key, false, Vec2::from_array)? {
            pad_uv_sets(reader.file, &mut sets, set, reader.vertices.len())?;
            sets.push(uvs);
        }
    }
    Ok(sets)
}

/// Adds sets of zeros until there are `n_sets`.
pub(super) fn pad_uv_sets(
    file: &File<'_>,
    sets: &mut Vec<Vec<Vec2>>,
    n_sets: usize,
    n_vertices: usize,
) -> Result<(), Fault> {
    while sets.len() < n_sets {
        file.allowance
            .spend(n_vertices, size_of::<Vec2>(), "meshes")?;
        sets.push(vec![Vec2::ZERO; n_vertices]);
    }
    Ok(())
}

fn read_colors(reader: &Vertices<'_>) -> Result<Option<Vec<Vec4>>, Fault> {
    let kinds = ["VEC3", "VEC4"];
    let Some(accessor) = reader.attributes.open(reader.file, "COLOR_0", &kinds)? else {
        return Ok(None);
    };
    let is_opaque = accessor.n_components() == 3;
    let convert = |[r, g, b, a]: [f32; 4]| Vec4::new(r, g, b, if is_opaque { 1.0 } else { a });
    reader.read(&accessor.normalized(), convert).map(Some)
}

/// Puts plain numbers in the place of those that are not finite, lest they reach the picture.
///
/// Positions stay: building leaves their triangles out and says so.
fn mend_numbers(mesh: &mut MeshDescription, notes: &mut Notes) {
    let name = quoted(&mesh.name);
    for (set, uvs) in mesh.uv_sets.iter_mut().enumerate() {
        let n = replace(uvs, Vec2::is_finite, Vec2::ZERO);
        if n > 0 {
            notes.warn(format!(
                "mesh {name}: {n} of {} TEXCOORD_{set} are not finite; (0, 0) stands in",
                uvs.len()
            ));
        }
    }
    if let Some(colors) = &mut mesh.colors {
        let n = replace(colors, Vec4::is_finite, Vec4::ONE);
        if n > 0 {
            notes.warn(format!(
                "mesh {name}: {n} of {} vertex colours are not finite; white stands in",
                colors.len()
            ));
        }
    }
}

/// Replaces what is not sound; tells how many there were.
fn replace<T: Copy>(values: &mut [T], is_sound: impl Fn(T) -> bool, stand_in: T) -> usize {
    let mut n = 0;
    for value in values.iter_mut().filter(|value| !is_sound(**value)) {
        *value = stand_in;
        n += 1;
    }
    n
}

/// Makes normals and tangents unit vectors.
///
/// A normal that is none is replaced by that of the triangles around it.
fn mend_directions(mesh: &mut MeshDescription, notes: &mut Notes) {
    let is_direction = |v: Vec3| v.is_finite() && v.length_squared() > 1e-24;
    if let Some(normals) = &mut mesh.normals {
        let n_broken = normals.iter().filter(|n| !is_direction(**n)).count();
        if n_broken > 0 {
            notes.warn(format!(
                "mesh {}: {n_broken} of {} normals are zero or not finite; those of the triangles \
                 stand in",
                quoted(&mesh.name),
                normals.len()
            ));
            let mut sums = vec![Vec3::ZERO; normals.len()];
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
                let twice_area = (b - a).cross(c - a);
                for vertex in triangle {
                    sums[*vertex as usize] += twice_area;
                }
            }
            for (normal, sum) in normals.iter_mut().zip(sums) {
                if !is_direction(*normal) {
                    *normal = sum.normalize_or(Vec3::Z);
                }
            }
        }
        for normal in normals {
            *normal = normal.normalize_or(Vec3::Z);
        }
    }
    let mut n_broken = 0;
    for tangent in mesh.tangents.iter_mut().flatten() {
        let direction = Some(tangent.truncate()).filter(|t| is_direction(*t));
        n_broken += usize::from(direction.is_none());
        let unit = direction.map_or(Vec3::X, |t| t.normalize_or(Vec3::X));
        *tangent = unit.extend(if tangent.w < 0.0 { -1.0 } else { 1.0 });
    }
    if n_broken > 0 {
        notes.warn(format!(
            "mesh {}: {n_broken} tangents are zero or not finite; the x axis stands in",
            quoted(&mesh.name)
        ));
    }
}
