//! The reflection integral at one vertex, light by light:
//! `T L_e (x, wo) = ∫ f(wo, wi) L_e(wi) cos_i dω`.
//!
//! It can be estimated from the BSDF (draw `wi`, see what emits there), from the lights
//! (choose one, aim at it), or from both, weighed so that the better one counts
//! ([Veach 1997] ch. 9). The integrators take from here what they need.

use super::{Medium, SurfaceVertex, Tracer};
use crate::bsdf::TransportMode;
use crate::endpoint::light::LightSample;
use crate::radiometry::Rgb;
use crate::sampling::Sampler;
use crate::sampling::mis::power_heuristic;

/// Light aimed at from a vertex, before anything is known of what is in between.
#[derive(Clone, Copy, Debug)]
pub struct Aimed {
    /// `f · cos · L_e / pdf`, 0 if the vertex does not scatter that way.
    pub value: Rgb,
    /// Density of the direction by the choice of lights, 1/sr.
    pub pdf_w_light: f32,
    /// Density of the direction by the BSDF, 1/sr; 0 for lights that it cannot find.
    pub pdf_w_bsdf: f32,
}

/// Random numbers for aiming at a light.
#[inline]
pub fn light_sample(sampler: &mut Sampler) -> LightSample {
    LightSample {
        choice: sampler.next_2d(),
        point: sampler.next_2d(),
        direction: [0.0; 2],
    }
}

/// Random numbers for starting a ray at a light.
#[inline]
pub fn start_sample(sampler: &mut Sampler) -> LightSample {
    LightSample {
        direction: sampler.next_2d(),
        ..light_sample(sampler)
    }
}

/// Aims at one light and looks whether it is seen; `None` if no light comes this way.
#[inline]
pub fn aim_at_light(
    tracer: &mut Tracer<'_>,
    vertex: &SurfaceVertex<'_>,
    medium: Medium,
    u: &LightSample,
) -> Option<Aimed> {
    aim_unshadowed(tracer, vertex, u).and_then(|(aimed, aim)| {
        let share = tracer.visibility(&vertex.point, &aim);
        if share <= 0.0 {
            return None;
        }
        let through = medium.beyond(vertex, aim.wi);
        Some(Aimed {
            value: aimed.value * through.transmittance(aim.distance) * share,
            ..aimed
        })
    })
}

/// Aims at one light as if nothing were in the way.
#[inline]
pub fn aim_unshadowed(
    tracer: &Tracer<'_>,
    vertex: &SurfaceVertex<'_>,
    u: &LightSample,
) -> Option<(Aimed, crate::endpoint::Aim)> {
    let aim = tracer.scene.lights().aim(vertex.point.position, u)?;
    let (f_cos, pdf_w) = vertex.f_cos_and_pdf_w(aim.wi, TransportMode::Radiance)?;
    let pdf_w_bsdf = if aim.is_delta { 0.0 } else { pdf_w };
    let aimed = Aimed {
        value: f_cos * aim.value / aim.pdf_w,
        pdf_w_light: aim.pdf_w,
        pdf_w_bsdf,
    };
    Some((aimed, aim))
}

/// Density, 1/sr, with which a light would have been aimed at where a BSDF sample found it: the emitter at
/// `vertex`, seen from the vertex before.
#[inline]
#[must_use]
pub fn pdf_w_of_emitter(tracer: &Tracer<'_>, vertex: &SurfaceVertex<'_>) -> f32 {
    let lights = tracer.scene.lights();
    match lights.of_triangle(vertex.triangle) {
        Some((index, light)) => {
            let pdf_a = lights.pmf(index) * light.pdf_a(vertex.barycentrics);
            let cos = vertex.cos_g(vertex.wo);
            if cos > 0.0 {
                pdf_a * vertex.distance * vertex.distance / cos
            } else {
                0.0
            }
        }
        None => 0.0,
    }
}

impl Aimed {
    /// MIS weight against the BSDF sample of the same vertex.
    #[inline]
    #[must_use]
    pub fn mis_weight(&self) -> f32 {
        power_heuristic(self.pdf_w_light, self.pdf_w_bsdf)
    }
}
