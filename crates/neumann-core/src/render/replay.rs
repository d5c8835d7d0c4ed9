//! One iteration once more, to see by which paths light has come to some pixels.
//!
//! Random numbers belong to paths, so any path can be walked again. A replay runs the iteration with
//! paths that walk alone, and an [`Observer`] at each sink writes down what arrives at the pixels
//! that are asked for, with the path that brought it. Where a camera path is joined to light paths,
//! these are known after that; a second run keeps them whole. Methods whose paths add to their own
//! pixel alone walk the paths of those pixels only.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use super::renderer::Renderer;
use super::{CancelToken, Cancelled};
use crate::film::{Contribution, Joint};
use crate::radiometry::Rgb;
use crate::transport::{PathVertex, SharedTrail, Trail};

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
}

/// What a replay looks at.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    /// Columns and rows of the pixels.
    pub(super) pixels: Arc<HashSet<[u32; 2]>>,
    /// Whether no other pixel needs to be traced.
    pub(super) only_these: bool,
    /// Light paths to be kept whole.
    pub(super) light_paths: Arc<HashSet<u32>>,
}

/// Writes down what arrives at a sink.
pub(super) struct Observer {
    trail: SharedTrail,
    pixels: Arc<HashSet<[u32; 2]>>,
    /// The light path that camera vertices are connected to,
    joined: Option<u32>,
    /// and the one that a camera vertex is merged with.
    merged: Option<u32>,
    found: Vec<Found>,
}

/// A contribution as an observer has seen it: the light path is known by its number only.
pub(super) struct Found {
    pixel: [u32; 2],
    replayed: Replayed,
    light_path: Option<u32>,
}

/// What the observers of an iteration have seen.
#[derive(Default)]
pub(super) struct Seen {
    found: Vec<Found>,
    light_paths: HashMap<u32, Vec<PathVertex>>,
}

impl Plan {
    /// The trail of a task, and who observes it.
    pub(super) fn observer(&self) -> (SharedTrail, Observer) {
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
    pub(super) fn joins(&mut self, path: u32) {
        self.joined = Some(path);
    }

    /// The light path that the next merge is with.
    pub(super) fn merges(&mut self, path: u32) {
        self.merged = Some(path);
    }

    /// A contribution of a camera path to its pixel.
    pub(super) fn add(&mut self, pixel: [u32; 2], contribution: Contribution, share: f32) {
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
    pub(super) fn splat(&mut self, pixel: [u32; 2], contribution: Contribution, share: f32) {
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
    pub(super) fn into_seen(self) -> Seen {
        Seen {
            found: self.found,
            light_paths: self.trail.take().into_kept(),
        }
    }
}

impl Seen {
    /// Adds what later tasks have seen.
    pub(super) fn extend(&mut self, later: Self) {
        self.found.extend(later.found);
        self.light_paths.extend(later.light_paths);
    }
}

impl Renderer {
    /// Every contribution that an iteration makes to some pixels (columns and rows), with its
    /// path; for each pixel, in the order in which they are added.
    ///
    /// The sum over a pixel's contributions of a bounce is the value that the iteration has there:
    /// to the bit for methods whose paths add to their own pixel alone, but for rounding for the
    /// others. Takes one or two iterations' time, of paths that walk one by one.
    ///
    /// # Errors
    /// [`Cancelled`] when the token was.
    pub fn replay(
        &self,
        iteration: u32,
        pixels: &[[u32; 2]],
        cancel: &CancelToken,
    ) -> Result<Vec<Vec<Replayed>>, Cancelled> {
        let mut plan = Plan {
            pixels: Arc::new(pixels.iter().copied().collect()),
            ..Plan::default()
        };
        let mut seen = self.observe(iteration, &plan, cancel)?;
        let joined: HashSet<u32> = seen.found.iter().filter_map(|f| f.light_path).collect();
        if !joined.is_empty() {
            plan.light_paths = Arc::new(joined);
            seen = self.observe(iteration, &plan, cancel)?;
        }
        let mut of_pixel: HashMap<[u32; 2], Vec<Replayed>> = HashMap::new();
        for found in seen.found {
            let mut replayed = found.replayed;
            if let Some(light) = found
                .light_path
                .and_then(|path| seen.light_paths.get(&path))
            {
                replayed.light.extend(light.iter().copied());
                replayed
                    .light
                    .truncate(usize::from(replayed.contribution.strategy.s));
                if let Some(last) = replayed.light.last_mut() {
                    last.event = None;
                }
            }
            of_pixel.entry(found.pixel).or_default().push(replayed);
        }
        let of = |pixel| {
            let mut of_pixel = of_pixel.get(pixel).cloned().unwrap_or_default();
            number_samples(&mut of_pixel);
            of_pixel
        };
        Ok(pixels.iter().map(of).collect())
    }
}

/// Numbers the camera paths of a pixel from 0.
fn number_samples(of_pixel: &mut [Replayed]) {
    let starts: BTreeSet<u32> = of_pixel
        .iter()
        .filter_map(|replayed| match replayed.camera_path {
            Some(PathId::Camera { sample, .. }) => Some(sample),
            _ => None,
        })
        .collect();
    for replayed in of_pixel {
        if let Some(PathId::Camera { sample, .. }) = &mut replayed.camera_path {
            *sample = starts.range(..*sample).count() as u32;
        }
    }
}
