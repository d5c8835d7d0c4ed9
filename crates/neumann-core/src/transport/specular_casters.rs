//! Directions towards mirrors and glass, beside those of the BSDF.
//!
//! A caustic is light that reached a diffuse surface by way of something mirror-like, its specular
//! caster. The BSDF of the surface sends few paths there. So a share of them is drawn from the
//! cones that specular casters fill, seen from the vertex, and the rest from the BSDF. Photons are
//! sent to such things by projection maps (Jensen 2001, ch. 5); a mixture with the density that
//! there was makes it safe ("defensive" sampling, Hesterberg 1995). The density of a direction is
//! that of the mixture, whichever of the two has drawn it.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3;

use super::diffuse::{DiffuseSamples, DiffuseVertices};
use super::reflection::Aimed;
use super::{SurfaceVertex, VertexSample};
use crate::bsdf::TransportMode;
use crate::endpoint::Receiver;
use crate::math::Frame;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, select, side_by_side, vectorized};
use crate::sampling::discrete::one_of_two;
use crate::sampling::mis::power_heuristic;
use crate::sampling::warp;
use crate::scene::SpecularCaster;

/// The share of a vertex's paths that specular casters have between them, at most.
const MAX_SHARE: f32 = 0.25;
/// Density within a cone, in units of the largest that a diffuse surface has: at most this, so that
/// what is small and far away does not draw more than it may be worth,
const MAX_DENSITY: f32 = 16.0 * FRAC_1_PI;
/// and at least this, or the BSDF does as well.
const MIN_DENSITY: f32 = 0.25 * FRAC_1_PI;
/// Smaller cones are hard to tell from their axis in single precision.
const MIN_HEIGHT: f32 = 1e-6;

/// The cone that a specular caster fills, seen from a vertex.
#[derive(Clone, Copy, Debug, Default)]
struct Cone {
    /// Unit.
    axis: Vec3,
    /// 1 less the cosine of the half-angle.
    height: f32,
    /// Share of the vertex's paths that are drawn from it; 0 if it is not used.
    share: f32,
    /// The share over the cone's solid angle, 1/sr.
    density: f32,
}

impl Cone {
    /// One of `n` specular casters seen from a vertex.
    #[inline(always)]
    fn new(caster: &SpecularCaster, n: usize, from: &Receiver) -> Self {
        let towards = caster.center - from.position;
        let squared = towards.length_squared();
        let sin2 = caster.radius * caster.radius / squared;
        let height = sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt());
        let solid_angle = TAU * height;
        let density = (MAX_SHARE / (n as f32 * solid_angle)).min(MAX_DENSITY);
        // A vertex within the sphere sees no cone. Comparisons are false where a number is none.
        let density = select(sin2 < 1.0, density, 0.0);
        let density = select(height > MIN_HEIGHT, density, 0.0);
        let density = select(density > MIN_DENSITY, density, 0.0);
        let above = towards.dot(from.normal) + caster.radius;
        let above = select(from.has_both_sides(), 1.0, above);
        let density = select(above > 0.0, density, 0.0);
        Self {
            axis: towards * (1.0 / squared.sqrt()),
            height,
            share: density * height * TAU,
            density,
        }
    }

    /// The density that it gives a unit direction, 1/sr. The angle is measured by the chord, since
    /// cosines of small angles are all nearly 1.
    #[inline(always)]
    fn density(&self, wi: Vec3) -> f32 {
        let is_within = 0.5 * (wi - self.axis).length_squared() <= self.height;
        select(is_within, self.density, 0.0)
    }
}

/// The cone that a direction is drawn from: the one of which the share, behind those before it,
/// holds a number.
#[derive(Clone, Copy, Debug, Default)]
struct Choice {
    axis: Vec3,
    height: f32,
    /// What is left of the number, in [0, 1].
    rest: f32,
    /// Where the next share starts.
    start: f32,
}

impl Choice {
    /// Takes the next cone instead, if the number reaches it.
    #[inline(always)]
    fn offer(&mut self, cone: &Cone, number: f32) {
        let rest = (number - self.start) / cone.share;
        // False where the share is 0.
        let is_reached = (rest >= 0.0) & (cone.share > 0.0);
        let [x, y, z] = [0, 1, 2].map(|i| select(is_reached, cone.axis[i], self.axis[i]));
        self.axis = Vec3::new(x, y, z);
        self.height = select(is_reached, cone.height, self.height);
        self.rest = select(is_reached, rest.min(1.0), self.rest);
        self.start += cone.share;
    }

    /// The direction.
    #[inline(always)]
    fn direction(&self, u: f32) -> Vec3 {
        in_cone(self.axis, self.height, [u, self.rest])
    }
}

/// Uniform in the cone about an axis of which 1 less the cosine of the half-angle is `height`: a
/// point of the disk, lifted to the sphere so that areas stay in proportion.
#[inline(always)]
fn in_cone(axis: Vec3, height: f32, u: [f32; 2]) -> Vec3 {
    let p = warp::disk(u);
    let depth = p.length_squared() * height;
    let scale = (height * (2.0 - depth)).max(0.0).sqrt();
    Frame::from_z(axis).world_from_local(Vec3::new(p.x * scale, p.y * scale, 1.0 - depth))
}

/// The specular casters seen from a vertex.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cones {
    cones: [Cone; SpecularCaster::MAX],
    n: usize,
    /// All shares.
    share: f32,
}

impl Cones {
    /// What a vertex sees of specular casters, up to [`SpecularCaster::MAX`]; `None` if there are
    /// none, or its BSDF has no diffuse part.
    #[inline]
    #[must_use]
    pub fn seen_from(vertex: &SurfaceVertex<'_>, casters: &[SpecularCaster]) -> Option<Self> {
        if casters.is_empty() || !vertex.bsdf.has_density() || vertex.bsdf.roughness() < 1.0 {
            return None;
        }
        let mut seen = Self::default();
        let from = vertex.receiver();
        for caster in casters {
            let cone = Cone::new(caster, casters.len(), &from);
            seen.cones[seen.n] = cone;
            seen.n += 1;
            seen.share += cone.share;
        }
        Some(seen)
    }

    /// Density of a direction, 1/sr, to which the BSDF gives `pdf_w`.
    #[inline]
    #[must_use]
    pub fn mixed(&self, wi: Vec3, pdf_w: f32) -> f32 {
        let cones = self.cones[..self.n].iter();
        cones.fold(pdf_w * (1.0 - self.share), |sum, cone| {
            sum + cone.density(wi)
        })
    }

    /// Draws a direction from the mixture; `None` means no light this way. The numbers are those
    /// that the BSDF would have had.
    #[inline]
    #[must_use]
    pub fn sample(
        &self,
        vertex: &SurfaceVertex<'_>,
        u: [f32; 3],
        mode: TransportMode,
    ) -> Option<VertexSample> {
        let (is_aimed, rest) = one_of_two(u[2], self.share);
        if is_aimed {
            let mut choice = Choice::default();
            for cone in &self.cones[..self.n] {
                choice.offer(cone, rest * self.share);
            }
            let wi = choice.direction(u[1]);
            let (f_cos, pdf_w) = vertex.f_cos_and_pdf_w(wi, mode)?;
            return Some(VertexSample {
                wi,
                f_cos,
                pdf_w: self.mixed(wi, pdf_w),
                is_delta: false,
                delta_reverse: 0.0,
            });
        }
        let sample = vertex.sample([u[0], u[1], rest], mode)?;
        Some(VertexSample {
            pdf_w: if sample.is_delta {
                sample.pdf_w * (1.0 - self.share)
            } else {
                self.mixed(sample.wi, sample.pdf_w)
            },
            ..sample
        })
    }

    /// What is aimed at from the vertex, if its directions are drawn from the mixture.
    #[inline]
    #[must_use]
    pub fn beside(&self, aimed: Aimed) -> Aimed {
        // 0 stays: the mixture finds no more lights than the BSDF does.
        let is_found = aimed.pdf_w_bsdf > 0.0;
        Aimed {
            pdf_w_bsdf: select(is_found, self.mixed(aimed.wi, aimed.pdf_w_bsdf), 0.0),
            ..aimed
        }
    }
}

/// The specular casters seen from the vertices of all lanes.
#[derive(Default)]
pub(crate) struct ConeLanes {
    cones: [OneConeLanes; SpecularCaster::MAX],
    n: usize,
    share: Lanes<f32>,
    choice: ChoiceLanes,
    /// 1 where a direction is drawn from a cone.
    is_aimed: Lanes<u32>,
    /// Of the mixture.
    density: Lanes<f32>,
}

side_by_side! {
    /// A [`Choice`] in each lane.
    struct ChoiceLanes of Choice { axis: Vec3, height: f32, rest: f32, start: f32 }
}

side_by_side! {
    /// A [`Cone`] in each lane.
    struct OneConeLanes of Cone { axis: Vec3, height: f32, share: f32, density: f32 }
}

impl ConeLanes {
    /// [`Cones::seen_from`], from diffuse vertices.
    pub(crate) fn see(&mut self, casters: &[SpecularCaster], vertices: &DiffuseVertices<'_>) {
        see(self, casters, vertices);
    }

    /// [`Cones::beside`]: MIS weights of light that was aimed at along `wi`, with the densities of
    /// light and BSDF.
    pub(crate) fn weigh(
        &mut self,
        wi: &Vec3Lanes,
        pdf_w_light: &Lanes<f32>,
        pdf_w_bsdf: &Lanes<f32>,
        weights: &mut Lanes<f32>,
    ) {
        weigh(self, wi, pdf_w_light, pdf_w_bsdf, weights);
    }

    /// The first part of [`Cones::sample`]: decides what the directions are drawn from, and leaves
    /// the numbers for those that the BSDF draws.
    pub(crate) fn choose(&mut self, u: &mut [Lanes<f32>; 3]) {
        choose(self, u);
    }

    /// The second part, where the BSDF has drawn `samples` by these numbers.
    pub(crate) fn sample(
        &mut self,
        vertices: &DiffuseVertices<'_>,
        u: &[Lanes<f32>; 3],
        mode: TransportMode,
        samples: &mut DiffuseSamples,
    ) {
        sample(self, vertices, u, mode, samples);
    }
}

vectorized! {
    fn see(seen: &mut ConeLanes, casters: &[SpecularCaster], vertices: &DiffuseVertices<'_>) {
        let ConeLanes { cones, n, share, .. } = seen;
        *n = casters.len();
        *share = Lanes::default();
        for (caster, cones) in casters.iter().zip(cones) {
            see_one(cones, share, *caster, *n, vertices);
        }
    }
}

#[inline(always)]
fn see_one(
    cones: &mut OneConeLanes,
    share: &mut Lanes<f32>,
    caster: SpecularCaster,
    n: usize,
    vertices: &DiffuseVertices<'_>,
) {
    for lane in 0..LANES {
        let cone = Cone::new(&caster, n, &vertices.receiver(lane));
        cones.set(lane, cone);
        share.set(lane, share.get(lane) + cone.share);
    }
}

vectorized! {
    fn weigh(
        seen: &mut ConeLanes,
        wi: &Vec3Lanes,
        pdf_w_light: &Lanes<f32>,
        pdf_w_bsdf: &Lanes<f32>,
        weights: &mut Lanes<f32>,
    ) {
        mix(seen, wi, pdf_w_bsdf);
        for lane in 0..LANES {
            let is_found = pdf_w_bsdf.get(lane) > 0.0;
            let mixed = select(is_found, seen.density.get(lane), 0.0);
            weights.set(lane, power_heuristic(pdf_w_light.get(lane), mixed));
        }
    }
}

vectorized! {
    fn choose(seen: &mut ConeLanes, u: &mut [Lanes<f32>; 3]) {
        let ConeLanes { cones, n, share, choice, is_aimed: aimed, .. } = seen;
        choice.start = Lanes::default();
        for lane in 0..LANES {
            let (is_aimed, rest) = one_of_two(u[2].get(lane), share.get(lane));
            aimed.set(lane, u32::from(is_aimed));
            u[2].set(lane, rest);
        }
        for cones in &cones[..*n] {
            for lane in 0..LANES {
                let mut of_lane = choice.get(lane);
                of_lane.offer(&cones.get(lane), u[2].get(lane) * share.get(lane));
                choice.set(lane, of_lane);
            }
        }
    }
}

vectorized! {
    fn sample(
        seen: &mut ConeLanes,
        vertices: &DiffuseVertices<'_>,
        u: &[Lanes<f32>; 3],
        mode: TransportMode,
        samples: &mut DiffuseSamples,
    ) {
        for lane in 0..LANES {
            let wi = seen.choice.get(lane).direction(u[1].get(lane));
            let vertex = vertices.vertex(lane);
            let found = vertex.f_cos_and_pdf_w(wi, mode);
            let is_aimed = seen.is_aimed.get(lane) != 0;
            samples.replace(is_aimed, lane, wi, found);
        }
        let (wi, pdf_w) = samples.drawn();
        mix(seen, wi, pdf_w);
        samples.set_pdf_w(&seen.density);
    }
}

/// [`Cones::mixed`].
#[inline(always)]
fn mix(seen: &mut ConeLanes, wi: &Vec3Lanes, pdf_w: &Lanes<f32>) {
    let density = &mut seen.density;
    for lane in 0..LANES {
        density.set(lane, pdf_w.get(lane) * (1.0 - seen.share.get(lane)));
    }
    for cones in &seen.cones[..seen.n] {
        for lane in 0..LANES {
            let of_cone = cones.get(lane).density(wi.get(lane));
            density.set(lane, density.get(lane) + of_cone);
        }
    }
}
