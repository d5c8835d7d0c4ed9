//! Is the light that merging finds the right amount, and does its error fall as fast as it should?
//!
//! At the size of these renders merges weigh little beside connections, so they are tested alone.

use std::sync::Arc;

use neumann_core::integrator::{Value, method};
use neumann_core::scene::Scene;
use neumann_tests::renders::{Batches, Block, Setup};
use neumann_tests::scenes::builtin;
use neumann_tests::studio::studios;

const N_BATCHES: u32 = 16;

fn setup(scene: &Arc<Scene>, id: &str, values: &[(&'static str, Value)]) -> Setup {
    let mut setup = Setup::new(scene, 24, 16)
        .by(method(id).expect("a method of the registry"))
        .up_to(4);
    for (name, value) in values {
        setup.settings.values.put(name, *value);
    }
    setup
}

fn batches(scene: &Arc<Scene>, id: &str, values: &[(&'static str, Value)], n: u32) -> Batches {
    setup(scene, id, values).batches(N_BATCHES, n, 90)
}

/// Blur moves light about but hardly adds any: the image's mean stays what it is.
#[test]
fn merges_alone_make_the_image() {
    let mut scenes = vec![("cornell", builtin("cornell")), ("bleed", builtin("bleed"))];
    let wanted = ["lamp", "point", "sky", "veil", "lamp and sky"];
    scenes.extend(
        studios()
            .into_iter()
            .filter(|(name, _)| wanted.contains(name)),
    );
    let mut n_decisive = 0;
    for (name, scene) in &scenes {
        let expected = batches(scene, "pt-mis", &[], 16);
        for values in [
            vec![
                ("connect", Value::Switch(false)),
                ("radius", Value::Real(0.01)),
            ],
            // With connections, and merges that weigh more than they do.
            vec![("radius", Value::Real(0.03))],
        ] {
            let found = batches(scene, "vcm", &values, 32);
            for layer in 1..=3 {
                let (a, b) = (found.layer(layer)[1], expected.layer(layer)[1]);
                let noise = 5.0 * (a.standard_error + b.standard_error) / b.mean;
                if noise > 0.3 {
                    continue;
                }
                n_decisive += 1;
                let ratio = a.mean / b.mean;
                assert!(
                    (ratio - 1.0).abs() < 0.06 + noise,
                    "{name}, {values:?}, T{layer}: ratio {ratio:.3} with noise of {noise:.3}"
                );
            }
        }
    }
    assert!(
        n_decisive > 20,
        "only {n_decisive} comparisons say anything"
    );
}

/// Knaus and Zwicker 2011: with a radius whose square shrinks like i^(α - 1), the variance of the
/// mean of n iterations falls like n^(-α), for photons that are few within the radius.
#[test]
fn the_variance_of_progressive_photons_falls_with_the_predicted_exponent() {
    // All pixels of a batch share its photons: a bigger picture, with more of them, varies less
    // from batch to batch.
    let size = [72, 48];
    let scene = builtin("cornell");
    for alpha in [0.5, 0.75, 1.0] {
        let variance = |n: u32| {
            let mut setup = setup(&scene, "ppm", &[("alpha", Value::Real(alpha))]);
            [setup.settings.width, setup.settings.height] = size;
            let found = setup.batches(N_BATCHES, n, 90);
            let pixels = Block::grid(&found.films[0], size[0], size[1]);
            let sum: f64 = pixels
                .iter()
                .map(|pixel| found.block(*pixel, 1)[1].standard_error.powi(2))
                .sum();
            sum
        };
        let (few, many) = (4, 64);
        let exponent = (variance(many) / variance(few)).ln() / f64::from(many / few).ln();
        assert!(
            (exponent + alpha).abs() < 0.1,
            "alpha {alpha}: the variance falls like n^{exponent:.3}"
        );
    }
}
