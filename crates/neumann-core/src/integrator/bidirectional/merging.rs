//! Vertices of light subpaths merged with one of a camera subpath, as if they were at the same
//! point.

use glam::Vec3;

use super::light::LightVertex;
use super::{MisWeights, Partial, Vertex};
use crate::film::{Contribution, Strategy};
use crate::pass::{Collected, Sink};
use crate::photons::{HashGrid, Near, Photon, Placed};

/// A light vertex as merging needs it: one line of a processor's cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(in crate::integrator) struct Mergeable {
    photon: Photon,
    d_vcm: f32,
    d_vm: f32,
}

/// The light vertices of an iteration, found by place.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Merging<'a> {
    grid: &'a HashGrid<Mergeable>,
    /// What it was filled with.
    paths: &'a Collected<LightVertex>,
    /// One over the area of the disk in which vertices are merged, and over the number of light
    /// subpaths, 1/m².
    per_merge: f32,
}

impl Mergeable {
    pub(in crate::integrator) fn of(vertex: &LightVertex) -> Self {
        Self {
            photon: vertex.photon,
            d_vcm: vertex.partial.d_vcm,
            d_vm: vertex.partial.d_vm,
        }
    }

    /// The quantities that merging needs.
    #[inline]
    fn partial(&self) -> Partial {
        Partial {
            d_vcm: self.d_vcm,
            d_vc: 0.0,
            d_vm: self.d_vm,
        }
    }
}

impl Placed for Mergeable {
    #[inline]
    fn position(&self) -> Vec3 {
        self.photon.position
    }
}

impl<'a> Merging<'a> {
    /// Merges vertices of light subpaths within `radius`, metres.
    pub(in crate::integrator) fn new(
        grid: &'a HashGrid<Mergeable>,
        paths: &'a Collected<LightVertex>,
        radius: f32,
    ) -> Self {
        let n_paths = paths.n_paths() as f32;
        Self {
            grid,
            paths,
            per_merge: std::f32::consts::FRAC_1_PI / (radius * radius * n_paths),
        }
    }

    /// The index to search.
    #[inline]
    pub(super) fn grid(&self) -> &'a HashGrid<Mergeable> {
        self.grid
    }

    /// Merges a camera vertex with those that are near it, as far as that makes a path short
    /// enough.
    pub(super) fn merge(
        &self,
        vertex: &Vertex<'_>,
        near: &[Near],
        max_bounces: u32,
        weighing: &MisWeights,
        sink: &mut Sink<'_>,
    ) {
        for found in near {
            let light = &self.grid.entries()[found.number as usize];
            let strategy = Strategy::merge(light.photon.n_vertices, vertex.n_vertices);
            if strategy.bounce() > max_bounces {
                continue;
            }
            let Some(scattered) = light.photon.scattered(&vertex.surface) else {
                continue;
            };
            if sink.is_observed() {
                let item = self.grid.item_of(found.number);
                sink.merges(self.paths.path_of(item));
            }
            sink.add(Contribution {
                value: vertex.throughput * scattered.f_power * self.per_merge,
                mis_weight: weighing.merge(
                    vertex.partial,
                    light.partial(),
                    scattered.scattering.pdf_w_forward,
                    scattered.scattering.pdf_w_reverse,
                ),
                bounce: strategy.bounce(),
                strategy,
            });
        }
    }
}
