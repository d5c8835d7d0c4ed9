//! Is what an inspected pixel is taken apart into what the film has there?

use std::collections::HashMap;
use std::sync::Arc;

use neumann_core::expression::{Expression, PRESETS};
use neumann_core::film::TechniqueImage;
use neumann_core::integrator::{METHODS, Method};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{CancelToken, Inspection, Renderer};
use neumann_core::scene::Scene;
use neumann_core::transport::Lobe;
use neumann_tests::random::Random;
use neumann_tests::renders::{Setup, pool};
use neumann_tests::scenes::builtin;

const WIDTH: usize = 37;
const HEIGHT: usize = 31;
const N_ITERATIONS: u32 = 3;

fn setup(scene: &Arc<Scene>, method: &'static Method) -> Setup {
    Setup::new(scene, WIDTH, HEIGHT).by(method).up_to(8)
}

/// A quarter of a thousand pixels.
fn pixels(stream: u64) -> Vec<[u32; 2]> {
    let mut random = Random::new(stream);
    let mut pixel = || random.pair();
    let pixels = (0..250).map(|_| {
        let [x, y] = pixel();
        [(x * WIDTH as f32) as u32, (y * HEIGHT as f32) as u32]
    });
    pixels.collect()
}

/// The first iterations of some pixels.
fn inspect(setup: &Setup, scene: &Arc<Scene>, pixels: &[[u32; 2]]) -> Vec<Inspection> {
    inspect_first(N_ITERATIONS, setup, scene, pixels)
}

fn inspect_first(
    n_iterations: u32,
    setup: &Setup,
    scene: &Arc<Scene>,
    pixels: &[[u32; 2]],
) -> Vec<Inspection> {
    let renderer = Renderer::new(Arc::clone(scene), setup.settings.clone(), pool(), 0);
    let mut inspected = vec![Inspection::default(); pixels.len()];
    for iteration in 0..n_iterations {
        let replayed = renderer.replay(iteration, pixels, &CancelToken::default());
        for (inspected, replayed) in inspected
            .iter_mut()
            .zip(replayed.expect("nobody cancels it"))
        {
            for path in &replayed {
                let (n, k) = (path.bounces().len(), path.contribution.bounce);
                assert_eq!(n, k as usize, "{path:#?}");
            }
            inspected.add(iteration, replayed);
        }
    }
    inspected
}

fn assert_near(found: Rgb, expected: Rgb, what: &str) {
    let apart = (found - expected).map(f32::abs).max_channel();
    let bound = 1e-5 * expected.max_channel();
    assert!(apart <= bound, "{what}: {found:?} for {expected:?}");
}

#[test]
fn sums_are_those_of_the_film() {
    for (stream, name) in ["cornell", "cornell-glass", "sky", "pool"]
        .into_iter()
        .enumerate()
    {
        let scene = builtin(name);
        let pixels = pixels(90 + stream as u64);
        for method in METHODS {
            let setup = setup(&scene, method);
            let settings = setup.settings.clone();
            let film = setup.film(0, N_ITERATIONS);
            let mut renderer = Renderer::new(Arc::clone(&scene), settings, pool(), 0);
            renderer.record_techniques(Some(1));
            for _ in 0..N_ITERATIONS {
                renderer
                    .iterate(&CancelToken::default())
                    .expect("nobody cancels it");
            }
            let techniques = renderer.techniques().expect("they are recorded");
            let mut images = HashMap::new();
            let mut n_paths = 0;
            for (pixel, inspected) in pixels.iter().zip(inspect(&setup, &scene, &pixels)) {
                let what = format!("{name}, {}, {pixel:?}", method.id);
                let index = pixel[1] as usize * WIDTH + pixel[0] as usize;
                n_paths += inspected.n_paths();
                let mut layers = vec![Rgb::BLACK; film.n_layers() + 1];
                for (k, of) in inspected.bounces().enumerate() {
                    layers[k.min(film.n_layers())] += of.mean;
                }
                for (k, layer) in layers.into_iter().enumerate() {
                    assert_near(layer, film.layer_at(k, index), &format!("{what}, T{k}"));
                }
                for (strategy, of) in inspected.techniques() {
                    if method.has_techniques && (strategy.bounce() as usize) < film.n_layers() {
                        let image = || techniques.image(strategy, TechniqueImage::Weighted);
                        let image = images.entry(strategy).or_insert_with(image);
                        assert_near(of.mean, image[index], &format!("{what}, {strategy:?}"));
                    }
                }
                let n_values: u32 = inspected.samples().map(|bin| bin.n).sum();
                assert_eq!(n_values + inspected.n_zeros(), N_ITERATIONS, "{what}");
                let of_ways: f64 = inspected.ways().iter().map(|way| way.luminance).sum();
                let total = f64::from(inspected.total().mean.luminance());
                assert!((of_ways - total).abs() <= 1e-5 * total, "{what}: ways");
            }
            assert!(n_paths > 0, "{name}, {}: no path", method.id);
        }
    }
}

/// Expressions of which every path fits one add up to the pixel.
#[test]
fn kinds_of_paths_add_up() {
    let scene = builtin("cornell-glass");
    let read = |text: &str| Expression::new(text, &scene).expect("an expression");
    let kinds = ["L E", "L S+ E", "L .* [DG] S* E"].map(read);
    for (_, text) in PRESETS {
        read(text);
    }
    let pixels = pixels(99);
    for id in ["naive", "pt-mis", "bdpt", "vcm"] {
        let method = neumann_core::integrator::method(id).expect("a method of the registry");
        for inspected in inspect(&setup(&scene, method), &scene, &pixels) {
            for way in inspected.ways() {
                let kinds = kinds.iter();
                let n = kinds
                    .filter(|kind| kind.matches(way.bounces, way.source))
                    .count();
                assert_eq!(n, 1, "{id}: {way:?}");
                // Walls and floor let no light through, also where two parts are joined.
                let mut diffuse = way.bounces.iter().filter(|b| b.lobe == Lobe::Diffuse);
                assert!(diffuse.all(|b| !b.is_transmission), "{id}: {way:?}");
            }
        }
    }
}

/// A firefly's paths are those that the film has there, and few of them have made it.
#[test]
fn fireflies_replay_to_what_was_recorded() {
    const N: u32 = 16;
    let scene = builtin("pool");
    for id in ["naive", "pt-mis", "bdpt"] {
        let method = neumann_core::integrator::method(id).expect("a method of the registry");
        let setup = setup(&scene, method);
        let film = setup.film(0, N);
        let found = film.fireflies(12);
        assert!(found.len() > 3, "{id}: {found:?}");
        let pixels: Vec<_> = found.iter().map(|f| f.pixel.map(|at| at as u32)).collect();
        let inspected = inspect_first(N, &setup, &scene, &pixels);
        for (firefly, inspected) in found.iter().zip(&inspected) {
            let total = inspected.total().mean.luminance();
            let apart = (total - firefly.luminance).abs();
            assert!(apart <= 1e-5 * total, "{id}, {firefly:?}: {total}");
        }
        // Few paths have made the brightest one.
        let brightest = inspected[0].total().mean.luminance();
        let largest = inspected[0].paths()[0].1.value().luminance() / N as f32;
        assert!(largest > 0.2 * brightest, "{id}: {largest} of {brightest}");
    }
}
