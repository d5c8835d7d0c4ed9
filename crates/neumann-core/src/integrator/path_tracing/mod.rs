//! Path tracing in four steps, each the last one plus one idea.
//!
//! [`naive`] is the slide's pseudo-code; [`bsdf`] draws directions from the BSDF;
//! [`nee`] also aims at the lights; [`mis`] weighs both and ends paths by chance.

pub mod bsdf;
pub mod mis;
pub mod naive;
pub mod nee;

use crate::film::{Contribution, Strategy};
use crate::pass::Gather;
use crate::radiometry::Rgb;
use crate::transport::{SurfaceVertex, Tracer};

/// Light found by running into an emitter after `bounce` scattering events.
#[inline]
pub(super) fn hit(bounce: u32, value: Rgb, mis_weight: f32) -> Contribution {
    Contribution {
        value,
        mis_weight,
        bounce,
        strategy: Strategy::hit(bounce as u16 + 2),
    }
}

/// Light found by aiming at an emitter from the vertex reached after `bounce - 1` scattering
/// events.
#[inline]
pub(super) fn connect(bounce: u32, value: Rgb, mis_weight: f32) -> Contribution {
    Contribution {
        value,
        mis_weight,
        bounce,
        strategy: Strategy::connect(1, bounce as u16 + 1),
    }
}

/// What an unlit surface shows where the camera sees it directly.
#[inline]
pub(super) fn add_unlit(tracer: &Tracer<'_>, vertex: &SurfaceVertex<'_>, sink: &mut impl Gather) {
    if vertex.material.is_unlit() {
        sink.gather(hit(0, tracer.unlit(vertex), 1.0));
    }
}
