//! Path tracing that draws directions from the BSDF.
//!
//! The naive path tracer plus one idea, importance sampling: `p` is (nearly)
//! proportional to `f · cos_i`, so that `f cos / p` varies little, and mirrors and
//! glass, whose `f` is a delta, can be followed at all.

use crate::bsdf::TransportMode;
use crate::integrator::{Integrator, Method, ParameterValues, PathIntegrator, PathStart, Sight};
use crate::pass::PixelSink;
use crate::radiometry::Rgb;
use crate::transport::Tracer;

use super::{add_unlit, hit};

/// The row of the registry.
pub static METHOD: Method = Method {
    id: "pt-bsdf",
    title: "PT bsdf",
    name: "Path tracing, BSDF sampling",
    about: "Directions are drawn where the surface scatters most. Light still counts only where \
            a path runs into it.",
    blind_spots: "Lights without extent: no path runs into them by chance.",
    formula: "L ≈ L_e + f cos θ L / p,  p ~ f cos θ",
    pseudo_code: include_str!("../pseudo_code/pt-bsdf.txt"),
    sight: Sight {
        punctual_lights: false,
        ..Sight::FULL
    },
    bias: None,
    has_techniques: false,
    has_photons: false,
    parameters: &[],
    build: |_: &ParameterValues| Integrator::Pixels(Box::new(BsdfSampling)),
};

struct BsdfSampling;

impl PathIntegrator for BsdfSampling {
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

            // Draw a direction from the BSDF, and on to the next vertex.
            let u = path.sampler.bounce(bounce);
            let Some(sample) = vertex.sample(u.bsdf(), MODE) else {
                return;
            };
            throughput *= sample.throughput();
            tracer.leaves(&vertex, &sample, MODE, 1.0);
            media = vertex.media_towards(sample.wi, media);
            ray = vertex.ray(sample.wi);
        }
    }
}

pub(in crate::integrator) const MODE: TransportMode = TransportMode::Radiance;
