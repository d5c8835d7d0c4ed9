//! The lobes of a surface, told apart.

use std::sync::Arc;

use glam::Vec3;

use super::SurfaceVertex;
use super::bent::Bent;
use crate::bsdf::{Bsdf, TransportMode};
use crate::radiometry::Rgb;

/// The part of a BSDF that scatters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lobe {
    /// Alike in all directions.
    Diffuse,
    /// Around a direction, by facets.
    Glossy,
    /// In a single direction.
    Specular,
}

/// What a surface scatters with at a vertex, for any pair of directions.
#[derive(Clone, Debug)]
pub(crate) enum Lobes {
    /// One lobe alone; a specular one scatters nothing from one given direction to another.
    One(Lobe),
    /// A diffuse base and a glossy lobe.
    Both(Arc<Both>),
}

#[derive(Debug)]
pub(crate) struct Both {
    bent: Bent,
    all: Bsdf,
    glossy: Bsdf,
}

impl Lobes {
    pub(crate) fn of(vertex: &SurfaceVertex<'_>) -> Self {
        let bsdf = &vertex.bsdf;
        if !bsdf.has_density() {
            return Self::One(Lobe::Specular);
        }
        let glossy = bsdf.glossy_part().filter(Bsdf::has_density);
        match glossy {
            None => Self::One(Lobe::Diffuse),
            Some(_) if !bsdf.has_diffuse_part() => Self::One(Lobe::Glossy),
            Some(glossy) => Self::Both(Arc::new(Both {
                bent: Bent::new(vertex.frame, vertex.point.ng),
                all: *bsdf,
                glossy,
            })),
        }
    }

    /// What scatters light that comes from `to_light` towards `to_eye`, both unit and away from the
    /// surface: the lobe that has most, and the share of the glossy one. Shares are the same
    /// whichever end the path was walked from.
    pub(crate) fn share(&self, to_eye: Vec3, to_light: Vec3) -> (Lobe, Rgb) {
        let both = match self {
            Self::One(Lobe::Glossy) => return (Lobe::Glossy, Rgb::WHITE),
            Self::One(lobe) => return (*lobe, Rgb::BLACK),
            Self::Both(both) => both,
        };
        let f_cos = |bsdf: &Bsdf| {
            let mode = TransportMode::Radiance;
            let found = both.bent.f_cos_and_pdf_w(bsdf, to_eye, to_light, mode);
            found.map_or(Rgb::BLACK, |(f_cos, _)| f_cos)
        };
        let share = f_cos(&both.glossy).over(f_cos(&both.all));
        let share = share.map(|share| share.clamp(0.0, 1.0));
        let is_glossy = share.mean() > 0.5;
        (
            if is_glossy {
                Lobe::Glossy
            } else {
                Lobe::Diffuse
            },
            share,
        )
    }

    /// The lobe of a surface that has one; of several, the diffuse one, which sees most.
    pub(crate) fn main(&self) -> Lobe {
        match self {
            Self::One(lobe) => *lobe,
            Self::Both(_) => Lobe::Diffuse,
        }
    }
}
