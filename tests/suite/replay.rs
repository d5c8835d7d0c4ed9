//! Do replayed paths make the pixel?
//!
//! For every row of `METHODS`: what an iteration's paths bring to a pixel, replayed one by one,
//! adds up to what the iteration has there, bounce by bounce; and the paths are possible ones.

use std::sync::Arc;

use neumann_core::endpoint::SurfacePoint;
use neumann_core::film::Joint;
use neumann_core::integrator::{METHODS, Value, method};
use neumann_core::material::Material;
use neumann_core::radiometry::Rgb;
use neumann_core::render::{CancelToken, PathId, Renderer, Replayed};
use neumann_core::scene::Scene;
use neumann_core::transport::{PathVertex, Tracer, VertexKind};
use neumann_tests::random::Random;
use neumann_tests::renders::{Setup, pool};
use neumann_tests::scenes::builtin;

const WIDTH: usize = 41;
const HEIGHT: usize = 35;
/// Late enough for adaptive sampling to have measured.
const ITERATION: u32 = 5;

/// Every method with its default parameters, and those that sample or keep maps in other ways.
fn ways(scene: &Arc<Scene>) -> Vec<(String, Setup)> {
    let setup = Setup::new(scene, WIDTH, HEIGHT).up_to(10);
    let mut ways: Vec<_> = METHODS
        .iter()
        .map(|method| (method.id.to_owned(), setup.clone().by(method)))
        .collect();
    for (id, name, value) in [
        ("pt-mis", "adaptive", Value::Switch(true)),
        ("drt", "lens-samples", Value::Integer(3)),
        ("pm", "gather", Value::Integer(2)),
    ] {
        let Some(method) = method(id) else { continue };
        let mut way = setup.clone().by(method);
        if way.settings.values.value(name).is_some() {
            way.settings.values.put(name, value);
            ways.push((format!("{id}, {name}"), way));
        }
    }
    // Few photons need a wide radius to be found at all.
    for (_, way) in &mut ways {
        if way.settings.values.value("radius").is_some() {
            way.settings.values.put("radius", Value::Real(0.05));
        }
    }
    ways
}

/// A third of a thousand pixels.
fn pixels(stream: u64) -> Vec<[u32; 2]> {
    let mut random = Random::new(stream);
    let mut pixels: Vec<[u32; 2]> = (0..334)
        .map(|_| {
            let [x, y] = random.pair();
            [(x * WIDTH as f32) as u32, (y * HEIGHT as f32) as u32]
        })
        .collect();
    pixels.sort_unstable();
    pixels.dedup();
    pixels
}

/// What is added to each layer.
fn sums(replayed: &[Replayed], n_layers: usize) -> Vec<Rgb> {
    let mut sums = vec![Rgb::BLACK; n_layers + 1];
    for path in replayed {
        sums[(path.contribution.bounce as usize).min(n_layers)] += path.value();
    }
    sums
}

#[test]
fn replayed_paths_add_up_to_the_pixel() {
    for (stream, name) in ["cornell-glass", "sky", "pool"].into_iter().enumerate() {
        let scene = builtin(name);
        let pixels = pixels(70 + stream as u64);
        for (id, setup) in ways(&scene) {
            let film = setup.film(ITERATION, 1);
            let settings = setup.settings.clone();
            let n_layers = settings.n_layers;
            let method = settings.method;
            let adds_alone = (method.build)(&settings.values).adds_to_own_pixels();
            let renderer = Renderer::new(Arc::clone(&scene), settings, pool(), 0);
            let replayed = renderer.replay(ITERATION, &pixels, &CancelToken::default());
            let mut n_paths = 0;
            for (pixel, replayed) in pixels.iter().zip(replayed.unwrap()) {
                let index = pixel[1] as usize * WIDTH + pixel[0] as usize;
                n_paths += replayed.len();
                for (k, sum) in sums(&replayed, n_layers).into_iter().enumerate() {
                    let value = film.layer_at(k, index);
                    let apart = (sum - value).map(f32::abs).max_channel();
                    let bound = if adds_alone { 0.0 } else { 1e-5 };
                    assert!(
                        apart <= bound * value.max_channel(),
                        "{name}, {id}, {pixel:?}, bounce {k}: {sum:?} for {value:?}"
                    );
                }
                for path in &replayed {
                    check(&scene, path, &format!("{name}, {id}, {pixel:?}"));
                }
            }
            assert!(n_paths > 0, "{name}, {id}: no path");
        }
    }
}

/// A path has as many vertices as its technique says, each of its segments is open, and its
/// throughput is the product of its factors.
fn check(scene: &Scene, path: &Replayed, what: &str) {
    let strategy = path.contribution.strategy;
    let what = format!("{what}: {path:#?}");
    assert_eq!(path.camera.len(), usize::from(strategy.t), "{what}");
    assert_eq!(path.light.len(), usize::from(strategy.s), "{what}");
    if let Some(first) = path.camera.first() {
        assert_eq!(first.kind, VertexKind::Lens, "{what}");
    }
    if let Some(first) = path.light.first() {
        assert!(
            matches!(first.kind, VertexKind::Light | VertexKind::FarLight),
            "{what}"
        );
    }
    // Who walked which part is known.
    assert_eq!(
        matches!(path.camera_path, Some(PathId::Camera { .. })),
        strategy.t > 1,
        "{what}"
    );
    let is_light_walked = strategy.s > 1 || strategy.t <= 1;
    assert_eq!(path.light_path.is_some(), is_light_walked, "{what}");
    for part in [&path.camera, &path.light] {
        for pair in part.windows(2) {
            check_segment(scene, &pair[0], &pair[1], &what);
        }
    }
    if strategy.joint == Joint::Merge {
        let ends = path.camera.last().zip(path.light.last());
        let apart = ends.map(|(a, b)| a.position.distance(b.position));
        let radius = 0.1 * scene.lights().bounds().radius;
        assert!(apart.is_some_and(|apart| apart < radius), "{what}");
    }
}

/// The second vertex follows from the first.
fn check_segment(scene: &Scene, from: &PathVertex, to: &PathVertex, what: &str) {
    let is_near = |vertex: &PathVertex| vertex.kind != VertexKind::FarLight;
    if from.kind == VertexKind::Surface && to.kind == VertexKind::Surface {
        let towards = (to.position - from.position).normalize_or_zero();
        let event = from.event.unwrap_or_else(|| panic!("no event: {what}"));
        let reach = from.position.length().max(to.position.length());
        let apart = from.position.distance(to.position);
        // Very short segments are not told from rounding.
        if apart > 1e-3 * reach {
            assert!(event.wi.dot(towards) > 1.0 - 1e-4, "another way: {what}");
        }
        let point = |vertex: &PathVertex| SurfacePoint {
            position: vertex.position,
            triangle: vertex.triangle.unwrap_or_default(),
            ng: vertex.ng,
        };
        let visibility = Tracer::new(scene).visibility_between(&point(from), &point(to));
        assert!(visibility > 0.0, "something is in between: {what}");
        let n = from.n_paths as f32;
        let factor = event.f_cos / (event.pdf_w * event.survival * n);
        check_throughput(scene, from.throughput * factor, to.throughput, what);
    } else if is_near(from) && to.kind == VertexKind::Surface {
        let expected = from.throughput / from.n_paths as f32;
        check_throughput(scene, expected, to.throughput, what);
    }
}

/// Media may have absorbed some.
fn check_throughput(scene: &Scene, expected: Rgb, found: Rgb, what: &str) {
    let over = (found - expected * 1.0001).max_channel();
    assert!(
        over <= 1e-6 * expected.max_channel(),
        "{expected:?}: {what}"
    );
    let absorbs = |m: &Material| m.absorption().is_some();
    if !scene.materials().iter().any(absorbs) {
        let under = (expected * 0.9999 - found).max_channel();
        assert!(
            under <= 1e-6 * expected.max_channel(),
            "{expected:?}: {what}"
        );
    }
}
