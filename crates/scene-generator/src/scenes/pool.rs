//! A tiled pool under rippled water: specular, diffuse, specular.
//!
//! Every path from the lamp to a tile goes down through the surface, and every
//! path from the tile to the camera up through it again. No technique that
//! connects two vertices finds such a path; density estimation does.

use glam::{DVec2, DVec3, dvec2, dvec3};

use crate::material::{Material, Rgb};
use crate::mesh::Mesh;
use crate::revolve::Sweep;
use crate::scene::{Camera, Placement, Scene};

/// Half the size of the basin along X and Z; its middle is at (0, 0, -1).
const HALF: DVec2 = dvec2(1.5, 2.0);
const CENTRE: DVec3 = dvec3(0.0, 0.0, -1.0);
const DEPTH: f64 = 1.25;
const WATER_LEVEL: f64 = -0.14;
const TILE: f64 = 0.25;

/// A pool in a hall.
pub(crate) fn pool() -> Scene {
    let mut scene = Scene::new(
        "The pool: tiles under rippled water, lit and seen through it; most methods fail here",
    );
    hall(&mut scene);
    tiles(&mut scene);

    let water = Material::glass("water", 1.33).attenuating([0.55, 0.87, 0.91], 3.0);
    let water = scene.material(water);
    // The edge of the sheet lies within the walls.
    let sheet = Mesh::sheet(HALF + 0.04, 128, ripples).moved(CENTRE + WATER_LEVEL * DVec3::Y);
    scene.add("water", sheet, water);

    swimming_ring(&mut scene);
    let coral = scene.material(Material::lambert("coral", [0.85, 0.22, 0.13]));
    let ball = scene.geometry("ball", Mesh::sphere(32));
    let placement = Placement::at(dvec3(0.62, 0.222 - DEPTH, -1.55)).scaled(DVec3::splat(0.22));
    scene.place("sunken ball", &[(ball, coral)], placement);

    // On the side of the camera, which does not see it mirrored by the water.
    let lamp = scene.material(Material::emitter("lamp", [1100.0, 1055.0, 960.0]));
    let square = scene.geometry("square", Mesh::square_facing_down());
    let placement = Placement::at(dvec3(-0.6, 3.79, 1.6)).scaled(dvec3(0.2, 1.0, 0.2));
    scene.place("lamp", &[(square, lamp)], placement);

    let above = Camera {
        name: "Above the edge",
        eye: dvec3(-1.3, 2.15, 2.75),
        target: dvec3(0.05, -0.6, -0.85),
        field_of_view: 38.0,
        aspect_ratio: 4.0 / 3.0,
        aperture: 0.0,
    };
    scene.camera(above);
    scene.camera(Camera {
        name: "Straight down",
        eye: dvec3(0.0, 3.5, -0.9),
        target: dvec3(0.0, 0.0, -1.0),
        field_of_view: 52.0,
        ..above
    });
    scene
}

/// Walls and ceiling, and the deck, whose blocks are also the basin's walls.
fn hall(scene: &mut Scene) {
    let plaster = scene.material(Material::lambert("plaster", [0.70, 0.69, 0.66]));
    let hall = Mesh::cuboid(dvec3(-3.5, -DEPTH - 0.2, -4.6), dvec3(3.5, 3.8, 3.4)).inside_out();
    scene.add("hall", hall, plaster);

    let (min, max) = (
        CENTRE - dvec3(HALF.x, 0.0, HALF.y),
        CENTRE + dvec3(HALF.x, 0.0, HALF.y),
    );
    let bottom = -DEPTH - 0.1;
    let frame = |outer_min: DVec3, outer_max: DVec3, low: f64, high: f64| {
        Mesh::union([
            Mesh::cuboid(
                dvec3(outer_min.x, low, outer_min.z),
                dvec3(min.x, high, outer_max.z),
            ),
            Mesh::cuboid(
                dvec3(max.x, low, outer_min.z),
                dvec3(outer_max.x, high, outer_max.z),
            ),
            Mesh::cuboid(dvec3(min.x, low, outer_min.z), dvec3(max.x, high, min.z)),
            Mesh::cuboid(dvec3(min.x, low, max.z), dvec3(max.x, high, outer_max.z)),
        ])
    };
    let stone = scene.material(Material::lambert("stone", [0.50, 0.47, 0.42]));
    let deck = frame(dvec3(-3.6, 0.0, -4.7), dvec3(3.6, 0.0, 3.5), bottom, 0.0);
    scene.add("deck", deck, stone);
    let coping = scene.material(Material::lambert("coping", [0.72, 0.70, 0.66]));
    let rim = dvec3(0.24, 0.0, 0.24);
    scene.add("coping", frame(min - rim, max + rim, -0.02, 0.03), coping);

    let grout = scene.material(Material::lambert("grout", [0.62, 0.63, 0.62]));
    let floor = Mesh::cuboid(dvec3(-2.0, bottom, -3.5), dvec3(2.0, -DEPTH, 1.5));
    scene.add("basin floor", floor, grout);
}

/// Tiles a hair in front of the grout, in one mesh for each colour.
fn tiles(scene: &mut Scene) {
    let paints: [(&str, Rgb); 3] = [
        ("white tiles", [0.80, 0.81, 0.79]),
        ("aqua tiles", [0.22, 0.58, 0.62]),
        ("blue tiles", [0.03, 0.14, 0.36]),
    ];
    let mut meshes = [const { Vec::new() }; 3];
    let (columns, rows) = (2.0 * HALF.x / TILE, 2.0 * HALF.y / TILE);
    let lift = 0.002;

    // The floor: a checkerboard, and a blue line one tile from its edge.
    for (i, j) in cells(columns, rows) {
        let from_edge = i.min(columns - 1.0 - i).min(j).min(rows - 1.0 - j);
        let colour = if from_edge == 1.0 {
            2
        } else {
            usize::from((i + j) % 2.0 == 0.0)
        };
        let corner = CENTRE + dvec3(i * TILE - HALF.x, lift - DEPTH, j * TILE - HALF.y);
        meshes[colour].push(tile(corner, DVec3::Z * TILE, DVec3::X * TILE));
    }
    // The walls: aqua and white courses below a blue band at the water line.
    let walls = [
        (dvec3(-1.0, 0.0, -1.0), DVec3::X, DVec3::Z, columns),
        (dvec3(1.0, 0.0, 1.0), DVec3::NEG_X, DVec3::NEG_Z, columns),
        (dvec3(-1.0, 0.0, 1.0), DVec3::NEG_Z, DVec3::X, rows),
        (dvec3(1.0, 0.0, -1.0), DVec3::Z, DVec3::NEG_X, rows),
    ];
    for (side, along, inwards, count) in walls {
        let start = CENTRE + side * dvec3(HALF.x, 0.0, HALF.y) + lift * inwards - DEPTH * DVec3::Y;
        for (i, j) in cells(count, DEPTH / TILE) {
            let colour = if j == 4.0 {
                2
            } else {
                usize::from((i + j) % 2.0 == 0.0)
            };
            let corner = start + along * (i * TILE) + DVec3::Y * (j * TILE);
            meshes[colour].push(tile(corner, along * TILE, DVec3::Y * TILE));
        }
    }
    for ((name, albedo), parts) in paints.into_iter().zip(meshes) {
        let surface = scene.material(Material::lambert(name, albedo));
        scene.add(name, Mesh::union(parts), surface);
    }
}

/// The integer points of a grid.
fn cells(columns: f64, rows: f64) -> impl Iterator<Item = (f64, f64)> {
    let count = |limit: f64| (0_u32..).map(f64::from).take_while(move |&i| i < limit);
    count(rows).flat_map(move |j| count(columns).map(move |i| (i, j)))
}

/// A square with grout left free around it, facing `right` x `up`.
fn tile(corner: DVec3, right: DVec3, up: DVec3) -> Mesh {
    let (near, far) = (0.025, 0.975);
    let corners = [[near, near], [far, near], [far, far], [near, far]];
    Mesh::quad(corners.map(|[u, v]| corner + u * right + v * up))
}

/// Height and normal of the water at (x, z): ten plane waves in directions
/// spread by the golden angle.
fn ripples(x: f64, z: f64) -> (f64, DVec3) {
    let (mut height, mut slope) = (0.0, DVec2::ZERO);
    for i in 0..10_u32 {
        let direction = DVec2::from_angle(2.4 * f64::from(i) + 0.3);
        let wave_number = 7.5 * 1.14_f64.powi(i32::try_from(i).unwrap_or(0));
        let amplitude = 0.0115 * (7.5 / wave_number).powf(1.4);
        let phase = wave_number * direction.dot(dvec2(x, z)) + 1.7 * f64::from(i * i);
        height += amplitude * phase.sin();
        slope += amplitude * wave_number * phase.cos() * direction;
    }
    (height, dvec3(-slope.x, 1.0, -slope.y).normalize())
}

/// A striped ring, half in the water.
fn swimming_ring(scene: &mut Scene) {
    let white = scene.material(Material::lambert("white rubber", [0.82, 0.80, 0.77]));
    let red = scene.material(Material::lambert("red rubber", [0.75, 0.06, 0.05]));
    let sector = |first: u32| {
        Mesh::union((0..4).map(|i| {
            let start = std::f64::consts::FRAC_PI_4 * f64::from(2 * i + first);
            Mesh::torus(
                0.34,
                0.1,
                24,
                Sweep::arc(start, start + std::f64::consts::FRAC_PI_4, 10),
            )
        }))
    };
    let even = scene.geometry("even sectors", sector(0));
    let odd = scene.geometry("odd sectors", sector(1));
    let placement = Placement::at(dvec3(-0.62, WATER_LEVEL + 0.03, -1.25));
    scene.place("swimming ring", &[(even, white), (odd, red)], placement);
}
