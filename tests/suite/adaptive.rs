//! Do samples go where they are needed, without changing what the picture tends to?

use std::sync::Arc;

use glam::Vec3;
use neumann_core::film::View;
use neumann_core::integrator::{Value, method};
use neumann_core::render::{CancelToken, RenderSettings, Renderer};
use neumann_core::scene::Scene;
use neumann_tests::renders::{Batches, Block, Setup, pool};
use neumann_tests::scenes::{Stage, above_square, builtin, emitter, lambert, rectangle};
use neumann_tests::statistics::{Estimate, Family};

fn setup(scene: &Arc<Scene>, is_adaptive: bool) -> Setup {
    let method = method("pt-mis").expect("a method of the registry");
    let mut setup = Setup::new(scene, 48, 32).by(method).up_to(4);
    let value = Value::Switch(is_adaptive);
    setup.settings.values.put("adaptive", value);
    setup
}

#[test]
fn what_is_sampled_adaptively_tends_to_the_same() {
    let mut family = Family::default();
    for (name, layers) in [("cornell", 0..=4), ("sky", 0..=3)] {
        let scene = builtin(name);
        let batches = |is_adaptive, n_iterations, stream| {
            setup(&scene, is_adaptive).batches(64, n_iterations, stream)
        };
        let (found, expected) = (batches(true, 8, 70), batches(false, 32, 71));
        assert_eq!(found.n_refused(), 0, "{name}");
        for layer in layers {
            for block in Block::grid(&found.films[0], 3, 2) {
                let (a, b) = (found.block(block, layer), expected.block(block, layer));
                for channel in 0..3 {
                    let (a, b) = (a[channel], b[channel]);
                    let what = format!("{name} T{layer} {block:?} channel {channel}: {a:?} {b:?}");
                    family.add(a.p_value_against(&b, 1e-5), what);
                }
            }
        }
    }
    family.judge();
}

/// In each tile a speck, so small that only every fourth measurement meets it, decides how many
/// paths are run there. Were these not independent of those that met it, the specks would come out
/// a quarter too dark.
#[test]
fn what_is_met_rarely_is_not_lost() {
    const SPECK: f32 = 1.0 / 8.0;
    let pixel = 2.0 / 64.0;
    let mut stage = Stage::default();
    for tile in 0..16 {
        let place = |i: usize| -1.0 + pixel * (16.0 * i as f32 + 5.4);
        let center = Vec3::new(place(tile % 4), 0.0, place(tile / 4));
        let half = 0.5 * SPECK * pixel;
        let speck = rectangle(center, Vec3::Z * half, Vec3::X * half);
        stage.add("speck", speck, emitter(1.0));
    }
    stage.description.cameras = vec![above_square(1.0, 10.0)];
    let scene = stage.scene();
    let mut setup = setup(&scene, true).up_to(0);
    (setup.settings.width, setup.settings.height) = (64, 64);

    let found = setup.batches(512, 8, 73).layer(0)[1];
    let expected = f64::from(SPECK * SPECK) / 256.0;
    assert!(found.standard_error < 0.03 * expected, "{found:?}");
    let mut family = Family::default();
    family.add(
        found.p_value(expected, 1e-5),
        format!("{found:?}, expected {expected}"),
    );
    family.judge();
}

/// A floor under a lamp that hangs low over one corner: close to the lamp, what a point of it gives
/// varies a hundred times more than far away.
#[test]
fn where_noise_is_uneven_the_same_rays_leave_less_error() {
    let mut stage = Stage::default();
    let floor = rectangle(Vec3::ZERO, Vec3::Z * 20.0, Vec3::X * 20.0);
    stage.add("floor", floor, lambert(0.5));
    let lamp = rectangle(Vec3::new(-3.0, 0.3, -3.0), Vec3::X, Vec3::Z);
    stage.add("lamp", lamp, emitter(1.0));
    stage.description.cameras = vec![above_square(4.0, 10.0)];
    let scene = stage.scene();

    let work = |is_adaptive, n_iterations| {
        let setup = Setup {
            settings: RenderSettings {
                width: 128,
                height: 128,
                max_bounces: 1,
                ..setup(&scene, is_adaptive).settings
            },
            scene: Arc::clone(&scene),
        };
        let mut renderer = Renderer::new(Arc::clone(&scene), setup.settings.clone(), pool(), 0);
        let n_rays: u64 = (0..n_iterations)
            .map(|_| renderer.iterate(&CancelToken::default()).unwrap().n_rays())
            .sum();
        (
            squared_error(&setup.batches(16, n_iterations, 72)),
            n_rays as f64,
        )
    };
    let (error, n_rays) = work(true, 16);
    let (even_error, n_even_rays) = work(false, 64);
    let gain = even_error * n_even_rays / (error * n_rays);
    assert!(
        (0.9..1.1).contains(&(n_rays / n_even_rays)),
        "{n_rays} {n_even_rays}"
    );
    assert!(gain > 1.5, "{gain}");
}

/// Variance of L over films, mean of the pixels: the mean squared error.
pub(super) fn squared_error(batches: &Batches) -> f64 {
    let n_pixels = batches.films[0].n_pixels();
    let of_pixel = |pixel: usize| {
        let values: Vec<f64> = batches
            .films
            .iter()
            .map(|film| f64::from(film.radiance(View::Total, pixel).mean()))
            .collect();
        Estimate::of(&values).standard_error.powi(2) * values.len() as f64
    };
    (0..n_pixels).map(of_pixel).sum::<f64>() / n_pixels as f64
}
