//! The reflection integral at one vertex, light by light:
//! `T L_e (x, wo) = ∫ f(wo, wi) L_e(wi) cos_i dω`.
//!
//! It can be estimated from the BSDF (draw `wi`, see what emits there), from the lights
//! (choose one, aim at it), or from both, weighed so that the better one counts
//! ([Veach 1997] ch. 9). The integrators take from here what they need.

use glam::Vec3;

use super::{SurfaceVertex, Tracer, VertexSample};
use crate::bsdf::TransportMode;
use crate::endpoint::light::LightSample;
use crate::endpoint::{Aim, LightChoice, Receiver};
use crate::radiometry::Rgb;
use crate::radiometry::measure::pdf_w_from_pdf_a;
use crate::sampling::Sampler;
use crate::sampling::mis::power_heuristic;
use crate::scene::bodies::Media;

/// Light aimed at from a vertex, before anything is known of what is in between.
#[derive(Clone, Copy, Debug)]
pub struct Aimed {
    /// Its direction.
    pub wi: Vec3,
    /// `f · cos · L_e / pdf`, 0 if the vertex does not scatter that way.
    pub value: Rgb,
    /// Density of the direction by the choice of lights, 1/sr.
    pub pdf_w_light: f32,
    /// Density of the direction by the BSDF, 1/sr; 0 for lights that it cannot find.
    pub pdf_w_bsdf: f32,
    /// Probability that a ray in that direction meets the light, if nothing is in the way.
    pub opacity: f32,
}

/// Random numbers for aiming at a light.
#[inline]
pub fn light_sample(sampler: &mut Sampler<'_>) -> LightSample {
    LightSample {
        choice: sampler.next_2d(),
        point: sampler.next_2d(),
        direction: [0.0; 2],
    }
}

/// Random numbers for starting a ray at a light.
#[inline]
pub fn start_sample(sampler: &mut Sampler<'_>) -> LightSample {
    LightSample {
        direction: sampler.next_2d(),
        ..light_sample(sampler)
    }
}

/// Aims at one light from a vertex reached through `media`, and looks whether it is seen; `None` if
/// no light comes this way.
#[inline(always)]
pub fn aim_at_light(
    tracer: &mut Tracer<'_>,
    vertex: &SurfaceVertex<'_>,
    media: Media,
    choice: LightChoice,
    u: &LightSample,
) -> Option<Aimed> {
    aim_unshadowed(tracer, vertex, choice, u).and_then(|(aimed, aim)| {
        let media = vertex.media_towards(aim.wi, media);
        let light = tracer.light_to(&vertex.point, &aim, media);
        (!light.is_black()).then(|| Aimed {
            value: aimed.value * light,
            ..aimed
        })
    })
}

/// Aims at one light as if nothing were in the way.
#[inline(always)]
pub fn aim_unshadowed(
    tracer: &Tracer<'_>,
    vertex: &SurfaceVertex<'_>,
    choice: LightChoice,
    u: &LightSample,
) -> Option<(Aimed, Aim)> {
    let aim = tracer.scene.lights().aim(&vertex.receiver(), choice, u)?;
    Some((Aimed::at(vertex, &aim)?, aim))
}

/// A direction drawn from the BSDF of a vertex from which a light could have been aimed at as well.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// The vertex.
    pub from: Receiver,
    /// What lights are chosen by there.
    pub choice: LightChoice,
    /// Density of the direction, 1/sr.
    pub pdf_w: f32,
}

impl Drawn {
    /// A sample of the vertex; `None` for a mirror-like direction, which no light could have been aimed along.
    #[inline]
    #[must_use]
    pub fn at(
        vertex: &SurfaceVertex<'_>,
        choice: LightChoice,
        sample: &VertexSample,
    ) -> Option<Self> {
        (!sample.is_delta).then(|| Self {
            from: vertex.receiver(),
            choice,
            pdf_w: sample.pdf_w,
        })
    }

    /// MIS weight of the emitter that the ray has run into, against having been aimed at.
    #[inline]
    #[must_use]
    pub fn mis_weight(&self, tracer: &Tracer<'_>, emitter: &SurfaceVertex<'_>) -> f32 {
        let pdf_w_light = pdf_w_of_emitter(tracer, self, emitter);
        power_heuristic(self.pdf_w * emitter.opacity, pdf_w_light)
    }

    /// MIS weight of the environment where the ray has left the scene along `direction`, against having been aimed at.
    #[inline]
    #[must_use]
    pub fn mis_weight_of_environment(&self, tracer: &Tracer<'_>, direction: Vec3) -> f32 {
        let lights = tracer.scene.lights();
        let (pdf_w_light, _) = lights.environment_densities(&self.from, self.choice, direction);
        power_heuristic(self.pdf_w, pdf_w_light)
    }
}

/// Density, 1/sr, with which a light would have been aimed at where a BSDF sample found it: the emitter, seen from
/// the vertex before.
#[inline]
fn pdf_w_of_emitter(tracer: &Tracer<'_>, drawn: &Drawn, emitter: &SurfaceVertex<'_>) -> f32 {
    let lights = tracer.scene.lights();
    match lights.of_triangle(emitter.triangle) {
        Some((index, light)) => {
            let pmf = lights.pmf_aim(&drawn.from, drawn.choice, index);
            let cos = emitter.cos_g(emitter.wo);
            if cos > 0.0 {
                pmf * pdf_w_from_pdf_a(
                    light.pdf_a(emitter.barycentrics),
                    cos,
                    emitter.distance * emitter.distance,
                )
            } else {
                0.0
            }
        }
        None => 0.0,
    }
}

impl Aimed {
    /// What a vertex scatters of the light that it aims at; `None` if nothing.
    #[inline(always)]
    #[must_use]
    pub fn at(vertex: &SurfaceVertex<'_>, aim: &Aim) -> Option<Self> {
        let (f_cos, pdf_w) = vertex.f_cos_and_pdf_w(aim.wi, TransportMode::Radiance)?;
        Some(Self {
            wi: aim.wi,
            value: f_cos * aim.value / aim.pdf_w,
            pdf_w_light: aim.pdf_w,
            pdf_w_bsdf: if aim.is_delta { 0.0 } else { pdf_w },
            opacity: aim.opacity,
        })
    }

    /// MIS weight against the BSDF sample of the same vertex.
    #[inline]
    #[must_use]
    pub fn mis_weight(&self) -> f32 {
        power_heuristic(self.pdf_w_light, self.pdf_w_bsdf * self.opacity)
    }
}
