//! Who writes down by which paths light comes to some pixels.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use crate::film::{Contribution, Joint};
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::{Bounce, PathVertex, SharedTrail, Trail};

/// The name of a path, unique in its iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PathId {
    /// A path from the camera.
    Camera {
        /// Column and row of its pixel.
        pixel: [u32; 2],
        /// Its number among those that start in the pixel.
        sample: u32,
        /// Its number among those that it forks into.
        branch: u32,
    },
    /// A path from a light, by its number.
    Light(u32),
}

/// What one path has brought to a pixel.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// The contribution, before it is divided among the paths of the pixel.
    pub contribution: Contribution,
    /// The share of the pixel that the path has: one over their number.
    pub share: f32,
    /// The path from the camera, if one was walked.
    pub camera_path: Option<PathId>,
    /// The path from a light, if one was walked.
    pub light_path: Option<PathId>,
    /// The camera's part, from the lens on: t vertices. Where light ran into the lens, none.
    pub camera: Vec<PathVertex>,
    /// The light's part, from the light on: s vertices. Where the camera's part ran into a light,
    /// none.
    pub light: Vec<PathVertex>,
}

impl Replayed {
    /// What was added to the pixel, W m⁻² sr⁻¹.
    #[must_use]
    pub fn value(&self) -> Rgb {
        self.contribution.value * (self.contribution.mis_weight * self.share)
    }

    /// All vertices from the eye to the light, those that two parts have in common once.
    #[must_use]
    pub fn vertices(&self) -> Vec<&PathVertex> {
        let is_merge = self.contribution.strategy.joint == Joint::Merge;
        let light = self.light.iter().rev().skip(usize::from(is_merge));
        self.camera.iter().chain(light).collect()
    }

    /// Index of the material that the light is emitted by, if it comes from a surface.
    #[must_use]
    pub fn emitter(&self, scene: &Scene) -> Option<u32> {
        let triangle = self.vertices().last()?.triangle?;
        let geometry = scene.geometry();
        let mesh = geometry.facet(triangle).mesh as usize;
        Some(geometry.meshes().get(mesh)?.material)
    }

    /// What happens between the eye and the light.
    #[must_use]
    pub fn bounces(&self) -> Vec<Bounce> {
        let vertices = self.vertices();
        let triples = vertices.windows(3);
        triples.map(|v| Bounce::new([v[0], v[1], v[2]])).collect()
    }
}

/// What a replay looks at.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    /// Columns and rows of the pixels.
    pub(crate) pixels: Arc<HashSet<[u32; 2]>>,
    /// Whether no other pixel needs to be traced.
    pub(crate) only_these: bool,
    /// Light paths to be kept whole.
    pub(crate) light_paths: Arc<HashSet<u32>>,
}

/// Writes down what arrives at a sink.
pub(crate) struct Observer {
    trail: SharedTrail,
    pixels: Arc<HashSet<[u32; 2]>>,
    /// The light path that camera vertices are connected to,
    joined: Option<u32>,
    /// and the one that a camera vertex is merged with.
    merged: Option<u32>,
    found: Vec<Found>,
}

/// A contribution as an observer has seen it: the light path is known by its number only.
pub(crate) struct Found {
    pub(crate) pixel: [u32; 2],
    pub(crate) replayed: Replayed,
    pub(crate) light_path: Option<u32>,
}

/// What the observers of an iteration have seen.
#[derive(Default)]
pub(crate) struct Seen {
    pub(crate) found: Vec<Found>,
    pub(crate) light_paths: HashMap<u32, Vec<PathVertex>>,
}

impl Plan {
    /// The trail of a task, and who observes it.
    pub(crate) fn observer(&self) -> (SharedTrail, Observer) {
        let trail = SharedTrail::new(Trail::keeping(Arc::clone(&self.light_paths)).into());
        let observer = Observer {
            trail: SharedTrail::clone(&trail),
            pixels: Arc::clone(&self.pixels),
            joined: None,
            merged: None,
            found: Vec::new(),
        };
        (trail, observer)
    }
}

impl Observer {
    /// The light path that connections from now on end at.
    pub(crate) fn joins(&mut self, path: u32) {
        self.joined = Some(path);
    }

    /// The light path that the next merge is with.
    pub(crate) fn merges(&mut self, path: u32) {
        self.merged = Some(path);
    }

    /// A contribution of a camera path to its pixel.
    pub(crate) fn add(&mut self, pixel: [u32; 2], contribution: Contribution, share: f32) {
        if !self.pixels.contains(&pixel) {
            return;
        }
        let trail = self.trail.borrow();
        let strategy = contribution.strategy;
        let (mut camera, aim) = trail.vertices_and_aim();
        if strategy.s == 0 && camera.len() + 1 == usize::from(strategy.t) {
            camera = trail.vertices_to_sky();
        }
        let light_path = match strategy.joint {
            Joint::Merge => self.merged,
            Joint::Connect if strategy.s > 1 => self.joined,
            _ => None,
        };
        let (sample, branch) = trail.camera_path();
        let replayed = Replayed {
            contribution,
            share,
            camera_path: Some(PathId::Camera {
                pixel,
                sample,
                branch,
            }),
            light_path: light_path.map(PathId::Light),
            camera,
            light: aim.into_iter().filter(|_| strategy.s == 1).collect(),
        };
        self.found.push(Found {
            pixel,
            replayed,
            light_path,
        });
    }

    /// A contribution of a light path to a pixel.
    pub(crate) fn splat(&mut self, pixel: [u32; 2], contribution: Contribution, share: f32) {
        if !self.pixels.contains(&pixel) {
            return;
        }
        let trail = self.trail.borrow();
        let (mut light, aim) = trail.vertices_and_aim();
        let (mut camera, lens) = (Vec::new(), aim);
        if contribution.strategy.t == 0 {
            light.extend(lens);
        } else {
            camera.extend(lens);
        }
        let replayed = Replayed {
            contribution,
            share,
            camera_path: None,
            light_path: trail.light_path().map(PathId::Light),
            camera,
            light,
        };
        self.found.push(Found {
            pixel,
            replayed,
            light_path: None,
        });
    }

    /// All that it has seen.
    pub(crate) fn into_seen(self) -> Seen {
        Seen {
            found: self.found,
            light_paths: self.trail.take().into_kept(),
        }
    }
}

impl Seen {
    /// Adds what later tasks have seen.
    pub(crate) fn extend(&mut self, later: Self) {
        self.found.extend(later.found);
        self.light_paths.extend(later.light_paths);
    }
}
