//! Do lights start rays and get aimed at with the densities they state?
//!
//! Where positions are drawn, they are counted in cells by chi-square. Measures are checked by
//! what their inverse integrates to: the mean of `1 / pdf_w` is the solid angle that was drawn
//! from, and the mean of `value · cos / pdf` of started rays is the light's power.

use std::f32::consts::{PI, TAU};

use glam::{Mat3, Vec3};
use neumann_core::endpoint::light::{Emitter, Light};
use neumann_core::endpoint::{LightChoice, Lights};
use neumann_tests::cells::SphereCells;
use neumann_tests::lights::{
    BOUNDS, CORNERS, all_lights, anywhere, environment_light, light_sample, only,
};
use neumann_tests::random::Random;
use neumann_tests::statistics::{Estimate, Family, chi_square};

const N_SAMPLES: usize = 60_000;
const TREE: LightChoice = LightChoice::Tree;

/// Barycentric coordinates of a point of the triangle light.
fn barycentrics(p: Vec3) -> [f32; 2] {
    let (e1, e2) = (CORNERS[1] - CORNERS[0], CORNERS[2] - CORNERS[0]);
    let n = e1.cross(e2);
    let q = p - CORNERS[0];
    [
        q.cross(e2).dot(n) / n.length_squared(),
        e1.cross(q).dot(n) / n.length_squared(),
    ]
}

/// Solid angle of the triangle light (van Oosterom and Strackee 1983).
fn solid_angle(x: Vec3) -> f32 {
    let [a, b, c] = CORNERS.map(|v| (v - x).normalize());
    let numerator = a.dot(b.cross(c)).abs();
    2.0 * numerator.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// Cells of the triangle light, each a triangle: `n²` of them among `2 n²` numbers.
fn triangle_cell(b: [f32; 2], n: usize) -> usize {
    let [x, y] = b.map(|v| (v * n as f32).clamp(0.0, n as f32 - 1e-3));
    let is_turned = x.fract() + y.fract() > 1.0;
    2 * (y as usize * n + x as usize) + usize::from(is_turned)
}

#[test]
fn positions_on_area_lights() {
    let mut family = Family::default();
    let mut random = Random::new(20);
    let n = 12;
    let above = Vec3::new(0.2, 1.5, 0.4);
    let below = Vec3::new(0.2, -1.5, 0.4);
    for (name, light) in all_lights() {
        let Light::Area(area) = &light else { continue };
        let area = area.emitter();
        let lights = only(light.clone());
        // The density is constant over cells of the light's own, so cells of ours are averaged.
        let mut expected = vec![0.0; 2 * n * n];
        let fine = 240;
        for row in 0..fine {
            for column in 0..fine - row {
                let at = |d: f32| {
                    [
                        (column as f32 + d) / fine as f32,
                        (row as f32 + d) / fine as f32,
                    ]
                };
                for d in [1.0 / 3.0, 2.0 / 3.0] {
                    let b = at(d);
                    if b[0] + b[1] < 1.0 {
                        let mass = area.pdf_a(b) * area.area() / (fine * fine) as f32;
                        expected[triangle_cell(b, n)] += f64::from(mass) * N_SAMPLES as f64;
                    }
                }
            }
        }
        let total: f64 = expected.iter().sum();
        assert!(
            (total / N_SAMPLES as f64 - 1.0).abs() < 1e-3,
            "{name}: pdf_a integrates to {}",
            total / N_SAMPLES as f64
        );
        let mut started = vec![0.0; 2 * n * n];
        let mut aimed = vec![0.0; 2 * n * n];
        let mut inverse = Vec::new();
        let x = if lights
            .aim(&anywhere(above), TREE, &light_sample(&mut random))
            .is_some()
        {
            above
        } else {
            below
        };
        for _ in 0..N_SAMPLES {
            let u = light_sample(&mut random);
            let start = lights.start(&u).unwrap();
            let b = barycentrics(start.position);
            started[triangle_cell(b, n)] += 1.0;
            let stated = start.densities.pdf_a;
            assert!(
                (area.pdf_a(b) / stated - 1.0).abs() < 1e-3,
                "{name} at {b:?}"
            );
            let aim = lights.aim(&anywhere(x), TREE, &u).unwrap();
            let point = aim.surface.unwrap();
            aimed[triangle_cell(barycentrics(point.position), n)] += 1.0;
            inverse.push(1.0 / f64::from(aim.pdf_w));
            let cos = point.ng.dot(aim.wi).abs();
            let d = point.position - x;
            assert!((d.length() / aim.distance - 1.0).abs() < 1e-5);
            assert!((d.normalize() - aim.wi).length() < 1e-5);
            let pdf_w = aim.start.pdf_a * d.length_squared() / cos;
            assert!(
                (pdf_w / aim.pdf_w - 1.0).abs() < 1e-4,
                "{name}: pdf_w {}",
                aim.pdf_w
            );
            assert!((aim.start.pdf_w - area.pdf_w_start(-aim.wi)).abs() < 1e-6);
        }
        for (what, counts) in [("started", started), ("aimed at", aimed)] {
            let result = chi_square(&counts, &expected);
            family.add(result.p_value, format!("{name}, {what}: {result:?}"));
        }
        let estimate = Estimate::of(&inverse);
        let exact = f64::from(solid_angle(x));
        family.add(
            estimate.p_value(exact, 1e-5),
            format!("{name}: mean of 1/pdf_w {estimate:?}, solid angle {exact}"),
        );
    }
    family.judge();
}

#[test]
fn started_directions() {
    let mut family = Family::default();
    let mut random = Random::new(21);
    for (name, light) in all_lights() {
        let lights = only(light.clone());
        // Directions are counted about the light's own axis, and the environment's about +Y.
        let (axis, cells): (Vec3, SphereCells) = match &light {
            Light::Area(_) => {
                let n = (CORNERS[1] - CORNERS[0]).cross(CORNERS[2] - CORNERS[0]);
                (n.normalize(), SphereCells::even(16, 12))
            }
            Light::Spot(spot) => (
                spot.axis,
                SphereCells::new(vec![1.0, 0.9, 0.7, 0.5, -1.0], 12, 0.0),
            ),
            _ => (Vec3::Z, SphereCells::even(16, 12)),
        };
        let up = axis.any_orthonormal_vector();
        let to_local = Mat3::from_cols(up, axis.cross(up), axis).transpose();
        let pdf = |w: Vec3| -> f64 {
            let world = to_local.transpose() * w;
            f64::from(match &light {
                Light::Area(area) => area.emitter().pdf_w_start(world),
                Light::Point(_) => 0.25 / PI,
                Light::Spot(s) if w.z > 1.0 - s.outer_height => 1.0 / (TAU * s.outer_height),
                _ => 0.0,
            })
        };
        if matches!(light, Light::Directional(_) | Light::Environment(_)) {
            continue;
        }
        let mut expected = cells.integrals(pdf);
        for e in &mut expected {
            *e *= N_SAMPLES as f64;
        }
        let mut observed = vec![0.0; expected.len()];
        for _ in 0..N_SAMPLES {
            let Some(start) = lights.start(&light_sample(&mut random)) else {
                continue;
            };
            let local = to_local * start.direction;
            observed[cells.cell(local)] += 1.0;
            let stated = f64::from(start.densities.pdf_w);
            assert!((pdf(local) / stated - 1.0).abs() < 1e-3, "{name}: {stated}");
        }
        let result = chi_square(&observed, &expected);
        family.add(result.p_value, format!("{name}: {result:?}"));
    }
    family.judge();
}

#[test]
fn directions_from_the_environment() {
    let mut family = Family::default();
    let mut random = Random::new(22);
    let light = environment_light();
    let lights = only(Light::Environment(light.clone()));
    let here = anywhere(Vec3::ZERO);
    // Columns and rows of the map, each row cut in two. Local axes: x to -Z, y to +X, z to +Y,
    // so that the angle is 2π (u - 1/2) before the turn by the rotation.
    let local = |w: Vec3| Vec3::new(-w.z, w.x, w.y);
    let world = |l: Vec3| Vec3::new(l.y, l.z, -l.x);
    let heights = (0..=16)
        .map(|i| (std::f64::consts::PI * f64::from(i) / 16.0).cos())
        .collect();
    let cells = SphereCells::new(heights, 16, 0.0);
    let expected: Vec<f64> = cells
        .integrals(|l| f64::from(lights.environment_densities(&here, TREE, world(l)).0))
        .iter()
        .map(|e| e * N_SAMPLES as f64)
        .collect();
    let total = expected.iter().sum::<f64>() / N_SAMPLES as f64;
    assert!((total - 1.0).abs() < 1e-3, "density integrates to {total}");
    let (mut aimed, mut started) = (vec![0.0; cells.n_cells()], vec![0.0; cells.n_cells()]);
    for _ in 0..N_SAMPLES {
        let u = light_sample(&mut random);
        let aim = lights.aim(&here, TREE, &u).unwrap();
        aimed[cells.cell(local(aim.wi))] += 1.0;
        let (pdf_w, densities) = lights.environment_densities(&here, TREE, aim.wi);
        assert!(
            (pdf_w / aim.pdf_w - 1.0).abs() < 1e-3,
            "{pdf_w} {}",
            aim.pdf_w
        );
        assert!((densities.pdf_a / aim.start.pdf_a - 1.0).abs() < 1e-5);
        let value = light.radiance(aim.wi);
        assert!((value - aim.value).map(f32::abs).max_channel() < 1e-4);
        let start = lights.start(&u).unwrap();
        started[cells.cell(local(-start.direction))] += 1.0;
    }
    for (what, counts) in [("aimed", aimed), ("started", started)] {
        let result = chi_square(&counts, &expected);
        family.add(result.p_value, format!("{what}: {result:?}"));
    }
    family.judge();
}

/// The mean of `value cos / pdf` over started rays is the light's power, `∫∫ L cos dA dω`.
#[test]
fn started_rays_carry_the_power() {
    let mut family = Family::default();
    let mut random = Random::new(23);
    let across = PI * BOUNDS.radius * BOUNDS.radius;
    let mut sum = 0.0;
    let mut mixed = Vec::new();
    for (name, light) in all_lights() {
        let exact = match &light {
            Light::Area(l) if name == "area" => 4.0 * PI * l.emitter().area(),
            Light::Area(l) if name == "area, both sides" => 8.0 * PI * l.emitter().area(),
            Light::Point(_) => 3.0 * 4.0 * PI,
            // The squared linear ramp in cosine integrates to a third of its width.
            Light::Spot(_) => 3.0 * TAU * (0.1 + 0.4 / 3.0),
            Light::Directional(_) => 2.0 * across,
            Light::Area(l) => power_sent(&l.emitter()),
            _ => light.power(BOUNDS).r,
        };
        sum += exact;
        mixed.push(light.clone());
        let lights = only(light);
        let power = power_of(&lights, &mut random);
        family.add(
            power.p_value(f64::from(exact), 1e-4),
            format!("{name}: {power:?}, exact {exact}"),
        );
    }
    // All together: the choice among lights must be undone by its probability.
    let lights = Lights::new(mixed, 1, BOUNDS);
    let pmf: f32 = (0..lights.as_slice().len())
        .map(|i| lights.pmf_start(i))
        .sum();
    assert!((pmf - 1.0).abs() < 1e-5, "probabilities add to {pmf}");
    let power = power_of(&lights, &mut random);
    family.add(
        power.p_value(f64::from(sum), 1e-4),
        format!("all: {power:?}, exact {sum}"),
    );
    family.judge();
}

/// `π ∫ L dA` of a light that shines from its front, by the midpoints of many small triangles.
fn power_sent(emitter: &Emitter<'_>) -> f32 {
    let n = 500;
    let normal = (CORNERS[1] - CORNERS[0]).cross(CORNERS[2] - CORNERS[0]);
    let mut sum = 0.0;
    for i in 0..n * n {
        for d in [1.0 / 3.0, 2.0 / 3.0] {
            let b = [i % n, i / n].map(|k| (k as f32 + d) / n as f32);
            if b[0] + b[1] < 1.0 {
                sum += f64::from(emitter.sent(b, normal.normalize()).r);
            }
        }
    }
    PI * emitter.area() * (sum / f64::from(n * n)) as f32
}

fn power_of(lights: &Lights, random: &mut Random) -> Estimate {
    let values: Vec<f64> = (0..N_SAMPLES)
        .map(|_| {
            lights.start(&light_sample(random)).map_or(0.0, |s| {
                f64::from(s.value.r * s.cos / (s.densities.pdf_a * s.densities.pdf_w))
            })
        })
        .collect();
    Estimate::of(&values)
}

/// The irradiance that aiming at all lights together finds is the sum of what each alone gives:
/// the choice among lights enters the densities, whatever it is made by.
#[test]
fn the_choice_of_a_light_is_weighed() {
    let mut family = Family::default();
    let mut random = Random::new(24);
    let x = Vec3::new(0.3, -1.4, 0.1);
    let mut fluence = |lights: &Lights, choice: LightChoice| -> Estimate {
        let values: Vec<f64> = (0..N_SAMPLES)
            .map(|_| {
                let aim = lights.aim(&anywhere(x), choice, &light_sample(&mut random));
                aim.map_or(0.0, |a| f64::from(a.value.r / a.pdf_w))
            })
            .collect();
        Estimate::of(&values)
    };
    let alone: Vec<Estimate> = all_lights()
        .into_iter()
        .map(|(_, light)| fluence(&only(light), TREE))
        .collect();
    let all = Lights::new(
        all_lights().into_iter().map(|(_, l)| l).collect(),
        1,
        BOUNDS,
    );
    let sum = Estimate {
        mean: alone.iter().map(|e| e.mean).sum(),
        standard_error: alone
            .iter()
            .map(|e| e.standard_error.powi(2))
            .sum::<f64>()
            .sqrt(),
        n: N_SAMPLES,
    };
    assert!(sum.mean > 0.0);
    for choice in [TREE, LightChoice::Power] {
        let together = fluence(&all, choice);
        family.add(
            together.p_value_against(&sum, 1e-5),
            format!("{choice:?}: together {together:?}, one by one {sum:?}"),
        );
    }
    family.judge();
}
