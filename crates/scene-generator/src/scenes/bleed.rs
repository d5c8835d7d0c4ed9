//! Colour that travels from surface to surface.
//!
//! Three curved screens of saturated paint in a white room, each around a white
//! object: what is coloured on the objects, the floor and the ceiling is light
//! that has met a screen before.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};

use crate::material::{Material, Rgb};
use crate::mesh::Mesh;
use crate::revolve::Sweep;
use crate::scene::{Camera, Placement, Scene};

const SCREEN_RADIUS: f64 = 0.95;
const SCREEN_HEIGHT: f64 = 1.9;
const SCREEN_THICKNESS: f64 = 0.04;

/// Three niches in a white room.
pub(crate) fn bleed() -> Scene {
    let mut scene = Scene::new(
        "Colour bleeding: white things between painted screens, lit by light that met the paint",
    );

    let white = scene.material(Material::lambert("white", [0.86, 0.85, 0.83]));
    let room = Mesh::cuboid(dvec3(-3.8, 0.0, -2.8), dvec3(3.8, 4.0, 5.2)).inside_out();
    scene.add("room", room, white);

    let light = scene.material(Material::emitter("ceiling light", [13.0, 12.4, 11.4]));
    let square = scene.geometry("square", Mesh::square_facing_down());
    let placement = Placement::at(dvec3(0.0, 3.99, -1.0)).scaled(dvec3(3.6, 1.0, 0.5));
    scene.place("ceiling light", &[(square, light)], placement);

    let screen = scene.geometry("screen", screen());
    let paints: [(&str, f64, Rgb); 3] = [
        ("vermilion", -2.1, [0.90, 0.13, 0.045]),
        ("yellow", 0.0, [0.90, 0.58, 0.03]),
        ("blue", 2.1, [0.05, 0.22, 0.80]),
    ];
    for (name, x, albedo) in paints {
        let paint = scene.material(Material::lambert(name, albedo));
        scene.place(
            &format!("{name} screen"),
            &[(screen, paint)],
            Placement::at(dvec3(x, 0.0, -1.0)),
        );
    }

    let ball = scene.geometry("ball", Mesh::sphere(32));
    let placement = Placement::at(dvec3(-2.1, 0.45, -1.05)).scaled(DVec3::splat(0.45));
    scene.place("ball", &[(ball, white)], placement);
    let vase = scene.geometry("vase", Mesh::smooth_lathe(&vase_profile(), Sweep::full(64)));
    scene.place(
        "vase",
        &[(vase, white)],
        Placement::at(dvec3(0.0, 0.0, -1.05)),
    );
    let cone = Mesh::lathe(&[(0.48, 0.0), (0.0, 1.15)], Sweep::full(64));
    let cone = scene.geometry("cone", cone);
    scene.place(
        "cone",
        &[(cone, white)],
        Placement::at(dvec3(2.1, 0.0, -1.05)),
    );

    scene.camera(Camera {
        name: "Front",
        eye: dvec3(0.0, 3.1, 4.9),
        target: dvec3(0.0, 0.80, -0.8),
        field_of_view: 35.0,
        aspect_ratio: 16.0 / 9.0,
        aperture: 0.0,
    });
    scene
}

/// A bent board, open towards +Z.
fn screen() -> Mesh {
    let (start, end) = (-0.2 * PI, 1.2 * PI);
    let (inner, outer, top) = (
        SCREEN_RADIUS - SCREEN_THICKNESS,
        SCREEN_RADIUS,
        SCREEN_HEIGHT,
    );
    let profile = [(outer, 0.0), (outer, top), (inner, top), (inner, 0.0)];
    let bent = Mesh::lathe(&profile, Sweep::arc(start, end, 64));
    let edge = |angle: f64, is_first: bool| {
        let at = |radius: f64, y: f64| dvec3(radius * angle.cos(), y, -radius * angle.sin());
        let mut edge = Mesh::quad([
            at(inner, 0.0),
            at(outer, 0.0),
            at(outer, top),
            at(inner, top),
        ]);
        // Across the board, from its end outwards.
        edge.normals = vec![dvec3(angle.sin(), 0.0, angle.cos()); 4];
        if is_first { edge } else { edge.inside_out() }
    };
    Mesh::union([bent, edge(start, true), edge(end, false)])
}

/// Radius and height, from the foot to the lip.
fn vase_profile() -> Vec<(f64, f64)> {
    (0..=64)
        .map(|i| {
            let h = f64::from(i) / 64.0;
            let radius =
                0.24 + 0.16 * (2.0 * PI * (h - 0.12)).sin() * (1.0 - 0.35 * h) + 0.08 * h.powi(8);
            (radius, 1.25 * h)
        })
        .collect()
}
