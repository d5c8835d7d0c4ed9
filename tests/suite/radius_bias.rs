//! Is the error of photons split as it should be: into a noise that is what seeds differ by, and a
//! bias that is what is left of it against a method without one?

use glam::Vec3;
use neumann_core::film::View;
use neumann_core::integrator::{Value, method};
use neumann_core::radiometry::Rgb;
use neumann_core::render::CancelToken;
use neumann_core::scene::description::LightKind;
use neumann_picture::agreement::{Batches, Estimate};
use neumann_picture::radius_bias::{EDGES, RATIO, Radii, RadiusBias, pair};
use neumann_tests::renders::{Setup, pool};
use neumann_tests::scenes::{Stage, above_square, builtin, lambert, rectangle};
use neumann_tests::statistics::Family;

/// A method with its radius in metres and so many light paths for each pixel.
fn photons(setup: Setup, id: &str, radius: f64, paths: f64) -> Setup {
    let mut setup = setup.by(method(id).expect("a method of the registry"));
    let values = &mut setup.settings.values;
    values.put("radius-unit", Value::Choice(1));
    values.put("radius", Value::Real(radius));
    if values.value("paths").is_some() {
        values.put("paths", Value::Real(paths));
    }
    setup
}

/// So many renders at both radii.
fn measured(setup: &Setup, n_iterations: u32, n_renders: u32, stream: u64) -> RadiusBias {
    let settings = &setup.settings;
    let radii = Radii::of(&setup.scene, settings, n_iterations).expect("it has a radius");
    let (width, height) = (settings.width, settings.height);
    let mut found = RadiusBias::new(width, height, settings.n_layers, radii.q);
    for render in 0..n_renders {
        let length = (n_iterations, stream << 32 | u64::from(render));
        let nobody = CancelToken::default();
        let films = pair(&setup.scene, &radii, length, &pool(), &nobody);
        let [wide, narrow] = films.expect("nobody cancels");
        found.take(&wide, &narrow);
    }
    found
}

/// A method without a bias on the same scene.
fn truth(setup: &Setup, id: &str, n_batches: u32, n_iterations: u32) -> Batches {
    let settings = &setup.settings;
    let mut truth = Batches::new(settings.width, settings.height, settings.n_layers);
    let setup = setup
        .clone()
        .by(method(id).expect("a method of the registry"));
    for film in setup.batches(n_batches, n_iterations, 77).films {
        truth.take(&film);
    }
    truth
}

/// A square of floor under a point light of 1 W/sr, far from the edges of the floor and, without a
/// plate, from all others.
fn floor(has_plate: bool, size: usize) -> Setup {
    let mut stage = Stage::default();
    let (x, z) = (Vec3::X, Vec3::Z);
    let mesh = rectangle(Vec3::ZERO, z * 3.0, x * 3.0);
    stage.add("floor", mesh, lambert(0.8));
    // Its shadow reaches into what the camera sees, and the plate does not.
    let at = if has_plate { -1.0 } else { 0.0 };
    if has_plate {
        let mesh = rectangle(Vec3::new(-0.9, 0.5, 0.0), z * 0.6, x * 0.3);
        stage.add("plate", mesh, lambert(0.0));
    }
    let kind = LightKind::Point {
        intensity: Rgb::WHITE,
    };
    stage.light(kind, Vec3::new(at, 1.0, 0.0), Vec3::NEG_Y);
    let camera = above_square(0.5, 4.0);
    Setup::seen_by(&stage.scene(), camera, size, size).up_to(1)
}

/// What the bias in a cell is in truth, and what is said of it; luminance is alike in all channels.
fn biases(found: &RadiusBias, truth: &Batches, view: usize, cell: usize) -> [Estimate; 2] {
    let [wide, true_mean] = [found.wide(view, cell, 1), truth.estimate(view, cell, 1)];
    let true_bias = Estimate {
        mean: wide.mean - true_mean.mean,
        standard_error: wide.standard_error.hypot(true_mean.standard_error),
        ..wide
    };
    [true_bias, found.bias(view, cell, 1)]
}

/// The light of a furnace is the same everywhere, so that a radius takes nothing away.
#[test]
fn the_bias_in_a_furnace_is_none() {
    let scene = builtin("furnace");
    for id in ["pm", "ppm", "vcm"] {
        let setup = photons(Setup::new(&scene, 24, 24), id, 0.1, 4.0);
        let found = measured(&setup, 2, 24, 1);
        let mut family = Family::default();
        for (number, view) in found.views().into_iter().enumerate() {
            for cell in 0..found.cells().len() {
                let bias = found.bias(number, cell, 1);
                let mean = found.wide(number, cell, 1).mean;
                let what = format!("{id} {view} cell {cell}: {bias:?} of {mean}");
                family.add(bias.p_value(0.0, 0.0).max(f64::MIN_POSITIVE), what);
            }
        }
        family.judge();
        for part in found.parts() {
            assert!(
                part.here.bias < 0.3 * part.here.noise.max(1e-3),
                "{id}: {part:?}"
            );
            assert!(!part.has_bias(), "{id}: {part:?}");
        }
    }
}

/// Halves, two renders of each of many, against the variance over all seeds.
#[test]
fn the_noise_is_what_seeds_differ_by() {
    const SIZE: usize = 16;
    const N_SEEDS: u32 = 256;
    let scene = builtin("cornell");
    for id in ["pm", "ppm", "vcm"] {
        let setup = photons(Setup::new(&scene, SIZE, SIZE), id, 0.15, 4.0).up_to(3);
        let term = View::Term(1);
        let films = setup.batches(N_SEEDS, 2, 5).films;
        let mut empirical = 0.0;
        let mut mean = 0.0;
        for pixel in 0..SIZE * SIZE {
            let values = films
                .iter()
                .map(|film| film.radiance(term, pixel).luminance());
            let values: Vec<f64> = values.map(f64::from).collect();
            let n = values.len() as f64;
            let middle = values.iter().sum::<f64>() / n;
            let squares = values.iter().map(|v| (v - middle) * (v - middle));
            empirical += squares.sum::<f64>() / (n - 1.0);
            mean += middle;
        }
        let n_pixels = (SIZE * SIZE) as f64;
        let empirical = empirical / n_pixels / (mean / n_pixels).powi(2);
        let of_halves = (0..64).map(|group| {
            let parts = measured(&setup, 2, 2, 1000 + group).parts();
            let part = parts.into_iter().find(|part| part.view == term);
            part.expect("it has light").here.noise.powi(2)
        });
        let halves = Estimate::of(&of_halves.collect::<Vec<f64>>());
        let apart = halves.mean / empirical - 1.0;
        assert!(apart.abs() < 0.1, "{id}: {apart} {halves:?} {empirical}");
        let p_value = halves.p_value(empirical, 0.03);
        assert!(p_value > 1e-4, "{id}: {halves:?} {empirical}");
    }
}

/// Where the light has no edges, the bias is that against a method without one, in size and sign.
#[test]
fn the_bias_of_smooth_light_is_that_against_the_truth() {
    for (id, n_iterations) in [("pm", 1), ("ppm", 4)] {
        let setup = photons(floor(false, 16), id, 0.3, 16.0);
        let found = measured(&setup, n_iterations, 64, 2);
        let truth = truth(&setup, "pt-nee", 16, 4);
        let view = 1;
        let mut family = Family::default();
        for cell in 0..found.cells().len() {
            let [is, said] = biases(&found, &truth, view, cell);
            let mean = found.wide(view, cell, 1).mean;
            // What is left out goes with the fourth power of the radius.
            let rounding = 2e-3 * mean / said.mean.abs();
            let what = format!("{id} cell {cell}: is {is:?}, said {said:?} of {mean}");
            family.add(said.p_value_against(&is, rounding), what);
        }
        family.judge();
        let [is, said] = biases(&found, &truth, view, 0);
        assert!(said.mean < -8.0 * said.standard_error, "{id}: {said:?}");
        assert!(
            (said.mean / is.mean - 1.0).abs() < 0.2,
            "{id}: {said:?} {is:?}"
        );
        let part = &found.parts()[0];
        assert!(part.has_bias(), "{id}: {part:?}");
    }
}

/// Where it has edges, the bias is no less than `1 - q` times what is said, and no more than
/// [`EDGES`] times that.
#[test]
fn the_bias_at_edges_is_within_what_is_said() {
    const SMALLER: f64 = 1.0 - RATIO * RATIO;
    let caustic = Setup::new(&builtin("caustic"), 64, 64).up_to(3);
    for (setup, id, reference, view) in [
        (floor(true, 128), "pm", "pt-nee", 1),
        (caustic.clone(), "pm", "bdpt", 3),
        (caustic, "vcm", "bdpt", 3),
    ] {
        let setup = photons(setup, id, 0.1, 2.0);
        let found = measured(&setup, 1, 32, 3);
        let truth = truth(&setup, reference, 16, 16);
        let mut n_seen = 0;
        for cell in 0..found.cells().len() {
            let [is, said] = biases(&found, &truth, view, cell);
            let error = is.standard_error.hypot(EDGES * said.standard_error);
            let [a, b] = [SMALLER, EDGES].map(|times| times * said.mean);
            let is_within = is.mean >= a.min(b) - 4.5 * error && is.mean <= a.max(b) + 4.5 * error;
            assert!(is_within, "{id} T{view} cell {cell}: {is:?} {said:?}");
            n_seen += usize::from(said.mean.abs() > 4.0 * said.standard_error);
        }
        assert!(n_seen > 0, "{id} T{view}");
        if reference == "pt-nee" {
            // Of a straight edge it is known: 1.56 times what is said, in the root mean square.
            let times = true_rms(&found, &truth, view) / found.parts()[0].here.bias;
            assert!((times - 1.56).abs() < 0.15, "{times}");
        }
    }
}

/// Root mean square of the true bias over the pixels, as a share of the mean.
fn true_rms(found: &RadiusBias, truth: &Batches, view: usize) -> f64 {
    let (width, height) = found.cells().size();
    let (mut squares, mut sum) = (0.0, 0.0);
    for pixel in 0..width * height {
        let ([wide, _], is) = (found.pixel(view, pixel), truth.pixel(view, pixel));
        let of_noise = wide.standard_error.powi(2) + is.standard_error.powi(2);
        squares += (wide.mean - is.mean).powi(2) - of_noise;
        sum += wide.mean;
    }
    let n = (width * height) as f64;
    (squares / n).sqrt() / (sum / n)
}
