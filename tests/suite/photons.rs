//! Do photons that are looked at lie where the map has them, and does looking change nothing?

use std::f32::consts::PI;
use std::sync::{Arc, mpsc};
use std::time::Duration;

use glam::Vec3;
use neumann_core::film::Film;
use neumann_core::integrator::{METHODS, Value, method};
use neumann_core::photons::{Photon, PhotonMap, PhotonPicture, PhotonStack};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{CancelToken, Job, Published, RenderLoop, Renderer, StopRule};
use neumann_core::scene::Scene;
use neumann_core::scene::description::LightKind;
use neumann_tests::renders::{Setup, pool, pool_of};
use neumann_tests::scenes::{Stage, above_square, builtin, lambert, rectangle};

const SIDE: usize = 64;
/// Half the edge of the floor, which is all that the camera sees, metres.
const HALF: f32 = 2.0;
/// Height of the plate over the floor, and of the lamp.
const PLATE: f32 = 1.0;
const LAMP: f32 = 2.0;

/// A floor under a point light of 1 W/sr, with a plate over a part of it or without; seen from
/// above.
fn floor(has_plate: bool) -> Setup {
    let mut stage = Stage::default();
    let (x, z) = (Vec3::X, Vec3::Z);
    stage.add(
        "floor",
        rectangle(Vec3::ZERO, z * HALF, x * HALF),
        lambert(0.8),
    );
    if has_plate {
        let mesh = rectangle(Vec3::new(0.8, PLATE, 0.0), z * 0.5, x * 0.5);
        stage.add("plate", mesh, lambert(0.8));
    }
    let kind = LightKind::Point {
        intensity: Rgb::WHITE,
    };
    stage.light(kind, Vec3::Y * LAMP, Vec3::NEG_Y);
    let mut setup = Setup::seen_by(&stage.scene(), above_square(HALF, 4.0), SIDE, SIDE);
    setup = setup.by(method("pm").expect("a method"));
    setup.settings.values.put("paths", Value::Real(8.0));
    setup
}

fn renderer(setup: &Setup) -> Renderer {
    Renderer::new(Arc::clone(&setup.scene), setup.settings.clone(), pool(), 0)
}

fn looked_at(renderer: &mut Renderer) -> (Arc<PhotonMap>, PhotonPicture) {
    let nobody = CancelToken::default();
    let map = renderer.photons(&nobody).expect("nobody cancels");
    let map = map.expect("the method has photons");
    let picture = renderer.draw_photons(&map, &nobody);
    (map, picture.expect("nobody cancels"))
}

/// The pixel that a photon is seen in, by the geometry of [`floor`] alone; `None` where the plate
/// hides it.
fn pixel_of(photon: &Photon, has_plate: bool) -> Option<usize> {
    let Vec3 { x, y, z } = photon.position;
    let is_on_plate = y > 0.5 * PLATE;
    let is_under = has_plate && (0.3..1.3).contains(&x) && z.abs() < 0.5;
    // What has come from below is under the plate, or on its lower side.
    let is_hidden = if is_on_plate {
        photon.wo.y < 0.0
    } else {
        is_under
    };
    let at = |v: f32| ((v + HALF) / (2.0 * HALF) * SIDE as f32) as usize;
    (!is_hidden).then(|| at(z).min(SIDE - 1) * SIDE + at(x).min(SIDE - 1))
}

#[test]
fn photons_are_seen_where_they_lie_and_hidden_behind_what_is_opaque() {
    for has_plate in [false, true] {
        let (map, picture) = looked_at(&mut renderer(&floor(has_plate)));
        let mut expected = vec![0i64; SIDE * SIDE];
        let mut n_hidden = 0;
        for photon in map.grid.entries() {
            match pixel_of(photon, has_plate) {
                Some(pixel) => expected[pixel] += 1,
                None => n_hidden += 1,
            }
        }
        assert_eq!(n_hidden > 200, has_plate, "{n_hidden} hidden");
        let n_seen = |pixel: usize| -> i64 {
            let stacks = picture.of_pixel(pixel).iter();
            stacks.map(|stack| i64::from(stack.n)).sum()
        };
        let n_apart: i64 = (0..SIDE * SIDE)
            .map(|pixel| (n_seen(pixel) - expected[pixel]).abs())
            .sum();
        // Rounding may put one that lies on an edge of a pixel on its other side.
        let n_photons = map.grid.len() as i64;
        assert!(
            n_photons > 5_000 && n_apart * 2000 < n_photons,
            "{n_apart} of {n_photons}"
        );
    }
}

#[test]
fn what_is_seen_has_the_power_of_the_map_bounce_by_bounce() {
    let (map, picture) = looked_at(&mut renderer(&floor(true)));
    let mut sums: Vec<PhotonStack> = Vec::new();
    for photon in map.grid.entries() {
        if pixel_of(photon, true).is_none() {
            continue;
        }
        let bounce = usize::from(photon.n_vertices) - 1;
        sums.resize(sums.len().max(bounce + 1), PhotonStack::default());
        sums[bounce].n += 1;
        sums[bounce].power += photon.power / map.n_paths as f32;
    }
    let by_bounce = picture.by_bounce();
    assert!(sums.len() > 3 && by_bounce.len() == sums.len());
    for (seen, held) in by_bounce.iter().zip(&sums).skip(1) {
        let bounce = seen.bounce;
        let n_apart = seen.n.abs_diff(held.n);
        assert!(
            n_apart * 1000 <= held.n,
            "bounce {bounce}: {} of {}",
            seen.n,
            held.n
        );
        let apart = (seen.power.g - held.power.g).abs();
        assert!(
            apart <= 2e-3 * held.power.g,
            "bounce {bounce}: {seen:?} {held:?}"
        );
    }
    // What comes straight from the lamp is its intensity times the solid angle of the floor.
    let (_, open) = looked_at(&mut renderer(&floor(false)));
    let solid_angle = 4.0 * (HALF * HALF / (LAMP * LAMP + HALF * HALF)).asin();
    let direct = open.by_bounce()[1].power;
    assert!(
        (direct.g - solid_angle).abs() < 0.01 * solid_angle,
        "{direct:?} {solid_angle}"
    );
    assert!(
        solid_angle < 4.0 * PI && open.by_bounce().len() == 2,
        "nothing else is there"
    );
}

#[test]
fn looking_at_photons_changes_no_bit() {
    for (id, map) in [("pm", 0), ("pm", 1), ("ppm", 0)] {
        let mut setup = Setup::new(&builtin("cornell-glass"), 48, 32);
        setup = setup.by(method(id).expect("a method"));
        if id == "pm" {
            setup.settings.values.put("map", Value::Choice(map));
        }
        let keeps_map = id == "pm" && map == 0;
        let nobody = CancelToken::default();
        let (mut watched, mut alone) = (renderer(&setup), renderer(&setup));
        let black = Film::new(48, 32, setup.settings.n_layers);
        let (mut film, mut other_film) = (black.clone(), black);
        let mut before = None;
        for iteration in 0..3 {
            if iteration != 1 {
                looked_at(&mut watched);
            }
            let frame = watched.iterate(&nobody).expect("nobody cancels");
            let other = alone.iterate(&nobody).expect("nobody cancels");
            film.add(frame);
            other_film.add(other);
            assert_eq!(film.layers(), other_film.layers(), "{id}");
            let report = frame.photons().expect("photons");
            assert_eq!(Some(report), other.photons(), "{id}");
            // Photons that are looked at are those that the iteration reads.
            let (map, picture) = looked_at(&mut watched);
            assert_eq!(report.radius.to_bits(), map.radius.to_bits());
            assert_eq!(report.n_vertices, map.grid.len());
            assert_eq!(picture.iteration(), if keeps_map { 0 } else { iteration });
            let first = map.grid.entries()[0].position;
            let is_another = before.replace(first).is_some_and(|before| before != first);
            assert_eq!(is_another, iteration > 0 && !keeps_map, "{id}");
        }
    }
}

#[test]
fn methods_that_say_so_have_photons() {
    let scene = builtin("cornell");
    for &method in METHODS {
        let setup = Setup::new(&scene, 16, 16).by(method);
        let photons = renderer(&setup).photons(&CancelToken::default());
        let photons = photons.expect("nobody cancels");
        assert_eq!(photons.is_some(), method.has_photons, "{}", method.id);
    }
}

#[test]
fn threads_do_not_matter_to_what_is_seen() {
    let setup = Setup::new(&builtin("cornell-glass"), 48, 32).by(method("ppm").expect("a method"));
    let seen = |n_threads| {
        let pool = pool_of(n_threads);
        let (scene, settings) = (Arc::clone(&setup.scene), setup.settings.clone());
        let (_, picture) = looked_at(&mut Renderer::new(scene, settings, pool, 5));
        let of_pixel = |pixel| picture.of_pixel(pixel).to_vec();
        (0..48 * 32).map(of_pixel).collect::<Vec<_>>()
    };
    assert_eq!(seen(1), seen(3));
}

fn job(scene: &Arc<Scene>, id: &str) -> Job {
    Job {
        scene: Arc::clone(scene),
        settings: Setup::new(scene, 40, 30)
            .by(method(id).expect("a method"))
            .settings,
        stop: StopRule::Iterations(3),
    }
}

/// Nothing is drawn of photons unless somebody looks; then also of an iteration that is done.
#[test]
fn photons_are_published_while_somebody_looks() {
    let (sender, bell) = mpsc::channel();
    let on_publish = move || {
        // Whoever listened may be gone already.
        let _ = sender.send(());
    };
    let render_loop = RenderLoop::new(pool_of(2), on_publish).expect("a thread for the loop");
    let wait = |is_there: &dyn Fn(&Published) -> bool| {
        while !is_there(&render_loop.published()) {
            let rung = bell.recv_timeout(Duration::from_secs(60));
            rung.expect("the loop published nothing for a minute");
        }
    };
    let scene = builtin("cornell");
    for id in ["pm", "ppm"] {
        let generation = render_loop.start(job(&scene, id));
        let is_done = |p: &Published| p.generation == generation && p.stats.is_done;
        wait(&is_done);
        assert!(render_loop.published().photons.is_none(), "nobody looks");
        render_loop.draw_photons(true);
        wait(&|p| p.photons.is_some());
        let photons = render_loop.published().photons.clone().expect("photons");
        assert_eq!((photons.width(), photons.height()), (40, 30));
        assert_eq!(photons.iteration(), if id == "pm" { 0 } else { 2 });
        assert!(photons.n_seen() > 100);
        render_loop.draw_photons(false);
        wait(&|p| p.photons.is_none());
    }
    // Of a method without photons there is nothing to wait for.
    render_loop.draw_photons(true);
    let generation = render_loop.start(job(&scene, "pt-mis"));
    wait(&|p| p.generation == generation && p.stats.is_done);
    assert!(render_loop.published().photons.is_none());
    let generation = render_loop.start(job(&scene, "ppm"));
    wait(&|p| p.generation == generation && p.stats.is_done && p.photons.is_some());
}
