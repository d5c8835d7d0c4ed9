//! What happens to light between its source and the eye.

use super::{Lobe, PathVertex};

/// Light is scattered at a vertex of a whole path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bounce {
    /// What scatters.
    pub lobe: Lobe,
    /// True if the path goes on at the other side of the surface.
    pub is_transmission: bool,
    /// Index of the material.
    pub material: Option<u32>,
}

impl Bounce {
    /// What happens at the middle one of three vertices that follow each other.
    #[must_use]
    pub fn new([before, at, after]: [&PathVertex; 3]) -> Self {
        let walked = at.event.map(|event| (event.lobe, event.is_transmission));
        // Where two parts were joined, neither has gone on.
        let joined = || {
            let sides = [before, after].map(|other| other.direction_from(at).dot(at.ng));
            (at.lobe.unwrap_or(Lobe::Diffuse), sides[0] * sides[1] < 0.0)
        };
        let (lobe, is_transmission) = walked.unwrap_or_else(joined);
        Self {
            lobe,
            is_transmission,
            material: at.material,
        }
    }
}
