use glam::{Affine3A, DVec3, Quat, Vec3};
use rayon::prelude::*;

use super::super::abreast::RayLanes;
use super::super::binary::BinaryTree;
use super::super::build::boxes_of;
use super::super::wide::{FLAT, STACK_SIZE, WIDTH, WideTree};
use super::{Bvh, Hit, Kernel, Placement, TreeQuality};
use crate::math::Ray;
use crate::math::lanes::LANES;
use crate::sampling::{Sampler, warp};

/// A closed, bumpy sphere.
fn sphere(n: usize, scale: f32) -> Vec<[Vec3; 3]> {
    let at = |i: usize, j: usize| {
        let theta = std::f32::consts::PI * i as f32 / n as f32;
        let phi = std::f32::consts::TAU * (j % (2 * n)) as f32 / (2 * n) as f32;
        let bump = if i == 0 || i == n {
            1.0
        } else {
            1.0 + 0.1 * (5.0 * phi).sin()
        };
        let (st, ct) = if i == n {
            (0.0, -1.0)
        } else if i == 0 {
            (0.0, 1.0)
        } else {
            theta.sin_cos()
        };
        Vec3::new(st * phi.cos(), ct, st * phi.sin()) * (bump * scale)
    };
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..2 * n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if i + 1 < n {
                triangles.push([a, b, c]);
            }
            if i > 0 {
                triangles.push([a, c, d]);
            }
        }
    }
    triangles
}

#[test]
fn the_tree_finds_what_a_loop_over_all_triangles_finds() {
    let triangles = sphere(24, 1.0);
    let bvh = Bvh::new(&triangles);
    let single: Vec<Bvh> = triangles.iter().map(|t| Bvh::new(&[*t])).collect();
    for i in 0..2000 {
        let mut sampler = Sampler::new(3, i, 0);
        let origin = warp::uniform_sphere(sampler.next_2d()) * 2.0;
        let ray = Ray::new(origin, warp::uniform_sphere(sampler.next_2d()));
        let best = single
            .iter()
            .enumerate()
            .filter_map(|(k, b)| b.closest_hit(&ray).map(|h| (h.t, k as u32)))
            .min_by(|a, b| a.partial_cmp(b).unwrap());
        let hit = bvh.closest_hit(&ray).map(|h| (h.t, h.triangle));
        assert_eq!(hit, best, "ray {i}");
        assert_eq!(bvh.is_occluded(&ray), best.is_some());
    }
}

/// Rays at corners and edges, which the next triangle must catch where the first misses.
#[test]
fn no_ray_slips_through_a_closed_mesh() {
    const N_RAYS: u64 = 10_000_000;
    let scales = [1e-3, 1e-1, 1.0, 1e2, 1e4];
    let kernels: Vec<Kernel> = Kernel::available().collect();
    let n = N_RAYS / (scales.len() * kernels.len()) as u64;
    for scale in scales {
        let triangles = sphere(40, scale);
        let mut bvh = Bvh::new(&triangles);
        for &kernel in &kernels {
            bvh.kernel = kernel;
            let slips = |i: u64| {
                let mut sampler = Sampler::new(5, i, 0);
                let origin = warp::uniform_sphere(sampler.next_2d()) * (0.5 * scale);
                let triangle = &triangles[i as usize % triangles.len()];
                let along = if i.is_multiple_of(2) {
                    0.0
                } else {
                    sampler.next_1d()
                };
                let target = triangle[0] + (triangle[1] - triangle[0]) * along;
                let ray = Ray::new(origin, (target - origin).normalize());
                bvh.closest_hit(&ray).is_none() || !bvh.is_occluded(&ray)
            };
            let slipped = (0..n).into_par_iter().find_any(|i| slips(*i));
            assert_eq!(slipped, None, "ray at scale {scale}, {kernel:?}");
        }
    }
}

#[test]
fn kernels_agree_to_the_bit() {
    let triangles = sphere(40, 1.0);
    let mut bvh = Bvh::new(&triangles);
    for i in 0..100_000 {
        let mut sampler = Sampler::new(6, i, 0);
        let origin = warp::uniform_sphere(sampler.next_2d()) * 1.5;
        let ray = Ray::new(origin, warp::uniform_sphere(sampler.next_2d()));
        let answer = |kernel: Kernel| {
            bvh.kernel = kernel;
            let hit = bvh.closest_hit(&ray);
            let bits = hit.map(|h| (h.triangle, h.t.to_bits(), h.barycentrics.map(f32::to_bits)));
            (bits, bvh.is_occluded(&ray))
        };
        let answers: Vec<_> = Kernel::available().map(answer).collect();
        assert!(
            answers.iter().all(|a| *a == answers[0]),
            "ray {i}: {answers:?}"
        );
    }
}

#[test]
fn rays_abreast_meet_what_they_meet_alone() {
    rays_abreast_meet_what_they_meet_alone_in(&sphere(40, 1.0));
}

#[test]
fn rays_go_together_through_a_small_tree() {
    let mut triangles = sphere(3, 1.0);
    assert!(Bvh::new(&triangles).tree.is_small());
    rays_abreast_meet_what_they_meet_alone_in(&triangles);
    // Half inside another, which makes it deeper, with some of the triangles there twice.
    triangles.extend(sphere(3, 1.3).into_iter().take(10));
    triangles.extend_from_within(2..6);
    let bvh = Bvh::new(&triangles);
    let (n_nodes, n_leaves) = (bvh.tree.nodes.len(), bvh.tree.leaves.len());
    assert!(bvh.tree.is_small() && n_nodes > 1, "{n_nodes}, {n_leaves}");
    rays_abreast_meet_what_they_meet_alone_in(&triangles);
}

fn rays_abreast_meet_what_they_meet_alone_in(triangles: &[[Vec3; 3]]) {
    let mut bvh = Bvh::new(triangles);
    let (mut n_hits, mut n_occluded) = (0, 0);
    for i in 0..20_000 {
        let mut rays = RayLanes::default();
        for lane in 0..LANES {
            let mut sampler = Sampler::new(16, i, lane as u32);
            let origin = warp::uniform_sphere(sampler.next_2d()) * 1.5;
            let towards = match lane {
                // Along the axes, forwards and backwards, where a direction has zeros of either
                // sign.
                0 => Vec3::X,
                1 => -Vec3::Y,
                2 => Vec3::new(-0.0, 0.0, 1.0),
                3 => continue,
                // At corners and edges.
                4 => triangles[i as usize % triangles.len()][0] - origin,
                5 => {
                    let [a, b, _] = triangles[i as usize % triangles.len()];
                    a + (b - a) * sampler.next_1d() - origin
                }
                _ => warp::uniform_sphere(sampler.next_2d()),
            };
            let ray = if lane % 2 == 0 {
                Ray::new(origin, towards.normalize())
            } else {
                Ray::with_end(origin, towards * 1.7, 1.0)
            };
            rays.set(lane, &ray);
        }
        for kernel in Kernel::available() {
            bvh.kernel = kernel;
            let (hits, _) = bvh.closest_hits(&rays);
            let sight = bvh.occluded(&rays);
            for (lane, found) in hits.into_iter().enumerate() {
                let is_there = rays.mask() >> lane & 1 != 0;
                let alone = is_there.then(|| rays.get(lane));
                let bits = |hit: Option<Hit>| {
                    hit.map(|h| (h.triangle, h.t.to_bits(), h.barycentrics.map(f32::to_bits)))
                };
                let hit = alone.and_then(|ray| bvh.closest_hit(&ray));
                assert_eq!(bits(found), bits(hit), "{kernel:?}, {i}, lane {lane}");
                let is_occluded = alone.is_some_and(|ray| bvh.is_occluded(&ray));
                if sight.unsure >> lane & 1 == 0 {
                    let is_stopped = sight.stopped >> lane & 1 != 0;
                    assert_eq!(is_stopped, is_occluded, "{kernel:?}, {i}");
                }
                n_hits += u32::from(hit.is_some());
                n_occluded += u32::from(is_occluded);
            }
        }
    }
    assert!(n_hits > 100_000 && n_occluded > 100_000);
}

#[test]
fn of_two_triangles_at_one_distance_the_lower_index_is_hit() {
    let t = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let ray = Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z);
    let mut triangles = vec![t; 9];
    triangles[0] = t.map(|v| v - Vec3::Z);
    assert_eq!(Bvh::new(&triangles).closest_hit(&ray).unwrap().triangle, 1);
}

#[test]
fn trees_of_any_quality_are_hit_alike() {
    let triangles = sphere(40, 1.0);
    let [quick, full] = [TreeQuality::Quick, TreeQuality::Full]
        .map(|quality| Bvh::with_instances(&triangles, &[], &[], quality));
    let mut halved = Bvh::new(&triangles);
    halved.tree = WideTree::of_triangles(&BinaryTree::of_halves(&boxes_of(&triangles)), &triangles);
    assert!(quick.tree.nodes.len() != full.tree.nodes.len(), "the same");
    // Six thousand triangles: thirteen halvings.
    assert!(halved.tree.depth <= 13);
    for i in 0..100_000 {
        let mut sampler = Sampler::new(12, i, 0);
        let origin = 2.0 * warp::uniform_sphere(sampler.next_2d());
        let mut target = warp::uniform_sphere(sampler.next_2d());
        if i % 2 == 0 {
            // A corner, where several triangles are as near but for rounding.
            target = triangles[i as usize / 2 % triangles.len()][0];
        }
        let towards = target - origin;
        let ray = Ray::new(origin, towards.normalize());
        let answers = [&quick, &full, &halved].map(|bvh| {
            let hit = bvh.closest_hit(&ray);
            (hit.map(|h| (h.triangle, h.t)), bvh.is_occluded(&ray))
        });
        assert!(answers[0] == answers[1] && answers[0] == answers[2]);
    }
}

#[test]
fn a_tree_that_is_too_deep_to_be_walked_is_told() {
    // Triangles far apart, each half as far as the last: the deepest tree that single precision has
    // room for.
    let triangles: Vec<[Vec3; 3]> = (-90..30)
        .map(|i| [Vec3::X, Vec3::ONE, Vec3::new(1.0, 0.0, 1.0)].map(|p| p * 2f32.powi(i)))
        .collect();
    assert!(Bvh::new(&triangles).tree.fits_stack());
    let tree = WideTree {
        depth: STACK_SIZE / (WIDTH - 1) + 1,
        ..WideTree::default()
    };
    assert!(!tree.fits_stack());
}

#[test]
fn instances_are_hit_where_their_triangles_would_be() {
    let mesh = sphere(12, 0.5);
    let ground = vec![[
        Vec3::new(-9.0, -2.0, -9.0),
        Vec3::new(0.0, -2.0, 9.0),
        Vec3::new(9.0, -2.0, -9.0),
    ]];
    let mut flat = ground.clone();
    let mut placements = Vec::new();
    for i in 0..40 {
        let mut sampler = Sampler::new(8, i, 0);
        let world_from_mesh = Affine3A::from_scale_rotation_translation(
            // One in four is mirrored.
            Vec3::new(if i % 4 == 0 { -0.7 } else { 1.2 }, 0.8, 1.0),
            Quat::from_axis_angle(warp::uniform_sphere(sampler.next_2d()), 2.0),
            warp::uniform_sphere(sampler.next_2d()) * 3.0,
        );
        placements.push(Placement {
            mesh: 0,
            world_from_mesh,
            first_triangle: flat.len() as u32,
        });
        flat.extend(
            mesh.iter()
                .map(|t| t.map(|v| world_from_mesh.transform_point3(v))),
        );
    }
    let mut instanced = Bvh::with_instances(&ground, &[mesh], &placements, TreeQuality::Full);
    let flattened = Bvh::new(&flat);
    for kernel in Kernel::available() {
        instanced.kernel = kernel;
        let mut n_hits = 0;
        for i in 0..20_000 {
            let mut sampler = Sampler::new(9, i, 0);
            let origin = warp::uniform_sphere(sampler.next_2d()) * 5.0;
            let target = warp::uniform_sphere(sampler.next_2d()) * 3.0;
            let ray = Ray::new(origin, (target - origin).normalize());
            let [a, b] = [&instanced, &flattened].map(|bvh| bvh.closest_hit(&ray));
            // Rounding may decide otherwise at a silhouette, and among neighbours at an edge.
            if let (Some(a), Some(b)) = (a, b) {
                n_hits += 1;
                let apart = (a.t - b.t).abs();
                assert!(
                    apart < 1e-4 || a.triangle != b.triangle,
                    "ray {i}: {a:?} {b:?}"
                );
            }
            assert_eq!(instanced.is_occluded(&ray), a.is_some(), "ray {i}");
            n_hits -= i32::from(a.is_some() != b.is_some()) * 1000;
        }
        assert!(n_hits > 10_000, "{n_hits} agree");
    }
}

#[test]
fn an_empty_tree_is_missed() {
    let ray = Ray::new(Vec3::ZERO, Vec3::X);
    assert!(Bvh::new(&[]).closest_hit(&ray).is_none());
    assert!(!Bvh::new(&[]).is_occluded(&ray));
}

/// Rays of which some number is not finite, or hardly: any of them may come, none may do harm.
#[test]
fn rays_that_are_not_finite_come_to_an_end() {
    let odd = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        -f32::MAX,
        f32::MIN_POSITIVE,
        1e-45,
        0.0,
    ];
    let mesh = sphere(12, 0.5);
    let placements = [-2.0, 0.0, 2.0].map(|x| Placement {
        mesh: 0,
        world_from_mesh: Affine3A::from_translation(Vec3::X * x),
        first_triangle: 100_000 + (x as i32 + 2) as u32 * 1000,
    });
    let full = TreeQuality::Full;
    let mut trees = [
        Bvh::new(&sphere(40, 1.0)),
        Bvh::new(&sphere(3, 1.0)),
        Bvh::new(&sphere(1, 1.0)),
        Bvh::with_instances(&sphere(3, 1.0), &[mesh], &placements, full),
    ];
    for bvh in &mut trees {
        for kernel in Kernel::available() {
            bvh.kernel = kernel;
            for i in 0..4096 {
                let mut sampler = Sampler::new(21, i, 0);
                let mut rays = RayLanes::default();
                for lane in 0..LANES {
                    let u = warp::uniform_sphere(sampler.next_2d());
                    let v = warp::uniform_sphere(sampler.next_2d());
                    let mut numbers = [u.x, u.y, u.z, v.x, v.y, v.z, f32::INFINITY];
                    for (digit, number) in numbers.iter_mut().enumerate() {
                        let pick = (i as usize + lane * 521) >> digit & 7;
                        if sampler.next_1d() < 0.4 {
                            *number = odd[pick];
                        }
                    }
                    let [a, b, c, d, e, f, end] = numbers;
                    let ray = Ray::with_end(Vec3::new(a, b, c), Vec3::new(d, e, f), end);
                    rays.set(lane, &ray);
                    let _ = (bvh.closest_hit(&ray), bvh.is_occluded(&ray));
                }
                let _ = (bvh.closest_hits(&rays), bvh.occluded(&rays));
            }
        }
    }
}

#[test]
fn a_ray_does_not_meet_the_triangles_that_it_starts_and_ends_on() {
    for n in [3, 40] {
        let triangles = sphere(n, 1.0);
        let mut bvh = Bvh::new(&triangles);
        for kernel in Kernel::available() {
            bvh.kernel = kernel;
            for i in 0..5000 {
                let mut rays = RayLanes::default();
                for lane in 0..LANES {
                    let mut sampler = Sampler::new(22, i, lane as u32);
                    let mut point = || {
                        let triangle = (sampler.next_1d() * triangles.len() as f32) as usize;
                        let [a, b, c] = triangles[triangle];
                        let [u, v] = warp::triangle(sampler.next_2d());
                        (a + (b - a) * u + (c - a) * v, triangle as u32)
                    };
                    let ((from, start), (to, end)) = (point(), point());
                    let ray = Ray::with_end(from, to - from, 1.0);
                    rays.set(lane, &ray.leaving(start).aimed_at(end));
                }
                let (hits, unsure) = bvh.closest_hits(&rays);
                for (lane, hit) in hits.into_iter().enumerate() {
                    let ray = rays.get(lane);
                    let alone = bvh.meet(&ray);
                    assert_eq!(hit.map(|h| h.triangle), alone.hit.map(|h| h.triangle));
                    for hit in [hit, alone.hit].into_iter().flatten() {
                        assert!(hit.triangle != ray.leaves() && hit.triangle != ray.aims_at());
                    }
                    // Two points of a sphere that is nearly convex seldom hide each other.
                    assert!(alone.is_sure || unsure != 0 || n == 40);
                }
            }
        }
    }
}

/// Rays that leave a plane of many triangles, however flatly, meet none of the others, nor do those
/// that end there; a leaf of such triangles is passed.
#[test]
fn rays_along_a_plane_of_many_triangles_do_not_meet_it() {
    let turn = Quat::from_axis_angle(Vec3::new(0.48, 0.6, 0.64), 0.7);
    let at = |i: i32, j: i32| turn * Vec3::new(i as f32 - 2.0, 0.3, j as f32 - 2.0);
    let mut triangles = Vec::new();
    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    let mut bvh = Bvh::new(&triangles);
    let links = bvh.tree.nodes.iter().flat_map(|node| node.children);
    assert!(links.filter(|link| link & FLAT != 0).count() >= 8);
    let mut n_unsure = 0;
    for kernel in Kernel::available() {
        bvh.kernel = kernel;
        for i in 0..2000 {
            let mut rays = RayLanes::default();
            for lane in 0..LANES {
                let mut sampler = Sampler::new(24, i, lane as u32);
                let triangle = (sampler.next_1d() * triangles.len() as f32) as usize;
                let [a, b, c] = triangles[triangle];
                let [u, v] = warp::triangle(sampler.next_2d());
                let point = a + (b - a) * u + (c - a) * v;
                let d = warp::uniform_hemisphere(sampler.next_2d());
                let away = turn * Vec3::new(d.x, d.z * 0.1, d.y);
                rays.set(
                    lane,
                    &if lane % 2 == 0 {
                        Ray::new(point, away.normalize()).leaving(triangle as u32)
                    } else {
                        Ray::with_end(point + away, -away, 1.0).aimed_at(triangle as u32)
                    },
                );
            }
            let (hits, unsure) = bvh.closest_hits(&rays);
            let sight = bvh.occluded(&rays);
            n_unsure += (unsure | sight.unsure).count_ones();
            for (lane, hit) in hits.into_iter().enumerate() {
                assert!(hit.is_none() || unsure >> lane & 1 != 0, "{kernel:?}, {i}");
            }
            assert_eq!(sight.stopped, 0, "{kernel:?}, {i}");
        }
    }
    assert!(n_unsure < 100, "{n_unsure}");
}

/// The distance of a triangle along a ray in double precision.
fn distance(ray: &Ray, triangle: &[Vec3; 3]) -> f64 {
    let [a, b, c] = triangle.map(Vec3::as_dvec3);
    let normal: DVec3 = (b - a).cross(c - a);
    let origin = ray.origin().as_dvec3();
    normal.dot(a - origin) / normal.dot(ray.direction().as_dvec3())
}

/// A small thing on a floor of kilometres, where single precision is off by more than the thing is
/// wide: whatever a kernel is
/// sure of must be so.
#[test]
fn what_is_sure_is_right_in_double_precision() {
    for (size, tilt) in [(3.0f32, 0.0), (300.0, 0.1), (3000.0, 0.0), (3000.0, 0.3)] {
        let turn = Quat::from_rotation_z(tilt);
        let floor = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]]
            .map(|[x, z]| turn * (Vec3::new(x, 0.0, z) * size));
        let mut triangles = vec![
            [floor[0], floor[1], floor[2]],
            [floor[0], floor[2], floor[3]],
        ];
        let ball = sphere(if size < 10.0 { 3 } else { 12 }, 0.005);
        triangles.extend(ball.iter().map(|t| t.map(|v| turn * (v + Vec3::Y * 0.004))));
        let mut bvh = Bvh::new(&triangles);
        for kernel in Kernel::available() {
            bvh.kernel = kernel;
            let (mut n_sure, mut n_hits) = (0, 0);
            for i in 0..4000 {
                let mut rays = RayLanes::default();
                for lane in 0..LANES {
                    let mut sampler = Sampler::new(23, i, lane as u32);
                    let d = warp::uniform_hemisphere(sampler.next_2d());
                    let origin = turn * (Vec3::new(d.x, d.z, d.y) * 0.3);
                    let target = warp::uniform_sphere(sampler.next_2d()) * 0.007;
                    rays.set(lane, &Ray::new(origin, (target - origin).normalize()));
                }
                let (hits, unsure) = bvh.closest_hits(&rays);
                for (lane, hit) in hits.into_iter().enumerate() {
                    let ray = rays.get(lane);
                    let alone = bvh.meet(&ray);
                    let together = (hit, unsure >> lane & 1 == 0);
                    for (hit, is_sure) in [together, (alone.hit, alone.is_sure)] {
                        n_hits += 1;
                        let Some(hit) = hit.filter(|_| is_sure) else {
                            continue;
                        };
                        n_sure += 1;
                        let t = distance(&ray, &triangles[hit.triangle as usize]);
                        bvh.crossings(&ray, &mut |other| {
                            let other = other.hit.triangle;
                            let before = distance(&ray, &triangles[other as usize]);
                            let is_first = other == hit.triangle || before > t || before <= 0.0;
                            assert!(is_first, "{kernel:?}, {i}, {lane}: {t}, {before}");
                            f32::INFINITY
                        });
                    }
                }
            }
            let share = f64::from(n_sure) / f64::from(n_hits);
            assert!(size > 10.0 || share > 0.9, "{kernel:?}, {size}: {share}");
        }
    }
}
