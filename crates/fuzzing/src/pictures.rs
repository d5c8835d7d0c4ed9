//! Textures, skies, checkpoints and pictures to compare.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use image::{ImageFormat, RgbaImage};
use neumann_core::film::Film;
use neumann_core::radiometry::Rgb;
use neumann_core::scene::load::{environment_from_bytes, load_bytes};
use neumann_picture::compare::{compare, difference_picture};
use neumann_picture::exr_file::{IterationRanges, Metadata, read_exr, write_exr, write_image_exr};
use neumann_picture::image_file::read_image;
use neumann_picture::tone::Display;

use crate::Target;
use crate::scenes::textured_square;

/// Textures: PNG, JPEG, WebP.
pub(crate) const PICTURE: Target = Target {
    name: "picture",
    run: |bytes| {
        let scene = textured_square();
        let resolve = |_: &str| Some(bytes.to_vec());
        match load_bytes("fuzz.gltf", &scene, &resolve) {
            // A texture that cannot be read costs a warning.
            Ok(scene) => scene.report.warnings.is_empty(),
            Err(_) => false,
        }
    },
    seeds: || {
        let picture = RgbaImage::from_fn(5, 3, |x, y| {
            image::Rgba([40 * x as u8, 80 * y as u8, 7, 200])
        });
        let opaque = image::DynamicImage::from(picture.clone()).into_rgb8();
        let mut seeds = Vec::new();
        for format in [ImageFormat::Png, ImageFormat::WebP] {
            let mut bytes = Cursor::new(Vec::new());
            if picture.write_to(&mut bytes, format).is_ok() {
                seeds.push(bytes.into_inner());
            }
        }
        let mut bytes = Cursor::new(Vec::new());
        if opaque.write_to(&mut bytes, ImageFormat::Jpeg).is_ok() {
            seeds.push(bytes.into_inner());
        }
        seeds
    },
};

/// Skies in Radiance HDR.
pub(crate) const HDR: Target = Target {
    name: "hdr",
    run: sky,
    seeds: || {
        let flat = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n";
        let mut flat = flat.to_vec();
        flat.extend([128, 0, 0, 129, 0, 128, 0, 130]);
        let head = b"#?RADIANCE\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 16\n";
        let mut runs = head.to_vec();
        for _ in 0..2 {
            // Four channels of a row: a run of twelve, then four as they are.
            runs.extend([2, 2, 0, 16]);
            for channel in [100, 110, 120, 129] {
                runs.extend([128 + 12, channel, 4, channel, 1, 2, channel]);
            }
        }
        vec![flat, runs]
    },
};

/// Skies in OpenEXR.
pub(crate) const EXR: Target = Target {
    name: "exr",
    run: sky,
    seeds: || {
        let pixels: Vec<_> = (0..8)
            .map(|i| Rgb::new(i as f32, 0.5, 0.25 * i as f32))
            .collect();
        vec![written(|path| {
            write_image_exr(path, (4, 2), &pixels, &[("scene", "fuzz")]).is_ok()
        })]
    },
};

fn sky(bytes: &[u8]) -> bool {
    let Ok(sky) = environment_from_bytes("fuzz", bytes) else {
        return false;
    };
    let map = sky.environment;
    assert_eq!(map.texels.len(), map.width * map.height);
    // More of them only take longer.
    assert!(map.texels.iter().take(1 << 20).all(Rgb::is_radiance));
    true
}

/// Films to go on from.
pub(crate) const CHECKPOINT: Target = Target {
    name: "checkpoint",
    run: |bytes| {
        let file = Scratch::of(bytes);
        let Ok(checkpoint) = read_exr(file.path()) else {
            return false;
        };
        let film = &checkpoint.film;
        let n_pixels = film.width() * film.height();
        assert_eq!(film.n_iterations(), checkpoint.metadata.iterations.count());
        assert!(film.layers().iter().all(|layer| layer.len() == n_pixels));
        let differences = checkpoint.metadata.differences(&Metadata::default());
        assert!(differences.iter().all(|d| !d.to_string().is_empty()));
        let mut doubled = film.clone();
        doubled.merge(film).is_ok()
    },
    seeds: || {
        vec![written(|path| {
            write_exr(path, &film(), None, &metadata()).is_ok()
        })]
    },
};

/// Two pictures that are compared; the first two bytes say where the second one begins.
pub(crate) const COMPARE: Target = Target {
    name: "compare",
    run: |bytes| {
        let Some((length, rest)) = bytes.split_first_chunk() else {
            return false;
        };
        let length = usize::from(u16::from_le_bytes(*length)).min(rest.len());
        let (first, second) = rest.split_at(length);
        let (first, second) = (Scratch::of(first), Scratch::of(second));
        let (Ok(a), Ok(b)) = (read_image(first.path()), read_image(second.path())) else {
            return false;
        };
        // Flip convolves; larger pictures only take longer.
        if a.width * a.height > 1 << 16 || b.width * b.height > 1 << 16 {
            return false;
        }
        let Ok(found) = compare(&a, &b, &Display::default()) else {
            return false;
        };
        assert!(found.rmse >= 0.0 || found.rmse.is_nan());
        let (picture, _) = difference_picture(&a, &b);
        assert_eq!(picture.pixels.len(), a.width * a.height);
        true
    },
    seeds: || {
        let mut files = (EXR.seeds)();
        files.extend((HDR.seeds)().into_iter().skip(1));
        files.extend((PICTURE.seeds)().into_iter().take(1));
        files
            .iter()
            .map(|file| {
                let length = u16::try_from(file.len()).unwrap_or(u16::MAX);
                [&length.to_le_bytes(), file.as_slice(), file.as_slice()].concat()
            })
            .collect()
    },
};

/// Two iterations of six pixels; two terms and the tail, each one unit of radiance.
fn film() -> Film {
    let layer = || vec![Rgb::WHITE; 6];
    let total = vec![Rgb::splat(3.0); 6];
    let layers = vec![layer(), layer(), layer()];
    Film::from_parts((3, 2), 2, layers, total, &layer(), 0).unwrap_or_else(|_| Film::new(3, 2, 2))
}

fn metadata() -> Metadata {
    Metadata {
        integrator: "pt-mis".to_owned(),
        parameters: vec![("roulette".to_owned(), "on".to_owned())],
        iterations: IterationRanges::of(0..2),
        scene: "fuzz".to_owned(),
        program_version: "0".to_owned(),
        camera: "perspective 0.5; pinhole; 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1".to_owned(),
        environment: "none".to_owned(),
        ..Metadata::default()
    }
}

/// What a writer puts into a file.
fn written(write: impl FnOnce(&Path) -> bool) -> Vec<u8> {
    let file = Scratch::of(&[]);
    if write(file.path()) {
        fs::read(file.path()).unwrap_or_default()
    } else {
        Vec::new()
    }
}

/// A file of its own, in memory where the system has such a place; removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn of(bytes: &[u8]) -> Self {
        static COUNTER: AtomicU32 = AtomicU32::new(0);
        let n = COUNTER.fetch_add(1, Ordering::Relaxed);
        let memory = Path::new("/dev/shm");
        let folder = if memory.is_dir() {
            memory.to_owned()
        } else {
            std::env::temp_dir()
        };
        let path = folder.join(format!("neumann-fuzzing-{}-{n}", std::process::id()));
        // A file that could not be written is refused by whoever reads it.
        let _ = fs::write(&path, bytes);
        Self(path)
    }

    fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}
