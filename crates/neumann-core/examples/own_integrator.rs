//! A method of one's own, rendered like those that come with the program: ambient occlusion, the
//! share of the hemisphere from which a surface sees nothing within a metre.
//!
//! `cargo run --release -p neumann-core --example own_integrator -- [SCENE]`

#![allow(clippy::print_stdout, reason = "an example shows its result")]

use std::error::Error;
use std::sync::Arc;

use neumann_core::film::{Contribution, Film, Strategy};
use neumann_core::integrator::{
    Integrator, Method, ParameterValues, PathIntegrator, PathStart, Sight,
};
use neumann_core::math::Frame;
use neumann_core::pass::PixelSink;
use neumann_core::radiometry::Rgb;
use neumann_core::render::{CancelToken, RenderSettings, Renderer, WorkerPool};
use neumann_core::sampling::warp;
use neumann_core::scene::load::LoadOptions;
use neumann_core::scene::{Scene, open};
use neumann_core::transport::Tracer;

/// Everything that menus and tests know of a method.
static OCCLUSION: Method = Method {
    id: "occlusion",
    title: "occlusion",
    name: "Ambient occlusion",
    about: "How much of the hemisphere above a surface is open.",
    blind_spots: "Light.",
    formula: "V / 1,  p = cos θ / π",
    pseudo_code: "ω = a direction in proportion to its cosine\nadd V along ω, up to 1 metre",
    sight: Sight::FULL,
    bias: Some("it is no solution of the rendering equation"),
    has_techniques: false,
    has_photons: false,
    parameters: &[],
    build: |_: &ParameterValues| Integrator::Pixels(Box::new(Occlusion)),
};

struct Occlusion;

impl PathIntegrator for Occlusion {
    fn trace_path(&self, path: &PathStart<'_>, tracer: &mut Tracer<'_>, sink: &mut PixelSink<'_>) {
        tracer.begin_at_camera(&path.ray);
        let Some(vertex) = tracer.vertex(&path.ray) else {
            return;
        };
        // A direction in proportion to its cosine, so that each counts alike.
        let local = warp::cosine_hemisphere(path.sampler.bounce(0).direction);
        let side = 1f32.copysign(vertex.point.ng.dot(vertex.wo));
        let wi = Frame::from_z(vertex.point.ng * side).world_from_local(local);
        let end = vertex.point.position + wi;
        let open = tracer.transmittance(&vertex.point.segment(end));
        sink.add(Contribution {
            value: Rgb::splat(open),
            mis_weight: 1.0,
            bounce: 1,
            strategy: Strategy::connect(1, 2),
        });
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "cornell".to_owned());
    let scene = Arc::new(Scene::build(&open(&name, &LoadOptions::default())?));
    let mut settings = RenderSettings::new(scene.cameras()[0].clone(), 48, 24);
    settings.method = &OCCLUSION;
    settings.values = ParameterValues::defaults(OCCLUSION.parameters);
    let mut film = Film::new(settings.width, settings.height, settings.n_layers);
    let mut renderer = Renderer::new(scene, settings, WorkerPool::new(None, || ())?, 0);
    for _ in 0..64 {
        film.add(renderer.iterate(&CancelToken::default())?);
    }
    for row in film.total().chunks(48) {
        let shade = |value: &Rgb| char::from(b" .:-=+*#%@"[(value.g * 9.0).round() as usize % 10]);
        println!("{}", row.iter().map(shade).collect::<String>());
    }
    Ok(())
}
