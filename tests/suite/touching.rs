//! Do rays meet what they should where surfaces touch, let light through, or are of very different
//! sizes?
//!
//! What is cut out is not there; layers of which each lets a share through multiply, however many
//! there are, for every kind of ray; of surfaces in one plane all methods see the same one; and a
//! floor of kilometres does to a small thing what a small floor does.

use std::sync::Arc;

use glam::{Mat4, Quat, Vec3};

use neumann_core::integrator::{METHODS, Method, method};
use neumann_core::math::Ray;
use neumann_core::radiometry::Rgb;
use neumann_core::scene::Scene;
use neumann_core::scene::description::{
    AlphaMode, MaterialDescription, MeshDescription, VolumeDescription,
};
use neumann_core::transport::Tracer;
use neumann_tests::renders::Setup;
use neumann_tests::scenes::{Stage, emitter, lambert, looking, rectangle};
use neumann_tests::statistics::{Estimate, Family};

/// A surface of which so much is there.
fn veil(alpha: f32) -> MaterialDescription {
    MaterialDescription {
        alpha,
        alpha_mode: AlphaMode::Blend,
        ..lambert(0.0)
    }
}

/// Horizontal sheets at the given heights, in one mesh.
fn sheets(heights: impl Iterator<Item = f32>) -> MeshDescription {
    let mut mesh = MeshDescription::default();
    for height in heights {
        let sheet = rectangle(Vec3::Y * height, Vec3::Z * 3.0, Vec3::X * 3.0);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(sheet.positions);
        let triangles = sheet.triangles.iter();
        mesh.triangles
            .extend(triangles.map(|t| t.map(|i| i + first)));
    }
    mesh
}

/// A floor below a lamp, seen from the side.
fn below_lamp() -> Stage {
    let mut stage = Stage::default();
    let floor = rectangle(Vec3::ZERO, Vec3::Z * 2.0, Vec3::X * 2.0);
    stage.add("floor", floor, lambert(0.5));
    let lamp = rectangle(Vec3::Y, Vec3::X * 0.55, Vec3::Z * 0.45);
    stage.add("lamp", lamp, emitter(10.0));
    let eye = Vec3::new(0.6, 0.15, 0.6);
    stage.description.cameras = vec![looking(eye, Vec3::new(0.1, 0.0, 0.1))];
    stage
}

/// Methods that see light from lamps on diffuse surfaces, and shadows.
fn methods_with_shadows() -> impl Iterator<Item = &'static Method> {
    METHODS.iter().copied().filter(|m| m.sight.shadows)
}

/// Means of a bounce by a method, channel by channel the same.
fn estimate(scene: &Arc<Scene>, method: &'static Method, layer: usize, stream: u64) -> Estimate {
    let setup = Setup::new(scene, 12, 12).by(method).up_to(layer as u32);
    setup
        .with_many_photons()
        .batches(8, 12, stream)
        .layer(layer)[1]
}

/// Moves everything of a scene, cameras too.
fn moved(mut stage: Stage, by: Mat4) -> Arc<Scene> {
    for mesh in &mut stage.description.meshes {
        for position in &mut mesh.positions {
            *position = by.transform_point3(*position);
        }
    }
    for camera in &mut stage.description.cameras {
        camera.world_from_camera = by * camera.world_from_camera;
    }
    stage.scene()
}

#[test]
fn sheets_that_are_cut_out_take_no_light() {
    let without = below_lamp();
    let mut family = Family::default();
    let bare = without.scene();
    let mut stage = without;
    let heights = (0..20).map(|i| 0.2 + 0.03 * i as f32);
    stage.add("sheets", sheets(heights), veil(0.0));
    let scene = stage.scene();
    for (stream, method) in methods_with_shadows().enumerate() {
        // The radius of photons grows with the scene.
        if method.bias.is_some_and(|bias| bias.contains("radius")) {
            continue;
        }
        let [a, b] = [&bare, &scene].map(|s| estimate(s, method, 1, 3000 + stream as u64));
        let what = format!("{}: {a:?} without, {b:?} with", method.id);
        family.add(a.p_value_against(&b, 1e-4), what);
    }
    family.judge();
}

/// However many layers there are, and however many in one plane: each counts once for rays that ask
/// how much gets
/// through, and stops its share of the rays that go on.
#[test]
fn layers_multiply_for_every_kind_of_ray() {
    const N: usize = 1000;
    let alpha = 1.0 - 0.5f32.powf(1.0 / N as f32);
    let apart = sheets((0..N).map(|i| 1.0 + 0.01 * i as f32));
    let in_one_plane = sheets((0..N).map(|_| 5.0));
    for (name, mesh) in [("apart", apart), ("in one plane", in_one_plane)] {
        let mut stage = Stage::default();
        stage.add("sheets", mesh, veil(alpha));
        let scene = stage.scene();
        let mut tracer = Tracer::new(&scene);
        let slope = Vec3::new(0.1, 1.0, 0.03).normalize();
        for (direction, from) in [(slope, 0.0), (-slope, 20.0)] {
            let origin = Vec3::new(0.123, from, 0.077) - slope * 0.05 * from.min(1.0);
            let ray = Ray::new(origin, direction);
            assert_eq!(tracer.crossings(&ray).len(), N, "{name}");
            let share = tracer.transmittance(&ray);
            assert!((share - 0.5).abs() < 1e-4, "{name}: {share}");
        }
        let n_rays = 4000;
        let n_through = (0..n_rays)
            .filter(|i| {
                let origin = Vec3::new(0.1 + 1e-4 * *i as f32, 0.0, 0.07);
                tracer.hit(&Ray::new(origin, Vec3::Y)).is_none()
            })
            .count();
        let share = n_through as f32 / n_rays as f32;
        assert!((share - 0.5).abs() < 0.04, "{name}: {share}");
    }
}

/// A lamp in the plane of the ceiling shines, if it comes first in the scene, and does not
/// otherwise; upright, turned, and a
/// kilometre away.
#[test]
fn of_surfaces_in_one_plane_all_methods_see_the_same() {
    let turned = Mat4::from_quat(Quat::from_rotation_z(0.4));
    let away = Mat4::from_translation(Vec3::new(1000.0, 0.0, -1000.0));
    let expected = estimate(&below_lamp().scene(), method("pt-mis").unwrap(), 1, 3100);
    let mut family = Family::default();
    for (place, by) in [("here", Mat4::IDENTITY), ("turned", turned), ("away", away)] {
        for is_first in [true, false] {
            let mut stage = below_lamp();
            let ceiling = rectangle(Vec3::Y, Vec3::X * 2.0, Vec3::Z * 2.1);
            stage.add("ceiling", ceiling, lambert(0.5));
            if !is_first {
                stage.description.instances.reverse();
            }
            let scene = moved(stage, by);
            for id in ["pt-bsdf", "pt-nee", "pt-mis", "lt", "bdpt", "vcm"] {
                let found = estimate(&scene, method(id).unwrap(), 1, 3200);
                if is_first {
                    let what = format!("{id}, {place}: {found:?} for {expected:?}");
                    family.add(found.p_value_against(&expected, 1e-3), what);
                } else {
                    assert!(found.mean < 1e-4, "{id}, {place}: {found:?}");
                }
            }
        }
    }
    family.judge();
}

/// Light from below a floor stays there, whatever stands flush on it: a glass box, a
/// half-transparent decal.
#[test]
fn nothing_leaks_through_a_floor_under_flush_things() {
    let glass = MaterialDescription {
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        volume: Some(VolumeDescription {
            attenuation_color: Rgb::WHITE,
            attenuation_distance: f32::INFINITY,
        }),
        ..MaterialDescription::default()
    };
    let turned = Mat4::from_quat(Quat::from_rotation_z(0.4));
    for by in [Mat4::IDENTITY, turned] {
        for is_first in [true, false] {
            for (name, material) in [("glass", glass.clone()), ("decal", veil(0.5))] {
                let mut stage = Stage::default();
                let floor = rectangle(Vec3::ZERO, Vec3::Z * 3.0, Vec3::X * 3.0);
                stage.add("floor", floor, lambert(0.5));
                let below = rectangle(-Vec3::Y, Vec3::Z * 2.0, Vec3::X * 2.0);
                let lamp = MaterialDescription {
                    is_double_sided: true,
                    ..emitter(1e6)
                };
                stage.add("lamp", below, lamp);
                let bottom = rectangle(Vec3::ZERO, Vec3::X, Vec3::Z);
                stage.add("bottom", bottom, material);
                if name == "glass" {
                    let top = rectangle(Vec3::Y, Vec3::Z, Vec3::X);
                    stage.add("top", top, glass.clone());
                }
                if !is_first {
                    stage.description.instances.reverse();
                }
                let eye = Vec3::new(0.1, 2.0, 0.6);
                stage.description.cameras = vec![looking(eye, Vec3::ZERO)];
                let scene = moved(stage, by);
                for id in ["pt-bsdf", "pt-nee", "pt-mis", "bdpt", "vcm"] {
                    // Photons between a decal and its floor are as near to the floor's other side.
                    if (id, name) == ("vcm", "decal") {
                        continue;
                    }
                    let setup = Setup::new(&scene, 24, 24).by(method(id).unwrap());
                    let film = setup.up_to(4).film(0, 16);
                    let sum: f64 = film.layer_means().iter().map(|layer| layer[1]).sum();
                    // The floor is wider than the light can go around it; its two halves see each
                    // other by rounding.
                    assert!(sum < 1e-4, "{name}, {id}, first: {is_first}: {sum}");
                }
            }
        }
    }
}

/// A box of a centimetre below a lamp, on floors from four metres to six kilometres, level
/// and tilted.
#[test]
fn a_small_box_does_not_know_how_large_its_floor_is() {
    let scene = |half: f32, tilt: f32| {
        let mut stage = Stage::default();
        let floor = rectangle(Vec3::ZERO, Vec3::Z * half, Vec3::X * half);
        stage.add("floor", floor, lambert(0.5));
        let (center, h) = (Vec3::Y * 0.005, 0.005);
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for n in [axis, -axis] {
                let x = n.any_orthonormal_vector() * h;
                let wall = rectangle(center + n * h, x, n.cross(x));
                stage.add("box", wall, lambert(0.7));
            }
        }
        let lamp = rectangle(Vec3::Y * 0.05, Vec3::X * 0.02, Vec3::Z * 0.02);
        stage.add("lamp", lamp, emitter(10.0));
        let eye = Vec3::new(0.02, 0.012, 0.025);
        stage.description.cameras = vec![looking(eye, Vec3::Y * 0.003)];
        moved(stage, Mat4::from_quat(Quat::from_rotation_z(tilt)))
    };
    for tilt in [0.0, 0.3] {
        for id in ["pt-nee", "pt-mis", "bdpt", "lt", "vcm", "ppm"] {
            let method = method(id).unwrap();
            // Rounding takes a photon into the radius, or out of it.
            let bound = if method.bias.is_some() { 1e-2 } else { 2e-3 };
            let means = |half| {
                let setup = Setup::new(&scene(half, tilt), 64, 64).by(method).up_to(3);
                setup.film(0, 4).layer_means()
            };
            let small = means(2.0);
            for half in [300.0, 3000.0] {
                for (k, (a, b)) in means(half).iter().zip(&small).enumerate() {
                    let off = (a[1] - b[1]).abs();
                    // The same paths: what differs is rounding.
                    assert!(
                        off <= bound * b[1] + 1e-6,
                        "{id}, {half} m, T{k}: {a:?} {b:?}"
                    );
                }
            }
        }
    }
}

/// Two half-transparent decals above a wall, a millimetre from each other, a kilometre from the
/// origin.
#[test]
fn decals_hold_a_kilometre_away() {
    let mut stage = below_lamp();
    let lamp = stage.scene();
    for (name, height) in [("lower", 0.001), ("upper", 0.002)] {
        let decal = rectangle(Vec3::Y * height, Vec3::Z * 1.9, Vec3::X * 1.9);
        stage.add(name, decal, veil(0.5));
    }
    let mut family = Family::default();
    let away = Mat4::from_translation(Vec3::new(1000.0, 200.0, -1000.0));
    for (place, by) in [("here", Mat4::IDENTITY), ("away", away)] {
        let scene = moved(stage.clone(), by);
        for (stream, id) in ["pt-bsdf", "pt-mis", "bdpt"].into_iter().enumerate() {
            let method = method(id).unwrap();
            let stream = 3300 + stream as u64;
            let [bare, found] = [&lamp, &scene].map(|s| estimate(s, method, 1, stream));
            // Black decals leave a quarter on the way there, and a quarter on the way back.
            let exact = bare.mean / 16.0;
            let what = format!("{id}, {place}: {found:?} for {exact}");
            family.add(found.p_value(exact, 0.02 * exact), what);
        }
    }
    family.judge();
}
