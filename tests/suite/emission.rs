//! Does light come from where a surface emits, and from as much of it as there is?
//!
//! Emission may vary by a texture, and be seen through coverage: a factor, a texture, vertices.
//! Points of such lamps are drawn
//! with the density that is stated, wherever texture coordinates lead; every method sees the same
//! lamp, and what it lights.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3, Vec4};
use neumann_core::integrator::METHODS;
use neumann_core::radiometry::Rgb;
use neumann_core::scene::Scene;
use neumann_core::scene::description::{
    AlphaMode, EnvironmentDescription, Filter, ImageDescription, MaterialDescription,
    MeshDescription, TextureDescription, Wrap,
};
use neumann_tests::lights::{BOUNDS, CORNERS, light_sample};
use neumann_tests::random::Random;
use neumann_tests::renders::Setup;
use neumann_tests::scenes::{Stage, emitter, lambert, looking, rectangle};
use neumann_tests::statistics::{Estimate, Family, chi_square};

/// An image of grey and alpha.
fn image(n: usize, texel: impl Fn(usize, usize) -> [u8; 2]) -> ImageDescription {
    let texels = (0..n * n).map(|i| {
        let [grey, alpha] = texel(i % n, i / n);
        [grey, grey, grey, alpha]
    });
    ImageDescription {
        width: n,
        height: n,
        texels: texels.collect(),
        ..Default::default()
    }
}

fn texture(filter: Filter, wrap: Wrap) -> TextureDescription {
    TextureDescription {
        image: 0,
        uv_set: 0,
        image_from_mesh_uv: Mat3::IDENTITY,
        wrap_u: wrap,
        wrap_v: wrap,
        filter,
    }
}

/// A triangle by itself, as a lamp.
fn triangle(
    material: MaterialDescription,
    image: ImageDescription,
    uvs: [Vec2; 3],
    alphas: Option<[f32; 3]>,
) -> Arc<Scene> {
    let mut stage = Stage::default();
    stage.description.images = vec![image];
    let mesh = MeshDescription {
        positions: CORNERS.to_vec(),
        triangles: vec![[0, 1, 2]],
        uv_sets: vec![uvs.to_vec()],
        colors: alphas.map(|alphas| alphas.map(|a| Vec4::new(1.0, 1.0, 1.0, a)).to_vec()),
        ..Default::default()
    };
    stage.add("lamp", mesh, material);
    stage.scene()
}

fn few_lit(x: usize, y: usize) -> [u8; 2] {
    let is_lit = [(3, 4), (4, 4), (11, 9), (15, 0)].contains(&(x, y));
    [if is_lit { 255 } else { 0 }, 255]
}

fn varied(x: usize, y: usize) -> [u8; 2] {
    let n = x * 37 + y * 101;
    [60 + (n % 190) as u8, 20 + (n % 230) as u8]
}

/// Triangles on which points are drawn in every way there is.
fn triangles() -> Vec<(&'static str, Arc<Scene>)> {
    let lit_by = |texture| MaterialDescription {
        emission_texture: Some(texture),
        ..emitter(3.0)
    };
    let covered_by = |texture, alpha_mode| MaterialDescription {
        base_color_texture: Some(texture),
        alpha_mode,
        ..emitter(3.0)
    };
    let (linear, nearest) = (Filter::Linear, Filter::Nearest);
    let uvs = |scale: f32, shift: f32| {
        [
            Vec2::new(0.1, 0.2),
            Vec2::new(0.9, 0.3),
            Vec2::new(0.3, 0.8),
        ]
        .map(|uv| (uv - 0.5) * scale + shift)
    };
    let turned = TextureDescription {
        image_from_mesh_uv: Mat3::from_scale_angle_translation(
            Vec2::new(2.0, 0.7),
            0.6,
            Vec2::new(-0.4, 0.3),
        ),
        ..texture(nearest, Wrap::Repeat)
    };
    let lit = |texture, texel: fn(usize, usize) -> [u8; 2], uvs| {
        triangle(lit_by(texture), image(16, texel), uvs, None)
    };
    let repeat = texture(linear, Wrap::Repeat);
    let mirror = Wrap::MirroredRepeat;
    let blend = AlphaMode::Blend;
    let mask = AlphaMode::Mask { cutoff: 0.5 };
    let vertices = MaterialDescription {
        alpha_mode: blend,
        ..emitter(3.0)
    };
    let plain = || image(1, |_, _| [255, 255]);
    vec![
        ("few texels", lit(repeat, few_lit, uvs(1.5, 0.5))),
        (
            "few texels, nearest, turned",
            lit(turned, few_lit, uvs(2.0, 0.1)),
        ),
        (
            "mirrored",
            lit(texture(linear, mirror), varied, uvs(3.0, -0.7)),
        ),
        (
            "mirrored, nearest",
            lit(texture(nearest, mirror), few_lit, uvs(3.0, -0.7)),
        ),
        (
            "clamped",
            lit(texture(linear, Wrap::ClampToEdge), varied, uvs(2.5, 0.3)),
        ),
        (
            "clamped, nearest",
            lit(texture(nearest, Wrap::ClampToEdge), varied, uvs(2.5, 0.6)),
        ),
        ("over and over", lit(repeat, varied, uvs(9.0, 0.3))),
        ("beyond all rows", lit(repeat, varied, uvs(30_000.0, 0.3))),
        ("turned round", lit(repeat, few_lit, uvs(-1.2, 0.5))),
        ("one place", lit(repeat, varied, uvs(0.0, 0.3))),
        ("no place", lit(repeat, varied, uvs(f32::NAN, 0.3))),
        (
            "alpha",
            triangle(
                covered_by(repeat, blend),
                image(16, varied),
                uvs(1.4, 0.5),
                None,
            ),
        ),
        (
            "mask",
            triangle(
                covered_by(repeat, mask),
                image(16, varied),
                uvs(1.4, 0.5),
                None,
            ),
        ),
        (
            "vertices",
            triangle(vertices, plain(), uvs(1.0, 0.5), Some([0.1, 0.9, 0.4])),
        ),
    ]
}

/// Calls with barycentric coordinates all over a triangle, `2 n²` for a square of twice its area,
/// none of them in step with any
/// texture.
fn all_over(n: usize, mut with: impl FnMut([f32; 2])) {
    for i in 0..2 * n * n {
        let cell = i / 2;
        // Additive recurrences of the plastic number.
        let u = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2].map(|a| (a * i as f64).fract());
        let b = [(cell % n, u[0]), (cell / n, u[1])].map(|(k, u)| (k as f64 + u) / n as f64);
        if b[0] + b[1] < 1.0 {
            with(b.map(|x| x as f32));
        }
    }
}

#[test]
fn points_are_drawn_where_textures_shine() {
    const N_SAMPLES: usize = 100_000;
    let mut family = Family::default();
    let mut random = Random::new(60);
    let normal = (CORNERS[1] - CORNERS[0])
        .cross(CORNERS[2] - CORNERS[0])
        .normalize();
    for (name, scene) in triangles() {
        let lights = scene.lights();
        let (_, emitter) = lights
            .of_triangle(0)
            .unwrap_or_else(|| panic!("{name} is dark"));
        let (n, fine) = (12, 1500);
        let cell = |b: [f32; 2]| {
            let [x, y] = b.map(|v| (v * n as f32).clamp(0.0, n as f32 - 1e-3));
            2 * (y as usize * n + x as usize) + usize::from(x.fract() + y.fract() > 1.0)
        };
        let mut expected = vec![0.0; 2 * n * n + 1];
        let mut power = 0.0;
        all_over(fine, |b| {
            let density = f64::from(emitter.pdf_a(b) * emitter.area());
            let sent = f64::from(emitter.sent(b, normal).r);
            assert!(density > 0.0 || sent <= 0.0, "{name}: {b:?} is never drawn");
            expected[cell(b)] += density * N_SAMPLES as f64 / (fine * fine) as f64;
            power += PI * sent * f64::from(emitter.area()) / (fine * fine) as f64;
        });
        // What misses is counted, too.
        let total: f64 = expected.iter().sum::<f64>() / N_SAMPLES as f64;
        let missed = if name == "beyond all rows" {
            1.0 - total
        } else {
            0.0
        };
        assert!(
            (total + missed - 1.0).abs() < 5e-3 && missed < 0.05,
            "{name}: adds to {total}"
        );
        expected[2 * n * n] = missed.max(0.0) * N_SAMPLES as f64;
        let mut counts = vec![0.0; 2 * n * n + 1];
        let mut powers = Vec::new();
        for _ in 0..N_SAMPLES {
            let start = lights.start(&light_sample(&mut random));
            powers.push(start.map_or(0.0, |start| f64::from(start.throughput().r)));
            let Some((_, b)) = start.and_then(|start| start.on_triangle) else {
                counts[2 * n * n] += 1.0;
                continue;
            };
            let stated = start.map_or(0.0, |start| start.densities.pdf_a);
            assert!((stated / emitter.pdf_a(b) - 1.0).abs() < 1e-4, "{name}");
            counts[cell(b)] += 1.0;
        }
        // Where half of what is drawn is nothing, counts say little of where.
        if !["mask", "no place"].contains(&name) {
            let result = chi_square(&counts, &expected);
            family.add(result.p_value, format!("{name}: {result:?}"));
        }
        let found = Estimate::of(&powers);
        let what = format!("{name}: power {found:?}, exact {power}");
        family.add(found.p_value(power, 2e-3), what);
        let stated = f64::from(scene.lights().as_slice()[0].power(BOUNDS).mean());
        assert!(
            (0.3..3.0).contains(&(stated / power)),
            "{name}: {stated} for {power}"
        );
    }
    family.judge();
}

/// A floor of albedo 1/2 under a lamp of 1 m² that shines down, seen together.
fn room(lamp: MaterialDescription, image: Option<ImageDescription>, alpha: f32) -> Arc<Scene> {
    let mut stage = Stage::default();
    stage.description.images.extend(image);
    let floor = rectangle(Vec3::ZERO, Vec3::Z * 2.0, Vec3::X * 2.0);
    stage.add("floor", floor, lambert(0.5));
    let mesh = MeshDescription {
        uv_sets: vec![vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]],
        colors: Some(vec![Vec4::new(1.0, 1.0, 1.0, alpha); 4]),
        ..rectangle(Vec3::Y, Vec3::X * 0.5, Vec3::Z * 0.5)
    };
    stage.add("lamp", mesh, lamp);
    stage.description.cameras = vec![looking(Vec3::new(0.0, 0.4, 1.6), Vec3::Y * 0.5)];
    stage.scene()
}

fn covered(alpha: f32, alpha_mode: AlphaMode, filter: Option<Filter>) -> MaterialDescription {
    MaterialDescription {
        alpha,
        alpha_mode,
        base_color_texture: filter.map(|filter| texture(filter, Wrap::Repeat)),
        ..emitter(10.0)
    }
}

/// A lamp gives as much light as there is of it, to whoever looks at it and to the floor, by every
/// method.
#[test]
fn lamps_shine_through_their_coverage() {
    let mut family = Family::default();
    let checks = || image(16, |x, y| [0, if (x + y) % 2 == 0 { 255 } else { 0 }]);
    let fine = || Some(checks());
    let blend = AlphaMode::Blend;
    let mask = |cutoff| AlphaMode::Mask { cutoff };
    let nearest = Some(Filter::Nearest);
    let lamps = [
        ("factor", room(covered(0.25, blend, None), None, 1.0), 0.25),
        ("vertices", room(covered(0.5, blend, None), None, 0.5), 0.25),
        (
            "texture",
            room(covered(0.5, blend, nearest), fine(), 1.0),
            0.25,
        ),
        (
            "above the cutoff",
            room(covered(0.6, mask(0.5), None), None, 1.0),
            1.0,
        ),
        (
            "below the cutoff",
            room(covered(0.4, mask(0.5), None), None, 1.0),
            0.0,
        ),
        (
            "cut out",
            room(covered(1.0, mask(0.5), nearest), fine(), 1.0),
            0.5,
        ),
        ("all there", room(emitter(10.0), None, 0.1), 1.0),
    ];
    let film = |scene: &Arc<Scene>, method, n| {
        Setup::new(scene, 24, 24)
            .by(method)
            .with_many_photons()
            .up_to(1)
            .batches(8, n, 70)
    };
    let opaque = room(emitter(10.0), None, 1.0);
    let mis = neumann_core::integrator::method("pt-mis").unwrap();
    let exact = film(&opaque, mis, 64);
    let exact = [0, 1].map(|layer| exact.layer(layer)[0].mean);
    for (name, scene, share) in &lamps {
        assert_eq!(scene.lights().n_triangles() > 0, *share > 0.0, "{name}");
        for &method in METHODS {
            let found = film(scene, method, 8);
            for layer in [0, 1] {
                let expected = share * exact[layer];
                let found = found.layer(layer)[0];
                let what = format!("{name}, {}, T{layer}: {found:?}, {expected}", method.id);
                if expected == 0.0 {
                    assert!(found.mean == 0.0, "{what}");
                } else {
                    family.add(found.p_value(expected, 5e-3), what);
                }
            }
        }
    }
    assert!(family.len() > 100, "only {} questions", family.len());
    family.judge();
}

/// Half-transparent lamps in a row, and a sky behind them: each is dimmed by those before it. To
/// methods that wait for light it comes without noise, whichever of the lamps stop a ray.
#[test]
fn lamps_in_a_row_dim_each_other() {
    let mut stage = Stage::default();
    for (z, radiance, alpha) in [(0.0, 10.0, 0.25), (-1.0, 20.0, 0.5), (-2.0, 0.0, 0.2)] {
        let lamp = MaterialDescription {
            alpha,
            alpha_mode: AlphaMode::Blend,
            ..emitter(radiance)
        };
        let sheet = rectangle(Vec3::Z * z, Vec3::X * 9.0, Vec3::Y * 9.0);
        stage.add("sheet", sheet, lamp);
    }
    stage.description.environment = Some(EnvironmentDescription::uniform(Rgb::WHITE));
    stage.description.cameras = vec![looking(Vec3::Z, Vec3::ZERO)];
    let scene = stage.scene();
    let expected = 0.25 * 10.0 + 0.75 * (0.5 * 20.0 + 0.5 * 0.8 * 1.0);
    let mut family = Family::default();
    for &method in METHODS {
        let film = Setup::new(&scene, 16, 16).by(method).up_to(0);
        let found = film.batches(8, 8, 71).layer(0)[0];
        family.add(
            found.p_value(expected, 1e-5),
            format!("{}: {found:?}, {expected}", method.id),
        );
        if ["naive", "pt-bsdf"].contains(&method.id) {
            for pixel in film.film(0, 1).layer(0) {
                let off = (f64::from(pixel.r) - expected).abs();
                assert!(off <= 1e-5, "{}: {pixel:?}, {expected}", method.id);
            }
        }
    }
    family.judge();
}

/// A few lit texels of a large texture are seen, and light a floor without noise to speak of.
#[test]
fn small_spots_shine() {
    let spot = image(1024, |x, y| {
        let is_lit = (500..504).contains(&x) && (301..305).contains(&y);
        [if is_lit { 255 } else { 0 }, 255]
    });
    let material = MaterialDescription {
        emission: Rgb::splat(1e5),
        emission_texture: Some(texture(Filter::Linear, Wrap::Repeat)),
        ..emitter(0.0)
    };
    let scene = room(material, Some(spot), 1.0);
    assert_eq!(
        scene.lights().n_triangles(),
        1,
        "the other half of the lamp is dark"
    );
    let u = (502.0 - 512.0) / 1024.0;
    let v = (303.0 - 512.0) / 1024.0;
    // Intensity of the spot, and E = I cos² / r² = I / r⁴ on the floor one metre below.
    let intensity = 1e5 * 16.0 / (1024.0 * 1024.0);
    let camera = neumann_tests::scenes::above_square(0.25, 0.5);
    let n = 400;
    let exact: f64 = (0..n * n)
        .map(|i| {
            let [x, z] = [i % n, i / n].map(|k| ((f64::from(k) + 0.5) / f64::from(n) - 0.5) * 0.5);
            let squared = 1.0 + (x - u) * (x - u) + (z - v) * (z - v);
            0.5 / PI * intensity / (squared * squared) / f64::from(n * n)
        })
        .sum();
    for id in ["pt-nee", "pt-mis", "bdpt", "vcm", "lt"] {
        let method = neumann_core::integrator::method(id).unwrap();
        let setup = Setup::seen_by(&scene, camera.clone(), 16, 16)
            .by(method)
            .up_to(1);
        let found = setup.batches(8, 8, 71).layer(1)[0];
        let what = format!("{id}: {found:?}, exact {exact}");
        assert!(found.p_value(exact, 2e-3) > 1e-4, "{what}");
        assert!(found.standard_error < 0.02 * exact, "{what}");
    }
    // Looked at, it shows itself.
    let eye = Vec3::new(u as f32, 0.98, v as f32);
    let setup = Setup::seen_by(&scene, looking(eye, eye + Vec3::Y * 0.02), 32, 32).up_to(0);
    let seen = setup.film(0, 16).layer_means()[0][0];
    let exact = 1e5 * 16.0 / (0.04f64 * 1024.0).powi(2);
    assert!((seen / exact - 1.0).abs() < 0.1, "{seen}, exact {exact}");
}
