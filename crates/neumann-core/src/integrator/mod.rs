//! How we guess the sum: the contract of an integrator, and the registry.
//!
//! To add one: write a file here with its `METHOD` row, add a `mod` line and
//! an entry to [`METHODS`]. Menus, command line and tests follow.

pub mod bdpt;
pub mod bidirectional;
mod distributed;
mod lanes;
pub mod light_tracing;
mod parameter;
pub mod path_tracing;
pub mod photon_mapping;
mod radius;
mod shade;
pub mod vcm;

pub use parameter::{
    Parameter, ParameterError, ParameterKind, ParameterValues, Value, parameter_name,
};
pub use radius::Radius;

use crate::pass::{Cancelled, Pass};
use crate::scene::Scene;

/// Turns a scene into contributions, one complete estimate of the image at a time.
pub trait Integrator: Send {
    /// Adds one complete estimate of the image, or stops early when cancelled.
    ///
    /// # Errors
    /// [`Cancelled`] when the pass was told to stop.
    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled>;

    /// True if the next iteration is one call that traces the pixels, whose paths add to no other pixel than their own: what a tile comes to
    /// is known then as soon as it has been traced, and goes into the film while it is at hand. The pass leaves the frame black.
    fn traces_only_pixels(&self) -> bool {
        false
    }

    /// True if the error of the mean shows in how iterations differ. It does not where they have
    /// random numbers in common.
    fn shows_its_error(&self) -> bool {
        true
    }
}

/// One row of the registry: everything that menus, command line, README and tests need to know.
pub struct Method {
    /// Name on the command line.
    pub id: &'static str,
    /// Name in a menu, short.
    pub title: &'static str,
    /// Full name, as a heading.
    pub name: &'static str,
    /// What it is, a sentence or two.
    pub about: &'static str,
    /// What it cannot see, one sentence; empty if it sees everything.
    pub blind_spots: &'static str,
    /// The same as facts that tests rely on.
    pub sight: Sight,
    /// Why its expectation differs from L; `None` for an unbiased method.
    pub bias: Option<&'static str>,
    /// Whether its paths are made by several techniques (s, t), which a [`TechniqueFilm`](crate::film::TechniqueFilm) keeps apart.
    pub has_techniques: bool,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// Makes an integrator with the given parameter values.
    pub build: fn(&ParameterValues) -> Box<dyn Integrator>,
}

/// What a method can see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sight {
    /// Light from point, spot and directional lights.
    pub punctual_lights: bool,
    /// Light by way of mirrors and smooth glass.
    pub delta_surfaces: bool,
    /// Mirrors and smooth glass that the camera sees directly.
    pub delta_to_camera: bool,
    /// On diffuse surfaces alone, the highest bounce that it computes; `None` for no limit.
    pub diffuse_bounces: Option<u32>,
    /// Shadows.
    pub shadows: bool,
}

impl Sight {
    /// Everything.
    pub const FULL: Self = Self {
        punctual_lights: true,
        delta_surfaces: true,
        delta_to_camera: true,
        diffuse_bounces: None,
        shadows: true,
    };
}

impl std::fmt::Debug for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Method").field(&self.id).finish()
    }
}

impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

/// All methods, in lecture order.
pub static METHODS: &[&Method] = &[
    &path_tracing::naive::METHOD,
    &path_tracing::bsdf::METHOD,
    &path_tracing::nee::METHOD,
    &path_tracing::mis::METHOD,
    &distributed::METHOD,
    &shade::METHOD,
    &light_tracing::METHOD,
    &bdpt::METHOD,
    &photon_mapping::METHOD,
    &photon_mapping::PROGRESSIVE,
    &vcm::METHOD,
];

/// The method where nothing else is asked for.
pub const DEFAULT_METHOD: &str = "pt-mis";

/// The method with the given id.
#[must_use]
pub fn method(id: &str) -> Option<&'static Method> {
    METHODS.iter().copied().find(|m| m.id == id)
}
