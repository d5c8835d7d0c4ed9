//! How we guess the sum: the contract of an integrator, and the registry.
//!
//! To add one: write a file here with its `METHOD` row, add a `mod` line and
//! an entry to [`METHODS`]. Menus, command line and tests follow.

mod parameter;

pub use parameter::{Parameter, ParameterError, ParameterKind, ParameterValues, Value};

use crate::render::{Cancelled, Pass};
use crate::scene::Scene;

/// Turns a scene into contributions, one complete estimate of the image at a time.
pub trait Integrator: Send {
    /// Adds one complete estimate of the image, or stops early when cancelled.
    ///
    /// # Errors
    /// [`Cancelled`] when the pass was told to stop.
    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled>;
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
    /// Why its expectation differs from L; `None` for an unbiased method.
    pub bias: Option<&'static str>,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// Makes an integrator with the given parameter values.
    pub build: fn(&ParameterValues) -> Box<dyn Integrator>,
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
pub static METHODS: &[&Method] = &[];

/// The method where nothing else is asked for.
pub const DEFAULT_METHOD: &str = "pt-mis";

/// The method with the given id.
#[must_use]
pub fn method(id: &str) -> Option<&'static Method> {
    METHODS.iter().copied().find(|m| m.id == id)
}
