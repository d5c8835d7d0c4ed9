//! Is the reflection equation, looked at over the hemisphere, the radiance of the pixel?

use std::f64::consts::PI;
use std::sync::Arc;

use neumann_core::film::View;
use neumann_core::render::hemisphere::{Estimator, Integrand, settings_of_ray};
use neumann_core::render::{CancelToken, Hemisphere, Measured};
use neumann_core::scene::Scene;
use neumann_core::scene::builtin::BUILTINS;
use neumann_tests::random::Random;
use neumann_tests::renders::{Block, Setup, pool};
use neumann_tests::scenes::builtin;
use neumann_tests::statistics::{Estimate, Family, chi_square};

const WIDTH: usize = 40;
const HEIGHT: usize = 30;
/// What rounding may add, relative.
const ROUNDING: f64 = 1e-4;

fn setup(scene: &Arc<Scene>) -> Setup {
    let mut setup = Setup::new(scene, WIDTH, HEIGHT);
    setup.settings.camera.lens = None;
    setup
}

fn look(setup: &Setup, pixel: [u32; 2], n_passes: u32) -> Option<Hemisphere> {
    let scene = Arc::clone(&setup.scene);
    let mut hemisphere = Hemisphere::new(scene, &setup.settings, pixel, 32).ok()?;
    for _ in 0..n_passes {
        hemisphere
            .add_pass(&pool(), &CancelToken::default())
            .expect("nobody cancels it");
    }
    Some(hemisphere)
}

/// The pixel as a film has it, so small that it is the ray through its middle.
fn film_of_ray(setup: &Setup, pixel: [u32; 2], stream: u64) -> Estimate {
    let mut setup = setup.clone();
    setup.settings = settings_of_ray(&setup.settings, pixel);
    let batches = setup.batches(16, 32, stream);
    let luminances = batches.films.iter().map(|film| {
        let whole = Block::grid(film, 1, 1)[0];
        let mut sum = [0.0; 3];
        for layer in 0..=film.n_layers() {
            let mean = whole.mean(film, layer);
            sum = std::array::from_fn(|c| sum[c] + mean[c]);
        }
        luminance(sum)
    });
    Estimate::of(&luminances.collect::<Vec<_>>())
}

fn luminance([r, g, b]: [f64; 3]) -> f64 {
    let weights = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let [wr, wg, wb] = weights.map(|[r, g, b]: [f32; 3]| {
        f64::from(neumann_core::radiometry::Rgb::new(r, g, b).luminance())
    });
    r * wr + g * wg + b * wb
}

/// A mean with its error, beside what the point emits.
fn estimate(measured: &Measured, hemisphere: &Hemisphere, n: u32) -> Estimate {
    let emitted = hemisphere.emitted().luminance();
    Estimate {
        mean: f64::from(measured.mean.luminance() + emitted),
        standard_error: measured.interval.expect("many paths") / 1.96,
        n: n as usize,
    }
}

/// Scenes with lights so small that no direction out of thousands runs into some of them. BSDF
/// sampling is too low there as long as it has not, and does not know it.
const WITH_SMALL_LIGHTS: [&str; 4] = ["plates", "lamps", "sky", "many"];

/// All estimators and the integral of the pictures agree with the film, at some pixels of every
/// built-in scene.
fn compare(max_bounces: u32, n_passes: u32, stream: u64) {
    let mut family = Family::default();
    for (i, row) in BUILTINS.iter().enumerate() {
        let scene = builtin(row.name);
        let setup = setup(&scene).up_to(max_bounces);
        let mut random = Random::new(stream + i as u64);
        let is_small = WITH_SMALL_LIGHTS.contains(&row.name);
        let mut n_seen = 0;
        for _ in 0..60 {
            let [x, y] = random.pair();
            let pixel = [(x * WIDTH as f32) as u32, (y * HEIGHT as f32) as u32];
            let Some(hemisphere) = look(&setup, pixel, n_passes) else {
                continue;
            };
            let what = format!("{}, {pixel:?}", row.name);
            let film = film_of_ray(&setup, pixel, 1000 * stream + 100 * i as u64 + n_seen);
            let mut add = |found: Estimate, name: &str| {
                let is_blind = name != "light sampling" && name != "MIS" && is_small;
                if is_blind && found.mean < film.mean {
                    return;
                }
                let p_value = found.p_value_against(&film, ROUNDING);
                let (mean, error) = (found.mean, found.standard_error);
                let of_film = (film.mean, film.standard_error);
                let text = format!("{what}, {name}: {mean} ± {error}, film {of_film:?}");
                family.add(p_value, text);
            };
            for estimator in Estimator::ALL {
                let running = hemisphere.estimate_by(estimator);
                let found = estimate(&running.measured(), &hemisphere, running.n());
                add(found, estimator.name());
            }
            add(
                estimate(&hemisphere.integral(), &hemisphere, n_passes),
                "pictures",
            );
            n_seen += 1;
            if n_seen == 12 {
                break;
            }
        }
        assert!(n_seen >= 6, "{}: {n_seen} pixels", row.name);
    }
    family.judge();
}

#[test]
fn estimators_and_pictures_agree_with_the_film_on_light_scattered_once() {
    compare(1, 48, 71);
}

#[test]
fn estimators_and_pictures_agree_with_the_film() {
    compare(4, 48, 72);
}

fn sum(hemisphere: &Hemisphere, integrand: Integrand) -> f64 {
    let picture = hemisphere.picture(integrand, View::Total);
    let sum: f64 = picture.iter().map(|v| f64::from(v.luminance())).sum();
    sum * f64::from(hemisphere.map().solid_angle())
}

/// In the furnace all is known: `L_i` is `1/2^k` from everywhere, `f` is `1/(2 π)`.
#[test]
fn the_furnace_is_the_same_from_everywhere() {
    let scene = builtin("furnace");
    let setup = setup(&scene).up_to(3);
    let hemisphere = look(&setup, [17, 12], 64).expect("a wall");
    let is_inside = |i: usize| {
        let (x, y) = ((i % 32) as f32 - 15.5, (i / 32) as f32 - 15.5);
        x.hypot(y) < 14.0
    };
    for k in 0..3 {
        let picture = hemisphere.picture(Integrand::Incident, View::Term(k));
        let expected = 0.5f32.powi(k as i32);
        let bound = if k == 0 { 1e-3 } else { 0.1 };
        let (mut sum, mut n) = (0.0, 0.0);
        for (_, value) in picture.iter().enumerate().filter(|(i, _)| is_inside(*i)) {
            let apart = (value.luminance() / expected - 1.0).abs();
            assert!(apart < bound, "T{k}: {value:?}");
            sum += value.luminance() / expected;
            n += 1.0;
        }
        assert!((sum / n - 1.0f32).abs() < 5e-3, "T{k}: {}", sum / n);
    }
    let near = |value: f64, expected: f64, bound: f64| {
        assert!(
            (value / expected - 1.0).abs() < bound,
            "{value} for {expected}"
        );
    };
    for (i, value) in hemisphere
        .picture(Integrand::Bsdf, View::Total)
        .iter()
        .enumerate()
    {
        if is_inside(i) {
            near(f64::from(value.luminance()), 0.5 / PI, 1e-4);
        }
    }
    near(sum(&hemisphere, Integrand::Cosine), PI, 1e-2);
    near(
        sum(&hemisphere, Integrand::Density(Estimator::Bsdf)),
        1.0,
        2e-2,
    );
    // Half of 1 + 1/2 + 1/4.
    near(sum(&hemisphere, Integrand::Product), 0.875, 2e-2);
    let bsdf = hemisphere.estimate_by(Estimator::Bsdf).measured();
    near(f64::from(bsdf.mean.luminance()), 0.875, 1e-3);
    assert!(bsdf.interval.expect("many paths") < 1e-3, "it has no noise");
    for estimator in Estimator::ALL {
        let running = hemisphere.estimate_by(estimator);
        let p = estimate(&running.measured(), &hemisphere, running.n()).p_value(1.875, 1e-4);
        assert!(p > 1e-4, "{}: {p}", estimator.name());
        let last = running.moments().last().copied().expect("moments");
        assert_eq!(last.n, running.n(), "the last moment is now");
        let mean = f64::from(running.measured().mean.luminance());
        assert!((last.mean - mean).abs() < 1e-9, "{last:?} {mean}");
    }
}

/// Directions fall as densely as the pictures of the densities say.
#[test]
fn dots_fall_as_densities_say() {
    let mut family = Family::default();
    for (name, pixel) in [
        ("cornell", [20, 29]),
        ("cornell", [12, 12]),
        ("plates", [20, 20]),
        ("sky", [20, 28]),
        ("many", [20, 25]),
    ] {
        let scene = builtin(name);
        let hemisphere = look(&setup(&scene).up_to(1), pixel, 128).expect("a surface");
        for estimator in Estimator::ALL {
            let density = hemisphere.picture(Integrand::Density(estimator), View::Total);
            // Lights behind the surface may be aimed at.
            let dots = hemisphere.dots(estimator);
            let dots = dots.filter_map(|dot| hemisphere.map().place(dot));
            let dots: Vec<[f32; 2]> = dots.collect();
            let n = dots.len();
            assert!(n > 150, "{name}, {pixel:?}, {}: {n} dots", estimator.name());
            let width = hemisphere.map().size().0;
            let cell = |x: f32, y: f32| (y / 4.0) as usize * (width / 4) + (x / 4.0) as usize;
            let mut expected = vec![0.0; width / 4 * 8];
            let mut counts = expected.clone();
            for (i, value) in density.iter().enumerate() {
                expected[cell((i % width) as f32, (i / width) as f32)] += f64::from(value.r);
            }
            for [x, y] in &dots {
                counts[cell((*x).min(width as f32 - 0.1), (*y).min(31.9))] += 1.0;
            }
            let total: f64 = expected.iter().sum();
            for value in &mut expected {
                *value *= dots.len() as f64 / total;
            }
            let result = chi_square(&counts, &expected);
            let what = format!("{name}, {pixel:?}, {}", estimator.name());
            family.add(result.p_value, what);
            let mass = total * f64::from(hemisphere.map().solid_angle());
            assert!(mass < 1.2, "{name}, {}: {mass}", estimator.name());
        }
    }
    family.judge();
}
