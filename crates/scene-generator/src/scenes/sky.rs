//! A few materials out of doors, under an image of the sky.

use glam::{DQuat, DVec3, dvec3};

use crate::environment::GROUND_ALBEDO;
use crate::material::Material;
use crate::mesh::Mesh;
use crate::revolve::Sweep;
use crate::scene::{Camera, Placement, Scene};

/// Balls and a ring on open ground.
pub(crate) fn sky() -> Scene {
    let mut scene = Scene::new(
        "Materials under a sky: clay, brushed metal, glossy plastic and glass, lit by an image",
    );
    scene.surround("sky.hdr");

    let ground = scene.material(Material::lambert("ground", GROUND_ALBEDO));
    let disc = Mesh::lathe(&[(40.0, 0.0), (0.0, 0.0)], Sweep::full(96));
    scene.add("ground", disc, ground);

    let ball = scene.geometry("ball", Mesh::sphere(64));
    let clay = scene.material(Material::lambert("clay", [0.62, 0.30, 0.19]));
    let copper = scene.material(Material::metal("brushed copper", [0.95, 0.57, 0.40], 0.35));
    let plastic = scene.material(Material::plastic("teal plastic", [0.02, 0.26, 0.27], 0.15));
    let glass = scene.material(Material::glass("glass", 1.5));
    let chrome = scene.material(Material::metal("chrome", [1.0; 3], 0.0));
    for (name, surface, x, z, radius) in [
        ("copper ball", copper, -0.15, -1.15, 0.95),
        ("clay ball", clay, -1.5, -0.25, 0.55),
        ("plastic ball", plastic, 1.28, -0.30, 0.62),
        ("glass ball", glass, 0.22, 0.55, 0.42),
        ("chrome ball", chrome, -0.62, 0.72, 0.24),
    ] {
        let placement = Placement::at(dvec3(x, radius + 0.001, z)).scaled(DVec3::splat(radius));
        scene.place(name, &[(ball, surface)], placement);
    }

    let yellow = scene.material(Material::plastic("yellow plastic", [0.85, 0.47, 0.03], 0.3));
    let ring = Mesh::torus(0.27, 0.085, 32, Sweep::full(80));
    let ring = scene.geometry("ring", ring);
    let lean = DQuat::from_rotation_z(-0.12);
    let placement = Placement::at(dvec3(1.12, 0.12, 0.82)).turned(lean);
    scene.place("plastic ring", &[(ring, yellow)], placement);

    let wide = Camera {
        name: "Wide",
        eye: dvec3(0.5, 1.35, 5.2),
        target: dvec3(0.0, 0.62, -0.2),
        field_of_view: 31.0,
        aspect_ratio: 16.0 / 9.0,
        aperture: 0.0,
    };
    scene.camera(wide);
    scene.camera(Camera {
        name: "Close, wide open",
        eye: dvec3(0.75, 0.75, 2.7),
        target: dvec3(0.22, 0.42, 0.55),
        field_of_view: 34.0,
        aperture: 0.09,
        ..wide
    });
    scene
}
