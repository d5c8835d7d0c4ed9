//! A window without a renderer: a small film that never changes.

use std::sync::Arc;

use neumann_core::film::{Film, TechniqueFilm};
use neumann_core::integrator::{ParameterValues, method};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{
    CancelToken, Published, RenderSettings, Renderer, Stats, Thumbnail, WorkerPool,
};
use neumann_core::scene::Scene;
use neumann_core::scene::builtin::builtin;
use neumann_picture::Image;
use neumann_picture::compare::compare;
use neumann_picture::race::Point;
use neumann_viewer::ViewOptions;
use neumann_viewer::app::App;
use neumann_viewer::render_link::RenderLink;
use neumann_viewer::views::race::{RaceView, Report, Standing};

/// A film whose layer k is a gradient of strength 2^-k.
pub(crate) fn published() -> Published {
    published_with(8)
}

/// The same with so many layers.
pub(crate) fn published_with(n_layers: usize) -> Published {
    let (width, height) = (96, 96);
    let layer = |k: usize| -> Vec<Rgb> {
        (0..width * height)
            .map(|i| {
                let (x, y) = ((i % width) as f32 / 95.0, (i / width) as f32 / 95.0);
                Rgb::new(x, y, 1.0 - x) * 0.5f32.powi(k as i32 + 1)
            })
            .collect()
    };
    let layers: Vec<_> = (0..=n_layers).map(layer).collect();
    let total: Vec<Rgb> = (0..width * height)
        .map(|i| layers.iter().fold(Rgb::BLACK, |sum, l| sum + l[i]))
        .collect();
    let thumbnails = layers
        .iter()
        .map(|pixels| Thumbnail {
            width,
            height,
            pixels: pixels.clone(),
        })
        .collect();
    let variance = vec![Rgb::splat(1e-4); width * height];
    let film = Film::from_parts((width, height), 64, layers, total, &variance, 0);
    let film = film.expect("planes of one size");
    Published {
        generation: 1,
        version: 1,
        divisor: 1,
        stats: Stats {
            n_iterations: 64,
            seconds: 1.5,
            samples_per_second: 1e6,
            rays_per_second: 5e6,
            estimated_error: Some(0.01),
            n_refused: 0,
            photons: None,
            is_done: false,
        },
        energy_shares: film.energy_shares(),
        layer_errors: (0..=n_layers)
            .map(|k| (k > 0).then_some(0.01 * k as f64))
            .collect(),
        film,
        thumbnails,
        thumbnails_version: 1,
        techniques: None,
        classes: None,
        photons: None,
        features: None,
        samples: None,
    }
}

/// The window on that film, with the furnace as its scene.
pub(crate) fn app() -> App {
    let options = ViewOptions {
        size: Some((96, 96)),
        ..ViewOptions::default()
    };
    app_of(published(), options)
}

/// The window on a film, with the furnace as its scene.
pub(crate) fn app_of(published: Published, options: ViewOptions) -> App {
    app_on(RenderLink::fixed(published), options)
}

/// The window on what a link renders, with the furnace as its scene.
pub(crate) fn app_on(link: RenderLink, options: ViewOptions) -> App {
    let mut app = App::new(link, options, || {});
    app.shell.gallery.keep_still();
    let description = builtin("furnace").expect("a built-in scene");
    let description = description.load().expect("a scene as it comes");
    app.take_scene("furnace".to_owned(), Arc::new(Scene::build(&description)));
    app
}

/// The same, by bidirectional path tracing, with what one iteration of it makes of cornell as
/// techniques.
pub(crate) fn app_with_techniques() -> App {
    let options = ViewOptions {
        size: Some((96, 96)),
        integrator: Some("bdpt".to_owned()),
        ..ViewOptions::default()
    };
    let published = Published {
        techniques: Some(Arc::new(techniques())),
        ..published()
    };
    app_of(published, options)
}

/// The same, by photon mapping, with what it makes of cornell as photons.
pub(crate) fn app_with_photons() -> App {
    let options = ViewOptions {
        size: Some((96, 96)),
        integrator: Some("pm".to_owned()),
        ..ViewOptions::default()
    };
    let nobody = CancelToken::default();
    let mut renderer = renderer_of_cornell("pm", 96);
    let map = renderer.photons(&nobody).expect("nobody cancels");
    let map = map.expect("pm has photons");
    let photons = renderer.draw_photons(&map, &nobody);
    let published = Published {
        photons: Some(Arc::new(photons.expect("nobody cancels"))),
        ..published()
    };
    app_of(published, options)
}

/// The window on a film, with what the camera of cornell sees first, and how many paths an
/// iteration sends there.
pub(crate) fn app_with_quantities() -> App {
    let options = ViewOptions {
        size: Some((96, 96)),
        ..ViewOptions::default()
    };
    let mut renderer = renderer_of_cornell("pt-mis", 96);
    let iteration = renderer.iterate(&CancelToken::default());
    assert!(iteration.is_ok(), "nobody cancels");
    let published = Published {
        features: Some(Arc::new(renderer.features())),
        samples: Some(Arc::new(renderer.samples().clone())),
        ..published()
    };
    app_of(published, options)
}

/// The window on a film, with a race as it stood at some time: curves that fall as they should, and
/// pictures that are noisy as they say.
pub(crate) fn app_with_race() -> App {
    let options = ViewOptions {
        size: Some((96, 96)),
        ..ViewOptions::default()
    };
    let published = published();
    let (width, height) = (published.film.width(), published.film.height());
    let pixels = published.film.total();
    let picture = |pixels: Vec<Rgb>| {
        Arc::new(Image {
            width,
            height,
            pixels,
            ..Image::default()
        })
    };
    let reference = picture(pixels.clone());
    let methods = [("pt-bsdf", 0.4), ("pt-nee", 0.1), ("pt-mis", 0.03)];
    let standings = methods.map(|(name, error): (&str, f64)| {
        let points = (0..9).map(|i| {
            let seconds = 0.05 * 2f64.powi(i) * (1.0 + 0.04 * error);
            let rel_mse = error / (10.0 * seconds);
            let mut comparison = compare(&reference, &reference, &Default::default())
                .expect("a picture has its own size");
            (comparison.rel_mse, comparison.flip) = (rel_mse, 0.5 * rel_mse.sqrt());
            Point {
                seconds,
                n_iterations: 4 << i,
                comparison,
            }
        });
        let points: Vec<Point> = points.collect();
        let noisy = pixels.iter().enumerate().map(|(i, value)| {
            let noise = ((i * 7919) % 101) as f32 / 50.5 - 1.0;
            let noise = 1.0 + noise * error.sqrt() as f32;
            Rgb::new(value.r * noise, value.g * noise, value.b * noise)
        });
        Standing {
            name: name.to_owned(),
            seconds: points.last().map_or(0.0, |point| point.seconds),
            image: Some(picture(noisy.collect())),
            curve: Arc::new(points),
        }
    });
    let mut app = app_of(published, options);
    let view = app.viewing.views.get_mut::<RaceView>();
    view.expect("a row of VIEWS").report = Report {
        standings: standings.into(),
        reference: Some(reference),
        reference_words: "bdpt, 512 iterations, 25 s, 128 of them from the cache".to_owned(),
    };
    app
}

fn techniques() -> TechniqueFilm {
    let mut renderer = renderer_of_cornell("bdpt", 32);
    renderer.record_techniques(Some(1));
    renderer
        .iterate(&CancelToken::default())
        .expect("nobody cancels");
    renderer.techniques().expect("they are recorded").clone()
}

fn renderer_of_cornell(id: &str, side: usize) -> Renderer {
    let description = builtin("cornell").expect("a built-in scene");
    let description = description.load().expect("a scene as it comes");
    let scene = Arc::new(Scene::build(&description));
    let method = method(id).expect("a method");
    let settings = RenderSettings {
        method,
        values: ParameterValues::defaults(method.parameters),
        n_layers: 4,
        ..RenderSettings::new(scene.cameras()[0].clone(), side, side)
    };
    let pool = WorkerPool::new(Some(1), || {}).expect("a thread");
    Renderer::new(scene, settings, pool, 0)
}
