//! Path tracing with multiple importance sampling.
//!
//! The last one plus one idea: light is both aimed at and run into, and each way
//! is weighed by how well it samples the direction, `w_i = p_i² / (p_1² + p_2²)`
//! ([Veach 1997] 9.2.3.2). A sky of one radiance is not aimed at: the BSDF samples it
//! as it counts. Long paths end by Russian roulette on their throughput.

use crate::endpoint::LightChoice;
use crate::integrator::{Integrator, Method, Parameter, ParameterKind, ParameterValues, Sight};
use crate::radiometry::Rgb;
use crate::render::{Cancelled, Pass};
use crate::sampling::roulette;
use crate::scene::Scene;
use crate::transport::Medium;
use crate::transport::reflection::{Drawn, aim_at_light, light_sample};

use super::adaptive::{ADAPTIVE, Adaptive};
use super::bsdf::{MODE, bsdf_numbers};
use super::nee::{LIGHTS, light_choice};
use super::{add_unlit, connect, hit};

/// The row of the registry.
pub static METHOD: Method = Method {
    id: "pt-mis",
    title: "PT mis",
    name: "Path tracing, multiple importance sampling",
    about: "Lights are aimed at and run into, each way weighed by how well it samples the direction: \
            small lights and sharp reflections both come out clean.",
    blind_spots: "Lights without extent by way of a mirror or smooth glass: neither can be aimed at the other.",
    sight: Sight::FULL,
    bias: None,
    has_techniques: false,
    parameters: &[
        Parameter {
            name: "roulette",
            title: "Russian roulette",
            unit: "",
            about: "End long paths by chance, in proportion to what they could still carry.",
            kind: ParameterKind::Switch { default: true },
        },
        LIGHTS,
        ADAPTIVE,
    ],
    build: |values: &ParameterValues| {
        let mis = Mis {
            choice: match light_choice(values) {
                LightChoice::Tree => LightChoice::TreeBesideBsdf,
                choice => choice,
            },
            has_roulette: values.switch("roulette"),
        };
        if values.switch(ADAPTIVE.name) {
            Box::new(Adaptive::new(mis))
        } else {
            Box::new(mis)
        }
    },
};

struct Mis {
    choice: LightChoice,
    has_roulette: bool,
}

impl Integrator for Mis {
    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled> {
        let max_bounces = pass.max_bounces();
        let camera = pass.camera();
        let (choice, has_roulette) = (self.choice, self.has_roulette);
        pass.trace_pixels(scene, |raster, tracer, sampler, sink| {
            let mut ray = camera.ray(raster, sampler.next_2d()).ray;
            let mut throughput = Rgb::WHITE;
            let mut medium = Medium::VACUUM;
            // Scattering events so far, those at delta lobes aside.
            let mut n_events = 0;
            // Where the ray's direction was drawn; nothing where it could not have been aimed.
            let mut drawn: Option<Drawn> = None;
            for bounce in 0..=max_bounces {
                // What does the ray meet? Nothing: the environment emits.
                let Some(found) = tracer.hit(&ray) else {
                    let radiance = scene.lights().environment_radiance(ray.direction());
                    if !radiance.is_black() {
                        let weight = drawn.map_or(1.0, |d| {
                            d.mis_weight_of_environment(tracer, ray.direction())
                        });
                        sink.add(hit(bounce, throughput * radiance, weight));
                    }
                    return;
                };
                let vertex = tracer.surface_vertex(-ray.direction(), &found);
                throughput *= medium.transmittance(vertex.distance);
                if bounce == 0 {
                    add_unlit(tracer, &vertex, sink);
                }

                // L_e that was run into, against having been aimed at.
                let emitted = tracer.emitted(&vertex);
                if !emitted.is_black() {
                    let weight = drawn.map_or(1.0, |d| d.mis_weight(tracer, &vertex));
                    sink.add(hit(bounce, throughput * emitted, weight));
                }
                if bounce == max_bounces {
                    return;
                }

                // Draw a direction from the BSDF.
                let sample = vertex.sample(bsdf_numbers(sampler, bounce), MODE);

                // The next event, aimed at, against running into it.
                if vertex.bsdf.has_density() {
                    let u = light_sample(sampler);
                    if let Some(aimed) = aim_at_light(tracer, &vertex, medium, choice, &u) {
                        let value = throughput * aimed.value;
                        sink.add(connect(bounce + 1, value, aimed.mis_weight()));
                    }
                }

                // On to the next vertex.
                let Some(sample) = sample else {
                    return;
                };
                throughput *= sample.throughput();
                drawn = Drawn::at(&vertex, choice, &sample);

                // Paths that carry little end by chance.
                if !sample.is_delta {
                    if has_roulette {
                        let Some(factor) = roulette::play(n_events, throughput, sampler) else {
                            return;
                        };
                        throughput *= factor;
                    }
                    n_events += 1;
                }
                medium = medium.beyond(&vertex, sample.wi);
                ray = vertex.ray(sample.wi);
            }
        })
    }
}
