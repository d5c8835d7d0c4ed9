//! Are layers of paths, and of lights, what they say?

use std::sync::Arc;

use glam::Vec3;
use neumann_core::expression::Expression;
use neumann_core::film::{ClassFilm, Film, LightGroup, PathClasses, View};
use neumann_core::integrator::{METHODS, method};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{CancelToken, Renderer};
use neumann_core::scene::Scene;
use neumann_core::scene::description::{EnvironmentDescription, LightKind, MaterialDescription};
use neumann_core::transport::Source;
use neumann_tests::renders::{Setup, pool};
use neumann_tests::scenes::{Stage, ball, builtin, emitter, lambert, looking, rectangle};
use neumann_tests::statistics::{Estimate, Family};
use neumann_tests::studio::studios;

/// Sets of kinds of which every path has exactly one.
const COMPLETE: [&[&str]; 3] = [
    &["L E", "L .* D E", "L .* G E", "L .* S E"],
    &["L [^S]* E", "L .* S .* E"],
    &["L R* E", "L .* T .* E"],
];

fn classes(scene: &Scene, expressions: &[&str]) -> PathClasses {
    let read = |text: &&str| Expression::new(text, scene).unwrap_or_else(|e| panic!("{e}"));
    PathClasses {
        expressions: expressions.iter().map(read).collect(),
        groups: LightGroup::parse(LightGroup::EACH, scene).expect("each can be had"),
    }
}

/// The first iterations, with their classes.
fn render(setup: &Setup, classes: PathClasses, n_iterations: u32) -> (Film, ClassFilm) {
    let s = &setup.settings;
    let mut film = Film::new(s.width, s.height, s.n_layers);
    let mut renderer = Renderer::new(Arc::clone(&setup.scene), s.clone(), pool(), 0);
    renderer.keep_classes(Some(Arc::new(classes)));
    for _ in 0..n_iterations {
        let iteration = renderer.iterate_after(&film, &CancelToken::default());
        iteration.expect("nobody cancels it").add_to(&mut film);
    }
    let classes = renderer.classes().expect("they are kept").clone();
    (film, classes)
}

fn assert_same(found: &[Rgb], expected: &[Rgb], what: &str) {
    for (pixel, (found, expected)) in found.iter().zip(expected).enumerate() {
        let apart = (*found - *expected).map(f32::abs).max_channel();
        let bound = 1e-5 * expected.max_channel();
        assert!(
            apart <= bound,
            "{what}, pixel {pixel}: {found:?} for {expected:?}"
        );
    }
}

fn sum(layers: impl Iterator<Item = Vec<Rgb>>) -> Vec<Rgb> {
    let add = |mut sum: Vec<Rgb>, layer: Vec<Rgb>| {
        sum.iter_mut()
            .zip(layer)
            .for_each(|(sum, value)| *sum += value);
        sum
    };
    layers.reduce(add).unwrap_or_default()
}

fn part(film: &Film, view: View) -> Vec<Rgb> {
    let mut pixels = vec![Rgb::BLACK; film.width() * film.height()];
    film.compose(view, &mut pixels);
    pixels
}

/// Scenes with every kind of lobe and of light.
fn scenes() -> Vec<(&'static str, Arc<Scene>)> {
    let mut scenes = vec![("cornell-glass", builtin("cornell-glass"))];
    scenes.extend(studios());
    scenes
}

/// Each contribution is in one of the classes, whole or shared out among them, by every technique
/// of every method; and in the layer of one light.
#[test]
fn complete_sets_add_up_to_the_film() {
    for (name, scene) in scenes() {
        for method in METHODS {
            let setup = Setup::new(&scene, 15, 11).by(method).up_to(6);
            let expressions: Vec<&str> = COMPLETE.iter().copied().flatten().copied().collect();
            let (film, classes) = render(&setup, classes(&scene, &expressions), 3);
            let total = part(&film, View::Total);
            let what = format!("{name}, {}", method.id);
            let mut first = 0;
            for set in COMPLETE {
                let layers = (first..first + set.len()).map(|i| classes.expression(i));
                assert_same(&sum(layers), &total, &format!("{what}, {set:?}"));
                first += set.len();
            }
            for view in [View::Total, View::Term(1), View::Upto(2), View::Tail] {
                let groups = (0..classes.n_groups()).filter_map(|g| classes.group(g, view));
                let what = format!("{what}, {view}, lights");
                assert_same(&sum(groups), &part(&film, view), &what);
            }
        }
    }
}

/// Looking changes no bit where paths add to their own pixels, and else only the order of sums.
#[test]
fn keeping_classes_changes_no_path() {
    let scene = builtin("cornell-glass");
    for method in METHODS {
        let setup = Setup::new(&scene, 24, 18).by(method).up_to(5);
        let mut with = setup.film(0, 0);
        let mut renderer = Renderer::new(Arc::clone(&scene), setup.settings.clone(), pool(), 0);
        let wanted = Arc::new(classes(&scene, &["L .* D E"]));
        // In the middle of a render, too.
        for kept in [None, Some(Arc::clone(&wanted)), Some(wanted), None] {
            renderer.keep_classes(kept);
            let iteration = renderer.iterate_after(&with, &CancelToken::default());
            iteration.expect("nobody cancels it").add_to(&mut with);
        }
        let without = setup.film(0, 4);
        for layer in 0..=with.n_layers() {
            let view = if layer < with.n_layers() {
                View::Term(layer)
            } else {
                View::Tail
            };
            assert_same(&part(&with, view), &part(&without, view), method.id);
        }
    }
}

/// A ball on a floor before a wall, under a large lamp.
fn stage(
    floor: MaterialDescription,
    wall: MaterialDescription,
    of_ball: MaterialDescription,
) -> Stage {
    let mut stage = Stage::default();
    let mesh = rectangle(Vec3::ZERO, Vec3::Z * 1.5, Vec3::X * 1.5);
    stage.add("floor", mesh, floor);
    let mesh = rectangle(Vec3::new(0.0, 1.0, -0.8), Vec3::X * 1.5, Vec3::Y);
    stage.add("wall", mesh, wall);
    let mut mesh = ball(0.4);
    for position in &mut mesh.positions {
        *position += Vec3::new(0.1, 0.5, 0.0);
    }
    stage.add("ball", mesh, of_ball);
    let mesh = rectangle(Vec3::new(0.0, 1.7, 0.3), Vec3::X * 0.8, Vec3::Z * 0.8);
    let lamp = MaterialDescription {
        name: "lamp".to_owned(),
        ..emitter(5.0)
    };
    stage.add("lamp", mesh, lamp);
    stage.description.cameras = vec![looking(Vec3::new(0.0, 0.8, 1.3), Vec3::Y * 0.4)];
    stage
}

fn plastic(base: f32) -> MaterialDescription {
    MaterialDescription {
        base_color: Rgb::splat(base),
        metallic: 0.0,
        roughness: 0.45,
        ..MaterialDescription::default()
    }
}

fn clear_glass() -> MaterialDescription {
    MaterialDescription {
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        ..MaterialDescription::default()
    }
}

/// Mean luminance, over independent renders, of what `of` picks of each.
fn estimate(
    scene: &Arc<Scene>,
    id: &str,
    expressions: &[&str],
    of: impl Fn(&Film, &ClassFilm) -> Vec<Rgb>,
) -> Estimate {
    const N_BATCHES: u64 = 20;
    let method = method(id).expect("it is in the registry");
    let stream = METHODS.iter().position(|m| *m == method).unwrap_or(0) as u64;
    let means: Vec<f64> = (0..N_BATCHES)
        .map(|batch| {
            let seed = (700 + stream) << 32 | batch;
            let setup = Setup::new(scene, 16, 12).by(method).up_to(5).seeded(seed);
            let (film, classes) = render(&setup, classes(scene, expressions), 8);
            let pixels = of(&film, &classes);
            let sum: f64 = pixels.iter().map(|p| f64::from(p.luminance())).sum();
            sum / pixels.len() as f64
        })
        .collect();
    Estimate::of(&means)
}

fn compare(family: &mut Family, what: &str, found: &Estimate, expected: &Estimate) {
    assert!(expected.mean > 0.0, "{what}: nothing to compare with");
    let ratio = found.mean / expected.mean;
    family.add(
        found.p_value_against(expected, 1e-5),
        format!("{what}: {found:?} against {expected:?}, ratio {ratio:.4}"),
    );
}

fn layer(i: usize) -> impl Fn(&Film, &ClassFilm) -> Vec<Rgb> {
    move |_, classes| classes.expression(i)
}

fn view(view: View) -> impl Fn(&Film, &ClassFilm) -> Vec<Rgb> {
    move |film, _| part(film, view)
}

const METHODS_OF_ALL_KINDS: [&str; 3] = ["pt-mis", "bdpt", "vcm"];

/// Classes are what renders of scenes show that have no other light, by hits, connections and
/// merges alike.
#[test]
fn classes_are_what_split_materials_show() {
    let mut family = Family::default();
    // Where the base is black, all light is that of the coat. Nothing else scatters.
    let coated = stage(plastic(0.6), lambert(0.0), lambert(0.0)).scene();
    let coat = stage(plastic(0.0), lambert(0.0), lambert(0.0)).scene();
    let of_coat = estimate(&coat, "pt-mis", &[], view(View::Term(1)));
    // No path by way of the ball is left where it absorbs all.
    let clear = stage(lambert(0.6), plastic(0.5), clear_glass()).scene();
    let dull = stage(lambert(0.6), plastic(0.5), lambert(0.0)).scene();
    let without_ball = estimate(&dull, "pt-mis", &[], view(View::Total));
    let kinds = ["L [DG]* E", "L S+ D E", "L D D E"];
    let by_hits = estimate(&clear, "pt-mis", &kinds, layer(1));
    let cornell = builtin("cornell");
    let two_bounces = estimate(&cornell, "pt-mis", &[], view(View::Term(2)));
    for id in METHODS_OF_ALL_KINDS {
        let found = estimate(&coated, id, &["L G E"], layer(0));
        compare(&mut family, &format!("{id}, L G E"), &found, &of_coat);
        let found = estimate(&clear, id, &kinds, layer(0));
        compare(
            &mut family,
            &format!("{id}, L [DG]* E"),
            &found,
            &without_ball,
        );
        if id != "pt-mis" {
            let found = estimate(&clear, id, &kinds, layer(1));
            compare(&mut family, &format!("{id}, L S+ D E"), &found, &by_hits);
        }
        let found = estimate(&cornell, id, &["L D D E"], layer(0));
        compare(&mut family, &format!("{id}, L D D E"), &found, &two_bounces);
    }
    family.judge();
}

/// The light of each source is what is there when all others are off.
#[test]
fn lights_are_what_they_show_alone() {
    let mut family = Family::default();
    let mut stage = stage(plastic(0.6), lambert(0.5), clear_glass());
    let blue = EnvironmentDescription::uniform(Rgb::new(0.1, 0.2, 0.4));
    stage.description.environment = Some(blue);
    for (kind, x) in [
        (
            LightKind::Point {
                intensity: Rgb::splat(2.0),
            },
            -0.7,
        ),
        (
            LightKind::Directional {
                irradiance: Rgb::splat(1.0),
            },
            0.5,
        ),
    ] {
        stage.light(kind, Vec3::new(x, 1.2, 0.6), Vec3::new(-x, -1.0, -0.5));
    }
    for (light, name) in stage.description.lights.iter_mut().zip(["bulb", "sun"]) {
        light.name = name.to_owned();
    }
    let scene = stage.scene();
    let groups = LightGroup::all(&scene);
    let names: Vec<&str> = groups.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(names, ["lamp", "bulb", "sun", "environment"]);
    for (number, group) in groups.iter().enumerate() {
        let mut appearance = scene.appearance().clone();
        let is_on = |source| group.sources.contains(&source);
        for (level, i) in appearance.material_levels.iter_mut().zip(0..) {
            level.is_on = is_on(Source::Material(i));
        }
        for (level, i) in appearance.light_levels.iter_mut().zip(0..) {
            level.is_on = is_on(Source::Punctual(i));
        }
        appearance.environment_level.is_on = is_on(Source::Environment);
        let alone = Arc::new(scene.with_appearance(appearance));
        let expected = estimate(&alone, "pt-mis", &[], view(View::Total));
        let expression = format!("L'{}' .* E", group.name);
        for id in METHODS_OF_ALL_KINDS {
            let of = |_: &Film, c: &ClassFilm| c.group(number, View::Total).expect("it is kept");
            let what = format!("{id}, {}", group.name);
            let found = estimate(&scene, id, &[], of);
            compare(&mut family, &what, &found, &expected);
            let by_expression = estimate(&scene, id, &[&expression], layer(0));
            let apart = (by_expression.mean / found.mean - 1.0).abs();
            assert!(apart < 1e-6, "{what}: {by_expression:?} for {found:?}");
        }
    }
    family.judge();
}

/// Turned to another colour, a light is what it would be rendered so.
#[test]
fn light_can_be_mixed_without_rendering_anew() {
    let scene = builtin("lamps");
    let setup = Setup::new(&scene, 15, 11).up_to(4);
    let (_, classes) = render(&setup, classes(&scene, &[]), 2);
    let n = classes.n_groups();
    assert!(n > 2, "{n}");
    let factor = Rgb::new(0.5, 0.0, 2.0);
    let mut factors = vec![Rgb::WHITE; n];
    factors[0] = factor;
    let part = View::Upto(2);
    let of = |group| classes.group(group, part).expect("it is kept");
    let first = of(0).iter().map(|value| *value * factor).collect();
    let expected = sum([first].into_iter().chain((1..n).map(of)));
    let mixed = classes.mixed(part, &factors).expect("it is kept");
    assert_same(&mixed, &expected, "mixed");
    assert!(classes.mixed(View::Term(99), &factors).is_none());
}
