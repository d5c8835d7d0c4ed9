//! The reflection integral at one vertex, light by light:
//! `T L_e (x, wo) = ∫ f(wo, wi) L_e(wi) cos_i dω`.
//!
//! It can be estimated from the BSDF (draw `wi`, see what emits there), from the lights
//! (choose one, aim at it), or from both, weighed so that the better one counts
//! ([Veach 1997] ch. 9). The integrators take from here what they need.

use glam::Vec3;

use super::{SurfaceVertex, Tracer, VertexKind, VertexSample};
use crate::bsdf::TransportMode;
use crate::endpoint::light::LightSample;
use crate::endpoint::{Aim, LightChoice, Receiver};
use crate::math::lanes::side_by_side;
use crate::radiometry::Rgb;
use crate::radiometry::measure::pdf_w_from_pdf_a;
use crate::sampling::mis::power_heuristic;
use crate::sampling::{BounceNumbers, StartNumbers};
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

/// The numbers with which a vertex aims at a light.
#[inline(always)]
#[must_use]
pub fn light_sample(u: &BounceNumbers) -> LightSample {
    LightSample {
        choice: u.light,
        point: u.point_on_light,
        direction: [0.0; 2],
    }
}

/// The numbers with which a light starts a path.
#[inline(always)]
#[must_use]
pub fn start_sample(u: &StartNumbers) -> LightSample {
    LightSample {
        choice: u.light,
        point: u.position,
        direction: u.direction,
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
    tracer.note_aim(vertex.point.position, &aim, VertexKind::Light);
    Some((Aimed::at(vertex, &aim)?, aim))
}

/// Where a direction was drawn, if a light could have been aimed at from there as well.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// The vertex.
    from: Receiver,
    /// Density of the direction, 1/sr; 0 where no light could have been aimed at along it.
    pdf_w: f32,
}

side_by_side! {
    /// Where the directions of all lanes were drawn.
    pub(crate) struct DrawnLanes of Drawn { from: Receiver, pdf_w: f32 }
}

impl Drawn {
    /// Where no light could have been aimed at: at the camera, or at a mirror.
    pub const NOWHERE: Self = Self {
        from: Receiver::NOWHERE,
        pdf_w: 0.0,
    };

    /// A sample of a vertex.
    #[inline(always)]
    #[must_use]
    pub fn at(vertex: &SurfaceVertex<'_>, sample: &VertexSample) -> Self {
        Self {
            from: vertex.receiver(),
            pdf_w: if sample.is_delta { 0.0 } else { sample.pdf_w },
        }
    }

    /// MIS weight of the emitter that the ray has run into, against having been aimed at by such a
    /// choice of lights.
    #[inline]
    #[must_use]
    pub fn mis_weight(
        &self,
        tracer: &Tracer<'_>,
        choice: LightChoice,
        emitter: &SurfaceVertex<'_>,
    ) -> f32 {
        if self.pdf_w <= 0.0 {
            return 1.0;
        }
        let pdf_w_light = pdf_w_of_emitter(tracer, &self.from, choice, emitter);
        power_heuristic(self.pdf_w * emitter.opacity, pdf_w_light)
    }

    /// MIS weight of the environment where the ray has left the scene along `direction`, against
    /// having been aimed at by such a choice of lights.
    #[inline]
    #[must_use]
    pub fn mis_weight_of_environment(
        &self,
        tracer: &Tracer<'_>,
        choice: LightChoice,
        direction: Vec3,
    ) -> f32 {
        if self.pdf_w <= 0.0 {
            return 1.0;
        }
        let lights = tracer.scene.lights();
        let (pdf_w_light, _) = lights.environment_densities(&self.from, choice, direction);
        power_heuristic(self.pdf_w, pdf_w_light)
    }
}

/// Density, 1/sr, with which a light would have been aimed at where a BSDF sample found it: the
/// emitter, seen from the vertex before.
#[inline]
fn pdf_w_of_emitter(
    tracer: &Tracer<'_>,
    from: &Receiver,
    choice: LightChoice,
    emitter: &SurfaceVertex<'_>,
) -> f32 {
    let lights = tracer.scene.lights();
    let Some((index, light)) = lights.of_triangle(emitter.triangle) else {
        return 0.0;
    };
    let cos = emitter.cos_g(emitter.wo);
    if cos <= 0.0 {
        return 0.0;
    }
    let pdf_a = light.pdf_a(emitter.barycentrics);
    let distance_squared = emitter.distance * emitter.distance;
    lights.pmf_aim(from, choice, index) * pdf_w_from_pdf_a(pdf_a, cos, distance_squared)
}

/// Density, 1/sr, with which such a choice of lights aims along a ray from a vertex, whatever is in
/// between: that of all emitters along it together.
#[must_use]
pub fn pdf_w_of_aim(
    tracer: &mut Tracer<'_>,
    vertex: &SurfaceVertex<'_>,
    choice: LightChoice,
    wi: Vec3,
) -> f32 {
    let from = vertex.receiver();
    let ray = vertex.ray(wi);
    let lights = tracer.scene.lights();
    let (mut pdf_w, _) = lights.environment_densities(&from, choice, wi);
    for hit in tracer.crossings(&ray) {
        let emitter = tracer.surface_vertex(&ray, &hit);
        if !tracer.emitted(&emitter).is_black() {
            pdf_w += pdf_w_of_emitter(tracer, &from, choice, &emitter);
        }
    }
    pdf_w
}

impl Aimed {
    /// At nothing.
    pub(crate) const NOWHERE: Self = Self {
        wi: Vec3::ZERO,
        value: Rgb::BLACK,
        pdf_w_light: 1.0,
        pdf_w_bsdf: 0.0,
        opacity: 1.0,
    };

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
