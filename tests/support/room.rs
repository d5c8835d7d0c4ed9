//! Something to trace rays in: a closed room with ten bumpy spheres of `20 · frequency²`
//! triangles each.

use glam::Vec3;
use neumann_core::accel::Bvh;
use neumann_core::math::{Frame, Ray};
use neumann_core::sampling::{Sampler, warp};

/// Rays of a picture of `side`² pixels: from the camera, bounced off what it sees by the cosine
/// and so in no order, and from there to a lamp.
#[must_use]
pub fn rays(bvh: &Bvh, triangles: &[[Vec3; 3]], side: u32) -> [Vec<Ray>; 3] {
    let eye = Vec3::new(0.0, 1.0, 5.9);
    let (mut primary, mut bounce, mut shadow) = (Vec::new(), Vec::new(), Vec::new());
    for pixel in 0..side * side {
        let mut sampler = Sampler::new(1, u64::from(pixel), 0);
        let at = |i: u32, u: f32| (i as f32 + u) / side as f32 * 2.0 - 1.0;
        let [u, v] = sampler.next_2d();
        let target = Vec3::new(at(pixel % side, u), -at(pixel / side, v), -1.6);
        let ray = Ray::new(eye, target.normalize());
        primary.push(ray);
        let Some(hit) = bvh.closest_hit(&ray) else {
            continue;
        };
        let [a, b, c] = triangles[hit.triangle as usize];
        let ng = (b - a).cross(c - a).normalize();
        let ng = if ng.dot(ray.direction()) > 0.0 {
            -ng
        } else {
            ng
        };
        let origin = ray.at(hit.t) + ng * 1e-4;
        let local = warp::cosine_hemisphere(sampler.next_2d());
        bounce.push(Ray::new(origin, Frame::from_z(ng).world_from_local(local)));
        let [u, v] = sampler.next_2d();
        let lamp = Vec3::new(2.0 * u - 1.0, 3.9, 2.0 * v - 1.0) - origin;
        shadow.push(Ray::with_end(origin, lamp.normalize(), lamp.length()));
    }
    [primary, bounce, shadow]
}

/// The triangles of the room.
#[must_use]
pub fn room_with_spheres(frequency: u32) -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    // The room: a box of six sides, seen from within.
    for axis in 0..3 {
        for side in [-1.0f32, 1.0] {
            let half = Vec3::new(6.0, 4.0, 6.0);
            let at = |u: f32, v: f32| {
                let mut p = Vec3::ZERO;
                p[axis] = side;
                p[(axis + 1) % 3] = u;
                p[(axis + 2) % 3] = v;
                p * half
            };
            triangles.push([at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0)]);
            triangles.push([at(-1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]);
        }
    }
    let centers = [
        [0.0, -1.5, 0.0],
        [-3.0, -2.0, -1.0],
        [3.0, -2.2, -0.5],
        [-1.6, -2.8, 2.4],
        [1.8, -2.9, 2.2],
        [-2.2, 1.3, -2.5],
        [2.4, 1.5, -2.2],
        [4.2, -3.0, 1.6],
        [-4.3, -3.1, 1.4],
        [0.1, 2.2, -3.4],
    ];
    let radii = [1.7, 1.5, 1.4, 0.9, 0.8, 1.3, 1.2, 0.8, 0.7, 0.9];
    let unit = geodesic_sphere(frequency);
    for (center, radius) in centers.into_iter().zip(radii) {
        let bump = |p: Vec3| {
            let waves = (9.0 * p.x).sin() * (11.0 * p.y + 1.0).sin() * (10.0 * p.z + 2.0).sin();
            let ripples = (71.0 * p.x).sin() * (67.0 * p.y).sin() * (73.0 * p.z).sin();
            Vec3::from(center) + p * (radius * (1.0 + 0.08 * waves + 0.01 * ripples))
        };
        triangles.extend(unit.iter().map(|t| t.map(bump)));
    }
    triangles
}

/// A sphere of radius 1: the 20 faces of an icosahedron, each cut into `frequency²` triangles.
fn geodesic_sphere(frequency: u32) -> Vec<[Vec3; 3]> {
    let golden = 0.5 * (1.0 + 5f32.sqrt());
    let mut corners: Vec<Vec3> = Vec::new();
    for (a, b) in [
        (1.0, golden),
        (-1.0, golden),
        (1.0, -golden),
        (-1.0, -golden),
    ] {
        corners.push(Vec3::new(a, b, 0.0));
        corners.push(Vec3::new(0.0, a, b));
        corners.push(Vec3::new(b, 0.0, a));
    }
    // Corners two apart are neighbours; faces are the triples of neighbours.
    let near = |i: usize, j: usize| corners[i].distance(corners[j]) < 2.01;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(i, k) {
                    let [a, b, c] = [corners[i], corners[j], corners[k]];
                    let at = |u: u32, v: u32| {
                        let (u, v) = (u as f32 / frequency as f32, v as f32 / frequency as f32);
                        (a * (1.0 - u - v) + b * u + c * v).normalize()
                    };
                    for u in 0..frequency {
                        for v in 0..frequency - u {
                            triangles.push([at(u, v), at(u + 1, v), at(u, v + 1)]);
                            if u + v + 1 < frequency {
                                triangles.push([at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)]);
                            }
                        }
                    }
                }
            }
        }
    }
    triangles
}
