//! A path from the eye to the light, of whatever parts it was made.

use std::ops::Range;

use crate::film::{Joint, Strategy};
use crate::transport::{PathVertex, Scattered, Source};

/// All vertices of a path, from the eye to the light; those that two parts have in common once.
#[derive(Default)]
pub(crate) struct WholePath<'v> {
    vertices: Vec<&'v PathVertex>,
    /// Vertices where a part was joined to another one: neither has gone on from there.
    joined: Range<usize>,
}

impl<'v> WholePath<'v> {
    /// Lays out the parts of a path that a technique has made, each from where it was walked from:
    /// t vertices from the camera, and s vertices from the light.
    pub(crate) fn new(
        strategy: Strategy,
        camera: impl Iterator<Item = &'v PathVertex>,
        light: impl DoubleEndedIterator<Item = &'v PathVertex>,
    ) -> Self {
        let is_merge = strategy.joint == Joint::Merge;
        let vertices: Vec<_> = camera
            .chain(light.rev().skip(usize::from(is_merge)))
            .collect();
        let (t, inner) = (usize::from(strategy.t), 1..vertices.len().max(2) - 1);
        let joined = match strategy.joint {
            Joint::Hit => 0..0,
            Joint::Connect => inner.start.max(t - 1)..inner.end.min(t + 1),
            Joint::Merge => t - 1..t,
        };
        Self { vertices, joined }
    }

    /// What happens between the eye and the light.
    pub(crate) fn scattered(&self) -> impl Iterator<Item = Scattered> {
        let inner = self.vertices.windows(3).zip(1..);
        inner.map(|(around, i)| {
            let [before, at, after] = [around[0], around[1], around[2]];
            let walked = Scattered::walked(at).filter(|_| !self.joined.contains(&i));
            walked.unwrap_or_else(|| Scattered::joined(before, at, after))
        })
    }

    /// What the light comes from.
    pub(crate) fn source(&self) -> Option<Source> {
        self.vertices.last()?.source()
    }

    pub(crate) fn into_vertices(self) -> Vec<&'v PathVertex> {
        self.vertices
    }
}
