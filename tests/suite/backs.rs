//! Do all methods look through the same backs, and through no others?
//!
//! Where the camera looks through the backs of single-sided surfaces, it does so on the first
//! segment of a path, from whichever end that is walked; to all that comes after they are solid.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;
use neumann_core::film::{Features, Strategy, TechniqueImage};
use neumann_core::integrator::{METHODS, method};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{CancelToken, Renderer, hidden_by_backs};
use neumann_core::scene::builtin::BUILTINS;
use neumann_core::scene::description::{
    AlphaMode, CameraDescription, EnvironmentDescription, Lens, MaterialDescription,
    MeshDescription, Projection,
};
use neumann_core::scene::{Backs, Scene};
use neumann_tests::renders::{Setup, pool};
use neumann_tests::scenes::{Stage, ball, builtin, emitter, lambert, looking, rectangle, room};
use neumann_tests::statistics::Family;
use neumann_tests::studio::rough_glass;

use super::agreement::compare_methods;

/// The scene with backs that the camera looks through.
fn open(scene: &Arc<Scene>) -> Arc<Scene> {
    Arc::new(Scene::clone(scene).with_backs(Backs::SeeThrough))
}

fn moved(mut mesh: MeshDescription, by: Vec3) -> MeshDescription {
    for position in &mut mesh.positions {
        *position += by;
    }
    mesh
}

/// The same mesh with its front where its back was.
fn turned(mut mesh: MeshDescription) -> MeshDescription {
    for triangle in &mut mesh.triangles {
        triangle.swap(1, 2);
    }
    mesh
}

fn colored(color: [f32; 3]) -> MaterialDescription {
    MaterialDescription {
        base_color: Rgb::from(color),
        ..lambert(1.0)
    }
}

/// A room with a lamp, a ball and a veil, under a sky, from outside.
fn house() -> Stage {
    let mut stage = Stage::default();
    stage.add("walls", room(), colored([0.7, 0.6, 0.4]));
    let lamp = rectangle(Vec3::Y * 0.9, Vec3::X * 0.6, Vec3::Z * 0.6);
    stage.add("lamp", lamp, emitter(4.0));
    let at = Vec3::new(-0.3, -0.5, 0.2);
    stage.add("ball", moved(ball(0.45), at), colored([0.3, 0.5, 0.8]));
    let veil = MaterialDescription {
        alpha: 0.5,
        alpha_mode: AlphaMode::Blend,
        ..lambert(0.8)
    };
    // Its back is towards the camera.
    let up = Vec3::new(0.0, 0.4, 0.1);
    let hanging = rectangle(Vec3::new(0.5, -0.2, 0.5), Vec3::X * -0.4, up);
    stage.add("veil", hanging, veil);
    let sky = EnvironmentDescription::uniform(Rgb::new(0.2, 0.3, 0.5));
    stage.description.environment = Some(sky);
    stage.description.cameras = vec![looking(Vec3::new(0.9, 0.7, 2.3), Vec3::ZERO)];
    stage
}

/// The same through a lens that light meets by chance, off a glossy plate.
fn house_through_lens() -> Stage {
    let mut stage = house();
    stage.description.cameras[0].lens = Some(Lens {
        aperture: 1.2,
        focus_distance: 2.0,
    });
    let metal = MaterialDescription {
        roughness: 0.4,
        ..MaterialDescription::default()
    };
    // Half-way between the lens and the lamp.
    let normal = Vec3::new(0.15, 0.57, 0.81).normalize();
    let x = normal.any_orthonormal_vector() * 0.4;
    let plate = rectangle(Vec3::new(0.0, -0.1, -0.7), x, normal.cross(x));
    stage.add("plate", plate, metal);
    stage
}

/// A model in a hull that is turned inside out, on a floor that is lit from outside.
fn hull(is_unlit: bool) -> Stage {
    let mut stage = Stage::default();
    // Black, since light paths do not show what is unlit.
    let black = MaterialDescription {
        is_unlit: true,
        ..lambert(0.0)
    };
    let hull = if is_unlit {
        black
    } else {
        colored([0.2, 0.6, 0.3])
    };
    stage.add("hull", turned(ball(0.8)), hull);
    stage.add("model", ball(0.35), colored([0.8, 0.5, 0.4]));
    let within = rectangle(Vec3::Y * 0.65, Vec3::X * 0.3, Vec3::Z * 0.3);
    stage.add("lamp within", within, emitter(3.0));
    let floor = rectangle(Vec3::Y * -0.9, Vec3::Z * 2.0, Vec3::X * 2.0);
    stage.add("floor", floor, lambert(0.6));
    let above = rectangle(Vec3::Y * 1.8, Vec3::X * 0.8, Vec3::Z * 0.8);
    stage.add("lamp above", above, emitter(2.0));
    stage.description.cameras = vec![looking(Vec3::new(0.4, 0.3, 1.7), Vec3::ZERO)];
    stage
}

/// The house, lit by its lamp alone, with the camera in a block of rough glass that reaches in, all
/// of which is there or a part.
fn house_in_glass(alpha: f32) -> Stage {
    let mut stage = house();
    stage.description.environment = None;
    let mut block = turned(room());
    for position in &mut block.positions {
        *position = *position * Vec3::new(1.4, 1.3, 1.0) + Vec3::new(0.9, 0.7, 1.9);
    }
    let glass = MaterialDescription {
        alpha,
        alpha_mode: if alpha < 1.0 {
            AlphaMode::Blend
        } else {
            AlphaMode::Opaque
        },
        ..rough_glass()
    };
    stage.add("block", block, glass);
    let above = rectangle(Vec3::new(0.9, 2.4, 2.0), Vec3::X * 0.8, Vec3::Z * 0.8);
    stage.add("lamp above", above, emitter(4.0));
    stage
}

#[test]
fn all_methods_look_through_the_same_backs() {
    let mut family = Family::default();
    let mut n_scenes = BTreeMap::new();
    for (name, stage) in [
        ("house", house()),
        ("house through lens", house_through_lens()),
        ("hull", hull(false)),
        ("unlit hull", hull(true)),
        ("house in glass", house_in_glass(1.0)),
        ("house in glass in part", house_in_glass(0.7)),
    ] {
        let scene = open(&stage.scene());
        assert!(scene.sees_through_backs(), "{name}");
        compare_methods(&mut family, &mut n_scenes, name, &scene);
    }
    family.judge();
    assert!(family.len() > 500, "only {} comparisons", family.len());
    for (id, n) in n_scenes {
        assert!(n >= 3, "{id} was compared on {n} scenes only");
    }
}

/// Light runs into the lens through the same backs through which the lens is aimed at: either
/// technique by itself finds all of `T L_e`.
#[test]
fn light_runs_into_the_lens_through_backs() {
    let scene = open(&house_through_lens().scene());
    let bdpt = method("bdpt").expect("a method of the registry");
    let setup = Setup::new(&scene, 48, 32).by(bdpt).up_to(1);
    let mut renderer = Renderer::new(scene, setup.settings, pool(), 0);
    renderer.record_techniques(Some(4));
    for _ in 0..64 {
        let frame = renderer.iterate(&CancelToken::default());
        frame.expect("nobody cancels");
    }
    let techniques = renderer.techniques().expect("they were asked for");
    let found = |strategy: Strategy| {
        let image = techniques.image(strategy, TechniqueImage::Raw);
        image.iter().map(|c| f64::from(c.luminance())).sum::<f64>()
    };
    let (met, aimed_at) = (found(Strategy::lens(3)), found(Strategy::connect(2, 1)));
    let ratio = met / aimed_at;
    assert!((0.9..1.1).contains(&ratio), "{met} and {aimed_at}");
}

/// What is seen of a room through its walls is what is seen without the walls in the way: a camera
/// outside sees the lamp's front and the far walls, not the near ones nor the lamp's back.
#[test]
fn the_far_side_is_seen_and_the_near_one_is_not() {
    let mut stage = house();
    stage.description.environment = None;
    let (solid, through) = (stage.scene(), open(&stage.scene()));
    for &method in METHODS {
        let mean = |scene: &Arc<Scene>, layer: usize| {
            let setup = Setup::new(scene, 24, 16).by(method).with_many_photons();
            setup.film(0, 8).layer_means()[layer].iter().sum::<f64>()
        };
        if method.sight.shadows {
            assert_eq!(mean(&solid, 1), 0.0, "{}: walls are solid", method.id);
        }
        let seen = mean(&through, 1);
        assert!(seen > 0.03, "{}: {seen}", method.id);
    }
    let camera = &through.cameras()[0];
    let depth = |scene| Features::trace(scene, camera, 25, 17).depth[8 * 25 + 12];
    let [near, far] = [depth(&solid), depth(&through)];
    assert!(far > near + 0.5, "{near} m and {far} m");
}

/// An outline that is drawn, not built, leaves its model in the light.
#[test]
fn light_passes_hulls_that_are_unlit() {
    let [built, drawn] = [false, true].map(|is_unlit| {
        let mut stage = hull(is_unlit);
        // All light comes from outside.
        stage
            .description
            .instances
            .retain(|i| i.name != "lamp within");
        let scene = open(&stage.scene());
        let near = CameraDescription {
            projection: Projection::Perspective { yfov: 0.3 },
            ..looking(Vec3::new(0.4, 0.3, 1.7), Vec3::ZERO)
        };
        let film = Setup::seen_by(&scene, near, 16, 16).film(0, 8);
        film.layer_means()[1]
    });
    assert_eq!(built, [0.0; 3]);
    assert!(drawn.iter().all(|c| *c > 0.01), "{drawn:?}");
}

/// Nothing changes, to the bit, where no back is in sight, nor for a camera in a body of glass:
/// light passes its walls, seen from within or not.
#[test]
fn what_has_no_backs_stays_as_it_is() {
    let mut glass = Stage::default();
    glass.add("ball", ball(0.5), rough_glass());
    let floor = rectangle(Vec3::Y * -0.6, Vec3::Z * 2.0, Vec3::X * 2.0);
    glass.add("floor", floor, lambert(0.6));
    let lamp = rectangle(Vec3::Y * 1.5, Vec3::X * 0.8, Vec3::Z * 0.8);
    glass.add("lamp", lamp, emitter(4.0));
    glass.description.cameras = vec![looking(Vec3::Z * 0.2, Vec3::ZERO)];
    for scene in [builtin("cornell"), glass.scene()] {
        for &method in METHODS {
            let layers = |scene: &Arc<Scene>| {
                let film = Setup::new(scene, 16, 16).by(method).film(0, 2);
                film.layers().to_vec()
            };
            let (solid, through) = (layers(&scene), layers(&open(&scene)));
            assert!(solid == through, "{}, {}", scene.name(), method.id);
        }
    }
}

/// Somebody is told of backs that hide much, and nobody of others.
#[test]
fn backs_that_hide_much_are_told() {
    let hidden = |scene: &Scene, camera: &CameraDescription| hidden_by_backs(scene, camera);
    let first = |scene: &Arc<Scene>| hidden(scene, &scene.cameras()[0]);
    let house = house().scene();
    assert!(first(&house).is_some_and(|share| share > 0.9));
    assert_eq!(first(&open(&house)), None, "they are looked through");
    let inside = looking(Vec3::new(0.8, 0.8, 0.8), Vec3::ZERO);
    assert_eq!(hidden(&house, &inside), None);
    assert!(first(&hull(false).scene()).is_some_and(|share| share < 0.9));
    // Nothing stands behind.
    let mut plate = Stage::default();
    let back = rectangle(Vec3::ZERO, Vec3::Y, Vec3::X);
    plate.add("plate", back, lambert(0.5));
    plate.description.cameras = vec![looking(Vec3::Z, Vec3::ZERO)];
    assert_eq!(first(&plate.scene()), None);
    for entry in BUILTINS {
        assert_eq!(first(&builtin(entry.name)), None, "{}", entry.name);
    }
}
