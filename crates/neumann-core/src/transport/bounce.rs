//! What happens to light between its source and the eye.

use super::{Lobe, PathVertex};
use crate::radiometry::Rgb;

/// Light is scattered at a vertex of a whole path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bounce {
    /// What scatters; of several lobes, the one that scatters most.
    pub lobe: Lobe,
    /// True if the path goes on at the other side of the surface.
    pub is_transmission: bool,
    /// Index of the material.
    pub material: Option<u32>,
}

/// A bounce, shared out among the lobes that scatter the same way.
///
/// A BSDF is a sum of lobes, and so is what a path brings by way of it. A diffuse base under a
/// glossy coat scatters by both at once, whichever of them has drawn the direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered {
    /// What the lobes have in common, and which of them scatters most.
    pub bounce: Bounce,
    /// Share of the glossy lobe, in [0, 1] per channel; the diffuse one has the rest. 0 for a
    /// specular bounce.
    pub glossy: Rgb,
}

impl Scattered {
    /// By one lobe alone.
    #[must_use]
    pub fn by_one(bounce: Bounce) -> Self {
        let is_glossy = bounce.lobe == Lobe::Glossy;
        Self {
            bounce,
            glossy: Rgb::splat(f32::from(u8::from(is_glossy))),
        }
    }

    /// What happens at a vertex that a path was walked through.
    pub(crate) fn walked(at: &PathVertex) -> Option<Self> {
        let event = at.event?;
        Some(Self {
            bounce: Bounce {
                lobe: event.lobe,
                is_transmission: event.is_transmission,
                material: at.material,
            },
            glossy: event.glossy,
        })
    }

    /// What happens at the middle one of three vertices, seen from the eye, where the path was
    /// joined to another one.
    pub(crate) fn joined(before: &PathVertex, at: &PathVertex, after: &PathVertex) -> Self {
        let towards = |other: &PathVertex| other.direction_from(at).normalize_or_zero();
        let (to_eye, to_light) = (towards(before), towards(after));
        let (lobe, glossy) = at.lobes.as_ref().map_or_else(
            || (Lobe::Diffuse, Rgb::BLACK),
            |lobes| lobes.share(to_eye, to_light),
        );
        Self {
            bounce: Bounce {
                lobe,
                is_transmission: to_eye.dot(at.ng) * to_light.dot(at.ng) < 0.0,
                material: at.material,
            },
            glossy,
        }
    }

    /// The lobes that scatter, each with its share.
    pub fn lobes(&self) -> impl Iterator<Item = (Lobe, Rgb)> {
        let shares = match self.bounce.lobe {
            Lobe::Specular => [(Lobe::Specular, Rgb::WHITE), (Lobe::Glossy, Rgb::BLACK)],
            _ => [
                (Lobe::Diffuse, Rgb::WHITE - self.glossy),
                (Lobe::Glossy, self.glossy),
            ],
        };
        shares.into_iter().filter(|(_, share)| !share.is_black())
    }
}
