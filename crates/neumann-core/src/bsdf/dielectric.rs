//! Glass: a dielectric interface, smooth or rough, of a solid or of a thin pane.
//!
//! Solid: Walter et al. 2007, "Microfacet Models for Refraction through Rough
//! Surfaces". Above the surface (z > 0) is outside. Thin: both faces at once; what
//! passes goes straight on, blurred like the reflection it mirrors, and light going
//! back and forth between the faces is summed.

use glam::Vec3;

use super::conductor::{sample_reflected, upper};
use super::fresnel::{self, Interface};
use super::microfacet::Ggx;
use super::{BsdfSample, Scatter, TransportMode, is_reflection};
use crate::radiometry::Rgb;

/// What is behind the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Walls {
    /// The inside of a body: light is refracted.
    Solid,
    /// A pane of no thickness: light passes straight.
    Thin,
}

/// A dielectric interface.
#[derive(Clone, Copy, Debug)]
pub struct Dielectric {
    /// Index of refraction of the inside, relative to the outside.
    pub ior: f32,
    /// Multiplies the light that passes, at each crossing.
    pub tint: Rgb,
    /// Multiplies the light that is reflected.
    pub reflection_tint: Rgb,
    /// Its facets.
    pub ggx: Ggx,
    /// What is behind it.
    pub walls: Walls,
}

impl Dielectric {
    /// True where both reflection and transmission are mirror-like; also where both sides have the
    /// same index, so that nothing is bent and the facets do not show.
    #[inline]
    #[must_use]
    pub fn is_delta(&self) -> bool {
        self.ggx.is_smooth() || (self.walls == Walls::Solid && (self.ior - 1.0).abs() < 1e-4)
    }

    /// Index of the side that `w` is not on over that of the side that it is on.
    #[inline]
    fn eta(&self, w: Vec3) -> f32 {
        if w.z > 0.0 { self.ior } else { 1.0 / self.ior }
    }

    /// Fresnel for a facet seen under `cos` in [0, 1], from the side of `w`.
    #[inline]
    fn interface(&self, w: Vec3, cos: f32) -> Interface {
        match self.walls {
            Walls::Solid => fresnel::dielectric(cos, self.eta(w)),
            Walls::Thin => {
                let face = fresnel::dielectric(cos, self.ior);
                Interface {
                    reflectance: fresnel::pane(face.reflectance),
                    cos_refracted: cos,
                }
            }
        }
    }

    /// Probability to follow the reflection: its share of the light, but either way is followed one
    /// time in ten at least. A small light seen by way of several faint reflections is found more
    /// often then, and counts less each time; followed by its share, it would be found hardly ever,
    /// and then at its full radiance.
    #[inline]
    fn p_reflect(&self, reflectance: f32) -> f32 {
        let r = reflectance * self.reflection_tint.max_channel();
        let t = (1.0 - reflectance) * self.tint.max_channel();
        if t <= 0.0 {
            f32::from(u8::from(r > 0.0))
        } else if r <= 0.0 {
            0.0
        } else {
            (r / (r + t)).clamp(0.1, 0.9)
        }
    }

    /// What squeezing or widening of the cone does to radiance at a crossing.
    #[inline]
    fn radiance_scale(&self, wo: Vec3, mode: TransportMode) -> f32 {
        if self.walls == Walls::Thin || mode == TransportMode::Importance {
            return 1.0;
        }
        let eta = self.eta(wo);
        1.0 / (eta * eta)
    }

    fn sample_delta(&self, wo: Vec3, u: f32, mode: TransportMode) -> Option<BsdfSample> {
        let cos = wo.z.abs();
        let interface = self.interface(wo, cos);
        let p_reflect = self.p_reflect(interface.reflectance);
        if u < p_reflect {
            return Some(BsdfSample {
                wi: Vec3::new(-wo.x, -wo.y, wo.z),
                f: self.reflection_tint * (interface.reflectance / cos),
                pdf_w: p_reflect,
                is_delta: true,
            });
        }
        let wi = match self.walls {
            Walls::Thin => -wo,
            Walls::Solid => {
                let ratio = 1.0 / self.eta(wo);
                Vec3::new(
                    -wo.x * ratio,
                    -wo.y * ratio,
                    -interface.cos_refracted.copysign(wo.z),
                )
                .normalize()
            }
        };
        let cos_i = wi.z.abs();
        let p_transmit = 1.0 - p_reflect;
        if cos_i == 0.0 || p_transmit <= 0.0 {
            return None;
        }
        let share = (1.0 - interface.reflectance) * self.radiance_scale(wo, mode);
        Some(BsdfSample {
            wi,
            f: self.tint * (share / cos_i),
            pdf_w: p_transmit,
            is_delta: true,
        })
    }

    /// The facet normal that refracts `wo` to `wi`, on the upper side; `None` if there is none
    /// or a facet is seen from its back.
    #[inline]
    fn refracting_facet(&self, wo: Vec3, wi: Vec3) -> Option<Vec3> {
        let m = (wo + wi * self.eta(wo)).normalize_or_zero();
        let m = if m.z < 0.0 { -m } else { m };
        let faces = m.dot(wo) * wo.z > 0.0 && m.dot(wi) * wi.z > 0.0;
        (m.z > 0.0 && faces).then_some(m)
    }
}

impl Scatter for Dielectric {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> Rgb {
        if self.is_delta() || wo.z == 0.0 || wi.z == 0.0 {
            return Rgb::BLACK;
        }
        if is_reflection(wo, wi) {
            let (o, i) = upper(wo, wi);
            let m = (o + i).normalize();
            let share = self.interface(wo, o.dot(m)).reflectance;
            let f = share * self.ggx.d(m) * self.ggx.g2(o, i) / (4.0 * o.z * i.z);
            return self.reflection_tint * f;
        }
        if self.walls == Walls::Thin {
            let (o, i) = upper(wo, Vec3::new(wi.x, wi.y, -wi.z));
            let m = (o + i).normalize();
            let share = 1.0 - self.interface(wo, o.dot(m)).reflectance;
            let f = share * self.ggx.d(m) * self.ggx.g2(o, i) / (4.0 * o.z * i.z);
            return self.tint * f;
        }
        let Some(m) = self.refracting_facet(wo, wi) else {
            return Rgb::BLACK;
        };
        let eta = self.eta(wo);
        let (om, im) = (wo.dot(m), wi.dot(m));
        let share = 1.0 - self.interface(wo, om.abs()).reflectance;
        let g = 1.0 / (1.0 + self.ggx.lambda(wo) + self.ggx.lambda(wi));
        let denominator = om + eta * im;
        // Walter et al. 2007 (21), with η_t² / (…)² for the side that wi is on; radiance
        // is divided by η² where importance is not.
        let f = share * self.ggx.d(m) * g * eta * eta * (om * im).abs()
            / (denominator * denominator * (wo.z * wi.z).abs());
        self.tint * (f * self.radiance_scale(wo, mode))
    }

    fn pdf_w(&self, wo: Vec3, wi: Vec3, _mode: TransportMode) -> f32 {
        if self.is_delta() || wo.z == 0.0 || wi.z == 0.0 {
            return 0.0;
        }
        if is_reflection(wo, wi) {
            let (o, i) = upper(wo, wi);
            let reflected = self.ggx.reflected(o, i);
            let p = self.p_reflect(self.interface(wo, reflected.cos_m).reflectance);
            return p * reflected.pdf_w;
        }
        if self.walls == Walls::Thin {
            let (o, i) = upper(wo, Vec3::new(wi.x, wi.y, -wi.z));
            let reflected = self.ggx.reflected(o, i);
            let p = 1.0 - self.p_reflect(self.interface(wo, reflected.cos_m).reflectance);
            return p * reflected.pdf_w;
        }
        let Some(m) = self.refracting_facet(wo, wi) else {
            return 0.0;
        };
        let eta = self.eta(wo);
        let (om, im) = (wo.dot(m), wi.dot(m));
        let p = 1.0 - self.p_reflect(self.interface(wo, om.abs()).reflectance);
        let denominator = om + eta * im;
        // Jacobian dω_m / dω_i of refraction, Walter et al. 2007 (17).
        let jacobian = eta * eta * im.abs() / (denominator * denominator);
        // From below, a point inversion takes wo to the upper side and the facet facing it to m.
        let upper_wo = wo * 1f32.copysign(wo.z);
        p * self.ggx.pdf_w_visible(upper_wo, m) * jacobian
    }

    #[inline(never)]
    fn sample(&self, wo: Vec3, u: [f32; 3], mode: TransportMode) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        if self.is_delta() {
            return self.sample_delta(wo, u[0], mode);
        }
        let side = 1f32.copysign(wo.z);
        let o = wo * side;
        let m = self.ggx.sample_visible(o, [u[1], u[2]]);
        let cos = o.dot(m);
        let interface = self.interface(wo, cos);
        let wi = if u[0] < self.p_reflect(interface.reflectance) {
            sample_reflected(self.ggx, wo, [u[1], u[2]])?
        } else if self.walls == Walls::Thin {
            let reflected = sample_reflected(self.ggx, wo, [u[1], u[2]])?;
            Vec3::new(reflected.x, reflected.y, -reflected.z)
        } else {
            let ratio = 1.0 / self.eta(wo);
            let refracted = -o * ratio + m * (ratio * cos - interface.cos_refracted);
            if refracted.z >= 0.0 {
                return None;
            }
            refracted.normalize() * side
        };
        let pdf_w = self.pdf_w(wo, wi, mode);
        (pdf_w > 0.0).then(|| BsdfSample {
            wi,
            f: self.eval(wo, wi, mode),
            pdf_w,
            is_delta: false,
        })
    }
}
