//! The paths of a pixel that are listed: of a bounce, of a technique, of a kind.

use neumann_core::expression::{Expression, ExpressionError};
use neumann_core::film::{Strategy, View as Part};
use neumann_core::render::{Inspection, Job, PathId, Replayed};

/// Paths that are drawn, at most.
const N_DRAWN: usize = 256;

/// Which paths are listed, and which of them is chosen.
#[derive(Default)]
pub struct List {
    /// The light path expression as it is typed; empty for all.
    pub only: String,
    /// The technique, if it is of one only.
    pub technique: Option<Strategy>,
    /// The vertex of the chosen path that is looked at, from the eye on.
    pub vertex: usize,
    /// The chosen path is to be scrolled to.
    pub(super) reveals: bool,
    /// The path that brings most is the chosen one, until another one is chosen.
    pub(super) follows_first: bool,
    /// Indices into the paths of the inspection, those that bring most first.
    rows: Vec<usize>,
    chosen: Option<Name>,
    made: Option<Made>,
    read: Option<Result<Expression, ExpressionError>>,
    /// The share of the pixel that all ways of the expression have.
    share: Option<f64>,
}

/// What tells a path from others.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Name {
    iteration: u32,
    strategy: Strategy,
    paths: [Option<PathId>; 2],
}

impl Name {
    fn of((iteration, path): &(u32, Replayed)) -> Self {
        Self {
            iteration: *iteration,
            strategy: path.contribution.strategy,
            paths: [path.camera_path, path.light_path],
        }
    }
}

/// What the rows were made of.
#[derive(Clone, Debug, PartialEq)]
struct Made {
    n_iterations: u32,
    part: Part,
    technique: Option<Strategy>,
    only: String,
}

impl List {
    /// There is nothing to list.
    pub(super) fn forget(&mut self) {
        self.rows.clear();
        self.chosen = None;
        self.made = None;
        self.share = None;
        self.vertex = 0;
        self.follows_first = false;
    }

    /// Lists what there is now.
    pub(super) fn follow(&mut self, found: &Inspection, job: &Job, part: Part) {
        let made = Made {
            n_iterations: found.n_iterations(),
            part,
            technique: self.technique,
            only: self.only.clone(),
        };
        if self.made.as_ref() == Some(&made) {
            return;
        }
        let text = self.only.trim();
        self.read = (!text.is_empty()).then(|| Expression::new(text, &job.scene));
        let only = self.read.as_ref().and_then(|read| read.as_ref().ok());
        let n_layers = job.settings.n_layers;
        let layers = part.layers(n_layers).unwrap_or(0..n_layers + 1);
        let fits = |path: &Replayed| {
            let contribution = &path.contribution;
            let layer = (contribution.bounce as usize).min(n_layers);
            layers.contains(&layer)
                && self.technique.is_none_or(|of| of == contribution.strategy)
                && only.is_none_or(|only| !only.share(&path.scattered(), path.source()).is_black())
        };
        let paths = found.paths().iter().enumerate();
        self.rows = paths
            .filter(|(_, (_, path))| fits(path))
            .map(|(i, _)| i)
            .collect();
        let total = f64::from(found.total().mean.luminance());
        self.share = only.filter(|_| total > 0.0).map(|only| {
            let ways = found.ways();
            let of_kind = ways
                .iter()
                .filter(|way| only.matches(way.bounces, way.source));
            of_kind.map(|way| way.luminance).sum::<f64>() / total
        });
        self.made = Some(made);
        if self.follows_first {
            let first = self.rows.first().and_then(|i| found.paths().get(*i));
            self.chosen = first.map(Name::of);
        }
    }

    /// Why the expression is none, if it is none.
    pub(super) fn error(&self) -> Option<&ExpressionError> {
        self.read.as_ref()?.as_ref().err()
    }

    /// The share of the pixel that the expression stands for.
    pub(super) fn share(&self) -> Option<f64> {
        self.share
    }

    /// How many are listed.
    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Those that are listed, and whether each is the chosen one.
    pub(super) fn rows<'a>(
        &'a self,
        found: &'a Inspection,
    ) -> impl Iterator<Item = (&'a (u32, Replayed), bool)> {
        let rows = self.rows.iter().filter_map(|i| found.paths().get(*i));
        rows.map(|path| (path, self.chosen == Some(Name::of(path))))
    }

    /// The one that brings most.
    pub(super) fn first<'a>(&self, found: &'a Inspection) -> Option<&'a Replayed> {
        Some(&found.paths().get(*self.rows.first()?)?.1)
    }

    /// Those that are drawn.
    pub(super) fn drawn<'a>(
        &'a self,
        found: &'a Inspection,
    ) -> impl DoubleEndedIterator<Item = &'a Replayed> {
        let rows = self.rows[..self.rows.len().min(N_DRAWN)].iter();
        rows.filter_map(|i| found.paths().get(*i))
            .map(|(_, path)| path)
    }

    /// The chosen one.
    pub(super) fn chosen<'a>(&self, found: &'a Inspection) -> Option<&'a Replayed> {
        let name = self.chosen?;
        let mut paths = found.paths().iter();
        paths
            .find(|path| Name::of(path) == name)
            .map(|(_, path)| path)
    }

    /// Chooses one, or none if it is chosen already.
    pub(super) fn toggle(&mut self, path: &(u32, Replayed)) {
        let name = Name::of(path);
        self.chosen = (self.chosen != Some(name)).then_some(name);
        self.vertex = 0;
        self.follows_first = false;
    }

    /// Chooses none; false if none was chosen.
    pub(super) fn choose_none(&mut self) -> bool {
        self.follows_first = false;
        self.chosen.take().is_some()
    }

    /// Chooses the path so many rows further.
    pub(super) fn step_path(&mut self, found: &Inspection, step: i64) {
        let names: Vec<Name> = self.rows(found).map(|(path, _)| Name::of(path)).collect();
        let now = self
            .chosen
            .and_then(|name| names.iter().position(|other| *other == name));
        let next = now.map_or(0, |now| now as i64 + step);
        let next = next.clamp(0, names.len().max(1) as i64 - 1) as usize;
        self.chosen = names.get(next).copied();
        self.vertex = 0;
        self.reveals = true;
        self.follows_first = false;
    }

    /// Looks at the vertex so many further along the chosen path.
    pub(super) fn step_vertex(&mut self, found: &Inspection, step: i32) {
        let n = self.chosen(found).map_or(0, |path| path.vertices().len());
        let next = self.vertex as i64 + i64::from(step);
        self.vertex = next.clamp(0, n.max(1) as i64 - 1) as usize;
    }
}
