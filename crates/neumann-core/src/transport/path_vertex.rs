//! A vertex of a path that is walked once more, with what is known there.

use glam::Vec3;

use super::{Lobe, Lobes};
use crate::endpoint::Aim;
use crate::radiometry::Rgb;

/// What a vertex of a path is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexKind {
    /// A point of the lens, or of an orthographic film.
    Lens,
    /// A point of a light that a path starts at or that is aimed at.
    Light,
    /// Light from infinitely far away: the position is the direction to it.
    FarLight,
    /// A surface that the path has met.
    Surface,
}

/// What light comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Source {
    /// A surface of this material.
    Material(u32),
    /// A light of no extent in the scene or in direction, by its number among those of
    /// [`Appearance::lights`](crate::scene::Appearance::lights).
    Punctual(u32),
    /// The environment.
    Environment,
}

/// How a path leaves a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// Direction to the next vertex, unit.
    pub wi: Vec3,
    /// What scatters; of several lobes, the one that scatters most.
    pub lobe: Lobe,
    /// Share of the glossy lobe, per channel; the diffuse one has the rest. 0 for a specular one.
    pub glossy: Rgb,
    /// True if the path goes on at the other side of the surface.
    pub is_transmission: bool,
    /// `f · cos`, 1/sr; for a specular lobe, its reflectance or transmittance.
    pub f_cos: Rgb,
    /// Density of the direction, 1/sr; for a specular lobe, its probability.
    pub pdf_w: f32,
    /// The same for a path that is walked the other way.
    pub pdf_w_reverse: f32,
    /// Probability with which Russian roulette lets the path go on.
    pub survival: f32,
}

/// A vertex of a path, from the end that it was walked from.
#[derive(Clone, Debug)]
pub struct PathVertex {
    /// What it is.
    pub kind: VertexKind,
    /// World space, metres.
    pub position: Vec3,
    /// Geometric normal, unit; zero where there is none.
    pub ng: Vec3,
    /// Shading normal, unit; zero where there is none.
    pub ns: Vec3,
    /// The triangle that it is on.
    pub triangle: Option<u32>,
    /// Index of the material there.
    pub material: Option<u32>,
    /// What scatters here where the path is joined to another one.
    pub(crate) lobes: Option<Lobes>,
    /// What the light comes from, if it was aimed at or started from.
    pub(crate) source: Option<Source>,
    /// Throughput of the path up to here, scattering not included.
    pub throughput: Rgb,
    /// The paths that go on from here in place of one.
    pub n_paths: u32,
    /// How the path goes on, unless it ends here.
    pub event: Option<Event>,
}

impl PathVertex {
    /// What scatters here where the path is joined to another one; of several lobes, the diffuse
    /// one.
    #[must_use]
    pub fn lobe(&self) -> Option<Lobe> {
        self.lobes.as_ref().map(Lobes::main)
    }

    /// What the light comes from, where the path begins here.
    #[must_use]
    pub fn source(&self) -> Option<Source> {
        match self.kind {
            VertexKind::Surface => self.material.map(Source::Material),
            _ => self.source,
        }
    }

    /// Towards this vertex from another one, of any length.
    #[must_use]
    pub fn direction_from(&self, other: &Self) -> Vec3 {
        match self.kind {
            VertexKind::FarLight => self.position,
            _ => self.position - other.position,
        }
    }

    pub(super) fn end(kind: VertexKind, position: Vec3, throughput: Rgb) -> Self {
        Self {
            kind,
            position,
            ng: Vec3::ZERO,
            ns: Vec3::ZERO,
            triangle: None,
            material: None,
            lobes: None,
            source: None,
            throughput,
            n_paths: 1,
            event: None,
        }
    }

    pub(super) fn of_aim(from: Vec3, aim: &Aim, near: VertexKind) -> Self {
        match &aim.surface {
            Some(point) => Self {
                ng: point.ng,
                triangle: Some(point.triangle),
                ..Self::end(near, point.position, Rgb::WHITE)
            },
            None if aim.distance.is_finite() => {
                Self::end(near, from + aim.wi * aim.distance, Rgb::WHITE)
            }
            None => Self::end(VertexKind::FarLight, aim.wi, Rgb::WHITE),
        }
    }
}
