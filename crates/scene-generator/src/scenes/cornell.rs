//! The Cornell box, with its two blocks or with a mirror and a glass ball.
//!
//! The measured vertices of the real box, in millimetres there, with +X to the
//! left and +Z away from the camera: here in units of 10 cm taken as metres,
//! turned so that the camera looks down -Z. Walls and blocks are not quite
//! rectangular, because the real ones are not.

use glam::{DVec3, dvec3};

use crate::material::Material;
use crate::mesh::Mesh;
use crate::scene::{Camera, Placement, Scene, Surface};

const WHITE: [f64; 3] = [0.725, 0.71, 0.68];
const GREEN: [f64; 3] = [0.14, 0.45, 0.091];
const RED: [f64; 3] = [0.63, 0.065, 0.05];
const LIGHT: [f64; 3] = [36.0, 29.0, 19.5];

/// The box with its two blocks.
pub(crate) fn cornell() -> Scene {
    let mut scene = Scene::new(
        "The Cornell box: diffuse walls and blocks under one area light; the place to start",
    );
    let white = room(&mut scene);
    let short = [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]];
    scene.add("short block", block(short, 165.0), white);
    let tall = [
        [423.0, 247.0],
        [265.0, 296.0],
        [314.0, 456.0],
        [472.0, 406.0],
    ];
    scene.add("tall block", block(tall, 330.0), white);
    scene
}

/// The box with a mirror ball and a glass ball.
pub(crate) fn cornell_glass() -> Scene {
    let mut scene = Scene::new(
        "The Cornell box with a mirror ball and a glass ball: caustics, and what few paths reach",
    );
    room(&mut scene);
    let ball = scene.geometry("ball", Mesh::sphere(64));
    let mirror = scene.material(Material::metal("mirror", [1.0; 3], 0.0));
    let glass = scene.material(Material::glass("glass", 1.5));
    let placed = |x, z| Placement::at(dvec3(x, 1.001, z));
    scene.place("mirror ball", &[(ball, mirror)], placed(-1.15, -3.75));
    scene.place("glass ball", &[(ball, glass)], placed(1.1, -1.85));
    scene
}

/// Walls, light and camera; returns the white of the walls.
fn room(scene: &mut Scene) -> Surface {
    let white = scene.material(Material::lambert("white", WHITE));
    let green = scene.material(Material::lambert("green", GREEN));
    let red = scene.material(Material::lambert("red", RED));
    let light = scene.material(Material::emitter("light", LIGHT));

    let floor = [
        [552.8, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 559.2],
        [549.6, 0.0, 559.2],
    ];
    let ceiling = [
        [556.0, 548.8, 0.0],
        [556.0, 548.8, 559.2],
        [0.0, 548.8, 559.2],
        [0.0, 548.8, 0.0],
    ];
    let back = [floor[3], floor[2], ceiling[2], ceiling[1]];
    let right = [floor[2], floor[1], ceiling[3], ceiling[2]];
    let left = [floor[0], floor[3], ceiling[1], ceiling[0]];
    // A millimetre below the ceiling, so that the two do not fight.
    let lamp = [
        [343.0, 548.7, 227.0],
        [343.0, 548.7, 332.0],
        [213.0, 548.7, 332.0],
        [213.0, 548.7, 227.0],
    ];
    for (name, corners, surface) in [
        ("floor", floor, white),
        ("ceiling", ceiling, white),
        ("back wall", back, white),
        ("right wall", right, green),
        ("left wall", left, red),
        ("light", lamp, light),
    ] {
        scene.add(name, Mesh::quad(corners.map(measured)), surface);
    }
    // A little closer in angle than the original, which shows the rim of the box.
    scene.camera(Camera {
        name: "Front",
        eye: dvec3(0.0, 2.744, 8.0),
        target: dvec3(0.0, 2.744, 0.0),
        field_of_view: 37.5,
        aspect_ratio: 1.0,
        aperture: 0.0,
    });
    white
}

/// From the table of measurements to the scene.
fn measured([x, y, z]: [f64; 3]) -> DVec3 {
    dvec3(276.4 - x, y, -z) / 100.0
}

/// A block without a bottom, from the (x, z) of its corners.
fn block(corners: [[f64; 2]; 4], height: f64) -> Mesh {
    let at = |i: usize, y: f64| measured([corners[i % 4][0], y, corners[i % 4][1]]);
    let sides =
        (0..4).map(|i| Mesh::quad([at(i, 0.0), at(i + 1, 0.0), at(i + 1, height), at(i, height)]));
    let top = Mesh::quad([0, 1, 2, 3].map(|i| at(i, height)));
    Mesh::union(sides.chain([top]))
}
