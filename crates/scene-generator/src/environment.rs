//! The analytic sky of the scene `sky`, as a Radiance RGBE picture.
//!
//! Latitude and longitude: `u = 0.5 + atan2(x, -z) / 2 pi`, `v = acos(y) / pi`,
//! so the middle of the picture is -Z, u grows towards +X and row 0 is the
//! zenith. A blue that pales to the horizon, a glow around a small warm sun, and
//! below the horizon the radiance of a Lambertian ground under that sky, so that
//! a ground of the same albedo in the scene meets it without a seam.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, dvec3};
use image::codecs::hdr::HdrEncoder;
use image::{ImageResult, Rgb};

const WIDTH: u32 = 512;
const HEIGHT: u32 = 256;
/// Samples along each side of a pixel: the sun is hardly wider than two pixels.
const SAMPLES: u32 = 8;

const ZENITH: DVec3 = dvec3(0.10, 0.22, 0.52);
const HORIZON: DVec3 = dvec3(0.62, 0.68, 0.74);
const SUN_GLOW: DVec3 = dvec3(0.55, 0.42, 0.26);
/// Irradiance of the sun on a plane that faces it.
const SUN_IRRADIANCE: DVec3 = dvec3(2.6, 2.3, 1.85);
/// Half the angle under which the sun is seen: four times that of the real one.
const SUN_RADIUS: f64 = 1.1 * PI / 180.0;
/// Towards the sun; not of unit length.
const SUN: DVec3 = dvec3(-0.80, 0.62, 0.18);

/// Reflectance of the ground, below the horizon here and in the scene.
pub(crate) const GROUND_ALBEDO: [f64; 3] = [0.42, 0.40, 0.37];

/// The picture as a `.hdr` file.
pub(crate) fn sky_hdr() -> ImageResult<Vec<u8>> {
    let ground = DVec3::from_array(GROUND_ALBEDO) * irradiance_on_the_ground() / PI;
    let pixels: Vec<_> = (0..HEIGHT)
        .flat_map(|row| (0..WIDTH).map(move |column| pixel(column, row, ground)))
        .collect();
    let mut file = Vec::new();
    HdrEncoder::new(&mut file).encode(&pixels, WIDTH as usize, HEIGHT as usize)?;
    Ok(file)
}

fn pixel(column: u32, row: u32, ground: DVec3) -> Rgb<f32> {
    let mut sum = DVec3::ZERO;
    for i in 0..SAMPLES * SAMPLES {
        let offset = |k: u32| (f64::from(k) + 0.5) / f64::from(SAMPLES);
        let u = (f64::from(column) + offset(i % SAMPLES)) / f64::from(WIDTH);
        let v = (f64::from(row) + offset(i / SAMPLES)) / f64::from(HEIGHT);
        let ((sin_longitude, cos_longitude), (sin_v, cos_v)) =
            ((TAU * (u - 0.5)).sin_cos(), (PI * v).sin_cos());
        let direction = dvec3(sin_v * sin_longitude, cos_v, -sin_v * cos_longitude);
        sum += if direction.y < 0.0 {
            ground
        } else {
            sky(direction) + sun(direction)
        };
    }
    Rgb((sum / f64::from(SAMPLES * SAMPLES)).as_vec3().to_array())
}

/// Radiance of the sky without the sun; `direction` is of unit length, above
/// the horizon.
fn sky(direction: DVec3) -> DVec3 {
    let haze = (1.0 - direction.y).powi(4);
    let near_sun = direction.dot(SUN.normalize()).max(0.0);
    ZENITH.lerp(HORIZON, haze) + SUN_GLOW * (0.35 * near_sun.powi(8) + near_sun.powi(96))
}

fn sun(direction: DVec3) -> DVec3 {
    let solid_angle = TAU * (1.0 - SUN_RADIUS.cos());
    let is_inside = direction.dot(SUN.normalize()) > SUN_RADIUS.cos();
    if is_inside {
        SUN_IRRADIANCE / solid_angle
    } else {
        DVec3::ZERO
    }
}

/// Irradiance on a level plane: the sun's in closed form, the sky's by the
/// midpoint rule over the hemisphere.
fn irradiance_on_the_ground() -> DVec3 {
    let steps = 256_u32;
    let mut sum = SUN_IRRADIANCE * SUN.normalize().y;
    for i in 0..steps {
        for j in 0..steps {
            let theta = FRAC_PI_2 * (f64::from(i) + 0.5) / f64::from(steps);
            let phi = TAU * (f64::from(j) + 0.5) / f64::from(steps);
            let direction = dvec3(
                theta.sin() * phi.cos(),
                theta.cos(),
                theta.sin() * phi.sin(),
            );
            let solid_angle = theta.sin() * FRAC_PI_2 * TAU / f64::from(steps * steps);
            sum += sky(direction) * theta.cos() * solid_angle;
        }
    }
    sum
}
