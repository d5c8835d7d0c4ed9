//! The same bits, whatever the threads, the interruptions and the parts?
//!
//! For every row of `METHODS`. Latencies are counted in paths, never timed.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::sync::{Arc, LazyLock};
use std::time::Duration;

use glam::Vec3;
use neumann_core::accel::TreeQuality;
use neumann_core::film::{Contribution, Film, Strategy};
use neumann_core::integrator::{
    Integrator, METHODS, Method, ParameterValues, PathIntegrator, PathStart, Sight, Value,
};
use neumann_core::pass::PixelSink;
use neumann_core::radiometry::Rgb;
use neumann_core::render::{CancelToken, Cancelled, Job, RenderLoop, Renderer, StopRule};
use neumann_core::scene::description::{MeshDescription, SceneDescription};
use neumann_core::scene::{OpeningProgress, Scene};
use neumann_core::transport::Tracer;
use neumann_tests::renders::{Setup, pool, pool_of};
use neumann_tests::room::room_with_spheres;
use neumann_tests::scenes::{Stage, builtin, emitter, lambert, looking, rectangle};

fn assert_same_bits(a: &Film, b: &Film, what: &str) {
    assert_eq!(a.n_iterations(), b.n_iterations(), "{what}");
    assert_eq!(a.layers(), b.layers(), "{what}: layers differ");
    assert_eq!(a.total(), b.total(), "{what}: totals differ");
    for pixel in 0..a.total().len() {
        assert_eq!(
            a.variance_of_mean(pixel),
            b.variance_of_mean(pixel),
            "{what}"
        );
    }
}

/// Every method with its default parameters, and adaptive sampling, which looks at iterations
/// before its own.
fn ways(scene: &Arc<Scene>, width: usize, height: usize) -> Vec<(String, Setup)> {
    let setup = Setup::new(scene, width, height);
    let by = |method: &&'static Method| (method.id.to_owned(), setup.clone().by(method));
    let mut ways: Vec<_> = METHODS.iter().map(by).collect();
    let mut adaptive = setup;
    adaptive
        .settings
        .values
        .put("adaptive", Value::Switch(true));
    ways.push(("adaptive".to_owned(), adaptive));
    ways
}

#[test]
fn threads_do_not_matter() {
    for name in ["cornell-glass", "many", "sky"] {
        let scene = builtin(name);
        // More than one tile, and tiles that are cut off.
        for (id, setup) in ways(&scene, 41, 35) {
            let setup = setup.seeded(7);
            // From the fifth iteration on, adaptive sampling goes by what it measured.
            let one = setup.film_on(pool_of(1), 2, 4);
            for n_threads in [2, 7] {
                let other = setup.film_on(pool_of(n_threads), 2, 4);
                let what = format!("{name}, {id}, {n_threads} threads");
                assert_same_bits(&one, &other, &what);
            }
        }
    }
}

#[test]
fn seeds_and_iterations_matter() {
    let scene = builtin("cornell");
    for (id, setup) in ways(&scene, 16, 16) {
        // Adaptive sampling begins with the fifth iteration.
        let first = if id == "adaptive" { 4 } else { 0 };
        let film = setup.film(first, 1);
        assert!(film.total() != setup.film(first + 1, 1).total(), "{id}");
        let other = setup.clone().seeded(1).film(first, 1);
        assert!(film.total() != other.total(), "{id}");
    }
}

#[test]
fn a_cancelled_iteration_leaves_no_trace() {
    let scene = builtin("cornell-glass");
    for (id, setup) in ways(&scene, 33, 20) {
        let whole = setup.film(0, 6);
        let mut film = Film::new(33, 20, setup.settings.n_layers);
        let mut renderer = Renderer::new(Arc::clone(&scene), setup.settings.clone(), pool(), 0);
        for _ in 0..6 {
            let cancelled = CancelToken::default();
            cancelled.cancel();
            assert!(matches!(
                renderer.iterate_after(&film, &cancelled),
                Err(Cancelled)
            ));
            let iteration = renderer.iterate_after(&film, &CancelToken::default());
            iteration.unwrap().add_to(&mut film);
        }
        assert_same_bits(&whole, &film, &id);
    }
}

/// A film that tiles go into as soon as they have been traced is the one that whole frames are
/// added to.
#[test]
fn tiles_at_once_are_those_of_whole_frames() {
    let scene = builtin("cornell-glass");
    for (id, setup) in ways(&scene, 33, 20) {
        let mut film = Film::new(33, 20, setup.settings.n_layers);
        let mut renderer = Renderer::new(Arc::clone(&scene), setup.settings.clone(), pool(), 0);
        for _ in 0..6 {
            film.add(renderer.iterate(&CancelToken::default()).unwrap());
        }
        assert_same_bits(&setup.film(0, 6), &film, &id);
    }
}

/// Paths begun by [`Stumbling`], and the token that it cancels on its way.
static N_BEGUN: AtomicUsize = AtomicUsize::new(0);
static TRIPWIRE: LazyLock<CancelToken> = LazyLock::new(CancelToken::default);
const TRIP_AT: usize = 1000;

/// A method that is cancelled in the middle of an iteration, as from another thread.
struct Stumbling;

impl PathIntegrator for Stumbling {
    fn trace_path(&self, _: &PathStart<'_>, _: &mut Tracer<'_>, _: &mut PixelSink<'_>) {
        if N_BEGUN.fetch_add(1, Ordering::Relaxed) == TRIP_AT {
            TRIPWIRE.cancel();
        }
    }
}

static STUMBLING: Method = Method {
    id: "stumbling",
    title: "",
    name: "",
    about: "",
    blind_spots: "",
    formula: "",
    pseudo_code: "",
    sight: Sight::FULL,
    bias: None,
    has_techniques: false,
    has_photons: false,
    parameters: &[],
    build: |_: &ParameterValues| Integrator::Pixels(Box::new(Stumbling)),
};

/// Each worker finishes at most the row of the tile that it is in.
#[test]
fn cancelling_is_heeded_within_a_row() {
    let setup = Setup::new(&builtin("cornell"), 640, 480).by(&STUMBLING);
    let n_threads = 3;
    let mut renderer = Renderer::new(setup.scene, setup.settings, pool_of(n_threads), 0);
    assert_eq!(renderer.iterate(&TRIPWIRE).err(), Some(Cancelled));
    let n_late = N_BEGUN.load(Ordering::Relaxed) - TRIP_AT;
    assert!(
        n_late <= 16 * n_threads,
        "{n_late} paths after the cancellation"
    );
}

/// A method that adds what is no radiance beside what is, and something very bright.
struct Odd;

impl PathIntegrator for Odd {
    fn trace_path(&self, _: &PathStart<'_>, _: &mut Tracer<'_>, sink: &mut PixelSink<'_>) {
        for value in [f32::NAN, f32::INFINITY, -1.0, 1e20] {
            sink.add(Contribution {
                value: Rgb::splat(value),
                mis_weight: 1.0,
                bounce: 0,
                strategy: Strategy::hit(2),
            });
        }
    }
}

static ODD: Method = Method {
    id: "odd",
    build: |_: &ParameterValues| Integrator::Pixels(Box::new(Odd)),
    ..STUMBLING
};

#[test]
fn what_is_no_radiance_is_refused_and_counted_and_the_rest_is_not_clamped() {
    // In a closed sphere every tile shows a surface, so that its paths are traced.
    let setup = Setup::new(&builtin("furnace"), 17, 3).by(&ODD);
    let film = setup.film(0, 2);
    assert_eq!(film.n_refused(), 2 * 3 * 17 * 3);
    let total = film.total();
    assert!(total.iter().all(|radiance| *radiance == Rgb::splat(1e20)));
}

#[test]
fn a_run_is_the_sum_of_its_parts() {
    let scene = builtin("cornell-glass");
    for (id, setup) in ways(&scene, 24, 24) {
        let setup = setup.seeded(3);
        let whole = setup.film(0, 64);
        // Two ranges rendered apart and merged, in either order.
        for first_is_early in [true, false] {
            let (early, late) = (setup.film(0, 32), setup.film(32, 32));
            let (mut film, rest) = if first_is_early {
                (early, late)
            } else {
                (late, early)
            };
            film.merge(&rest).unwrap();
            assert_close(&whole, &film, &id);
        }
        // The first part goes on where it stopped, from what a file would hold of it.
        let part = setup.film(0, 20);
        let variance: Vec<_> = (0..24 * 24).map(|i| part.variance_of_mean(i)).collect();
        let mut film = Film::from_parts(
            (24, 24),
            part.n_iterations(),
            part.layers().to_vec(),
            part.total().to_vec(),
            &variance,
            part.n_refused(),
        )
        .unwrap();
        film.set_spread(&part.spread()).unwrap();
        let settings = setup.settings.clone();
        let mut renderer = Renderer::new(Arc::clone(&scene), settings, pool(), 20);
        for _ in 20..64 {
            film.add(renderer.iterate(&CancelToken::default()).unwrap());
        }
        assert_same_bits(&whole, &film, &format!("{id}: resumed"));
    }
}

/// Equal to 1e-6 of the brightest channel of the pixel and of the image's mean.
fn assert_close(a: &Film, b: &Film, what: &str) {
    assert_eq!(a.n_iterations(), b.n_iterations(), "{what}");
    let planes = a
        .layers()
        .iter()
        .chain([&a.total().to_vec()])
        .cloned()
        .collect::<Vec<_>>();
    let others = b
        .layers()
        .iter()
        .chain([&b.total().to_vec()])
        .cloned()
        .collect::<Vec<_>>();
    for (plane, other) in planes.iter().zip(&others) {
        let mean = plane.iter().map(|c| c.mean()).sum::<f32>() / plane.len() as f32;
        for (x, y) in plane.iter().zip(other) {
            let apart = (*x - *y).map(f32::abs).max_channel();
            assert!(
                apart <= 1e-6 * x.max_channel().max(mean),
                "{what}: {x:?} and {y:?}"
            );
        }
    }
    for pixel in 0..a.total().len() {
        let (x, y) = (a.variance_of_mean(pixel), b.variance_of_mean(pixel));
        let apart = (x - y).map(f32::abs).max_channel();
        assert!(
            apart <= 1e-3 * x.max_channel() + 1e-12,
            "{what}: variance {x:?} {y:?}"
        );
    }
}

/// A loop and a channel that rings after every change of the picture.
fn watched_loop() -> (RenderLoop, mpsc::Receiver<()>) {
    let (sender, receiver) = mpsc::channel();
    let render_loop = RenderLoop::new(pool_of(2), move || {
        // Whoever listened may be gone already.
        let _ = sender.send(());
    })
    .expect("a thread for the loop");
    (render_loop, receiver)
}

/// Waits until the picture is as asked for; a minute is for ever.
fn wait_for(
    render_loop: &RenderLoop,
    bell: &mpsc::Receiver<()>,
    mut is_there: impl FnMut(&neumann_core::render::Published) -> bool,
) {
    while !is_there(&render_loop.published()) {
        bell.recv_timeout(Duration::from_secs(60))
            .expect("the loop published nothing for a minute");
    }
}

#[test]
fn the_loop_ends_at_full_resolution_with_the_same_bits() {
    let scene = builtin("cornell");
    let (render_loop, bell) = watched_loop();
    for &method in METHODS {
        // Large enough that the ladder has a rung below the top.
        let setup = Setup::new(&scene, 300, 200).by(method).up_to(3);
        let generation = render_loop.start(Job {
            scene: Arc::clone(&scene),
            settings: setup.settings.clone(),
            stop: StopRule::Iterations(2),
        });
        let mut divisors = Vec::new();
        wait_for(&render_loop, &bell, |p| {
            if p.generation != generation {
                return false;
            }
            if divisors.last() != Some(&p.divisor) {
                divisors.push(p.divisor);
                let size = (p.film.width(), p.film.height());
                assert_eq!(
                    size,
                    (300usize.div_ceil(p.divisor), 200usize.div_ceil(p.divisor))
                );
            }
            p.stats.is_done
        });
        assert!(
            divisors.is_sorted_by(|a, b| a > b),
            "{}: {divisors:?}",
            method.id
        );
        let published = render_loop.published();
        assert_eq!(published.divisor, 1);
        assert_eq!(published.stats.n_iterations, 2);
        assert_eq!(published.thumbnails.len(), setup.settings.n_layers + 1);
        assert_same_bits(&published.film, &setup.film(0, 2), method.id);
    }
}

/// Whoever asks for techniques when rendering is done gets those of all iterations, and the picture
/// stays; a rule that asks for less than is there ends rendering, and says so.
#[test]
fn techniques_of_a_picture_that_is_done_are_found() {
    let scene = builtin("cornell");
    let (render_loop, bell) = watched_loop();
    let method = METHODS.iter().find(|method| method.has_techniques);
    let setup = Setup::new(&scene, 60, 40).by(method.expect("one")).up_to(3);
    render_loop.start(Job {
        scene: Arc::clone(&scene),
        settings: setup.settings.clone(),
        stop: StopRule::Never,
    });
    wait_for(&render_loop, &bell, |p| {
        p.divisor == 1 && p.stats.n_iterations >= 5
    });
    render_loop.stop_after(StopRule::Iterations(2));
    wait_for(&render_loop, &bell, |p| p.stats.is_done);
    let n_iterations = render_loop.published().film.n_iterations();
    assert!(n_iterations >= 5, "nothing is taken back");
    assert!(render_loop.published().techniques.is_none());
    render_loop.record_techniques(true);
    wait_for(&render_loop, &bell, |p| {
        let techniques = p.techniques.as_ref();
        techniques.is_some_and(|t| t.n_iterations() == n_iterations)
    });
    let published = render_loop.published();
    assert!(published.stats.is_done);
    assert_same_bits(&published.film, &setup.film(0, n_iterations), "once more");
}

/// The loop is told while it has nothing to do, so no iteration comes that could say it.
#[test]
fn a_rule_that_has_been_met_already_ends_a_job_that_rests() {
    let (render_loop, bell) = watched_loop();
    let setup = Setup::new(&builtin("cornell"), 60, 40).up_to(3);
    render_loop.start(Job {
        scene: builtin("cornell"),
        settings: setup.settings.clone(),
        stop: StopRule::Never,
    });
    let is_at_top = |p: &neumann_core::render::Published| p.divisor == 1;
    wait_for(&render_loop, &bell, |p| {
        is_at_top(p) && p.stats.n_iterations >= 3
    });
    render_loop.pause(true);
    // An iteration may be under way.
    while bell.recv_timeout(Duration::from_millis(300)).is_ok() {}
    assert!(!render_loop.published().stats.is_done);
    render_loop.stop_after(StopRule::Iterations(2));
    wait_for(&render_loop, &bell, |p| p.stats.is_done);
    render_loop.stop_after(StopRule::Never);
    wait_for(&render_loop, &bell, |p| !p.stats.is_done);
}

/// A room with enough triangles that a quick tree is built first.
fn big_scene() -> SceneDescription {
    let corners = room_with_spheres(30);
    let mut stage = Stage::default();
    let mesh = MeshDescription {
        positions: corners.concat(),
        triangles: (0..corners.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect(),
        ..MeshDescription::default()
    };
    stage.add("spheres", mesh, lambert(0.7));
    let light = rectangle(Vec3::Y * 3.9, Vec3::X, Vec3::Z);
    stage.add("light", light, emitter(20.0));
    stage.description.cameras = vec![looking(Vec3::new(0.0, 0.5, 5.5), Vec3::ZERO)];
    stage.description
}

#[test]
fn a_better_tree_changes_no_bit() {
    let description = big_scene();
    let quick = Arc::new(Scene::build_quickly(
        &description,
        &OpeningProgress::default(),
    ));
    assert_eq!(quick.bvh().quality(), TreeQuality::Quick);
    let tree = quick.better_tree().expect("there is a better one");
    let better = Arc::new(quick.with_tree(&tree).expect("it is for this scene"));
    assert_eq!(better.bvh().quality(), TreeQuality::Full);
    assert!(better.better_tree().is_none());
    let at_once = Arc::new(Scene::build(&description));
    assert!(at_once.with_tree(&tree).is_none(), "of another scene");
    assert!(builtin("cornell").better_tree().is_none());

    let setup = |scene| Setup::new(scene, 48, 40).up_to(4);
    let expected = setup(&at_once).film(0, 3);
    assert_same_bits(&setup(&quick).film(0, 3), &expected, "a quick tree");
    assert_same_bits(&setup(&better).film(0, 3), &expected, "a better tree");

    // In the middle of a job, which goes on.
    let (render_loop, bell) = watched_loop();
    let generation = render_loop.start(Job {
        scene: Arc::clone(&quick),
        settings: setup(&quick).settings,
        stop: StopRule::Never,
    });
    wait_for(&render_loop, &bell, |p| p.stats.n_iterations >= 3);
    render_loop.improve_scene(&at_once, &better);
    render_loop.improve_scene(&quick, &better);
    let n = render_loop.published().stats.n_iterations + 20;
    render_loop.stop_after(StopRule::Iterations(n));
    wait_for(&render_loop, &bell, |p| p.stats.is_done);
    let published = render_loop.published();
    assert_eq!(published.generation, generation);
    let expected = setup(&at_once).film(0, published.stats.n_iterations);
    assert_same_bits(&published.film, &expected, "improved under way");
}

#[test]
fn jobs_start_pause_and_stop() {
    let scene = builtin("cornell");
    let (render_loop, bell) = watched_loop();
    let setup = Setup::new(&scene, 64, 64);
    let job = |seed, stop| Job {
        scene: Arc::clone(&scene),
        settings: setup.clone().seeded(seed).settings,
        stop,
    };
    // Without end, until another job takes over, again and again.
    for seed in 0..5 {
        let generation = render_loop.start(job(seed, StopRule::Never));
        wait_for(&render_loop, &bell, |p| {
            p.generation == generation && p.divisor == 1
        });
        assert!(!render_loop.published().stats.is_done);
    }
    // While paused nothing changes but what was being published already.
    render_loop.pause(true);
    assert!(render_loop.is_paused());
    while bell.recv_timeout(Duration::from_millis(200)).is_ok() {}
    let version = render_loop.version();
    assert!(bell.recv_timeout(Duration::from_millis(100)).is_err());
    assert_eq!(render_loop.version(), version);
    // Going on keeps what was there.
    let before = render_loop.published().stats.n_iterations;
    render_loop.pause(false);
    wait_for(&render_loop, &bell, |p| p.stats.n_iterations > before);
    // A stop rule for the job under way; then more of the same, with the same bits as ever.
    render_loop.stop_after(StopRule::Iterations(before + 20));
    wait_for(&render_loop, &bell, |p| p.stats.is_done);
    let n = render_loop.published().stats.n_iterations;
    assert!(n >= before + 20);
    render_loop.stop_after(StopRule::Iterations(n + 3));
    wait_for(&render_loop, &bell, |p| {
        p.stats.is_done && p.stats.n_iterations == n + 3
    });
    let expected = setup.clone().seeded(4).film(0, n + 3);
    assert_same_bits(
        &render_loop.published().film,
        &expected,
        "paused and resumed",
    );
    // By time: done at some point.
    let generation = render_loop.start(job(9, StopRule::Seconds(0.05)));
    wait_for(&render_loop, &bell, |p| {
        p.generation == generation && p.stats.is_done
    });
    assert!(render_loop.published().stats.n_iterations > 0);
    // Dropped at work: no hang.
    render_loop.start(job(10, StopRule::Never));
    drop(render_loop);
}
