//! A vertex of a path on a surface.
//!
//! Directions are world space, unit, pointing away from the surface. The BSDF
//! lives in the frame of the shading normal; the geometric normal decides what is
//! reflection and what is transmission, and nothing passes where the two disagree.
//! For importance, shading normals ask for the factor
//! `|wo·ns| |wi·ng| / (|wo·ng| |wi·ns|)` ([Veach 1997] eq. 5.19).

use glam::Vec3;

use crate::bsdf::{Bsdf, BsdfSample, Scatter, TransportMode};
use crate::endpoint::{Receiver, SurfacePoint};
use crate::material::Material;
use crate::math::{Frame, Ray};
use crate::radiometry::Rgb;
use crate::scene::bodies::Media;

/// A point of a surface that a ray has met, with all that a walk needs to go on.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceVertex<'a> {
    /// Position and geometric normal.
    pub point: SurfacePoint,
    /// Frame about the shading normal.
    pub frame: Frame,
    /// Direction to the previous vertex.
    pub wo: Vec3,
    /// The same in the shading frame.
    pub wo_local: Vec3,
    /// Distance to the previous vertex, metres.
    pub distance: f32,
    /// How the surface scatters, in the shading frame.
    pub bsdf: Bsdf,
    /// Its material.
    pub material: &'a Material,
    /// Probability with which it stopped the ray: below 1 for alpha.
    pub opacity: f32,
    /// Index of the triangle.
    pub triangle: u32,
    /// Barycentric coordinates of the second and third corner.
    pub barycentrics: [f32; 2],
    /// What is on the side that the vertex was not reached from.
    pub across: Media,
    /// Of a wall between media, the numbers of the indices of refraction in front and behind.
    pub(crate) indices: [u8; 2],
}

/// A direction drawn at a vertex.
#[derive(Clone, Copy, Debug)]
pub struct VertexSample {
    /// Direction to the next vertex.
    pub wi: Vec3,
    /// `f · cos_i`, with the correction for shading normals.
    pub f_cos: Rgb,
    /// Density of `wi`, 1/sr; for a delta lobe, its probability.
    pub pdf_w: f32,
    /// True for a mirror-like direction.
    pub is_delta: bool,
}

/// Densities of a pair of directions, each drawn given the other, 1/sr.
#[derive(Clone, Copy, Debug)]
pub struct Densities {
    /// Of `wi` given `wo`.
    pub forward: f32,
    /// Of `wo` given `wi`.
    pub reverse: f32,
}

/// What a vertex makes of a pair of directions.
#[derive(Clone, Copy, Debug)]
pub struct Scattering {
    /// `f · cos_i`, 1/sr, with the correction for shading normals.
    pub f_cos: Rgb,
    /// Density of `wi` given `wo`, 1/sr.
    pub pdf_w_forward: f32,
    /// Density of `wo` given `wi`, walked the other way, 1/sr.
    pub pdf_w_reverse: f32,
}

impl VertexSample {
    /// `f cos / pdf`: what the step multiplies the throughput by.
    #[inline]
    #[must_use]
    pub fn throughput(&self) -> Rgb {
        self.f_cos / self.pdf_w
    }
}

/// Diffuse reflection, the commonest BSDF, has a way of its own through the methods below, on which all stays in registers;
/// others hand over what they find in memory.
impl SurfaceVertex<'_> {
    /// `f(wo, wi) · cos_i`, 1/sr, delta lobes not counted.
    #[inline(always)]
    #[must_use]
    pub fn f_cos(&self, wi: Vec3, mode: TransportMode) -> Rgb {
        let wi_local = self.frame.local_from_world(wi);
        if !self.sides_agree(wi, wi_local) {
            return Rgb::BLACK;
        }
        let factor = wi_local.z.abs() * self.normal_correction(wi, wi_local, mode);
        match &self.bsdf {
            Bsdf::Lambert(lambert) => lambert.eval(self.wo_local, wi_local, mode) * factor,
            other => other.eval(self.wo_local, wi_local, mode) * factor,
        }
    }

    /// `f · cos_i` with the density of `wi`, delta lobes not counted; `None` where nothing is scattered.
    #[inline(always)]
    #[must_use]
    pub fn f_cos_and_pdf_w(&self, wi: Vec3, mode: TransportMode) -> Option<(Rgb, f32)> {
        self.f_cos_and_pdf_w_of(wi, self.frame.local_from_world(wi), mode)
    }

    /// As [`Self::f_cos_and_pdf_w`], of a direction that is known in the shading frame as well.
    #[inline(always)]
    fn f_cos_and_pdf_w_of(
        &self,
        wi: Vec3,
        wi_local: Vec3,
        mode: TransportMode,
    ) -> Option<(Rgb, f32)> {
        if !self.sides_agree(wi, wi_local) {
            return None;
        }
        let factor = wi_local.z.abs() * self.normal_correction(wi, wi_local, mode);
        let weighed = |(f, pdf_w): (Rgb, f32)| (!f.is_black()).then(|| (f * factor, pdf_w));
        match &self.bsdf {
            Bsdf::Lambert(lambert) => {
                weighed(lambert.eval_and_pdf_w(self.wo_local, wi_local, mode))
            }
            other => weighed(other.eval_and_pdf_w(self.wo_local, wi_local, mode)),
        }
    }

    /// Density with which [`Self::sample`] yields `wi`, 1/sr, delta lobes not counted.
    #[inline]
    #[must_use]
    pub fn pdf_w(&self, wi: Vec3, mode: TransportMode) -> f32 {
        let wi_local = self.frame.local_from_world(wi);
        if !self.sides_agree(wi, wi_local) {
            return 0.0;
        }
        self.bsdf.pdf_w(self.wo_local, wi_local, mode)
    }

    /// `f · cos_i` with the densities either way, delta lobes not counted; `None` where nothing is scattered.
    #[inline(always)]
    #[must_use]
    pub fn scattering(&self, wi: Vec3, mode: TransportMode) -> Option<Scattering> {
        let wi_local = self.frame.local_from_world(wi);
        let (f_cos, pdf_w_forward) = self.f_cos_and_pdf_w_of(wi, wi_local, mode)?;
        Some(Scattering {
            f_cos,
            pdf_w_forward,
            pdf_w_reverse: self.pdf_w_back(wi_local, mode),
        })
    }

    /// Densities of `wi` given `wo` and of `wo` given `wi`, delta lobes not counted.
    #[inline]
    #[must_use]
    pub fn densities(&self, wi: Vec3) -> Densities {
        let wi_local = self.frame.local_from_world(wi);
        let (mode, reversed) = (TransportMode::Radiance, TransportMode::Importance);
        Densities {
            forward: self.bsdf.pdf_w(self.wo_local, wi_local, mode),
            reverse: self.bsdf.pdf_w(wi_local, self.wo_local, reversed),
        }
    }

    /// Density, 1/sr, with which a walk the other way would have drawn `wo` where this one has drawn `sample`.
    /// The probability of a delta lobe is the same from either of its directions.
    #[inline(always)]
    #[must_use]
    pub fn pdf_w_reverse(&self, sample: &VertexSample, mode: TransportMode) -> f32 {
        if sample.is_delta {
            return sample.pdf_w;
        }
        self.pdf_w_back(self.frame.local_from_world(sample.wi), mode)
    }

    /// Density with which a walk the other way, along `wi`, draws `wo`, 1/sr.
    #[inline(always)]
    fn pdf_w_back(&self, wi_local: Vec3, mode: TransportMode) -> f32 {
        match &self.bsdf {
            Bsdf::Lambert(lambert) => lambert.pdf_w(wi_local, self.wo_local, mode.reversed()),
            other => other.pdf_w(wi_local, self.wo_local, mode.reversed()),
        }
    }

    /// Draws a direction; `None` means no light this way.
    #[inline(always)]
    #[must_use]
    pub fn sample(&self, u: [f32; 3], mode: TransportMode) -> Option<VertexSample> {
        self.sample_of(&self.bsdf, u, mode)
    }

    /// As [`Self::sample`], from a BSDF other than the vertex's own (one of its lobes).
    #[inline(always)]
    #[must_use]
    pub fn sample_of(&self, bsdf: &Bsdf, u: [f32; 3], mode: TransportMode) -> Option<VertexSample> {
        match bsdf {
            Bsdf::Lambert(lambert) => self.in_world(lambert.sample(self.wo_local, u, mode)?, mode),
            other => self.in_world(other.sample(self.wo_local, u, mode)?, mode),
        }
    }

    /// What is drawn in the shading frame, seen from the world; `None` where the two normals disagree.
    #[inline(always)]
    fn in_world(&self, sample: BsdfSample, mode: TransportMode) -> Option<VertexSample> {
        let wi = self.frame.world_from_local(sample.wi);
        if !self.sides_agree(wi, sample.wi) {
            return None;
        }
        let f_cos = sample.f * (sample.wi.z.abs() * self.normal_correction(wi, sample.wi, mode));
        (!f_cos.is_black()).then_some(VertexSample {
            wi,
            f_cos,
            pdf_w: sample.pdf_w,
            is_delta: sample.is_delta,
        })
    }

    /// What the surface is to a light that shines on it. Seen from any direction that light is scattered to from there,
    /// it is the same.
    #[inline]
    #[must_use]
    pub fn receiver(&self) -> Receiver {
        let normal = self.frame.z * 1f32.copysign(self.wo_local.z);
        Receiver::new(self.point.position, normal, self.bsdf.is_transmissive())
    }

    /// A ray that leaves the surface along `wi`.
    #[inline]
    #[must_use]
    pub fn ray(&self, wi: Vec3) -> Ray {
        self.point.ray(wi)
    }

    /// Cosine of a direction with the geometric normal, not negative.
    #[inline]
    #[must_use]
    pub fn cos_g(&self, w: Vec3) -> f32 {
        self.point.ng.dot(w).abs()
    }

    /// True if shading and geometric normal agree on the sides of `wo` and `wi`.
    #[inline]
    fn sides_agree(&self, wi: Vec3, wi_local: Vec3) -> bool {
        let ng = self.point.ng;
        ng.dot(wi) * wi_local.z > 0.0 && ng.dot(self.wo) * self.wo_local.z > 0.0
    }

    #[inline]
    fn normal_correction(&self, wi: Vec3, wi_local: Vec3, mode: TransportMode) -> f32 {
        if mode == TransportMode::Radiance {
            return 1.0;
        }
        let ng = self.point.ng;
        (self.wo_local.z * ng.dot(wi) / (ng.dot(self.wo) * wi_local.z)).abs()
    }
}
