//! How much each technique counts: the running quantities of vertex connection and merging.
//!
//! After I. Georgiev, Implementing Vertex Connection and Merging, 2012 (\[VCM\] below; equation
//! numbers are the report's), which brings the sum over all techniques of a path,
//! `w = p / Σ p_i`, into three numbers that a walk carries along:
//!
//! - `d_vcm`, what both kinds of technique share: one over the density of the latest vertex,
//!   (31), (34);
//! - `d_vc`, the densities of all connections before it, (32), (35);
//! - `d_vm`, the densities of all merges before it, (33), (36);
//!
//! all relative to the density of the subpath itself. At the joint of two subpaths the weight is
//! `1 / (w_light + 1 + w_camera)` with (37)-(46). Each ratio of densities goes through
//! [`Heuristic::of`], which makes the balance heuristic, the power heuristic or a plain average of
//! it.
//!
//! Numbers of samples enter as ratios. Per camera subpath there is one connection by each technique
//! with t ≥ 2; techniques that end on the lens use all light subpaths, N of them for each camera
//! subpath; a merge uses all N light subpaths of the whole image within a disk of area πr².

use glam::Vec3;

use crate::endpoint::{Aim, CameraRay, LensHit, Spread, Start, StartDensities};
use crate::math::lanes::side_by_side;
use crate::transport::{Scattering, SurfaceVertex};

/// How the densities of techniques become weights ([Veach 1997] 9.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heuristic {
    /// In proportion to the density, (9.8) there.
    Balance,
    /// In proportion to its square.
    Power,
    /// All that can make the path count alike: there to show why the others matter.
    Average,
    /// Other techniques count nothing: for a method that has only one.
    Never,
}

impl Heuristic {
    /// What a ratio of densities counts.
    #[inline]
    #[must_use]
    pub fn of(self, ratio: f32) -> f32 {
        match self {
            Self::Balance => ratio.min(f32::MAX),
            Self::Power => (ratio * ratio).min(f32::MAX),
            Self::Average => f32::from(u8::from(ratio > 0.0)),
            Self::Never => 0.0,
        }
    }
}

/// The running quantities at one vertex of a subpath.
#[derive(Clone, Copy, Debug, Default)]
pub struct Partial {
    /// Shared by connections and merges.
    pub d_vcm: f32,
    /// Connections before this vertex.
    pub d_vc: f32,
    /// Merges before this vertex.
    pub d_vm: f32,
}

side_by_side! {
    /// The running quantities in each lane.
    pub(crate) struct PartialLanes of Partial { d_vcm: f32, d_vc: f32, d_vm: f32 }
}

/// What all weights of an iteration have in common.
#[derive(Clone, Copy, Debug)]
pub struct MisWeights {
    heuristic: Heuristic,
    /// Light subpaths for each camera subpath.
    light_paths: f32,
    /// `of(η)`, with `η = N π r²` the density of merges over that of connections; 0 where
    /// nothing merges.
    merges: f32,
    /// `of(1 / η)`; 0 where nothing merges or nothing is connected.
    connections: f32,
}

/// The densities at a joint, as the joining code knows them.
#[derive(Clone, Copy, Debug)]
pub struct JointDensities {
    /// Density of the new segment's direction at the camera vertex, 1/sr.
    pub camera_forward: f32,
    /// Density, walking from the light, of going on from the camera vertex to its predecessor,
    /// 1/sr.
    pub camera_reverse: f32,
    /// Density of the new segment's direction at the light vertex, 1/sr.
    pub light_forward: f32,
    /// Density, walking from the camera, of going on from the light vertex to its predecessor,
    /// 1/sr.
    pub light_reverse: f32,
    /// Cosine of the segment with the geometric normal at the camera vertex.
    pub camera_cos: f32,
    /// Cosine of the segment with the geometric normal at the light vertex.
    pub light_cos: f32,
    /// Length of the segment, squared, m².
    pub distance_squared: f32,
}

impl MisWeights {
    /// Connections alone: bidirectional path tracing, with `light_paths` light subpaths for each
    /// camera subpath.
    #[must_use]
    pub fn connections(heuristic: Heuristic, light_paths: f32) -> Self {
        Self {
            heuristic,
            light_paths,
            merges: 0.0,
            connections: 0.0,
        }
    }

    /// A single technique: nothing competes with it and all weights are 1.
    #[must_use]
    pub fn one_technique() -> Self {
        Self::connections(Heuristic::Never, 1.0)
    }

    /// Merges of `n_light_paths` light subpaths within `radius`, with connections or without.
    #[must_use]
    pub fn merges(self, n_light_paths: usize, radius: f32, has_connections: bool) -> Self {
        let eta = std::f32::consts::PI * radius * radius * n_light_paths as f32;
        Self {
            merges: self.heuristic.of(eta),
            connections: if has_connections {
                self.heuristic.of(1.0 / eta)
            } else {
                0.0
            },
            ..self
        }
    }

    /// How densities become weights.
    #[inline]
    #[must_use]
    pub fn heuristic(&self) -> Heuristic {
        self.heuristic
    }

    /// The same by another heuristic.
    #[inline(always)]
    #[must_use]
    pub fn with(self, heuristic: Heuristic) -> Self {
        Self { heuristic, ..self }
    }

    /// True if techniques compete. Where none does, weights are 1 and nothing has to be carried
    /// along for them.
    #[inline]
    #[must_use]
    pub fn has_others(&self) -> bool {
        self.heuristic != Heuristic::Never
    }

    /// Quantities of a ray as a light starts it, (31)-(33) without the geometry of the first
    /// segment and without the choice of the light, see [`Self::choose`].
    #[inline(always)]
    #[must_use]
    pub fn of_light(&self, start: &Start) -> Partial {
        let is_delta = start.is_delta_position || start.is_delta_direction;
        // Whoever runs into the light meets as much of it as there is.
        let back = (!is_delta).then_some((start.cos * start.opacity, start.densities));
        self.of_start(first_density(start.spread), back, 1.0)
    }

    /// Quantities of a ray as the camera starts it.
    #[must_use]
    pub fn of_camera(&self, start: &CameraRay) -> Partial {
        let lens = (!start.is_delta).then_some((start.cos, start.densities));
        self.of_start(first_density(start.spread), lens, self.light_paths)
    }

    #[inline(always)]
    fn of_start(&self, density: f32, back: Option<(f32, StartDensities)>, n: f32) -> Partial {
        let d_vc = back.map_or(0.0, |(cos, densities)| {
            self.of(n * cos / (densities.pdf_a * densities.pdf_w))
        });
        Partial {
            d_vcm: self.of(n / density),
            d_vc,
            d_vm: d_vc * self.connections,
        }
    }

    /// Quantities after a segment has met a surface under a cosine with its geometric normal,
    /// (34)-(36). The squared length counts unless the segment comes from infinity: then it is 1.
    #[inline(always)]
    #[must_use]
    pub fn arrive(&self, partial: Partial, distance_squared: f32, cos: f32) -> Partial {
        let over_cos = self.of(1.0 / cos);
        Partial {
            d_vcm: (partial.d_vcm * self.of(distance_squared) * over_cos).min(f32::MAX),
            d_vc: (partial.d_vc * over_cos).min(f32::MAX),
            d_vm: (partial.d_vm * over_cos).min(f32::MAX),
        }
    }

    /// Quantities at the first vertex that a light subpath meets, where they begin with `p_connect
    /// / p_trace`, (31): the probability of choosing its light to aim at from there, over that of
    /// choosing it to start from.
    #[inline]
    #[must_use]
    pub fn choose(&self, partial: Partial, aim_over_start: f32) -> Partial {
        Partial {
            d_vcm: (partial.d_vcm * self.of(aim_over_start)).min(f32::MAX),
            ..partial
        }
    }

    /// Quantities after a direction has been drawn, without the geometry of the new segment,
    /// (34)-(36). Nothing joins at a delta lobe; its probabilities from either side count.
    #[inline(always)]
    #[must_use]
    pub fn scatter(
        &self,
        at: Partial,
        cos: f32,
        pdf_w_forward: f32,
        pdf_w_reverse: f32,
        is_delta: bool,
    ) -> Partial {
        if is_delta {
            let cos = self.of(cos * (pdf_w_reverse / pdf_w_forward));
            return Partial {
                d_vcm: 0.0,
                d_vc: at.d_vc * cos,
                d_vm: at.d_vm * cos,
            };
        }
        let (ratio, reverse) = (self.of(cos / pdf_w_forward), self.of(pdf_w_reverse));
        Partial {
            d_vcm: self.of(1.0 / pdf_w_forward),
            d_vc: (ratio * (at.d_vc * reverse + at.d_vcm + self.merges)).min(f32::MAX),
            d_vm: (ratio * (at.d_vm * reverse + at.d_vcm * self.connections + 1.0)).min(f32::MAX),
        }
    }

    /// Weight of a camera subpath that ran into an emitter (s = 0), (43): the density with which
    /// the emitter would have been aimed at (1/m², or 1/sr at infinity), and the densities with
    /// which it would have started the ray.
    #[inline]
    #[must_use]
    pub fn hit(&self, at: Partial, pdf_aim: f32, start: StartDensities) -> f32 {
        weight(
            self.of(pdf_aim) * at.d_vcm + self.of(start.pdf_a * start.pdf_w) * at.d_vc,
            0.0,
        )
    }

    /// Weight of a light subpath that ran into the lens (t = 0).
    #[must_use]
    pub fn lens(&self, at: Partial, lens: &LensHit) -> f32 {
        let emission = lens.start.pdf_a * lens.start.pdf_w / self.light_paths;
        weight(
            self.of(lens.start.pdf_a) * at.d_vcm + self.of(emission) * at.d_vc,
            0.0,
        )
    }

    /// Weight of aiming at a light from a camera vertex (s = 1), (44)-(45).
    #[inline(always)]
    #[must_use]
    pub fn next_event(&self, at: Partial, aim: &Aim, joint: &EndDensities) -> f32 {
        self.end(at, aim, joint, 1.0)
    }

    /// Weight of aiming at the lens from a light vertex (t = 1), (46).
    #[inline(always)]
    #[must_use]
    pub fn splat(&self, at: Partial, aim: &Aim, joint: &EndDensities) -> f32 {
        self.end(at, aim, joint, self.light_paths)
    }

    #[inline(always)]
    fn end(&self, at: Partial, aim: &Aim, joint: &EndDensities, n: f32) -> f32 {
        let found = if aim.is_delta {
            0.0
        } else {
            self.of(joint.forward * aim.opacity / aim.pdf_w)
        };
        // What starts at the endpoint is chosen otherwise than what aims at it: p_trace /
        // p_connect.
        let chosen = aim.start_over_aim * aim.spread.pdf_a_across(aim.distance);
        let reached = chosen * joint.cos / n;
        weight(
            found,
            self.of(reached) * (self.merges + at.d_vcm + at.d_vc * self.of(joint.reverse)),
        )
    }

    /// Weight of connecting two vertices (s ≥ 2, t ≥ 2), (40)-(41).
    #[inline(always)]
    #[must_use]
    pub fn connect(&self, camera: Partial, light: Partial, joint: &JointDensities) -> f32 {
        let d2 = joint.distance_squared;
        let at_light = self.of(joint.camera_forward * joint.light_cos / d2);
        let at_camera = self.of(joint.light_forward * joint.camera_cos / d2);
        weight(
            at_light * (self.merges + light.d_vcm + light.d_vc * self.of(joint.light_reverse)),
            at_camera * (self.merges + camera.d_vcm + camera.d_vc * self.of(joint.camera_reverse)),
        )
    }

    /// Weight of merging a light vertex into a camera vertex, (38)-(39): the densities at the
    /// camera vertex of the direction that the photon came from, and of the one the camera subpath
    /// came from.
    #[inline]
    #[must_use]
    pub fn merge(
        &self,
        camera: Partial,
        light: Partial,
        pdf_w_forward: f32,
        pdf_w_reverse: f32,
    ) -> f32 {
        weight(
            light.d_vcm * self.connections + light.d_vm * self.of(pdf_w_forward),
            camera.d_vcm * self.connections + camera.d_vm * self.of(pdf_w_reverse),
        )
    }

    #[inline(always)]
    fn of(&self, ratio: f32) -> f32 {
        self.heuristic.of(ratio)
    }
}

/// The densities at a vertex that aims at an endpoint.
#[derive(Clone, Copy, Debug)]
pub struct EndDensities {
    /// Of the direction to the endpoint, 1/sr.
    pub forward: f32,
    /// Of going on to the vertex before, coming from the endpoint, 1/sr.
    pub reverse: f32,
    /// Cosine of the direction to the endpoint with the geometric normal.
    pub cos: f32,
}

impl EndDensities {
    /// Those of a vertex that scatters so along `wi`.
    #[inline(always)]
    #[must_use]
    pub fn of(surface: &SurfaceVertex<'_>, scattering: &Scattering, wi: Vec3) -> Self {
        Self {
            forward: scattering.pdf_w_forward,
            reverse: scattering.pdf_w_reverse,
            cos: surface.cos_g(wi),
        }
    }
}

/// Density of the first segment without its geometry: 1/sr from a point, 1/m² from infinity.
#[inline(always)]
fn first_density(spread: Spread) -> f32 {
    match spread {
        Spread::Point { pdf_w } => pdf_w,
        Spread::Parallel { pdf_a } => pdf_a,
    }
}

#[inline(always)]
fn weight(one_side: f32, other_side: f32) -> f32 {
    1.0 / (1.0 + one_side + other_side)
}
