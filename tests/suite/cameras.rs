//! Do cameras start rays and get aimed at with the densities they state?
//!
//! Measures are checked by what their inverse integrates to: the mean of `1 / pdf_w` over rays is
//! the solid angle they were drawn from, and a film on which light of radiance 1 falls from
//! everywhere is 1 in every pixel.

use std::f32::consts::PI;

use glam::{Mat4, Vec2, Vec3};
use neumann_core::endpoint::Camera;
use neumann_core::scene::description::{CameraDescription, Lens, Projection};
use neumann_tests::random::Random;
use neumann_tests::statistics::{Estimate, Family};

fn cameras() -> Vec<(&'static str, Camera)> {
    let lens = Lens {
        aperture: 0.5,
        focus_distance: 1.7,
    };
    let perspective = Projection::Perspective { yfov: 1.1 };
    let orthographic = Projection::Orthographic { ymag: 0.8 };
    [
        ("pinhole", perspective, None),
        ("thin lens", perspective, Some(lens)),
        ("orthographic", orthographic, None),
    ]
    .map(|(name, projection, lens)| {
        let description = CameraDescription {
            name: name.to_owned(),
            // Looks down on the plane y = 0 from 2 m above, a little turned.
            world_from_camera: Mat4::from_translation(Vec3::Y * 2.0)
                * Mat4::from_rotation_y(0.3)
                * Mat4::from_rotation_x(-1.3),
            aspect_ratio: None,
            projection,
            lens,
            crop: None,
        };
        (name, Camera::new(&description, 12, 8))
    })
    .into()
}

/// Seen from the camera's film, rays must find what aiming from outside finds: a plane of radiance
/// 1 is 1 in every pixel, whether its light is aimed at the camera or found by camera rays.
#[test]
fn importance_is_one_for_every_pixel() {
    let mut family = Family::default();
    for (name, camera) in cameras() {
        let mut random = Random::new(25);
        // The part of the plane that is seen, with room to spare.
        let half = 7.0f32;
        let n = 240_000;
        let mut sums = [[0f64; 2]; 24];
        for _ in 0..n {
            let mut sampler = random.sampler();
            let u = sampler.next_2d();
            let x = Vec3::new(
                (2.0 * u[0] - 1.0) * half,
                0.0,
                (2.0 * u[1] - 1.0) * half - 0.5,
            );
            let Some((aim, raster)) = camera.aim(x, sampler.next_2d()) else {
                continue;
            };
            let value = f64::from(aim.value.r * aim.wi.y.abs() / aim.pdf_w * 4.0 * half * half);
            // Four pixels a block.
            let block = (raster.y as usize / 2) * 6 + raster.x as usize / 2;
            sums[block][0] += value;
            sums[block][1] += value * value;
        }
        for (block, [sum, squares]) in sums.into_iter().enumerate() {
            let mean = sum / n as f64;
            let variance = squares / n as f64 - mean * mean;
            let estimate = Estimate {
                mean: mean / 4.0,
                standard_error: (variance / n as f64).sqrt() / 4.0,
                n,
            };
            family.add(
                estimate.p_value(1.0, 1e-5),
                format!("{name}, block {block}: {estimate:?}"),
            );
        }
    }
    family.judge();
}

/// The mean of `1 / pdf_w` over rays through a part of the film is its solid angle
/// (times its share of the film), and `pdf_a` is one over the area of lens or film.
#[test]
fn densities_of_camera_rays() {
    let mut family = Family::default();
    let mut random = Random::new(26);
    for (name, camera) in cameras() {
        let origin_area = match name {
            "pinhole" => 1.0,
            "thin lens" => PI * 0.25 * 0.25,
            _ => 4.0 * 0.8 * 0.8 * 12.0 / 8.0,
        };
        for (x, y) in [(0.0, 0.0), (5.0, 3.0), (11.0, 7.0)] {
            let mut inverse = Vec::new();
            // One point of the lens, so that the pixel is one rectangle seen from it.
            let u_lens = [0.83, 0.4];
            for _ in 0..20_000 {
                let u = random.pair();
                let start = camera.ray(Vec2::new(x + u[0], y + u[1]), u_lens);
                inverse.push(1.0 / f64::from(start.densities.pdf_w));
                assert!(
                    (start.densities.pdf_a * origin_area - 1.0).abs() < 1e-4,
                    "{name}"
                );
                assert!((start.ray.direction().length() - 1.0).abs() < 1e-5);
            }
            let corner = |dx: f32, dy: f32| {
                camera
                    .ray(Vec2::new(x + dx, y + dy), u_lens)
                    .ray
                    .direction()
            };
            let [a, b, c, d] = [
                corner(0.0, 0.0),
                corner(1.0, 0.0),
                corner(1.0, 1.0),
                corner(0.0, 1.0),
            ];
            let triangle = |a: Vec3, b: Vec3, c: Vec3| {
                2.0 * a
                    .dot(b.cross(c))
                    .abs()
                    .atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
            };
            let exact = match name {
                "orthographic" => 1.0,
                _ => f64::from(triangle(a, b, c) + triangle(a, c, d)) * 96.0,
            };
            let estimate = Estimate::of(&inverse);
            family.add(
                estimate.p_value(exact, 1e-4),
                format!("{name}, pixel ({x}, {y}): {estimate:?}, exact {exact}"),
            );
        }
    }
    family.judge();
}
