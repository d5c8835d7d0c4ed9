//! Light gathered by glass onto a diffuse ground.
//!
//! A ball and a ring of clear glass in front of a small, strong light: every
//! path of the caustics goes light, glass, ground, and no connection through
//! the glass can find it.

use std::f64::consts::PI;

use glam::{DQuat, DVec3, dvec3};

use crate::material::Material;
use crate::mesh::Mesh;
use crate::revolve::Sweep;
use crate::scene::{Camera, Placement, Scene};

/// A ball and a ring on a sheet of paper.
pub(crate) fn caustic() -> Scene {
    let mut scene = Scene::new(
        "Caustics: a glass ball and a glass ring gather the light of a small lamp on the ground",
    );

    let paper = scene.material(Material::lambert("paper", [0.76, 0.74, 0.70]));
    let bend = (0..=24).map(|i| {
        let (sin, cos) = (0.5 * PI * f64::from(i) / 24.0).sin_cos();
        (-3.4 - 1.6 * sin, 1.6 - 1.6 * cos)
    });
    let profile: Vec<_> = [(7.0, 0.0), (-1.0, 0.0)]
        .into_iter()
        .chain(bend)
        .chain([(-5.0, 6.0)])
        .collect();
    scene.add("paper", Mesh::extrusion(&profile, 8.0), paper);

    let glass = scene.material(Material::glass("glass", 1.5));
    let ball = scene.geometry("ball", Mesh::sphere(64));
    let placement = Placement::at(dvec3(-0.62, 0.502, -0.45)).scaled(DVec3::splat(0.5));
    scene.place("glass ball", &[(ball, glass)], placement);
    let ring = Mesh::torus(0.36, 0.1, 40, Sweep::full(112));
    let ring = scene.geometry("ring", ring);
    scene.place(
        "glass ring",
        &[(ring, glass)],
        Placement::at(dvec3(0.62, 0.102, -0.05)),
    );

    let light = scene.material(Material::emitter("lamp", [1200.0, 1130.0, 1030.0]));
    let square = scene.geometry("square", Mesh::square_facing_down());
    let at = dvec3(-2.1, 2.1, -2.9);
    let aim = DQuat::from_rotation_arc(DVec3::NEG_Y, (dvec3(0.1, 0.0, 0.1) - at).normalize());
    let placement = Placement::at(at).turned(aim).scaled(dvec3(0.22, 1.0, 0.22));
    scene.place("lamp", &[(square, light)], placement);

    scene.camera(Camera {
        name: "Front",
        eye: dvec3(0.3, 1.75, 3.8),
        target: dvec3(0.1, 0.2, 0.15),
        field_of_view: 32.0,
        aspect_ratio: 4.0 / 3.0,
        aperture: 0.0,
    });
    scene
}
