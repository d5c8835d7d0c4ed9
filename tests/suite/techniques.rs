//! Do the techniques of a bidirectional method, kept apart, add up to its image?

use std::sync::Arc;

use neumann_core::film::{Film, Joint, TechniqueFilm, TechniqueImage};
use neumann_core::integrator::{METHODS, Value, method};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{CancelToken, Renderer};
use neumann_tests::renders::{Setup, pool};
use neumann_tests::scenes::builtin;

const DIVISOR: usize = 4;

fn recorded(id: &str, scene: &str, max_bounces: u32) -> (Film, TechniqueFilm) {
    let setup = Setup::new(&builtin(scene), 64, 48)
        .by(method(id).expect("a method of the registry"))
        .up_to(max_bounces);
    let s = &setup.settings;
    let mut film = Film::new(s.width, s.height, s.n_layers);
    let mut renderer = Renderer::new(Arc::clone(&setup.scene), s.clone(), pool(), 0);
    renderer.record_techniques(Some(DIVISOR));
    for _ in 0..4 {
        film.add(
            renderer
                .iterate(&CancelToken::default())
                .expect("nobody cancels"),
        );
    }
    let techniques = renderer.techniques().expect("they were asked for").clone();
    (film, techniques)
}

#[test]
fn weighted_techniques_add_up_to_the_image() {
    // The last one has paths beyond the terms that are kept apart.
    for (id, scene, max_bounces) in [
        ("pt-mis", "cornell-glass", 6),
        ("bdpt", "lamps", 6),
        ("vcm", "cornell-glass", 6),
        ("bdpt", "bleed", 12),
    ] {
        let (film, techniques) = recorded(id, scene, max_bounces);
        assert_eq!(techniques.n_iterations(), 4);
        let mut sum = techniques.rest();
        assert_eq!(sum.iter().any(|c| !c.is_black()), max_bounces > 7);
        let mut n_merges = 0;
        for strategy in (0..techniques.n_bounces()).flat_map(|k| techniques.techniques(k)) {
            n_merges += usize::from(strategy.joint == Joint::Merge);
            let image = techniques.image(strategy, TechniqueImage::Weighted);
            for (s, value) in sum.iter_mut().zip(&image) {
                *s += *value;
            }
            let weights = techniques.image(strategy, TechniqueImage::Weight);
            assert!(weights.iter().all(|w| (0.0..=1.0 + 1e-5).contains(&w.g)));
        }
        assert_eq!(n_merges > 0, id == "vcm");
        let total = film.total();
        let mut relative: f32 = 0.0;
        for y in 0..techniques.height() {
            for x in 0..techniques.width() {
                let mut mean = Rgb::BLACK;
                for i in 0..DIVISOR * DIVISOR {
                    let (column, row) = (x * DIVISOR + i % DIVISOR, y * DIVISOR + i / DIVISOR);
                    mean += total[row * film.width() + column];
                }
                let mean = mean / (DIVISOR * DIVISOR) as f32;
                let apart = (mean - sum[y * techniques.width() + x]).map(f32::abs);
                relative = relative.max(apart.max_channel() / mean.max_channel().max(1e-3));
            }
        }
        assert!(relative < 1e-5, "{id} on {scene}: {relative}");
        let shares: f64 = (0..techniques.n_bounces())
            .flat_map(|k| techniques.techniques(k))
            .map(|strategy| techniques.share(strategy))
            .sum();
        assert!(shares <= 1.0 + 1e-6 && (max_bounces > 7 || shares > 1.0 - 1e-6));
    }
}

/// Recording is looking: it must not change what is rendered.
#[test]
fn recording_changes_no_bit() {
    for method in METHODS.iter().filter(|method| method.has_techniques) {
        let (film, _) = recorded(method.id, "cornell-glass", 6);
        let setup = Setup::new(&builtin("cornell-glass"), 64, 48)
            .by(method)
            .up_to(6);
        assert_eq!(setup.film(0, 4).layers(), film.layers(), "{}", method.id);
    }
}

/// Without merges, vertex connection and merging is bidirectional path tracing.
#[test]
fn vcm_without_merges_is_bdpt() {
    let scene = builtin("cornell-glass");
    let bdpt = Setup::new(&scene, 48, 32).by(method("bdpt").unwrap());
    let mut vcm = Setup::new(&scene, 48, 32).by(method("vcm").unwrap());
    vcm.settings.values.put("merge", Value::Switch(false));
    let (a, b) = (bdpt.film(0, 3), vcm.film(0, 3));
    for (x, y) in a.total().into_iter().zip(b.total()) {
        let apart = (x - y).map(f32::abs).max_channel();
        assert!(apart <= 1e-4 * x.max_channel().max(1e-3), "{x:?} {y:?}");
    }
}
