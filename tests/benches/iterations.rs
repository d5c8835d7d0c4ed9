//! One iteration of each method, on all threads; and of one by one thread, beside which the first
//! shows how well threads share the work.

use divan::Bencher;
use divan::counter::ItemsCount;
use neumann_core::integrator::{METHODS, ParameterValues, method};
use neumann_core::render::{CancelToken, RenderSettings, Renderer};
use neumann_tests::renders::{pool, pool_of};
use neumann_tests::scenes::builtin;

/// Edge of the picture, pixels.
const EDGE: usize = 256;

fn main() {
    divan::main();
}

fn ids() -> impl Iterator<Item = &'static str> {
    METHODS.iter().map(|method| method.id)
}

/// Counted in pixels.
#[divan::bench(args = ids(), sample_count = 10, sample_size = 1)]
fn cornell(bencher: Bencher<'_, '_>, id: &str) {
    iterate(bencher, "cornell", id, None);
}

#[divan::bench(args = ["pt-mis", "lt", "bdpt", "vcm"], sample_count = 10, sample_size = 1)]
fn cornell_on_one_thread(bencher: Bencher<'_, '_>, id: &str) {
    iterate(bencher, "cornell", id, Some(1));
}

#[divan::bench(args = ["pt-mis", "bdpt", "vcm"], sample_count = 10, sample_size = 1)]
fn lamps(bencher: Bencher<'_, '_>, id: &str) {
    iterate(bencher, "lamps", id, None);
}

fn iterate(bencher: Bencher<'_, '_>, scene: &str, id: &str, n_threads: Option<usize>) {
    let scene = builtin(scene);
    let mut settings = RenderSettings::new(scene.cameras()[0].clone(), EDGE, EDGE);
    settings.method = method(id).expect("it is in the registry");
    settings.values = ParameterValues::defaults(settings.method.parameters);
    let pool = n_threads.map_or_else(pool, pool_of);
    let mut renderer = Renderer::new(scene, settings, pool, 0);
    let cancel = CancelToken::default();
    bencher
        .counter(ItemsCount::new(EDGE * EDGE))
        .bench_local(|| renderer.iterate(&cancel).map(|frame| frame.n_rays()));
}
