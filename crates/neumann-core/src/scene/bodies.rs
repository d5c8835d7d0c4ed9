//! Bodies: what has an inside that light passes through, and which of them a point is in.
//!
//! A body is bounded by walls: surfaces with a volume that transmit light. **Identity**: all walls
//! of one object (what a node of the file has placed) that are filled with the same medium (index
//! of refraction and absorption) bound one body, of however many meshes it consists. Walls of an
//! object that do not close are joined with all others of their medium that do not; what is not
//! closed then, is *open*: it has an inside only for light that has passed it, as a wall by itself,
//! and nothing is known of where that inside ends.
//!
//! **Nesting**: where bodies overlap, the one that encloses the smaller volume is there, the others
//! are not. A body within another is the smaller of both, so this orders bodies by nesting; it
//! depends on the bodies alone, not on the way that light takes through them; of two alike, the
//! first of the file counts as the smaller. (Schmidt and Budge 2002, "Simple nested dielectrics in
//! ray traced images", ask for a priority in its place.) A wall with the same medium on both sides
//! is no interface: light passes it as if it were not there. Walls that coincide are one interface,
//! between what is in front of all and what is behind all.
//!
//! **Cavities**: a closed surface turned inside out, within another body, bounds that body from
//! inside (a bubble). By itself, it is a body whose triangles are wound the wrong way round.

mod parts;

use std::collections::HashMap;

use glam::Vec3;

use self::parts::{Part, fill_cavities, join_open, parts};
use super::geometry::{Geometry, PlacedMesh};
use crate::accel::{Bvh, Hit};
use crate::material::Material;
use crate::math::Ray;
use crate::radiometry::Rgb;

/// The bodies that a segment of a path runs through, innermost first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Media([u16; N_NESTED]);

/// Bodies that may be around a point; of more, the outermost are not counted.
const N_NESTED: usize = 8;
/// In the place of a body.
const NONE: u16 = u16::MAX;
/// Bodies that have an identity of their own, at most.
const MAX_BODIES: usize = 60_000;

impl Media {
    /// Outside of all bodies.
    pub const VACUUM: Self = Self([NONE; N_NESTED]);

    /// True outside of all bodies.
    #[inline(always)]
    #[must_use]
    pub fn is_vacuum(self) -> bool {
        self.0[0] == NONE
    }

    /// Number of the body that fills the space there; bodies are numbered from the innermost on.
    #[inline]
    #[must_use]
    pub fn innermost(self) -> Option<usize> {
        (self.0[0] != NONE).then_some(self.0[0] as usize)
    }

    #[inline]
    fn contains(self, body: u16) -> bool {
        self.0.contains(&body)
    }

    fn with(self, body: u16) -> Self {
        let mut bodies = self;
        let mut next = body;
        for slot in &mut bodies.0 {
            if *slot == body {
                return self;
            }
            if *slot > next {
                std::mem::swap(slot, &mut next);
            }
        }
        bodies
    }

    fn without(self, gone: impl Fn(u16) -> bool) -> Self {
        let mut left = Self::VACUUM;
        let bodies = self.0.into_iter().filter(|body| !gone(*body));
        for (slot, body) in left.0.iter_mut().zip(bodies) {
            *slot = body;
        }
        left
    }
}

impl Default for Media {
    fn default() -> Self {
        Self::VACUUM
    }
}

/// A wall of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wall {
    pub(crate) body: u16,
    /// True where the inside is on the front side of the triangles.
    is_inside_out: bool,
}

/// What light meets where it crosses walls at one place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// What is behind.
    pub(crate) across: Media,
    /// Numbers of the indices of refraction before and behind.
    pub(crate) indices: [u8; 2],
    /// False where the same medium is on both sides.
    pub(crate) is_interface: bool,
}

/// A body.
#[derive(Clone, Copy, Debug)]
struct Body {
    /// Absorption coefficient, 1/m.
    absorption: Rgb,
    /// Number of its medium.
    medium: u32,
    /// Number of its index of refraction.
    index: u8,
    /// True if other bodies may overlap or touch it.
    has_neighbours: bool,
    min: Vec3,
    max: Vec3,
}

/// The bodies of a scene.
#[derive(Clone, Debug, Default)]
pub struct Bodies {
    /// From the innermost on; open ones last.
    bodies: Vec<Body>,
    n_closed: usize,
    /// `walls[mesh]`
    walls: Vec<Option<Wall>>,
    /// Indices of refraction, that of the vacuum first.
    indices: Vec<f32>,
    /// True if light may get through a wall as if it were not there: some have alpha.
    has_leaks: bool,
    has_neighbours: bool,
    holds_lights: bool,
    /// Box around all closed ones.
    min: Vec3,
    max: Vec3,
}

/// Index of refraction and absorption, as bits.
type MediumKey = [u32; 4];

impl Bodies {
    /// Finds the bodies among the meshes of a scene.
    pub(super) fn new(geometry: &Geometry, bvh: &Bvh, materials: &[Material]) -> Self {
        let mut parts = parts(geometry, materials);
        if parts.is_empty() {
            return Self::default();
        }
        join_open(&mut parts);
        let mut walls: Vec<Option<Wall>> = vec![None; geometry.meshes().len()];
        for (number, part) in parts.iter().enumerate() {
            for mesh in &part.meshes {
                walls[*mesh] = Some(Wall {
                    body: number as u16,
                    is_inside_out: part.is_closed && part.shape.volume < 0.0,
                });
            }
        }
        fill_cavities(geometry, bvh, &mut parts, &mut walls);

        // Numbers by nesting.
        parts.retain(|part| !part.meshes.is_empty());
        parts.sort_by(|a, b| {
            // To a ten-thousandth, or rounding would tell which of two equal bodies is smaller.
            let volume = |part: &Part| (part.shape.volume.abs().log2() * 8192.0).round();
            let by_volume = volume(a).total_cmp(&volume(b));
            let by_kind = b.is_closed.cmp(&a.is_closed);
            by_kind.then(by_volume).then(a.meshes[0].cmp(&b.meshes[0]))
        });
        let mut indices = Indices::default();
        let mut media: HashMap<MediumKey, u32> = HashMap::new();
        let mut bodies = Vec::with_capacity(parts.len());
        for (number, part) in parts.iter().enumerate() {
            for mesh in &part.meshes {
                if let Some(wall) = &mut walls[*mesh] {
                    wall.body = number as u16;
                }
            }
            let next = media.len() as u32;
            let key = part.key.map(f32::from_bits);
            bodies.push(Body {
                absorption: Rgb::new(key[1], key[2], key[3]),
                medium: *media.entry(part.key).or_insert(next),
                index: indices.number(key[0]),
                has_neighbours: false,
                min: part.shape.min,
                max: part.shape.max,
            });
        }
        let n_closed = parts.iter().filter(|part| part.is_closed).count();
        let closed = &mut bodies[..n_closed];
        find_neighbours(closed);
        let (min, max) = closed
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), body| {
                (min.min(body.min), max.max(body.max))
            });
        let is_leak = |(mesh, wall): (&PlacedMesh, &Option<Wall>)| {
            wall.is_some() && materials[mesh.material as usize].has_alpha()
        };
        Self {
            has_leaks: geometry.meshes().iter().zip(&walls).any(is_leak),
            has_neighbours: closed.iter().any(|body| body.has_neighbours),
            holds_lights: false,
            n_closed,
            bodies,
            walls,
            indices: indices.values,
            min,
            max,
        }
    }

    /// The same, told the boxes that lights are in.
    pub(super) fn with_lights(mut self, boxes: impl IntoIterator<Item = [Vec3; 2]>) -> Self {
        let closed = &self.bodies[..self.n_closed];
        let is_near = |[min, max]: [Vec3; 2]| {
            overlap([min, max], [self.min, self.max])
                && closed
                    .iter()
                    .any(|body| overlap([min, max], [body.min, body.max]))
        };
        self.holds_lights = boxes.into_iter().any(is_near);
        self
    }

    /// True in a scene without any.
    #[inline(always)]
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// True if lights may be within bodies.
    #[inline]
    #[must_use]
    pub fn hold_lights(&self) -> bool {
        self.holds_lights || self.has_leaks
    }

    /// True if light may get through walls as if they were not there, since they have alpha.
    #[inline(always)]
    pub(crate) fn have_leaks(&self) -> bool {
        self.has_leaks
    }

    /// True if there may be walls that are passed as if they were not there.
    #[inline]
    pub(crate) fn have_hidden_walls(&self) -> bool {
        self.has_leaks || self.has_neighbours
    }

    /// The wall that the triangles of a mesh are, if they are one.
    #[inline]
    pub(crate) fn wall(&self, mesh: u32) -> Option<Wall> {
        self.walls[mesh as usize]
    }

    /// True if other walls may be within the body or where its own are.
    #[inline]
    pub(crate) fn has_neighbours(&self, body: usize) -> bool {
        self.bodies[body].has_neighbours
    }

    /// Share of light that is left after `distance` metres (Beer and Lambert). Whatever goes to
    /// infinity has left all bodies: only an open one lets it.
    #[inline]
    #[must_use]
    pub fn transmittance(&self, media: Media, distance: f32) -> Rgb {
        match media.innermost() {
            Some(body) if distance.is_finite() => {
                let absorption = self.bodies[body].absorption;
                absorption.map(|a| if a > 0.0 { (-a * distance).exp() } else { 1.0 })
            }
            _ => Rgb::WHITE,
        }
    }

    /// An index of refraction, by its number.
    #[inline]
    pub(crate) fn index(&self, number: u8) -> f32 {
        self.indices.get(number as usize).copied().unwrap_or(1.0)
    }

    /// True if light that goes along a direction comes into the body through its wall.
    #[inline]
    pub(crate) fn is_entered(wall: Wall, ng: Vec3, direction: Vec3) -> bool {
        (ng.dot(direction) < 0.0) != wall.is_inside_out
    }

    /// The media behind a wall; what is open ends at every wall.
    #[inline]
    pub(crate) fn across(&self, media: Media, wall: Wall, is_entered: bool) -> Media {
        let is_open = |body: u16| body as usize >= self.n_closed && body != NONE;
        if is_entered {
            media.without(is_open).with(wall.body)
        } else {
            media.without(|body| body == wall.body || is_open(body))
        }
    }

    /// What light in `media` meets that crosses walls at one place: `wall`, the innermost of them,
    /// and `others`, each with whether it is entered. A body that was left without having been
    /// entered counts as if it had been.
    pub(crate) fn crossing(
        &self,
        media: Media,
        wall: (Wall, bool),
        others: impl IntoIterator<Item = (Wall, bool)>,
    ) -> Crossing {
        let (wall, is_entered) = wall;
        let before = if is_entered {
            media.without(|body| body == wall.body)
        } else {
            media.with(wall.body)
        };
        let across = others.into_iter().fold(
            self.across(before, wall, is_entered),
            |media, (wall, is_entered)| self.across(media, wall, is_entered),
        );
        let is_open = wall.body as usize >= self.n_closed;
        let own = Some(wall.body as usize);
        // Nothing hides an open body's wall, and other walls know nothing of what is open.
        let beside = |media: Media| media.innermost().filter(|body| *body < self.n_closed);
        let [front, behind] = match (is_open, is_entered) {
            (true, true) => [beside(before), own],
            (true, false) => [own, beside(across)],
            (false, _) => [beside(before), beside(across)],
        };
        let medium = |body: Option<usize>| body.map(|body| self.bodies[body].medium);
        let index = |body: Option<usize>| body.map_or(0, |body| self.bodies[body].index);
        Crossing {
            across,
            indices: [index(front), index(behind)],
            is_interface: is_open || medium(front) != medium(behind),
        }
    }

    /// True where a wall is met again that has been crossed: what is said of it is so already.
    pub(crate) fn is_crossed(media: Media, wall: Wall, is_entered: bool) -> bool {
        media.contains(wall.body) == is_entered
    }

    /// The bodies around a point. `side` is the direction away from the surface that it lies on, if
    /// it does on `triangle`, else zero.
    pub(crate) fn around(
        &self,
        bvh: &Bvh,
        geometry: &Geometry,
        point: Vec3,
        side: Vec3,
        triangle: Option<u32>,
    ) -> Media {
        let is_in = |min: Vec3, max: Vec3| point.cmpge(min).all() && point.cmple(max).all();
        if !is_in(self.min, self.max) {
            return Media::VACUUM;
        }
        let closed = self.bodies[..self.n_closed].iter().enumerate();
        let near: Vec<u16> = closed
            .filter(|(_, body)| is_in(body.min, body.max))
            .map(|(number, _)| number as u16)
            .collect();
        if near.is_empty() {
            return Media::VACUUM;
        }
        let end = self.min.distance(self.max);
        let seeker = Seeker {
            bvh,
            geometry,
            walls: &self.walls,
            near: &near,
            end,
        };
        let bodies = seeker.around(point, side, triangle);
        bodies.into_iter().fold(Media::VACUUM, Media::with)
    }
}

/// Finds out which bodies a point is in.
struct Seeker<'a> {
    bvh: &'a Bvh,
    geometry: &'a Geometry,
    walls: &'a [Option<Wall>],
    /// The bodies in question, in ascending order.
    near: &'a [u16],
    /// No wall of theirs is farther away, metres.
    end: f32,
}

/// Directions that no scene is likely to have edges and corners in.
const DIRECTIONS: [Vec3; 3] = [
    Vec3::new(0.6364, 0.4583, 0.6205),
    Vec3::new(-0.5417, -0.6871, -0.4843),
    Vec3::new(0.3191, -0.7283, 0.6064),
];

impl Seeker<'_> {
    /// Those that are around the point by two of three rays.
    fn around(&self, point: Vec3, side: Vec3, triangle: Option<u32>) -> Vec<u16> {
        let mut votes = vec![0u8; self.near.len()];
        for (n_cast, direction) in DIRECTIONS.into_iter().enumerate() {
            let direction = if side.dot(direction) < 0.0 {
                -direction
            } else {
                direction
            };
            let ray = Ray::with_end(point, direction, 1.001 * self.end / direction.length());
            for (vote, n_left) in votes.iter_mut().zip(self.n_left(&ray, triangle)) {
                *vote += u8::from(n_left > 0);
            }
            // Rays that agree need no third one; nearly all points are outside, and one that says
            // so is believed.
            if votes
                .iter()
                .all(|vote| *vote == 0 || (n_cast == 1 && *vote == 2))
            {
                break;
            }
        }
        let inside = self.near.iter().zip(votes).filter(|(_, vote)| *vote >= 2);
        inside.map(|(body, _)| *body).collect()
    }

    /// How much more often each body is left than entered along a ray: once by a ray from its
    /// inside.
    fn n_left(&self, ray: &Ray, triangle: Option<u32>) -> Vec<i32> {
        let mut n_left = vec![0; self.near.len()];
        self.bvh.each_hit(ray, &mut |hit: Hit| {
            let facet = self.geometry.facet(hit.triangle);
            let Some(wall) = self.walls[facet.mesh as usize] else {
                return;
            };
            if let Ok(place) = self.near.binary_search(&wall.body)
                && triangle != Some(hit.triangle)
            {
                let is_entered = Bodies::is_entered(wall, facet.ng, ray.direction());
                n_left[place] += if is_entered { -1 } else { 1 };
            }
        });
        n_left
    }
}

/// Comparisons of bodies with each other, for each of them on average: where more were needed, all
/// are taken to be neighbours, and cavities for bodies by themselves.
const MOST_COMPARISONS: usize = 200;

/// Tells which closed bodies may overlap or touch others.
fn find_neighbours(bodies: &mut [Body]) {
    let mut order: Vec<usize> = (0..bodies.len()).collect();
    order.sort_by(|a, b| bodies[*a].min.x.total_cmp(&bodies[*b].min.x));
    let mut n_left = MOST_COMPARISONS * bodies.len();
    for (i, &a) in order.iter().enumerate() {
        for &b in &order[i + 1..] {
            let [first, second] = [&bodies[a], &bodies[b]];
            if second.min.x > first.max.x + margin(first) {
                break;
            }
            n_left = n_left.saturating_sub(1);
            if n_left == 0 {
                for body in bodies {
                    body.has_neighbours = true;
                }
                return;
            }
            let padding = Vec3::splat(margin(first) + margin(second));
            let near = [first.min - padding, first.max + padding];
            if overlap(near, [second.min, second.max]) {
                bodies[a].has_neighbours = true;
                bodies[b].has_neighbours = true;
            }
        }
    }
}

/// Walls that are closer to each other than this may be at the same place, metres.
fn margin(body: &Body) -> f32 {
    1e-4 * body.min.abs().max(body.max.abs()).max_element()
}

fn overlap(a: [Vec3; 2], b: [Vec3; 2]) -> bool {
    a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all()
}

/// Indices of refraction, each with a number.
struct Indices {
    values: Vec<f32>,
}

impl Default for Indices {
    fn default() -> Self {
        Self { values: vec![1.0] }
    }
}

impl Indices {
    /// The number of an index; of the nearest one, where there are too many.
    fn number(&mut self, index: f32) -> u8 {
        if let Some(number) = self.values.iter().position(|value| *value == index) {
            return number as u8;
        }
        if self.values.len() <= u8::MAX as usize {
            self.values.push(index);
            return (self.values.len() - 1) as u8;
        }
        let distance = |number: &usize| (self.values[*number] - index).abs();
        let nearest = (0..self.values.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.unwrap_or(0) as u8
    }
}
