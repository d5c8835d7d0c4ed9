//! A hall with three hundred lights of many colours and powers.
//!
//! Lanterns float between two rows of pillars; small panes glow in the floor.
//! Most light at any point comes from a few of the lights, and which few changes
//! from point to point: what choosing a light well is worth shows here.

use glam::{DVec3, dvec3};

use crate::material::{Material, Rgb};
use crate::mesh::Mesh;
use crate::revolve::Sweep;
use crate::scene::{Camera, Placement, Scene, Surface};

const N_LANTERNS: u32 = 260;
const N_PANES_PER_SIDE: u32 = 24;
/// Radii of the three sizes of lantern, metres.
const SIZES: [f64; 3] = [0.07, 0.125, 0.20];
/// Radiance of the three sizes, times the hue.
const BRIGHTNESS: [f64; 3] = [2.0, 2.8, 4.2];
/// From the front of the hall to its end.
const HUES: [(&str, Rgb); 6] = [
    ("amber", [1.0, 0.50, 0.13]),
    ("gold", [1.0, 0.68, 0.26]),
    ("coral", [1.0, 0.30, 0.17]),
    ("rose", [1.0, 0.24, 0.42]),
    ("violet", [0.50, 0.30, 1.0]),
    ("azure", [0.20, 0.55, 1.0]),
];

/// The hall.
pub(crate) fn many() -> Scene {
    let mut scene = Scene::new(
        "Three hundred lights: lanterns of many colours and powers among the pillars of a hall",
    );
    hall(&mut scene);
    lanterns(&mut scene);
    floor_panes(&mut scene);
    scene.camera(Camera {
        name: "Along the hall",
        eye: dvec3(0.55, 1.65, 4.6),
        target: dvec3(-0.15, 2.35, -6.0),
        field_of_view: 48.0,
        aspect_ratio: 1.6,
        aperture: 0.0,
    });
    scene
}

fn hall(scene: &mut Scene) {
    let plaster = scene.material(Material::lambert("plaster", [0.72, 0.70, 0.67]));
    let hall = Mesh::cuboid(dvec3(-4.8, 0.0, -17.0), dvec3(4.8, 5.6, 5.0)).inside_out();
    scene.add("hall", hall, plaster);
    let stone = scene.material(Material::lambert("stone", [0.55, 0.50, 0.44]));
    let profile = [
        (0.42, 0.0),
        (0.42, 0.22),
        (0.34, 0.30),
        (0.27, 0.36),
        (0.24, 4.7),
        (0.30, 4.8),
        (0.42, 5.1),
        (0.42, 5.6),
    ];
    let pillar = scene.geometry("pillar", Mesh::lathe(&profile, Sweep::full(40)));
    for i in 0..7_u32 {
        for (side, x) in [("left", -2.5), ("right", 2.5)] {
            let placement = Placement::at(dvec3(x, 0.0, 2.0 - 3.0 * f64::from(i)));
            scene.place(
                &format!("{side} pillar {}", i + 1),
                &[(pillar, stone)],
                placement,
            );
        }
    }
}

fn lanterns(scene: &mut Scene) {
    let barrel = [(0.62, -0.8), (0.95, -0.35), (0.95, 0.35), (0.62, 0.8)];
    let paper = scene.geometry("lantern paper", Mesh::lathe(&barrel, Sweep::full(8)));
    let caps = [(0.0, -0.86), (0.66, -0.86), (0.66, -0.78)];
    let lid = [(0.66, 0.78), (0.66, 0.86), (0.0, 0.86)];
    let caps = Mesh::union([caps, lid].map(|profile| Mesh::lathe(&profile, Sweep::full(8))));
    let caps = scene.geometry("lantern caps", caps);
    let lacquer = scene.material(Material::lambert("lacquer", [0.09, 0.07, 0.06]));
    let papers: Vec<[Surface; 3]> = HUES
        .iter()
        .map(|(name, hue)| {
            [0, 1, 2].map(|size| {
                let radiance = hue.map(|channel| channel * BRIGHTNESS[size]);
                let name = format!("{name} paper {}", size + 1);
                scene.material(Material::lambert(&name, [0.4; 3]).emitting(radiance))
            })
        })
        .collect();

    let spots = (0..)
        .map(spot)
        .filter(|&at| is_free(at))
        .take(N_LANTERNS as usize);
    for (i, at) in (0_u32..).zip(spots) {
        // Many small ones, few large ones.
        let size = [0, 0, 1, 0, 1, 2, 0, 1][i as usize % 8];
        // The hue follows the depth of the hall, with some disorder.
        let depth = (4.0 - at.z) / 20.5;
        let position = 5.0 * depth + 1.6 * (fraction(0.618_034 * f64::from(i)) - 0.5);
        let hue = (0..HUES.len() - 1)
            .take_while(|&h| position > 0.5 + f64::from(u8::try_from(h).unwrap_or(0)))
            .count();
        let placement = Placement::at(at).scaled(DVec3::splat(SIZES[size]));
        let parts = [(paper, papers[hue][size]), (caps, lacquer)];
        scene.place(&format!("lantern {}", i + 1), &parts, placement);
    }
}

/// Point i of a sequence that fills the upper hall evenly (additive recurrence
/// on the root of x^4 = x + 1).
fn spot(i: u32) -> DVec3 {
    let root = 1.220_744_084_605_759_5_f64;
    let coordinate = |power: i32| fraction(0.5 + f64::from(i) * root.powi(-power));
    dvec3(
        -4.4 + 8.8 * coordinate(1),
        2.15 + 3.2 * coordinate(2),
        -16.5 + 17.5 * coordinate(3),
    )
}

/// Clear of the pillars and of the view along the middle.
fn is_free(at: DVec3) -> bool {
    let pillar = 2.0 - 3.0 * ((2.0 - at.z) / 3.0).round();
    let from_pillar = dvec3(at.x.abs() - 2.5, 0.0, at.z - pillar).length();
    let from_axis = (at.x.abs() - 0.5).max(2.6 - at.y);
    from_pillar > 0.62 && (from_axis > 0.0 || at.z < -12.0)
}

/// Two rows of panes in the floor, along the pillars.
fn floor_panes(scene: &mut Scene) {
    let square = scene.geometry("square", Mesh::square_facing_down().inside_out());
    let cool = scene.material(Material::emitter("cool pane", [2.4, 3.3, 4.5]));
    let warm = scene.material(Material::emitter("warm pane", [5.0, 3.3, 1.7]));
    for i in 0..N_PANES_PER_SIDE {
        for (side, x) in [("left", -1.75), ("right", 1.75)] {
            let pane = if i % 3 == 1 { warm } else { cool };
            let placement = Placement::at(dvec3(x, 0.004, 2.0 - 0.75 * f64::from(i)));
            let placement = placement.scaled(dvec3(0.1, 1.0, 0.22));
            scene.place(
                &format!("{side} pane {}", i + 1),
                &[(square, pane)],
                placement,
            );
        }
    }
}

fn fraction(x: f64) -> f64 {
    x - x.floor()
}
