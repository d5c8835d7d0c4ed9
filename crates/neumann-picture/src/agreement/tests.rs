//! Batches of which it is known how they differ.

use neumann_core::film::{Film, View};
use neumann_core::radiometry::Rgb;

use super::{Agreement, Batches, FEWEST, Grain, Score};

const N: usize = 16;
const SIZE: usize = 16;

/// Numbers that look random, about 1, with a spread of some percent.
fn noise(stream: usize, batch: usize, pixel: usize) -> f32 {
    let mut x = (stream * 1_000_003 + batch * 10_007 + pixel) as u64;
    for factor in [0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb_u64] {
        x = (x ^ (x >> 30))
            .wrapping_add(0x9e37_79b9_7f4a_7c15)
            .wrapping_mul(factor);
    }
    1.0 + 0.2 * ((x >> 40) as f32 / (1u64 << 24) as f32 - 0.5)
}

/// Batches of one layer, which `value(batch, x, y)` is times noise, and a tail without light.
fn batches(stream: usize, value: impl Fn(usize, usize, usize) -> Rgb) -> Batches {
    some_batches(stream, N, value)
}

fn some_batches(stream: usize, n: usize, value: impl Fn(usize, usize, usize) -> Rgb) -> Batches {
    let mut batches = Batches::new(SIZE, SIZE, 1);
    for batch in 0..n {
        let pixels = 0..SIZE * SIZE;
        let layer = pixels
            .map(|pixel| value(batch, pixel % SIZE, pixel / SIZE) * noise(stream, batch, pixel));
        let layer: Vec<Rgb> = layer.collect();
        let black = vec![Rgb::BLACK; layer.len()];
        let layers = vec![layer.clone(), black.clone()];
        let film = Film::from_parts((SIZE, SIZE), 1, layers, layer, &black, 0);
        batches.take(&film.unwrap());
    }
    batches
}

fn white(stream: usize) -> Batches {
    batches(stream, |_, _, _| Rgb::WHITE)
}

fn first_term(a: &Batches, b: &Batches) -> super::Term {
    Agreement::of([a, b], 0.01).terms.remove(0)
}

#[test]
fn noise_is_none_and_a_small_bias_is_one_with_its_sign() {
    let (honest, other) = (white(1), white(2));
    let agreement = Agreement::of([&honest, &other], 0.01);
    assert!(agreement.holds());
    // The term and L, in the whole and its four quarters, in three channels.
    assert_eq!(agreement.n_scores, 2 * 5 * 3);
    let views: Vec<View> = agreement.terms.iter().map(|term| term.view).collect();
    assert_eq!(
        views,
        [View::Term(0), View::Total],
        "a black tail is left out"
    );
    let brighter = batches(3, |_, _, _| Rgb::splat(1.01));
    for (pair, sign) in [([&brighter, &honest], 1.0), ([&honest, &brighter], -1.0)] {
        let agreement = Agreement::of(pair, 0.01);
        assert!(!agreement.holds());
        let score = agreement.terms[0].whole().unwrap();
        assert!(score.is_beyond(agreement.limit));
        assert!(score.deviations * sign > 0.0, "{score:?}");
    }
}

#[test]
fn what_can_be_seen_is_told() {
    let agreement = Agreement::of([&white(1), &white(2)], 0.01);
    let seen_from = f64::from(agreement.terms[0].seen_from as f32);
    assert!((1e-4..0.01).contains(&seen_from), "{seen_from}");
    let is_seen = |factor: f64| {
        let from = agreement.terms[0].means[1] / agreement.terms[0].means[0];
        let brighter = batches(1, |_, _, _| {
            Rgb::splat((from * (1.0 + factor * seen_from)) as f32)
        });
        let score = first_term(&brighter, &white(2)).whole().unwrap();
        score.is_beyond(agreement.limit)
    };
    assert!(is_seen(1.05) && !is_seen(0.95), "{seen_from}");
}

#[test]
fn the_limit_grows_with_the_number_of_scores_and_falls_with_the_level() {
    let (a, b) = (white(1), white(2));
    let limit = |level| Agreement::of([&a, &b], level).limit;
    // P(|z| > 3.5875) = 0.01 / 30.
    assert!((limit(0.01) - 3.5875).abs() < 1e-3, "{}", limit(0.01));
    assert!(limit(1e-4) > limit(0.01) && limit(0.01) > limit(0.3));
}

#[test]
fn a_bias_is_found_in_its_quarter_and_in_its_channel() {
    let honest = white(1);
    let biased = batches(2, |_, x, y| {
        let is_there = x >= SIZE / 2 && y < SIZE / 2;
        Rgb::new(1.0, 1.0, if is_there { 1.1 } else { 1.0 })
    });
    let agreement = Agreement::of([&biased, &honest], 0.01);
    let (cell, score) = agreement.terms[0].largest().unwrap();
    let cell = agreement.cells.cell(cell);
    assert_eq!((cell.x, cell.y), ([8, 16], [0, 8]));
    assert_eq!(score.channel, 2);
    let map = super::map(&agreement, &agreement.terms[0], Grain::Blocks);
    let has_hue = |x: usize, y: usize| {
        let [r, g, b] = map.pixels[y * SIZE + x];
        !(r == g && g == b)
    };
    assert!(has_hue(12, 4), "the quarter lights up");
}

#[test]
fn rounding_is_no_difference() {
    let exact = |value: f32| {
        let mut batches = Batches::new(1, 1, 1);
        for _ in 0..N {
            let value = vec![Rgb::splat(value)];
            let layers = vec![value.clone(), vec![Rgb::BLACK]];
            let film = Film::from_parts((1, 1), 1, layers, value, &[Rgb::BLACK], 0);
            batches.take(&film.unwrap());
        }
        batches
    };
    assert!(Agreement::of([&exact(1.0), &exact(1.000_01)], 0.01).holds());
    assert!(!Agreement::of([&exact(1.0), &exact(1.001)], 0.01).holds());
}

#[test]
fn light_against_none_counts_where_it_is_sure_and_rare_light_is_not_judged() {
    let black = batches(1, |_, _, _| Rgb::BLACK);
    let honest = white(2);
    let term = first_term(&black, &honest);
    assert_eq!((term.n_beyond, term.n_judged(), term.n_rare), (5, 5, 0));
    assert_eq!(term.n_beyond_black, [5, 0]);
    // In all batches but one.
    let rare = batches(
        3,
        |batch, _, _| if batch == 5 { Rgb::BLACK } else { Rgb::WHITE },
    );
    for other in [&black, &honest] {
        let term = first_term(&rare, other);
        assert_eq!((term.n_judged(), term.n_rare), (0, 5));
    }
    assert!(Agreement::of([&black, &black], 0.01).terms.is_empty());
}

#[test]
fn none_in_a_part_of_where_there_is_some_at_times_is_not_judged() {
    let honest = white(1);
    let quarter = |x: usize, y: usize| x < SIZE / 2 && y < SIZE / 2;
    for (is_lit_always, n_judged, n_rare) in [(true, 5, 0), (false, 0, 5)] {
        let partly = batches(2, |batch, x, y| {
            let is_lit = !quarter(x, y) && (is_lit_always || batch != 5);
            if is_lit { Rgb::WHITE } else { Rgb::BLACK }
        });
        let term = first_term(&partly, &honest);
        assert_eq!((term.n_judged(), term.n_rare), (n_judged, n_rare));
        assert_eq!(term.n_beyond_black, [usize::from(is_lit_always), 0]);
    }
}

#[test]
fn a_pixel_has_the_colour_of_the_smallest_cell_that_is_beyond() {
    let biased = batches(1, |_, x, y| match (x < SIZE / 2, y < SIZE / 2) {
        (true, true) => Rgb::splat(1.5),
        (false, false) => Rgb::splat(0.9),
        _ => Rgb::WHITE,
    });
    let agreement = Agreement::of([&biased, &white(2)], 0.01);
    let term = &agreement.terms[0];
    let score = term.whole().unwrap();
    assert!(score.deviations > agreement.limit, "brighter as a whole");
    let map = super::map(&agreement, term, Grain::Blocks);
    let is_orange = |x: usize, y: usize| {
        let [r, _, b] = map.pixels[y * SIZE + x];
        assert_ne!(r, b);
        r > b
    };
    assert!(is_orange(2, 3) && !is_orange(12, 13));
    assert!(is_orange(12, 3), "of the whole, where the quarter is noise");
}

/// A mean that is low by chance has a low spread, too, where it is made of few contributions.
#[test]
fn errors_are_those_of_the_larger_mean() {
    let estimate = |mean, standard_error| super::Estimate {
        mean,
        standard_error,
        n: 33,
    };
    let (low, high) = (estimate(0.5, 0.05), estimate(1.0, 0.1));
    let score = Score::of(low, high, 0).deviations;
    // The relative error of both is 0.1, of 1.
    let expected = super::deviations(estimate(0.5, 0.1).p_value_against(&high, 0.0));
    assert!((score + expected).abs() < 1e-6, "{score} {expected}");
    assert!(score < -3.0);
}

/// Looks share the level: the earliest verdict has the eighth part of it, and none comes before.
#[test]
fn who_looks_often_is_deceived_no_more_often() {
    let limit = |n: usize| {
        let [a, b] = [1, 2].map(|stream| some_batches(stream, n, |_, _, _| Rgb::WHITE));
        let agreement = Agreement::while_watched([&a, &b], 0.01);
        assert_eq!(agreement.is_judged(), n >= FEWEST, "{n}");
        (Agreement::of([&a, &b], 0.01).limit, agreement.limit)
    };
    let (_, early) = limit(FEWEST - 1);
    assert!(early >= super::MOST_DEVIATIONS, "no verdict");
    let share = |n: f64| super::deviations(0.01 / 30.0 * 7.0 / (n * (n - 1.0)));
    for n in [8, 9, 16] {
        let (once, watched) = limit(n);
        assert!(watched > once);
        assert!((watched - share(n as f64)).abs() < 1e-9, "{n}");
    }
    let of_all: f64 = (8..100_000)
        .map(|n| 7.0 / f64::from(n) / f64::from(n - 1))
        .sum();
    assert!((of_all - 1.0).abs() < 1e-4);
}

#[test]
fn a_single_pixel_lights_up_by_its_own_score_and_rare_light_does_not() {
    let honest = white(1);
    let biased = batches(2, |_, x, y| {
        Rgb::splat(if (x, y) == (3, 5) { 2.0 } else { 1.0 })
    });
    let agreement = Agreement::of([&biased, &honest], 0.01);
    let term = &agreement.terms[0];
    assert!(
        agreement.pixel_limit > agreement.limit,
        "there are more of them"
    );
    let beyond: Vec<usize> = (0..SIZE * SIZE)
        .filter(|pixel| term.is_beyond(*pixel, agreement.pixel_limit))
        .collect();
    assert_eq!(beyond, [5 * SIZE + 3]);
    let hues = |grain| {
        let map = super::map(&agreement, term, grain);
        let has_hue = |[r, g, b]: &&[u8; 3]| !(r == g && g == b);
        map.pixels.iter().filter(has_hue).count()
    };
    assert_eq!(hues(Grain::Pixels), 1);
    assert_ne!(hues(Grain::Blocks), 1, "blocks have more pixels");
    // Once without light.
    let rare = batches(2, |batch, x, y| {
        let value = if batch == 4 { 0.0 } else { 2.0 };
        Rgb::splat(if (x, y) == (3, 5) { value } else { 1.0 })
    });
    let agreement = Agreement::of([&rare, &honest], 0.01);
    let term = &agreement.terms[0];
    assert!(!term.is_sure[5 * SIZE + 3] && term.is_sure[0]);
    assert!(!term.is_beyond(5 * SIZE + 3, 0.0));
}
