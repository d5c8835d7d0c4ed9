//! Do light paths and camera paths agree through bodies that nest, overlap and touch, and do both
//! ends of a segment say the same of what is between them?

use std::sync::Arc;

use glam::Vec3;

use neumann_core::endpoint::Camera;
use neumann_core::integrator::bidirectional::{Heuristic, MisWeights, Vertex, Walk};
use neumann_core::integrator::method;
use neumann_core::radiometry::Rgb;
use neumann_core::sampling::Sampler;
use neumann_core::scene::Scene;
use neumann_core::scene::description::{AlphaMode, Lens, LightKind, MaterialDescription};
use neumann_core::transport::Tracer;
use neumann_core::transport::reflection::start_sample;
use neumann_tests::renders::{Block, Setup};
use neumann_tests::scenes::{Stage, ball, emitter, lambert, looking, rectangle};
use neumann_tests::statistics::Family;

use super::{CLEAR, cuboid, glass, inside_out, moved};

/// Compares light paths and camera paths, layer by layer and block by block.
fn compare(name: &str, scene: &Arc<Scene>, methods: &[&str], max_bounces: u32) {
    let mut family = Family::default();
    let batches = |id: &str, n, stream| {
        Setup::new(scene, 18, 18)
            .by(method(id).expect("a method of the registry"))
            .up_to(max_bounces)
            .batches(24, n, stream)
    };
    let expected = batches("pt-mis", 64, 70);
    for (stream, id) in methods.iter().enumerate() {
        let found = batches(id, 48, 71 + stream as u64);
        assert_eq!(found.n_refused(), 0);
        for block in Block::grid(&expected.films[0], 2, 2) {
            for layer in 0..=max_bounces as usize {
                let (a, b) = (
                    found.block(block, layer)[1],
                    expected.block(block, layer)[1],
                );
                // Blocks that hardly any light reaches say nothing.
                let least = 0.01 * expected.layer(layer)[1].mean;
                let error = a.standard_error.max(b.standard_error);
                if b.mean <= least || error > 0.05 * b.mean {
                    continue;
                }
                let what = format!("{name}, {id}, T{layer}: {a:?} against {b:?}");
                family.add(a.p_value_against(&b, 1e-5), what);
            }
        }
    }
    let n = family.len();
    assert!(n >= 3 * methods.len(), "{name}: {n} comparisons");
    family.judge();
    // Methods that blur come close.
    for id in ["ppm", "vcm"] {
        let found = batches(id, 8, 80);
        for layer in 0..=max_bounces as usize {
            let [a, b] = [&found, &expected].map(|batches| batches.layer(layer)[1]);
            if b.mean > 0.01 {
                let error = (a.standard_error.hypot(b.standard_error) / b.mean).min(1.0);
                let ratio = a.mean / b.mean;
                assert!(
                    (ratio - 1.0).abs() < 0.03 + 5.0 * error,
                    "{name}, {id}, T{layer}: {ratio} ± {error}"
                );
            }
        }
    }
}

/// A floor, a large lamp above, and a camera between.
fn studio(eye: Vec3) -> Stage {
    let mut stage = Stage::default();
    let floor = rectangle(Vec3::ZERO, Vec3::Z * 2.0, Vec3::X * 2.0);
    stage.add("floor", floor, lambert(0.8));
    let lamp = rectangle(Vec3::Y * 3.0, Vec3::X * 2.0, Vec3::Z * 2.0);
    stage.add("lamp", lamp, emitter(1.0));
    stage.description.cameras = vec![looking(eye, Vec3::ZERO)];
    stage
}

#[test]
fn a_camera_under_water() {
    for roughness in [0.0, 0.4] {
        // From there, only the floor is seen.
        let mut stage = studio(Vec3::new(0.1, 0.9, 0.1));
        let water = cuboid(Vec3::new(-1.8, -0.2, -1.8), Vec3::new(1.8, 1.5, 1.8));
        stage.add("water", water, glass(1.33, roughness, 1.0));
        compare("water", &stage.scene(), &["pt-bsdf", "lt", "bdpt"], 4);
    }
}

/// Light paths run into the lens as well.
#[test]
fn a_wide_lens_under_water() {
    let mut stage = studio(Vec3::new(0.1, 0.9, 0.1));
    stage.description.cameras[0].lens = Some(Lens {
        aperture: 0.5,
        focus_distance: 0.9,
    });
    let water = cuboid(Vec3::new(-1.8, -0.2, -1.8), Vec3::new(1.8, 1.5, 1.8));
    stage.add("water", water, glass(1.33, 0.3, 0.5));
    let bead = moved(ball(0.15), Vec3::new(0.25, 0.5, 0.0));
    stage.add("bead", bead, glass(2.0, 0.6, CLEAR));
    compare("lens", &stage.scene(), &["pt-bsdf", "lt", "bdpt"], 3);
}

/// Bodies that light enters and leaves through holes, too.
#[test]
fn light_paths_through_walls_that_leak() {
    let leaky = MaterialDescription {
        alpha: 0.5,
        alpha_mode: AlphaMode::Blend,
        ..glass(1.4, 0.4, 0.3)
    };
    let mut stage = studio(Vec3::new(0.0, 1.3, 1.5));
    let block = cuboid(Vec3::new(-0.8, 0.1, -0.8), Vec3::new(0.8, 1.1, 0.8));
    stage.add("block", block, leaky);
    let center = Vec3::Y * 0.6;
    stage.add("ball", moved(ball(0.3), center), lambert(0.8));
    compare("leaky", &stage.scene(), &["pt-bsdf", "lt", "bdpt"], 4);
}

#[test]
fn a_lamp_in_a_tinted_ball() {
    for (roughness, is_point) in [(0.5, false), (0.0, false), (0.5, true)] {
        let mut stage = studio(Vec3::new(0.0, 1.2, 1.6));
        stage.description.materials[1] = lambert(0.5);
        let center = Vec3::Y * 0.9;
        stage.add("ball", moved(ball(0.7), center), glass(1.4, roughness, 0.5));
        if is_point {
            let intensity = Rgb::splat(1.0);
            stage.light(LightKind::Point { intensity }, center, Vec3::Y);
        } else {
            stage.add("bulb", moved(ball(0.5), center), emitter(3.0));
        }
        let methods: &[&str] = match (is_point, roughness > 0.0) {
            (true, _) => &["pt-nee", "lt", "bdpt"],
            (false, true) => &["pt-bsdf", "lt", "bdpt"],
            (false, false) => &["pt-bsdf", "bdpt"],
        };
        compare("lamp in a ball", &stage.scene(), methods, 4);
    }
}

#[test]
fn bodies_that_nest_overlap_and_touch() {
    let eye = Vec3::new(0.0, 1.3, 1.5);
    let block = || cuboid(Vec3::new(-0.8, 0.1, -0.8), Vec3::new(0.8, 1.1, 0.8));
    let center = Vec3::Y * 0.6;
    let methods = ["pt-bsdf", "lt", "bdpt"];

    let mut stage = studio(eye);
    stage.add("block", block(), glass(1.4, 0.4, 0.3));
    let clear = glass(1.6, 0.4, CLEAR);
    stage.add("ball", moved(ball(0.4), center), clear.clone());
    compare("nested", &stage.scene(), &methods, 5);

    let mut stage = studio(eye);
    stage.add("block", block(), glass(1.4, 0.4, 0.3));
    stage.add(
        "ball",
        moved(ball(0.5), center + Vec3::Y * 0.4),
        clear.clone(),
    );
    compare("overlapping", &stage.scene(), &methods, 5);

    let mut stage = studio(eye);
    stage.add("block", block(), glass(1.33, 0.4, 0.3));
    let lid = cuboid(Vec3::new(-0.8, 1.1, -0.8), Vec3::new(0.8, 1.3, 0.8));
    stage.add("lid", lid, clear);
    compare("touching", &stage.scene(), &methods, 5);

    let mut stage = studio(eye);
    let cavity = inside_out(moved(ball(0.4), center));
    stage.add("block", block(), glass(1.4, 0.4, 0.3));
    stage.add("cavity", cavity, glass(1.4, 0.3, 0.3));
    compare("bubble", &stage.scene(), &methods, 5);
}

/// The vertices of a subpath.
fn subpath<'a>(
    mut walk: Walk,
    tracer: &mut Tracer<'a>,
    sampler: &mut Sampler<'_>,
    weighing: &MisWeights,
) -> Vec<Vertex<'a>> {
    let mut vertices = Vec::new();
    while let Some(vertex) = walk.meet(tracer, weighing) {
        vertices.push(vertex);
        let u = sampler.bounce(walk.bounce());
        if vertices.len() == 8 || !walk.scatter(&vertex, tracer, &u, false, weighing) {
            break;
        }
    }
    vertices
}

/// What a segment between two vertices runs through is the same from either end.
#[test]
fn both_ends_agree_on_what_is_between() {
    let mut stage = studio(Vec3::new(0.0, 0.5, 0.6));
    let block = cuboid(Vec3::new(-0.8, 0.1, -0.8), Vec3::new(0.8, 1.1, 0.8));
    stage.add("block", block, glass(1.4, 0.4, 0.3));
    let center = Vec3::Y * 0.6;
    stage.add(
        "ball",
        moved(ball(0.4), center + Vec3::Y * 0.4),
        glass(1.6, 0.4, CLEAR),
    );
    let lid = cuboid(Vec3::new(-0.8, 1.1, -0.8), Vec3::new(0.8, 1.2, 0.8));
    stage.add("lid", lid, glass(1.5, 0.2, 0.2));
    stage.add("bulb", moved(ball(0.1), center), emitter(3.0));
    stage.add(
        "in it",
        moved(ball(0.05), center + Vec3::X * 0.5),
        lambert(0.5),
    );
    let scene = stage.scene();
    let camera = Camera::new(&scene.cameras()[0], 8, 8);
    let weighing = MisWeights::connections(Heuristic::Power, 1.0);
    let mut tracer = Tracer::new(&scene);
    let (mut n_in_vacuum, mut n_in_media, mut n_other) = (0, 0, 0);
    for i in 0..4000 {
        let mut sampler = Sampler::new(31, i, 0);
        let Some(start) = scene.lights().start(&start_sample(&sampler.start())) else {
            continue;
        };
        let walk = Walk::from_light(&start, &mut tracer, &weighing);
        let lights = subpath(walk, &mut tracer, &mut sampler, &weighing);
        let mut sampler = Sampler::new(32, i, 0);
        let u = sampler.start();
        let raster = u.film.map(|u| 8.0 * u).into();
        let walk = Walk::from_camera(&camera, raster, u.lens, &mut tracer, &weighing);
        for ours in subpath(walk, &mut tracer, &mut sampler, &weighing) {
            for theirs in &lights {
                let (from, to) = (&ours.surface, &theirs.surface);
                let apart = to.point.position - from.point.position;
                let distance = apart.length();
                if distance < 1e-3 {
                    continue;
                }
                let wi = apart / distance;
                // Along a wall, rounding tells on which side.
                if from.cos_g(wi) < 1e-3 || to.cos_g(wi) < 1e-3 {
                    continue;
                }
                let media = from.media_towards(wi, ours.media);
                let light = tracer.light_between(&from.point, &to.point, distance, media);
                let back_media = to.media_towards(-wi, theirs.media);
                let back = tracer.light_between(&to.point, &from.point, distance, back_media);
                let [light, back] = [light, back].map(|light| light.mean());
                if (light - back).abs() > 1e-4 {
                    n_other += 1;
                }
                if light > 0.0 {
                    if media.is_vacuum() {
                        n_in_vacuum += 1;
                    } else {
                        n_in_media += 1;
                    }
                }
            }
        }
    }
    assert!(
        n_in_vacuum > 1000 && n_in_media > 1000,
        "{n_in_vacuum}, {n_in_media}"
    );
    // A few go past an edge, where rounding tells.
    let n = n_in_vacuum + n_in_media;
    assert!(n_other * 2000 < n, "{n_other} of {n}");
}
