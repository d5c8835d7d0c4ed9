//! A window without a renderer: a small film that never changes.

use std::sync::Arc;

use neumann_core::film::Film;
use neumann_core::radiometry::Rgb;
use neumann_core::render::{Published, Stats, Thumbnail};
use neumann_core::scene::Scene;
use neumann_core::scene::builtin::builtin;
use neumann_viewer::ViewOptions;
use neumann_viewer::app::App;
use neumann_viewer::render_link::RenderLink;

/// A film whose layer k is a gradient of strength 2^-k.
pub(crate) fn published() -> Published {
    let (width, height, n_layers) = (96, 96, 8);
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
            estimated_error: 0.01,
            n_refused: 0,
            is_done: false,
        },
        energy_shares: film.energy_shares(),
        film,
        thumbnails,
        thumbnails_version: 1,
    }
}

/// The window on that film, with the furnace as its scene.
pub(crate) fn app() -> App {
    let options = ViewOptions {
        size: Some((96, 96)),
        ..ViewOptions::default()
    };
    let mut app = App::new(RenderLink::fixed(published()), options, || {});
    app.gallery.keep_still();
    let description = builtin("furnace").expect("a built-in scene");
    let description = description.load().expect("a scene as it comes");
    app.take_scene("furnace".to_owned(), Arc::new(Scene::build(&description)));
    app
}
