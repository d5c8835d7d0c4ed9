//! What keeping bounces apart costs: taking frames into a film, and drawing a view from it, at
//! 1280×720.

use divan::Bencher;
use divan::counter::ItemsCount;
use neumann_core::film::{Film, View};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{CancelToken, RenderSettings, Renderer, WorkerPool};
use neumann_tests::renders::pool;
use neumann_tests::scenes::builtin;

const SIZE: (usize, usize) = (1280, 720);

fn main() {
    divan::main();
}

/// Counted in pixels.
#[divan::bench(args = [1, 8])]
fn add_frame(bencher: Bencher<'_, '_>, n_layers: usize) {
    let (pool, mut renderer) = renderer(n_layers);
    let frame = renderer
        .iterate(&CancelToken::default())
        .expect("nobody cancels");
    let mut film = Film::new(SIZE.0, SIZE.1, n_layers);
    bencher
        .counter(ItemsCount::new(SIZE.0 * SIZE.1))
        .bench_local(|| pool.run(|| film.add(frame)));
}

/// The sum of the terms up to T³: counted in pixels.
#[divan::bench]
fn compose_partial_sum(bencher: Bencher<'_, '_>) {
    let (_, mut renderer) = renderer(8);
    let mut film = Film::new(SIZE.0, SIZE.1, 8);
    film.add(
        renderer
            .iterate(&CancelToken::default())
            .expect("nobody cancels"),
    );
    let mut out = vec![Rgb::BLACK; SIZE.0 * SIZE.1];
    bencher
        .counter(ItemsCount::new(SIZE.0 * SIZE.1))
        .bench_local(|| film.compose(View::Upto(3), &mut out));
}

fn renderer(n_layers: usize) -> (WorkerPool, Renderer) {
    let scene = builtin("cornell");
    let mut settings = RenderSettings::new(scene.cameras()[0].clone(), SIZE.0, SIZE.1);
    settings.n_layers = n_layers;
    (pool(), Renderer::new(scene, settings, pool(), 0))
}
