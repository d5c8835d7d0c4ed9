//! Distributed ray tracing (Cook, Porter and Carpenter 1984).
//!
//! Whitted's recursion with every integral spread over rays: points on the lens, points
//! on the lights, directions within a glossy lobe. Light is only ever aimed at from
//! a surface, or found by way of mirror-like and glossy reflection and transmission;
//! diffuse surfaces hand nothing on to each other.

use super::path_tracing::{add_unlit, connect, hit};
use super::{
    Integrator, Method, Parameter, ParameterKind, ParameterValues, PathIntegrator, PathStart, Sight,
};
use crate::bsdf::TransportMode;
use crate::endpoint::LightChoice;
use crate::math::Ray;
use crate::pass::PixelSink;
use crate::radiometry::Rgb;
use crate::sampling::Sampler;
use crate::scene::bodies::Media;
use crate::transport::Tracer;
use crate::transport::reflection::{aim_at_light, light_sample};

/// The row of the registry.
pub(super) static METHOD: Method = Method {
    id: "drt",
    title: "distributed",
    name: "Distributed ray tracing",
    about: "Cook's rays spread over lens, lights and glossy lobes: soft shadows, blurred \
            reflections, depth of field.",
    blind_spots: "Light that two diffuse surfaces hand on to each other: no colour bleeding, no \
                  caustics.",
    formula: "L ≈ L_e + Σ f G V L_e / n p + Σ f_glossy cos θ L / m p",
    pseudo_code: include_str!("pseudo_code/drt.txt"),
    sight: Sight {
        diffuse_bounces: Some(1),
        ..Sight::FULL
    },
    bias: Some("no interreflection between diffuse surfaces"),
    has_techniques: false,
    has_photons: false,
    parameters: &[
        Parameter {
            name: "lens-samples",
            title: "Lens samples",
            unit: "",
            about: "Camera rays through each pixel.",
            kind: ParameterKind::Integer {
                default: 1,
                min: 1,
                max: 64,
            },
        },
        Parameter {
            name: "light-samples",
            title: "Light samples",
            unit: "",
            about: "Points on lights aimed at from the surface seen first.",
            kind: ParameterKind::Integer {
                default: 4,
                min: 1,
                max: 64,
            },
        },
        Parameter {
            name: "glossy-samples",
            title: "Glossy samples",
            unit: "",
            about: "Reflected or transmitted rays from the surface seen first; deeper ones send \
                    one.",
            kind: ParameterKind::Integer {
                default: 4,
                min: 1,
                max: 64,
            },
        },
    ],
    build: |values: &ParameterValues| {
        let count = |name| values.integer(name).max(1) as u32;
        Integrator::Pixels(Box::new(Distributed {
            n_lens: count("lens-samples"),
            n_light: count("light-samples"),
            n_glossy: count("glossy-samples"),
        }))
    },
};

#[derive(Clone, Copy)]
struct Distributed {
    n_lens: u32,
    n_light: u32,
    n_glossy: u32,
}

/// One ray of the tree, on its way.
#[derive(Clone, Copy)]
struct Branch {
    ray: Ray,
    throughput: Rgb,
    media: Media,
    bounce: u32,
    /// True if the vertex before could not have aimed along it.
    is_specular: bool,
}

/// The random numbers of a tree of rays: its scattering events in the order in which they are met,
/// several numbers for one where it sends several rays.
struct EventNumbers<'a> {
    sampler: &'a Sampler<'a>,
    n: u32,
}

impl EventNumbers<'_> {
    /// The first of the next `n` numbers of events.
    fn next(&mut self, n: u32) -> u32 {
        let first = self.n;
        self.n += n;
        first
    }
}

impl PathIntegrator for Distributed {
    fn trace_path(&self, path: &PathStart<'_>, tracer: &mut Tracer<'_>, sink: &mut PixelSink<'_>) {
        let mut events = EventNumbers {
            sampler: path.sampler,
            n: 0,
        };
        for i in 0..self.n_lens {
            // The position in the pixel is drawn once, the lens anew for each ray.
            let ray = match i {
                0 => path.ray,
                _ => path.ray_through(path.sampler.bounce(events.next(1)).lens),
            };
            let branch = Branch {
                ray,
                throughput: Rgb::splat(1.0 / self.n_lens as f32),
                media: tracer.begin_at_camera(&ray),
                bounce: 0,
                is_specular: true,
            };
            tracer.splits(self.n_lens);
            self.follow(branch, path.max_bounces, tracer, &mut events, sink);
        }
    }
}

impl Distributed {
    fn follow(
        self,
        branch: Branch,
        max_bounces: u32,
        tracer: &mut Tracer<'_>,
        events: &mut EventNumbers<'_>,
        sink: &mut PixelSink<'_>,
    ) {
        let Branch {
            ray,
            mut throughput,
            mut media,
            bounce,
            is_specular,
        } = branch;
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

        // Emission counts where the vertex before could not aim at it.
        if is_specular {
            sink.add(hit(bounce, throughput * tracer.emitted(&vertex), 1.0));
        }
        if bounce == max_bounces {
            return;
        }
        let [n_light, n_glossy] = if bounce == 0 {
            [self.n_light, self.n_glossy]
        } else {
            [1, 1]
        };
        let event = events.next(n_light.max(n_glossy));

        // Soft shadows: points on the lights.
        if vertex.bsdf.has_density() {
            for i in 0..n_light {
                let u = light_sample(&events.sampler.bounce(event + i));
                if let Some(aimed) = aim_at_light(tracer, &vertex, media, LightChoice::Tree, &u) {
                    let value = throughput * aimed.value;
                    sink.add(connect(bounce + 1, value, 1.0 / n_light as f32));
                }
            }
        }

        // Blurred reflection and transmission: directions within the glossy lobes.
        let Some(glossy) = vertex.bsdf.glossy_part() else {
            return;
        };
        tracer.splits(n_glossy);
        for i in 0..n_glossy {
            let u = events.sampler.bounce(event + i).bsdf();
            let Some(sample) = vertex.sample_of(&glossy, u, TransportMode::Radiance) else {
                continue;
            };
            tracer.leaves(&vertex, &sample, TransportMode::Radiance, 1.0);
            let next = Branch {
                ray: vertex.ray(sample.wi),
                throughput: throughput * sample.throughput() / n_glossy as f32,
                media: vertex.media_towards(sample.wi, media),
                bounce: bounce + 1,
                is_specular: sample.is_delta,
            };
            self.follow(next, max_bounces, tracer, events, sink);
        }
    }
}
