//! Does the agreement map light up where there is a bias, and stay grey where there is none?

use std::sync::Arc;

use neumann_core::film::{Film, View};
use neumann_core::integrator::method;
use neumann_core::radiometry::Rgb;
use neumann_core::scene::Scene;
use neumann_picture::agreement::{Agreement, Batches, Grain, Term, map};
use neumann_tests::renders::Setup;
use neumann_tests::scenes::builtin;

const N_BATCHES: u32 = 32;
/// False-alarm rate of a comparison.
const LEVEL: f64 = 0.01;

/// Batches by a method; what is done to each film is a bias that is planted.
fn batches(
    (scene, size): (&Arc<Scene>, usize),
    id: &str,
    n_iterations: u32,
    stream: u64,
    plant: impl Fn(Film) -> Film,
) -> Batches {
    let setup = Setup::new(scene, size, size).by(method(id).expect("a method of the registry"));
    let mut batches = Batches::new(size, size, setup.settings.n_layers);
    for film in setup.batches(N_BATCHES, n_iterations, stream).films {
        batches.take(&plant(film));
    }
    batches
}

/// A film whose layer is brighter by a factor.
fn brightened(film: &Film, layer: usize, factor: f32) -> Film {
    let mut layers = film.layers();
    for value in &mut layers[layer] {
        *value *= factor;
    }
    let total = (0..film.n_pixels()).map(|pixel| {
        let values = layers.iter().map(|layer| layer[pixel]);
        values.fold(Rgb::BLACK, |sum, value| sum + value)
    });
    let total: Vec<Rgb> = total.collect();
    let size = (film.width(), film.height());
    let n = film.n_iterations();
    let variance = vec![Rgb::BLACK; total.len()];
    Film::from_parts(size, n, layers, total, &variance, 0).expect("of its own size")
}

fn names(terms: &[&Term]) -> Vec<String> {
    terms.iter().map(|term| term.view.to_string()).collect()
}

/// One percent, in one bounce, for two seconds by each method.
#[test]
fn a_planted_bias_lights_up_in_its_bounce() {
    const SIZE: usize = 64;
    const ITERATIONS: u32 = 32;
    const LAYER: usize = 2;
    let scene = builtin("cornell");
    let at = (&scene, SIZE);
    let honest = batches(at, "pt-mis", ITERATIONS, 1, |film| film);
    let other = batches(at, "bdpt", ITERATIONS, 2, |film| film);
    assert!(Agreement::of([&honest, &other], LEVEL).holds());
    for (factor, sign) in [(1.01, 1.0), (1.0 / 1.01, -1.0)] {
        let planted = |film: Film| brightened(&film, LAYER, factor);
        let biased = batches(at, "bdpt", ITERATIONS, 2, planted);
        let agreement = Agreement::of([&biased, &honest], LEVEL);
        let is_beyond = |term: &&Term| term.n_beyond > 0;
        let beyond: Vec<&Term> = agreement.terms.iter().filter(is_beyond).collect();
        assert_eq!(names(&beyond)[0], View::Term(LAYER).to_string());
        let others = beyond.iter().filter(|term| term.view != View::Total);
        assert_eq!(others.count(), 1, "{:?}", names(&beyond));
        let score = beyond[0].whole().expect("light everywhere");
        assert!(score.deviations * sign > agreement.limit, "{score:?}");
        for term in &agreement.terms {
            let map = map(&agreement, term, Grain::Blocks);
            let is_lit = |[r, _, b]: &[u8; 3]| sign * (f64::from(*r) - f64::from(*b)) > 30.0;
            let n_lit = map.pixels.iter().filter(|colour| is_lit(colour)).count();
            let n_grey = map
                .pixels
                .iter()
                .filter(|[r, g, b]| r == g && g == b)
                .count();
            match term.view {
                View::Term(LAYER) => assert_eq!((n_lit, n_grey), (SIZE * SIZE, 0)),
                View::Total => {}
                view => assert_eq!((n_lit, n_grey), (0, SIZE * SIZE), "{view}"),
            }
        }
    }
}

/// Over a hundred seeds no more alarms than are promised, and scores that spread as the normal
/// distribution does.
#[test]
fn without_a_bias_it_is_calm_at_the_stated_rate() {
    const SIZE: usize = 32;
    const N_SEEDS: u64 = 100;
    /// As many or fewer in 99.66 % of all cases, at the rate of one percent.
    const MOST_ALARMS: usize = 4;
    let scene = builtin("cornell");
    for ids in [["pt-mis", "pt-mis"], ["pt-mis", "bdpt"]] {
        let (mut alarms, mut pixel_alarms) = (Vec::new(), Vec::new());
        let (mut n, mut squares) = (0.0, 0.0);
        for seed in 0..N_SEEDS {
            let [a, b] = [0, 1].map(|i| {
                let stream = 1000 + 2 * seed + i as u64;
                batches((&scene, SIZE), ids[i], 2, stream, |film| film)
            });
            let agreement = Agreement::of([&a, &b], LEVEL);
            if !agreement.holds() {
                alarms.push(seed);
            }
            let has_alarm = |term: &Term| {
                (0..SIZE * SIZE).any(|pixel| term.is_beyond(pixel, agreement.pixel_limit))
            };
            if agreement.terms.iter().any(has_alarm) {
                pixel_alarms.push(seed);
            }
            for score in agreement.terms.iter().filter_map(Term::whole) {
                n += 1.0;
                squares += score.deviations.powi(2);
            }
            assert!(agreement.n_scores > 400, "{}", agreement.n_scores);
        }
        assert!(alarms.len() <= MOST_ALARMS, "{ids:?}: seeds {alarms:?}");
        assert!(
            pixel_alarms.len() <= MOST_ALARMS,
            "{ids:?}: pixels at seeds {pixel_alarms:?}"
        );
        // The largest of three channels, which hardly differ.
        let spread = f64::sqrt(squares / n);
        assert!((0.9..1.25).contains(&spread), "{ids:?}: {spread}");
    }
}
