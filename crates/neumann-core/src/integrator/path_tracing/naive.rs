//! The naive path tracer of the lecture slide, line for line:
//!
//! ```text
//! L(x, wo):  return L_e(x, wo) + R(x, wo)
//! R(x, wo):  draw wi uniformly from the hemisphere, p = 1 / 2π
//!            return f(wo, wi) · cos_i · L(y, -wi) / p,   y = what wi meets
//! ```
//!
//! The recursion is a loop here, so that each turn is one application of T. No
//! direction is preferred, no light is aimed at, no path ends before the cut.
//! Where light can pass through a surface, directions are drawn from the whole sphere.

use crate::integrator::{Integrator, Method, ParameterValues, PathIntegrator, PathStart, Sight};
use crate::math::Frame;
use crate::pass::PixelSink;
use crate::radiometry::Rgb;
use crate::sampling::warp;
use crate::transport::Tracer;
use crate::transport::VertexSample;

use super::bsdf::MODE;
use super::{add_unlit, hit};

/// The row of the registry.
pub static METHOD: Method = Method {
    id: "naive",
    title: "naive",
    name: "Naive path tracing",
    about: "The recursion of the rendering equation as on the slide: a uniform direction at \
            every hit, \
            and light only where a path happens to run into it.",
    blind_spots: "Lights without extent, and mirrors and smooth glass: a uniform direction never \
                  finds them.",
    formula: "L ≈ L_e + f cos θ L / p,  p = 1 / 2π",
    pseudo_code: include_str!("../pseudo_code/naive.txt"),
    sight: Sight {
        punctual_lights: false,
        delta_surfaces: false,
        ..Sight::FULL
    },
    bias: None,
    has_techniques: false,
    has_photons: false,
    parameters: &[],
    build: |_: &ParameterValues| Integrator::Pixels(Box::new(Naive)),
};

struct Naive;

impl PathIntegrator for Naive {
    fn trace_path(&self, path: &PathStart<'_>, tracer: &mut Tracer<'_>, sink: &mut PixelSink<'_>) {
        let mut ray = path.ray;
        let mut throughput = Rgb::WHITE;
        let mut media = tracer.begin_at_camera(&ray);
        for bounce in 0..=path.max_bounces {
            // L_e of what the ray meets, or of the environment, after `bounce` applications of T.
            let met = tracer.meet(&ray, &mut media, &mut throughput);
            let emitted = tracer.emitted_along(&ray, met.as_ref());
            sink.add(hit(bounce, throughput * emitted, 1.0));
            let Some(vertex) = met else {
                return;
            };
            if bounce == 0 {
                add_unlit(tracer, &vertex, sink);
            }

            // Draw a direction uniformly.
            let u = path.sampler.bounce(bounce).direction;
            let (local, pdf_w) = if vertex.bsdf.is_transmissive() {
                (warp::uniform_sphere(u), warp::UNIFORM_SPHERE_PDF_W)
            } else {
                (warp::uniform_hemisphere(u), warp::UNIFORM_HEMISPHERE_PDF_W)
            };
            let side = 1f32.copysign(vertex.point.ng.dot(vertex.wo));
            let wi = Frame::from_z(vertex.point.ng).world_from_local(local) * side;

            // f · cos / p, and on to the next vertex.
            let sample = VertexSample::new(wi, vertex.f_cos(wi, MODE), pdf_w);
            throughput *= sample.throughput();
            tracer.leaves(&vertex, &sample, MODE, 1.0);
            if throughput.is_black() {
                return;
            }
            media = vertex.media_towards(wi, media);
            ray = vertex.ray(wi);
        }
    }
}
