//! Renders of which noise and bias are known.

use neumann_core::film::{Film, View};
use neumann_core::integrator::{METHODS, method};
use neumann_core::radiometry::Rgb;
use neumann_core::render::RenderSettings;
use neumann_core::scene::Scene;
use neumann_core::scene::builtin::builtin;

use super::{Half, RATIO, Radii, RadiusBias, Report, has_radius, planes};

const SIZE: usize = 32;

/// A number that looks random, of variance 1.
fn noise(stream: usize, pixel: usize) -> f32 {
    let mut x = (stream * 1_000_003 + pixel) as u64;
    for factor in [0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb_u64] {
        x = (x ^ (x >> 30))
            .wrapping_add(0x9e37_79b9_7f4a_7c15)
            .wrapping_mul(factor);
    }
    ((x >> 40) as f32 / (1u64 << 24) as f32 - 0.5) * 12.0_f32.sqrt()
}

fn film(value: impl Fn(usize) -> f32) -> Film {
    let layer: Vec<Rgb> = (0..SIZE * SIZE).map(|i| Rgb::splat(value(i))).collect();
    let black = vec![Rgb::BLACK; layer.len()];
    let layers = vec![layer.clone(), black.clone()];
    Film::from_parts((SIZE, SIZE), 1, layers, layer, &black, 0).unwrap()
}

/// Renders of a picture of 4, with noise of one part in common and of one that is not, and a bias
/// on the left half that goes with the square of the radius.
fn renders(n: usize, [common, own]: [f32; 2], bias: f32) -> RadiusBias {
    let q = RATIO * RATIO;
    let mut of = RadiusBias::new(SIZE, SIZE, 1, q);
    for render in 0..n {
        let value = |i: usize, which: usize, bias: f32| {
            let at = if i % SIZE < SIZE / 2 { bias } else { 0.0 };
            4.0 + common * noise(3 * render, i) + own * noise(3 * render + which, i) + at
        };
        of.take(
            &film(|i| value(i, 1, bias)),
            &film(|i| value(i, 2, q as f32 * bias)),
        );
    }
    of
}

#[test]
fn noise_and_bias_are_those_that_were_put_in() {
    for n in [2, 8] {
        let of = renders(n, [0.3, 0.1], 0.2);
        let parts = of.parts();
        let part = &parts[0];
        assert_eq!(part.view, View::Term(0));
        assert!((part.mean - 4.1).abs() < 0.05);
        let noise = (0.09_f64 + 0.01).sqrt() / part.mean;
        assert!(
            (part.here.noise / noise - 1.0).abs() < 0.06,
            "{n}: {part:?}"
        );
        assert!(
            (part.at_half.noise / noise - 1.0).abs() < 0.06,
            "{n}: {part:?}"
        );
        // On half of the pixels.
        let bias = 0.2 / 2f64.sqrt() / part.mean;
        let [least, most] = part.bias_range;
        assert!(
            part.has_bias() && least < bias && bias < most,
            "{n}: {part:?}"
        );
        assert!((part.here.bias / bias - 1.0).abs() < 0.1, "{n}: {part:?}");
        assert!((part.at_half.bias / part.here.bias - 0.25).abs() < 1e-9);
        let error = part.here.error();
        assert!((error.powi(2) - part.here.noise.powi(2) - part.here.bias.powi(2)).abs() < 1e-9);
    }
}

#[test]
fn noise_alone_is_no_bias() {
    for n in [2, 8] {
        let part = renders(n, [0.0, 0.3], 0.0).parts().remove(0);
        assert!(!part.has_bias(), "{part:?}");
        // What is not subtracted would be this.
        let of_noise = 0.3 * (2.0 / n as f64).sqrt() / 0.75 / part.mean;
        assert!(part.here.bias < 0.35 * of_noise, "{part:?} {of_noise}");
    }
}

#[test]
fn the_map_has_noise_everywhere_and_bias_where_it_is() {
    let of = renders(8, [0.3, 0.02], 0.2);
    let [noise, bias] = planes(&of, 0);
    assert_eq!(Half::ALL.map(Half::name), ["noise", "radius bias"]);
    let error = |plane: &crate::quantity::QuantityPlane, x: usize| {
        let words = plane.words(x, SIZE / 2);
        let number = words[0].split_whitespace().nth(1).unwrap();
        number.parse::<f64>().unwrap()
    };
    for x in [5, 26] {
        assert!(
            (error(&noise, x) - 0.3).abs() < 0.1,
            "{:?}",
            noise.words(x, SIZE / 2)
        );
    }
    assert!(
        (error(&bias, 5) - 0.2).abs() < 0.03,
        "{:?}",
        bias.words(5, SIZE / 2)
    );
    assert!(error(&bias, 26) < 0.03, "{:?}", bias.words(26, SIZE / 2));
    // Both colour the mean square of their surroundings.
    assert!(noise.largest_error() < 0.6);
}

#[test]
fn radii_are_one_and_half_of_it_whatever_they_are_measured_in() {
    let description = builtin("cornell").unwrap().load().unwrap();
    let scene = Scene::build(&description);
    let by = |id: &str| {
        let method = method(id).unwrap();
        let mut settings = RenderSettings::new(scene.cameras()[0].clone(), 32, 32);
        settings.method = method;
        settings.values = neumann_core::integrator::ParameterValues::defaults(method.parameters);
        settings
    };
    for method in METHODS {
        let radii = Radii::of(&scene, &by(method.id), 16);
        assert_eq!(radii.is_ok(), has_radius(method), "{}", method.id);
    }
    let error = Radii::of(&scene, &by("pt-mis"), 16).unwrap_err();
    assert!(error.contains("pm, ppm, vcm have"), "{error}");
    let ppm = Radii::of(&scene, &by("ppm"), 16).unwrap();
    assert!((ppm.q - 0.25).abs() < 1e-6, "{}", ppm.q);
    assert!(ppm.radius[0] > 1.4 * ppm.radius[1], "it shrinks");
    let pm = Radii::of(&scene, &by("pm"), 16).unwrap();
    assert_eq!(pm.radius[0], pm.radius[1]);
    // At 32×32, a pixel is wider than the share of the scene; half of it is half all the same.
    assert!((pm.radius[0] - ppm.radius[0]).abs() < 1e-9);
    let mut nearest = by("pm");
    let parameters = nearest.method.parameters;
    nearest.values.set(parameters, "nearest", "50").unwrap();
    let error = Radii::of(&scene, &nearest, 16).unwrap_err();
    assert!(error.contains("'nearest'"), "{error}");
}

#[test]
fn a_line_says_all() {
    let description = builtin("cornell").unwrap().load().unwrap();
    let scene = Scene::build(&description);
    let mut settings = RenderSettings::new(scene.cameras()[0].clone(), SIZE, SIZE);
    settings.method = method("ppm").unwrap();
    settings.values =
        neumann_core::integrator::ParameterValues::defaults(settings.method.parameters);
    let radii = Radii::of(&scene, &settings, 4).unwrap();
    let line = |bias: f32| {
        let parts = renders(8, [0.3, 0.02], bias).parts();
        let report = Report {
            name: "ppm",
            radii: &radii,
            n_iterations: 4,
            n_renders: 8,
            parts: &parts,
        };
        assert!(report.heading().contains("8 renders of 4 iterations"));
        assert_eq!(report.text().lines().count(), 10, "{}", report.text());
        report.line(View::Total)
    };
    let biased = line(0.8);
    for words in [
        "ppm after 4 iterations, L: relative error 15 %, of it noise 6.8 % and radius bias 13 % (",
        "With half the radius noise 6.8 %, bias 3.2 %: the error becomes smaller, 7.6 %.",
    ] {
        assert!(biased.contains(words), "{biased}");
    }
    let honest = line(0.0);
    assert!(
        honest.contains("no radius bias that is seen (below 0."),
        "{honest}"
    );
}
