//! Does a surface give back what it received, and no more?
//!
//! White furnace: the albedo, `∫ f cos dω` plus the delta lobes, is at most 1 under importance
//! (radiance also grows and shrinks with the index of refraction). Reciprocity:
//! `f(wo, wi) = f(wi, wo)`, and across an interface what radiance meets one way importance
//! meets the other way.

use glam::Vec3;
use neumann_core::bsdf::{Bsdf, Scatter, TransportMode};
use neumann_core::radiometry::Rgb;
use neumann_tests::bsdfs::{Example, MODES, directions, examples, opaque};
use neumann_tests::cells::SphereCells;
use neumann_tests::random::Random;
use neumann_tests::statistics::{Estimate, Family};

/// Albedo by sampling: the mean of `f cos / pdf`, green.
fn albedo(bsdf: &Bsdf, wo: Vec3, mode: TransportMode, random: &mut Random) -> Estimate {
    let values: Vec<f64> = (0..20_000)
        .map(|_| {
            bsdf.sample(wo, random.triple(), mode)
                .map_or(0.0, |s| f64::from(s.f.g * s.wi.z.abs() / s.pdf_w))
        })
        .collect();
    Estimate::of(&values)
}

/// Albedo by numerical integration of `eval`, green, delta lobes not counted.
fn integrated_albedo(bsdf: &Bsdf, wo: Vec3, mode: TransportMode) -> f64 {
    let reflected = |wi: Vec3| f64::from(bsdf.eval(wo, wi, mode).g * wi.z.abs());
    SphereCells::even(16, 24).integrals(reflected).iter().sum()
}

#[test]
fn nothing_gives_more_than_it_gets() {
    let mut random = Random::new(10);
    for Example {
        name,
        bsdf,
        is_white,
        ..
    } in examples()
    {
        for wo in directions() {
            let a = albedo(&bsdf, wo, TransportMode::Importance, &mut random);
            // Facets that see light only once lose some of it, but never most of it.
            assert!(
                !is_white || a.mean > 0.25,
                "{name}, wo {wo}: albedo {:.4} of a white surface",
                a.mean
            );
            let limit = 1.0 + 5.0 * a.standard_error + 2e-3;
            assert!(
                a.mean <= limit,
                "{name}, wo {wo}: albedo {:.4} ± {:.4}",
                a.mean,
                a.standard_error
            );
        }
    }
}

/// Sampling and evaluating must tell of the same surface: the mean of `f cos / pdf` is `∫ f cos`.
#[test]
fn sampled_albedo_is_the_integral() {
    let mut random = Random::new(11);
    let mut family = Family::default();
    for Example { name, bsdf, .. } in examples() {
        // Where delta lobes take part, the integral knows only of the rest.
        if name == "mirror" || name.ends_with("alpha 0") || name.contains("smooth") {
            continue;
        }
        for wo in directions() {
            for mode in MODES {
                let a = albedo(&bsdf, wo, mode, &mut random);
                let integral = integrated_albedo(&bsdf, wo, mode);
                family.add(
                    a.p_value(integral, 1e-3),
                    format!(
                        "{name}, wo {wo}, {mode:?}: sampled {:.4} ± {:.4}, integrated \
                         {integral:.4}",
                        a.mean, a.standard_error
                    ),
                );
            }
        }
    }
    family.judge();
}

/// Under a white base the coat must not swallow light: what it does not reflect comes back
/// from the base, at any roughness.
#[test]
fn white_plastic_is_white() {
    let mut random = Random::new(12);
    for roughness in 0..=10 {
        let alpha = (roughness as f32 / 10.0).powi(2);
        let bsdf = Bsdf::MetallicRoughness(opaque(Rgb::WHITE, 0.0, alpha));
        for wo in directions() {
            let a = albedo(&bsdf, wo, TransportMode::Radiance, &mut random);
            assert!(
                a.mean > 0.97 && a.mean < 1.004 + 5.0 * a.standard_error,
                "alpha {alpha}, wo {wo}: albedo {:.4} ± {:.4}",
                a.mean,
                a.standard_error
            );
        }
    }
}

/// Mirrors, smooth glass and thin panes lose nothing at all.
#[test]
fn delta_lobes_conserve_energy() {
    let mut random = Random::new(13);
    for Example { name, bsdf, .. } in examples().into_iter().filter(|e| e.is_white) {
        if bsdf.has_density() {
            continue;
        }
        for wo in directions() {
            let a = albedo(&bsdf, wo, TransportMode::Importance, &mut random);
            assert!(
                (a.mean - 1.0).abs() < 1e-4 + 5.0 * a.standard_error && a.standard_error < 2e-3,
                "{name}, wo {wo}: albedo {:.6} ± {:.6}",
                a.mean,
                a.standard_error
            );
        }
    }
}

#[test]
fn reflection_is_reciprocal() {
    let mut n_compared = 0;
    for Example {
        name, bsdf, ior, ..
    } in examples()
    {
        let pairs = directions()
            .into_iter()
            .flat_map(|wo| directions().into_iter().map(move |wi| (wo, wi)));
        for (wo, wi) in pairs {
            // Importance walks from wi to wo what radiance walks from wo to wi.
            let there = bsdf.eval(wo, wi, TransportMode::Importance);
            let back = bsdf.eval(wi, wo, TransportMode::Radiance);
            let apart = (there - back).map(f32::abs).max_channel();
            assert!(
                apart <= 1e-3 * there.max_channel() + 1e-7,
                "{name}: importance {wo} to {wi} {there:?}, radiance back {back:?}"
            );
            // Radiance shrinks by the square of the index on the way out of glass. In a mix
            // only the glass transmits.
            let eta = match (wo.z > 0.0, wi.z > 0.0) {
                (true, false) => ior,
                (false, true) => 1.0 / ior,
                _ => 1.0,
            };
            let radiance = bsdf.eval(wo, wi, TransportMode::Radiance) * (eta * eta);
            let apart = (there - radiance).map(f32::abs).max_channel();
            assert!(
                apart <= 1e-3 * there.max_channel() + 1e-7,
                "{name}: {wo} to {wi}, importance {there:?}, radiance times eta² {radiance:?}"
            );
            n_compared += u32::from(!there.is_black());
        }
    }
    assert!(n_compared > 500, "only {n_compared} pairs scatter at all");
}

/// The same for smooth refraction, which only `sample` knows.
#[test]
fn smooth_refraction_scales_radiance() {
    let mut random = Random::new(14);
    let mut n_refracted = 0;
    for Example {
        name, bsdf, ior, ..
    } in examples()
    {
        for wo in directions() {
            for _ in 0..20 {
                let u = random.triple();
                let radiance = bsdf.sample(wo, u, TransportMode::Radiance);
                let importance = bsdf.sample(wo, u, TransportMode::Importance);
                let (Some(r), Some(i)) = (radiance, importance) else {
                    continue;
                };
                if !r.is_delta || r.wi.z * wo.z > 0.0 {
                    continue;
                }
                let eta = if wo.z > 0.0 { ior } else { 1.0 / ior };
                let ratio = i.f.max_channel() / r.f.max_channel();
                assert!(
                    (ratio / (eta * eta) - 1.0).abs() < 1e-4,
                    "{name}, wo {wo}: importance over radiance is {ratio}, eta² is {}",
                    eta * eta
                );
                // Snell: the tangents differ by the ratio of the indices.
                let snell = (r.wi.truncate() * eta + wo.truncate()).length();
                assert!(snell < 1e-5, "{name}, wo {wo}: refracted to {}", r.wi);
                n_refracted += 1;
            }
        }
    }
    assert!(
        n_refracted > 100,
        "only {n_refracted} samples were refracted"
    );
}
