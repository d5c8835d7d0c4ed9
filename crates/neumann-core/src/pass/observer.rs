//! Who looks at the paths by which light comes to pixels: writes some of them down, or tells what
//! class each is of.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::whole_path::WholePath;
use crate::film::{ClassRecord, ClassShape, Contribution, Joint, PathClasses};
use crate::radiometry::Rgb;
use crate::transport::{Bounce, PathVertex, Scattered, SharedTrail, Source, Trail, WantedPaths};

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
        self.whole().into_vertices()
    }

    /// What the light comes from.
    #[must_use]
    pub fn source(&self) -> Option<Source> {
        self.whole().source()
    }

    /// What happens between the eye and the light.
    #[must_use]
    pub fn scattered(&self) -> Vec<Scattered> {
        self.whole().scattered().collect()
    }

    /// The same, with the lobe that has most of each.
    #[must_use]
    pub fn bounces(&self) -> Vec<Bounce> {
        self.whole().scattered().map(|s| s.bounce).collect()
    }

    fn whole(&self) -> WholePath<'_> {
        let strategy = self.contribution.strategy;
        WholePath::new(strategy, self.camera.iter(), self.light.iter())
    }
}

/// What is looked at.
#[derive(Clone, Debug)]
pub(crate) enum Plan {
    /// The paths of some pixels.
    Replay(ReplayPlan),
    /// The classes of all paths.
    Classify(ClassPlan),
}

/// What a replay looks at.
#[derive(Clone, Debug, Default)]
pub(crate) struct ReplayPlan {
    /// Columns and rows of the pixels.
    pub(crate) pixels: Arc<HashSet<[u32; 2]>>,
    /// Whether no other pixel needs to be traced.
    pub(crate) only_these: bool,
    /// Light paths to be kept whole.
    pub(crate) light_paths: Arc<HashSet<u32>>,
}

/// What classes are told apart.
#[derive(Clone, Debug)]
pub(crate) struct ClassPlan {
    pub(crate) classes: Arc<PathClasses>,
    pub(crate) shape: ClassShape,
    /// The light paths that others are joined to.
    pub(crate) light_paths: Arc<LightPathsSeen>,
}

/// Light paths by their numbers, from the light on.
pub(crate) type LightPathsSeen = HashMap<u32, Vec<PathVertex>>;

/// Looks at what arrives at a sink.
pub(crate) struct Observer {
    trail: SharedTrail,
    /// The light path that camera vertices are connected to,
    joined: Option<u32>,
    /// and the one that a camera vertex is merged with.
    merged: Option<u32>,
    task: Task,
}

/// What an observer does.
enum Task {
    /// Writes down the paths of some pixels.
    Replay {
        pixels: Arc<HashSet<[u32; 2]>>,
        found: Vec<Found>,
    },
    /// Tells the classes of all paths.
    Classify {
        plan: ClassPlan,
        /// Whether light paths are handed on to later tasks.
        hands_on: bool,
        row: Vec<Scattered>,
        records: Vec<ClassRecord>,
    },
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
    pub(crate) light_paths: LightPathsSeen,
    pub(crate) records: Vec<ClassRecord>,
}

impl Plan {
    /// The trail of a task, and who observes it; `hands_on` if paths of later tasks may be joined
    /// to light paths of this one.
    pub(crate) fn observer(&self, hands_on: bool) -> (SharedTrail, Observer) {
        let (wanted, task) = match self {
            Self::Replay(plan) => (
                WantedPaths::These(Arc::clone(&plan.light_paths)),
                Task::Replay {
                    pixels: Arc::clone(&plan.pixels),
                    found: Vec::new(),
                },
            ),
            Self::Classify(plan) => (
                WantedPaths::All,
                Task::Classify {
                    plan: plan.clone(),
                    hands_on,
                    row: Vec::new(),
                    records: Vec::new(),
                },
            ),
        };
        let trail = SharedTrail::new(Trail::keeping(wanted).into());
        let observer = Observer {
            trail: SharedTrail::clone(&trail),
            joined: None,
            merged: None,
            task,
        };
        (trail, observer)
    }

    /// The pixels that need to be traced, if not all do.
    pub(crate) fn only(&self) -> Option<&HashSet<[u32; 2]>> {
        match self {
            Self::Replay(plan) if plan.only_these => Some(&plan.pixels),
            _ => None,
        }
    }

    /// Later paths are joined to these, if it needs to know them beforehand.
    pub(crate) fn joins(&mut self, light_paths: &mut LightPathsSeen) {
        if let Self::Classify(plan) = self {
            plan.light_paths = Arc::new(std::mem::take(light_paths));
        }
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
        let strategy = contribution.strategy;
        let light_path = match strategy.joint {
            Joint::Merge => self.merged,
            Joint::Connect if strategy.s > 1 => self.joined,
            _ => None,
        };
        let trail = self.trail.borrow();
        let walked = trail.so_far();
        let is_sky = strategy.s == 0 && walked.len() + 1 == usize::from(strategy.t);
        match &mut self.task {
            Task::Replay { pixels, found } if pixels.contains(&pixel) => {
                let (mut camera, aim) = trail.vertices_and_aim();
                if is_sky {
                    camera = trail.vertices_to_sky();
                }
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
                found.push(Found {
                    pixel,
                    replayed,
                    light_path,
                });
            }
            Task::Replay { .. } => {}
            Task::Classify {
                plan, row, records, ..
            } => {
                let sky = is_sky.then(|| trail.sky());
                let camera = walked.iter().chain(&sky);
                // Of an earlier task, or of this one.
                let known = |path| plan.light_paths.get(&path).or_else(|| trail.kept(path));
                let path = match light_path.and_then(known) {
                    Some(light) => {
                        let s = usize::from(strategy.s).min(light.len());
                        WholePath::new(strategy, camera, light[..s].iter())
                    }
                    None => {
                        let aim = trail.aim().filter(|_| strategy.s == 1);
                        WholePath::new(strategy, camera, aim.into_iter())
                    }
                };
                let sources = if strategy.s == 0 {
                    trail.sources()
                } else {
                    &[]
                };
                plan.record(
                    pixel,
                    (&contribution, share),
                    (&path, sources),
                    row,
                    records,
                );
            }
        }
    }

    /// A contribution of a light path to a pixel.
    pub(crate) fn splat(&mut self, pixel: [u32; 2], contribution: Contribution, share: f32) {
        let trail = self.trail.borrow();
        let strategy = contribution.strategy;
        match &mut self.task {
            Task::Replay { pixels, found } if pixels.contains(&pixel) => {
                let (mut light, aim) = trail.vertices_and_aim();
                let (mut camera, lens) = (Vec::new(), aim);
                if strategy.t == 0 {
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
                found.push(Found {
                    pixel,
                    replayed,
                    light_path: None,
                });
            }
            Task::Replay { .. } => {}
            Task::Classify {
                plan, row, records, ..
            } => {
                // The lens is the first vertex from the eye, however it was met.
                let path = WholePath::new(strategy, trail.aim().into_iter(), trail.so_far().iter());
                plan.record(pixel, (&contribution, share), (&path, &[]), row, records);
            }
        }
    }

    /// All that it has seen.
    pub(crate) fn into_seen(self) -> Seen {
        let light_paths = self.trail.take().into_kept();
        match self.task {
            Task::Replay { found, .. } => Seen {
                found,
                light_paths,
                ..Seen::default()
            },
            Task::Classify {
                hands_on, records, ..
            } => Seen {
                light_paths: if hands_on {
                    light_paths
                } else {
                    LightPathsSeen::default()
                },
                records,
                ..Seen::default()
            },
        }
    }
}

impl ClassPlan {
    /// What a path adds to the layers of a pixel, whose light has come from several sources, each
    /// with its part, if there are any.
    fn record(
        &self,
        pixel: [u32; 2],
        (contribution, share): (&Contribution, f32),
        (path, sources): (&WholePath<'_>, &[(Source, Rgb)]),
        row: &mut Vec<Scattered>,
        records: &mut Vec<ClassRecord>,
    ) {
        row.clear();
        row.extend(path.scattered());
        let value = contribution.value * (contribution.mis_weight * share);
        let mut add = |source, value| {
            let of_path = (contribution.bounce, row.as_slice(), source);
            let (shape, classes) = (self.shape, &*self.classes);
            shape.record(classes, pixel, of_path, value, records);
        };
        if sources.is_empty() {
            add(path.source(), value);
            return;
        }
        let sum = sources
            .iter()
            .fold(Rgb::BLACK, |sum, (_, part)| sum + *part);
        for (source, part) in sources {
            add(Some(*source), value * part.over(sum));
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
