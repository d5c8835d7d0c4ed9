//! Scenes made in code, with answers that are known.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{Mat4, Vec2, Vec3};
use neumann_core::radiometry::Rgb;
use neumann_core::scene::Scene;
use neumann_core::scene::builtin::BUILTINS;
use neumann_core::scene::description::{
    CameraDescription, InstanceDescription, LightDescription, LightKind, MaterialDescription,
    MeshDescription, Projection, SceneDescription,
};

/// A built-in scene.
///
/// # Panics
/// If there is none of that name, or it does not load.
#[must_use]
pub fn builtin(name: &str) -> Arc<Scene> {
    Arc::new(Scene::build(&builtin_description(name)))
}

/// The description of a built-in scene.
///
/// # Panics
/// If there is none of that name, or it does not load.
#[must_use]
pub fn builtin_description(name: &str) -> SceneDescription {
    let scene = BUILTINS.iter().find(|scene| scene.name == name);
    match scene.map(|scene| scene.load()) {
        Some(Ok(description)) => description,
        Some(Err(error)) => panic!("{name}: {error}"),
        None => panic!("no built-in scene '{name}'"),
    }
}

/// Everything in a scene `scale` times as large, seen from as much farther away; radiance stays.
#[must_use]
pub fn scaled(mut description: SceneDescription, scale: f32) -> SceneDescription {
    let by = Mat4::from_scale(Vec3::splat(scale));
    for instance in &mut description.instances {
        instance.world_from_mesh = by * instance.world_from_mesh;
    }
    for camera in &mut description.cameras {
        camera.world_from_camera.w_axis =
            (camera.world_from_camera.w_axis.truncate() * scale).extend(1.0);
    }
    description
}

/// Ideal diffuse reflection.
#[must_use]
pub fn lambert(albedo: f32) -> MaterialDescription {
    MaterialDescription {
        base_color: Rgb::splat(albedo),
        metallic: 0.0,
        specular: 0.0,
        ..MaterialDescription::default()
    }
}

/// Emits from its front, scatters nothing.
#[must_use]
pub fn emitter(radiance: f32) -> MaterialDescription {
    MaterialDescription {
        emission: Rgb::splat(radiance),
        ..lambert(0.0)
    }
}

/// A scene under construction.
#[derive(Clone, Debug, Default)]
pub struct Stage {
    /// What it has so far.
    pub description: SceneDescription,
}

impl Stage {
    /// Adds a mesh in world space.
    pub fn add(&mut self, name: &str, mesh: MeshDescription, material: MaterialDescription) {
        let d = &mut self.description;
        d.instances.push(InstanceDescription {
            name: name.to_owned(),
            mesh: d.meshes.len(),
            world_from_mesh: Mat4::IDENTITY,
        });
        d.meshes.push(MeshDescription {
            name: name.to_owned(),
            material: Some(d.materials.len()),
            ..mesh
        });
        d.materials.push(material);
    }

    /// Adds a light at a position, shining along a direction (if its kind has one).
    pub fn light(&mut self, kind: LightKind, position: Vec3, direction: Vec3) {
        let up = direction.any_orthonormal_vector();
        self.description.lights.push(LightDescription {
            name: "light".to_owned(),
            world_from_light: CameraDescription::looking_at(position, position + direction, up),
            kind,
        });
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> Arc<Scene> {
        Arc::new(Scene::build(&self.description))
    }
}

/// A rectangle around `center`, spanned by two half edges; its front is on the side of `x × y`.
#[must_use]
pub fn rectangle(center: Vec3, x: Vec3, y: Vec3) -> MeshDescription {
    MeshDescription {
        positions: vec![
            center - x - y,
            center + x - y,
            center + x + y,
            center - x + y,
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshDescription::default()
    }
}

/// The inside of the cube from -1 to 1, facing inwards.
#[must_use]
pub fn room() -> MeshDescription {
    let mut room = MeshDescription::default();
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for n in [axis, -axis] {
            let x = n.any_orthonormal_vector();
            let wall = rectangle(-n, x, n.cross(x));
            let first = room.positions.len() as u32;
            room.positions.extend(wall.positions);
            room.triangles
                .extend(wall.triangles.iter().map(|t| t.map(|i| i + first)));
        }
    }
    room
}

/// A ball of flat facets around the origin, facing outwards.
#[must_use]
pub fn ball(radius: f32) -> MeshDescription {
    let (n_rings, n_columns) = (12u32, 24u32);
    let mut mesh = MeshDescription::default();
    for ring in 0..=n_rings {
        let (sin, cos) = (PI * ring as f32 / n_rings as f32).sin_cos();
        for column in 0..n_columns {
            let (s, c) = (2.0 * PI * column as f32 / n_columns as f32).sin_cos();
            mesh.positions
                .push(Vec3::new(sin * s, cos, sin * c) * radius);
        }
    }
    for ring in 0..n_rings {
        for column in 0..n_columns {
            let at = |r: u32, c: u32| r * n_columns + c % n_columns;
            let (a, b) = (at(ring, column), at(ring, column + 1));
            let (c, d) = (at(ring + 1, column + 1), at(ring + 1, column));
            if ring > 0 {
                mesh.triangles.push([a, d, b]);
            }
            if ring + 1 < n_rings {
                mesh.triangles.push([b, d, c]);
            }
        }
    }
    mesh
}

/// An octahedron with the normals of a sphere: they lean up to 55° away from its faces.
#[must_use]
pub fn smooth_octahedron(center: Vec3, radius: f32) -> MeshDescription {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let faces = [
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
    MeshDescription {
        positions: axes.map(|axis| center + radius * axis).into(),
        normals: Some(axes.into()),
        uv_sets: vec![
            axes.map(|axis| Vec2::new(axis.x + 0.3 * axis.y, axis.z - 0.6 * axis.y))
                .into(),
        ],
        triangles: faces.into(),
        ..MeshDescription::default()
    }
}

/// A camera that sees exactly the square `[-half, half]²` of the plane y = 0, from `height` above.
#[must_use]
pub fn above_square(half: f32, height: f32) -> CameraDescription {
    CameraDescription {
        name: "above".to_owned(),
        world_from_camera: CameraDescription::looking_at(Vec3::Y * height, Vec3::ZERO, Vec3::NEG_Z),
        aspect_ratio: None,
        projection: Projection::Orthographic { ymag: half },
        lens: None,
        crop: None,
    }
}

/// A pinhole camera with a right angle of view.
#[must_use]
pub fn looking(eye: Vec3, target: Vec3) -> CameraDescription {
    let up = if (target - eye).normalize().y.abs() > 0.99 {
        Vec3::Z
    } else {
        Vec3::Y
    };
    CameraDescription {
        name: "looking".to_owned(),
        world_from_camera: CameraDescription::looking_at(eye, target, up),
        aspect_ratio: None,
        projection: Projection::Perspective { yfov: FRAC_PI_2 },
        lens: None,
        crop: None,
    }
}
