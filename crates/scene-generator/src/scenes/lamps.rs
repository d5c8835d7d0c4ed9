//! A room at night whose lamps hide their bulbs.
//!
//! Four small bulbs deep in opaque shades: from most of the room no shadow ray
//! reaches one, and what lights the room are small bright patches on ceiling and
//! walls that a path from the camera meets by luck. Paths from the bulbs fill
//! the patches at once, so bidirectional methods win clearly
//! ([Veach 1997], figure 10.3, has the like).

use glam::{DVec3, dvec3};

use crate::material::Material;
use crate::mesh::Mesh;
use crate::revolve::Sweep;
use crate::scene::{Camera, Part, Placement, Scene, Surface};

const BULB_RADIUS: f64 = 0.025;

/// A living room.
pub(crate) fn lamps() -> Scene {
    let mut scene = Scene::new(
        "Hidden lamps: bulbs deep in their shades light the room by way of ceiling and walls",
    );
    room(&mut scene);
    let wood = scene.material(Material::lambert("walnut", [0.34, 0.17, 0.085]));
    furniture(&mut scene, wood);
    lighting(&mut scene);
    scene.camera(Camera {
        name: "From the door",
        eye: dvec3(1.15, 1.5, 2.75),
        target: dvec3(-0.1, 1.12, -1.2),
        field_of_view: 46.0,
        aspect_ratio: 1.5,
        aperture: 0.0,
    });
    scene
}

fn room(scene: &mut Scene) {
    let wall = scene.material(Material::lambert("wall", [0.72, 0.70, 0.66]));
    let room = Mesh::cuboid(dvec3(-2.9, 0.0, -2.4), dvec3(2.9, 2.6, 2.9)).inside_out();
    scene.add("room", room, wall);
    let boards = scene.material(Material::lambert("floor boards", [0.42, 0.27, 0.16]));
    let planks = (0..29).map(|i| {
        let x = -2.9 + 0.2 * f64::from(i);
        Mesh::cuboid(dvec3(x + 0.002, 0.0, -2.4), dvec3(x + 0.198, 0.012, 2.9))
    });
    scene.add("floor boards", Mesh::union(planks), boards);
    let rug = scene.material(Material::lambert("rug", [0.16, 0.22, 0.30]));
    let mesh = Mesh::lathe(
        &[(1.35, 0.012), (1.34, 0.025), (0.0, 0.025)],
        Sweep::full(96),
    );
    scene.add("rug", mesh.moved(dvec3(0.1, 0.0, -0.25)), rug);
}

fn furniture(scene: &mut Scene, wood: Surface) {
    // A round table on one leg, and a bowl on it.
    let table = [
        (0.26, 0.025),
        (0.26, 0.05),
        (0.04, 0.06),
        (0.04, 0.68),
        (0.58, 0.70),
        (0.58, 0.735),
        (0.0, 0.735),
    ];
    let table = Mesh::lathe(&table, Sweep::full(64)).moved(dvec3(0.2, 0.0, -0.4));
    scene.add("table", table, wood);
    let clay = scene.material(Material::lambert("celadon", [0.42, 0.58, 0.47]));
    let bowl: Vec<_> = (0..=16)
        .map(|i| {
            let h = f64::from(i) / 16.0;
            (0.05 + 0.12 * h.sqrt(), 0.735 + 0.09 * h)
        })
        .collect();
    scene.add(
        "bowl",
        Mesh::smooth_lathe(&bowl, Sweep::full(48)).moved(dvec3(0.2, 0.0, -0.4)),
        clay,
    );

    let chair = scene.geometry("chair", chair());
    for (name, x, z, heading) in [
        ("left chair", -0.65, -0.35, 1.45),
        ("right chair", 1.0, -0.75, -1.1),
    ] {
        let placement =
            Placement::at(dvec3(x, 0.025, z)).turned(glam::DQuat::from_rotation_y(heading));
        scene.place(name, &[(chair, wood)], placement);
    }

    // A sideboard against the back wall, with a vase, and a picture above.
    let oak = scene.material(Material::lambert("oak", [0.50, 0.33, 0.19]));
    let sideboard = Mesh::union([
        Mesh::cuboid(dvec3(-1.0, 0.16, -2.38), dvec3(0.9, 0.72, -1.96)),
        Mesh::cuboid(dvec3(-1.03, 0.72, -2.39), dvec3(0.93, 0.75, -1.94)),
        Mesh::cuboid(dvec3(-0.98, 0.19, -1.96), dvec3(-0.37, 0.70, -1.945)),
        Mesh::cuboid(dvec3(-0.355, 0.19, -1.96), dvec3(0.255, 0.70, -1.945)),
        Mesh::cuboid(dvec3(0.27, 0.19, -1.96), dvec3(0.88, 0.70, -1.945)),
        Mesh::cuboid(dvec3(-0.92, 0.0, -2.3), dvec3(-0.87, 0.16, -2.02)),
        Mesh::cuboid(dvec3(0.77, 0.0, -2.3), dvec3(0.82, 0.16, -2.02)),
    ]);
    scene.add("sideboard", sideboard, oak);
    let vase: Vec<_> = (0..=32)
        .map(|i| {
            let h = f64::from(i) / 32.0;
            (
                0.05 + 0.055 * (3.0 * h + 0.2).sin().powi(2) + 0.01 * h,
                0.75 + 0.34 * h,
            )
        })
        .collect();
    scene.add(
        "vase",
        Mesh::smooth_lathe(&vase, Sweep::full(48)).moved(dvec3(0.55, 0.0, -2.15)),
        clay,
    );

    let frame = Mesh::cuboid(dvec3(-0.55, 1.2, -2.4), dvec3(0.45, 1.95, -2.37));
    scene.add("picture frame", frame, wood);
    let paints = [
        ("picture sky", [0.62, 0.42, 0.22], -0.51, 1.58, 0.41, 1.91),
        ("picture sea", [0.10, 0.22, 0.30], -0.51, 1.24, 0.41, 1.58),
    ];
    for (name, albedo, left, bottom, right, top) in paints {
        let paint = scene.material(Material::lambert(name, albedo));
        scene.add(
            name,
            Mesh::cuboid(dvec3(left, bottom, -2.37), dvec3(right, top, -2.365)),
            paint,
        );
    }

    sofa(scene, wood);
}

fn sofa(scene: &mut Scene, wood: Surface) {
    let cloth = scene.material(Material::lambert("sofa cloth", [0.55, 0.20, 0.12]));
    let sofa = Mesh::union([
        Mesh::cuboid(dvec3(-2.75, 0.12, -1.3), dvec3(-1.95, 0.34, 0.5)),
        Mesh::cuboid(dvec3(-2.55, 0.34, -1.14), dvec3(-1.93, 0.46, -0.41)),
        Mesh::cuboid(dvec3(-2.55, 0.34, -0.39), dvec3(-1.93, 0.46, 0.34)),
        Mesh::cuboid(dvec3(-2.78, 0.30, -1.16), dvec3(-2.55, 0.82, 0.36)),
        Mesh::cuboid(dvec3(-2.78, 0.12, -1.32), dvec3(-1.93, 0.60, -1.16)),
        Mesh::cuboid(dvec3(-2.78, 0.12, 0.36), dvec3(-1.93, 0.60, 0.52)),
    ]);
    scene.add("sofa", sofa, cloth);
    let side_table = [
        (0.16, 0.012),
        (0.16, 0.03),
        (0.02, 0.04),
        (0.02, 0.50),
        (0.24, 0.51),
        (0.24, 0.53),
        (0.0, 0.53),
    ];
    let side_table = Mesh::lathe(&side_table, Sweep::full(48));
    scene.add(
        "side table",
        side_table.moved(dvec3(-2.35, 0.0, -1.75)),
        wood,
    );
}

/// Facing +Z, standing on the ground.
fn chair() -> Mesh {
    let leg =
        |x: f64, z: f64, top: f64| Mesh::cuboid(dvec3(x, 0.0, z), dvec3(x + 0.035, top, z + 0.035));
    Mesh::union([
        Mesh::cuboid(dvec3(-0.22, 0.43, -0.21), dvec3(0.22, 0.46, 0.22)),
        leg(-0.21, 0.175, 0.43),
        leg(0.175, 0.175, 0.43),
        leg(-0.21, -0.21, 0.88),
        leg(0.175, -0.21, 0.88),
        Mesh::cuboid(dvec3(-0.175, 0.66, -0.205), dvec3(0.175, 0.86, -0.185)),
    ])
}

/// A torchiere, two sconces and a table lamp: each a shade and a hidden bulb.
fn lighting(scene: &mut Scene) {
    let brass = scene.material(Material::lambert("brass paint", [0.52, 0.40, 0.20]));
    let shade = scene.material(Material::lambert("shade", [0.70, 0.66, 0.58]));
    let bulb = scene.geometry("bulb", Mesh::sphere(12));
    let bulb_part = |scene: &mut Scene, name: &str, radiance: [f64; 3]| -> Part {
        (bulb, scene.material(Material::emitter(name, radiance)))
    };
    let place_bulb = |scene: &mut Scene, name: &str, part: Part, at: DVec3| {
        scene.place(
            name,
            &[part],
            Placement::at(at).scaled(DVec3::splat(BULB_RADIUS)),
        );
    };

    // The torchiere's cup is closed below: all its light goes to the ceiling.
    let foot = [(0.16, 0.012), (0.15, 0.035), (0.015, 0.045), (0.015, 1.60)];
    let cup = [
        (0.015, 1.60),
        (0.075, 1.62),
        (0.125, 1.95),
        (0.118, 1.95),
        (0.068, 1.63),
        (0.0, 1.62),
    ];
    let foot = scene.geometry("foot", Mesh::lathe(&foot, Sweep::full(48)));
    let cup = scene.geometry("cup", Mesh::lathe(&cup, Sweep::full(48)));
    let corner = dvec3(2.15, 0.0, -1.75);
    scene.place(
        "torchiere",
        &[(foot, brass), (cup, shade)],
        Placement::at(corner),
    );
    let warm = bulb_part(scene, "torchiere bulb", [5600.0, 4800.0, 3900.0]);
    place_bulb(scene, "torchiere bulb", warm, corner + 1.67 * DVec3::Y);

    // The sconces are open above and below and wash the wall.
    let tube = Mesh::lathe(
        &[
            (0.062, -0.17),
            (0.062, 0.17),
            (0.056, 0.17),
            (0.056, -0.17),
            (0.062, -0.17),
        ],
        Sweep::full(48),
    );
    let bracket = Mesh::cuboid(dvec3(-0.015, -0.03, -0.10), dvec3(0.015, 0.03, -0.06));
    let tube = scene.geometry("tube", tube);
    let bracket = scene.geometry("bracket", bracket);
    let amber = bulb_part(scene, "sconce bulb", [5600.0, 4500.0, 3250.0]);
    for (side, x) in [("left", -1.3), ("right", 1.2)] {
        let at = dvec3(x, 1.62, -2.3);
        scene.place(
            &format!("{side} sconce"),
            &[(tube, brass), (bracket, brass)],
            Placement::at(at),
        );
        place_bulb(scene, &format!("{side} sconce bulb"), amber, at);
    }

    // The table lamp's shade is an opaque cone, wider below.
    let base = [(0.075, 0.53), (0.075, 0.545), (0.012, 0.56), (0.012, 0.74)];
    let base = scene.geometry("base", Mesh::lathe(&base, Sweep::full(48)));
    let cone = [
        (0.15, 0.76),
        (0.085, 1.02),
        (0.080, 1.02),
        (0.145, 0.76),
        (0.15, 0.76),
    ];
    let cone = scene.geometry("cone", Mesh::lathe(&cone, Sweep::full(48)));
    let stand = dvec3(-2.35, 0.0, -1.75);
    scene.place(
        "table lamp",
        &[(base, brass), (cone, shade)],
        Placement::at(stand),
    );
    let soft = bulb_part(scene, "table lamp bulb", [3400.0, 2750.0, 2000.0]);
    place_bulb(scene, "table lamp bulb", soft, stand + 0.90 * DVec3::Y);
}
