//! The white furnace: a closed ball that glows and reflects alike everywhere.
//!
//! With emission 1 and albedo 1/2, bounce k brings exactly 2^-k wherever one
//! looks, and the sum is 2. The facets are flat, so that shading and geometry
//! agree and the values hold to the last digit.

use glam::{DVec3, dvec3};

use crate::material::Material;
use crate::mesh::Mesh;
use crate::scene::{Camera, Scene};

/// A ball of radius 1, seen from within.
pub(crate) fn furnace() -> Scene {
    let mut scene =
        Scene::new("The white furnace: inside a glowing grey ball, where bounce k is exactly 2^-k");
    let wall = Material::lambert("glowing wall", [0.5; 3]).emitting([1.0; 3]);
    let wall = scene.material(wall);
    scene.add("ball", Mesh::icosphere(4).inside_out(), wall);
    scene.camera(Camera {
        name: "Inside",
        eye: dvec3(0.35, -0.2, 0.4),
        target: DVec3::ZERO,
        field_of_view: 60.0,
        aspect_ratio: 1.0,
        aperture: 0.0,
    });
    scene
}
