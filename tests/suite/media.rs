//! Is light absorbed and bent by what it runs through, whichever way it goes?
//!
//! Closed forms: slabs seen at right angles, where Beer's law and Fresnel's equations give every
//! layer, for all methods that say that they see what is there. `agreement` holds what has no
//! closed form: light paths against camera paths.

mod agreement;

use std::sync::Arc;

use glam::{Mat4, Vec3};

use neumann_core::integrator::{METHODS, Method};
use neumann_core::radiometry::Rgb;
use neumann_core::scene::Scene;
use neumann_core::scene::description::{
    AlphaMode, CameraDescription, InstanceDescription, MaterialDescription, MeshDescription,
    Projection, VolumeDescription,
};
use neumann_tests::renders::Setup;
use neumann_tests::scenes::{Stage, emitter, rectangle};
use neumann_tests::statistics::Family;

/// Glass of which half of the light is left after `half_length`; infinite for clear glass.
fn glass(ior: f32, roughness: f32, half_length: f32) -> MaterialDescription {
    MaterialDescription {
        metallic: 0.0,
        roughness,
        transmission: 1.0,
        ior,
        volume: Some(VolumeDescription {
            attenuation_color: Rgb::splat(0.5),
            attenuation_distance: half_length,
        }),
        ..MaterialDescription::default()
    }
}

const CLEAR: f32 = f32::INFINITY;

/// A box between two corners, facing outwards; six walls with corners of their own.
fn cuboid(min: Vec3, max: Vec3) -> MeshDescription {
    let (center, half) = (0.5 * (min + max), 0.5 * (max - min));
    let mut cuboid = MeshDescription::default();
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for n in [axis, -axis] {
            let x = n.any_orthonormal_vector();
            let y = n.cross(x);
            let wall = rectangle(center + n * half, x * half, y * half);
            let first = cuboid.positions.len() as u32;
            cuboid.positions.extend(wall.positions);
            let triangles = wall.triangles.iter();
            cuboid
                .triangles
                .extend(triangles.map(|t| t.map(|i| i + first)));
        }
    }
    cuboid
}

/// A slab between two heights, wide enough that nothing sees its sides.
fn slab(low: f32, high: f32) -> MeshDescription {
    cuboid(Vec3::new(-3.0, low, -3.0), Vec3::new(3.0, high, 3.0))
}

/// The same, wound the other way round.
fn inside_out(mut mesh: MeshDescription) -> MeshDescription {
    for triangle in &mut mesh.triangles {
        triangle.swap(1, 2);
    }
    mesh
}

fn moved(mut mesh: MeshDescription, by: Vec3) -> MeshDescription {
    for position in &mut mesh.positions {
        *position += by;
    }
    mesh
}

/// A camera at a height that looks straight up or down, all rays side by side.
fn straight(height: f32, direction: Vec3) -> CameraDescription {
    let eye = Vec3::Y * height;
    CameraDescription {
        name: "straight".to_owned(),
        world_from_camera: CameraDescription::looking_at(eye, eye + direction, Vec3::NEG_Z),
        aspect_ratio: None,
        projection: Projection::Orthographic { ymag: 0.2 },
        lens: None,
        crop: None,
    }
}

/// A stage whose camera looks up to a lamp of radiance 1 at height 10, which fills its view.
fn below_lamp(height: f32) -> Stage {
    let mut stage = Stage::default();
    let lamp = rectangle(Vec3::Y * 10.0, Vec3::X * 0.25, Vec3::Z * 0.25);
    stage.add("lamp", lamp, emitter(1.0));
    stage.description.cameras = vec![straight(height, Vec3::Y)];
    stage
}

/// Fresnel's reflectance at right angles.
fn r(a: f64, b: f64) -> f64 {
    ((a - b) / (a + b)).powi(2)
}

/// Methods that see mirror-like surfaces from the camera, and what is between.
fn methods_through_glass() -> impl Iterator<Item = &'static &'static Method> {
    METHODS.iter().filter(|m| {
        let sight = m.sight;
        sight.delta_surfaces && sight.delta_to_camera && sight.shadows
    })
}

/// Holds the first layers of all methods that see it against what they must be.
fn judge(name: &str, scene: &Arc<Scene>, expected: &[f64]) {
    let mut family = Family::default();
    for (stream, method) in methods_through_glass().enumerate() {
        let batches = Setup::new(scene, 16, 16)
            .by(method)
            .up_to(expected.len() as u32 - 1)
            .batches(16, 8, 900 + stream as u64);
        assert_eq!(batches.n_refused(), 0);
        for (k, exact) in expected.iter().enumerate() {
            let mean = batches.layer(k)[1];
            let what = format!("{name}, {}, T{k}: {mean:?} for {exact:.5}", method.id);
            family.add(mean.p_value(*exact, 2e-5), what);
        }
    }
    family.judge();
}

#[test]
fn a_camera_inside_of_an_absorbing_body() {
    // All methods that know shadows see the lamp, through half a metre of the body and more.
    let mut stage = below_lamp(1.0);
    stage.add("body", slab(0.0, 11.0), glass(1.0, 0.0, 6.0));
    let scene = stage.scene();
    let exact = 0.5f64.powf(1.5);
    let mut family = Family::default();
    for (stream, method) in METHODS.iter().enumerate() {
        if !method.sight.shadows {
            continue;
        }
        let setup = Setup::new(&scene, 16, 16).by(method).up_to(0);
        let mean = setup.batches(16, 16, 800 + stream as u64).layer(0)[1];
        let what = format!("{}: {mean:?} for {exact}", method.id);
        family.add(mean.p_value(exact, 2e-5), what);
    }
    family.judge();
}

#[test]
fn a_camera_and_a_lamp_in_different_bodies() {
    let mut stage = below_lamp(1.0);
    // The lamp has 1 m of the upper body below it, the camera 2 m of the lower one above.
    stage.add("lower", slab(-1.0, 3.0), glass(1.0, 0.0, 2.0));
    stage.add("upper", slab(9.0, 12.0), glass(1.0, 0.0, 4.0));
    judge("two bodies", &stage.scene(), &[0.0, 0.0, 0.5f64.powf(1.25)]);
}

#[test]
fn a_clear_body_inside_of_a_tinted_one() {
    let mut stage = below_lamp(0.0);
    stage.add("clear", slab(2.5, 3.0), glass(1.0, 0.0, CLEAR));
    stage.add("tinted", slab(2.0, 4.0), glass(1.0, 0.0, 1.0));
    let exact = 0.5f64.powf(1.5);
    let layers = [0.0, 0.0, 0.0, 0.0, exact];
    judge("clear in tinted", &stage.scene(), &layers);
    // And a third one in that.
    stage.add("inmost", slab(2.6, 2.9), glass(1.0, 0.0, 0.1));
    let exact = 0.5f64.powf(1.5 + 3.0);
    let layers = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, exact];
    judge("three", &stage.scene(), &layers);
}

/// A glass plate on water, seen from below the water: the plate stands apart, touches it, or
/// reaches into it.
#[test]
fn indices_of_both_sides_count() {
    let (water, plate) = (1.33, 1.5);
    let (up, top) = (r(water, plate), r(plate, 1.0));
    let bottom = r(water, 1.0);
    let inside = water * water;
    // Once through both; or back and forth once, in the plate or in the water.
    let through = inside * (1.0 - up) * (1.0 - top);
    let layers = [0.0, 0.0, through, 0.0, through * up * (top + bottom)];
    for (name, low) in [("touching", 2.0), ("overlapping", 1.7)] {
        for first in ["plate", "water"] {
            let mut stage = below_lamp(1.0);
            let bodies = [
                ("plate", slab(low, 3.0), glass(plate as f32, 0.0, CLEAR)),
                ("water", slab(0.0, 2.0), glass(water as f32, 0.0, CLEAR)),
            ];
            let (a, b): (Vec<_>, Vec<_>) = bodies.into_iter().partition(|body| body.0 == first);
            for (name, mesh, material) in a.into_iter().chain(b) {
                stage.add(name, mesh, material);
            }
            judge(&format!("{name}, {first} first"), &stage.scene(), &layers);
        }
    }
    // With air in between, there are three walls.
    let air = r(water, 1.0);
    let through = inside * (1.0 - air) * (1.0 - top) * (1.0 - top);
    let mut stage = below_lamp(1.0);
    stage.add("plate", slab(2.2, 3.0), glass(plate as f32, 0.0, CLEAR));
    stage.add("water", slab(0.0, 2.0), glass(water as f32, 0.0, CLEAR));
    judge("apart", &stage.scene(), &[0.0, 0.0, 0.0, through]);
}

/// A bubble as a cavity of the glass that it is in, turned inside out, and as a body of air.
#[test]
fn bubbles_of_either_kind() {
    let wall = r(1.5, 1.0);
    let through = (1.0 - wall).powi(4) * 0.5f64.powf(1.5);
    let layers = [0.0, 0.0, 0.0, 0.0, through];
    let (outer, inner) = (slab(2.0, 4.0), slab(2.5, 3.0));
    let inner = MeshDescription {
        positions: inner
            .positions
            .iter()
            .map(|p| *p * Vec3::new(0.9, 1.0, 0.9))
            .collect(),
        ..inner
    };
    let tinted = || glass(1.5, 0.0, 1.0);
    let mut one_mesh = outer.clone();
    let cavity = inside_out(inner.clone());
    let first = one_mesh.positions.len() as u32;
    one_mesh.positions.extend(&cavity.positions);
    let triangles = cavity.triangles.iter();
    one_mesh
        .triangles
        .extend(triangles.map(|t| t.map(|i| i + first)));
    let mut stage = below_lamp(0.0);
    stage.add("glass", one_mesh, tinted());
    judge("one mesh", &stage.scene(), &layers);
    let mut stage = below_lamp(0.0);
    stage.add("cavity", cavity, tinted());
    stage.add("glass", outer.clone(), tinted());
    judge("cavity", &stage.scene(), &layers);
    let mut stage = below_lamp(0.0);
    stage.add("glass", outer, tinted());
    stage.add("air", inner, glass(1.0, 0.0, CLEAR));
    judge("air", &stage.scene(), &layers);
}

#[test]
fn bodies_of_one_medium_that_overlap_or_touch_are_as_one() {
    let wall = r(1.5, 1.0);
    let through = (1.0 - wall).powi(2) * 0.5f64.powf(2.0);
    let layers = [0.0, 0.0, through];
    let whole = glass(1.5, 0.0, 1.0);
    for (name, high, low) in [("overlapping", 3.2, 2.8), ("touching", 3.0, 3.0)] {
        let mut stage = below_lamp(0.0);
        stage.add("lower", slab(2.0, high), whole.clone());
        stage.add("upper", slab(low, 4.0), whole.clone());
        judge(name, &stage.scene(), &layers);
    }
}

#[test]
fn of_two_alike_that_overlap_the_first_is_there() {
    let (one, two) = (slab(2.0, 4.0), moved(slab(2.0, 4.0), Vec3::Y));
    for (first, exact) in [(1.0, 2.0 + 0.5), (0.5, 4.0 + 1.0)] {
        let mut stage = below_lamp(0.0);
        stage.add("first", one.clone(), glass(1.0, 0.0, first));
        stage.add("second", two.clone(), glass(1.0, 0.0, 2.0 * first));
        let layers = [0.0, 0.0, 0.0, 0.5f64.powf(exact)];
        judge("alike", &stage.scene(), &layers);
    }
}

/// Walls of one body in several meshes, of materials that differ in more than their medium; and six
/// walls that are nodes by themselves.
#[test]
fn a_body_of_several_meshes() {
    let through = 0.5f64.powf(2.0);
    let layers = [0.0, 0.0, through];
    let whole = slab(2.0, 4.0);
    let tinted = glass(1.0, 0.0, 1.0);
    for object in [Some(7), None] {
        let mut stage = below_lamp(3.0);
        for (i, wall) in whole.triangles.chunks(2).enumerate() {
            let part = MeshDescription {
                triangles: wall.to_vec(),
                object,
                ..whole.clone()
            };
            let material = MaterialDescription {
                specular: i as f32 / 6.0,
                ..tinted.clone()
            };
            stage.add("wall", part, material);
        }
        // The camera is inside.
        let inside = [0.0, 0.5f64];
        judge("from inside", &stage.scene(), &inside);
        stage.description.cameras = vec![straight(0.0, Vec3::Y)];
        judge("from outside", &stage.scene(), &layers);
    }
}

#[test]
fn instances_and_mirror_images() {
    for mirrored in [1.0, -1.0] {
        let mut stage = below_lamp(0.0);
        let d = &mut stage.description;
        for (name, low, half_length, n) in [("a", 2.0, 1.0, 2), ("b", 5.0, 2.0, 1)] {
            for copy in 0..n {
                d.instances.push(InstanceDescription {
                    name: name.to_owned(),
                    mesh: d.meshes.len(),
                    world_from_mesh: Mat4::from_translation(Vec3::Y * (low + copy as f32))
                        * Mat4::from_scale(Vec3::new(mirrored, 0.5, 2.0)),
                });
            }
            d.meshes.push(MeshDescription {
                material: Some(d.materials.len()),
                ..slab(0.0, 1.0)
            });
            d.materials.push(glass(1.0, 0.0, half_length));
        }
        // Half a metre of each copy, one of them of the other glass.
        let exact = 0.5f64.powf(0.5 + 0.5 + 0.25);
        let layers = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, exact];
        judge("instances", &stage.scene(), &layers);
    }
}

/// A body whose triangles are all wound the wrong way round is a body still; a sheet that encloses
/// nothing has no inside that a camera could be in, whichever way it faces.
#[test]
fn what_is_not_well_made() {
    let mut stage = below_lamp(0.0);
    let tinted = glass(1.0, 0.0, 1.0);
    stage.add("turned", inside_out(slab(2.0, 4.0)), tinted.clone());
    judge("turned", &stage.scene(), &[0.0, 0.0, 0.25]);
    for facing in [1.0, -1.0] {
        let mut stage = below_lamp(0.0);
        let sheet = rectangle(Vec3::Y * 9.0, Vec3::X * 3.0, Vec3::Z * 3.0 * facing);
        stage.add("sheet", sheet, tinted.clone());
        // One that faces the camera is entered, and never left.
        let beyond = if facing > 0.0 { 0.5 } else { 1.0 };
        judge("sheet", &stage.scene(), &[0.0, beyond]);
    }
    // Outside of a body that is beside the camera, above and below it.
    let mut stage = below_lamp(1.0);
    let arch = cuboid(Vec3::new(0.5, -1.0, -1.0), Vec3::new(1.0, 3.0, 1.0));
    stage.add("beside", arch, glass(1.0, 0.0, 0.1));
    judge("beside", &stage.scene(), &[1.0]);
}

/// Half of a wall is not there: light goes through it into the body as through a hole.
#[test]
fn walls_that_leak() {
    let leaky = MaterialDescription {
        alpha: 0.5,
        alpha_mode: AlphaMode::Blend,
        ..glass(1.0, 0.0, 1.0)
    };
    let mut stage = below_lamp(0.0);
    stage.add("body", slab(2.0, 3.0), leaky);
    // Either wall stops it, or not: the same light in any case, after as many events as walls.
    judge("leaky", &stage.scene(), &[0.125, 0.25, 0.125]);
}
