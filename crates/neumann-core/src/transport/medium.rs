//! Paths through the bodies of a scene ([`crate::scene::bodies`]): what they start in, what stops
//! them, and what is left of their light.
//!
//! A segment of a path begins in known media, and crosses walls in three ways. Walls that lie
//! within a body that is there instead of theirs are passed as if they were not there, and so are
//! those that let light through by their alpha; an interface between two media stops it, and is a
//! vertex. Only where bodies are near each other or leak need anything but the first hit be looked
//! at.

use glam::Vec3;

use super::tracer::{chance, shadow_ray};
use super::{SurfaceVertex, Tracer, VertexKind};
use crate::accel::Hit;
use crate::bsdf::{Bsdf, Walls};
use crate::endpoint::{Aim, Start, SurfacePoint};
use crate::math::Ray;
use crate::math::ray::{LENS, triangle_of};
use crate::radiometry::Rgb;
use crate::scene::bodies::{Bodies, Crossing, Media, Wall};

impl SurfaceVertex<'_> {
    /// What is on the side of `wi` (world) of a vertex that was reached through `before`.
    #[inline(always)]
    #[must_use]
    pub fn media_towards(&self, wi: Vec3, before: Media) -> Media {
        let ng = self.point.ng;
        if ng.dot(wi) * ng.dot(self.wo) < 0.0 {
            self.across
        } else {
            before
        }
    }
}

/// What a ray has met next, on its way through media.
struct Met {
    hit: Hit,
    /// Probability with which it stops the ray there.
    opacity: f32,
    /// With the normal of the wall; `None` for a surface that is none.
    crossing: Option<(Crossing, Vec3)>,
}

/// What stops a ray.
struct Stop {
    hit: Hit,
    /// What is behind it.
    across: Media,
    /// [`SurfaceVertex::indices`]
    indices: [u8; 2],
}

impl Stop {
    /// A surface that is no wall.
    #[inline(always)]
    fn at(hit: &Hit, media: Media) -> Self {
        Self {
            hit: *hit,
            across: media,
            indices: [0; 2],
        }
    }

    /// An interface between media.
    fn between(hit: &Hit, ng: Vec3, ray: &Ray, crossing: &Crossing) -> Self {
        let [before, behind] = crossing.indices;
        Self {
            hit: *hit,
            across: crossing.across,
            indices: if ng.dot(ray.direction()) < 0.0 {
                [before, behind]
            } else {
                [behind, before]
            },
        }
    }
}

/// Walls that are turned against each other by more than this do not coincide: cosine.
const SAME_PLANE: f32 = 0.999;

/// Walls are in one place if they are no farther from each other than this share of the largest
/// coordinate: what rounding puts
/// between them, with room to spare.
const SAME_PLACE: f32 = 32.0 * f32::EPSILON;

impl<'a> Tracer<'a> {
    /// What a ray that leaves the camera begins in.
    #[inline(always)]
    pub fn media_at_camera(&mut self, ray: &Ray) -> Media {
        if self.scene.bodies().is_empty() {
            return Media::VACUUM;
        }
        self.media_at_eye(ray.origin())
    }

    /// All rays of a pinhole camera begin at one place, which is asked once.
    fn media_at_eye(&mut self, eye: Vec3) -> Media {
        match self.eye {
            Some((place, media)) if place == eye => media,
            _ => {
                let media = self.media_around(eye, Vec3::ZERO, None);
                self.eye = Some((eye, media));
                media
            }
        }
    }

    /// What a ray that leaves a light begins in; light from infinitely far away begins outside of
    /// everything.
    #[inline(always)]
    pub fn media_at_light(&mut self, start: &Start) -> Media {
        if !self.scene.bodies().hold_lights() || start.is_at_infinity() {
            return Media::VACUUM;
        }
        let (side, triangle) = match start.on_triangle {
            Some((triangle, _)) => (start.ng * start.ng.dot(start.direction), Some(triangle)),
            None => (Vec3::ZERO, None),
        };
        self.media_around(start.position, side, triangle)
    }

    #[inline(never)]
    fn media_around(&self, point: Vec3, side: Vec3, triangle: Option<u32>) -> Media {
        let (bvh, geometry) = (self.scene.bvh(), self.scene.geometry());
        let bodies = self.scene.bodies();
        bodies.around(bvh, geometry, point, side, triangle)
    }

    /// The first surface that stops a ray in `media`, with everything needed to scatter there.
    /// Takes media and throughput along.
    #[inline(always)]
    pub fn meet(
        &mut self,
        ray: &Ray,
        media: &mut Media,
        throughput: &mut Rgb,
    ) -> Option<SurfaceVertex<'a>> {
        let found = self.hit(ray);
        self.arrive(ray, found.as_ref(), media, throughput)
    }

    /// The same where it is known already what the ray meets if media are not asked
    /// ([`Self::hit`]).
    #[inline(always)]
    pub(crate) fn arrive(
        &mut self,
        ray: &Ray,
        found: Option<&Hit>,
        media: &mut Media,
        throughput: &mut Rgb,
    ) -> Option<SurfaceVertex<'a>> {
        self.note_ray(ray);
        let stop = if self.scene.bodies().is_empty() {
            Stop::at(found?, *media)
        } else {
            self.stop(ray, found, media, throughput)?
        };
        let mut vertex = self.surface_vertex(ray, &stop.hit);
        vertex.across = stop.across;
        if stop.indices != [0; 2] {
            self.put_between(&mut vertex, stop.indices);
        }
        self.note_vertex(&vertex, *throughput);
        Some(vertex)
    }

    /// What stops a ray, in a scene with bodies.
    #[inline(never)]
    fn stop(
        &mut self,
        ray: &Ray,
        found: Option<&Hit>,
        media: &mut Media,
        throughput: &mut Rgb,
    ) -> Option<Stop> {
        let bodies = self.scene.bodies();
        if bodies.have_leaks() {
            return self.stop_behind_walls(ray, media, throughput);
        }
        let hit = found?;
        let Some((wall, ng)) = self.wall(hit) else {
            *throughput *= bodies.transmittance(*media, hit.t);
            return Some(Stop::at(hit, *media));
        };
        if bodies.has_neighbours(wall.body as usize) {
            // Most often it is what stops the ray, or one of the walls in the same place is.
            let end = hit.t + self.reach(hit, ray);
            let nearer = ray.ending(end.min(ray.t_max()));
            let mut likely = (*media, *throughput);
            if let Some(stop) = self.stop_behind_walls(&nearer, &mut likely.0, &mut likely.1) {
                (*media, *throughput) = likely;
                return Some(stop);
            }
            return self.stop_behind_walls(ray, media, throughput);
        }
        let is_entered = Bodies::is_entered(wall, ng, ray.direction());
        let crossing = bodies.crossing(*media, (wall, is_entered), []);
        if !crossing.is_interface {
            return self.stop_behind_walls(ray, media, throughput);
        }
        *throughput *= bodies.transmittance(*media, hit.t);
        Some(Stop::between(hit, ng, ray, &crossing))
    }

    /// The same, wall by wall.
    fn stop_behind_walls(
        &mut self,
        ray: &Ray,
        media: &mut Media,
        throughput: &mut Rgb,
    ) -> Option<Stop> {
        let bodies = self.scene.bodies();
        let mut hits = self.all_hits(ray);
        let mut from = 0.0;
        while let Some(met) = self.next_met(ray, &mut hits, *media) {
            let Met {
                hit,
                opacity,
                crossing,
            } = met;
            let stops = opacity >= 1.0 || (opacity > 0.0 && chance(ray, hit.triangle) < opacity);
            match crossing {
                None if !stops => {}
                Some((crossing, ng)) => {
                    *throughput *= bodies.transmittance(*media, hit.t - from);
                    if stops && crossing.is_interface {
                        return Some(Stop::between(&hit, ng, ray, &crossing));
                    }
                    from = hit.t;
                    *media = crossing.across;
                }
                None => {
                    *throughput *= bodies.transmittance(*media, hit.t - from);
                    return Some(Stop::at(&hit, *media));
                }
            }
        }
        None
    }

    /// Share of light that gets from a surface, on a side where `media` are, to what was aimed at.
    #[inline(always)]
    pub fn light_to(&mut self, from: &SurfacePoint, aim: &Aim, media: Media) -> Rgb {
        self.note_aim(from.position, aim, VertexKind::Light);
        self.light_to_end(&shadow_ray(from, aim), aim.distance, media)
    }

    /// The same to the lens, which was aimed at: it may look through backs, also through that of
    /// the surface itself.
    #[inline(always)]
    pub fn light_to_lens(&mut self, from: &SurfacePoint, aim: &Aim, media: Media) -> Rgb {
        self.note_aim(from.position, aim, VertexKind::Lens);
        let ray = from.segment_to_lens(from.position + aim.wi * aim.distance);
        self.light_to_end(&ray, aim.distance, media)
    }

    /// Share of light that gets from one point of a surface, on the side where `media` are, to
    /// another one so far away, metres.
    #[inline(always)]
    pub fn light_between(
        &mut self,
        from: &SurfacePoint,
        to: &SurfacePoint,
        distance: f32,
        media: Media,
    ) -> Rgb {
        self.light_to_end(&from.segment_to(to), distance, media)
    }

    /// Share of light that gets along a ray from a surface, on a side where `media` are, to its
    /// end, so many metres away.
    #[inline(always)]
    fn light_to_end(&mut self, ray: &Ray, distance: f32, media: Media) -> Rgb {
        let bodies = self.scene.bodies();
        if bodies.is_empty() || (media.is_vacuum() && !bodies.have_leaks()) {
            return Rgb::splat(self.transmittance(ray));
        }
        self.light_through(ray, distance, media)
    }

    /// Share of light that gets along a ray that begins in `media` to the lens, so many metres
    /// away, where nothing is in between but what may not be there for it.
    pub fn light_before_lens(&mut self, ray: &Ray, distance: f32, media: Media) -> Rgb {
        let bodies = self.scene.bodies();
        if !bodies.have_hidden_walls() && !self.scene.sees_through_backs() {
            return bodies.transmittance(media, distance);
        }
        self.light_through(&ray.ending(distance).aimed_at(LENS), distance, media)
    }

    /// Share of light that gets along a ray that begins in `media` to its end, so many metres away.
    #[inline(always)]
    pub fn light_along(&mut self, ray: &Ray, distance: f32, media: Media) -> Rgb {
        if self.scene.bodies().is_empty() {
            return Rgb::splat(self.transmittance(ray));
        }
        self.light_through(ray, distance, media)
    }

    #[inline(never)]
    fn light_through(&mut self, ray: &Ray, distance: f32, media: Media) -> Rgb {
        if self.leaves_unseen(ray) {
            return Rgb::BLACK;
        }
        let bodies = self.scene.bodies();
        let all = bodies.transmittance(media, distance);
        if !bodies.have_leaks() {
            let share = self.transmittance(ray);
            let has_hidden_walls = |body| bodies.has_neighbours(body);
            if share > 0.0 || !media.innermost().is_some_and(has_hidden_walls) {
                return all * share;
            }
        }
        self.light_through_walls(ray, distance, media)
    }

    /// The same, wall by wall.
    fn light_through_walls(&mut self, ray: &Ray, distance: f32, mut media: Media) -> Rgb {
        let bodies = self.scene.bodies();
        let mut hits = self.all_hits(ray);
        let length = ray.direction().length();
        let mut light = Rgb::WHITE;
        let mut from = 0.0;
        while let Some(met) = self.next_met(ray, &mut hits, media) {
            // Walls in the place that the ray ends at are part of what it was aimed at.
            let has_target = triangle_of(ray.aims_at()).is_some();
            if has_target
                && met.crossing.is_some()
                && met.hit.t + self.reach(&met.hit, ray) >= ray.t_max()
            {
                continue;
            }
            if met
                .crossing
                .is_none_or(|(crossing, _)| crossing.is_interface)
            {
                light *= 1.0 - met.opacity;
                if light.is_black() {
                    return Rgb::BLACK;
                }
            }
            if let Some((crossing, _)) = met.crossing {
                let to = met.hit.t * length;
                light *= bodies.transmittance(media, to - from);
                from = to;
                media = crossing.across;
            }
        }
        light * bodies.transmittance(media, (distance - from).max(0.0))
    }

    /// Everything on the way of a ray, the last first.
    fn all_hits(&mut self, ray: &Ray) -> Vec<Hit> {
        let mut hits = self.crossings(ray);
        hits.reverse();
        hits
    }

    /// Takes out what a ray meets next in `media`: all walls in one place together.
    fn next_met(&self, ray: &Ray, hits: &mut Vec<Hit>, media: Media) -> Option<Met> {
        let bodies = self.scene.bodies();
        let direction = ray.direction();
        loop {
            let first = hits.pop()?;
            let Some((wall, ng)) = self.wall(&first) else {
                return Some(Met {
                    hit: first,
                    opacity: self.opacity(ray, &first),
                    crossing: None,
                });
            };
            let is_entered = Bodies::is_entered(wall, ng, direction);
            let reach = self.reach(&first, ray);
            if first.t <= reach && Bodies::is_crossed(media, wall, is_entered) {
                continue;
            }
            // The innermost of the walls there decides, the others go with it.
            let mut deciding = (first, wall, is_entered, ng);
            let mut others: Vec<(Wall, bool)> = Vec::new();
            let mut place = hits.len();
            while place > 0 && hits[place - 1].t <= first.t + reach {
                place -= 1;
                let hit = hits[place];
                let Some((wall, other_ng)) = self.wall(&hit) else {
                    continue;
                };
                if other_ng.dot(ng).abs() < SAME_PLANE {
                    continue;
                }
                hits.remove(place);
                let is_entered = Bodies::is_entered(wall, other_ng, direction);
                if wall.body < deciding.1.body {
                    others.push((deciding.1, deciding.2));
                    deciding = (hit, wall, is_entered, other_ng);
                } else if wall.body > deciding.1.body {
                    others.push((wall, is_entered));
                }
            }
            let (hit, wall, is_entered, ng) = deciding;
            return Some(Met {
                hit,
                opacity: self.opacity(ray, &hit),
                crossing: Some((bodies.crossing(media, (wall, is_entered), others), ng)),
            });
        }
    }

    /// The wall that was hit, if it is one, with its normal.
    #[inline]
    fn wall(&self, hit: &Hit) -> Option<(Wall, Vec3)> {
        let facet = self.scene.geometry().facet(hit.triangle);
        let wall = self.scene.bodies().wall(facet.mesh)?;
        Some((wall, facet.ng))
    }

    /// How much farther along a ray other surfaces may be hit that are in the same place, by
    /// rounding; in lengths of its direction.
    fn reach(&self, hit: &Hit, ray: &Ray) -> f32 {
        let facet = self.scene.geometry().facet(hit.triangle);
        let direction = ray.direction();
        let length = direction.length();
        let largest = ray.origin().abs().max(facet.at(hit.barycentrics).abs());
        let rounding = SAME_PLACE * largest.max_element();
        let cos = (facet.ng.dot(direction) / length).abs();
        rounding / (cos.max(0.01) * length)
    }

    /// Puts a surface between media of two indices of refraction, given by their numbers: in front
    /// of it and behind.
    pub(super) fn put_between(&self, vertex: &mut SurfaceVertex<'_>, indices: [u8; 2]) {
        vertex.indices = indices;
        let [front, behind] = indices.map(|number| self.scene.bodies().index(number));
        match &mut vertex.bsdf {
            Bsdf::Dielectric(glass) if glass.walls == Walls::Solid => glass.ior = behind / front,
            Bsdf::Mix(mix) if mix.glass.walls == Walls::Solid => mix.glass.ior = behind / front,
            _ => {}
        }
    }
}
