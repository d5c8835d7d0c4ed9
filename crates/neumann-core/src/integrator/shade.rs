//! Local shading as a rasteriser has it: `L_e + T L_e` without asking who sees whom.
//!
//! Lights are aimed at as if nothing were in the way. Held against the true `T L_e` it
//! shows what shadows are worth; held against L, what all further bounces are.

use super::path_tracing::{add_unlit, connect, hit};
use super::{
    Integrator, Method, Parameter, ParameterKind, ParameterValues, PathIntegrator, PathStart, Sight,
};
use crate::endpoint::LightChoice;
use crate::pass::PixelSink;
use crate::transport::Tracer;
use crate::transport::reflection::{aim_unshadowed, light_sample};

/// The row of the registry.
pub(super) static METHOD: Method = Method {
    id: "shade",
    title: "shade",
    name: "Local shading",
    about: "What a rasteriser computes: emission and one reflection of every light, without \
            shadows.",
    blind_spots: "Everything in between: shadows, mirrors and glass, and all light scattered \
                  more than once.",
    formula: "L ≈ L_e + Σ f G L_e / n p,  without V",
    pseudo_code: include_str!("pseudo_code/shade.txt"),
    sight: Sight {
        delta_surfaces: false,
        diffuse_bounces: Some(1),
        shadows: false,
        ..Sight::FULL
    },
    bias: Some("lights shine through everything"),
    has_techniques: false,
    has_photons: false,
    parameters: &[Parameter {
        name: "light-samples",
        title: "Light samples",
        unit: "",
        about: "Points on lights aimed at from each surface point.",
        kind: ParameterKind::Integer {
            default: 4,
            min: 1,
            max: 64,
        },
    }],
    build: |values: &ParameterValues| {
        Integrator::Pixels(Box::new(Shade {
            n_light_samples: values.integer("light-samples").max(1) as u32,
        }))
    },
};

struct Shade {
    n_light_samples: u32,
}

impl PathIntegrator for Shade {
    fn trace_path(&self, path: &PathStart<'_>, tracer: &mut Tracer<'_>, sink: &mut PixelSink<'_>) {
        let n = self.n_light_samples;
        let ray = path.ray;
        tracer.begin_at_camera(&ray);
        let Some(vertex) = tracer.vertex(&ray) else {
            let radiance = tracer.scene.lights().environment_radiance(ray.direction());
            sink.add(hit(0, radiance, 1.0));
            return;
        };
        add_unlit(tracer, &vertex, sink);
        sink.add(hit(0, tracer.emitted(&vertex), 1.0));
        if path.max_bounces == 0 || !vertex.bsdf.has_density() {
            return;
        }
        for i in 0..n {
            let u = light_sample(&path.sampler.bounce(i));
            if let Some((aimed, _)) = aim_unshadowed(tracer, &vertex, LightChoice::Tree, &u) {
                sink.add(connect(1, aimed.value, 1.0 / n as f32));
            }
        }
    }
}
