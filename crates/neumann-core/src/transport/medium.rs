//! What is between two vertices: nothing, or the absorbing inside of a solid.

use super::SurfaceVertex;
use crate::radiometry::Rgb;

/// The space that a segment of a path runs through.
#[derive(Clone, Copy, Debug, Default)]
pub struct Medium {
    absorption: Option<Rgb>,
}

impl Medium {
    /// What is around the camera and the lights.
    pub const VACUUM: Self = Self { absorption: None };

    /// The space on the side of `wi` (world) of a vertex that was reached through `self`.
    ///
    /// Only surfaces with a volume have an inside; any other leaves the medium as it was.
    #[inline]
    #[must_use]
    pub fn beyond(self, vertex: &SurfaceVertex<'_>, wi: glam::Vec3) -> Self {
        match vertex.material.absorption() {
            None => self,
            Some(absorption) => Self {
                absorption: (vertex.point.ng.dot(wi) < 0.0).then_some(absorption),
            },
        }
    }

    /// True where nothing is absorbed.
    #[inline]
    #[must_use]
    pub fn is_vacuum(self) -> bool {
        self.absorption.is_none()
    }

    /// Share of light that is left after `distance` metres (Beer and Lambert).
    #[inline]
    #[must_use]
    pub fn transmittance(self, distance: f32) -> Rgb {
        match self.absorption {
            None => Rgb::WHITE,
            Some(absorption) => {
                absorption.map(|a| if a > 0.0 { (-a * distance).exp() } else { 1.0 })
            }
        }
    }
}
