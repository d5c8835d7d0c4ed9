//! What a path has gone through, for whoever replays it.
//!
//! A tracer that is observed keeps the vertices of the path under way. A ray that starts at one of
//! them goes on from there, so that paths that fork need no more than this: whatever lay behind is
//! forgotten. Nobody observes most of the time; then a tracer has no trail, and that is all that it
//! asks.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;
use std::sync::Arc;

use glam::Vec3;

use super::{
    Event, Lobe, Lobes, PathVertex, Source, SurfaceVertex, Tracer, VertexKind, VertexSample,
};
use crate::bsdf::TransportMode;
use crate::endpoint::{Aim, Start};
use crate::math::Ray;
use crate::radiometry::Rgb;
use crate::scene::bodies::Media;

/// The path under way.
#[derive(Debug, Default)]
pub(crate) struct Trail {
    vertices: Vec<PathVertex>,
    /// Direction of the latest ray.
    heading: Vec3,
    /// Ways in which the path, or what it forks into, leaves its vertices.
    events: Vec<(usize, Event)>,
    /// What was aimed at last.
    aim: Option<PathVertex>,
    /// Paths that have started at the camera so far,
    n_starts: u32,
    /// and what the latest of them has forked into.
    n_forks: u32,
    /// The number of the light path under way.
    light_path: Option<u32>,
    /// Light paths that are to be kept whole.
    wanted: WantedPaths,
    kept: HashMap<u32, Vec<PathVertex>>,
    /// What the latest ray has got light from, where that is more than one thing.
    sources: Vec<(Source, Rgb)>,
}

/// Light paths that are to be kept whole.
#[derive(Clone, Debug, Default)]
pub(crate) enum WantedPaths {
    /// Those of some numbers.
    These(Arc<HashSet<u32>>),
    /// All of them.
    #[default]
    All,
}

impl WantedPaths {
    fn contains(&self, path: u32) -> bool {
        match self {
            Self::These(paths) => paths.contains(&path),
            Self::All => true,
        }
    }
}

/// A trail that a tracer and a sink have in common.
pub(crate) type SharedTrail = Rc<RefCell<Trail>>;

impl Trail {
    /// Keeps these light paths whole.
    pub(crate) fn keeping(wanted: WantedPaths) -> Self {
        Self {
            wanted,
            ..Self::default()
        }
    }

    /// The vertices so far, as they are: how the last is left may be what it was when it was left
    /// before.
    pub(crate) fn so_far(&self) -> &[PathVertex] {
        &self.vertices
    }

    /// What was aimed at last.
    pub(crate) fn aim(&self) -> Option<&PathVertex> {
        self.aim.as_ref()
    }

    /// What the latest ray has got light from, each with its part, where that is more than one
    /// thing.
    pub(crate) fn sources(&self) -> &[(Source, Rgb)] {
        &self.sources
    }

    /// The end of a path that has left the scene.
    pub(crate) fn sky(&self) -> PathVertex {
        PathVertex {
            source: Some(Source::Environment),
            ..PathVertex::end(VertexKind::FarLight, self.heading, Rgb::WHITE)
        }
    }

    /// The vertices so far; the last has no event.
    pub(crate) fn vertices(&self) -> Vec<PathVertex> {
        let mut vertices = self.vertices.clone();
        if let Some(last) = vertices.last_mut() {
            last.event = None;
        }
        vertices
    }

    /// As [`Self::vertices`], and what was aimed at last.
    pub(crate) fn vertices_and_aim(&self) -> (Vec<PathVertex>, Option<PathVertex>) {
        (self.vertices(), self.aim.clone())
    }

    /// The vertices of a path that has left the scene.
    pub(crate) fn vertices_to_sky(&self) -> Vec<PathVertex> {
        let mut vertices = self.vertices.clone();
        vertices.push(self.sky());
        vertices
    }

    /// Number of the camera path, and of the one that it has forked into.
    pub(crate) fn camera_path(&self) -> (u32, u32) {
        (self.n_starts, self.n_forks)
    }

    /// Number of the light path.
    pub(crate) fn light_path(&self) -> Option<u32> {
        self.light_path
    }

    /// A light path that was kept.
    pub(crate) fn kept(&self, path: u32) -> Option<&Vec<PathVertex>> {
        self.kept.get(&path)
    }

    /// The light paths that were kept.
    pub(crate) fn into_kept(mut self) -> HashMap<u32, Vec<PathVertex>> {
        self.keep();
        self.kept
    }

    /// Ends the path.
    fn keep(&mut self) {
        if let Some(path) = self.light_path.take()
            && self.wanted.contains(path)
        {
            self.kept.insert(path, std::mem::take(&mut self.vertices));
        }
        self.vertices.clear();
        self.events.clear();
        self.aim = None;
    }

    fn start(&mut self, vertex: PathVertex) {
        self.vertices.push(vertex);
    }

    /// Goes on from a vertex at this place.
    fn resume(&mut self, place: Vec3) {
        let at = self.vertices.iter().rposition(|v| v.position == place);
        if let Some(at) = at
            && at + 1 < self.vertices.len()
        {
            self.n_forks += 1;
            self.vertices.truncate(at + 1);
            self.events.retain(|(of, _)| *of <= at);
        }
    }

    /// Follows a ray from where it starts.
    fn follow(&mut self, ray: &Ray) {
        self.resume(ray.origin());
        self.heading = ray.direction();
        self.sources.clear();
        let Some(at) = self.vertices.len().checked_sub(1) else {
            return;
        };
        let mut events = self.events.iter().rev();
        let event = events.find(|(of, event)| *of == at && event.wi == ray.direction());
        self.vertices[at].event = event.map(|(_, event)| *event);
    }
}

impl<'a> Tracer<'a> {
    /// A tracer that keeps a trail.
    pub(crate) fn observed(mut self, trail: Option<SharedTrail>) -> Self {
        self.trail = trail;
        self
    }

    /// What a camera path begins in that starts with a ray.
    #[inline(always)]
    pub fn begin_at_camera(&mut self, ray: &Ray) -> Media {
        if let Some(trail) = &self.trail {
            let mut trail = trail.borrow_mut();
            trail.keep();
            trail.n_starts += 1;
            trail.n_forks = 0;
            trail.start(PathVertex::end(VertexKind::Lens, ray.origin(), Rgb::WHITE));
        }
        self.media_at_camera(ray)
    }

    /// What a light path begins in.
    #[inline(always)]
    pub fn begin_at_light(&mut self, start: &Start) -> Media {
        if let Some(trail) = &self.trail {
            let kind = if start.is_at_infinity() {
                VertexKind::FarLight
            } else {
                VertexKind::Light
            };
            let vertex = PathVertex {
                ng: start.ng,
                triangle: start.on_triangle.map(|(triangle, _)| triangle),
                source: Some(self.source(start.on_triangle.map(|(t, _)| t), start.light)),
                ..PathVertex::end(kind, start.ray().origin(), start.throughput())
            };
            trail.borrow_mut().start(vertex);
        }
        self.media_at_light(start)
    }

    /// Says which light path comes next.
    #[inline(always)]
    pub(crate) fn next_light_path(&mut self, number: u32) {
        if let Some(trail) = &self.trail {
            let mut trail = trail.borrow_mut();
            trail.keep();
            trail.light_path = Some(number);
        }
    }

    /// Says that so many paths go on from the latest vertex in place of one.
    #[inline(always)]
    pub fn splits(&mut self, n: u32) {
        if let Some(trail) = &self.trail
            && let Some(last) = trail.borrow_mut().vertices.last_mut()
        {
            last.n_paths = n;
        }
    }

    /// Says that a path leaves a vertex along a direction that was drawn, if roulette lets it,
    /// which it does with probability `survival`.
    #[inline(always)]
    pub fn leaves(
        &mut self,
        vertex: &SurfaceVertex<'_>,
        sample: &VertexSample,
        mode: TransportMode,
        survival: f32,
    ) {
        if self.trail.is_some() {
            self.note_event(vertex, sample, mode, survival);
        }
    }

    #[cold]
    #[inline(never)]
    fn note_event(
        &mut self,
        vertex: &SurfaceVertex<'_>,
        sample: &VertexSample,
        mode: TransportMode,
        survival: f32,
    ) {
        let Some(trail) = &self.trail else { return };
        let mut trail = trail.borrow_mut();
        trail.resume(vertex.point.position);
        let ng = vertex.point.ng;
        let (lobe, glossy) = if sample.is_delta {
            (Lobe::Specular, Rgb::BLACK)
        } else {
            let lobes = Lobes::of(vertex);
            match mode {
                TransportMode::Radiance => lobes.share(vertex.wo, sample.wi),
                TransportMode::Importance => lobes.share(sample.wi, vertex.wo),
            }
        };
        let event = Event {
            wi: sample.wi,
            lobe,
            glossy,
            is_transmission: ng.dot(sample.wi) * ng.dot(vertex.wo) < 0.0,
            f_cos: sample.f_cos,
            pdf_w: sample.pdf_w,
            pdf_w_reverse: vertex.pdf_w_reverse(sample, mode),
            survival,
        };
        let at = trail.vertices.len().saturating_sub(1);
        trail.events.push((at, event));
    }

    /// Follows a ray.
    #[inline(always)]
    pub(super) fn note_ray(&self, ray: &Ray) {
        if let Some(trail) = &self.trail {
            trail.borrow_mut().follow(ray);
        }
    }

    /// Notes the surface that it has met.
    #[inline(always)]
    pub(super) fn note_vertex(&self, vertex: &SurfaceVertex<'_>, throughput: Rgb) {
        if self.trail.is_some() {
            self.push_vertex(vertex, throughput);
        }
    }

    #[cold]
    #[inline(never)]
    fn push_vertex(&self, vertex: &SurfaceVertex<'_>, throughput: Rgb) {
        let Some(trail) = &self.trail else { return };
        trail.borrow_mut().vertices.push(PathVertex {
            kind: VertexKind::Surface,
            position: vertex.point.position,
            ng: vertex.point.ng,
            ns: vertex.frame.z,
            triangle: Some(vertex.triangle),
            material: Some(self.material_of(vertex.triangle)),
            lobes: Some(Lobes::of(vertex)),
            source: None,
            throughput,
            n_paths: 1,
            event: None,
        });
    }

    /// Notes a part of what the latest ray has got light from.
    #[inline(always)]
    pub(super) fn note_source(&self, triangle: Option<u32>, value: Rgb) {
        if let Some(trail) = &self.trail
            && !value.is_black()
        {
            let of_triangle = |triangle| Source::Material(self.material_of(triangle));
            let source = triangle.map_or(Source::Environment, of_triangle);
            trail.borrow_mut().sources.push((source, value));
        }
    }

    /// Index of the material of a triangle.
    fn material_of(&self, triangle: u32) -> u32 {
        let geometry = self.scene.geometry();
        let mesh = geometry.facet(triangle).mesh as usize;
        geometry.meshes()[mesh].material
    }

    /// What a light is, which is on a triangle or has a number among the lights.
    fn source(&self, triangle: Option<u32>, light: usize) -> Source {
        if let Some(triangle) = triangle {
            return Source::Material(self.material_of(triangle));
        }
        let punctual = self.scene.lights().punctual(light);
        punctual.map_or(Source::Environment, Source::Punctual)
    }

    /// Notes the point of the lens that light has got to.
    #[inline(always)]
    pub(crate) fn note_lens(&self, position: Vec3) {
        if let Some(trail) = &self.trail {
            let lens = PathVertex::end(VertexKind::Lens, position, Rgb::WHITE);
            trail.borrow_mut().aim = Some(lens);
        }
    }

    /// Notes what is aimed at from a point.
    #[inline(always)]
    pub(super) fn note_aim(&self, from: Vec3, aim: &Aim, near: VertexKind) {
        if let Some(trail) = &self.trail {
            let triangle = aim.surface.map(|point| point.triangle);
            let is_light = near == VertexKind::Light;
            let source = is_light.then(|| self.source(triangle, aim.light as usize));
            let vertex = PathVertex {
                source,
                ..PathVertex::of_aim(from, aim, near)
            };
            trail.borrow_mut().aim = Some(vertex);
        }
    }
}
