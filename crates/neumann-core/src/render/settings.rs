//! What determines the picture. A change of any of it restarts rendering; how the
//! picture is looked at is no part of it.

use crate::film::DEFAULT_LAYERS;
use crate::integrator::{DEFAULT_METHOD, METHODS, Method, ParameterValues, method};
use crate::pass::PassNumbers;
use crate::scene::description::CameraDescription;

/// Scene aside, everything that determines the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// The method.
    pub method: &'static Method,
    /// Its parameters.
    pub values: ParameterValues,
    /// The camera.
    pub camera: CameraDescription,
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Terms with `k` up to and including this one are computed.
    pub max_bounces: u32,
    /// Bounce layers kept apart, the tail not counted.
    pub n_layers: usize,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl RenderSettings {
    /// Default method, depth and layers for a camera and a size.
    #[must_use]
    pub fn new(camera: CameraDescription, width: usize, height: usize) -> Self {
        let method = method(DEFAULT_METHOD).unwrap_or(METHODS[0]);
        Self {
            method,
            values: ParameterValues::defaults(method.parameters),
            camera,
            width,
            height,
            max_bounces: 16,
            n_layers: DEFAULT_LAYERS,
            seed: 0,
        }
    }

    /// What the paths of an iteration depend on.
    pub(super) fn numbers(&self, iteration: u32) -> PassNumbers {
        PassNumbers {
            max_bounces: self.max_bounces,
            seed: self.seed,
            iteration,
        }
    }
}
