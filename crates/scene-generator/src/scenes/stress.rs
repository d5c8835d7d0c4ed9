//! Scenes that are there to be big, for measuring; not built in.

use glam::{DVec3, dvec3};

use crate::material::Material;
use crate::mesh::Mesh;
use crate::scene::{Camera, Placement, Scene};

/// Copies along each side of the crowd.
const ROWS: usize = 100;

/// One bumpy ball of five million triangles.
pub(crate) fn five_million() -> Scene {
    let mut scene = Scene::new("A ball of five million triangles");
    let mut ball = Mesh::icosphere(9);
    for p in &mut ball.positions {
        let bumps = (40.0 * p.x).sin() * (40.0 * p.y).sin() * (40.0 * p.z).sin();
        *p *= 1.0 + 0.02 * bumps;
    }
    let clay = scene.material(Material::plastic("clay", [0.7, 0.6, 0.5], 0.6));
    scene.add("ball", ball, clay);
    light(&mut scene, 3.0);
    scene.camera(Camera {
        name: "Ball",
        eye: dvec3(0.0, 0.6, 3.4),
        target: DVec3::ZERO,
        field_of_view: 40.0,
        aspect_ratio: 1.0,
        aperture: 0.0,
    });
    scene
}

/// Ten thousand balls of ten thousand triangles, which share one mesh.
pub(crate) fn ten_thousand() -> Scene {
    let mut scene = Scene::new("Ten thousand balls of ten thousand triangles");
    let ball = scene.geometry("ball", Mesh::sphere(50));
    let clay = scene.material(Material::plastic("clay", [0.7, 0.6, 0.5], 0.6));
    let middle = (ROWS - 1) as f64 / 2.0;
    for i in 0..ROWS * ROWS {
        let (x, z) = ((i % ROWS) as f64 - middle, (i / ROWS) as f64 - middle);
        let y = 0.6 * (0.3 * x).sin() * (0.23 * z).cos();
        let placement = Placement::at(2.5 * dvec3(x, y, z));
        scene.place(&format!("ball {i}"), &[(ball, clay)], placement);
    }
    light(&mut scene, 120.0);
    scene.camera(Camera {
        name: "Crowd",
        eye: dvec3(0.0, 40.0, 150.0),
        target: DVec3::ZERO,
        field_of_view: 40.0,
        aspect_ratio: 1.0,
        aperture: 0.0,
    });
    scene
}

/// A square lamp overhead, as wide as it is high.
fn light(scene: &mut Scene, height: f64) {
    let lamp = scene.material(Material::emitter("lamp", [6.0; 3]));
    let square = scene.geometry("square", Mesh::square_facing_down());
    let placement = Placement::at(height * DVec3::Y).scaled(DVec3::splat(height));
    scene.place("lamp", &[(square, lamp)], placement);
}
