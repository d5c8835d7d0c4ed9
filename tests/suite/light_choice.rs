//! Is the light that is aimed at chosen with the probability that is stated?
//!
//! From several points, lights chosen are counted and held against their probabilities by
//! chi-square; those that add to less than one leave the rest to choosing none. And no light that
//! can reach a point may be ruled out there.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use neumann_core::endpoint::light::{
    AreaLight, DirectionalLight, Emission, Light, LightInstance, MeshLights, PointLight, SpotLight,
};
use neumann_core::endpoint::{LightChoice, Lights, Receiver};
use neumann_core::radiometry::Rgb;
use neumann_core::scene::Scene;
use neumann_tests::lights::{BOUNDS, all_lights, environment_light, light_sample};
use neumann_tests::random::Random;
use neumann_tests::scenes::builtin;
use neumann_tests::statistics::{Estimate, Family, chi_square};

const TREE: LightChoice = LightChoice::Tree;
const N_SAMPLES: usize = 200_000;

/// A point in a box of the given half extent, uniform.
fn point(random: &mut Random, half: f32) -> Vec3 {
    let ([a, b], [c, _]) = (random.pair(), random.pair());
    half * (2.0 * Vec3::new(a, b, c) - 1.0)
}

fn receiver(random: &mut Random, half: f32) -> Receiver {
    let position = point(random, half);
    let normal = point(random, 1.0).normalize_or(Vec3::Z);
    Receiver::new(position, normal, random.pair()[0] < 0.3)
}

/// Triangles of many sizes and powers, points and spots, some of them in the same place.
fn jumble(n: usize, random: &mut Random) -> Vec<Light> {
    (0..n)
        .map(|i| {
            let center = if i % 7 == 3 {
                Vec3::splat(0.25)
            } else {
                point(random, 1.0)
            };
            let [size, strength] = random.pair().map(|u| 10f32.powf(3.0 * u - 3.0));
            let value = Rgb::splat(strength);
            match i % 5 {
                0 => Light::Point(PointLight {
                    position: center,
                    intensity: value,
                }),
                1 => Light::Spot(SpotLight {
                    position: center,
                    axis: point(random, 1.0).normalize_or(Vec3::X),
                    intensity: value,
                    inner_height: 0.1,
                    outer_height: if i % 2 == 0 { 0.2 } else { 0.9 },
                }),
                _ => {
                    let corner = |random: &mut Random| center + point(random, size);
                    let corners = [corner(random), corner(random), corner(random)];
                    let both_sides = i % 4 == 0;
                    let emission = Emission::Uniform(value);
                    Light::Area(AreaLight::new(i as u32, corners, emission, both_sides))
                }
            }
        })
        .collect()
}

fn distant() -> Vec<Light> {
    let directional = |x| {
        Light::Directional(DirectionalLight {
            direction: Vec3::new(x, -1.0, 0.2).normalize(),
            irradiance: Rgb::splat(0.5),
        })
    };
    vec![
        directional(0.3),
        Light::Environment(environment_light()),
        directional(-0.7),
    ]
}

/// Emissive meshes that are placed several times, some stretched, some as their mirror image, among
/// lights by themselves; and all
/// their lights by themselves.
fn instanced(n_triangles: usize, random: &mut Random) -> (Lights, Vec<Light>) {
    let singles = jumble(10, random);
    let mut copies = singles.clone();
    let mut instances = Vec::new();
    for (k, stretch) in [
        Vec3::ONE,
        Vec3::new(0.3, 1.5, 0.8),
        Vec3::new(-0.7, 0.7, 0.7),
    ]
    .into_iter()
    .enumerate()
    {
        let is_mirrored = stretch.x < 0.0;
        let lights: Vec<AreaLight> = (0..n_triangles)
            .map(|i| {
                let center = point(random, 0.5);
                let corners = [0; 3].map(|_| center + point(random, 0.2));
                let emission = Emission::Uniform(Rgb::splat(random.pair()[0]));
                AreaLight::new(2 * i as u32, corners, emission, i % 5 == 0)
            })
            .collect();
        let mesh = MeshLights::new(lights.clone(), 2 * n_triangles, is_mirrored)
            .expect("its lights have power");
        let mesh = Arc::new(mesh);
        for j in 0..3 {
            let turn = Quat::from_scaled_axis(point(random, 3.0));
            let place =
                Affine3A::from_scale_rotation_translation(stretch, turn, point(random, 1.0));
            let first = 10 + 2 * ((3 * k + j) * n_triangles) as u32;
            instances.push(LightInstance::new(Arc::clone(&mesh), place, first));
            copies.extend(lights.iter().map(|light| {
                let emitter = light.emitter();
                let corners = emitter.corners().map(|p| place.transform_point3(p));
                let emission = emitter.emission().clone();
                let triangle = first + light.triangle();
                Light::Area(AreaLight::new(
                    triangle,
                    corners,
                    emission,
                    emitter.is_double_sided(),
                ))
            }));
        }
    }
    (
        Lights::with_instances(singles, instances, 10, BOUNDS),
        copies,
    )
}

/// Instances give the light that copies of their meshes would, and rule out none of it.
#[test]
fn instances_shine_as_copies_do() {
    let mut family = Family::default();
    let mut random = Random::new(35);
    let (lights, copies) = instanced(20, &mut random);
    assert_eq!(lights.len(), copies.len());
    let n_triangles = 10 + 9 * 2 * 20;
    let all = Lights::new(copies.clone(), n_triangles, BOUNDS);
    let mut n_ruled_out = 0;
    for (i, copy) in copies.iter().enumerate().skip(10) {
        let Light::Area(copy) = copy else {
            panic!("light {i} is a triangle")
        };
        let (index, emitter) = lights.of_triangle(copy.triangle()).unwrap();
        assert_eq!((index, emitter.corners()), (i, copy.emitter().corners()));
        assert!(lights.of_triangle(copy.triangle() + 1).is_none());
    }
    for round in 0..40 {
        let at = receiver(&mut random, [0.3, 1.0, 4.0][round % 3]);
        for (i, light) in copies.iter().enumerate() {
            if lights.pmf_aim(&at, TREE, i) > 0.0 {
                continue;
            }
            n_ruled_out += 1;
            let alone = Lights::new(vec![light.clone()], n_triangles, BOUNDS);
            for _ in 0..10 {
                let u = light_sample(&mut random);
                let Some(aim) = alone.aim(&at, LightChoice::Power, &u) else {
                    continue;
                };
                let cos = at.normal.dot(aim.wi);
                let cos = if at.has_both_sides() { cos.abs() } else { cos };
                assert!(cos <= 1e-6, "light {i} reaches {at:?}: cos {cos}");
            }
        }
        for choice in [TREE, LightChoice::Power] {
            let mut lit = |lights: &Lights| {
                let values: Vec<f64> = (0..20_000)
                    .map(|_| {
                        let aim = lights.aim(&at, choice, &light_sample(&mut random));
                        aim.map_or(0.0, |aim| {
                            let cos = at.normal.dot(aim.wi);
                            let cos = if at.has_both_sides() {
                                cos.abs()
                            } else {
                                cos.max(0.0)
                            };
                            // So near a point, no number of samples would do.
                            if aim.distance < 0.1 {
                                return 0.0;
                            }
                            f64::from(aim.value.r * cos / aim.pdf_w)
                        })
                    })
                    .collect();
                Estimate::of(&values)
            };
            let (found, expected) = (lit(&lights), lit(&all));
            let what = format!("round {round}, {choice:?}: {found:?} against {expected:?}");
            family.add(found.p_value_against(&expected, 1e-4), what);
        }
    }
    assert!(n_ruled_out > 500, "only {n_ruled_out} were ruled out");
    let mut power = |lights: &Lights| {
        let values: Vec<f64> = (0..100_000)
            .map(|_| {
                let start = lights.start(&light_sample(&mut random));
                start.map_or(0.0, |s| f64::from(s.throughput().r))
            })
            .collect();
        Estimate::of(&values)
    };
    let (found, expected) = (power(&lights), power(&all));
    let what = format!("power: {found:?} against {expected:?}");
    family.add(found.p_value_against(&expected, 1e-4), what);
    family.judge();
}

fn sets(random: &mut Random) -> Vec<(&'static str, Lights)> {
    let lights = |lights: Vec<Light>| {
        let n_triangles = lights.len();
        Lights::new(lights, n_triangles, BOUNDS)
    };
    let joined = |n: usize, random: &mut Random| {
        let mut all = jumble(n, random);
        all.extend(distant());
        all
    };
    vec![
        ("instances", instanced(30, random).0),
        ("one", lights(jumble(1, random))),
        ("two", lights(jumble(2, random))),
        ("five", lights(jumble(5, random))),
        ("hundred", lights(jumble(100, random))),
        ("thousand", lights(jumble(1000, random))),
        ("far", lights(distant())),
        ("near and far", lights(joined(40, random))),
        (
            "one of each",
            lights(all_lights().into_iter().map(|(_, l)| l).collect()),
        ),
    ]
}

/// Counts the lights chosen from a point against what is stated.
fn count(family: &mut Family, name: &str, lights: &Lights, at: &Receiver, random: &mut Random) {
    let n = lights.len();
    for choice in [TREE, LightChoice::TreeBesideBsdf, LightChoice::Power] {
        let pmf: Vec<f64> = (0..n)
            .map(|i| f64::from(lights.pmf_aim(at, choice, i)))
            .collect();
        let sum: f64 = pmf.iter().sum();
        assert!(sum < 1.0 + 1e-4, "{name}: probabilities add to {sum}");
        // The last cell is for no light at all.
        let mut counts = vec![0.0; n + 1];
        for _ in 0..N_SAMPLES {
            match lights.choose(at, choice, random.pair()) {
                Some(chosen) => {
                    let (i, stated) = (chosen.light, chosen.pmf);
                    counts[i] += 1.0;
                    let ratio = f64::from(stated) / pmf[i];
                    assert!((ratio - 1.0).abs() < 1e-4, "{name}: {stated}, {}", pmf[i]);
                }
                None => counts[n] += 1.0,
            }
        }
        let rest = if sum > 1.0 - 1e-5 { 0.0 } else { 1.0 - sum };
        let expected: Vec<f64> = pmf
            .iter()
            .chain([&rest])
            .map(|p| p * N_SAMPLES as f64)
            .collect();
        if rest == 0.0 {
            // The sum is known to 1e-5, which is two of the samples: more than twelve are beyond
            // chance.
            assert!(counts[n] <= 12.0, "{name}: no light {} times", counts[n]);
        }
        if expected.iter().filter(|e| **e > 0.0).count() < 2 {
            continue;
        }
        let result = chi_square(&counts, &expected);
        family.add(result.p_value, format!("{name}, {choice:?}: {result:?}"));
    }
}

#[test]
fn lights_are_chosen_as_stated() {
    let mut family = Family::default();
    let mut random = Random::new(31);
    for (name, lights) in sets(&mut random) {
        for half in [0.4, 0.4, 1.0, 1.0, 5.0] {
            let at = receiver(&mut random, half);
            count(&mut family, name, &lights, &at, &mut random);
        }
    }
    for name in ["many", "plates", "cornell"] {
        let scene: &Scene = &builtin(name);
        let (min, max) = scene.bounds();
        for _ in 0..3 {
            let at = receiver(&mut random, 1.0);
            let inside = 0.5 * (min + max) + 0.5 * (max - min) * at.position;
            let at = Receiver::new(inside, at.normal, false);
            count(&mut family, name, scene.lights(), &at, &mut random);
        }
    }
    assert!(family.len() > 60, "only {} questions", family.len());
    family.judge();
}

/// What is ruled out must have nothing to give: otherwise its light would be missing from the
/// picture.
#[test]
fn no_light_that_reaches_a_point_is_ruled_out() {
    let mut random = Random::new(32);
    let (mut n_reached, mut n_ruled_out) = (0, 0);
    for round in 0..60 {
        let lights = jumble(1 + 5 * round, &mut random);
        let n = lights.len();
        let all = Lights::new(lights.clone(), n, BOUNDS);
        for half in [0.3, 1.0, 4.0] {
            // Some points lie on a light itself.
            let mut position = point(&mut random, half);
            if let (0, Light::Point(l)) = (round % 3, &lights[0]) {
                position = l.position + point(&mut random, 1e-3);
            }
            let normal = point(&mut random, 1.0).normalize_or(Vec3::Z);
            let has_both_sides = round % 2 == 0;
            let at = Receiver::new(position, normal, has_both_sides);
            for (i, light) in lights.iter().enumerate() {
                if all.pmf_aim(&at, TREE, i) > 0.0 {
                    continue;
                }
                n_ruled_out += 1;
                let alone = Lights::new(vec![light.clone()], n, BOUNDS);
                for _ in 0..30 {
                    let u = light_sample(&mut random);
                    let Some(aim) = alone.aim(&at, LightChoice::Power, &u) else {
                        continue;
                    };
                    let cos = normal.dot(aim.wi);
                    let cos = if has_both_sides { cos.abs() } else { cos };
                    assert!(
                        cos <= 0.0 || aim.value.is_black(),
                        "light {i} of {n} reaches {at:?}: {light:?}, cos {cos}, {aim:?}"
                    );
                }
            }
            n_reached += n;
        }
    }
    assert!(
        n_ruled_out > n_reached / 20,
        "only {n_ruled_out} of {n_reached} were ruled out"
    );
}

/// The same lights make the same tree.
#[test]
fn the_tree_is_made_the_same_again() {
    let make = || {
        let mut random = Random::new(33);
        let lights = jumble(500, &mut random);
        let at = receiver(&mut random, 1.0);
        let lights = Lights::new(lights, 500, BOUNDS);
        (0..500)
            .map(|i| lights.pmf_aim(&at, TREE, i).to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(make(), make());
}

/// Lights that leave a choice no way to tell them apart, and lights that no number can hold.
#[test]
fn odd_lights_are_chosen_too() {
    let mut random = Random::new(34);
    let at = receiver(&mut random, 1.0);
    let same = |n: usize, strength: f32| -> Vec<Light> {
        let light = Light::Point(PointLight {
            position: Vec3::splat(0.5),
            intensity: Rgb::splat(strength),
        });
        vec![light; n]
    };
    for n in [1, 2, 3, 300] {
        let lights = Lights::new(same(n, 2.0), n, BOUNDS);
        for i in 0..n {
            let share = lights.pmf_aim(&at, TREE, i) * n as f32;
            assert!((0.05..20.0).contains(&share), "{share} of {n}");
        }
    }
    for strength in [1e-35, 1e30] {
        let mut lights = same(3, strength);
        lights.extend(jumble(3, &mut random));
        let lights = Lights::new(lights, 6, BOUNDS);
        let on_it = Receiver::new(Vec3::splat(0.5), Vec3::Z, false);
        for at in [at, on_it] {
            let sum: f32 = (0..6).map(|i| lights.pmf_aim(&at, TREE, i)).sum();
            assert!((0.0..1.0 + 1e-4).contains(&sum), "{sum}");
        }
    }
}
