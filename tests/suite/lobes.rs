//! Do lobes, looked at, show the BSDF that is rendered? What is known of BSDFs is the referee.

use std::f64::consts::PI;

use glam::Vec3;
use neumann_core::bsdf::microfacet::Ggx;
use neumann_core::bsdf::{Bsdf, BsdfSample, Conductor, Lambert, Scatter, TransportMode};
use neumann_core::radiometry::Rgb;
use neumann_core::render::CancelToken;
use neumann_core::render::lobe::{ANGLES, Lobes, Reciprocity, Viewed, viewer};
use neumann_tests::bsdfs::examples;
use neumann_tests::statistics::{Family, chi_square};

/// All examples from all angles, from before the surface and from behind.
fn all_views(mut look: impl FnMut(&str, &Bsdf, &Viewed)) {
    for example in examples() {
        for is_behind in [false, true] {
            for angle in ANGLES {
                let view = Viewed::new(&example.bsdf, angle, is_behind);
                let what = format!("{}, {angle}°, behind: {is_behind}", example.name);
                look(&what, &example.bsdf, &view);
            }
        }
    }
}

fn metal(alpha: f32) -> Conductor {
    Conductor {
        f0: Rgb::new(0.9, 0.6, 0.3),
        f90: Rgb::WHITE,
        ggx: Ggx { alpha },
    }
}

#[test]
fn probabilities_add_up_to_one() {
    all_views(|what, _, view| {
        let refused = view.drawn.refused;
        let of_chance = 5.0 * (refused * (1.0 - refused) / f64::from(view.drawn.n)).sqrt();
        let total = view.total_probability();
        assert!(
            (total - 1.0).abs() < of_chance + 1e-3,
            "{what}: density {}, mirror-like {}, refused {refused}",
            view.integrals.pdf_w,
            view.drawn.p_delta()
        );
    });
}

/// Dots in blocks of pixels against the density that is shown below them.
#[test]
fn dots_lie_as_the_density_that_is_shown() {
    const BLOCK: usize = 8;
    let mut family = Family::default();
    all_views(|what, bsdf, view| {
        if !bsdf.has_density() {
            assert!(view.drawn.dots.is_empty(), "{what}");
            return;
        }
        let (width, height) = view.map.size();
        let n_columns = width / BLOCK;
        let mut expected = vec![0.0; n_columns * (height / BLOCK)];
        for (i, density) in view.density.iter().enumerate() {
            let (x, y) = (i % width, i / width);
            expected[y / BLOCK * n_columns + x / BLOCK] += f64::from(*density);
        }
        let mut observed = vec![0.0; expected.len()];
        for dot in &view.drawn.dots {
            let [x, y] = view.map.place(*dot).expect("it is on a disk");
            let at = |p: f32, n: usize| (p as usize).min(n - 1) / BLOCK;
            observed[at(y, height) * n_columns + at(x, width)] += 1.0;
        }
        let scale = view.drawn.dots.len() as f64 / expected.iter().sum::<f64>();
        // A pixel across the edge of a disk counts for less than it says; a block of them alone is
        // no cell of its own.
        let expected: Vec<f64> = expected.iter().map(|e| e * scale + 1e-3).collect();
        let result = chi_square(&observed, &expected);
        family.add(result.p_value, format!("{what}: {result:.1?}"));
    });
    assert!(family.len() > 150);
    family.judge();
}

/// `f = albedo / π` above the surface, nothing below it, and the same albedo from everywhere.
#[test]
fn diffuse_reflection_is_a_half_circle() {
    let albedo = Rgb::new(0.8, 0.5, 0.1);
    let lambert = Bsdf::Lambert(Lambert { albedo });
    let lobes = Lobes::new(&lambert, &ANGLES, false, &CancelToken::default()).expect("it is not");
    let is_close = |a: Rgb, b: Rgb| (a - b).map(f32::abs).max_channel() < 1e-5;
    for view in &lobes.views {
        let plane = view.polar.iter().map(|p| (p.wi, p.f));
        let everywhere = view.solid.directions.iter().copied();
        let everywhere = everywhere.zip(view.solid.f.iter().copied());
        for (wi, f) in plane.chain(everywhere) {
            let expected = if wi.z > 0.0 {
                albedo * (1.0 / PI) as f32
            } else {
                Rgb::BLACK
            };
            assert!(is_close(f, expected), "{wi}: {f:?}");
        }
        let found = f64::from(albedo.luminance());
        assert!((view.integrals.f_cos - found).abs() < 1e-5);
        assert!(view.drawn.deltas.is_empty() && view.drawn.refused == 0.0);
    }
    assert!(lobes.albedo.len() > 25);
    for at in &lobes.albedo {
        assert!(is_close(at.albedo, albedo), "{at:?}");
        assert_eq!(at.specular_share(), 0.0);
    }
    let reciprocity = lobes.reciprocity.expect("there are values");
    assert!(reciprocity.n_pairs > 3000 && reciprocity.largest == 0.0);
}

/// Fresnel's and Snell's laws.
#[test]
fn mirror_like_lobes_are_where_the_laws_have_them() {
    let named = |name: &str| {
        let mut all = examples().into_iter();
        all.find(|e| e.name == name).expect("an example").bsdf
    };
    let glass = named("solid glass 1.5, alpha 0");
    for (is_behind, eta) in [(false, 1.5f32), (true, 1.0 / 1.5)] {
        for angle in ANGLES {
            let view = Viewed::new(&glass, angle, is_behind);
            let wo = view.wo;
            let mirrored = Vec3::new(-wo.x, 0.0, wo.z);
            let sin_t = -wo.x / eta;
            let reflectance = if sin_t.abs() < 1.0 {
                let (cos_i, cos_t) = (wo.z.abs(), (1.0 - sin_t * sin_t).sqrt());
                let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
                let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
                0.5 * (s * s + p * p)
            } else {
                1.0
            };
            let mut expected = vec![(mirrored, reflectance)];
            if reflectance < 1.0 {
                let z = -(1.0 - sin_t * sin_t).sqrt().copysign(wo.z);
                expected.push((Vec3::new(sin_t, 0.0, z), 1.0 - reflectance));
            }
            assert_eq!(view.drawn.deltas.len(), expected.len(), "{angle}");
            for (wi, share) in expected {
                let mut lobes = view.drawn.deltas.iter();
                let lobe = lobes.find(|lobe| lobe.wi.distance(wi) < 1e-4);
                let lobe = lobe.unwrap_or_else(|| panic!("{angle}: nothing towards {wi}"));
                assert!((lobe.share.g - share).abs() < 1e-4, "{lobe:?} {share}");
            }
            let at = view.albedo();
            assert!((at.albedo.g - 1.0).abs() < 1e-4 && at.specular_share() > 0.999);
            assert_eq!(view.integrals.pdf_w, 0.0);
        }
    }
    let view = Viewed::new(&named("mirror"), 60.0, false);
    assert_eq!(view.drawn.deltas.len(), 1);
    assert!((view.drawn.p_delta() - 1.0).abs() < 1e-6);
    // Of two kinds of lobes, the shares of both make the albedo.
    let at = Viewed::new(&named("opaque, metallic 0, alpha 0"), 30.0, false).albedo();
    assert!((0.02..0.2).contains(&at.specular_share()), "{at:?}");
}

#[test]
fn albedo_by_quadrature_is_the_mean_over_directions_that_are_drawn() {
    let mut n = 0;
    for example in examples() {
        for is_behind in [false, true] {
            let cancel = CancelToken::default();
            let lobes = Lobes::new(&example.bsdf, &[30.0], is_behind, &cancel).expect("it is not");
            for at in &lobes.albedo {
                let apart = (f64::from(at.albedo.luminance()) - at.sampled).abs();
                assert!(
                    apart < 5.0 * at.standard_error + 2e-3,
                    "{}, behind: {is_behind}: {at:?}",
                    example.name
                );
                n += 1;
            }
        }
    }
    assert!(n > 1000);
}

/// A BSDF with something wrong about it.
#[derive(Clone, Copy)]
struct Planted<'a> {
    bsdf: &'a Bsdf,
    /// How strongly values depend on the direction to the viewer alone.
    bent: f32,
    /// What densities are multiplied by.
    density: f32,
}

impl Scatter for Planted<'_> {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> Rgb {
        self.bsdf.eval(wo, wi, mode) * (1.0 + self.bent * wo.z.abs())
    }

    fn pdf_w(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> f32 {
        self.bsdf.pdf_w(wo, wi, mode) * self.density
    }

    fn sample(&self, wo: Vec3, u: [f32; 3], mode: TransportMode) -> Option<BsdfSample> {
        self.bsdf.sample(wo, u, mode)
    }
}

#[test]
fn reciprocity_holds_and_its_lack_is_seen() {
    for example in examples() {
        let found = Reciprocity::of(&example.bsdf);
        assert_eq!(
            found.is_some(),
            example.bsdf.has_density(),
            "{}",
            example.name
        );
        let Some(found) = found else { continue };
        assert!(found.n_pairs > 500, "{}: {found:?}", example.name);
        assert!(found.holds(), "{}: {found:?}", example.name);
        let planted = Planted {
            bsdf: &example.bsdf,
            bent: 0.1,
            density: 1.0,
        };
        let found = Reciprocity::of(&planted).expect("it scatters");
        assert!(!found.holds(), "{}: {found:?}", example.name);
    }
}

#[test]
fn a_wrong_density_is_seen() {
    let planted = |density| {
        let copper = Bsdf::Conductor(metal(0.3));
        let planted = Planted {
            bsdf: &copper,
            bent: 0.0,
            density,
        };
        Viewed::new(&planted, 30.0, false).total_probability()
    };
    assert!((planted(1.0) - 1.0).abs() < 4e-3);
    assert!(planted(0.97) < 0.98);
}

/// The narrowest lobes are met by plots at their heights, and end where they end.
#[test]
fn narrow_lobes_are_not_missed() {
    for alpha in [0.0012, 0.01, 0.1] {
        let metal = metal(alpha);
        for angle in ANGLES {
            let view = Viewed::new(&metal, angle, false);
            let wo = viewer(angle, false);
            let value = |wi| metal.eval(wo, wi, TransportMode::Radiance).max_channel();
            let peak = Vec3::new(-wo.x, 0.0, wo.z);
            let height = value(peak);
            let largest =
                |all: &mut dyn Iterator<Item = Rgb>| all.map(Rgb::max_channel).fold(0.0, f32::max);
            let of_plane = largest(&mut view.polar.iter().map(|p| p.f));
            let of_solid = largest(&mut view.solid.f.iter().copied());
            for (what, found) in [("plane", of_plane), ("solid", of_solid)] {
                assert!(
                    found > 0.9 * height,
                    "{alpha}, {angle}, {what}: {found} of {height}"
                );
            }
            // A straight line from one direction of the plane to the next is the curve.
            for pair in view.polar.windows(2) {
                let middle = (pair[0].wi + pair[1].wi).normalize();
                if middle.z > 0.01 {
                    let line = 0.5 * (pair[0].f + pair[1].f).max_channel();
                    let apart = (value(middle) - line).abs();
                    assert!(
                        apart < 0.02 * of_plane,
                        "{alpha}, {angle}, {middle}: {apart}"
                    );
                }
            }
        }
    }
}
