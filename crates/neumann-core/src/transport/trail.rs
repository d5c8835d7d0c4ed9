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

use super::{SurfaceVertex, Tracer, VertexSample};
use crate::bsdf::TransportMode;
use crate::endpoint::{Aim, Start};
use crate::math::Ray;
use crate::radiometry::Rgb;
use crate::scene::bodies::Media;

/// What a vertex of a path is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexKind {
    /// A point of the lens, or of an orthographic film.
    Lens,
    /// A point of a light that a path starts at or that is aimed at.
    Light,
    /// Light from infinitely far away: the position is the direction to it.
    FarLight,
    /// A surface that the path has met.
    Surface,
}

/// The part of a BSDF that scatters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lobe {
    /// Alike in all directions.
    Diffuse,
    /// Around a direction.
    Glossy,
    /// In a single direction.
    Specular,
}

impl Lobe {
    fn of(vertex: &SurfaceVertex<'_>, is_delta: bool) -> Self {
        if is_delta || !vertex.bsdf.has_density() {
            Self::Specular
        } else if vertex.bsdf.roughness() >= 1.0 {
            Self::Diffuse
        } else {
            Self::Glossy
        }
    }
}

/// How a path leaves a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// Direction to the next vertex, unit.
    pub wi: Vec3,
    /// What scatters.
    pub lobe: Lobe,
    /// True if the path goes on at the other side of the surface.
    pub is_transmission: bool,
    /// `f · cos`, 1/sr; for a specular lobe, its reflectance or transmittance.
    pub f_cos: Rgb,
    /// Density of the direction, 1/sr; for a specular lobe, its probability.
    pub pdf_w: f32,
    /// The same for a path that is walked the other way.
    pub pdf_w_reverse: f32,
    /// Probability with which Russian roulette lets the path go on.
    pub survival: f32,
}

/// A vertex of a path, from the end that it was walked from.
#[derive(Clone, Copy, Debug)]
pub struct PathVertex {
    /// What it is.
    pub kind: VertexKind,
    /// World space, metres.
    pub position: Vec3,
    /// Geometric normal, unit; zero where there is none.
    pub ng: Vec3,
    /// Shading normal, unit; zero where there is none.
    pub ns: Vec3,
    /// The triangle that it is on.
    pub triangle: Option<u32>,
    /// Index of the material there.
    pub material: Option<u32>,
    /// What scatters here where the path is joined to another one.
    pub lobe: Option<Lobe>,
    /// Throughput of the path up to here, scattering not included.
    pub throughput: Rgb,
    /// The paths that go on from here in place of one.
    pub n_paths: u32,
    /// How the path goes on, unless it ends here.
    pub event: Option<Event>,
}

impl PathVertex {
    /// Towards this vertex from another one, of any length.
    #[must_use]
    pub fn direction_from(&self, other: &Self) -> Vec3 {
        match self.kind {
            VertexKind::FarLight => self.position,
            _ => self.position - other.position,
        }
    }

    fn end(kind: VertexKind, position: Vec3, throughput: Rgb) -> Self {
        Self {
            kind,
            position,
            ng: Vec3::ZERO,
            ns: Vec3::ZERO,
            triangle: None,
            material: None,
            lobe: None,
            throughput,
            n_paths: 1,
            event: None,
        }
    }

    fn of_aim(from: Vec3, aim: &Aim, near: VertexKind) -> Self {
        match &aim.surface {
            Some(point) => Self {
                ng: point.ng,
                triangle: Some(point.triangle),
                ..Self::end(near, point.position, Rgb::WHITE)
            },
            None if aim.distance.is_finite() => {
                Self::end(near, from + aim.wi * aim.distance, Rgb::WHITE)
            }
            None => Self::end(VertexKind::FarLight, aim.wi, Rgb::WHITE),
        }
    }
}

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
    wanted: Arc<HashSet<u32>>,
    kept: HashMap<u32, Vec<PathVertex>>,
}

/// A trail that a tracer and a sink have in common.
pub(crate) type SharedTrail = Rc<RefCell<Trail>>;

impl Trail {
    /// Keeps these light paths whole.
    pub(crate) fn keeping(wanted: Arc<HashSet<u32>>) -> Self {
        Self {
            wanted,
            ..Self::default()
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
        (self.vertices(), self.aim)
    }

    /// The vertices of a path that has left the scene.
    pub(crate) fn vertices_to_sky(&self) -> Vec<PathVertex> {
        let sky = PathVertex::end(VertexKind::FarLight, self.heading, Rgb::WHITE);
        let mut vertices = self.vertices.clone();
        vertices.push(sky);
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

    /// The light paths that were kept.
    pub(crate) fn into_kept(mut self) -> HashMap<u32, Vec<PathVertex>> {
        self.keep();
        self.kept
    }

    /// Ends the path.
    fn keep(&mut self) {
        if let Some(path) = self.light_path.take()
            && self.wanted.contains(&path)
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
        let event = Event {
            wi: sample.wi,
            lobe: Lobe::of(vertex, sample.is_delta),
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
        if let Some(trail) = &self.trail {
            let geometry = self.scene.geometry();
            let mesh = geometry.facet(vertex.triangle).mesh as usize;
            trail.borrow_mut().vertices.push(PathVertex {
                kind: VertexKind::Surface,
                position: vertex.point.position,
                ng: vertex.point.ng,
                ns: vertex.frame.z,
                triangle: Some(vertex.triangle),
                material: Some(geometry.meshes()[mesh].material),
                lobe: Some(Lobe::of(vertex, false)),
                throughput,
                n_paths: 1,
                event: None,
            });
        }
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
            trail.borrow_mut().aim = Some(PathVertex::of_aim(from, aim, near));
        }
    }
}
