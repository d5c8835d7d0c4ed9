//! A vertex of a path on a surface.
//!
//! Directions are world space, unit, pointing away from the surface. The BSDF lives in the frame of
//! the shading normal; the geometric normal decides what is reflection and what is transmission.
//! Where the two differ, [`Bent`] says what becomes of light that one of them sends below the
//! surface. For importance, shading normals ask for the factor
//! `|wo·ns| |wi·ng| / (|wo·ng| |wi·ns|)` ([Veach 1997] eq. 5.19).

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::bent::Bent;
use crate::bsdf::{Bsdf, Lambert, Scatter, TransportMode};
use crate::endpoint::{Receiver, SurfacePoint};
use crate::material::Material;
use crate::math::{Frame, Ray};
use crate::radiometry::Rgb;
use crate::sampling::warp;
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
    /// Of a delta lobe, the probability with which a walk the other way takes it.
    pub delta_reverse: f32,
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

/// A direction in both frames.
#[derive(Clone, Copy)]
struct Direction {
    world: Vec3,
    local: Vec3,
}

impl Direction {
    #[inline(always)]
    fn new(world: Vec3, local: Vec3) -> Self {
        Self { world, local }
    }
}

impl VertexSample {
    /// A direction of a lobe that is not specular.
    #[inline(always)]
    #[must_use]
    pub fn new(wi: Vec3, f_cos: Rgb, pdf_w: f32) -> Self {
        Self {
            wi,
            f_cos,
            pdf_w,
            is_delta: false,
            delta_reverse: 0.0,
        }
    }

    /// `f cos / pdf`: what the step multiplies the throughput by.
    #[inline]
    #[must_use]
    pub fn throughput(&self) -> Rgb {
        self.f_cos / self.pdf_w
    }
}

/// Diffuse reflection, the commonest BSDF, has a way of its own through the methods below, on which
/// all stays in registers; others hand over what they find in memory.
impl SurfaceVertex<'_> {
    /// `f(wo, wi) · cos_i`, 1/sr, delta lobes not counted.
    #[inline(always)]
    #[must_use]
    pub fn f_cos(&self, wi: Vec3, mode: TransportMode) -> Rgb {
        self.f_cos_and_pdf_w(wi, mode)
            .map_or(Rgb::BLACK, |(f_cos, _)| f_cos)
    }

    /// `f · cos_i` with the density of `wi`, delta lobes not counted; `None` where nothing is
    /// scattered.
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
        let scattered = match &self.bsdf {
            Bsdf::Lambert(lambert) => self.diffuse(lambert, wi, wi_local, mode)?,
            other => {
                let (from, to) = (self.given(), Direction::new(wi, wi_local));
                self.assert_local([from, to]);
                if self.is_plain(from) && self.is_plain(to) {
                    let (f, pdf_w) = other.eval_and_pdf_w(self.wo_local, wi_local, mode);
                    let factor = wi_local.z.abs() * self.normal_correction(to, mode);
                    (f * factor, pdf_w)
                } else {
                    self.bent().f_cos_and_pdf_w(other, self.wo, wi, mode)?
                }
            }
        };
        (!scattered.0.is_black()).then_some(scattered)
    }

    /// Density with which [`Self::sample`] yields `wi`, 1/sr, delta lobes not counted.
    #[inline]
    #[must_use]
    pub fn pdf_w(&self, wi: Vec3, mode: TransportMode) -> f32 {
        self.pdf_w_of_pair(self.given(), self.found(wi), mode)
    }

    /// `f · cos_i` with the densities either way, delta lobes not counted; `None` where nothing is
    /// scattered.
    #[inline(always)]
    #[must_use]
    pub fn scattering(&self, wi: Vec3, mode: TransportMode) -> Option<Scattering> {
        let found = self.found(wi);
        let (f_cos, pdf_w_forward) = self.f_cos_and_pdf_w_of(wi, found.local, mode)?;
        Some(Scattering {
            f_cos,
            pdf_w_forward,
            pdf_w_reverse: self.pdf_w_of_pair(found, self.given(), mode.reversed()),
        })
    }

    /// Densities of `wi` given `wo` and of `wo` given `wi`, delta lobes not counted.
    #[inline]
    #[must_use]
    pub fn densities(&self, wi: Vec3) -> Densities {
        let (given, found) = (self.given(), self.found(wi));
        Densities {
            forward: self.pdf_w_of_pair(given, found, TransportMode::Radiance),
            reverse: self.pdf_w_of_pair(found, given, TransportMode::Importance),
        }
    }

    /// Density, 1/sr, with which a walk the other way would have drawn `wo` where this one has
    /// drawn `sample`; for a
    /// delta lobe, the probability.
    #[inline(always)]
    #[must_use]
    pub fn pdf_w_reverse(&self, sample: &VertexSample, mode: TransportMode) -> f32 {
        if sample.is_delta {
            return sample.delta_reverse;
        }
        self.pdf_w_of_pair(self.found(sample.wi), self.given(), mode.reversed())
    }

    /// Density of one direction given another, 1/sr, delta lobes not counted.
    #[inline(always)]
    fn pdf_w_of_pair(&self, given: Direction, found: Direction, mode: TransportMode) -> f32 {
        if !matches!(self.bsdf, Bsdf::Lambert(_)) {
            self.assert_local([given, found]);
        }
        match &self.bsdf {
            Bsdf::Lambert(_) => {
                let ng = self.point.ng;
                let (g_given, g_found) = (ng.dot(given.world), ng.dot(found.world));
                let cos = match mode {
                    TransportMode::Radiance => self.lit(found.local.z, g_found),
                    TransportMode::Importance => g_found.abs(),
                };
                if g_given * g_found > 0.0 {
                    warp::cosine_hemisphere_pdf_w(cos)
                } else {
                    0.0
                }
            }
            other if self.is_plain(given) && self.is_plain(found) => {
                other.pdf_w(given.local, found.local, mode)
            }
            other => self.bent().pdf_w(other, given.world, found.world, mode),
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
        let sample = match bsdf {
            Bsdf::Lambert(lambert) => self.sample_diffuse(lambert, [u[1], u[2]], mode)?,
            other => match self.sample_plain(other, u, mode)? {
                Some(sample) => sample,
                None => self.bent().sample(other, self.wo, u, mode)?,
            },
        };
        (!sample.f_cos.is_black()).then_some(sample)
    }

    /// Asserts, in builds with debug assertions, that directions are in the shading frame, as BSDFs
    /// expect them. Diffuse vertices are not asked: an assertion would break up the vectors that
    /// are made of their steps.
    #[inline(always)]
    fn assert_local<const N: usize>(&self, directions: [Direction; N]) {
        debug_assert!(
            directions.iter().all(|w| {
                let local = self.frame.local_from_world(w.world);
                w.local.abs_diff_eq(local, 1e-3)
            }),
            "a BSDF is given a direction that is not in the shading frame"
        );
    }

    /// `wo`, in both frames.
    #[inline(always)]
    fn given(&self) -> Direction {
        Direction::new(self.wo, self.wo_local)
    }

    #[inline(always)]
    fn found(&self, wi: Vec3) -> Direction {
        Direction::new(wi, self.frame.local_from_world(wi))
    }

    /// True if a direction stands for no other than itself, whichever way light goes, so that
    /// [`Bent`]
    /// is not asked: nearly every one where the two normals are close, and where they are one, all.
    #[inline(always)]
    fn is_plain(&self, w: Direction) -> bool {
        let (g, z) = (self.point.ng.dot(w.world), w.local.z);
        let c = 2.0 * self.frame.z.dot(self.point.ng);
        g * z > 0.0 && z.abs() <= c * g.abs() && g.abs() <= c * z.abs()
    }

    #[inline]
    fn bent(&self) -> Bent {
        Bent::new(self.frame, self.point.ng)
    }

    /// What a diffuse surface receives of light from a direction that makes the given cosines with
    /// the
    /// shading and the geometric normal: see [`Bent`], of which this is the whole for it.
    #[inline(always)]
    fn lit(&self, cos_s: f32, cos_g: f32) -> f32 {
        let side = 1f32.copysign(cos_g);
        let cos_s = cos_s * side;
        let mirrored = cos_s - 2.0 * cos_g.abs() * self.frame.z.dot(self.point.ng);
        cos_s.max(0.0) + mirrored.max(0.0)
    }

    /// Diffuse reflection: any direction on the same side sees the same of what the surface
    /// receives.
    #[inline(always)]
    fn diffuse(
        &self,
        lambert: &Lambert,
        wi: Vec3,
        wi_local: Vec3,
        mode: TransportMode,
    ) -> Option<(Rgb, f32)> {
        let (g_o, g_i) = (self.point.ng.dot(self.wo), self.point.ng.dot(wi));
        if g_o * g_i <= 0.0 {
            return None;
        }
        let (factor, cos) = match mode {
            TransportMode::Radiance => {
                let lit = self.lit(wi_local.z, g_i);
                (lit, lit)
            }
            TransportMode::Importance => {
                let lit = self.lit(self.wo_local.z, g_o);
                (lit * (g_i / g_o), g_i.abs())
            }
        };
        let f = lambert.albedo * FRAC_1_PI;
        Some((f * factor, warp::cosine_hemisphere_pdf_w(cos)))
    }

    /// Radiance is received about the shading normal, importance is sent out about the geometric
    /// one.
    #[inline(always)]
    fn sample_diffuse(
        &self,
        lambert: &Lambert,
        u: [f32; 2],
        mode: TransportMode,
    ) -> Option<VertexSample> {
        let ng = self.point.ng;
        let g_o = ng.dot(self.wo);
        let side = 1f32.copysign(g_o);
        let local = warp::cosine_hemisphere(u);
        let turned = Vec3::new(local.x, local.y, local.z * side);
        let (wi, factor, cos) = match mode {
            TransportMode::Radiance => {
                let wi = self.frame.world_from_local(turned);
                let g_i = ng.dot(wi);
                let mirrored = local.z - 2.0 * g_i * side * self.frame.z.dot(ng);
                let lit = local.z + mirrored.max(0.0);
                // Below the surface it is mirrored up.
                let up = if g_i * side < 0.0 { 2.0 * g_i } else { 0.0 };
                (wi - ng * up, lit, lit)
            }
            TransportMode::Importance => {
                let wi = Frame::from_z(ng).world_from_local(turned);
                let lit = self.lit(self.wo_local.z, g_o);
                (wi, lit * (local.z / g_o.abs()), local.z)
            }
        };
        let f_cos = lambert.albedo * FRAC_1_PI * factor;
        let pdf_w = warp::cosine_hemisphere_pdf_w(cos);
        (pdf_w > 0.0 && g_o != 0.0).then_some(VertexSample {
            wi,
            f_cos,
            pdf_w,
            is_delta: false,
            delta_reverse: 0.0,
        })
    }

    /// Draws a direction where both are plain; an inner `None` leaves it to [`Bent`].
    #[inline(always)]
    fn sample_plain(
        &self,
        bsdf: &Bsdf,
        u: [f32; 3],
        mode: TransportMode,
    ) -> Option<Option<VertexSample>> {
        self.assert_local([self.given()]);
        if !self.is_plain(self.given()) {
            return Some(None);
        }
        let sample = bsdf.sample(self.wo_local, u, mode)?;
        let wi = self.frame.world_from_local(sample.wi);
        let to = Direction::new(wi, sample.wi);
        let factor = sample.wi.z.abs() * self.normal_correction(to, mode);
        Some(self.is_plain(to).then_some(VertexSample {
            wi,
            f_cos: sample.f * factor,
            pdf_w: sample.pdf_w,
            is_delta: sample.is_delta,
            delta_reverse: sample.pdf_w,
        }))
    }

    /// What the surface is to a light that shines on it. Seen from any direction that light is
    /// scattered to from there, it is the same.
    #[inline]
    #[must_use]
    pub fn receiver(&self) -> Receiver {
        let normal = self.frame.z * 1f32.copysign(self.point.ng.dot(self.wo));
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

    #[inline]
    fn normal_correction(&self, wi: Direction, mode: TransportMode) -> f32 {
        if mode == TransportMode::Radiance {
            return 1.0;
        }
        let ng = self.point.ng;
        (self.wo_local.z * ng.dot(wi.world) / (ng.dot(self.wo) * wi.local.z)).abs()
    }
}
