//! Renders a scene and prints the mean of each term of the series.
//!
//! `cargo run --release -p neumann-core --example render -- [SCENE] [METHOD] [ITERATIONS]`

#![allow(clippy::print_stdout, reason = "an example shows its result")]

use std::error::Error;
use std::sync::Arc;

use neumann_core::film::{Film, View};
use neumann_core::integrator::{ParameterValues, method};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{CancelToken, RenderSettings, Renderer, WorkerPool};
use neumann_core::scene::load::LoadOptions;
use neumann_core::scene::{Scene, open};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "cornell".to_owned());
    let id = arguments.next().unwrap_or_else(|| "pt-mis".to_owned());
    let n_iterations: u32 = arguments.next().map_or(Ok(16), |n| n.parse())?;

    // A built-in scene by name, or the path of a .gltf or .glb file.
    let description = open(&name, &LoadOptions::default())?;
    let scene = Arc::new(Scene::build(&description));
    let mut settings = RenderSettings::new(scene.cameras()[0].clone(), 128, 128);
    settings.method = method(&id).ok_or_else(|| format!("no method is called '{id}'"))?;
    settings.values = ParameterValues::defaults(settings.method.parameters);

    let mut film = Film::new(settings.width, settings.height, settings.n_layers);
    let n_layers = settings.n_layers;
    let pool = WorkerPool::new(None, || ())?;
    let mut renderer = Renderer::new(scene, settings, pool, 0);
    for _ in 0..n_iterations {
        let iteration = renderer.iterate_after(&film, &CancelToken::default())?;
        iteration.add_to(&mut film);
    }

    let n_pixels = film.total().len();
    for k in 0..n_layers {
        let pixels = (0..n_pixels).map(|pixel| film.radiance(View::Term(k), pixel));
        let mean = pixels.fold(Rgb::BLACK, |sum, value| sum + value) / n_pixels as f32;
        println!("T{k}  {:.6} {:.6} {:.6}", mean.r, mean.g, mean.b);
    }
    Ok(())
}
