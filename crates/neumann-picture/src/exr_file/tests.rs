use glam::{Mat4, Vec3};
use neumann_core::film::{Features, Film};
use neumann_core::memory::Share;
use neumann_core::radiometry::Rgb;
use neumann_core::scene::description::{
    CameraDescription, EnvironmentDescription, Lens, Projection, SceneDescription, SunDescription,
};
use neumann_core::scene::{Appearance, Backs};

use super::{
    IterationRanges, Metadata, Precision, appearance_text, camera_text, environment_text, read_exr,
    read_layer, read_layers, write_exr, write_exr_as, write_image_exr,
};
use crate::files::tests::TestFolder;
use crate::state::State;

const SIZE: (usize, usize) = (37, 21);

/// Numbers without any order to them.
fn noise(n: usize, seed: u32) -> Vec<Rgb> {
    let mut state = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0
    };
    (0..n)
        .map(|_| Rgb::new(next(), next() * 9.0, next() * 1e-4))
        .collect()
}

fn film() -> Film {
    let n = SIZE.0 * SIZE.1;
    let layers = (0..4).map(|k| noise(n, k)).collect();
    Film::from_parts(SIZE, 16, layers, noise(n, 100), &noise(n, 101), 3).unwrap()
}

fn metadata() -> Metadata {
    Metadata {
        integrator: "pt-mis".to_owned(),
        parameters: vec![
            ("samples".to_owned(), "4".to_owned()),
            ("roulette".to_owned(), "on".to_owned()),
        ],
        iterations: "0-7,16-23".parse().unwrap(),
        seconds: 1.25,
        seed: u64::MAX,
        scene: "Küche ☀".to_owned(),
        content_hash: 0xdead_beef_0123_4567,
        program_version: "0.1.0".to_owned(),
        max_bounces: 16,
        camera: "perspective 0.7; pinhole; 1 0 0".to_owned(),
        environment: "none".to_owned(),
        appearance: "0123".to_owned(),
        backs: Backs::SeeThrough,
        n_refused: 3,
        state: Some(Box::new(State {
            scene: "cornell".to_owned(),
            ..State::default()
        })),
    }
}

fn features() -> Features {
    let n = SIZE.0 * SIZE.1;
    let mut depth: Vec<f32> = (0..n).map(|i| i as f32 * 0.5).collect();
    depth[5] = f32::INFINITY;
    Features {
        width: SIZE.0,
        albedo: noise(n, 7),
        normal: (0..n).map(|i| Vec3::new(0.0, i as f32, -1.0)).collect(),
        depth,
    }
}

#[test]
fn a_film_comes_back_bit_by_bit() {
    let folder = TestFolder::new();
    let path = folder.join("a.exr");
    let (film, features) = (film(), features());
    write_exr(&path, &film, Some(&features), &metadata()).unwrap();
    let back = read_exr(&path).unwrap();
    assert_eq!(back.metadata, metadata());
    assert_eq!(back.film.layers(), film.layers());
    assert_eq!(back.film.total(), film.total());
    assert_eq!(back.film.n_iterations(), 16);
    assert_eq!(back.film.n_refused(), 3);
    assert_eq!(back.film.spread(), film.spread());
    let read = back.features.unwrap();
    assert_eq!(read.albedo, features.albedo);
    assert_eq!(read.normal, features.normal);
    assert_eq!(read.depth, features.depth);
}

#[test]
fn layers_are_found_by_name() {
    let folder = TestFolder::new();
    let path = folder.join("a.exr");
    write_exr(&path, &film(), None, &metadata()).unwrap();
    let image = read_layers(&path).unwrap();
    assert_eq!(image.pixels, film().total());
    let names: Vec<_> = image.layers.keys().map(String::as_str).collect();
    assert_eq!(names, ["T0", "T1", "T2", "tail", "variance"]);
    let layer = |name| read_layer(&path, Some(name), &mut Share::default());
    assert_eq!(layer("T2").unwrap().pixels, film().layers()[2]);
    assert_eq!(layer("L").unwrap().pixels, film().total());
    let error = layer("T9").unwrap_err().to_string();
    assert!(error.contains("T9") && error.contains("T0, T1"), "{error}");
    assert!(read_exr(&path).unwrap().features.is_none());
}

#[test]
fn half_floats_are_smaller_and_no_checkpoint() {
    let folder = TestFolder::new();
    let (full, half) = (folder.join("full.exr"), folder.join("half.exr"));
    write_exr(&full, &film(), None, &metadata()).unwrap();
    write_exr_as(&half, &film(), None, &metadata(), Precision::Half).unwrap();
    let size = |path| std::fs::metadata(path).unwrap().len();
    assert!(size(&half) * 3 < size(&full) * 2);
    let image = read_layers(&half).unwrap();
    for (a, b) in image.pixels.iter().zip(film().total()) {
        assert!((a.g - b.g).abs() <= 1e-3 * b.g + 1e-7);
    }
    assert!(read_exr(&half).unwrap_err().to_string().contains("half"));
}

#[test]
fn half_floats_say_what_they_clamp() {
    let folder = TestFolder::new();
    let n = SIZE.0 * SIZE.1;
    let (mut layers, mut total) = (vec![noise(n, 0); 2], noise(n, 100));
    layers[0][7] = Rgb::new(65504.0, 1e5, 3e9);
    total[7] = Rgb::new(65504.0, 2e5, 4e9);
    let film = Film::from_parts(SIZE, 16, layers, total, &noise(n, 101), 3).unwrap();
    let path = folder.join("half.exr");
    let write =
        |precision| write_exr_as(&path, &film, Some(&features()), &metadata(), precision).unwrap();
    let clamped = write(Precision::Half);
    assert_eq!((clamped.n_values, clamped.largest), (4, 4e9));
    assert_eq!(read_layers(&path).unwrap().pixels[7].b, 65504.0);
    assert_eq!(write(Precision::Full).n_values, 0);
}

#[test]
fn a_plain_picture_is_no_film() {
    let folder = TestFolder::new();
    let path = folder.join("plain.exr");
    let pixels = noise(6, 1);
    write_image_exr(&path, (3, 2), &pixels, &[("view", "T²Lₑ")]).unwrap();
    assert_eq!(read_layers(&path).unwrap().pixels, pixels);
    let error = read_exr(&path).unwrap_err().to_string();
    assert!(error.contains("no proper entry 'neumann."), "{error}");
}

#[test]
fn broken_files_are_refused_and_never_panic() {
    let folder = TestFolder::new();
    let path = folder.join("a.exr");
    write_exr(&path, &film(), None, &metadata()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let cut = folder.join("cut.exr");
    for i in 0..40 {
        std::fs::write(&cut, &bytes[..bytes.len() * i / 40]).unwrap();
        assert!(read_exr(&cut).is_err(), "cut to {i}/40");
        assert!(read_layers(&cut).is_err(), "cut to {i}/40");
    }
    // Flipped bits may or may not matter; they must not bring the reader down.
    let mut n_refused = 0;
    for i in 0..1500usize {
        let mut flipped = bytes.clone();
        let at = if i < 1200 { i } else { i * 7919 % bytes.len() };
        flipped[at] ^= 1 << (i % 8);
        std::fs::write(&cut, &flipped).unwrap();
        n_refused += u32::from(read_exr(&cut).is_err());
    }
    assert!(n_refused > 100, "{n_refused}");
}

/// Changes bytes of a file behind a name in its header.
fn edit(bytes: &mut [u8], name: &str, old: &[u8], new: &[u8]) {
    let at = bytes
        .windows(name.len())
        .position(|w| w == name.as_bytes())
        .unwrap();
    let offset = bytes[at..]
        .windows(old.len())
        .position(|w| w == old)
        .unwrap();
    bytes[at + offset..at + offset + new.len()].copy_from_slice(new);
}

#[test]
fn impossible_values_are_refused() {
    let folder = TestFolder::new();
    let path = folder.join("a.exr");
    let n = SIZE.0 * SIZE.1;
    for value in [f32::NAN, f32::INFINITY, -1e-3] {
        let mut layers: Vec<_> = (0..4).map(|k| noise(n, k)).collect();
        layers[2][17].g = value;
        let film = Film::from_parts(SIZE, 16, layers, noise(n, 100), &noise(n, 101), 3).unwrap();
        write_exr(&path, &film, None, &metadata()).unwrap();
        let error = read_exr(&path).unwrap_err().to_string();
        assert!(
            error.contains("a.exr") && error.contains("'T2.G'"),
            "{error}"
        );
    }
    let mut odd = features();
    odd.normal[3].y = f32::NAN;
    write_exr(&path, &film(), Some(&odd), &metadata()).unwrap();
    let error = read_exr(&path).unwrap_err().to_string();
    assert!(error.contains("'normal.Y'"), "{error}");
}

#[test]
fn damage_is_found_wherever_it_is() {
    let folder = TestFolder::new();
    let path = folder.join("a.exr");
    write_exr(&path, &film(), None, &metadata()).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let seed = u64::MAX.to_string();
    let other = seed.replace('8', "7");
    let cases: [(&str, &[u8], &[u8], &str); 4] = [
        (
            "neumann.seed",
            seed.as_bytes(),
            other.as_bytes(),
            "its header",
        ),
        ("neumann.checksums", b"T1.G=", b"T1.H=", "'T1.H' is missing"),
        (
            "neumann.iterationRanges",
            b"0-7,",
            b"0-9,",
            "'neumann.iterations'",
        ),
        (
            "neumann.iterations\0",
            &[16, 0, 0, 0],
            &[17, 0, 0, 0],
            "'neumann.iterations'",
        ),
    ];
    for (name, old, new, expected) in cases {
        let mut bytes = whole.clone();
        edit(&mut bytes, name, old, new);
        std::fs::write(&path, &bytes).unwrap();
        let error = read_exr(&path).unwrap_err().to_string();
        assert!(
            error.contains("a.exr") && error.contains(expected),
            "{error}"
        );
    }
    // The last block is compressed, so that a changed byte changes pixels, or cannot be unpacked.
    for back in 20..60 {
        let mut bytes = whole.clone();
        let at = bytes.len() - back;
        bytes[at] ^= 4;
        std::fs::write(&path, &bytes).unwrap();
        assert!(read_exr(&path).is_err(), "{back}");
    }
}

#[test]
fn files_without_checksums_are_taken_as_they_are() {
    let folder = TestFolder::new();
    let path = folder.join("a.exr");
    write_exr(&path, &film(), None, &metadata()).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    edit(&mut bytes, "neumann.checksums", b"checksums", b"something");
    std::fs::write(&path, &bytes).unwrap();
    assert_eq!(read_exr(&path).unwrap().film.total(), film().total());
}

#[test]
fn a_header_that_promises_too_much_is_refused_early() {
    let folder = TestFolder::new();
    let path = folder.join("a.exr");
    write_image_exr(&path, (3, 2), &noise(6, 1), &[]).unwrap();
    let whole = std::fs::read(&path).unwrap();
    for (name, edge) in [("dataWindow", 200_000i32), ("displayWindow", 20_000)] {
        let mut bytes = whole.clone();
        let is_name = |w: &[u8]| w == name.as_bytes();
        let at = bytes.windows(name.len()).position(is_name).unwrap();
        // Name, zero, type "box2i", zero, length, then xMin, yMin, xMax, yMax.
        let window = at + name.len() + 1 + 6 + 4;
        bytes[window + 8..window + 12].copy_from_slice(&edge.to_le_bytes());
        bytes[window + 12..window + 16].copy_from_slice(&edge.to_le_bytes());
        std::fs::write(&path, &bytes).unwrap();
        let error = read_layers(&path).unwrap_err().to_string();
        assert!(error.contains("cannot be decoded"), "{name}: {error}");
    }
}

#[test]
fn differences_name_what_differs_and_nothing_else() {
    let (a, mut b) = (metadata(), metadata());
    b.seconds = 9.0;
    b.iterations = IterationRanges::of(100..200);
    b.n_refused = 0;
    assert!(a.differences(&b).is_empty());
    b.seed = 5;
    b.content_hash = 1;
    b.parameters[0].1 = "8".to_owned();
    let differences = a.differences(&b);
    let fields: Vec<_> = differences.iter().map(|d| d.field.as_str()).collect();
    let scene = "scene (its files have changed)";
    let parameter = format!("parameter {}", a.parameters[0].0);
    assert_eq!(fields, [scene, parameter.as_str(), "seed"]);
}

#[test]
fn cameras_and_environments_differ_in_words_where_they_differ() {
    let camera = CameraDescription {
        name: "one".to_owned(),
        world_from_camera: Mat4::IDENTITY,
        aspect_ratio: None,
        projection: Projection::Perspective { yfov: 0.7 },
        lens: None,
        crop: None,
    };
    let mut other = camera.clone();
    other.name = "two".to_owned();
    assert_eq!(camera_text(&camera), camera_text(&other));
    other.lens = Some(Lens {
        aperture: 0.1,
        focus_distance: 2.0,
    });
    assert_ne!(camera_text(&camera), camera_text(&other));
    let sky = EnvironmentDescription::uniform(Rgb::WHITE);
    let mut brighter = sky.clone();
    assert_eq!(
        environment_text(Some(&sky)),
        environment_text(Some(&brighter))
    );
    brighter.texels = vec![Rgb::splat(1.0 + f32::EPSILON)].into();
    assert_ne!(
        environment_text(Some(&sky)),
        environment_text(Some(&brighter))
    );
    let mut sunny = sky.clone();
    sunny.sun = Some(SunDescription {
        direction: Vec3::Y,
        angular_radius: 0.01,
        radiance: Rgb::WHITE,
    });
    assert_ne!(environment_text(Some(&sky)), environment_text(Some(&sunny)));
    assert_eq!(environment_text(None), "none");
    let appearance = Appearance::new(&SceneDescription::default());
    let mut tinted = appearance.clone();
    tinted.environment_tint = Rgb::new(1.0, 1.0, 0.5);
    assert_ne!(appearance_text(&appearance), appearance_text(&tinted));
}
