//! Every BSDF at work: drawing a direction, and finding value and density of a given one.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::Vec3;
use neumann_core::bsdf::{Scatter, TransportMode};
use neumann_core::sampling::{Sampler, warp};
use neumann_tests::bsdfs::{Example, examples};

/// Pairs of directions, in no order.
const N: u64 = 4096;

fn main() {
    divan::main();
}

fn names() -> impl Iterator<Item = String> {
    examples().into_iter().map(|example| example.name)
}

/// Counted in directions.
#[divan::bench(args = names())]
fn sample(bencher: Bencher<'_, '_>, name: &str) {
    let bsdf = example(name).bsdf;
    let cases: Vec<(Vec3, [f32; 3])> = numbers()
        .map(|mut s| {
            let wo = warp::uniform_hemisphere(s.next_2d());
            let [a, b] = s.next_2d();
            (wo, [s.next_1d(), a, b])
        })
        .collect();
    bencher.counter(ItemsCount::new(N)).bench_local(|| {
        for (wo, u) in &cases {
            black_box(black_box(&bsdf).sample(*wo, *u, TransportMode::Radiance));
        }
    });
}

/// Counted in pairs of directions.
#[divan::bench(args = names())]
fn eval_and_pdf(bencher: Bencher<'_, '_>, name: &str) {
    let bsdf = example(name).bsdf;
    let cases: Vec<[Vec3; 2]> = numbers()
        .map(|mut s| [(); 2].map(|()| warp::uniform_hemisphere(s.next_2d())))
        .collect();
    bencher.counter(ItemsCount::new(N)).bench_local(|| {
        for [wo, wi] in &cases {
            let bsdf = black_box(&bsdf);
            black_box(bsdf.eval(*wo, *wi, TransportMode::Radiance));
            black_box(bsdf.pdf_w(*wo, *wi, TransportMode::Radiance));
        }
    });
}

fn example(name: &str) -> Example {
    let found = examples().into_iter().find(|example| example.name == name);
    found.expect("it is in the list")
}

fn numbers() -> impl Iterator<Item = Sampler<'static>> {
    (0..N).map(|path| Sampler::new(1, path, 0))
}
