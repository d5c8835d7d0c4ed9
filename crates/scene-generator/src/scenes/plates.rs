//! Veach's scene for multiple importance sampling.
//!
//! Four metal plates from nearly mirror to satin, each tilted so that it shows
//! four lights of very different size and equal power to the camera
//! ([Veach 1997], figure 9.2). Sampling the BSDF wins at top right of the
//! reflections, sampling the lights at bottom left; only both win everywhere.

use glam::{DQuat, DVec3, dvec3};

use crate::material::{Material, Rgb};
use crate::mesh::Mesh;
use crate::scene::{Camera, Placement, Scene};

const EYE: DVec3 = dvec3(0.0, 0.55, 3.9);
/// In the middle of the row of lights.
const LIGHTS: DVec3 = dvec3(0.0, 0.0, 0.0);
/// Radiance times squared radius of each light of the row.
const POWER: f64 = 0.05;

/// Four plates, four lights and a lamp above.
pub(crate) fn plates() -> Scene {
    let mut scene = Scene::new(
        "Veach's plates: glossy metal under lights of equal power, for multiple importance \
         sampling",
    );

    let grey = scene.material(Material::lambert("grey", [0.4; 3]));
    let backdrop = [
        (5.0, -1.05),
        (-0.1, -1.05),
        (-0.3, -1.02),
        (-0.46, -0.92),
        (-0.56, -0.76),
        (-0.6, -0.55),
    ];
    let wall = [(-0.6, -0.2), (-0.6, 4.0)];
    let profile: Vec<_> = backdrop.into_iter().chain(wall).collect();
    scene.add("floor and wall", Mesh::extrusion(&profile, 5.0), grey);

    let half = dvec3(1.0, 0.006, 0.125);
    let plate = scene.geometry("plate", Mesh::cuboid(-half, half));
    let plates = [
        (0.06, dvec3(0.0, -0.60, -0.05)),
        (0.14, dvec3(0.0, -0.77, 0.23)),
        (0.23, dvec3(0.0, -0.90, 0.55)),
        (0.32, dvec3(0.0, -0.98, 0.89)),
    ];
    for (roughness, centre) in plates {
        let name = format!("metal of roughness {roughness}");
        let metal = scene.material(Material::metal(&name, [1.0; 3], roughness));
        // The half vector between eye and lights is the normal of the plate.
        let normal = ((EYE - centre).normalize() + (LIGHTS - centre).normalize()).normalize();
        let placement = Placement::at(centre).turned(DQuat::from_rotation_arc(DVec3::Y, normal));
        scene.place(&format!("plate of {name}"), &[(plate, metal)], placement);
    }

    let ball = scene.geometry("ball", Mesh::sphere(24));
    let lights: [(&str, f64, f64, Rgb); 4] = [
        ("tiny", -0.94, 0.0085, [1.0, 0.62, 0.36]),
        ("small", -0.31, 0.026, [1.0, 0.86, 0.42]),
        ("medium", 0.31, 0.077, [0.62, 1.0, 0.66]),
        ("large", 0.94, 0.23, [0.48, 0.72, 1.0]),
    ];
    for (size, x, radius, tint) in lights {
        let radiance = tint.map(|channel| channel * POWER / (radius * radius));
        let surface = scene.material(Material::emitter(&format!("{size} light"), radiance));
        let placement = Placement::at(LIGHTS + x * DVec3::X).scaled(DVec3::splat(radius));
        scene.place(&format!("{size} light"), &[(ball, surface)], placement);
    }
    let lamp = scene.material(Material::emitter("lamp", [420.0, 400.0, 370.0]));
    let placement = Placement::at(dvec3(2.5, 3.0, 2.2)).scaled(DVec3::splat(0.12));
    scene.place("lamp", &[(ball, lamp)], placement);

    let front = Camera {
        name: "Front",
        eye: EYE,
        target: dvec3(0.0, -0.60, 0.2),
        field_of_view: 26.0,
        aspect_ratio: 1.5,
        aperture: 0.0,
    };
    scene.camera(front);
    scene.camera(Camera {
        name: "Side, wide open",
        eye: dvec3(-2.4, 0.35, 2.6),
        target: dvec3(-0.5, -0.84, 0.38),
        field_of_view: 24.0,
        aperture: 0.12,
        ..front
    });
    scene
}
