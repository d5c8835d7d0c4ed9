//! Path tracing with next-event estimation.
//!
//! The last one plus one idea: the light of the next bounce is not waited for but
//! aimed at. At each vertex one light is chosen and a shadow ray sent to it. A path
//! that runs into a light counts it only where no light could have been aimed at it:
//! seen from the camera directly, or by way of a mirror-like direction.

use crate::endpoint::LightChoice;
use crate::integrator::{
    Integrator, Method, Parameter, ParameterKind, ParameterValues, PathIntegrator, PathStart, Sight,
};
use crate::pass::PixelSink;
use crate::radiometry::Rgb;
use crate::transport::Tracer;
use crate::transport::reflection::{aim_at_light, light_sample};

use super::bsdf::MODE;
use super::{add_unlit, connect, hit};

/// The row of the registry.
pub static METHOD: Method = Method {
    id: "pt-nee",
    title: "PT nee",
    name: "Path tracing, next-event estimation",
    about: "At every hit a light is aimed at. Paths no longer have to run into small lights by \
            chance.",
    blind_spots: "Lights without extent by way of a mirror or smooth glass: neither can be aimed \
                  at the other.",
    formula: "T L_e ≈ f G V L_e / p,  a point on a light",
    pseudo_code: include_str!("../pseudo_code/pt-nee.txt"),
    sight: Sight::FULL,
    bias: None,
    has_techniques: false,
    has_photons: false,
    parameters: &[LIGHTS],
    build: |values: &ParameterValues| {
        Integrator::Pixels(Box::new(NextEvent {
            choice: light_choice(values),
        }))
    },
};

/// What the light aimed at is chosen by.
pub(in crate::integrator) const LIGHTS: Parameter = Parameter {
    name: "lights",
    title: "Choose lights",
    unit: "",
    about: "The light to aim at is chosen by what it may send to the point, found in a tree, or \
            by its power alone.",
    kind: ParameterKind::Choice {
        default: 0,
        options: &["tree", "power"],
    },
};

pub(in crate::integrator) fn light_choice(values: &ParameterValues) -> LightChoice {
    match values.choice(LIGHTS.name) {
        1 => LightChoice::Power,
        _ => LightChoice::Tree,
    }
}

struct NextEvent {
    choice: LightChoice,
}

impl PathIntegrator for NextEvent {
    fn trace_path(&self, path: &PathStart<'_>, tracer: &mut Tracer<'_>, sink: &mut PixelSink<'_>) {
        let mut ray = path.ray;
        let mut throughput = Rgb::WHITE;
        let mut media = tracer.begin_at_camera(&ray);
        let mut is_specular = true;
        for bounce in 0..=path.max_bounces {
            // What does the ray meet? Nothing: the environment emits.
            let Some(vertex) = tracer.meet(&ray, &mut media, &mut throughput) else {
                if is_specular {
                    let radiance = tracer.scene.lights().environment_radiance(ray.direction());
                    sink.add(hit(bounce, throughput * radiance, 1.0));
                }
                return;
            };
            if bounce == 0 {
                add_unlit(tracer, &vertex, sink);
            }

            // L_e counts where the vertex before could not aim at it.
            if is_specular {
                sink.add(hit(bounce, throughput * tracer.emitted(&vertex), 1.0));
            }
            if bounce == path.max_bounces {
                return;
            }

            // The next event: light that scatters here, aimed at.
            let u = path.sampler.bounce(bounce);
            if vertex.bsdf.has_density() {
                let light = light_sample(&u);
                if let Some(aimed) = aim_at_light(tracer, &vertex, media, self.choice, &light) {
                    sink.add(connect(bounce + 1, throughput * aimed.value, 1.0));
                }
            }

            // Draw a direction from the BSDF, and on to the next vertex.
            let Some(sample) = vertex.sample(u.bsdf(), MODE) else {
                return;
            };
            throughput *= sample.throughput();
            tracer.leaves(&vertex, &sample, MODE, 1.0);
            is_specular = sample.is_delta;
            media = vertex.media_towards(sample.wi, media);
            ray = vertex.ray(sample.wi);
        }
    }
}
