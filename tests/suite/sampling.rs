//! Does each sampler draw from the density it states?
//!
//! Directions are counted in cells and held against the integral of the stated density by
//! chi-square. What a sampler does not return (absorbed, or a delta lobe) is a cell of its own
//! that expects what the density lacks to one, so the density must also integrate to what it
//! should. Lights and cameras have files of their own.

use std::f64::consts::PI;

use glam::Vec3;
use neumann_core::bsdf::Scatter;
use neumann_core::bsdf::microfacet::Ggx;
use neumann_core::sampling::discrete::{AliasTable, Grid2};
use neumann_core::sampling::warp;
use neumann_tests::bsdfs::{MODES, directions, examples};
use neumann_tests::cells::SphereCells;
use neumann_tests::random::Random;
use neumann_tests::statistics::{Family, chi_square};

const N_SAMPLES: usize = 60_000;

/// Counts what is drawn and compares it with the density.
fn test_directions(
    family: &mut Family,
    name: &str,
    cells: &SphereCells,
    pdf_w: impl Fn(Vec3) -> f64,
    draw: impl FnMut() -> Option<Vec3>,
) {
    test_directions_within(1e-4, family, name, cells, pdf_w, draw);
}

/// The same, where the density has edges that no quadrature sees more sharply than `blur`.
pub(super) fn test_directions_within(
    blur: f64,
    family: &mut Family,
    name: &str,
    cells: &SphereCells,
    pdf_w: impl Fn(Vec3) -> f64,
    mut draw: impl FnMut() -> Option<Vec3>,
) {
    let mut expected = cells.integrals(pdf_w);
    let total: f64 = expected.iter().sum();
    assert!(
        (-1e-5..1.0 + blur).contains(&total),
        "{name}: the density integrates to {total}"
    );
    expected.push((1.0 - total).max(0.0));
    let mut observed = vec![0.0; expected.len()];
    for _ in 0..N_SAMPLES {
        let cell = draw().map_or(expected.len() - 1, |w| cells.cell(w));
        observed[cell] += 1.0;
    }
    // Less than half a sample in the rest is rounding of the integral, not a promise.
    let floor = 0.5 / N_SAMPLES as f64;
    if expected[expected.len() - 1] < floor && observed[expected.len() - 1] == 0.0 {
        expected.pop();
        observed.pop();
    }
    let scale = N_SAMPLES as f64 / expected.iter().sum::<f64>();
    let expected: Vec<f64> = expected.iter().map(|e| e * scale).collect();
    let result = chi_square(&observed, &expected);
    family.add(result.p_value, format!("{name}: {result:.1?}"));
}

#[test]
fn value_and_density_together_are_what_they_are_alone() {
    let mut random = Random::new(3);
    for example in examples() {
        for (i, mode) in (0..400).flat_map(|i| MODES.map(|mode| (i, mode))) {
            let wo = directions()[i % directions().len()];
            let [a, b, _] = random.triple();
            let wi = warp::uniform_sphere([a, b]);
            let bsdf = &example.bsdf;
            let (f, pdf_w) = bsdf.eval_and_pdf_w(wo, wi, mode);
            let (f_alone, pdf_w_alone) = (bsdf.eval(wo, wi, mode), bsdf.pdf_w(wo, wi, mode));
            let is_close = |a: f32, b: f32| (a - b).abs() <= 1e-5 * b.abs();
            assert!(
                is_close(pdf_w, pdf_w_alone)
                    && std::iter::zip(f.to_array(), f_alone.to_array())
                        .all(|(a, b)| is_close(a, b)),
                "{}, {wo} to {wi}: {f:?} {pdf_w}, alone {f_alone:?} {pdf_w_alone}",
                example.name
            );
        }
    }
}

#[test]
fn warps_of_directions() {
    let mut family = Family::default();
    let mut random = Random::new(1);
    let cells = SphereCells::even(16, 24);
    let f = f64::from;
    test_directions(
        &mut family,
        "uniform hemisphere",
        &cells,
        |w| f(warp::UNIFORM_HEMISPHERE_PDF_W) * f(w.z.signum().max(0.0)),
        || Some(warp::uniform_hemisphere(random.pair())),
    );
    test_directions(
        &mut family,
        "cosine hemisphere",
        &cells,
        |w| f(warp::cosine_hemisphere_pdf_w(w.z)),
        || Some(warp::cosine_hemisphere(random.pair())),
    );
    test_directions(
        &mut family,
        "uniform sphere",
        &cells,
        |_| f(warp::UNIFORM_SPHERE_PDF_W),
        || Some(warp::uniform_sphere(random.pair())),
    );
    for cos in [0.9f32, 0.25, -0.5] {
        // A row of cells ends where the cone does.
        let rows = 8;
        let mut heights: Vec<f64> = (0..=rows)
            .map(|i| 1.0 - (1.0 - f(cos)) * f64::from(i) / f64::from(rows))
            .collect();
        heights.push(-1.0);
        test_directions(
            &mut family,
            &format!("cone of cosine {cos}"),
            &SphereCells::new(heights, 12, 0.0),
            |w| {
                if w.z > cos {
                    f(warp::uniform_cone_pdf_w(1.0 - cos))
                } else {
                    0.0
                }
            },
            || Some(warp::uniform_cone(random.pair(), 1.0 - cos)),
        );
    }
    family.judge();
}

#[test]
fn warps_of_points() {
    let mut family = Family::default();
    let mut random = Random::new(2);
    let n = 16;
    // Rings of equal area by sectors: all cells of a uniform disk are alike.
    let mut disk = vec![0.0; n * n];
    // Fourths of a triangle, fourfold: a barycentric grid of upright and turned cells.
    let mut triangle = vec![0.0; 2 * n * n];
    for _ in 0..N_SAMPLES {
        let p = warp::disk(random.pair()).as_dvec2();
        let ring = (p.length_squared() * n as f64) as usize;
        let sector = (p.y.atan2(p.x).rem_euclid(2.0 * PI) / (2.0 * PI) * n as f64) as usize;
        disk[ring.min(n - 1) * n + sector.min(n - 1)] += 1.0;
        let [a, b] = warp::triangle(random.pair()).map(|x| f64::from(x) * n as f64);
        assert!(a >= 0.0 && b >= 0.0 && a + b <= n as f64 + 1e-5);
        let is_turned = a.fract() + b.fract() > 1.0;
        let cell = (a as usize).min(n - 1) * n + (b as usize).min(n - 1);
        triangle[2 * cell + usize::from(is_turned)] += 1.0;
    }
    let result = chi_square(&disk, &vec![N_SAMPLES as f64 / (n * n) as f64; n * n]);
    family.add(result.p_value, format!("disk: {result:?}"));
    let expected: Vec<f64> = (0..2 * n * n)
        .map(|i| {
            let (turned, b, a) = (i % 2, i / 2 % n, i / 2 / n);
            let is_inside = a + b + turned < n;
            f64::from(u8::from(is_inside)) * N_SAMPLES as f64 / (n * n) as f64
        })
        .collect();
    let result = chi_square(&triangle, &expected);
    family.add(result.p_value, format!("triangle: {result:?}"));
    family.judge();
}

#[test]
fn discrete_choices() {
    let mut family = Family::default();
    let mut random = Random::new(3);
    let weights: Vec<f64> = (0..50).map(|i| f64::from(i * i % 17)).collect();
    let total: f64 = weights.iter().sum();
    let table = AliasTable::new(&weights).unwrap();
    let mut counts = vec![0.0; 50];
    for _ in 0..N_SAMPLES {
        let (index, pmf) = table.sample(random.pair()[0]);
        assert!((f64::from(pmf) - weights[index] / total).abs() < 1e-6);
        counts[index] += 1.0;
    }
    let scale = N_SAMPLES as f64 / total;
    let expected: Vec<f64> = weights.iter().map(|w| w * scale).collect();
    let result = chi_square(&counts, &expected);
    family.add(result.p_value, format!("alias table: {result:?}"));

    let grid = Grid2::new(10, 5, &weights).unwrap();
    let mut counts = vec![0.0; 50];
    for _ in 0..N_SAMPLES {
        let (p, density) = grid.sample(random.pair());
        let cell = (p[1] * 5.0) as usize * 10 + (p[0] * 10.0) as usize;
        assert!((f64::from(density) - weights[cell] / total * 50.0).abs() < 1e-4);
        assert!((density - grid.density(p)).abs() < 1e-6);
        counts[cell] += 1.0;
    }
    let result = chi_square(&counts, &expected);
    family.add(result.p_value, format!("grid: {result:?}"));
    family.judge();
}

#[test]
fn visible_normals() {
    let mut family = Family::default();
    let mut random = Random::new(4);
    // Rows even in angle, for normals crowd around the pole.
    let heights = (0..=32).map(|i| (PI * f64::from(i) / 32.0).cos()).collect();
    let cells = SphereCells::new(heights, 24, 0.0);
    for alpha in [0.05, 0.3, 1.0] {
        let ggx = Ggx { alpha };
        for wo in directions().into_iter().filter(|w| w.z > 0.0) {
            let pdf = |m: Vec3| {
                if m.z > 0.0 {
                    f64::from(ggx.pdf_w_visible(wo, m))
                } else {
                    0.0
                }
            };
            test_directions(
                &mut family,
                &format!("visible normals, alpha {alpha}, wo {wo}"),
                &cells,
                pdf,
                || Some(ggx.sample_visible(wo, random.pair())),
            );
        }
    }
    family.judge();
}

#[test]
fn bsdfs() {
    let mut family = Family::default();
    let mut random = Random::new(5);
    let cells = SphereCells::even(16, 24);
    for example in examples() {
        let bsdf = example.bsdf;
        if !bsdf.has_density() {
            continue;
        }
        for wo in directions() {
            for mode in MODES {
                let name = format!("{}, wo {wo}, {mode:?}", example.name);
                test_directions(
                    &mut family,
                    &name,
                    &cells,
                    |wi| f64::from(bsdf.pdf_w(wo, wi, mode)),
                    || {
                        let sample = bsdf.sample(wo, random.triple(), mode)?;
                        (!sample.is_delta).then_some(sample.wi)
                    },
                );
            }
        }
    }
    family.judge();
}

/// `sample` hands out `f` and `pdf_w`: they must be those of `eval` and `pdf_w`.
#[test]
fn samples_carry_the_values_of_their_direction() {
    let mut random = Random::new(6);
    for example in examples() {
        let bsdf = example.bsdf;
        for wo in directions() {
            for mode in MODES {
                for _ in 0..200 {
                    let Some(sample) = bsdf.sample(wo, random.triple(), mode) else {
                        continue;
                    };
                    let name = &example.name;
                    assert!(
                        (sample.wi.length() - 1.0).abs() < 1e-4,
                        "{name}: wi {} is not unit",
                        sample.wi
                    );
                    assert!(
                        sample.f.is_radiance() && sample.pdf_w > 0.0,
                        "{name}: {sample:?}"
                    );
                    if sample.is_delta {
                        assert!(sample.pdf_w <= 1.0 + 1e-6, "{name}: {sample:?}");
                        continue;
                    }
                    let pdf_w = bsdf.pdf_w(wo, sample.wi, mode);
                    let f = bsdf.eval(wo, sample.wi, mode);
                    let is_close = |a: f32, b: f32| (a - b).abs() <= 1e-4 * a.abs().max(b.abs());
                    assert!(
                        is_close(pdf_w, sample.pdf_w)
                            && is_close(f.r, sample.f.r)
                            && is_close(f.g, sample.f.g)
                            && is_close(f.b, sample.f.b),
                        "{name}, wo {wo}: sample {sample:?}, but pdf_w {pdf_w} and f {f:?}"
                    );
                }
            }
        }
    }
}
