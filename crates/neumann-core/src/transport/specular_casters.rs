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
use crate::math::lanes::{LANES, Laned, Lanes, Vec3Lanes, select, side_by_side, vectorized};
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
        self.axis.x = select(is_reached, cone.axis.x, self.axis.x);
        self.axis.y = select(is_reached, cone.axis.y, self.axis.y);
        self.axis.z = select(is_reached, cone.axis.z, self.axis.z);
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

/// Specular casters in an array of a length that is known beforehand.
fn filled_up(casters: &[SpecularCaster]) -> [SpecularCaster; SpecularCaster::MAX] {
    let nothing = SpecularCaster {
        center: Vec3::ZERO,
        radius: 0.0,
    };
    std::array::from_fn(|i| casters.get(i).copied().unwrap_or(nothing))
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
        let n = casters.len();
        Some(Self::new(&filled_up(casters), n, &vertex.receiver()))
    }

    /// The first `n` specular casters.
    #[inline(always)]
    fn new(casters: &[SpecularCaster; SpecularCaster::MAX], n: usize, from: &Receiver) -> Self {
        let mut seen = Self {
            n,
            ..Self::default()
        };
        for (cone, caster) in seen.cones[..n].iter_mut().zip(casters) {
            *cone = Cone::new(caster, n, from);
            seen.share += cone.share;
        }
        seen
    }

    /// Density of a direction, 1/sr, to which the BSDF gives `pdf_w`.
    #[inline(always)]
    #[must_use]
    pub fn mixed(&self, wi: Vec3, pdf_w: f32) -> f32 {
        let of_bsdf = pdf_w * (1.0 - self.share);
        let cones = self.cones[..self.n].iter();
        cones.fold(of_bsdf, |sum, cone| sum + cone.density(wi))
    }

    /// The direction that is drawn from a cone.
    #[inline(always)]
    fn direction(&self, u: f32, rest: f32) -> Vec3 {
        let mut choice = Choice::default();
        for cone in &self.cones[..self.n] {
            choice.offer(cone, rest * self.share);
        }
        choice.direction(u)
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
            let wi = self.direction(u[1], rest);
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
        Aimed {
            pdf_w_bsdf: self.aimed(aimed.wi, aimed.pdf_w_bsdf),
            ..aimed
        }
    }

    /// Density of a direction that was aimed along. 0 stays: the mixture finds no more lights than
    /// the BSDF does.
    #[inline(always)]
    fn aimed(&self, wi: Vec3, pdf_w: f32) -> f32 {
        select(pdf_w > 0.0, self.mixed(wi, pdf_w), 0.0)
    }
}

side_by_side! {
    /// A [`Cone`] in each lane.
    struct ConeLanes of Cone { axis: Vec3, height: f32, share: f32, density: f32 }
}

/// [`Cones`] in each lane, as many in one as in the other.
#[derive(Default)]
pub(crate) struct ConesLanes {
    cones: [ConeLanes; SpecularCaster::MAX],
    n: usize,
    share: Lanes<f32>,
}

/// A loop over lanes in which the number of cones is a constant. The loop over the cones within it
/// is then unrolled, so that the loop over lanes becomes vectors.
macro_rules! for_each_lane {
    ($number:expr, |$n:ident, $lane:ident| $body:block) => {
        match $number {
            1 => for_each_lane!(1 => $n, $lane, $body),
            2 => for_each_lane!(2 => $n, $lane, $body),
            3 => for_each_lane!(3 => $n, $lane, $body),
            _ => for_each_lane!(SpecularCaster::MAX => $n, $lane, $body),
        }
    };
    ($number:expr => $n:ident, $lane:ident, $body:block) => {{
        const $n: usize = $number;
        for $lane in 0..LANES $body
    }};
}

impl ConesLanes {
    /// Those of a lane; `n` is their number.
    #[inline(always)]
    fn get(&self, lane: usize, n: usize) -> Cones {
        Cones {
            cones: Laned::of_lane(&self.cones, lane),
            n,
            share: self.share.get(lane),
        }
    }

    /// [`Cones::seen_from`], from diffuse vertices.
    pub(crate) fn see(&mut self, casters: &[SpecularCaster], vertices: &DiffuseVertices<'_>) {
        self.n = casters.len();
        see(self, &filled_up(casters), vertices);
    }

    /// [`Cones::beside`]: MIS weights of light that was aimed at along `wi`, with the densities of
    /// light and BSDF.
    pub(crate) fn weigh(
        &self,
        wi: &Vec3Lanes,
        pdf_w_light: &Lanes<f32>,
        pdf_w_bsdf: &Lanes<f32>,
        weights: &mut Lanes<f32>,
    ) {
        weigh(self, wi, pdf_w_light, pdf_w_bsdf, weights);
    }

    /// [`Cones::sample`], in two parts with the draw of the BSDF between them. The first part
    /// decides what the directions are drawn from (1 where it is a cone), and leaves the numbers
    /// for those that the BSDF draws.
    pub(crate) fn choose(&self, u: &mut [Lanes<f32>; 3], is_aimed: &mut Lanes<u32>) {
        choose(self, u, is_aimed);
    }

    /// The second part, where the BSDF has drawn `samples` by these numbers.
    pub(crate) fn sample(
        &self,
        vertices: &DiffuseVertices<'_>,
        u: &[Lanes<f32>; 3],
        is_aimed: &Lanes<u32>,
        mode: TransportMode,
        samples: &mut DiffuseSamples,
    ) {
        sample(self, vertices, u, is_aimed, mode, samples);
    }
}

vectorized! {
    fn see(
        seen: &mut ConesLanes,
        casters: &[SpecularCaster; SpecularCaster::MAX],
        vertices: &DiffuseVertices<'_>,
    ) {
        for_each_lane!(seen.n, |N, lane| {
            let cones = Cones::new(casters, N, &vertices.receiver(lane));
            cones.cones.set_lane(&mut seen.cones, lane);
            seen.share.set(lane, cones.share);
        });
    }
}

vectorized! {
    fn weigh(
        seen: &ConesLanes,
        wi: &Vec3Lanes,
        pdf_w_light: &Lanes<f32>,
        pdf_w_bsdf: &Lanes<f32>,
        weights: &mut Lanes<f32>,
    ) {
        for_each_lane!(seen.n, |N, lane| {
            let pdf_w = seen.get(lane, N).aimed(wi.get(lane), pdf_w_bsdf.get(lane));
            weights.set(lane, power_heuristic(pdf_w_light.get(lane), pdf_w));
        });
    }
}

vectorized! {
    fn choose(seen: &ConesLanes, u: &mut [Lanes<f32>; 3], aimed: &mut Lanes<u32>) {
        for lane in 0..LANES {
            let (is_aimed, rest) = one_of_two(u[2].get(lane), seen.share.get(lane));
            aimed.set(lane, u32::from(is_aimed));
            u[2].set(lane, rest);
        }
    }
}

vectorized! {
    fn sample(
        seen: &ConesLanes,
        vertices: &DiffuseVertices<'_>,
        u: &[Lanes<f32>; 3],
        is_aimed: &Lanes<u32>,
        mode: TransportMode,
        samples: &mut DiffuseSamples,
    ) {
        for_each_lane!(seen.n, |N, lane| {
            let wi = seen.get(lane, N).direction(u[1].get(lane), u[2].get(lane));
            let found = vertices.vertex(lane).f_cos_and_pdf_w(wi, mode);
            samples.replace(is_aimed.get(lane) != 0, lane, wi, found);
        });
        for_each_lane!(seen.n, |N, lane| {
            let drawn = samples.get(lane);
            samples.set_pdf_w(lane, seen.get(lane, N).mixed(drawn.wi, drawn.pdf_w));
        });
    }
}
