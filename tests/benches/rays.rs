//! Trees over triangles, and rays through them, on one thread.

use divan::Bencher;
use divan::counter::ItemsCount;
use neumann_core::accel::Bvh;
use neumann_core::math::Ray;
use neumann_tests::room::{rays, room_with_spheres};

/// 20 000 and 205 000 triangles.
const FREQUENCIES: [u32; 2] = [10, 32];
/// Side of the picture that the rays belong to, pixels.
const SIDE: u32 = 200;

fn main() {
    divan::main();
}

/// Counted in triangles.
#[divan::bench(args = FREQUENCIES, sample_count = 10)]
fn build(bencher: Bencher<'_, '_>, frequency: u32) {
    let triangles = room_with_spheres(frequency);
    bencher
        .counter(ItemsCount::new(triangles.len()))
        .bench_local(|| Bvh::new(&triangles));
}

#[divan::bench(args = FREQUENCIES)]
fn camera(bencher: Bencher<'_, '_>, frequency: u32) {
    trace(bencher, frequency, 0, |bvh, ray| {
        bvh.closest_hit(ray).is_some()
    });
}

#[divan::bench(args = FREQUENCIES)]
fn bounce(bencher: Bencher<'_, '_>, frequency: u32) {
    trace(bencher, frequency, 1, |bvh, ray| {
        bvh.closest_hit(ray).is_some()
    });
}

#[divan::bench(args = FREQUENCIES)]
fn shadow(bencher: Bencher<'_, '_>, frequency: u32) {
    trace(bencher, frequency, 2, Bvh::is_occluded);
}

/// Counted in rays.
fn trace(bencher: Bencher<'_, '_>, frequency: u32, kind: usize, meets: fn(&Bvh, &Ray) -> bool) {
    let triangles = room_with_spheres(frequency);
    let bvh = Bvh::new(&triangles);
    let rays = &rays(&bvh, &triangles, SIDE)[kind];
    bencher
        .counter(ItemsCount::new(rays.len()))
        .bench_local(|| rays.iter().filter(|ray| meets(&bvh, ray)).count());
}
